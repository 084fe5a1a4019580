// SPDX-License-Identifier: MIT
// All arithmetic is in double, each operation a plain IEEE one, so that an edit gives the same bits anywhere.
// Lengths are in cells from sample (0, 0, 0).
#include "terrain/edit/field/edit_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/edit/brush.h"

namespace karst::core {
namespace {

// A kept block: whether it is exchanged already, while blocks are, then all of its samples.
constexpr std::size_t kHead = sizeof(std::uint64_t);
constexpr double kFarthest = 1e6;  // cells

Edit in_cells(const Edit& edit, const FieldInfo& info) {
  const double cells = 1 << (kMostCellLog2 - info.cell_log2);  // a voxel
  const glm::dvec3 corner(info.corner);
  Edit out = edit;
  out.place = (edit.place - corner) * cells;
  out.to = (edit.to - corner) * cells;
  out.half = edit.half * cells;
  out.radius = edit.radius * cells;
  if (edit.tool == EditTool::level) out.up = {0, 1, 0};
  return out;
}

// Written so that NaN fails.
bool is_near(const glm::dvec3& v, double most) {
  return std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most;
}

// An edit in cells.
Status check(const Edit& edit) {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  if (!edits_fields(edit.tool))
    return refuse("a field is cut with clear, fill, smooth, flatten and level", "tool");
  if (edit.shape != BrushShape::box && edit.shape != BrushShape::sphere && edit.shape != BrushShape::capsule)
    return refuse("a field's brush is a box, a sphere or a capsule", "shape");
  if (!is_near(edit.place, kFarthest)) return refuse("not finite, or too far away", "place");
  if (edit.shape == BrushShape::box) {
    if (!is_near(edit.half, kMostFieldBrush) || !(edit.half.x > 0 && edit.half.y > 0 && edit.half.z > 0))
      return refuse("not more than 0 and at most 128 cells of the field", "half_m");
  } else if (!(edit.radius > 0 && edit.radius <= kMostFieldBrush)) {
    return refuse("not more than 0 and at most 128 cells of the field", "radius_m");
  }
  if (edit.shape == BrushShape::capsule && !is_near(edit.to - edit.place, 2 * kMostFieldBrush))
    return refuse("more than 256 cells of the field from place", "to");
  if (!(edit.amount >= 0 && edit.amount <= 1)) return refuse("not within 0..1", "amount");
  if (!(edit.hardness >= 0 && edit.hardness <= 1)) return refuse("not within 0..1", "hardness");
  if (edit.tool == EditTool::flatten) {
    const double length = glm::length(edit.up);
    if (!(length >= 1e-9 && length <= 1e9)) return refuse("without a direction", "up");
  }
  return {};
}

// Samples that an edit in cells may change.
void find_reach(const Edit& edit, double reach, glm::ivec3 samples, glm::ivec3& first, glm::ivec3& last) {
  const BrushBox box = brush_box(edit);
  const double more = edits_voxels(edit.tool) ? reach + 1 : 1;
  const glm::dvec3 most(samples);
  first = glm::ivec3(glm::clamp(glm::ceil(box.low - more), glm::dvec3(0), most));
  last = glm::ivec3(glm::clamp(glm::floor(box.high + more), glm::dvec3(-1), most - 1.0));
}

double outside_of(const Edit& edit, const glm::dvec3& place) {
  const glm::dvec3 from = place - edit.place;
  if (edit.shape == BrushShape::box) {
    const glm::dvec3 beyond = glm::abs(from) - edit.half;
    const double inside = std::min(std::max({beyond.x, beyond.y, beyond.z}), 0.0);
    return glm::length(glm::max(beyond, glm::dvec3(0))) + inside;
  }
  if (edit.shape == BrushShape::sphere) return glm::length(from) - edit.radius;
  const glm::dvec3 along = edit.to - edit.place;
  const double square = glm::dot(along, along);
  const double t = square > 0 ? std::clamp(glm::dot(from, along) / square, 0.0, 1.0) : 0.0;
  return glm::length(from - along * t) - edit.radius;
}

template <class Sample>
class Sculpt {
 public:
  using Field = ScalarField<Sample>;
  using Samples = std::array<Sample, Field::kBlockSamples>;

  Sculpt(const Edit& edit, double reach, Field& field)
      : edit_(edit), field_(field), scale_(-double{Field::kSolid} / reach) {
    find_reach(edit, reach, field.samples(), first_, last_);
    const double length = glm::length(edit.up);
    if (length > 0) up_ = edit.up / length;
  }

  // Blocks that change and take samples only then.
  std::uint32_t opened() const {
    std::uint32_t count = 0;
    each_block([&](glm::ivec3 block) {
      if (!field_.block(block).empty()) return;
      count += edit_.tool == EditTool::smooth ? !is_alone(block) : changes(block);
    });
    return count;
  }

