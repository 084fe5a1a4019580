// SPDX-License-Identifier: MIT
// Hash of a node or tile, for tables of them.
#pragma once

#include <cstdint>

#include "terrain/ground/ground.h"

namespace karst::core {

inline std::uint32_t key_hash(NodeKey key) {
  std::uint64_t h = static_cast<std::uint32_t>(key.x) * 0x9e3779b97f4a7c15ull;
  h = (h ^ static_cast<std::uint32_t>(key.z)) * 0xc2b2ae3d27d4eb4full;
  h = (h ^ (h >> 29) ^ static_cast<std::uint32_t>(key.size)) * 0x165667b19e3779f9ull;
  return static_cast<std::uint32_t>(h >> 32);
}

}  // namespace karst::core
