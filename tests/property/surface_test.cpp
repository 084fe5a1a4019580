// SPDX-License-Identifier: MIT
// The extracted surface as a whole, on random voxel fields: a closed, consistently oriented 2-manifold at
// every level and with legal level differences, checked on decoded 16-bit vertices, bit by bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <compare>
#include <cstdio>
#include <set>
#include <utility>
#include <vector>

#include "terrain/draw/index_batches.h"
#include "terrain/patch/corner_fan.h"
#include "terrain/patch/displacement.h"
#include "terrain/surface/bezier/case_tables.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::Random;
using test::TestWorld;

using Position = std::array<std::int32_t, 3>;

Position lattice_position(const Volume& volume, const std::int16_t (&p)[3]) {
  const glm::ivec3 origin = patch_origin(volume);
  return {origin.x + p[0], origin.y + p[1], origin.z + p[2]};
}

// Directed edges of a triangle mesh, by position.
struct Mesh {
  struct Edge {
    Position a, b;  // a < b
    int direction;  // +1: the triangle runs from a to b
    friend auto operator<=>(const Edge&, const Edge&) = default;
  };
  std::vector<Edge> edges;
  std::size_t triangles = 0;
  std::size_t degenerate = 0;

  void add(const Position& a, const Position& b, const Position& c) {
    if (a == b || b == c || c == a) {
      ++degenerate;
      return;
    }
    ++triangles;
    const Position* corner[3] = {&a, &b, &c};
    for (int k = 0; k < 3; ++k) {
      const Position& from = *corner[k];
      const Position& to = *corner[(k + 1) % 3];
      edges.push_back(from < to ? Edge{from, to, 1} : Edge{to, from, -1});
    }
  }

  // Edges that are not run as often one way as the other. Zero for a closed, consistently oriented surface;
  // an edge may be run twice each way where surfaces touch.
  std::size_t count_open() {
    std::sort(edges.begin(), edges.end());
    std::size_t open = 0;
    for (std::size_t i = 0; i < edges.size();) {
      int balance = 0;
      std::size_t j = i;
      for (; j < edges.size() && edges[j].a == edges[i].a && edges[j].b == edges[i].b; ++j)
        balance += edges[j].direction;
      open += balance != 0;
      i = j;
    }
    return open;
  }
};

// Random levels per patch, neighbours at most one apart.
std::vector<int> random_levels(const TestWorld& world, int max_level, Random& random) {
  const Surface surface = world.surface();
  std::vector<int> levels(surface.patches.size());
  for (int& level : levels) level = 1 + random.below(max_level);
  for (bool changed = true; changed;) {
    changed = false;
    for (PatchId p = 0; p < levels.size(); ++p) {
      for (const PatchEdge e : surface.patches[p].neighbour) {
        if (e.exists() && levels[e.patch()] < levels[p] - 1) {
          levels[e.patch()] = levels[p] - 1;
          changed = true;
        }
      }
    }
  }
  return levels;
}

// resident: the level vertices are generated at; levels: what each patch is drawn at.
Mesh draw(const TestWorld& world, int resident, const std::vector<int>& levels) {
  const Surface surface = world.surface();
  std::vector<std::uint16_t> table(index_count(kMaxLevel));
  EXPECT_TRUE(build_index_tables(kMaxLevel, table).ok());
  Mesh mesh;
  for (PatchId p = 0; p < surface.patches.size(); ++p) {
    const std::vector<GpuVertex> vertices = world.vertices(p, resident);
    unsigned lower = 0;
    for (int e = 0; e < 4; ++e) {
      const PatchEdge n = surface.patches[p].neighbour[e];
      if (n.exists() && levels[n.patch()] < levels[p]) lower |= 1u << e;
    }
    IndexRange ranges[kMaxIndexRanges];
    const unsigned skipped = surface.patches[p].collapsed != 0 ? 8u : 0u;
    const int count = index_ranges(levels[p], lower, skipped, ranges);
    for (int r = 0; r < count; ++r) {
      for (std::uint32_t t = 0; t < ranges[r].count; t += 3) {
        Position corner[3];
        for (std::uint32_t k = 0; k < 3; ++k) {
          corner[k] =
              lattice_position(surface.volume_of(p), vertices[table[ranges[r].first + t + k]].position);
        }
        mesh.add(corner[0], corner[1], corner[2]);
      }
    }
  }
  return mesh;
}

void expect_closed(Mesh mesh, const char* what) {
  EXPECT_GT(mesh.triangles, 0u) << what;
  EXPECT_EQ(mesh.count_open(), 0u) << what;
}

