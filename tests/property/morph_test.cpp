// SPDX-License-Identifier: MIT
// Morphing levels of detail as the GPU draws them, over random poses near, far and in the middle of a morph:
// levels switch without a visible step, and patches meet without a crack. error_bound_test.cpp has the bound.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/draw/index_batches.h"
#include "terrain/patch/displacement.h"
#include "tests/support/morph_scene.h"

namespace karst::core {
namespace {

// Levels follow from thresholds alone: neighbours never have to be raised, and culling does not change them.
TEST(Morph, NeighboursAreOneLevelApartOnTheirOwn) {
  Random random{103};
  std::array<std::size_t, kMaxLevel + 1> at_level{};
  std::size_t steps = 0;
  for (int round = 0; round < 24; ++round) {
    Scene scene(random, 1 + round % kMaxLevel, kAllRoughness[static_cast<std::size_t>(round % 4)]);
    std::vector<std::uint8_t> culled(scene.levels.size(), 99);
    for (int n = 0; n < 300; ++n) {
      const Pose pose = random_pose(random, scene);
      const Camera camera = camera_of(pose.camera);
      const int top = n % 4 == 0 ? 1 + random.below(scene.drawn.level()) : scene.drawn.level();
      scene.select(camera, pose.size_px, pose.error_px, top);
      const Frustum frustum = make_frustum(camera);
      scene.select_again(camera, pose.error_px, top, &frustum, culled);
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
        const bool in_view = classify(frustum, scene.box(p), kAllPlanes) != kOutside;
        if (in_view) {
          ASSERT_EQ(culled[p], scene.levels[p]);
        }
        ++at_level[scene.levels[p]];
        for (const PatchEdge e : scene.drawn.surface().patches[p].neighbour) {
          if (!e.exists()) continue;
          ASSERT_LE(std::abs(scene.levels[p] - scene.levels[e.patch()]), 1);
          steps += scene.levels[p] != scene.levels[e.patch()] ? 1u : 0u;
          if (in_view) {
            ASSERT_EQ(culled[e.patch()], scene.levels[e.patch()]);
          }
        }
      }
    }
  }
  std::printf("patches at levels 1 to 6:");
  for (int m = 1; m <= kMaxLevel; ++m) std::printf(" %zu", at_level[static_cast<std::size_t>(m)]);
  std::printf("; %zu edges between levels\n", steps / 2);
  EXPECT_GT(steps, 10'000u);
}

// --- popping

// The camera flies along a line; where levels change between two places, the two are brought together until
// they are next to each other on the lattice of camera places. Then the camera is frozen and only the levels
// switch.
TEST(Morph, SwitchesDoNotPop) {
  Random random{104};
  for (const Roughness roughness : kAllRoughness) {
    double most = 0;
    std::size_t switches = 0;
    for (int round = 0; round < 4; ++round) {
      Scene scene(random, 3 + round % 3, roughness);
      for (int n = 0; n < 150; ++n) {
        Pose pose = random_pose(random, scene);
        const glm::dvec3 from = pose.camera.position;
        const glm::dvec3 to = from + std::exp2(between(random, -5, 3)) * direction(random);
        const double yaw = pose.camera.yaw_deg;
        const double turn = random.below(2) == 0 ? 0.0 : between(random, -40, 40);
        const auto look = [&](double t) {
          pose.camera.position = glm::mix(from, to, t);
          pose.camera.yaw_deg = yaw + turn * t;
          return camera_of(pose.camera);
        };
        const Camera start = look(0);
        scene.select(start, pose.size_px, pose.error_px, scene.drawn.level());
        std::vector<std::uint8_t> low(scene.levels);
        std::vector<std::uint8_t> middle(scene.levels.size());
        std::vector<std::uint8_t> high(scene.levels.size());
        double t_low = 0;
        double t_high = 1;
        scene.select_again(look(1), pose.error_px, scene.drawn.level(), nullptr, high);
        if (low == high) continue;
        while (t_high - t_low > 1e-12) {
          const double t = 0.5 * (t_low + t_high);
          scene.select_again(look(t), pose.error_px, scene.drawn.level(), nullptr, middle);
          if (middle == low) {
            t_low = t;
          } else {
            t_high = t;
            high = middle;
          }
        }
        for (PatchId p = 0; p < low.size(); ++p) switches += low[p] != high[p] ? 1u : 0u;
        for (const double t : {t_low, t_high})
          most = std::max(most, largest_step(scene, look(t), pose.size_px, low, high));
      }
    }
    std::printf("%-6s %zu patches switched: at most %.2g px\n", kRoughnessNames[static_cast<int>(roughness)],
                switches, most);
    EXPECT_GT(switches, 50u);
    EXPECT_LE(most, 0.01);
  }
}

// --- cracks

using Bits = std::array<std::uint32_t, 3>;

Bits bits_of(glm::vec3 v) {
  // Adding 0 makes a negative zero positive.
  return {std::bit_cast<std::uint32_t>(v.x + 0.0f), std::bit_cast<std::uint32_t>(v.y + 0.0f),
          std::bit_cast<std::uint32_t>(v.z + 0.0f)};
}

std::uint64_t hash_of(glm::vec3 v) {
  const Bits bits = bits_of(v);
  return test::mix(bits[0] ^ test::mix(bits[1] ^ test::mix(bits[2])));
}

// A sum over the edges of all drawn triangles, by the bits of their ends, in which an edge and its reverse
// cancel: 0 for a closed world, and anything else, with a chance of 2^-64 of being 0, where there is a crack
// or a T-junction.
std::uint64_t sum_of_edges(const Scene& scene, const Camera& camera, std::span<const std::uint16_t> table,
                           std::size_t& triangles) {
  std::uint64_t sum = 0;
  std::vector<std::uint64_t> vertex;
  for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
    const int level = scene.levels[p];
    vertex.clear();
    for (const glm::vec3& v : scene.moved(p, level, camera)) vertex.push_back(hash_of(v));
    IndexRange ranges[kMaxIndexRanges];
    const unsigned skipped = scene.drawn.surface().patches[p].collapsed != 0 ? 8u : 0u;
    const int count = index_ranges(level, scene.lower_edges(p, scene.levels), skipped, ranges);
    for (int r = 0; r < count; ++r) {
      triangles += ranges[r].count / 3;
      for (std::uint32_t t = 0; t < ranges[r].count; t += 3) {
        const std::uint16_t* const index = table.data() + ranges[r].first + t;
        for (int k = 0; k < 3; ++k) {
          const std::uint64_t from = vertex[index[k]];
          const std::uint64_t to = vertex[index[(k + 1) % 3]];
          sum += test::mix(from + 3 * to) - test::mix(to + 3 * from);
        }
      }
    }
  }
  return sum;
}

TEST(Morph, MovingPatchesMeetWithoutCracks) {
  Random random{105};
  std::vector<std::uint16_t> table(index_count(kMaxLevel));
  ASSERT_TRUE(build_index_tables(kMaxLevel, table).ok());
  std::size_t triangles = 0;
  std::size_t steps = 0;
  for (int round = 0; round < 24; ++round) {
    Scene scene(random, 2 + round % 4, kAllRoughness[static_cast<std::size_t>(1 + round % 3)]);
    for (int n = 0; n < 40; ++n) {
      const Pose pose = random_pose(random, scene);
      const Camera camera = camera_of(pose.camera);
      scene.select(camera, pose.size_px, pose.error_px, scene.drawn.level());
      ASSERT_EQ(sum_of_edges(scene, camera, table, triangles), 0u) << "pose " << n << " of round " << round;
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
        steps += scene.lower_edges(p, scene.levels) != 0 ? 1u : 0u;
      }
      LodSettings settings;
      settings.error_px = pose.error_px;
      settings.max_level = settings.resident_level = scene.drawn.level();
      scene.select_held(settings, camera, nullptr, random_held(random, scene, 0.0), {});
      ASSERT_EQ(sum_of_edges(scene, camera, table, triangles), 0u) << "held, pose " << n << " of " << round;
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
        steps += scene.lower_edges(p, scene.levels) != 0 ? 1u : 0u;
      }
    }
  }
  std::printf("%zu triangles, %zu patches beside coarser ones\n", triangles, steps);
  EXPECT_GT(steps, 1'000u);
}