  // Precondition: there is room for opened().
  void run(const EditedField& edited, UndoLog* log, FieldChange& change) {
    if (edit_.tool == EditTool::smooth) {
      smooth(edited, log, change);
      return;
    }
    each_block([&](glm::ivec3 block) {
      if (!changes(block)) return;
      const std::span<Sample> samples = open(block, edited, log, change);
      each_sample(block, [&](glm::ivec3 at, std::size_t n) {
        samples[n] = sculpted(at, samples[n]);
        return true;
      });
      field_.close(block);
    });
  }

 private:
  std::size_t index(glm::ivec3 block) const {
    const glm::ivec3 n = field_.blocks();
    return static_cast<std::size_t>(block.x + n.x * (block.y + n.y * block.z));
  }
  template <class Visit>
  void each_block(const Visit& visit) const {
    if (!glm::all(glm::lessThanEqual(first_, last_))) return;
    const glm::ivec3 low = first_ >> Field::kBlockLog2, high = last_ >> Field::kBlockLog2;
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) visit(glm::ivec3(x, y, z));
      }
    }
  }
  // Calls visit(sample, its number in the block), which returns whether to go on.
  template <class Visit>
  void each_sample(glm::ivec3 block, const Visit& visit) const {
    const glm::ivec3 corner = block * Field::kBlock;
    const glm::ivec3 low = glm::max(first_, corner), high = glm::min(last_, corner + Field::kBlock - 1);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          const glm::ivec3 at(x, y, z);
          if (!visit(at, Field::offset(at - corner))) return;
        }
      }
    }
  }

  // Samples of a block that is about to change, which is kept as it is.
  std::span<Sample> open(glm::ivec3 block, const EditedField& edited, UndoLog* log, FieldChange& change) {
    const std::span<Sample> samples = field_.open(block);
    KARST_ASSERT(!samples.empty());
    const glm::ivec3 corner = block * Field::kBlock;
    const glm::ivec3 first = glm::max(first_, corner), last = glm::min(last_, corner + Field::kBlock - 1);
    change.first = change.changed ? glm::min(change.first, first) : first;
    change.last = change.changed ? glm::max(change.last, last) : last;
    if (log != nullptr) keep(index(block), std::as_bytes(samples), edited.kept_in, *log);
    change.changed = true;
    return samples;
  }
  static void keep(std::size_t block, std::span<const std::byte> samples, std::span<std::uint32_t> kept_in,
                   UndoLog& log) {
    const auto part = [&] { return static_cast<std::uint32_t>(log.part_number()); };
    if (log.open_part() != CellKind::field_block) {
      log.begin_part();
    } else if (kept_in[block] == part()) {
      return;
    }
    const std::span<std::byte> room = log.add(CellKind::field_block, block, kHead + samples.size());
    if (room.empty()) return;
    std::memset(room.data(), 0, kHead);
    std::memcpy(room.data() + kHead, samples.data(), samples.size());
    kept_in[block] = part();
  }

  bool changes(glm::ivec3 block) const {
    const std::span<const Sample> samples = field_.block(block);
    const Sample all = field_.filling(block);
    bool found = false;
    each_sample(block, [&](glm::ivec3 at, std::size_t n) {
      const Sample before = samples.empty() ? all : samples[n];
      found = sculpted(at, before) != before;
      return !found;
    });
    return found;
  }
  // Whether all around a block that is all alike is so, too: smoothing changes nothing of it. Samples that
  // change first lie a sample from it, and what they change by one more.
  bool is_alone(glm::ivec3 block) const {
    const glm::ivec3 low = glm::max(block - 1, glm::ivec3(0)),
                     high = glm::min(block + 1, field_.blocks() - 1);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          if (!field_.block({x, y, z}).empty() || field_.filling({x, y, z}) != field_.filling(block))
            return false;
        }
      }
    }
    return true;
  }

  Sample stored(double cells) const {
    const double value = std::floor(cells * scale_);
    return static_cast<Sample>(std::clamp(value, double{Field::kSolid}, double{Field::kAir}));
  }
  Sample sculpted(glm::ivec3 at, Sample before) const {
    const glm::dvec3 place(at);
    if (edit_.tool == EditTool::fill) return std::min(before, stored(outside_of(edit_, place)));
    if (edit_.tool == EditTool::clear) return std::max(before, stored(-outside_of(edit_, place)));
    const double share = edit_.amount * brush_weight(edit_, place);
    if (share == 0) return before;
    const double was = static_cast<double>(before) + 0.5;
    if (edit_.tool == EditTool::smooth) {
      const int sum = field_.at(at - glm::ivec3(1, 0, 0)) + field_.at(at + glm::ivec3(1, 0, 0)) +
                      field_.at(at - glm::ivec3(0, 1, 0)) + field_.at(at + glm::ivec3(0, 1, 0)) +
                      field_.at(at - glm::ivec3(0, 0, 1)) + field_.at(at + glm::ivec3(0, 0, 1));
      const double mean = static_cast<double>(sum) / 6 + 0.5;
      return stored((was + share * (mean - was)) / scale_);
    }
    return stored(was / scale_ + share * (glm::dot(place - edit_.place, up_) - was / scale_));
  }

  // Every second sample, whose neighbours are all others, then those.
  void smooth(const EditedField& edited, UndoLog* log, FieldChange& change) {
    for (int parity = 0; parity < 2; ++parity) {
      each_block([&](glm::ivec3 block) {
        std::span<Sample> samples;
        each_sample(block, [&](glm::ivec3 at, std::size_t n) {
          if (((at.x + at.y + at.z) & 1) != parity) return true;
          const std::span<const Sample> now = field_.block(block);
          const Sample before = now.empty() ? field_.filling(block) : now[n];
          const Sample after = sculpted(at, before);
          if (after == before) return true;
          if (samples.empty()) samples = open(block, edited, log, change);
          samples[n] = after;
          return true;
        });
      });
    }
    if (change.changed) each_block([&](glm::ivec3 block) { field_.close(block); });
  }

  const Edit& edit_;
  Field& field_;
  double scale_;
  glm::dvec3 up_{0, 1, 0};
  glm::ivec3 first_{0}, last_{-1};
};

