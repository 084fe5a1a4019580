// SPDX-License-Identifier: MIT
// What sculpting a field (edit_field.h) and painting it (paint_field.h) share: the brush in cells of the
// field, the blocks and samples that it reaches, and blocks that are kept whole in steps of the log.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/base/check.h"
#include "terrain/edit/edit.h"
#include "terrain/edit/undo_log.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::core {

// Of a brush: the radius, half the sides of a box, and the length of a capsule beyond them.
inline constexpr double kMostFieldBrush = 128;  // cells

struct FieldChange {
  bool changed = false;  // false: the field was so already
  // Samples that may have changed, both ends included.
  glm::ivec3 first{0};
  glm::ivec3 last{-1};

  void join(glm::ivec3 low, glm::ivec3 high) {
    first = changed ? glm::min(first, low) : low;
    last = changed ? glm::max(last, high) : high;
    changed = true;
  }
};

// An edit of the world's voxels, in cells from sample (0, 0, 0).
inline Edit in_cells(const Edit& edit, const FieldInfo& info) {
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

// Of an edit in cells: shape, place, sizes, amount and hardness. invalid_argument naming the field.
inline Status check_field_brush(const Edit& edit) {
  // Written so that NaN fails.
  const auto is_near = [](const glm::dvec3& v, double most) {
    return std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most;
  };
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  constexpr double kFarthest = 1e6;
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
  return {};
}

// Samples first..last of a field of blocks.
struct FieldReach {
  static constexpr int kBlock = ScalarField<std::int8_t>::kBlock;

  glm::ivec3 first{0};
  glm::ivec3 last{-1};

  bool exists() const { return glm::all(glm::lessThanEqual(first, last)); }
  glm::ivec3 first_in(glm::ivec3 block) const { return glm::max(first, block * kBlock); }
  glm::ivec3 last_in(glm::ivec3 block) const { return glm::min(last, block * kBlock + kBlock - 1); }

  template <class Visit>
  void each_block(const Visit& visit) const {
    if (!exists()) return;
    const glm::ivec3 low = first / kBlock, high = last / kBlock;
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) visit(glm::ivec3(x, y, z));
      }
    }
  }
  // Calls visit(sample, its number in the block), which returns whether to go on.
  template <class Visit>
  void each_sample(glm::ivec3 block, const Visit& visit) const {
    const glm::ivec3 corner = block * kBlock, low = first_in(block), high = last_in(block);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          const glm::ivec3 at(x, y, z);
          if (!visit(at, ScalarField<std::int8_t>::offset(at - corner))) return;
        }
      }
    }
  }
};

// A kept block, by its number: whether it is exchanged already, while blocks are, then all that it holds.
inline constexpr std::size_t kKeptHead = sizeof(std::uint64_t);

// Keeps a block of a field as it is in the step that is open, once a part. kept_in: by block, the part that
// kept it last; empty: it is kept each time. begins: it is the first of an edit.
inline void keep_block(UndoLog& log, CellKind kind, std::size_t block, std::span<const std::byte> contents,
                       std::span<std::uint32_t> kept_in, bool begins) {
  const auto part = [&] { return static_cast<std::uint32_t>(log.part_number()); };
  if (log.open_part() != kind || (begins && kept_in.empty())) {
    log.begin_part();
  } else if (!kept_in.empty() && kept_in[block] == part()) {
    return;
  }
  const std::span<std::byte> room = log.add(kind, block, kKeptHead + contents.size());
  if (room.empty()) return;
  std::memset(room.data(), 0, kKeptHead);
  std::memcpy(room.data() + kKeptHead, contents.data(), contents.size());
  if (!kept_in.empty()) kept_in[block] = part();
}

// Exchanges blocks that a part keeps with what is there. blocks: a ScalarField or FieldMaterials. are_alike:
// whether a block of such values takes no room.
template <class Blocks, class AreAlike>
void exchange_blocks(Blocks& blocks, UndoPart part, const AreAlike& are_alike, FieldChange& change) {
  using Value = std::remove_cvref_t<decltype(blocks.filling(glm::ivec3(0)))>;
  using Values = std::array<Value, Blocks::kBlockSamples>;
  const glm::ivec3 n = blocks.blocks();
  const auto exchange_those = [&](bool alike) {
    for (const UndoCell cell : part) {
      std::uint64_t is_done = 0;
      Values wanted, now;
      std::memcpy(&is_done, cell.bytes.data(), kKeptHead);
      std::memcpy(&wanted, cell.bytes.data() + kKeptHead, sizeof wanted);
      if (is_done != 0 || are_alike(wanted) != alike) continue;
      const auto b = static_cast<int>(cell.key);
      const glm::ivec3 block(b % n.x, b / n.x % n.y, b / n.x / n.y);
      change.join(block * Blocks::kBlock, block * Blocks::kBlock + Blocks::kBlock - 1);
      const std::span<const Value> there = blocks.block(block);
      if (there.empty()) {
        now.fill(blocks.filling(block));
      } else {
        std::ranges::copy(there, now.begin());
      }
      if (alike) {
        blocks.fill(block, wanted[0]);
      } else {
        const std::span<Value> out = blocks.open(block);
        KARST_ASSERT(!out.empty());
        std::ranges::copy(wanted, out.begin());
      }
      is_done = 1;
      std::memcpy(cell.bytes.data(), &is_done, kKeptHead);
      std::memcpy(cell.bytes.data() + kKeptHead, &now, sizeof now);
    }
  };
  // What blocks that will be alike give back is enough for the others.
  exchange_those(true);
  exchange_those(false);
  for (const UndoCell cell : part) std::memset(cell.bytes.data(), 0, kKeptHead);
}

}  // namespace karst::core
