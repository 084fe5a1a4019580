// SPDX-License-Identifier: MIT
// Frames of a ground with a region in it: random grounds and voxels, cameras, thresholds, tiles that come
// late or fail, patches held at any level or not at all. In every frame each inner edge of nodes, patches and
// belts is used once by each of its two sides, with the same bits of the places that are drawn.
//
// KARST_REGION_FRAMES sets how many frames.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <unordered_map>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/draw/index_batches.h"
#include "terrain/draw/wall_indices.h"
#include "terrain/regions/belts.h"
#include "terrain/regions/region_rim.h"
#include "tests/support/any_camera.h"
#include "tests/support/ground_frame.h"
#include "tests/support/heap_count.h"
#include "tests/support/memory_ground.h"
#include "tests/support/morph_scene.h"

namespace karst::core {
namespace {

using test::bits_of;
using test::DrawnNode;
using test::Edge;
using test::EdgeHash;
using test::MemoryGround;
using test::Parts;
using test::Use;

std::uint64_t frames_wanted() {
  const char* const set = std::getenv("KARST_REGION_FRAMES");
  return set == nullptr ? 300 : std::strtoull(set, nullptr, 10);
}

// Where the ground lies, and what of it the region has.
struct Layout {
  int lattice_size = 0;
  int nodes[2] = {};    // of the region, along x and z
  int first[2] = {};    // its first node
  int samples[2] = {};  // of the ground
  glm::ivec3 extent{0};
};

Layout random_layout(Random& random) {
  Layout layout;
  layout.lattice_size = random.below(3);
  const int wide = 1 << layout.lattice_size;
  for (int axis = 0; axis < 2; ++axis) {
    layout.nodes[axis] = 1 + random.below(12 / wide + 1);
    if (layout.nodes[axis] * wide < 3) layout.nodes[axis] = (3 + wide - 1) / wide;
    layout.first[axis] = 1 + random.below(20);
    layout.samples[axis] =
        (layout.first[axis] + layout.nodes[axis] + random.below(20)) * kNodeQuads + 2 + random.below(3);
    layout.extent[2 * axis] = layout.nodes[axis] * wide + 1;
  }
  layout.extent.y = 14;
  return layout;
}

// A height over the voxels' columns, and caves that stay away from the sides.
TestWorld random_voxels(Random& random, const Layout& layout, int level) {
  const std::uint64_t seed = random.next();
  const double tall = between(random, 0, 4), caves = between(random, 0.1, 0.7);
  const glm::ivec3 extent = layout.extent;
  TestWorld world(
      extent,
      [=](glm::ivec3 v) {
        const bool inside = v.y > 0 && v.x > 2 && v.z > 2 && v.x < extent.x - 3 && v.z < extent.z - 3;
        if (inside && test::value_noise(seed + 1, glm::dvec3(v) / 3.0) > 1 - caves) return false;
        return v.y + 0.5 < 7 + tall * test::value_noise(seed, glm::dvec3(v.x, 0, v.z) / 5.0);
      },
      true);
  const double rough = std::exp2(between(random, 0, 11));
  world.set_heights(level, [=](glm::dvec3 p) { return rough * test::value_noise(seed + 2, 3.0 * p); });
  return world;
}

struct Totals {
  std::uint64_t frames = 0, with_region = 0, edges = 0, open = 0, belts = 0, nodes = 0, mixed = 0;
  std::uint64_t refused = 0, halves = 0;
};

class RegionFrames {
 public:
  RegionFrames() : table_(index_count(kMaxLevel)) {
    entries_.resize(kMorphEntries);
    build_family_entries(entries_);
    EXPECT_TRUE(build_index_tables(kMaxLevel, table_).ok());
  }

