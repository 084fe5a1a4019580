// SPDX-License-Identifier: MIT
// Grounds with a region in frames at random: the stated bound in pixels against how far what is drawn is from
// the full surface, of patches, of nodes and of the ground that stands for the region; and that nothing pops
// where nodes or levels switch under a camera that stands still.
//
// KARST_REGION_POSES sets how many frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include <glm/geometric.hpp>

#include "tests/support/any_camera.h"
#include "tests/support/ground_frame.h"
#include "tests/support/memory_ground.h"
#include "tests/support/morph_scene.h"

namespace karst::core {
namespace {

using test::DrawnNode;
using test::MemoryGround;
using test::Parts;

constexpr glm::ivec2 kSizePx{640, 360};
constexpr int kLattice = 1;                  // a node of size 0 is two voxels wide
constexpr double kSteps = 2048 << kLattice;  // between samples
constexpr int kFirst[2] = {9, 7};            // node of the region

std::uint64_t poses_wanted() {
  const char* const set = std::getenv("KARST_REGION_POSES");
  return set == nullptr ? 600 : std::strtoull(set, nullptr, 10);
}

// Hills, and a region in them whose voxels are filled up to the same height, roughly.
struct RegionWorld {
  explicit RegionWorld(Random& random)
      : extent{2 * (3 + random.below(9)) + 1, 26, 2 * (3 + random.below(9)) + 1},
        samples{4 * (kFirst[0] + extent.x / 2 + 4 + random.below(20)) + 2,
                4 * (kFirst[1] + extent.z / 2 + 4 + random.below(20)) + 2} {
    for (auto& w : waves) {
      const double length = std::exp2(between(random, 2, 5)), turn = between(random, 0, 6.28);
      w = glm::dvec3{std::cos(turn) * 6.28 / length, std::sin(turn) * 6.28 / length,
                     length * std::exp2(between(random, -7, -3.5))};
    }
    const std::uint64_t seed = random.next();
    const double rough = std::exp2(between(random, 0, 9));
    TestWorld voxels(
        extent, [this](glm::ivec3 v) { return v.y + 0.5 < height(v.x + 0.5, v.z + 0.5); }, true);
    voxels.set_heights(1 + random.below(3),
                       [=](glm::dvec3 p) { return rough * test::value_noise(seed, 2.0 * p); });
    scene = std::make_unique<Scene>(voxels);
    const auto sample = [this](std::int64_t i, std::int64_t k) {
      // Of the lattice of nodes of size 0: nothing is rounded there.
      const double wanted =
          height(0.5 + 0.5 * double(i) - 2 * kFirst[0], 0.5 + 0.5 * double(k) - 2 * kFirst[1]);
      return static_cast<std::int32_t>(wanted * (kStepsPerVoxel / kVertexStep >> kLattice)) << kLattice;
    };
    for (int k = 0; k < samples[1]; ++k) {
      for (int i = 0; i < samples[0]; ++i) heights.push_back(sample(i, k));
    }
    corner = {(0.5 - 2 * kFirst[0]) * kStepsPerVoxel, (0.5 - 2 * kFirst[1]) * kStepsPerVoxel};
    // As it is measured when it is baked: above each of its vertices.
    RegionMeasure measure{0, kStepsPerVoxel * glm::length(glm::dvec3(extent))};
    each_full_point({}, [&](glm::dvec3 place) {
      measure.error = std::max(measure.error, std::abs(place.y - full_height(place.x, place.z)));
    });
    error = measure.error;
    ground = std::make_unique<MemoryGround>(
        samples[0], samples[1], kSteps, kSteps, sample,
        std::vector<test::MemoryRegion>{{extent.x, extent.z, kFirst[0], kFirst[1], measure, extent.y, 0}});
  }
  RegionWorld(const RegionWorld&) = delete;

  // Voxels, of a place in them from the region's corner.
  double height(double x, double z) const {
    double h = 11;
    for (const auto& w : waves) h += w[2] * std::sin(w[0] * x + w[1] * z);
    return std::clamp(h, 3.0, 21.0);
  }

  // Of the region's full surface, lattice steps from a camera's voxel.
  template <class Take>
  void each_full_point(const Camera& camera, const Take& take) const {
    std::vector<glm::dvec3> points;
    for (PatchId p = 0; p < scene->drawn.patches(); ++p) {
      scene->drawn.full_points(p, camera, points);
      for (const glm::dvec3& place : points) take(place);
    }
  }

