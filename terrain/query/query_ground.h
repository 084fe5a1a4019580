// SPDX-License-Identifier: MIT
// The ground as queries meet it: at size 0, by tiles of a cache of their own. Where a tile is not at hand, a
// coarser size answers.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/budget.h"
#include "terrain/ground/ground_box.h"
#include "terrain/ground/tile.h"
#include "terrain/query/triangles.h"

namespace karst::core {

// Reads tiles for several queries at a time.
struct TileReading {
  const void* context = nullptr;  // borrowed, handed to read
  // workspace: as many bytes as the limits say. io, corrupt: there is no such tile then.
  Status (*read)(const void* context, NodeKey tile, const TilePlace& place, std::span<std::byte> workspace,
                 Tile& out) = nullptr;
};

class QueryGround {
 public:
  struct Limits {
    std::uint32_t tiles = 0;    // 0: no ground is asked; else at least kLeastTiles
    std::size_t workspace = 0;  // bytes that reading takes
  };
  // Those from the root's to one of size 0.
  static constexpr std::uint32_t kLeastTiles = kMostSize + 2;

  static void add_to(Budget& budget, const Limits& limits);
  Status create(const Limits& limits, Arena& arena);

  // root: borrowed, constant; null: there is no ground.
  void set_ground(const GroundInfo& info, const Tile* root, const TileReading& reading);
  bool exists() const { return root_ != nullptr; }
  const GroundInfo& info() const { return info_; }

  std::uint64_t failed_reads() const { return failed_reads_; }
  const Status& trouble() const { return trouble_; }
  std::uint64_t tiles_read() const { return tiles_read_; }

  // What of the ground may be met in a box; a node at the least size that is at hand.
  struct Met {
    NodeKey node;
    int tile;  // of the node's 2 x 2
  };

  // Calls visit(met, vertices of a tile of 2 x 2 quads) for nodes for whose box meets(box) is true, roughly
  // in the order of before(a, b), which compares boxes. read: tiles may be read.
  template <class Meets, class Before, class Visit>
  void walk(bool read, Meets&& meets, Before&& before, Visit&& visit) {
    if (!exists()) return;
    struct Entry {
      NodeKey node;
      TilePlace place;  // of its tile; the root's has none
      NodeBox box;
    };
    std::array<Entry, 3 * (kMostSize + 2)> stack;
    std::size_t depth = 0;
    const NodeKey top{info_.top_size(), 0, 0};
    stack[depth++] = {top, {}, node_box(info_, root_->nodes[0], top)};
    while (depth > 0) {
      const Entry at = stack[--depth];
      if (!meets(at.box)) continue;
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
        if (again != nullptr) visit_node(*again, at.node, visit);
        continue;
      }
      const std::size_t bottom = depth;
      for (int quadrant = 0; quadrant < 4; ++quadrant) {
        const NodeKey child = at.node.child(quadrant);
        if (!node_exists(info_, child)) continue;
        const Entry entry{child, place, node_box(info_, finer->nodes[node_in_tile(child)], child)};
        std::size_t to = depth++;
        for (; to > bottom && before(stack[to - 1].box, entry.box); --to) stack[to] = stack[to - 1];
        stack[to] = entry;
      }
    }
  }

 private:
  struct Slot {
    NodeKey key;
    std::uint64_t last_used = 0;  // 0: empty
  };
  struct Blocks {
    std::span<Tile> tiles;
    std::span<Slot> slots;
    std::span<std::byte> workspace;

    template <class Visit>
    void each_block(const Limits& limits, Visit&& visit) {
      visit(Consumer::queries, limits.tiles, tiles);
      visit(Consumer::queries, limits.tiles, slots);
      visit(Consumer::queries, limits.workspace, workspace);
    }
  };

  // Valid until the next call. Null: not there, and not to be read or not readable.
  const Tile* tile(NodeKey key, const TilePlace& place, bool read);
  void make_places(const Tile& tile, NodeKey node, std::array<glm::dvec3, kNodeVertices>& places) const;

  template <class Visit>
  void visit_node(const Tile& tile, NodeKey node, Visit& visit) const {
    std::array<glm::dvec3, kNodeVertices> places;  // rows from the north, west first
    make_places(tile, node, places);
    for (int part = 0; part < 4; ++part) {
      visit(Met{node, part}, TileVertices(places.data() + 2 * (part >> 1) * kNodeSide + 2 * (part & 1)));
    }
  }

  GroundInfo info_;
  const Tile* root_ = nullptr;
  TileReading reading_;
  Blocks blocks_;
  std::uint64_t clock_ = 0;
  std::uint64_t failed_reads_ = 0;
  std::uint64_t tiles_read_ = 0;
  Status trouble_;
};

}  // namespace karst::core