  // Draws the frame, and looks at each edge.
  void check(const MemoryGround& ground, const GroundRequest& request, const Parts& parts, const Scene& scene,
             const RegionRim& rim, Totals& totals) {
    edges_.clear();
    const Camera& camera = *request.camera;
    const Surface surface = scene.drawn.surface();
    const bool region = parts.view.result().region;
    // Vertices as they lie in the buffer: of patches, then of nodes.
    const std::uint32_t pages = slot_pages(scene.drawn.level());
    const auto first_node_page = static_cast<std::uint32_t>(surface.patches.size()) * pages;
    places_.assign((std::size_t{first_node_page} + 4 * std::size_t{parts.pool.count()}) * kPageVertices, {});
    for (PatchId p = 0; region && p < surface.patches.size(); ++p) {
      if (scene.levels[p] == 0) continue;
      const std::vector<glm::vec3> moved = scene.moved(p, scene.levels[p], camera);
      std::copy(moved.begin(), moved.end(),
                places_.begin() + static_cast<std::ptrdiff_t>(std::size_t{p} * pages * kPageVertices));
      const DrawItem item = make_draw_item(surface, scene.levels, p);
      use_item(item, p * pages * kPageVertices);
    }
    for (std::size_t n = 0; n < parts.view.items().size(); ++n) {
      const DrawItem& item = parts.view.items()[n];
      const GroundView::Node& node = parts.view.node_of(n);
      const DrawnNode drawn(ground.info(), camera, request.scale, node, entries_, parts.rows,
                            node.key == ground.root());
      const std::uint32_t first = (first_node_page + item.patch) * kPageVertices;
      for (std::uint32_t v = 0; v < kNodePageVertices; ++v) places_[first + v] = drawn.place(v);
      use_item(item, first);
      for (std::size_t edge = 0; edge < 4; ++edge) {
        for (std::size_t at = 0; (item.walls >> edge & 1u) != 0 && at < kIndicesPerWall; at += 3)
          use_triangle(kWallIndices[edge].data() + at, first);
      }
    }
    totals.nodes += parts.view.items().size();
    if (region) {
      first_page_.resize(surface.patches.size());
      next_page_.resize(std::size_t{first_node_page});
      for (std::uint32_t page = 0; page < first_node_page; ++page)
        next_page_[page] = (page + 1) % pages == 0 ? kNoPage : page + 1;
      for (PatchId p = 0; p < surface.patches.size(); ++p) first_page_[p] = p * pages;
      BuildBelts belts;
      belts.info = &ground.info();
      belts.rim = &rim;
      belts.view = &parts.view;
      belts.levels = belts.resident = scene.levels;
      belts.pages = {first_page_, next_page_, {}, {}};
      belts.first_node_page = first_node_page;
      indices_.resize(BuildBelts::room(static_cast<std::uint32_t>(rim.edges().size()), scene.drawn.level()));
      belts.out = indices_;
      const std::uint64_t before = test::heap_calls();
      const std::size_t count = belts.run();
      EXPECT_EQ(test::heap_calls() - before, 0u);
      for (std::size_t at = 0; at < count; at += 3) use_triangle(indices_.data() + at, 0);
      totals.belts += count / 3;
    }
    look(ground, request, totals);
  }

 private:
  void use_item(const DrawItem& item, std::uint32_t first) {
    IndexRange ranges[kMaxIndexRanges];
    const int count = index_ranges(item.level, item.lower_edges, item.skipped_edges, ranges);
    for (int r = 0; r < count; ++r) {
      for (std::uint32_t at = ranges[r].first; at < ranges[r].first + ranges[r].count; at += 3)
        use_triangle(table_.data() + at, first);
    }
  }
  template <class Index>
  void use_triangle(const Index* corners, std::uint32_t first) {
    for (int side = 0; side < 3; ++side) {
      const glm::vec3 from = places_[first + corners[side]];
      const glm::vec3 to = places_[first + corners[(side + 1) % 3]];
      const Edge edge{bits_of(from), bits_of(to)};
      if (edge.from == edge.to) continue;
      Use& use = edges_[edge];
      ++use.times;
      use.from = from;
      use.to = to;
    }
  }

