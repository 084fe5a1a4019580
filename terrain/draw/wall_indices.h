// SPDX-License-Identifier: MIT
// The walls of a node of the ground, where the ground ends: five triangles an edge, facing out, from the
// edge's five vertices to the two below its corners, which follow the grid's in the page
// (terrain/ground/ground.h).
#pragma once

#include <array>
#include <cstdint>

namespace karst::core {

inline constexpr std::uint32_t kIndicesPerWall = 15;

// Vertices of a node's slot along edge e, from its first corner on, in the slot's order at level 2
// (gpu_vertex.h); as index_batches.cpp walks it.
inline constexpr std::array<std::array<std::uint16_t, 5>, 4> kNodeEdges = {
    {{0, 9, 1, 10, 2}, {2, 15, 5, 22, 8}, {8, 24, 7, 23, 6}, {6, 18, 3, 11, 0}}};

// By edge.
inline constexpr std::array<std::array<std::uint16_t, kIndicesPerWall>, 4> kWallIndices = [] {
  constexpr std::uint16_t kFirstFoot = 25;
  std::array<std::array<std::uint16_t, kIndicesPerWall>, 4> all{};
  for (std::size_t e = 0; e < 4; ++e) {
    const std::array<std::uint16_t, 5>& v = kNodeEdges[e];
    const auto a = static_cast<std::uint16_t>(kFirstFoot + e);
    const auto b = static_cast<std::uint16_t>(kFirstFoot + (e + 1) % 4);
    all[e] = {v[0], a, v[1], v[1], a, v[2], v[2], a, b, v[2], b, v[3], v[3], b, v[4]};
  }
  return all;
}();

constexpr std::uint32_t wall_index_count(unsigned walls) {
  return kIndicesPerWall * ((walls & 1u) + (walls >> 1 & 1u) + (walls >> 2 & 1u) + (walls >> 3 & 1u));
}

}  // namespace karst::core
