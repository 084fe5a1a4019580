// SPDX-License-Identifier: MIT
// Frames of the ground by the thousand: random grounds, cameras, thresholds, tiles that come late or fail,
// pools that are too small. In every frame each inner edge is used once by each of its two sides, with the
// same bits of the places that are drawn, and nothing calls the heap.
//
// KARST_GROUND_FRAMES sets how many frames, KARST_GROUND_SEED which ones.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/base/storage_plan.h"
#include "terrain/draw/index_batches.h"
#include "terrain/draw/wall_indices.h"
#include "terrain/ground/ground_box.h"
#include "terrain/nodes/ground_view.h"
#include "terrain/nodes/make_node.h"
#include "terrain/nodes/node_place.h"
#include "tests/support/any_camera.h"
#include "tests/support/ground_frame.h"
#include "tests/support/heap_count.h"
#include "tests/support/memory_ground.h"

namespace karst::core {
namespace {

using test::DrawnNode;
using test::for_each_triangle;
using test::FrameEdges;
using test::MemoryGround;
using test::Parts;
using test::Random;

std::uint64_t frames_wanted() {
  const char* const set = std::getenv("KARST_GROUND_FRAMES");
  return set == nullptr ? 400 : std::strtoull(set, nullptr, 10);
}

std::uint64_t seed() {
  const char* const set = std::getenv("KARST_GROUND_SEED");
  return set == nullptr ? 20261127 : std::strtoull(set, nullptr, 10);
}

struct Totals {
  std::uint64_t frames = 0, edges = 0, nodes = 0, coarser = 0, refused = 0, moving = 0, rim = 0;
};

// All that is drawn of a frame, edge by edge.
void check_frame(const MemoryGround& ground, const GroundRequest& request, const Parts& parts,
                 std::span<const std::uint8_t> entries, std::span<const std::uint16_t> table,
                 FrameEdges& edges, Totals& totals) {
  edges.clear();
  const Camera& camera = *request.camera;
  for (std::size_t n = 0; n < parts.view.items().size(); ++n) {
    const DrawItem& item = parts.view.items()[n];
    const GroundView::Node& node = parts.view.node_of(n);
    const bool is_root = node.key == ground.root();
    const DrawnNode drawn(ground.info(), camera, request.scale, node, entries, parts.rows, is_root);
    totals.moving += static_cast<std::uint64_t>(drawn.moving());
    totals.coarser += item.lower_edges != 0 ? 1 : 0;
    const std::uint32_t first = drawn.add_to(edges);
    for_each_triangle(item, table, [&](const std::uint16_t* corners) { edges.use_triangle(corners, first); });
  }
  totals.nodes += parts.view.items().size();
  Camera at_voxel = camera;
  at_voxel.voxel = glm::ivec3(0);
  const Frustum frustum = make_frustum(at_voxel);
  const glm::dvec3 corner = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
  const double end[2] = {
      double(sample_place(ground.info().steps[0], ground.info().samples[0] - 1) * kVertexStep),
      double(sample_place(ground.info().steps[1], ground.info().samples[1] - 1) * kVertexStep)};
  const double foot = double(ground.info().low) * kVertexStep;
  const double slack = std::ldexp(4.0, ground.info().top_size());
  totals.edges += edges.count();
  edges.for_each_open([&](const FrameEdges::Edge& edge) {
    const glm::dvec3 a = glm::dvec3(edge.from) + corner;
    const glm::dvec3 b = glm::dvec3(edge.to) + corner;
    // Where the walls end, or what is in view.
    const bool at_foot = std::abs(a.y - foot) <= slack && std::abs(b.y - foot) <= slack;
    bool out_of_view = false;
    for (const Plane& plane : frustum.planes) {
      out_of_view =
          out_of_view || (request.culls && glm::dot(plane.normal, edge.from) + plane.offset < 0.0f &&
                          glm::dot(plane.normal, edge.to) + plane.offset < 0.0f);
    }
    // Beyond the last sample quads have no area, and walls none where the ground is lowest: their sides lie
    // on each other.
    const bool at_end = std::max(a.x, b.x) >= end[0] - slack || std::max(a.z, b.z) >= end[1] - slack;
    const bool at_lowest = std::min(a.y, b.y) <= foot + slack;
    if (edge.times == edge.back && (at_end || at_lowest)) return;
    totals.rim += 1;
    if (test::has_wall_behind(ground.info(), request, a, b)) return;
    if (at_foot || out_of_view || testing::Test::HasFatalFailure()) return;
    FAIL() << "an edge from " << a.x << ' ' << a.y << ' ' << a.z << " to " << b.x << ' ' << b.y << ' ' << b.z
           << " is used " << edge.times << " times, the other way " << edge.back << " times";
  });
}

TEST(Ground, EveryInnerEdgeIsUsedOnceByEachSide) {
  std::vector<std::uint8_t> entries(kMorphEntries, 0);
  build_family_entries(entries);
  std::vector<std::uint16_t> table(index_count(kNodeLevel));
  ASSERT_TRUE(build_index_tables(kNodeLevel, table).ok());
  Random random{seed()};
  Totals totals;
  FrameEdges edges;
  const std::uint64_t frames = frames_wanted();
  while (totals.frames < frames) {
    test::show_progress(totals.frames, frames);
    const auto wide = static_cast<std::int64_t>(test::between(random, 2, 260));
    const auto deep = static_cast<std::int64_t>(test::between(random, 2, 260));
    const double rough = std::exp2(test::between(random, 0, 11));
    std::vector<std::int32_t> heights(static_cast<std::size_t>(wide * deep));
    for (std::int32_t& h : heights) h = static_cast<std::int32_t>(test::between(random, -rough, rough));
    const double errors = std::exp2(test::between(random, 0, 9));
    const MemoryGround ground(
        wide, deep, test::between(random, 0, 1) < 0.5 ? 2048 : test::between(random, 700, 2048),
        test::between(random, 700, 2048),
        [&](std::int64_t i, std::int64_t k) { return heights[static_cast<std::size_t>(k * wide + i)]; },
        [&](NodeKey key) {
          return static_cast<float>(test::between(random, 0, 1) < 0.3
                                        ? 0.0
                                        : errors * std::exp2(key.size) * test::between(random, 0, 2));
        });
    Parts parts(static_cast<std::uint32_t>(ground.tile_count()) + 1,
                static_cast<std::uint32_t>(test::between(random, 3, 1500)));
    MemoryGround::Source source(ground);
    source.comes = test::between(random, 0.05, 1);
    source.fails = test::between(random, 0, 0.3);
    parts.tiles.reset(source.source(), ground.root(), ground.tile(ground.root()));
    parts.view.reset();
    const double size_voxels = double(std::max(wide, deep)) * 2048 / kStepsPerVoxel;
    for (int frame = 0; frame < 20; ++frame, ++totals.frames) {
      Camera camera;
      const auto kind = test::kAnyProjections[random.next() % std::size(test::kAnyProjections)];
      CameraMatrices matrices = test::any_matrices(random, kind, 0.01, size_voxels);
      test::show(random,
                 {test::between(random, 0, double(wide) * 0.25), test::between(random, -0.2, 0.2),
                  test::between(random, 0, double(deep) * 0.25)},
                 std::exp2(test::between(random, -3, 7)), matrices);
      if (!make_camera(matrices, camera).ok()) continue;
      GroundRequest request;
      request.camera = &camera;
      request.error_px = std::exp2(test::between(random, -2, 5));
      request.scale = make_error_scale(camera, 640, 360, request.error_px);
      request.culls = random.next() % 2 == 0;
      if (random.next() % 4 == 0) request.sides_away = std::exp2(test::between(random, -2, 7));
      const std::uint64_t before = test::heap_calls();
      parts.tiles.begin_frame();
      parts.pool.begin_frame();
      parts.tiles.poll();
      parts.view.select(ground.info(), request, parts.tiles, parts.pool);
      parts.tiles.ask();
      const std::uint64_t calls = test::heap_calls() - before;
      EXPECT_EQ(calls, 0u);
      for (MorphRows rows; !(rows = parts.view.take_rows()).halves.empty();) {
        std::copy(rows.halves.begin(), rows.halves.end(),
                  parts.rows.begin() + static_cast<std::ptrdiff_t>(rows.first_row) * kMorphRow);
      }
      totals.refused += parts.view.result().refused;
      check_frame(ground, request, parts, entries, table, edges, totals);
      if (HasFatalFailure()) {
        std::printf("ground %lld x %lld, frame %d, culls %d\n", static_cast<long long>(wide),
                    static_cast<long long>(deep), frame, request.culls ? 1 : 0);
        return;
      }
    }
  }
  std::printf(
      "FIGURE %llu frames, %llu edges, %llu of them at the feet of walls or out of view; %llu nodes, %llu of "
      "them beside coarser ones; %llu "
      "splits "
      "refused, %llu vertices on their way\n",
      static_cast<unsigned long long>(totals.frames), static_cast<unsigned long long>(totals.edges),
      static_cast<unsigned long long>(totals.rim), static_cast<unsigned long long>(totals.nodes),
      static_cast<unsigned long long>(totals.coarser), static_cast<unsigned long long>(totals.refused),
      static_cast<unsigned long long>(totals.moving));
  EXPECT_GT(totals.coarser, totals.frames);
  EXPECT_GT(totals.refused, 0u);
  EXPECT_GT(totals.moving, totals.frames);
}

// No place of a node's box is nearer than stated, and the nearest one is not much further.
TEST(Ground, NodesAreAsNearAsTheirBoxes) {
  Random random{20261129};
  double gap = 0;
  std::uint64_t nodes = 0;
  for (int world = 0; world < 20; ++world) {
    const double rough = std::exp2(test::between(random, 4, 12));
    const MemoryGround ground(
        257, 257, 2048, test::between(random, 1024, 2048),
        [&](std::int64_t i, std::int64_t k) {
          return static_cast<std::int32_t>(rough * std::sin(double(i * 7 + k * 3) * 0.02));
        },
        [](NodeKey) { return 100.0f; });
    Parts parts(static_cast<std::uint32_t>(ground.tile_count()) + 1, 1500);
    MemoryGround::Source source(ground);
    parts.tiles.reset(source.source(), ground.root(), ground.tile(ground.root()));
    parts.view.reset();
    for (int frame = 0; frame < 20; ++frame) {
      Camera camera;
      const auto kind = test::kAnyProjections[random.next() % 4];
      CameraMatrices matrices = test::any_matrices(random, kind, 0.01, 64);
      test::show(random, {test::between(random, 0, 64), 0, test::between(random, 0, 64)},
                 std::exp2(test::between(random, 0, 6)), matrices);
      if (!make_camera(matrices, camera).ok()) continue;
      GroundRequest request;
      request.camera = &camera;
      request.error_px = 2;
      request.scale = make_error_scale(camera, 640, 360, request.error_px);
      for (int round = 0; round < 12; ++round) {
        parts.tiles.begin_frame();
        parts.pool.begin_frame();
        parts.tiles.poll();
        parts.view.select(ground.info(), request, parts.tiles, parts.pool);
        parts.tiles.ask();
      }
      const glm::dvec3 corner = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
      for (const GroundView::Node& node : parts.view.nodes()) {
        if (node.key.size == ground.info().top_size() || !node.in_view) continue;
        if (!node_exists(ground.info(), node.key)) continue;
        const NodeBox box = node_box(ground.info(), node.tile->nodes[node_in_tile(node.key)], node.key);
        double nearest = std::numeric_limits<double>::infinity(), eye = nearest;
        for (int n = 0; n < 5 * 5 * 5; ++n) {
          const glm::dvec3 share(n % 5 * 0.25, n / 5 % 5 * 0.25, n / 25 * 0.25);
          const glm::dvec3 from_eye = glm::mix(box.low, box.high, share) - corner - glm::dvec3(camera.fine);
          nearest = std::min(nearest, double{apparent_distance(glm::vec3(from_eye), glm::vec3(camera.forward),
                                                               request.scale.least_cos2)});
          eye = std::min(eye, glm::length(from_eye));
        }
        ASSERT_LE(double{node.least_apparent}, nearest * (1 + 1e-5) + 2);
        const double radius = 0.5 * glm::length(box.high - box.low);
        if (eye < 8 * radius) continue;
        gap += (nearest - double{node.least_apparent}) / radius;
        ++nodes;
      }
    }
  }
  std::printf("FIGURE %llu nodes, nearer than their boxes by %.3f of their radius in the mean\n",
              static_cast<unsigned long long>(nodes), gap / double(nodes));
  EXPECT_GT(nodes, 1000u);
  EXPECT_LT(gap / double(nodes), 0.06);
}

// A node on its way, as measure_ground.h has it: a middle and a centre of its quads are home or not by any
// distance rho that changes by kSteepest a step at most. Then each point of the full surface is within rho /
// k of what is drawn.
class MovingNode {
 public:
  MovingNode(const MemoryGround& ground, const std::vector<std::int32_t>& heights, NodeKey key, int demand_of)
      : info_(ground.info()), heights_(heights), key_(key), quad_(std::int64_t{1} << key.size) {
    threshold_ = threshold(ground, key, demand_of);
    for (int edge = 0; edge < 4; ++edge) {
      constexpr int kEast[4] = {-1, 0, 1, 0}, kSouth[4] = {0, 1, 0, -1};
      NodeKey other;
      border_[edge] = threshold_;
      if (neighbour_of(info_, key, kEast[edge], kSouth[edge], other))
        border_[edge] = std::min(border_[edge], threshold(ground, other, demand_of));
    }
    for (int n = 0; n < 4; ++n) finer_[n] = threshold(ground, key.child(n), demand_of);
  }
  double own_threshold() const { return threshold_; }

