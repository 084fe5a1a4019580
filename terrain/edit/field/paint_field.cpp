// SPDX-License-Identifier: MIT
// All arithmetic is in double, each operation a plain IEEE one, so that an edit gives the same bits anywhere.
#include "terrain/edit/field/paint_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "karst/edit.h"
#include "terrain/base/check.h"
#include "terrain/edit/brush.h"

namespace karst::core {
namespace {

// A kept block: whether it is exchanged already, while blocks are, then all of its codes.
constexpr std::size_t kHead = sizeof(std::uint64_t);
constexpr int kBlock = FieldMaterials::kBlock;
constexpr double kMostBrush = 128;  // cells
constexpr double kFarthest = 1e6;

using Codes = std::array<std::uint8_t, FieldMaterials::kBlockSamples>;

Edit in_cells(const Edit& edit, const FieldInfo& info) {
  const double cells = 1 << (kMostCellLog2 - info.cell_log2);  // a voxel
  const glm::dvec3 corner(info.corner);
  Edit out = edit;
  out.place = (edit.place - corner) * cells;
  out.to = (edit.to - corner) * cells;
  out.half = edit.half * cells;
  out.radius = edit.radius * cells;
  return out;
}

// Written so that NaN fails.
bool is_near(const glm::dvec3& v, double most) {
  return std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most;
}

// An edit in cells.
Status check(const Edit& edit, std::uint32_t materials) {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  if (edit.tool != EditTool::paint) return refuse("a field's materials are painted", "tool");
  if (edit.shape != BrushShape::box && edit.shape != BrushShape::sphere)
    return refuse("a field is painted with a box or a sphere", "shape");
  if (!is_near(edit.place, kFarthest)) return refuse("not finite, or too far away", "place");
  if (edit.shape == BrushShape::box) {
    if (!is_near(edit.half, kMostBrush) || !(edit.half.x > 0 && edit.half.y > 0 && edit.half.z > 0))
      return refuse("not more than 0 and at most 128 cells of the field", "half_m");
  } else if (!(edit.radius > 0 && edit.radius <= kMostBrush)) {
    return refuse("not more than 0 and at most 128 cells of the field", "radius_m");
  }
  if (!(edit.amount >= 0 && edit.amount <= 1)) return refuse("not within 0..1", "amount");
  if (!(edit.hardness >= 0 && edit.hardness <= 1)) return refuse("not within 0..1", "hardness");
  if (edit.material != kNoMaterial && edit.material >= materials)
    return refuse("not the number of a material", "material");
  return {};
}

glm::ivec3 place_of(std::uint64_t block, glm::ivec3 blocks) {
  const auto b = static_cast<int>(block);
  return {b % blocks.x, b / blocks.x % blocks.y, b / blocks.x / blocks.y};
}

void join(SampleBox& box, glm::ivec3 first, glm::ivec3 last) {
  box.first = box.any() ? glm::min(box.first, first) : first;
  box.last = box.any() ? glm::max(box.last, last) : last;
}

class Painter {
 public:
  Painter(const PaintField& job, const Edit& edit)
      : job_(job), edit_(edit), material_(edit.material == kNoMaterial ? 0u : edit.material + 1u) {
    const BrushBox box = brush_box(edit);
    const glm::dvec3 samples(job.field->info().blocks * kBlock);
    first_ = glm::ivec3(glm::clamp(glm::ceil(box.low), glm::dvec3(0), samples));
    last_ = glm::ivec3(glm::clamp(glm::floor(box.high), glm::dvec3(-1), samples - 1.0));
  }

  Status run(SampleBox& changed) {
    FieldMaterials& materials = job_.field->materials();
    std::uint32_t opened = 0;
    each_block([&](glm::ivec3 block) {
      const bool alike = !materials.exists() || materials.block(block).empty();
      opened += alike && changes(block) ? 1u : 0u;
    });
    const std::uint32_t free = materials.exists() ? materials.free_blocks() : 0;
    if (opened > free) {
      return {StatusCode::limit_reached, "the field takes more materials", "field_material_blocks",
              opened - free};
    }
    if (!materials.exists()) return {};
    each_block([&](glm::ivec3 block) {
      if (!changes(block)) return;
      const std::span<std::uint8_t> codes = materials.open(block);
      KARST_ASSERT(!codes.empty());
      if (job_.log != nullptr) keep(index(block), std::as_bytes(codes), !changed.any());
      const glm::ivec3 corner = block * kBlock;
      join(changed, glm::max(first_, corner), glm::min(last_, corner + kBlock - 1));
      each_sample(block, [&](glm::ivec3 at, std::size_t n) {
        codes[n] = painted(at, codes[n]);
        return true;
      });
      materials.close(block);
    });
    return {};
  }