  void look(const MemoryGround& ground, const GroundRequest& request, Totals& totals) {
    const GroundInfo& info = ground.info();
    const Camera& camera = *request.camera;
    Camera at_voxel = camera;
    at_voxel.voxel = glm::ivec3(0);
    const Frustum frustum = make_frustum(at_voxel);
    const glm::dvec3 corner = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
    double low[2], high[2], end[2];  // of the region, and where the ground ends
    for (int axis = 0; axis < 2; ++axis) {
      const auto at = [&](std::int64_t sample) {
        return double(sample_place(info, axis, sample) * kVertexStep);
      };
      low[axis] = at(std::int64_t{info.region.low[axis]} * kNodeQuads);
      high[axis] = at(std::int64_t{info.region.high[axis]} * kNodeQuads);
      end[axis] = at(info.samples[axis] - 1);
    }
    const double foot = double(info.low) * kVertexStep;
    const double slack = std::ldexp(4.0, info.page_size(info.top_size()));
    for (const auto& [edge, use] : edges_) {
      const auto other = edges_.find({edge.to, edge.from});
      const int back = other == edges_.end() ? 0 : other->second.times;
      ++totals.edges;
      if (use.times == 1 && back == 1) continue;
      const glm::dvec3 a = glm::dvec3(use.from) + corner;
      const glm::dvec3 b = glm::dvec3(use.to) + corner;
      const bool at_foot = std::abs(a.y - foot) <= slack && std::abs(b.y - foot) <= slack;
      bool out_of_view = false;
      for (const Plane& plane : frustum.planes) {
        out_of_view =
            out_of_view || (request.culls && glm::dot(plane.normal, use.from) + plane.offset < 0.0f &&
                            glm::dot(plane.normal, use.to) + plane.offset < 0.0f);
      }
      const bool at_end = std::max(a.x, b.x) >= end[0] - slack || std::max(a.z, b.z) >= end[1] - slack;
      const bool at_lowest = std::min(a.y, b.y) <= foot + slack;
      if (use.times == back && (at_end || at_lowest)) continue;
      // In a side of the region triangles of the belt may have no area: their sides lie on each other. And
      // patches may touch along an edge.
      bool in_region = true;
      for (int axis = 0; axis < 2; ++axis) {
        for (const glm::dvec3& place : {a, b})
          in_region = in_region && place[2 * axis] >= low[axis] && place[2 * axis] <= high[axis];
      }
      if (use.times == back && in_region) continue;
      ++totals.open;
      ASSERT_TRUE(at_foot || out_of_view)
          << "an edge from " << a.x << ' ' << a.y << ' ' << a.z << " to " << b.x << ' ' << b.y << ' ' << b.z
          << " is used " << use.times << " times, the other way " << back << " times; the region is "
          << low[0] << ".." << high[0] << ", " << low[1] << ".." << high[1];
    }
  }