TEST(Surface, ClosedAtEveryLevel) {
  Random random{1};
  std::size_t patches = 0;
  std::size_t triangles = 0;
  for (int round = 0; round < 40; ++round) {
    const double wavelength = round % 3 == 0 ? 0.0 : 2.0 + 3.0 * random.unit();
    TestWorld world =
        TestWorld::noise(random.next(), {7 + random.below(4), 7 + random.below(3), 7 + random.below(4)},
                         0.3 + 0.4 * random.unit(), wavelength, true);
    if (world.patches().empty()) continue;
    world.roughen(3, random.next(), 2000);
    patches += world.patches().size();
    for (int level = 1; level <= 3; ++level) {
      Mesh mesh = draw(world, level, std::vector<int>(world.patches().size(), level));
      triangles += mesh.triangles;
      expect_closed(std::move(mesh), "uniform level");
    }
    expect_closed(draw(world, 3, random_levels(world, 3, random)), "random levels");
  }
  std::printf("%zu patches, %zu triangles\n", patches, triangles);
}

// Many small fields of all sizes and densities, with large voxels and single ones.
TEST(Surface, ThousandsOfFieldsAreClosedMeshes) {
  Random random{7};
  std::size_t fields = 0;
  std::size_t triangles = 0;
  for (int round = 0; round < 2000; ++round) {
    const glm::ivec3 extent(4 + random.below(4), 4 + random.below(4), 4 + random.below(4));
    const double wavelength = round % 2 == 0 ? 0.0 : 1.5 + 3.0 * random.unit();
    TestWorld world = TestWorld::noise(random.next(), extent, 0.1 + 0.8 * random.unit(), wavelength, true);
    if (world.patches().empty()) continue;
    world.roughen(2, random.next(), 2500);
    const int level = 1 + round % 2;
    Mesh uniform = draw(world, level, std::vector<int>(world.patches().size(), level));
    triangles += uniform.triangles;
    expect_closed(std::move(uniform), "uniform level");
    expect_closed(draw(world, 2, random_levels(world, 2, random)), "random levels");
    ++fields;
    if (HasFailure()) break;
  }
  std::printf("%zu fields, %zu triangles\n", fields, triangles);
  EXPECT_GT(fields, 1500u);
}

TEST(Surface, ClosedAtFineLevels) {
  Random random{2};
  TestWorld world = TestWorld::noise(random.next(), {6, 6, 6}, 0.5, 0.0, true);
  world.roughen(6, random.next(), 2000);
  for (int level = 4; level <= 6; ++level) {
    expect_closed(draw(world, level, std::vector<int>(world.patches().size(), level)), "uniform level");
  }
  expect_closed(draw(world, 6, random_levels(world, 6, random)), "random levels");
}

// Thousands of fields: without heights, at level 1, on connectivity alone.
TEST(Surface, ThousandsOfFieldsClose) {
  Random random{3};
  for (int round = 0; round < 3000; ++round) {
    const glm::ivec3 extent(4 + random.below(5), 4 + random.below(5), 4 + random.below(5));
    const TestWorld world =
        TestWorld::noise(random.next(), extent, random.unit(), round % 2 == 0 ? 0.0 : 2.5, true);
    const Surface surface = world.surface();
    for (PatchId p = 0; p < surface.patches.size(); ++p) {
      for (int e = 0; e < 4; ++e) {
        const PatchEdge n = surface.patches[p].neighbour[e];
        if (surface.patches[p].collapsed != 0 && e == 3) {
          EXPECT_FALSE(n.exists());
          continue;
        }
        ASSERT_TRUE(n.exists()) << "open edge in a closed field";
        EXPECT_EQ(surface.patches[n.patch()].neighbour[n.edge()], PatchEdge::make(p, e));
      }
    }
  }
}

// Where the world has sides, edges are open exactly on them, half a voxel inside.
TEST(Surface, OpenOnlyAtSides) {
  Random random{4};
  for (int round = 0; round < 50; ++round) {
    const glm::ivec3 extent(8, 9, 7);
    const TestWorld world = TestWorld::noise(random.next(), extent, 0.5, round % 2 == 0 ? 0.0 : 3.0, false);
    const Surface surface = world.surface();
    std::size_t open = 0;
    for (PatchId p = 0; p < surface.patches.size(); ++p) {
      for (int e = 0; e < 4; ++e) {
        if ((surface.patches[p].collapsed != 0 && e == 3) || surface.patches[p].neighbour[e].exists())
          continue;
        ++open;
        const GridLine line = GridLine::along_edge(e, 0, 1, false);
        const glm::dvec3 at = glm::dvec3(patch_origin(surface.volume_of(p))) / 8192.0 +
                              base_point(surface, 1, p, line.i0 + line.di, line.j0 + line.dj).position;
        const bool on_side =
            at.x == 0.5 || at.x == extent.x - 0.5 || at.z == 0.5 || at.z == extent.z - 0.5 || at.y == 0.5;
        EXPECT_TRUE(on_side) << at.x << ' ' << at.y << ' ' << at.z;
      }
    }
    EXPECT_GT(open, 0u);
  }
}