template <class Sample>
Status sculpt(const EditedField& edited, const Edit& edit, ScalarField<Sample>& field, UndoLog* log,
              FieldChange& change) {
  Sculpt<Sample> job(edit, double{edited.field->info().reach_cells}, field);
  const std::uint32_t opened = job.opened();
  if (opened > field.free_blocks()) {
    return {StatusCode::limit_reached, "the field takes more samples", "field_sample_blocks",
            (opened - field.free_blocks()) * sizeof(Sample)};
  }
  job.run(edited, log, change);
  return {};
}

template <class Sample>
bool are_alike(std::span<const Sample> samples) {
  using Field = ScalarField<Sample>;
  if (samples[0] != Field::kAir && samples[0] != Field::kSolid) return false;
  return std::ranges::all_of(samples, [&](Sample s) { return s == samples[0]; });
}

template <class Sample>
void exchange(ScalarField<Sample>& field, UndoPart part, FieldChange& change) {
  using Field = ScalarField<Sample>;
  using Samples = std::array<Sample, Field::kBlockSamples>;
  const glm::ivec3 n = field.blocks();
  const auto exchange_those = [&](bool alike) {
    for (const UndoCell cell : part) {
      std::uint64_t is_done = 0;
      Samples wanted, now;
      std::memcpy(&is_done, cell.bytes.data(), kHead);
      std::memcpy(&wanted, cell.bytes.data() + kHead, sizeof wanted);
      if (is_done != 0 || are_alike<Sample>(wanted) != alike) continue;
      const auto b = static_cast<int>(cell.key);
      const glm::ivec3 block(b % n.x, b / n.x % n.y, b / n.x / n.y);
      const glm::ivec3 first = block * Field::kBlock, last = first + Field::kBlock - 1;
      change.first = change.changed ? glm::min(change.first, first) : first;
      change.last = change.changed ? glm::max(change.last, last) : last;
      change.changed = true;
      const std::span<const Sample> samples = field.block(block);
      if (samples.empty()) {
        now.fill(field.filling(block));
      } else {
        std::ranges::copy(samples, now.begin());
      }
      if (alike) {
        field.fill(block, wanted[0]);
      } else {
        const std::span<Sample> out = field.open(block);
        KARST_ASSERT(!out.empty());
        std::ranges::copy(wanted, out.begin());
      }
      is_done = 1;
      std::memcpy(cell.bytes.data(), &is_done, kHead);
      std::memcpy(cell.bytes.data() + kHead, &now, sizeof now);
    }
  };
  // What blocks that will be alike give back is enough for the others.
  exchange_those(true);
  exchange_those(false);
  for (const UndoCell cell : part) std::memset(cell.bytes.data(), 0, kHead);
}

}  // namespace

bool reaches_field(const Edit& edit, const FieldInfo& info) {
  Edit own = in_cells(edit, info);
  if (own.tool == EditTool::paint) own.tool = EditTool::smooth;  // both reach as far
  if (!check(own).ok()) return false;
  glm::ivec3 first, last;
  find_reach(own, double{info.reach_cells}, info.blocks * ScalarField<std::int8_t>::kBlock, first, last);
  return glm::all(glm::lessThanEqual(first, last));
}

Status edit_field(const EditedField& edited, const Edit& edit, UndoLog* log, FieldChange& change) {
  change = {};
  FieldBlocks& field = *edited.field;
  const Edit own = in_cells(edit, field.info());
  if (const Status status = check(own); !status.ok()) return status;
  return field.info().sample_bits == 16 ? sculpt(edited, own, field.words(), log, change)
                                        : sculpt(edited, own, field.bytes(), log, change);
}

void exchange_field(FieldBlocks& field, UndoPart part, FieldChange& change) {
  change = {};
  if (field.info().sample_bits == 16) {
    exchange(field.words(), part, change);
  } else {
    exchange(field.bytes(), part, change);
  }
}

}  // namespace karst::core