  // The greatest k error / rho of its points, and where; nodes of the next smaller size that are split leave
  // theirs out.
  template <class Rho>
  double most(double k, const Rho& rho) const {
    double most = 0;
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const std::int64_t side = 2 * quad_;
      const std::int64_t i0 = (2 * key_.x + quadrant % 2) * side, k0 = (2 * key_.z + quadrant / 2) * side;
      double nearest = std::numeric_limits<double>::infinity();
      for (std::int64_t z = k0; z <= k0 + side; ++z) {
        for (std::int64_t x = i0; x <= i0 + side; ++x) nearest = std::min(nearest, rho(place(x, z)));
      }
      if (nearest < finer_[quadrant]) continue;
      for (std::int64_t z = k0; z <= k0 + side; ++z) {
        for (std::int64_t x = i0; x <= i0 + side; ++x) {
          const glm::dvec3 full = place(x, z);
          most = std::max(most, k * std::abs(full.y - drawn(x, z, rho)) / rho(full));
        }
      }
    }
    return most;
  }
  glm::dvec3 place(std::int64_t i, std::int64_t k) const {
    return {double(i) * info_.steps[0], height(i, k), double(k) * info_.steps[1]};
  }
  // Of some of its samples the one that is furthest off with all arrived, and the middle and the centre
  // there.
  std::array<glm::dvec3, 3> worst(Random& random) const {
    std::array<glm::dvec3, 3> worst;
    double most = -1;
    for (int n = 0; n < 40; ++n) {
      const std::int64_t i = 4 * key_.x * quad_ + random.below(static_cast<int>(4 * quad_));
      const std::int64_t k = 4 * key_.z * quad_ + random.below(static_cast<int>(4 * quad_));
      const double error = std::abs(place(i, k).y - drawn(i, k, [](const glm::dvec3&) { return 1e30; }));
      if (error <= most) continue;
      most = error;
      const Triangle t = triangle_of(i, k);
      worst = {place(i, k), place(t.middle[0], t.middle[1]), place(t.centre[0], t.centre[1])};
    }
    return worst;
  }

