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

void QueryGround::forget(NodeKey tile) {
  for (Slot& slot : blocks_.slots) {
    if (slot.key == tile) slot = {};
  }
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
  if (info_.basis.is_curved()) {
    const std::int64_t curved_unit = std::int64_t{kVertexStep} << node.size;
    const NodePlaces at(info_, node);
    const int first_x = (node.x & (kTileNodes - 1)) * kNodeQuads;
    const int first_z = (node.z & (kTileNodes - 1)) * kNodeQuads;
    for (int k = 0; k < kNodeSide; ++k) {
      for (int i = 0; i < kNodeSide; ++i) {
        const glm::i64vec3 exact = at.at(i, k, tile.height(first_x + i, first_z + k));
        glm::dvec3& out = places[static_cast<std::size_t>(k * kNodeSide + i)];
        for (int axis = 0; axis < 3; ++axis)
          out[axis] = static_cast<double>(place_at_size(exact[axis], node.size) * curved_unit);
      }
    }
    return;
  }
  const int size = info_.page_size(node.size);
  const std::int64_t unit = std::int64_t{kVertexStep} << size;
  const auto place = [&](int axis, std::int64_t vertex) {
    const std::int64_t sample = sample_of(info_.samples[axis], node.size, vertex);
    return static_cast<double>(place_at_size(sample_place(info_, axis, sample), size) * unit);
  };
  const int first_i = (node.x & (kTileNodes - 1)) * kNodeQuads;
  const int first_k = (node.z & (kTileNodes - 1)) * kNodeQuads;
  for (int k = 0; k < kNodeSide; ++k) {
    for (int i = 0; i < kNodeSide; ++i) {
      const std::int64_t height = place_at_size(tile.height(first_i + i, first_k + k), size) * unit;
      places[static_cast<std::size_t>(k * kNodeSide + i)] = {place(0, std::int64_t{node.x} * kNodeQuads + i),
                                                             static_cast<double>(height),
                                                             place(1, std::int64_t{node.z} * kNodeQuads + k)};
    }
  }
}

void QueryGround::visit_node(const Tile& tile, NodeKey node, Walk& walk) const {
  std::array<glm::dvec3, kNodeVertices> places;  // rows from the north, west first
  make_places(tile, node, places);
  for (int part = 0; part < 4; ++part) {
    walk.visit(Met{node, part}, TileVertices(places.data() + 2 * (part >> 1) * kNodeSide + 2 * (part & 1)));
  }
}

void QueryGround::run(bool read, Walk& walk) {
  if (!exists()) return;
  struct Entry {
    NodeKey node;
    TilePlace place;  // of its tile; the root's has none
    NodeBox box;
    double distance;
  };
  std::array<Entry, 3 * (kMostSize + 2) + kCubeFaces> stack;
  std::size_t depth = 0;
  const NodeKey top{info_.top_size(), 0, 0};
  for (int z = 0; z < (info_.is_cube() ? kCubeCells[1] : 1); ++z) {
    for (int x = 0; x < (info_.is_cube() ? kCubeCells[0] : 1); ++x) {
      const NodeKey root{top.size, x, z};
      if (!node_exists(info_, root)) continue;
      stack[depth++] = {root, {}, node_box(info_, root_->nodes[node_in_tile(root)], root), 0.0};
    }
  }
  while (depth > 0) {
    const Entry at = stack[--depth];
    // Again: what was met since may have made it unwanted.
    if (walk.distance(at.box) < 0.0) continue;
    const Tile* const own = tile(tile_of(at.node), at.place, read);
    if (own == nullptr) continue;  // it gave way meanwhile and cannot be read again
    const Tile* finer = nullptr;
    TilePlace place;
    if (at.node.size > 0) {
      const NodeKey below = tile_of(at.node.child(0));
      place = own->children[(below.x & 1) | (below.z & 1) << 1];
      finer = tile(below, place, read);
    }
    if (finer == nullptr) {
      // Again: reading another one may have moved it.
      const Tile* const again = tile(tile_of(at.node), at.place, read);
      if (again != nullptr) visit_node(*again, at.node, walk);
      continue;
    }
    const std::size_t bottom = depth;
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const NodeKey child = at.node.child(quadrant);
      if (!node_exists(info_, child)) continue;
      // A region's patches answer there.
      if (in_region(info_, child) == InRegion::all) continue;
      Entry entry{child, place, node_box(info_, finer->nodes[node_in_tile(child)], child), 0.0};
      entry.distance = walk.distance(entry.box);
      if (entry.distance < 0.0) continue;
      std::size_t to = depth++;
      for (; to > bottom && stack[to - 1].distance < entry.distance; --to) stack[to] = stack[to - 1];
      stack[to] = entry;
    }
  }
}

}  // namespace karst::core
