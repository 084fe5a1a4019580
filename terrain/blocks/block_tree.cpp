// SPDX-License-Identifier: MIT
#include "terrain/blocks/block_tree.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "terrain/base/check.h"
#include "terrain/isosurface/measure_cells.h"

namespace karst::core {
namespace {

constexpr glm::ivec3 offset_of(int n) {
  return {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
}

// Whether some cell of a block of the finest level may have surface.
template <class Sample>
bool is_mixed(const ScalarField<Sample>& field, glm::ivec3 first) {
  const glm::ivec3 last = glm::min(first + 1, field.blocks() - 1);
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        if (!field.block({x, y, z}).empty() || field.filling({x, y, z}) != field.filling(first)) return true;
      }
    }
  }
  return false;
}

}  // namespace

void BlockTree::reset(const FieldBlocks& field) {
  info_ = field.info();
  levels_ = 0;
  std::size_t count = 0;
  for (glm::ivec3 size = info_.drawn_blocks(); levels_ <= kIsoMaxLevel; size = (size + 1) / 2) {
    const auto n = static_cast<std::size_t>(levels_++);
    size_[n] = size;
    first_[n] = count;
    count += static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
             static_cast<std::size_t>(size.z);
    first_[n + 1] = count;
    if (size == glm::ivec3(1)) break;
    // In a region no block reaches beyond the sides.
    if (info_.in_region && (size.x % 2 != 0 || size.z % 2 != 0)) break;
  }
  KARST_ASSERT(count <= storage_.nodes.size() && first_[1] <= storage_.divided.size());
  for (const std::span<std::uint8_t> bytes : {storage_.nodes, storage_.steps, storage_.errors})
    std::fill_n(bytes.begin(), count, std::uint8_t{0});
  refresh(field, glm::ivec3(0), info_.blocks * kIsoCells - 1);
}

void BlockTree::refresh(const FieldBlocks& field, glm::ivec3 low, glm::ivec3 high) {
  // A block has cells up to the first samples of the next one.
  glm::ivec3 first = glm::max((low - 1) >> 4, glm::ivec3(0));
  glm::ivec3 last = glm::min(high >> 4, info_.drawn_blocks() - 1);
  field.with([&](const auto& samples) {
    for (int z = first.z; z <= last.z; ++z) {
      for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x)
          node({x, y, z}, 0) = is_mixed(samples, {x, y, z}) ? kSurface : std::uint8_t{0};
      }
    }
  });
  for (int level = 1; level < levels_; ++level) {
    first = first >> 1;
    last = last >> 1;
    for (int z = first.z; z <= last.z; ++z) {
      for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
          std::uint8_t any = 0;
          for (int o = 0; o < 8; ++o) {
            const glm::ivec3 child = 2 * glm::ivec3(x, y, z) + glm::ivec3(o & 1, o >> 1 & 1, o >> 2);
            if (inside(child, level - 1) && (node(child, level - 1) & kSurface) != 0) any = kSurface;
          }
          std::uint8_t& flags = node({x, y, z}, level);
          flags = any == 0 ? any : static_cast<std::uint8_t>((flags & ~kSurface) | any);
        }
      }
    }
    measure(field, level, low, high);
  }
}

// What is known of blocks stays, as it may be of cells that have not changed.
void BlockTree::measure(const FieldBlocks& field, int level, glm::ivec3 low, glm::ivec3 high) {
  const glm::ivec3 first_cell = glm::max((low - 1) >> level, glm::ivec3(0)), last_cell = high >> level;
  const glm::ivec3 last_block = blocks(level) - 1;
  const glm::ivec3 first = glm::max((first_cell - kFarCells) >> 4, glm::ivec3(0));
  const glm::ivec3 last = glm::min((last_cell + kFarCells) >> 4, last_block);
  field.with([&]<class Sample>(const ScalarField<Sample>& samples) {
    MeasureCells<Sample> cells;
    cells.field = &samples;
    cells.level = level;
    for (int z = first.z; z <= last.z; ++z) {
      for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
          std::uint8_t& flags = node({x, y, z}, level);
          std::uint8_t& step = storage_.steps[index({x, y, z}, level)];
          if ((flags & kSurface) == 0) {
            step = 0;
            continue;
          }
          // Of what it lost, cells around may be others.
          const int more = (flags & kFar) != 0 ? kFarCells : (flags & kNear) != 0 ? 1 : 0;
          const glm::ivec3 corner = glm::ivec3(x, y, z) * kIsoCells;
          const glm::ivec3 from = glm::max(corner, first_cell - more);
          const glm::ivec3 to = glm::min(corner + kIsoCells - 1, last_cell + more);
          const CellDistance most = cells.run(from, to, code_cells(step));
          step = std::max(step, cells_code(most.most));
          if (most.reach > 0) flags |= most.reach > 1 ? kFar : kNear;
        }
      }
    }
  });
  sum_errors(level, glm::max(first - 1, glm::ivec3(0)), glm::min(last + 1, last_block));
}

