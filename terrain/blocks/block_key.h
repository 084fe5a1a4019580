// SPDX-License-Identifier: MIT
// Names of blocks of an isosurface: level 0 is the finest; block (x, y, z) of level n begins at sample
// 16 2^n (x, y, z) and has 16^3 cells of 2^n samples.
#pragma once

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

#include "terrain/isosurface/extract_block.h"

namespace karst::core {

struct BlockKey {
  std::uint16_t x = 0, y = 0, z = 0;
  std::uint16_t level = 0;

  glm::ivec3 place() const { return {x, y, z}; }
  friend bool operator==(const BlockKey&, const BlockKey&) = default;
};

inline BlockKey block_key(glm::ivec3 place, int level) {
  return {static_cast<std::uint16_t>(place.x), static_cast<std::uint16_t>(place.y),
          static_cast<std::uint16_t>(place.z), static_cast<std::uint16_t>(level)};
}

// What lies around a block (ExtractBlock::around), two bits a place.
using BlockAround = std::uint64_t;

inline std::array<IsoNeighbour, 27> unpack_around(BlockAround around) {
  std::array<IsoNeighbour, 27> out{};
  for (std::size_t n = 0; n < out.size(); ++n) out[n] = static_cast<IsoNeighbour>(around >> (2 * n) & 3u);
  return out;
}

}  // namespace karst::core