 private:
  std::uint64_t index(glm::ivec3 block) const {
    const glm::ivec3 n = job_.field->info().blocks;
    return static_cast<std::uint64_t>(block.x + n.x * (block.y + n.y * block.z));
  }
  bool is_air(glm::ivec3 block) const {
    return job_.field->with([&](const auto& f) { return f.block(block).empty() && f.filling(block) > 0; });
  }
  template <class Visit>
  void each_block(const Visit& visit) const {
    if (!glm::all(glm::lessThanEqual(first_, last_))) return;
    const glm::ivec3 low = first_ / kBlock, high = last_ / kBlock;
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          if (!is_air({x, y, z})) visit(glm::ivec3(x, y, z));
        }
      }
    }
  }
  // Calls visit(sample, its number in the block), which returns whether to go on.
  template <class Visit>
  void each_sample(glm::ivec3 block, const Visit& visit) const {
    const glm::ivec3 corner = block * kBlock;
    const glm::ivec3 low = glm::max(first_, corner), high = glm::min(last_, corner + kBlock - 1);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          const glm::ivec3 at(x, y, z);
          if (!visit(at, FieldMaterials::offset(at - corner))) return;
        }
      }
    }
  }
  std::uint8_t painted(glm::ivec3 at, std::uint8_t code) const {
    return mix_in(code, material_, edit_.amount * brush_weight(edit_, glm::dvec3(at)));
  }
  bool changes(glm::ivec3 block) const {
    const FieldMaterials& materials = job_.field->materials();
    const std::span<const std::uint8_t> codes =
        materials.exists() ? materials.block(block) : std::span<const std::uint8_t>();
    const std::uint8_t all = materials.exists() && codes.empty() ? materials.filling(block) : std::uint8_t{0};
    bool found = false;
    each_sample(block, [&](glm::ivec3 at, std::size_t n) {
      const std::uint8_t before = codes.empty() ? all : codes[n];
      found = painted(at, before) != before;
      return !found;
    });
    return found;
  }
  void keep(std::uint64_t block, std::span<const std::byte> codes, bool is_first) const {
    UndoLog& log = *job_.log;
    const auto part = [&] { return static_cast<std::uint32_t>(log.part_number()); };
    const bool goes_on = log.open_part() == CellKind::field_materials;
    if (is_first && (!goes_on || job_.kept_in.empty())) {
      log.begin_part();
    } else if (!job_.kept_in.empty() && job_.kept_in[block] == part() && goes_on) {
      return;
    }
    const std::span<std::byte> room = log.add(CellKind::field_materials, block, kHead + codes.size());
    if (room.empty()) return;
    std::memset(room.data(), 0, kHead);
    std::memcpy(room.data() + kHead, codes.data(), codes.size());
    if (!job_.kept_in.empty()) job_.kept_in[block] = part();
  }

  const PaintField& job_;
  const Edit& edit_;
  unsigned material_;
  glm::ivec3 first_{0}, last_{-1};
};

}  // namespace

std::uint8_t mix_in(std::uint8_t code, unsigned material, double share) {
  const MaterialMix mix = mix_of(code);
  std::array<double, kMostFieldMaterials + 1> weights{};
  weights[mix.first] += (1 - share) * (kMixShares - mix.sevenths);
  weights[mix.second] += (1 - share) * mix.sevenths;
  weights[material] += share * kMixShares;
  // The lesser number where two weigh alike.
  unsigned most = 0;
  for (unsigned m = 1; m < weights.size(); ++m) most = weights[m] > weights[most] ? m : most;
  unsigned next = most == 0 ? 1 : 0;
  for (unsigned m = 0; m < weights.size(); ++m) {
    if (m != most && weights[m] > weights[next]) next = m;
  }
  const unsigned first = std::min(most, next), second = std::max(most, next);
  const double of_second = weights[second] / (weights[first] + weights[second]);
  const auto sevenths = static_cast<std::uint8_t>(std::floor(of_second * kMixShares + 0.5));
  if (sevenths == 0 || sevenths == kMixShares)
    return static_cast<std::uint8_t>(sevenths == 0 ? first : second);
  return code_of({static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(second), sevenths});
}

Status PaintField::run(const Edit& edit, SampleBox& changed) const {
  changed = {};
  const Edit own = in_cells(edit, field->info());
  if (const Status status = check(own, materials); !status.ok()) return status;
  return Painter(*this, own).run(changed);
}

void exchange_paint(FieldBlocks& field, UndoPart part, SampleBox& changed) {
  changed = {};
  FieldMaterials& materials = field.materials();
  const auto are_alike = [](const Codes& codes) {
    return std::ranges::all_of(codes, [&](std::uint8_t c) { return c == codes[0]; });
  };
  const auto exchange_those = [&](bool alike) {
    for (const UndoCell cell : part) {
      std::uint64_t is_done = 0;
      Codes wanted, now;
      std::memcpy(&is_done, cell.bytes.data(), kHead);
      std::memcpy(&wanted, cell.bytes.data() + kHead, sizeof wanted);
      if (is_done != 0 || are_alike(wanted) != alike) continue;
      const glm::ivec3 block = place_of(cell.key, materials.blocks());
      join(changed, block * kBlock, block * kBlock + kBlock - 1);
      const std::span<const std::uint8_t> codes = materials.block(block);
      if (codes.empty()) {
        now.fill(materials.filling(block));
      } else {
        std::ranges::copy(codes, now.begin());
      }
      if (alike) {
        materials.fill(block, wanted[0]);
      } else {
        const std::span<std::uint8_t> out = materials.open(block);
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

std::uint8_t material_at(const FieldBlocks& field, const glm::dvec3& place) {
  if (!field.materials().exists()) return 0;
  const glm::ivec3 low(glm::floor(place));
  const glm::ivec3 nearest(glm::floor(place + 0.5));
  glm::ivec3 best = nearest;
  double least = std::numeric_limits<double>::infinity();
  for (int n = 0; n < 8; ++n) {
    const glm::ivec3 at = low + glm::ivec3(n & 1, n >> 1 & 1, n >> 2);
    const glm::dvec3 way = glm::dvec3(at) - place;
    const double square = glm::dot(way, way);
    const bool solid = field.with([&](const auto& f) { return f.at(at); }) < 0;
    if (!solid || square >= least) continue;
    least = square;
    best = at;
  }
  return field.materials().at(best);
}

}  // namespace karst::core
