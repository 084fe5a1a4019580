// SPDX-License-Identifier: MIT
// karst::Query over core::Query: places of the simulator's frame to voxels, and answers back.
#pragma once

#include <atomic>
#include <cstddef>
#include <span>

#include "karst/query.h"
#include "scene/world/placement.h"
#include "terrain/base/arena.h"
#include "terrain/field/octree.h"
#include "terrain/query/query.h"

namespace karst::core {

struct QueryObject final : karst::Query {
  QueryObject() = default;
  ~QueryObject() = default;

  // memory: Query::bytes(limits). frame and octree are borrowed.
  Status create(const core::Query::Limits& limits, const QueryWorld& world, const PlacementFrame& frame,
                const Octree& octree, std::span<std::byte> memory);

  glm::dvec3 voxels(Vec3 place) const { return placement->voxels(place); }
  Hit hit_of(const QueryHit& hit) const;

  core::Query asked;
  Arena arena{{}};
  const PlacementFrame* placement = nullptr;
  const Octree* voxel_tree = nullptr;
  std::atomic<bool> taken{false};
};

}  // namespace karst::core