  // Of the ground's full surface, as its nodes of size 0 have it; lattice steps.
  double full_height(double x, double z) const {
    const double fx = std::clamp((x - corner[0]) / kSteps, 0.0, samples[0] - 1.001);
    const double fz = std::clamp((z - corner[1]) / kSteps, 0.0, samples[1] - 1.001);
    const int i = static_cast<int>(fx), k = static_cast<int>(fz);
    const double u = fx - i, v = fz - k;
    const auto h = [&](int a, int b) {
      return double{kVertexStep} * heights[static_cast<std::size_t>((k + b) * samples[0] + i + a)];
    };
    if ((i + k) % 2 == 0) {
      return u > v ? h(0, 0) + u * (h(1, 0) - h(0, 0)) + v * (h(1, 1) - h(1, 0))
                   : h(0, 0) + v * (h(0, 1) - h(0, 0)) + u * (h(1, 1) - h(0, 1));
    }
    return u + v < 1 ? h(0, 0) + u * (h(1, 0) - h(0, 0)) + v * (h(0, 1) - h(0, 0))
                     : h(1, 1) + (1 - u) * (h(0, 1) - h(1, 1)) + (1 - v) * (h(1, 0) - h(1, 1));
  }

  glm::ivec3 extent;
  glm::ivec2 samples;
  std::array<glm::dvec3, 5> waves{};
  std::vector<std::int32_t> heights;
  glm::dvec2 corner{0.0};  // the ground's, lattice steps
  double error = 0;        // RegionMeasure's
  std::unique_ptr<Scene> scene;
  std::unique_ptr<MemoryGround> ground;
};

// What was selected of nodes: kept, for a camera of another place.
struct Chosen {
  struct Item {
    DrawItem item;
    GroundView::Node node;
  };
  std::vector<Item> items;
  std::vector<std::uint16_t> rows;
  std::uint32_t regions = 0;
  double bound_px = 0;
  std::uint32_t refused = 0;

  // By nodes and how they meet.
  bool same_as(const Chosen& other) const {
    return regions == other.regions && std::equal(items.begin(), items.end(), other.items.begin(),
                                                  other.items.end(), [](const Item& a, const Item& b) {
                                                    return a.node.key == b.node.key &&
                                                           a.item.lower_edges == b.item.lower_edges;
                                                  });
  }
};

// Selects with all tiles there, or with as many as rounds bring.
Chosen choose(const RegionWorld& world, Parts& parts, const GroundRequest& request, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    parts.tiles.begin_frame();
    parts.pool.begin_frame();
    parts.tiles.poll();
    parts.view.select(world.ground->info(), request, parts.tiles, parts.pool);
    parts.tiles.ask();
    if (parts.view.result().lacks_tile == 0) break;
  }
  for (MorphRows rows; !(rows = parts.view.take_rows()).halves.empty();) {
    std::copy(rows.halves.begin(), rows.halves.end(),
              parts.rows.begin() + static_cast<std::ptrdiff_t>(rows.first_row) * kMorphRow);
  }
  Chosen chosen;
  for (std::size_t n = 0; n < parts.view.items().size(); ++n)
    chosen.items.push_back({parts.view.items()[n], parts.view.node_of(n)});
  chosen.rows = parts.rows;
  chosen.regions = parts.view.result().regions;
  chosen.bound_px = double{parts.view.result().bound_px};
  chosen.refused = parts.view.result().refused;
  return chosen;
}

// The triangles of nodes as a camera sees them, to be asked for heights.
class NodeSurface {
 public:
  using Triangle = std::array<glm::dvec3, 3>;  // lattice steps from the world's corner

  NodeSurface() : table_(index_count(kNodeLevel)), entries_(kMorphEntries) {
    build_family_entries(entries_);
    EXPECT_TRUE(build_index_tables(kNodeLevel, table_).ok());
  }

