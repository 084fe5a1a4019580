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
#include <unordered_map>
#include <vector>

#include "terrain/base/storage_plan.h"
#include "terrain/draw/index_batches.h"
#include "terrain/draw/wall_indices.h"
#include "terrain/ground/ground_view.h"
#include "terrain/ground/make_node.h"
#include "terrain/ground/node_place.h"
#include "tests/support/any_camera.h"
#include "tests/support/heap_count.h"
#include "tests/support/memory_ground.h"

namespace karst::core {
namespace {

using test::MemoryGround;
using test::Random;

std::uint64_t frames_wanted() {
  const char* const set = std::getenv("KARST_GROUND_FRAMES");
  return set == nullptr ? 400 : std::strtoull(set, nullptr, 10);
}

// A pool, a cache and a view in memory of their own.
struct Parts {
  explicit Parts(std::uint32_t tile_count, std::uint32_t family_count) {
    config.ground_tiles = tile_count;
    config.ground_families = family_count;
    Budget budget;
    TileCache::Storage cache_storage;
    FamilyPool::Storage pool_storage;
    GroundView::Storage view_storage;
    cache_storage.each_block(config, CountBlocks(budget));
    pool_storage.each_block(config, CountBlocks(budget));
    view_storage.each_block(config, CountBlocks(budget));
    memory.resize(budget.cpu_bytes() + Arena::kAlignment);
    void* at = memory.data();
    std::size_t room = memory.size();
    std::align(Arena::kAlignment, budget.cpu_bytes(), at, room);
    Arena arena({static_cast<std::byte*>(at), budget.cpu_bytes()});
    TakeBlocks take(arena);
    cache_storage.each_block(config, take);
    pool_storage.each_block(config, take);
    view_storage.each_block(config, take);
    EXPECT_TRUE(take.complete());
    EXPECT_EQ(arena.used(), budget.cpu_bytes());
    tiles.create(cache_storage);
    pool.create(pool_storage);
    pool.reset();
    view.create(view_storage);
    rows.resize((std::size_t{family_count} + 1) * kMorphRow);
  }

  Config config;
  std::vector<std::byte> memory;
  TileCache tiles;
  FamilyPool pool;
  GroundView view;
  std::vector<std::uint16_t> rows;  // as the GPU has them
};

struct Bits {
  std::uint32_t x, y, z;
  friend bool operator==(const Bits&, const Bits&) = default;
};
Bits bits_of(glm::vec3 place) {
  Bits bits;
  std::memcpy(&bits, &place, sizeof bits);
  // -0 and 0 are one place.
  for (std::uint32_t* v : {&bits.x, &bits.y, &bits.z}) *v = *v == 0x80000000u ? 0u : *v;
  return bits;
}

struct Edge {
  Bits from, to;
  friend bool operator==(const Edge&, const Edge&) = default;
};
struct EdgeHash {
  std::size_t operator()(const Edge& e) const {
    std::uint64_t h = 0;
    for (const std::uint32_t v : {e.from.x, e.from.y, e.from.z, e.to.x, e.to.y, e.to.z}) {
      h = (h ^ v) * 0x9e3779b97f4a7c15ull;
      h ^= h >> 31;
    }
    return static_cast<std::size_t>(h);
  }
};
struct Use {
  int times = 0;
  glm::vec3 from{0.0f}, to{0.0f};
};

// Where the vertices of a node are drawn.
class DrawnNode {
 public:
  DrawnNode(const GroundInfo& info, const Camera& camera, const ErrorScale& scale,
            const GroundView::Node& node, std::span<const std::uint8_t> entries,
            std::span<const std::uint16_t> rows, bool is_root) {
    std::array<GpuVertex, kNodePageVertices> vertices;
    MakeNode{&info, node.tile, node.key, !is_root, vertices}.run();
    const glm::ivec3 origin = node_origin(info, node.tile->nodes[node_in_tile(node.key)], node.key);
    const std::size_t row = is_root ? 0 : std::size_t{node.parent_family} + 1;
    const std::size_t first =
        (kFirstGroundPlace + static_cast<std::size_t>(node.key.quadrant())) * kPageVertices;
    for (std::size_t v = 0; v < kNodePageVertices; ++v) {
      const GpuVertex& from = vertices[v];
      const glm::vec3 home = node_place(camera.voxel, node.key.size, origin,
                                        {from.position[0], from.position[1], from.position[2]});
      const glm::vec3 target =
          node_place(camera.voxel, node.key.size, origin, {from.morph[0], from.morph[1], from.morph[2]});
      const float threshold = threshold_steps(rows[row * kMorphRow + entries[first + v]]);
      const float apparent =
          apparent_distance(home - camera.fine, glm::vec3(camera.forward), scale.least_cos2);
      const float share = morph_share(apparent, threshold);
      const float unit = std::ldexp(1.0f, node.key.size);
      const glm::vec3 way(static_cast<float>(from.morph[0] - from.position[0]) * unit,
                          static_cast<float>(from.morph[1] - from.position[1]) * unit,
                          static_cast<float>(from.morph[2] - from.position[2]) * unit);
      place_[v] = share < 1.0f ? home + way * share : target;
      moving_ += share > 0.0f && share < 1.0f ? 1 : 0;
      if (v >= kNodeVertices) {
        place_[v].y = static_cast<float>(std::int64_t{info.low} * kVertexStep -
                                         std::int64_t{camera.voxel.y} * kStepsPerVoxel);
      }
    }
  }
  glm::vec3 place(std::uint32_t vertex) const { return place_[vertex]; }
  int moving() const { return moving_; }