void BlockTree::sum_errors(int level, glm::ivec3 first, glm::ivec3 last) {
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        const glm::ivec3 place(x, y, z);
        std::uint8_t step = storage_.steps[index(place, level)];
        float before = 0;
        bool away = false;
        for (int o = 0; o < 8; ++o) {
          const glm::ivec3 child = 2 * place + glm::ivec3(o & 1, o >> 1 & 1, o >> 2);
          if (!inside(child, level - 1)) continue;
          before = std::max(before, code_cells(storage_.errors[index(child, level - 1)]) / 2);
          away = away || (node(child, level - 1) & kAway) != 0;
        }
        for (int o = 0; o < 27 && away; ++o) {
          const glm::ivec3 beside = place + offset_of(o);
          if (inside(beside, level)) step = std::max(step, storage_.steps[index(beside, level)]);
        }
        storage_.errors[index(place, level)] = cells_code(before + code_cells(step));
        std::uint8_t& flags = node(place, level);
        flags =
            static_cast<std::uint8_t>((flags & ~kAway) | (away || (flags & (kNear | kFar)) != 0 ? kAway : 0));
      }
    }
  }
}

float BlockTree::block_error(BlockKey block) const {
  if (block.level == 0) return 0;
  const float cells = code_cells(storage_.errors[index(block.place(), block.level)]) + kRoundedCells;
  return cells * static_cast<float>(1 << (block.level + info_.cell_log2));
}

LatticeBox BlockTree::box(BlockKey block) const {
  const int cell = 1 << (info_.cell_log2 + block.level);
  const glm::ivec3 low = info_.low_steps() + block.place() * (cell * kIsoCells);
  // Half a cell: vertices near transition cells move a fourth along their tangent plane.
  return {low - cell / 2, low + cell * kIsoCells + cell / 2};
}

float BlockTree::least_apparent(BlockKey block, const LodEye& eye) const {
  const LatticeBox b = box(block);
  PatchLod lod;
  const glm::vec3 half = glm::vec3(b.max - b.min) * 0.5f;
  for (int axis = 0; axis < 3; ++axis) lod.centre[axis] = static_cast<float>(b.min[axis]) + half[axis];
  lod.reach = static_cast<float>(kSteepest) * std::sqrt(half.x * half.x + half.y * half.y + half.z * half.z);
  return least_apparent_distance(lod, eye);
}

glm::ivec3 BlockTree::place_of(std::size_t in_level, int level) const {
  const glm::ivec3 size = size_[static_cast<std::size_t>(level)];
  const auto n = static_cast<int>(in_level);
  return {n % size.x, n / size.x % size.y, n / size.x / size.y};
}

void BlockTree::descend(glm::ivec3 place, int level, std::span<const BlockEye> eyes, int finest) {
  const std::uint8_t flags = node(place, level);
  if ((flags & kSurface) == 0 || level <= finest) return;
  const float error = block_error(block_key(place, level));
  // Beyond the field's end there are no samples: a coarse block would go on there as the last ones do.
  const bool is_within = glm::all(glm::lessThanEqual((place + 1) << level, blocks(0)));
  const bool is_enough =
      is_within && std::all_of(eyes.begin(), eyes.end(), [&](const BlockEye& eye) {
        return error * eye.steps_per_step <= least_apparent(block_key(place, level), eye.eye);
      });
  if (is_enough) return;
  divide(place, level);
  for (int o = 0; o < 8; ++o) {
    const glm::ivec3 child = 2 * place + glm::ivec3(o & 1, o >> 1 & 1, o >> 2);
    if (inside(child, level - 1)) descend(child, level - 1, eyes, finest);
  }
}