  void draw(const RegionWorld& world, const Camera& camera, const ErrorScale& scale, const Chosen& chosen) {
    triangles_.clear();
    nodes_.clear();
    const glm::dvec3 voxel = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
    for (const Chosen::Item& at : chosen.items) {
      const NodeKey key = at.node.key;
      const DrawnNode drawn(world.ground->info(), camera, scale, at.node, entries_, chosen.rows,
                            key == world.ground->root());
      const std::size_t first = triangles_.size();
      DrawItem item = at.item;
      item.walls = 0;
      test::for_each_triangle(item, table_, [&](const std::uint16_t* corners) {
        Triangle triangle;
        for (std::size_t c = 0; c < 3; ++c) triangle[c] = voxel + glm::dvec3(drawn.place(corners[c]));
        triangles_.push_back(triangle);
      });
      nodes_[{key.size, key.x, key.z}] = {first, triangles_.size()};
    }
  }
  const std::vector<Triangle>& triangles() const { return triangles_; }

  // False: no node is drawn there.
  bool height(const RegionWorld& world, double x, double z, double& height) const {
    const double fx = (x - world.corner[0]) / (4 * kSteps), fz = (z - world.corner[1]) / (4 * kSteps);
    double inmost = -1e30;
    for (int size = 0; size <= world.ground->info().top_size(); ++size) {
      const double side = std::ldexp(1.0, size);
      const auto found = nodes_.find(
          {size, static_cast<int>(std::floor(fx / side)), static_cast<int>(std::floor(fz / side))});
      if (found == nodes_.end()) continue;
      // That which has the place in it, or nearly: places are rounded.
      for (std::size_t t = found->second.first; t < found->second.second; ++t) {
        const auto& [a, b, c] = triangles_[t];
        const double area = (b.x - a.x) * (c.z - a.z) - (c.x - a.x) * (b.z - a.z);
        if (std::abs(area) < 1) continue;
        const double v = ((x - a.x) * (c.z - a.z) - (c.x - a.x) * (z - a.z)) / area;
        const double w = ((b.x - a.x) * (z - a.z) - (x - a.x) * (b.z - a.z)) / area;
        const double in = std::min({v, w, 1 - v - w});
        if (in <= inmost) continue;
        inmost = in;
        height = a.y + v * (b.y - a.y) + w * (c.y - a.y);
      }
    }
    return inmost > -0.01;
  }

