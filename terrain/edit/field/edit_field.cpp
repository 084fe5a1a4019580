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

// An edit in cells.
Status check(const Edit& edit) {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  if (!edits_fields(edit.tool))
    return refuse("a field is cut with clear, fill, smooth, flatten and level", "tool");
  if (const Status status = check_field_brush(edit); !status.ok()) return status;
  if (edit.tool == EditTool::flatten) {
    const double length = glm::length(edit.up);
    if (!(length >= 1e-9 && length <= 1e9)) return refuse("without a direction", "up");
  }
  return {};
}

// Samples that an edit in cells may change.
FieldReach reach_of(const Edit& edit, double reach, glm::ivec3 samples) {
  const BrushBox box = brush_box(edit);
  const double more = edits_voxels(edit.tool) ? reach + 1 : 1;
  const glm::dvec3 most(samples);
  return {glm::ivec3(glm::clamp(glm::ceil(box.low - more), glm::dvec3(0), most)),
          glm::ivec3(glm::clamp(glm::floor(box.high + more), glm::dvec3(-1), most - 1.0))};
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

  Sculpt(const Edit& edit, double reach, Field& field)
      : edit_(edit),
        field_(field),
        scale_(-double{Field::kSolid} / reach),
        reach_(reach_of(edit, reach, field.samples())) {
    const double length = glm::length(edit.up);
    if (length > 0) up_ = edit.up / length;
  }

  // Blocks that change and take samples only then.
  std::uint32_t opened() const {
    std::uint32_t count = 0;
    reach_.each_block([&](glm::ivec3 block) {
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
    reach_.each_block([&](glm::ivec3 block) {
      if (!changes(block)) return;
      const std::span<Sample> samples = open(block, edited, log, change);
      reach_.each_sample(block, [&](glm::ivec3 at, std::size_t n) {
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
  // Samples of a block that is about to change, which is kept as it is.
  std::span<Sample> open(glm::ivec3 block, const EditedField& edited, UndoLog* log, FieldChange& change) {
    const std::span<Sample> samples = field_.open(block);
    KARST_ASSERT(!samples.empty());
    if (log != nullptr) {
      keep_block(*log, CellKind::field_block, index(block), std::as_bytes(samples), edited.kept_in,
                 !change.changed);
    }
    change.join(reach_.first_in(block), reach_.last_in(block));
    return samples;
  }

  bool changes(glm::ivec3 block) const {
    const std::span<const Sample> samples = field_.block(block);
    const Sample all = field_.filling(block);
    bool found = false;
    reach_.each_sample(block, [&](glm::ivec3 at, std::size_t n) {
      const Sample before = samples.empty() ? all : samples[n];
      found = sculpted(at, before) != before;
      return !found;
    });
    return found;
  }
  // Whether all around a block that is all alike is so, too: smoothing changes nothing of it. Samples that
  // change first lie a sample from it, and what they change by one more.
  bool is_alone(glm::ivec3 block) const { return field_.are_alike(block - 1, block + 1); }

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
      reach_.each_block([&](glm::ivec3 block) {
        std::span<Sample> samples;
        reach_.each_sample(block, [&](glm::ivec3 at, std::size_t n) {
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
    if (change.changed) reach_.each_block([&](glm::ivec3 block) { field_.close(block); });
  }

  const Edit& edit_;
  Field& field_;
  double scale_;
  FieldReach reach_;
  glm::dvec3 up_{0, 1, 0};
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

}  // namespace

bool reaches_field(const Edit& edit, const FieldInfo& info) {
  Edit own = in_cells(edit, info);
  if (own.tool == EditTool::paint) own.tool = EditTool::smooth;  // both reach as far
  if (!check(own).ok()) return false;
  return reach_of(own, double{info.reach_cells}, info.blocks * FieldReach::kBlock).exists();
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
    exchange_blocks(field.words(), part, are_alike<std::int16_t>, change);
  } else {
    exchange_blocks(field.bytes(), part, are_alike<std::int8_t>, change);
  }
}

}  // namespace karst::core