// Every attribute of a vertex is the same bits in all patches that share it.
TEST(Surface, SharedVerticesAreIdentical) {
  Random random{5};
  for (int round = 0; round < 40; ++round) {
    TestWorld world =
        TestWorld::noise(random.next(), {8, 8, 8}, 0.5, round % 2 == 0 ? 0.0 : 3.0, round % 4 < 2);
    const int level = 1 + round % 5;
    world.roughen(level, random.next(), 2500);
    const Surface surface = world.surface();
    std::vector<std::vector<GpuVertex>> vertices;
    for (PatchId p = 0; p < surface.patches.size(); ++p) vertices.push_back(world.vertices(p, level));
    const int n = patch_cells(level);
    const auto same = [&](PatchId p, int i, int j, PatchId q, int k, int l) {
      const GpuVertex& a = vertices[p][static_cast<std::size_t>(vertex_order(level, i, j))];
      const GpuVertex& b = vertices[q][static_cast<std::size_t>(vertex_order(level, k, l))];
      const bool positions = lattice_position(surface.volume_of(p), a.position) ==
                             lattice_position(surface.volume_of(q), b.position);
      const bool morphs =
          lattice_position(surface.volume_of(p), a.morph) == lattice_position(surface.volume_of(q), b.morph);
      return positions && morphs && a.normal == b.normal && a.morph_normal == b.morph_normal;
    };
    for (PatchId p = 0; p < surface.patches.size(); ++p) {
      for (int e = 0; e < 4; ++e) {
        const PatchEdge other = surface.patches[p].neighbour[e];
        if (!other.exists()) continue;
        const GridLine mine = GridLine::along_edge(e, 0, level, false);
        const GridLine theirs = GridLine::along_edge(other.edge(), 0, level, true);
        for (int t = 0; t <= n; ++t) {
          ASSERT_TRUE(same(p, mine.i0 + t * mine.di, mine.j0 + t * mine.dj, other.patch(),
                           theirs.i0 + t * theirs.di, theirs.j0 + t * theirs.dj))
              << "patch " << p << " edge " << e << " t " << t << " level " << level;
        }
      }
      if (surface.patches[p].collapsed != 0) {
        for (int j = 1; j <= n; ++j) {
          const GpuVertex& a = vertices[p][static_cast<std::size_t>(vertex_order(level, 0, 0))];
          const GpuVertex& b = vertices[p][static_cast<std::size_t>(vertex_order(level, 0, j))];
          EXPECT_EQ(a.normal, b.normal);
        }
      }
    }
  }
}

TEST(Surface, CornerFansAreConsistent) {
  Random random{6};
  int most = 0;
  for (int round = 0; round < 100; ++round) {
    const TestWorld world =
        TestWorld::noise(random.next(), {8, 8, 8}, 0.5, round % 2 == 0 ? 0.0 : 3.0, round % 4 < 2);
    const Surface surface = world.surface();
    for (PatchId p = 0; p < surface.patches.size(); ++p) {
      for (int c = 0; c < 4; ++c) {
        PatchCorner fan[kMaxCornerFan];
        const int count = corner_fan(surface.patches, {p, c}, fan);
        most = std::max(most, count);
        ASSERT_LT(count, kMaxCornerFan);
        std::set<std::pair<PatchId, int>> members;
        for (int f = 0; f < count; ++f) members.insert({fan[f].patch, fan[f].corner});
        EXPECT_EQ(members.size(), static_cast<std::size_t>(count));
        // Every member has the same members.
        PatchCorner other[kMaxCornerFan];
        ASSERT_EQ(corner_fan(surface.patches, fan[count - 1], other), count);
        for (int f = 0; f < count; ++f) EXPECT_TRUE(members.count({other[f].patch, other[f].corner}) == 1);
      }
    }
  }
  std::printf("most patches around a corner: %d\n", most);
}

}  // namespace
}  // namespace karst::core
