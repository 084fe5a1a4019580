// SPDX-License-Identifier: MIT
// Frames of the ground by the thousand: random grounds, cameras, thresholds, tiles that come late or fail,
// pools that are too small. In every frame each inner edge is used once by each of its two sides, with the
// same bits of the places that are drawn, and nothing calls the heap.
//
// KARST_GROUND_FRAMES sets how many frames.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "terrain/base/storage_plan.h"
#include "terrain/draw/index_batches.h"
#include "terrain/draw/wall_indices.h"
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
  Random random{20261127};
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