  std::vector<std::uint8_t> entries_;
  std::vector<std::uint16_t> table_;
  std::unordered_map<Edge, Use, EdgeHash> edges_;
  std::vector<glm::vec3> places_;
  std::vector<std::uint32_t> first_page_, next_page_, indices_;
};

TEST(Region, EveryInnerEdgeIsUsedOnceByEachSide) {
  Random random{20261128};
  RegionFrames frames;
  Totals totals;
  const std::uint64_t wanted = frames_wanted();
  while (totals.frames < wanted) {
    const Layout layout = random_layout(random);
    const int level = 1 + random.below(4);
    Scene scene(random_voxels(random, layout, level));
    const double rough = std::exp2(between(random, 0, 13));
    std::vector<std::int32_t> heights(static_cast<std::size_t>(layout.samples[0] * layout.samples[1]));
    for (std::int32_t& h : heights)
      h = 7 * kStepsPerVoxel / kVertexStep + static_cast<std::int32_t>(between(random, -rough, rough));
    const double errors = std::exp2(between(random, 0, 9));
    const double steps = std::ldexp(2048, layout.lattice_size);
    const double region_error = std::exp2(between(random, 10, 18));
    const double reach = kStepsPerVoxel * glm::length(glm::dvec3(layout.extent));
    const MemoryGround ground(
        layout.samples[0], layout.samples[1], steps, steps,
        [&](std::int64_t i, std::int64_t k) {
          return heights[static_cast<std::size_t>(k * layout.samples[0] + i)];
        },
        [&](NodeKey key) {
          return static_cast<float>(
              between(random, 0, 1) < 0.3 ? 0.0 : errors * std::exp2(key.size) * between(random, 0, 2));
        },
        {layout.extent.x, layout.extent.z, layout.first[0], layout.first[1], {region_error, reach}});
    const std::uint32_t edges = RegionRim::count(scene.drawn.surface());
    std::vector<RegionRim::Edge> rim_edges(edges);
    std::vector<std::uint32_t> marks(edges);
    RegionRim rim;
    rim.create({rim_edges, marks});
    const Status built = rim.build(ground.info(), scene.drawn.surface());
    ASSERT_TRUE(built.ok()) << built.what();
    Parts parts(static_cast<std::uint32_t>(ground.tile_count()) + 1,
                static_cast<std::uint32_t>(between(random, 0, 1) < 0.5 ? 1500 : between(random, 3, 300)));
    MemoryGround::Source source(ground);
    source.comes = between(random, 0.4, 1);
    source.fails = between(random, 0, 0.2);
    parts.tiles.reset(source.source(), ground.root(), ground.tile(ground.root()));
    parts.view.reset();
    for (int frame = 0; frame < 20; ++frame, ++totals.frames) {
      Camera camera;
      const auto kind = test::kAnyProjections[random.next() % std::size(test::kAnyProjections)];
      CameraMatrices matrices = test::any_matrices(random, kind, 0.01, 64);
      test::show(random,
                 {between(random, 0, layout.extent.x), 7 + between(random, -3, 3),
                  between(random, 0, layout.extent.z)},
                 std::exp2(between(random, -3, 9)), matrices);
      if (!make_camera(matrices, camera).ok()) continue;
      GroundRequest request;
      request.camera = &camera;
      request.error_px = std::exp2(between(random, -2, 6));
      request.culls = random.next() % 2 == 0;
      const SelectLod::Result patches = scene.select(camera, {640, 360}, request.error_px, level);
      request.scale = scene.scale;
      request.has_region = patches.missing == 0 && random.below(8) != 0;
      if (random.below(2) == 0) {
        // Held at any level, but none missing.
        LodSettings settings;
        settings.error_px = request.error_px;
        settings.max_level = settings.resident_level = level;
        std::vector<LackingPatch> lacking(scene.levels.size());
        const std::vector<std::uint8_t> held = random_held(random, scene, 0);
        scene.select_held(settings, camera, nullptr, held, lacking);
      }
      for (int round = random.below(6); round >= 0; --round) {
        parts.tiles.begin_frame();
        parts.pool.begin_frame();
        parts.tiles.poll();
        parts.view.select(ground.info(), request, parts.tiles, parts.pool);
        parts.tiles.ask();
      }
      for (MorphRows rows; !(rows = parts.view.take_rows()).halves.empty();) {
        std::copy(rows.halves.begin(), rows.halves.end(),
                  parts.rows.begin() + static_cast<std::ptrdiff_t>(rows.first_row) * kMorphRow);
      }
      totals.refused += parts.view.result().refused;
      totals.with_region += parts.view.result().region ? 1u : 0u;
      frames.check(ground, request, parts, scene, rim, totals);
      if (HasFatalFailure()) {
        std::printf("ground %d x %d, region %d x %d nodes from %d, %d, lattice %d, frame %d, culls %d\n",
                    layout.samples[0], layout.samples[1], layout.nodes[0], layout.nodes[1], layout.first[0],
                    layout.first[1], layout.lattice_size, frame, request.culls ? 1 : 0);
        return;
      }
    }
  }
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf(
      "FIGURE %llu frames, %llu with the region; %llu edges, %llu of them at feet of walls or out of view; "
      "%llu nodes, %llu triangles of belts, %llu splits refused\n",
      number(totals.frames), number(totals.with_region), number(totals.edges), number(totals.open),
      number(totals.nodes), number(totals.belts), number(totals.refused));
  EXPECT_GT(totals.with_region, totals.frames / 8);
  EXPECT_LT(totals.with_region, totals.frames);
  EXPECT_GT(totals.belts, totals.frames);
}

}  // namespace
}  // namespace karst::core
