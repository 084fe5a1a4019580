// SPDX-License-Identifier: MIT
// A frame of the ground for tests: a view with memory of its own, where its vertices are drawn, and the edges
// between them, by the bits of their ends.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <span>
#include <utility>
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

// The edges of all triangles of a frame, each with how often it is used from either end. Ends are the same
// where their bits are, -0 being 0; edges without length are left out. Its memory stays from frame to frame.
class FrameEdges {
 public:
  struct Edge {
    glm::vec3 from{0.0f}, to{0.0f};
    int times = 0, back = 0;  // used so, and the other way
    bool is_shared() const { return times == 1 && back == 1; }
  };

  void clear() {
    ends_.clear();
    for (const std::uint32_t at : used_) slots_[at].uses = {};
    used_.clear();
  }

  // An end, by its place: what use() takes. Several may be at one place.
  std::uint32_t add(glm::vec3 place) {
    End end;
    place += 0.0f;  // of -0, 0
    std::memcpy(end.bits.data(), &place, sizeof place);
    for (const std::uint32_t v : end.bits) {
      end.hash = (end.hash ^ v) * 0x9e3779b97f4a7c15u;
      end.hash ^= end.hash >> 29;
    }
    ends_.push_back(end);
    return static_cast<std::uint32_t>(ends_.size()) - 1;
  }

  void use(std::uint32_t from, std::uint32_t to) {
    const End& a = ends_[from];
    const End& b = ends_[to];
    const bool turned = a.hash != b.hash ? a.hash > b.hash : a.bits > b.bits;
    if (same(from, to)) return;
    if (2 * (used_.size() + 1) > slots_.size()) grow();
    Slot& slot = find(turned ? to : from, turned ? from : to);
    ++slot.uses[turned ? 1 : 0];
  }
  // Its three sides.
  template <class Index>
  void use_triangle(const Index* corners, std::uint32_t first) {
    for (int side = 0; side < 3; ++side) use(first + corners[side], first + corners[(side + 1) % 3]);
  }

  std::size_t count() const { return used_.size(); }
  // Calls take(edge) for each that is not used once each way.
  template <class Take>
  void for_each_open(const Take& take) const {
    for (const std::uint32_t at : used_) {
      const Slot& slot = slots_[at];
      const Edge edge{place_of(slot.low), place_of(slot.high), slot.uses[0], slot.uses[1]};
      if (!edge.is_shared()) take(edge);
    }
  }

 private:
  struct End {
    std::array<std::uint32_t, 3> bits{};
    std::uint64_t hash = 0;
  };
  struct Slot {
    std::uint32_t low = 0, high = 0;  // ends
    std::array<std::uint16_t, 2> uses{};
  };

  glm::vec3 place_of(std::uint32_t end) const {
    glm::vec3 place;
    std::memcpy(&place, ends_[end].bits.data(), sizeof place);
    return place;
  }
  bool same(std::uint32_t a, std::uint32_t b) const {
    if (a == b) return true;
    const auto& [bits_a, hash_a] = ends_[a];
    const auto& [bits_b, hash_b] = ends_[b];
    return hash_a == hash_b && bits_a[0] == bits_b[0] && bits_a[1] == bits_b[1] && bits_a[2] == bits_b[2];
  }
  Slot& find(std::uint32_t low, std::uint32_t high) {
    const std::size_t mask = slots_.size() - 1;
    const std::uint64_t hash = (ends_[low].hash * 3 + ends_[high].hash) * 0x9e3779b97f4a7c15u;
    for (std::size_t at = static_cast<std::size_t>(hash >> 32) & mask;; at = (at + 1) & mask) {
      Slot& slot = slots_[at];
      if ((slot.uses[0] | slot.uses[1]) == 0) {
        slot.low = low;
        slot.high = high;
        used_.push_back(static_cast<std::uint32_t>(at));
        return slot;
      }
      if (same(slot.low, low) && same(slot.high, high)) return slot;
    }
  }
  void grow() {
    const std::vector<Slot> old = std::move(slots_);
    slots_.assign(std::max<std::size_t>(1024, 2 * old.size()), {});
    const std::vector<std::uint32_t> used = std::move(used_);
    used_.clear();
    for (const std::uint32_t at : used) find(old[at].low, old[at].high).uses = old[at].uses;
  }

  std::vector<End> ends_;
  std::vector<Slot> slots_;
  std::vector<std::uint32_t> used_;
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
  // The first of its vertices there.
  std::uint32_t add_to(FrameEdges& edges) const {
    const std::uint32_t first = edges.add(place_[0]);
    for (std::size_t v = 1; v < kNodePageVertices; ++v) edges.add(place_[v]);
    return first;
  }
  int moving() const { return moving_; }

 private:
  std::array<glm::vec3, kNodePageVertices> place_;
  int moving_ = 0;
};

// Whether both ends of an edge, steps from the ground's corner, lie where the ground ends and the eye is on
// the inner side of that end: walls there are not drawn. Of planes.
inline bool has_wall_behind(const GroundInfo& info, const GroundRequest& request, const glm::dvec3& a,
                            const glm::dvec3& b) {
  if (!request.culls || request.camera->parallel) return false;
  const glm::dvec3 eye =
      glm::dvec3(request.camera->voxel) * double{kStepsPerVoxel} + glm::dvec3(request.camera->fine);
  const double slack = std::ldexp(4.0, info.page_size(info.top_size()));
  for (int axis = 0; axis < 2; ++axis) {
    const int c = 2 * axis;
    const double begin = double(sample_place(info, axis, 0) * kVertexStep);
    const double end = double(sample_place(info, axis, info.samples[axis] - 1) * kVertexStep);
    if (std::max(a[c], b[c]) <= begin + slack && eye[c] >= begin) return true;
    if (std::min(a[c], b[c]) >= end - slack && eye[c] <= end) return true;
  }
  return false;
}

// Says how far a long test has come, every million frames.
inline void show_progress(std::uint64_t frames, std::uint64_t wanted) {
  if (frames % 1'000'000 == 0 && frames > 0 && frames < wanted)
    std::fprintf(stderr, "%llu of %llu frames\n", static_cast<unsigned long long>(frames),
                 static_cast<unsigned long long>(wanted));
}

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
