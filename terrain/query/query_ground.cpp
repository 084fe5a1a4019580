// SPDX-License-Identifier: MIT
#include "terrain/query/query_ground.h"

#include <algorithm>

#include "terrain/base/check.h"
#include "terrain/base/storage_plan.h"

namespace karst::core {

void QueryGround::add_to(Budget& budget, const Limits& limits) {
  Blocks blocks;
  blocks.each_block(limits, CountBlocks(budget));
}

Status QueryGround::create(const Limits& limits, Arena& arena) {
  if (limits.tiles != 0 && limits.tiles < kLeastTiles) {
    return {StatusCode::invalid_argument, "fewer than from the root to a tile of size 0", "tiles",
            limits.tiles};
  }
  TakeBlocks take(arena);
  blocks_.each_block(limits, take);
  if (take.complete()) return {};
  return {StatusCode::limit_reached, "the memory given is smaller than the budget", "memory"};
}

void QueryGround::set_ground(const GroundInfo& info, const Tile* root, const TileReading& reading) {
  KARST_ASSERT(root == nullptr || (info.exists() && !blocks_.tiles.empty()));
  info_ = info;
  root_ = root;
  reading_ = reading;
  std::fill(blocks_.slots.begin(), blocks_.slots.end(), Slot{});
  clock_ = 0;
  failed_reads_ = tiles_read_ = 0;
  trouble_ = {};
}

const Tile* QueryGround::tile(NodeKey key, const TilePlace& place, bool read) {
  if (key == tile_of({info_.top_size(), 0, 0})) return root_;
  ++clock_;
  std::size_t oldest = 0;
  for (std::size_t n = 0; n < blocks_.slots.size(); ++n) {
    Slot& slot = blocks_.slots[n];
    if (slot.last_used != 0 && slot.key == key) {
      slot.last_used = clock_;
      return &blocks_.tiles[n];
    }
    if (slot.last_used < blocks_.slots[oldest].last_used) oldest = n;
  }
  if (!read || !place.exists() || reading_.read == nullptr) return nullptr;
  Slot& slot = blocks_.slots[oldest];
  slot = {};
  const Status status = reading_.read(reading_.context, key, place, blocks_.workspace, blocks_.tiles[oldest]);
  if (!status.ok()) {
    ++failed_reads_;
    trouble_ = status;
    return nullptr;
  }
  ++tiles_read_;
  slot = {key, clock_};
  return &blocks_.tiles[oldest];
}

void QueryGround::make_places(const Tile& tile, NodeKey node,
                              std::array<glm::dvec3, kNodeVertices>& places) const {
  const std::int64_t unit = std::int64_t{kVertexStep} << node.size;
  const auto place = [&](int axis, std::int64_t vertex) {
    const std::int64_t sample = sample_of(info_.samples[axis], node.size, vertex);
    return static_cast<double>(place_at_size(sample_place(info_.steps[axis], sample), node.size) * unit);
  };
  const int first_i = (node.x & (kTileNodes - 1)) * kNodeQuads;
  const int first_k = (node.z & (kTileNodes - 1)) * kNodeQuads;
  for (int k = 0; k < kNodeSide; ++k) {
    for (int i = 0; i < kNodeSide; ++i) {
      const std::int64_t height = place_at_size(tile.height(first_i + i, first_k + k), node.size) * unit;
      places[static_cast<std::size_t>(k * kNodeSide + i)] = {place(0, std::int64_t{node.x} * kNodeQuads + i),
                                                             static_cast<double>(height),
                                                             place(1, std::int64_t{node.z} * kNodeQuads + k)};
    }
  }
}

}  // namespace karst::core
