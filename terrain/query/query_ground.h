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
  // After an edit: heights of all samples; and a tile that is another one now.
  void set_heights(std::int32_t low, std::int32_t high) {
    info_.low = low;
    info_.high = high;
  }
  void forget(NodeKey tile);
  const GroundInfo& info() const { return info_; }

  std::uint64_t failed_reads() const { return failed_reads_; }
  const Status& trouble() const { return trouble_; }
  std::uint64_t tiles_read() const { return tiles_read_; }

  // What of the ground may be met in a box; a node at the least size that is at hand.
  struct Met {
    NodeKey node;
    int tile;  // of the node's 2 x 2
  };

  // What walks through nodes.
  class Walk {
   public:
    // How far away a box is, in any measure; negative: it is not wanted.
    virtual double distance(const NodeBox& box) const = 0;
    // 2 x 2 quads of a node, and where they lie.
    virtual void visit(const Met& met, const TileVertices& tile) = 0;

   protected:
    ~Walk() = default;
  };

  // Nodes at the least size that is at hand, roughly nearest first. read: tiles may be read.
  void run(bool read, Walk& walk);

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

  void visit_node(const Tile& tile, NodeKey node, Walk& walk) const;

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