// Its parents, too.
void BlockTree::divide(glm::ivec3 place, int level) {
  if (is_divided(place, level)) return;
  if (level + 1 < levels_) divide(place >> 1, level + 1);
  node(place, level) |= kDivided | kExists;
  for (int o = 0; o < 8; ++o) {
    const glm::ivec3 child = 2 * place + glm::ivec3(o & 1, o >> 1 & 1, o >> 2);
    if (inside(child, level - 1)) node(child, level - 1) |= kExists;
  }
}

// What divided blocks of a level ask of blocks of the level and of the next one.
void BlockTree::settle(int level) {
  const auto n = static_cast<std::size_t>(level);
  std::size_t count = 0;
  for (std::size_t at = first_[n]; at < first_[n + 1]; ++at) {
    if ((storage_.nodes[at] & kDivided) != 0)
      storage_.divided[count++] = static_cast<std::uint32_t>(at - first_[n]);
  }
  for (std::size_t next = 0; next < count; ++next) {
    const glm::ivec3 place = place_of(storage_.divided[next], level);
    for (int o = 0; o < 27 && level + 1 < levels_; ++o) {
      const glm::ivec3 beside = place + offset_of(o);
      if (inside(beside, level)) divide(beside >> 1, level + 1);
    }
    // Twelve edges: the block across, and the two between.
    for (int o = 0; o < 27; ++o) {
      const glm::ivec3 step = offset_of(o);
      if (std::abs(step.x) + std::abs(step.y) + std::abs(step.z) != 2) continue;
      const glm::ivec3 across = place + step;
      if (!inside(across, level) || !is_divided(across, level)) continue;
      glm::ivec3 first = step;
      first[step.x != 0 ? 0 : 1] = 0;
      const glm::ivec3 a = place + first, b = place + step - first;
      if (is_divided(a, level) || is_divided(b, level)) continue;
      // The same one from both sides: which of them has the lesser index.
      const glm::ivec3 more = index(a, level) < index(b, level) ? a : b;
      divide(more, level);
      storage_.divided[count++] = static_cast<std::uint32_t>(index(more, level) - first_[n]);
    }
  }
}

BlockAround BlockTree::around(glm::ivec3 place, int level) const {
  BlockAround out = 0;
  for (int n = 0; n < 27; ++n) {
    const glm::ivec3 at = place + offset_of(n);
    if (n == 13 || !inside(at, level)) continue;
    const std::uint8_t flags = node(at, level);
    auto kind = IsoNeighbour::same;
    if ((flags & kDivided) != 0) {
      kind = IsoNeighbour::finer;
    } else if ((flags & kExists) == 0) {
      kind = IsoNeighbour::coarser;
    }
    out |= BlockAround{static_cast<std::uint8_t>(kind)} << (2 * n);
  }
  return out;
}

std::size_t BlockTree::choose(std::span<const BlockEye> eyes, int finest, std::span<ChosenBlock> out) {
  const int top = levels_ - 1;
  for (std::size_t at = 0; at < first_[static_cast<std::size_t>(levels_)]; ++at)
    storage_.nodes[at] &= kSurface | kNear | kFar | kAway;
  const glm::ivec3 roots = blocks(top);
  for (int z = 0; z < roots.z; ++z) {
    for (int y = 0; y < roots.y; ++y) {
      for (int x = 0; x < roots.x; ++x) {
        node({x, y, z}, top) |= kExists;
        descend({x, y, z}, top, eyes, finest);
      }
    }
  }
  for (int level = 1; level < levels_; ++level) settle(level);
  std::size_t count = 0;
  each_chosen([&](BlockKey key) {
    if (!may_hold_surface(key)) return;
    if (count < out.size()) out[count] = {key, around(key.place(), key.level)};
    ++count;
  });
  return count;
}

}  // namespace karst::core