 private:
  double threshold(const MemoryGround& ground, NodeKey key, int demand_of) const {
    return double{threshold_steps(ground.tile(tile_of(key)).nodes[node_in_tile(key)].thresholds[demand_of])} *
           std::ldexp(1.0, key.size);
  }
  double height(std::int64_t i, std::int64_t k) const {
    return 2.0 * heights_[static_cast<std::size_t>(k * info_.samples[0] + i)];
  }
  // A child triangle: samples of its vertices, and the sample's weights of them.
  struct Triangle {
    std::int64_t corner[2], middle[2], centre[2];
    double at_corner, at_middle;
    bool is_outer;
    int edge;
    bool even;
  };
  Triangle triangle_of(std::int64_t i, std::int64_t k) const {
    // A quad of the node that has it.
    const std::int64_t x = std::min(i / quad_, 4 * std::int64_t{key_.x} + 3);
    const std::int64_t z = std::min(k / quad_, 4 * std::int64_t{key_.z} + 3);
    const std::int64_t half = quad_ / 2, ci = x * quad_ + half, ck = z * quad_ + half;
    const std::int64_t u = i - ci, v = k - ck, su = u < 0 ? -half : half, sv = v < 0 ? -half : half;
    const bool to_side = std::abs(u) >= std::abs(v);
    const double out = double(std::max(std::abs(u), std::abs(v))) / double(half);
    const double at_corner = double(std::min(std::abs(u), std::abs(v))) / double(half);
    const int edge = to_side ? (u < 0 ? 0 : 2) : (v < 0 ? 3 : 1);
    const std::int64_t inside[4] = {x % 4, 3 - z % 4, 3 - x % 4, z % 4};
    return {{ci + su, ck + sv},
            {ci + (to_side ? su : 0), ck + (to_side ? 0 : sv)},
            {ci, ck},
            at_corner,
            out - at_corner,
            inside[edge] == 0,
            edge,
            (x + z) % 2 == 0};
  }
  // Height above a sample in the state that rho says.
  template <class Rho>
  double drawn(std::int64_t i, std::int64_t k, const Rho& rho) const {
    const Triangle t = triangle_of(i, k);
    const std::int64_t half = quad_ / 2, ci = t.centre[0], ck = t.centre[1];
    const auto moved = [&](const std::int64_t(&at)[2], double target, double threshold) {
      const double share = std::clamp((rho(place(at[0], at[1])) - (1 - kNodeMorphShare) * threshold) /
                                          (double{kNodeMorphShare} * threshold),
                                      0.0, 1.0);
      return height(at[0], at[1]) + share * (target - height(at[0], at[1]));
    };
    const std::int64_t south = t.even ? half : -half;
    const double centre =
        moved(t.centre, 0.5 * (height(ci - half, ck - south) + height(ci + half, ck + south)), threshold_);
    // From the corner over the middle, as far again.
    const double target = 0.5 * (height(t.corner[0], t.corner[1]) +
                                 height(2 * t.middle[0] - t.corner[0], 2 * t.middle[1] - t.corner[1]));
    const double middle = moved(t.middle, target, t.is_outer ? border_[t.edge] : threshold_);
    return t.at_corner * height(t.corner[0], t.corner[1]) + t.at_middle * middle +
           (1 - t.at_corner - t.at_middle) * centre;
  }

