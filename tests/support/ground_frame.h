// SPDX-License-Identifier: MIT
// A frame of the ground for tests: a view with memory of its own, and the edges of what is drawn, by the bits
// of their ends.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "terrain/base/storage_plan.h"
#include "terrain/basis/level_view.h"
#include "terrain/draw/index_batches.h"
#include "terrain/draw/wall_indices.h"
#include "terrain/nodes/ground_view.h"
#include "terrain/nodes/make_node.h"
#include "terrain/nodes/node_place.h"

namespace karst::test {
using namespace core;

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
inline Bits bits_of(glm::vec3 place) {
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
    const int size = info.page_size(node.key.size);
    const glm::ivec3 origin = node_origin(info, node.tile->nodes[node_in_tile(node.key)], node.key);
    const std::size_t row = is_root ? 0 : std::size_t{node.parent_family} + 1;
    const std::size_t first =
        (kFirstGroundPlace + static_cast<std::size_t>(node.key.quadrant())) * kPageVertices;
    for (std::size_t v = 0; v < kNodePageVertices; ++v) {
      const GpuVertex& from = vertices[v];
      const glm::vec3 home =
          node_place(camera.voxel, size, origin, {from.position[0], from.position[1], from.position[2]});
      const glm::vec3 target =
          node_place(camera.voxel, size, origin, {from.morph[0], from.morph[1], from.morph[2]});
      const float threshold = threshold_steps(rows[row * kMorphRow + entries[first + v]]);
      const float apparent =
          apparent_distance(home - camera.fine, glm::vec3(camera.forward), scale.least_cos2);
      const float share = morph_share(apparent, threshold, kNodeMorphShare);
      const float unit = std::ldexp(1.0f, size);
      const glm::vec3 way(static_cast<float>(from.morph[0] - from.position[0]) * unit,
                          static_cast<float>(from.morph[1] - from.position[1]) * unit,
                          static_cast<float>(from.morph[2] - from.position[2]) * unit);
      place_[v] = share < 1.0f ? home + way * share : target;
      moving_ += share > 0.0f && share < 1.0f ? 1 : 0;
      if (v >= kNodeVertices && info.basis.is_curved()) {
        const double step_m = info.basis.height_unit_m / kVertexStep;
        const glm::dvec3 eye = glm::dvec3(camera.voxel) * double{kStepsPerVoxel} + glm::dvec3(camera.fine);
        const LevelView level =
            make_level_view(info.basis, eye * step_m, step_m * kStepsPerVoxel, info.basis.height_m(info.low));
        const glm::vec3 from_eye = (place_[v] - camera.fine) / float{kStepsPerVoxel};
        place_[v] -= level_up(level, from_eye) *
                     ((level_height(level, from_eye) - level.eye.z) * float{kStepsPerVoxel});
      } else if (v >= kNodeVertices) {
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

// Calls take(corners) for each triangle of an item, by vertices of the node's page.
template <class Take>
void for_each_triangle(const DrawItem& item, std::span<const std::uint16_t> table, const Take& take) {
  IndexRange ranges[kMaxIndexRanges];
  const int count = index_ranges(item.level, item.lower_edges, item.skipped_edges, ranges);
  for (int r = 0; r < count; ++r) {
    for (std::uint32_t at = ranges[r].first; at < ranges[r].first + ranges[r].count; at += 3)
      take(table.data() + at);
  }
  for (std::size_t edge = 0; edge < 4; ++edge) {
    for (std::size_t at = 0; (item.walls >> edge & 1u) != 0 && at < kIndicesPerWall; at += 3)
      take(kWallIndices[edge].data() + at);
  }
}

}  // namespace karst::test
