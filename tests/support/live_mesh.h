// SPDX-License-Identifier: MIT
// The triangles of a loaded world at its finest level: whether they close.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <set>
#include <vector>

#include "terrain/draw/index_batches.h"
#include "terrain/patch/displacement.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/world/world.h"
#include "tests/support/test_world.h"

namespace karst::test {

// Edges that triangles run in one direction more often than in the other, but for those where the surface
// ends, at the sides of its voxels: 0 for a surface that is closed and consistently oriented. Patches must be
// linked to each other. Of a part of the world.
inline std::size_t open_edges(const core::World& world, std::size_t part = 0) {
  using Position = std::array<std::int32_t, 3>;
  struct Edge {
    Position a, b;  // a < b
    int direction;
    auto operator<=>(const Edge&) const = default;
  };
  const int level = world.info().level;
  const Surface surface = world.parts()[part].surface;
  const TestScratch scratch;
  GenerateVertices generate;
  generate.surface = surface;
  generate.heights = world.heights();
  generate.level = level;
  generate.scratch = scratch.get();
  std::size_t open = generate.validate().ok() ? 0 : 1;
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(level)));
  std::vector<Edge> edges;
  std::set<Position> ends;
  for (PatchId p = 0; p < surface.patches.size(); ++p) {
    if (surface.is_free(p)) continue;
    const Patch& patch = surface.patches[p];
    generate.run(p, vertices, nullptr);
    const glm::ivec3 origin = patch_origin(surface.volume_of(p));
    const auto position = [&](std::size_t vertex) {
      const auto& own = vertices[vertex].position;
      return Position{origin.x + own[0], origin.y + own[1], origin.z + own[2]};
    };
    IndexRange ranges[kMaxIndexRanges];
    const int count = index_ranges(level, 0, patch.collapsed != 0 ? 8u : 0u, ranges);
    for (int r = 0; r < count; ++r) {
      for (std::uint32_t t = 0; t < ranges[r].count; t += 3) {
        Position corner[3];
        for (std::uint32_t k = 0; k < 3; ++k)
          corner[k] = position(world.index_table()[ranges[r].first + t + k]);
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
        for (std::size_t k = 0; k < 3; ++k) {
          const Position &from = corner[k], &to = corner[(k + 1) % 3];
          edges.push_back(from < to ? Edge{from, to, 1} : Edge{to, from, -1});
        }
      }
    }
    for (int e = 0; e < 4; ++e) {
      const PatchEdge other = patch.neighbour[e];
      if (other.exists()) {
        const PatchEdge back = surface.patches[other.patch()].neighbour[other.edge()];
        if (surface.is_free(other.patch()) || !back.exists() || back.patch() != p || back.edge() != e) ++open;
        continue;
      }
      const GridLine line = GridLine::along_edge(e, 0, level, false);
      const int n = patch_cells(level);
      for (int t = 0; t <= n; ++t) {
        const int i = line.i0 + t * line.di, j = line.j0 + t * line.dj;
        ends.insert(position(static_cast<std::size_t>(vertex_order(level, i, j))));
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    int balance = 0;
    std::size_t j = i;
    for (; j < edges.size() && edges[j].a == edges[i].a && edges[j].b == edges[i].b; ++j)
      balance += edges[j].direction;
    open += balance != 0 && !(ends.contains(edges[i].a) && ends.contains(edges[i].b));
    i = j;
  }
  return open;
}

}  // namespace karst::test