 private:
  std::vector<std::uint16_t> table_;
  std::vector<std::uint8_t> entries_;
  std::vector<Triangle> triangles_;
  std::map<std::tuple<int, int, int>, std::pair<std::size_t, std::size_t>> nodes_;
};

// Of two places, lattice steps from the world's corner, in the picture; less than 0: not seen.
double pixels_between(const Camera& camera, const glm::dmat4& clip, glm::dvec3 a, glm::dvec3 b) {
  const glm::dvec3 voxel = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
  const glm::dvec4 p = clip * glm::dvec4(a - voxel, 1), q = clip * glm::dvec4(b - voxel, 1);
  if (!(p.w > 0 && q.w > 0 && p.z >= -p.w && q.z >= -q.w)) return -1;
  if (std::abs(p.x) > p.w || std::abs(p.y) > p.w) return -1;
  return std::hypot((p.x / p.w - q.x / q.w) * kSizePx.x / 2, (p.y / p.w - q.y / q.w) * kSizePx.y / 2);
}

glm::dvec3 somewhere(Random& random, const RegionWorld& world) {
  glm::dvec3 place(between(random, -3, world.extent.x + 3), 0, between(random, -3, world.extent.z + 3));
  place.y = world.height(place.x, place.z);
  return place;
}

TEST(RegionSurface, NoDrawnPointIsFurtherFromTheFullSurfaceThanStated) {
  Random random{20261130};
  NodeSurface surface;
  const std::uint64_t wanted = poses_wanted();
  std::uint64_t frames = 0, with_region = 0, points = 0, region_points = 0, refused = 0;
  Deviation patches;
  double most_nodes = 0, most_for_region = 0;
  while (frames < wanted) {
    RegionWorld world(random);
    Scene& scene = *world.scene;
    const bool few = random.below(2) == 0;
    Parts parts(static_cast<std::uint32_t>(world.ground->tile_count()) + 1,
                few ? 12 + static_cast<std::uint32_t>(random.below(40)) : 4000);
    MemoryGround::Source source(*world.ground);
    parts.tiles.reset(source.source(), world.ground->root(), world.ground->tile(world.ground->root()));
    parts.view.reset();
    for (int n = 0; n < 20; ++n, ++frames) {
      Camera camera;
      const auto kind = test::kAnyProjections[random.next() % std::size(test::kAnyProjections)];
      CameraMatrices matrices = test::any_matrices(random, kind, 0.02, 512);
      // Where families are few, from near by: there the region is closed for want of them.
      const double farthest = few ? 6 : 10;
      test::show(random, somewhere(random, world), std::exp2(between(random, -1, farthest)), matrices);
      if (!make_camera(matrices, camera).ok()) continue;
      GroundRequest request;
      request.camera = &camera;
      request.error_px = std::exp2(between(random, -1, 5));
      SelectLod::Result selected = scene.select(camera, kSizePx, request.error_px, scene.drawn.level());
      request.scale = scene.scale;
      request.regions = 1;
      if (random.below(2) == 0) {
        LodSettings settings;
        settings.error_px = request.error_px;
        settings.max_level = settings.resident_level = scene.drawn.level();
        std::vector<LackingPatch> lacking(scene.levels.size());
        selected = scene.select_held(settings, camera, nullptr, random_held(random, scene, 0), lacking);
      }
      const Chosen chosen = choose(world, parts, request, 12);
      refused += chosen.refused;
      surface.draw(world, camera, request.scale, chosen);
      const glm::dmat4 clip = glm::dmat4(clip_from_lattice(camera));
      double stated = chosen.bound_px;
      if (chosen.regions != 0) {
        ++with_region;
        stated = std::max(stated, double{selected.bound_px});
        measure_deviation(scene, camera, kSizePx, stated, patches);
        ASSERT_LE(patches.of_bound, 1.0) << "frame " << frames;
      }
      for (const NodeSurface::Triangle& triangle : surface.triangles()) {
        double a = random.unit(), b = random.unit();
        if (a + b > 1) a = 1 - a, b = 1 - b;
        const glm::dvec3 place = triangle[0] * (1 - a - b) + triangle[1] * a + triangle[2] * b;
        const glm::dvec3 full(place.x, world.full_height(place.x, place.z), place.z);
        const double px = pixels_between(camera, clip, place, full);
        if (px < 0) continue;
        ++points;
        most_nodes = std::max(most_nodes, px / stated);
        ASSERT_LE(px, stated) << "frame " << frames;
      }
      if (chosen.regions != 0) continue;
      // The ground in the region's place.
      Camera at_corner = camera;
      at_corner.voxel = glm::ivec3(0);
      int turn = random.below(16);
      world.each_full_point(at_corner, [&](glm::dvec3 full) {
        if (++turn % 16 != 0) return;
        glm::dvec3 drawn = full;
        if (!surface.height(world, full.x, full.z, drawn.y)) return;
        const double px = pixels_between(camera, clip, drawn, full);
        if (px < 0) return;
        ++region_points;
        most_for_region = std::max(most_for_region, px / stated);
      });
    }
  }
  std::printf(
      "FIGURE %llu frames, %llu with the region; of the stated bound at most %.3f at %zu points of patches, "
      "%.3f at %llu of nodes, %.3f at %llu of the ground that stands for the region; %llu splits refused\n",
      static_cast<unsigned long long>(frames), static_cast<unsigned long long>(with_region), patches.of_bound,
      patches.samples, most_nodes, static_cast<unsigned long long>(points), most_for_region,
      static_cast<unsigned long long>(region_points), static_cast<unsigned long long>(refused));
  EXPECT_GT(with_region, frames / 8);
  EXPECT_LT(with_region, frames / 8 * 7);
  EXPECT_GT(patches.of_bound, 0.3);
  EXPECT_GT(most_nodes, 0.3);
  EXPECT_GT(most_for_region, 0.3);
  // The ground's own deviation, and how far the region is from the ground.
  EXPECT_LE(most_for_region, 2.0);
  EXPECT_GT(refused, 0u);
}

// The eye moves along a line; where nodes or levels are others at its ends, two places next to each other are
// found between which they change. From either, both choices show the same, but where the region takes the
// ground's place or gives it back: that is seen, within the two's bounds.
TEST(RegionSurface, NothingPopsWhereNodesOrLevelsSwitch) {
  Random random{20261201};
  NodeSurface surface[2];
  const std::uint64_t wanted = poses_wanted() / 2;
  std::uint64_t lines = 0, switches = 0, with_region = 0, levels_switched = 0, swaps = 0;
  double most = 0;
  while (lines < wanted) {
    RegionWorld world(random);
    Scene& scene = *world.scene;
    Parts parts(static_cast<std::uint32_t>(world.ground->tile_count()) + 1, 4000);
    MemoryGround::Source source(*world.ground);
    parts.tiles.reset(source.source(), world.ground->root(), world.ground->tile(world.ground->root()));
    parts.view.reset();
    for (int n = 0; n < 20; ++n, ++lines) {
      const auto kind = test::kAnyProjections[random.next() % std::size(test::kAnyProjections)];
      CameraMatrices start = test::any_matrices(random, kind, 0.02, 512);
      test::show(random, somewhere(random, world), std::exp2(between(random, -1, 7)), start);
      const glm::dvec3 way = std::exp2(between(random, -4, 2)) * direction(random);
      const auto look = [&](double t) {
        CameraMatrices matrices = start;
        matrices.position += t * way;
        return test::camera_of(matrices);
      };
      const double error_px = std::exp2(between(random, -1, 4));
      scene.select(look(0), kSizePx, error_px, scene.drawn.level());
      struct State {
        Chosen nodes;
        std::vector<std::uint8_t> levels;
        bool operator==(const State& other) const {
          return nodes.same_as(other.nodes) && levels == other.levels;
        }
      };
      const auto state_at = [&](double t) {
        State state;
        state.levels.resize(scene.levels.size());
        const Camera camera = look(t);
        scene.select_again(camera, error_px, scene.drawn.level(), nullptr, state.levels);
        GroundRequest request;
        request.camera = &camera;
        request.error_px = error_px;
        request.scale = scene.scale;
        request.regions = 1;
        request.culls = false;
        state.nodes = choose(world, parts, request, 40);
        return state;
      };
      State low = state_at(0), high = state_at(1);
      if (low == high) continue;
      double t_low = 0, t_high = 1;
      while (t_high - t_low > 1e-12) {
        const double t = 0.5 * (t_low + t_high);
        State middle = state_at(t);
        (middle == low ? t_low : t_high) = t;
        if (t == t_high) high = std::move(middle);
      }
      ASSERT_EQ(low.nodes.refused + high.nodes.refused, 0u);
      ++switches;
      if (low.nodes.regions != high.nodes.regions) {
        ++swaps;
        continue;
      }
      with_region += low.nodes.regions;
      for (const double t : {t_low, t_high}) {
        const Camera camera = look(t);
        if (low.nodes.regions != 0) {
          most = std::max(most, largest_step(scene, camera, kSizePx, low.levels, high.levels));
          levels_switched += low.levels != high.levels ? 1u : 0u;
        }
        surface[0].draw(world, camera, scene.scale, low.nodes);
        surface[1].draw(world, camera, scene.scale, high.nodes);
        const glm::dmat4 clip = glm::dmat4(clip_from_lattice(camera));
        for (int from = 0; from < 2; ++from) {
          for (const NodeSurface::Triangle& triangle : surface[from].triangles()) {
            const double a = random.unit(), b = (1 - a) * random.unit();
            const glm::dvec3 place = triangle[0] * (1 - a - b) + triangle[1] * a + triangle[2] * b;
            glm::dvec3 other = place;
            ASSERT_TRUE(surface[1 - from].height(world, place.x, place.z, other.y));
            const double px = pixels_between(camera, clip, place, other);
            if (px >= 0) most = std::max(most, px);
          }
        }
      }
    }
  }
  std::printf(
      "FIGURE %llu lines, %llu of them with a switch, %llu with the region drawn, %llu of its levels: at "
      "most "
      "%.2g px; it took the ground's place in %llu\n",
      static_cast<unsigned long long>(lines), static_cast<unsigned long long>(switches),
      static_cast<unsigned long long>(with_region), static_cast<unsigned long long>(levels_switched / 2),
      most, static_cast<unsigned long long>(swaps));
  EXPECT_GT(with_region, 30u);
  EXPECT_GT(levels_switched, 20u);
  EXPECT_LE(most, 0.01);
}

}  // namespace
}  // namespace karst::core
