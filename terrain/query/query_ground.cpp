// SPDX-License-Identifier: MIT
#include "terrain/query/query_ground.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

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

std::size_t QueryGround::head_count(std::uint32_t tiles) {
  std::size_t count = tiles == 0 ? 0 : 1;
  while (count < tiles) count *= 2;
  return count;
}

void QueryGround::set_ground(const GroundInfo& info, const Tile* root, const TileReading& reading) {
  KARST_ASSERT(root == nullptr || (info.exists() && !blocks_.tiles.empty()));
  info_ = info;
  root_ = root;
  reading_ = reading;
  box_ = exists() ? ground_box(info_) : LatticeBox();
  std::fill(blocks_.slots.begin(), blocks_.slots.end(), Slot{});
  std::fill(blocks_.heads.begin(), blocks_.heads.end(), kNowhere);
  clock_ = 0;
  failed_reads_ = tiles_read_ = 0;
  trouble_ = {};
}

void QueryGround::set_heights(std::int32_t low, std::int32_t high) {
  info_.low = low;
  info_.high = high;
  if (exists()) box_ = ground_box(info_);
}

std::uint32_t& QueryGround::head(NodeKey key) const {
  const std::uint32_t mixed = static_cast<std::uint32_t>(key.x) * 0x9e3779b1u ^
                              static_cast<std::uint32_t>(key.z) * 0x85ebca77u ^
                              static_cast<std::uint32_t>(key.size) * 0xc2b2ae3du;  // odd, of no other meaning
  return blocks_.heads[(mixed >> 8) & (blocks_.heads.size() - 1)];
}

std::uint32_t QueryGround::find(NodeKey key) const {
  std::uint32_t slot = head(key);
  while (slot != kNowhere && !(blocks_.slots[slot].key == key)) slot = blocks_.slots[slot].next;
  return slot;
}

void QueryGround::take_out(std::uint32_t slot) {
  if (blocks_.slots[slot].last_used == 0) return;
  std::uint32_t* at = &head(blocks_.slots[slot].key);
  while (*at != slot) at = &blocks_.slots[*at].next;
  *at = blocks_.slots[slot].next;
  blocks_.slots[slot] = {};
}

void QueryGround::forget(NodeKey tile) {
  const std::uint32_t slot = blocks_.heads.empty() ? kNowhere : find(tile);
  if (slot != kNowhere) take_out(slot);
}

void QueryGround::touch(std::uint32_t slot) {
  while (slot != kNowhere) {
    Slot& own = blocks_.slots[slot];
    own.last_used = ++clock_;
    const NodeKey above = own.key.parent();
    const bool is_there = own.parent != kNowhere && blocks_.slots[own.parent].last_used != 0 &&
                          blocks_.slots[own.parent].key == above;
    if (!is_there) own.parent = find(above);
    slot = own.parent;
  }
}

const Tile* QueryGround::tile(NodeKey key, const TilePlace& place, bool read) {
  if (key == tile_of({info_.top_size(), 0, 0})) return root_;
  if (const std::uint32_t slot = find(key); slot != kNowhere) {
    blocks_.slots[slot].last_used = ++clock_;
    return &blocks_.tiles[slot];
  }
  if (!read || !place.exists() || reading_.read == nullptr) return nullptr;
  if (allowance_ != nullptr && !allowance_->take()) return nullptr;
  std::uint32_t oldest = 0;
  for (std::uint32_t n = 1; n < blocks_.slots.size(); ++n) {
    if (blocks_.slots[n].last_used < blocks_.slots[oldest].last_used) oldest = n;
  }
  take_out(oldest);
  const Status status = reading_.read(reading_.context, key, place, blocks_.workspace, blocks_.tiles[oldest]);
  if (!status.ok()) {
    ++failed_reads_;
    trouble_ = status;
    return nullptr;
  }
  ++tiles_read_;
  blocks_.slots[oldest] = {key, head(key), kNowhere, ++clock_};
  head(key) = oldest;
  return &blocks_.tiles[oldest];
}

