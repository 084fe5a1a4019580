// SPDX-License-Identifier: MIT
// karst::Query over core::Query: places of the simulator's frame to voxels, and answers back.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <span>

#include "karst/query.h"
#include "scene/world/placement.h"
#include "terrain/base/arena.h"
#include "terrain/query/query.h"
#include "terrain/world/world.h"

namespace karst::core {

struct QueryObject final : karst::Query {
  QueryObject();
  ~QueryObject() = default;

  // memory: Query::bytes(limits). frame is borrowed.
  Status create(const core::Query::Limits& limits, const PlacementFrame& frame, std::span<std::byte> memory);
  // What is asked of from now on; borrowed.
  Status show(const QueryWorld& world, std::span<const WorldPart> octrees);

  glm::dvec3 voxels(Vec3 place) const { return placement->voxels(place); }
  Hit hit_of(const QueryHit& hit) const;

  core::Query asked;
  Arena arena{{}};
  const PlacementFrame* placement = nullptr;
  std::span<const WorldPart> voxels_of;                   // the octrees
  int octree_depth = 0;                                   // that levels are counted by: WorldInfo
  std::array<QueryPart, kMostRegions - 1> other_parts{};  // that asked looks at
  std::atomic<bool> taken{false};
};

}  // namespace karst::core