// All vertices on a shared edge, drawn or not, are the same bits seen from both sides.
TEST(Morph, SharedVerticesMoveAlike) {
  Random random{106};
  std::size_t moving = 0;
  for (int round = 0; round < 8; ++round) {
    Scene scene(random, 3 + round % 3, kAllRoughness[static_cast<std::size_t>(round % 4)]);
    const int level = scene.drawn.level();
    const int n = patch_cells(level);
    for (int k = 0; k < 20; ++k) {
      const Pose pose = random_pose(random, scene);
      const Camera camera = camera_of(pose.camera);
      scene.select(camera, pose.size_px, pose.error_px, level);
      std::vector<std::vector<glm::vec3>> moved;
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) moved.push_back(scene.moved(p, level, camera));
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
        for (int e = 0; e < 4; ++e) {
          const PatchEdge other = scene.drawn.surface().patches[p].neighbour[e];
          if (!other.exists()) continue;
          const GridLine mine = GridLine::along_edge(e, 0, level, false);
          const GridLine theirs = GridLine::along_edge(other.edge(), 0, level, true);
          for (int t = 0; t <= n; ++t) {
            const auto a =
                static_cast<std::size_t>(vertex_order(level, mine.i0 + t * mine.di, mine.j0 + t * mine.dj));
            const auto b = static_cast<std::size_t>(
                vertex_order(level, theirs.i0 + t * theirs.di, theirs.j0 + t * theirs.dj));
            ASSERT_EQ(bits_of(moved[p][a]), bits_of(moved[other.patch()][b]));
            const GpuVertex& g = scene.drawn.vertices(p)[a];
            moving += g.position[0] != g.morph[0] || g.position[1] != g.morph[1] ? 1u : 0u;
          }
        }
      }
    }
  }
  EXPECT_GT(moving, 100'000u);
}

}  // namespace
}  // namespace karst::core