// Places of the vertices of a part; the others stay as they were.
void QueryGround::make_places(const Tile& tile, NodeKey node, Part part, Places& places) const {
  const bool is_curved = info_.basis.is_curved();
  const int face = is_curved ? face_of(info_, node) : 0;
  const int size = is_curved ? node.size : info_.page_size(node.size);
  const auto unit = static_cast<double>(std::int64_t{kVertexStep} << size);
  AxisPlace axes[2][kNodeSide];
  double lines[2][kNodeSide] = {};
  for (int n = 0; n <= part.quads; ++n) {
    const std::int64_t x = sample_around(info_, node.size, std::int64_t{node.x} * kNodeQuads + part.i + n);
    const std::int64_t z =
        sample_of(info_.samples[1], node.size, std::int64_t{node.z} * kNodeQuads + part.k + n);
    if (is_curved) {
      axes[0][n] = axis_place(info_.basis, 0, face, static_cast<double>(x));
      axes[1][n] = axis_place(info_.basis, 1, face, static_cast<double>(z));
    } else {
      lines[0][n] = static_cast<double>(place_at_size(sample_place(info_, 0, x), size)) * unit;
      lines[1][n] = static_cast<double>(place_at_size(sample_place(info_, 1, z), size)) * unit;
    }
  }
  const int first_i = (node.x & (kTileNodes - 1)) * kNodeQuads + part.i;
  const int first_k = (node.z & (kTileNodes - 1)) * kNodeQuads + part.k;
  for (int k = 0; k <= part.quads; ++k) {
    for (int i = 0; i <= part.quads; ++i) {
      const std::int32_t height = tile.height(first_i + i, first_k + k);
      glm::dvec3& out = places[static_cast<std::size_t>((part.k + k) * kNodeSide + part.i + i)];
      if (is_curved) {
        const glm::i64vec3 exact = vertex_place(info_.basis, face, axes[0][i], axes[1][k], height);
        for (int axis = 0; axis < 3; ++axis)
          out[axis] = static_cast<double>(place_at_size(exact[axis], size)) * unit;
      } else {
        out = {lines[0][i], static_cast<double>(place_at_size(height, size)) * unit, lines[1][k]};
      }
    }
  }
}

// Of a node's 2 x 2 tiles one, where the walk wants what is in its box.
void QueryGround::visit_part(const Places& places, Met met, Walk& walk) const {
  const glm::dvec3* const first = places.data() + 2 * (met.tile >> 1) * kNodeSide + 2 * (met.tile & 1);
  NodeBox box{*first, *first};
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      box.low = glm::min(box.low, first[k * kNodeSide + i]);
      box.high = glm::max(box.high, first[k * kNodeSide + i]);
    }
  }
  if (walk.distance(box) >= 0.0) walk.visit(met, TileVertices(first));
}

void QueryGround::visit_node(const Tile& tile, NodeKey node, Walk& walk) const {
  Places places;
  make_places(tile, node, Part(), places);
  for (int part = 0; part < 4; ++part) visit_part(places, Met{node, part}, walk);
}

bool QueryGround::run_at(const GridPlace& at, double within, Walk& walk) {
  if (!exists() || !(within < 1.0)) return false;
  std::int64_t from[2] = {0, 0};
  std::int64_t to[2] = {info_.samples[0] - 1, info_.samples[1] - 1};
  if (info_.is_cube()) {
    int cell[2];
    cube_cell(at.face, cell[0], cell[1]);
    for (int axis = 0; axis < 2; ++axis) {
      from[axis] = std::int64_t{cell[axis]} * info_.basis.face_quads;
      to[axis] = from[axis] + info_.basis.face_quads;
    }
  }
  // Tiles of 2 x 2 quads: one, or two that adjoin.
  std::int32_t low[2];
  std::int32_t high[2];
  for (int axis = 0; axis < 2; ++axis) {
    const double middle = axis == 0 ? at.i : at.k;
    const double first = middle - within, last = middle + within;
    if (!(first >= static_cast<double>(from[axis]) && last <= static_cast<double>(to[axis]))) return false;
    low[axis] = static_cast<std::int32_t>(std::floor(first / 2));
    high[axis] = static_cast<std::int32_t>(std::floor(last / 2));
    if (2 * std::int64_t{high[axis]} >= to[axis]) --high[axis];  // nothing begins at the last sample
  }
  const bool is_root = info_.top_size() == 0;
  const auto node_at = [](std::int32_t x, std::int32_t z) { return NodeKey{0, x >> 1, z >> 1}; };
  for (std::int32_t z = low[1]; z <= high[1] && !is_root; ++z) {
    for (std::int32_t x = low[0]; x <= high[0]; ++x) {
      if (find(tile_of(node_at(x, z))) == kNowhere) return false;
    }
  }
  Places places;
  for (std::int32_t z = low[1]; z <= high[1]; ++z) {
    for (std::int32_t x = low[0]; x <= high[0]; ++x) {
      const NodeKey node = node_at(x, z);
      if (in_region(info_, node) == InRegion::all) continue;
      const Tile* tile = root_;
      if (!is_root) {
        const std::uint32_t slot = find(tile_of(node));
        touch(slot);
        tile = &blocks_.tiles[slot];
      }
      const int part = (x & 1) | (z & 1) << 1;
      make_places(*tile, node, {2 * (x & 1), 2 * (z & 1), 2}, places);
      visit_part(places, Met{node, part}, walk);
    }
  }
  return true;
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