  const GroundInfo& info_;
  const std::vector<std::int32_t>& heights_;
  NodeKey key_;
  std::int64_t quad_;
  double threshold_ = 0, border_[4] = {}, finer_[4] = {};
};

TEST(Ground, ThresholdsHoldForAnyDistanceOfTheirSlope) {
  Random random{20261130};
  double most = 0, sum = 0;
  std::uint64_t beyond = 0, looks = 0;
  constexpr std::int64_t kSide = 129;
  const auto worlds = static_cast<int>(frames_wanted() * 60 / 400);
  for (int world = 0; world < worlds; ++world) {
    const double tall = std::exp2(test::between(random, 9, 15));
    const double length = std::exp2(test::between(random, 1.5, 6)), turn = test::between(random, 0, 6.28);
    const double noise = std::exp2(test::between(random, -9, 0));
    std::vector<std::int32_t> heights(kSide * kSide);
    for (std::int64_t k = 0; k < kSide; ++k) {
      for (std::int64_t i = 0; i < kSide; ++i) {
        const double along = (std::cos(turn) * double(i) + std::sin(turn) * double(k)) * 6.28 / length;
        heights[static_cast<std::size_t>(k * kSide + i)] = static_cast<std::int32_t>(
            tall * (std::sin(along) * length / 64 + noise * test::between(random, -1, 1)));
      }
    }
    const MemoryGround ground(
        kSide, kSide, 2048, test::between(random, 0, 1) < 0.5 ? 2048 : 1024,
        [&](std::int64_t i, std::int64_t k) { return heights[static_cast<std::size_t>(k * kSide + i)]; });
    for (int round = 0; round < 60; ++round) {
      const int size = 1 + random.below(4), nodes = static_cast<int>((kSide - 1) / 4) >> size;
      const int n = random.below(kDemands);
      const MovingNode node(ground, heights, {size, random.below(nodes), random.below(nodes)}, n);
      const double threshold = node.own_threshold();
      // A vertex just arrives, or is on its way, and rho falls most towards what is furthest off.
      const auto [point, middle, centre] = node.worst(random);
      const glm::dvec3 vertex = random.below(2) == 0 ? middle : centre;
      const double at_vertex =
          threshold * (random.below(2) == 0 ? 1 : test::between(random, 1 - kNodeMorphShare, 1));
      const glm::dvec3 way = vertex - point + 200.0 * test::any_direction(random);
      const glm::dvec3 slope = kSteepest * glm::normalize(way);
      const double share = node.most(demand(n), [&](const glm::dvec3& place) {
        return std::max(1.0, at_vertex + glm::dot(slope, place - vertex));
      });
      ++looks;
      sum += share;
      most = std::max(most, share);
      beyond += share > 1 ? 1 : 0;
    }
  }
  std::printf(
      "FIGURE %llu nodes on their way: %.4f of what their distance allows at most, %.3f in the mean\n",
      static_cast<unsigned long long>(looks), most, sum / double(looks));
  EXPECT_EQ(beyond, 0u);
  EXPECT_GT(most, 0.97);
}

// The full surface above a place, lattice steps from the ground's corner.
double full_height(const GroundInfo& info, const std::vector<std::int32_t>& heights, double x, double z) {
  const double fx = std::clamp(x / info.steps[0], 0.0, double(info.samples[0] - 1));
  const double fz = std::clamp(z / info.steps[1], 0.0, double(info.samples[1] - 1));
  const auto i = std::min(static_cast<std::int64_t>(fx), info.samples[0] - 2);
  const auto k = std::min(static_cast<std::int64_t>(fz), info.samples[1] - 2);
  const double u = fx - double(i), v = fz - double(k);
  const auto h = [&](std::int64_t a, std::int64_t b) {
    return 2.0 * heights[static_cast<std::size_t>((k + b) * info.samples[0] + i + a)];
  };
  if ((i + k) % 2 == 0) {
    return u > v ? h(0, 0) + u * (h(1, 0) - h(0, 0)) + v * (h(1, 1) - h(1, 0))
                 : h(0, 0) + v * (h(0, 1) - h(0, 0)) + u * (h(1, 1) - h(0, 1));
  }
  return u + v < 1 ? h(0, 0) + u * (h(1, 0) - h(0, 0)) + v * (h(0, 1) - h(0, 0))
                   : h(1, 1) + (1 - u) * (h(0, 1) - h(1, 1)) + (1 - v) * (h(1, 0) - h(1, 1));
}

TEST(Ground, NoDrawnPointIsFurtherFromTheFullSurfaceThanStated) {
  std::vector<std::uint8_t> entries(kMorphEntries, 0);
  build_family_entries(entries);
  std::vector<std::uint16_t> table(index_count(kNodeLevel));
  ASSERT_TRUE(build_index_tables(kNodeLevel, table).ok());
  Random random{5};
  double most = 0, sum = 0;
  std::uint64_t points = 0, frames = 0, refused = 0, beyond = 0;
  const std::uint64_t wanted = frames_wanted() / 4;
  while (frames < wanted) {
    const auto wide = static_cast<std::int64_t>(test::between(random, 40, 400));
    const auto deep = static_cast<std::int64_t>(test::between(random, 40, 400));
    // Waves of several lengths, and noise.
    const double tall = std::exp2(test::between(random, 6, 13));
    const double noise = tall * std::exp2(test::between(random, -8, -1));
    double wave[6][3];
    for (auto& w : wave) {
      const double length = std::exp2(test::between(random, 2, 8));
      const double turn = test::between(random, 0, 6.28);
      w[0] = std::cos(turn) * 6.28 / length;
      w[1] = std::sin(turn) * 6.28 / length;
      w[2] = tall * length / 256;
    }
    std::vector<std::int32_t> heights(static_cast<std::size_t>(wide * deep));
    for (std::int64_t k = 0; k < deep; ++k) {
      for (std::int64_t i = 0; i < wide; ++i) {
        double h = test::between(random, -noise, noise);
        for (const auto& w : wave) h += w[2] * std::sin(w[0] * double(i) + w[1] * double(k));
        heights[static_cast<std::size_t>(k * wide + i)] = static_cast<std::int32_t>(h);
      }
    }
    const MemoryGround ground(
        wide, deep, 2048, test::between(random, 0, 1) < 0.5 ? 2048 : 1777,
        [&](std::int64_t i, std::int64_t k) { return heights[static_cast<std::size_t>(k * wide + i)]; });
    const bool ample = test::between(random, 0, 1) < 0.7;
    Parts parts(static_cast<std::uint32_t>(ground.tile_count()) + 1, ample ? 4000 : 40);
    MemoryGround::Source source(ground);
    parts.tiles.reset(source.source(), ground.root(), ground.tile(ground.root()));
    parts.view.reset();
    for (int n = 0; n < 10; ++n, ++frames) {
      Camera camera;
      const auto kind = test::kAnyProjections[random.next() % std::size(test::kAnyProjections)];
      CameraMatrices matrices = test::any_matrices(random, kind, 0.02, double(wide) * 0.25);
      test::show(
          random,
          {test::between(random, 0, double(wide) * 0.25), test::between(random, -0.2, 0.2) * tall / 4096,
           test::between(random, 0, double(deep) * 0.2)},
          std::exp2(test::between(random, -2, 6)), matrices);
      if (!make_camera(matrices, camera).ok()) continue;
      GroundRequest request;
      request.camera = &camera;
      request.error_px = std::exp2(test::between(random, -1, 5));
      request.scale = make_error_scale(camera, 640, 360, request.error_px);
      for (int round = 0; round < 12; ++round) {
        parts.tiles.begin_frame();
        parts.pool.begin_frame();
        parts.tiles.poll();
        parts.view.select(ground.info(), request, parts.tiles, parts.pool);
        parts.tiles.ask();
        if (parts.view.result().lacks_tile == 0) break;
      }
      for (MorphRows rows; !(rows = parts.view.take_rows()).halves.empty();) {
        std::copy(rows.halves.begin(), rows.halves.end(),
                  parts.rows.begin() + static_cast<std::ptrdiff_t>(rows.first_row) * kMorphRow);
      }
      refused += parts.view.result().refused;
      const double bound = double{parts.view.result().bound_px};
      const glm::dmat4 clip = glm::dmat4(clip_from_lattice(camera));
      const glm::dvec3 corner = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
      for (std::size_t at = 0; at < parts.view.items().size(); ++at) {
        const DrawItem& item = parts.view.items()[at];
        const GroundView::Node& node = parts.view.node_of(at);
        const DrawnNode drawn(ground.info(), camera, request.scale, node, entries, parts.rows,
                              node.key == ground.root());
        IndexRange ranges[kMaxIndexRanges];
        const int count = index_ranges(item.level, item.lower_edges, 0, ranges);
        for (int r = 0; r < count; ++r) {
          for (std::uint32_t t = ranges[r].first; t < ranges[r].first + ranges[r].count; t += 3) {
            double a = test::between(random, 0, 1), b = test::between(random, 0, 1);
            if (a + b > 1) a = 1 - a, b = 1 - b;
            const glm::dvec3 place = glm::dvec3(drawn.place(table[t])) * (1 - a - b) +
                                     glm::dvec3(drawn.place(table[t + 1])) * a +
                                     glm::dvec3(drawn.place(table[t + 2])) * b;
            glm::dvec3 full = place;
            full.y = full_height(ground.info(), heights, place.x + corner.x, place.z + corner.z) - corner.y;
            const glm::dvec4 p = clip * glm::dvec4(place, 1), f = clip * glm::dvec4(full, 1);
            const bool in_front = p.w > 0 && f.w > 0 && p.z >= -p.w && f.z >= -f.w;
            if (!in_front || std::abs(p.x) > p.w || std::abs(p.y) > p.w) continue;
            const double px = std::hypot((p.x / p.w - f.x / f.w) * 320, (p.y / p.w - f.y / f.w) * 180);
            ++points;
            sum += px / request.error_px;
            most = std::max(most, px / bound);
            beyond += px > bound ? 1 : 0;
          }
        }
      }
    }
  }
  std::printf(
      "FIGURE %llu frames, %llu points, %llu splits refused: at most %.3f of the stated bound, %.3f of the "
      "error asked for in the mean\n",
      static_cast<unsigned long long>(frames), static_cast<unsigned long long>(points),
      static_cast<unsigned long long>(refused), most, sum / double(points));
  EXPECT_EQ(beyond, 0u);
  EXPECT_GT(most, 0.3);
  EXPECT_GT(refused, 0u);
}

}  // namespace
}  // namespace karst::core