 private:
  std::array<glm::vec3, kNodePageVertices> place_;
  int moving_ = 0;
};

struct Totals {
  std::uint64_t frames = 0, edges = 0, nodes = 0, coarser = 0, refused = 0, moving = 0, rim = 0;
};

// All that is drawn of a frame, edge by edge.
void check_frame(const MemoryGround& ground, const GroundRequest& request, const Parts& parts,
                 std::span<const std::uint8_t> entries, std::span<const std::uint16_t> table,
                 Totals& totals) {
  std::unordered_map<Edge, Use, EdgeHash> edges;
  const Camera& camera = *request.camera;
  for (std::size_t n = 0; n < parts.view.items().size(); ++n) {
    const DrawItem& item = parts.view.items()[n];
    const GroundView::Node& node = parts.view.node_of(n);
    const bool is_root = node.key == ground.root();
    const DrawnNode drawn(ground.info(), camera, request.scale, node, entries, parts.rows, is_root);
    totals.moving += static_cast<std::uint64_t>(drawn.moving());
    totals.coarser += item.lower_edges != 0 ? 1 : 0;
    const auto use_triangle = [&](const std::uint16_t* corners) {
      for (int side = 0; side < 3; ++side) {
        const glm::vec3 from = drawn.place(corners[side]);
        const glm::vec3 to = drawn.place(corners[(side + 1) % 3]);
        const Edge edge{bits_of(from), bits_of(to)};
        if (edge.from == edge.to) continue;
        Use& use = edges[edge];
        ++use.times;
        use.from = from;
        use.to = to;
      }
    };
    IndexRange ranges[kMaxIndexRanges];
    const int count = index_ranges(item.level, item.lower_edges, item.skipped_edges, ranges);
    for (int r = 0; r < count; ++r) {
      for (std::uint32_t at = ranges[r].first; at < ranges[r].first + ranges[r].count; at += 3) {
        use_triangle(table.data() + at);
      }
    }
    for (std::size_t edge = 0; edge < 4; ++edge) {
      for (std::size_t at = 0; (item.walls >> edge & 1u) != 0 && at < kIndicesPerWall; at += 3) {
        use_triangle(kWallIndices[edge].data() + at);
      }
    }
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
  for (const auto& [edge, use] : edges) {
    const auto other = edges.find({edge.to, edge.from});
    const int times_other = other == edges.end() ? 0 : other->second.times;
    ++totals.edges;
    if (use.times == 1 && times_other == 1) continue;
    const glm::dvec3 a = glm::dvec3(use.from) + corner;
    const glm::dvec3 b = glm::dvec3(use.to) + corner;
    // Where the walls end, or what is in view.
    const bool at_foot = std::abs(a.y - foot) <= slack && std::abs(b.y - foot) <= slack;
    bool out_of_view = false;
    for (const Plane& plane : frustum.planes) {
      out_of_view = out_of_view || (request.culls && glm::dot(plane.normal, use.from) + plane.offset < 0.0f &&
                                    glm::dot(plane.normal, use.to) + plane.offset < 0.0f);
    }
    // Beyond the last sample quads have no area, and walls none where the ground is lowest: their sides lie
    // on each other.
    const bool at_end = std::max(a.x, b.x) >= end[0] - slack || std::max(a.z, b.z) >= end[1] - slack;
    const bool at_lowest = std::min(a.y, b.y) <= foot + slack;
    if (use.times == times_other && (at_end || at_lowest)) continue;
    totals.rim += 1;
    ASSERT_TRUE(at_foot || out_of_view)
        << "an edge from " << a.x << ' ' << a.y << ' ' << a.z << " to " << b.x << ' ' << b.y << ' ' << b.z
        << " is used " << use.times << " times, the other way " << times_other << " times";
  }
}

TEST(Ground, EveryInnerEdgeIsUsedOnceByEachSide) {
  std::vector<std::uint8_t> entries(kMorphEntries, 0);
  build_family_entries(entries);
  std::vector<std::uint16_t> table(index_count(kNodeLevel));
  ASSERT_TRUE(build_index_tables(kNodeLevel, table).ok());
  Random random(20261127);
  Totals totals;
  const std::uint64_t frames = frames_wanted();
  while (totals.frames < frames) {
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
      check_frame(ground, request, parts, entries, table, totals);
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

}  // namespace
}  // namespace karst::core
