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
  void set_heights(std::int32_t low, std::int32_t high);
  void forget(NodeKey tile);
  // Borrowed; null: all reads are allowed.
  void set_allowance(ReadAllowance* allowance) { allowance_ = allowance; }
  const GroundInfo& info() const { return info_; }
  const LatticeBox& box() const { return box_; }  // ground_box()

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
  // The same of what lies at a place of the grid and within so many samples of it, without looking for it
  // from the root on. False, and nothing is visited: not all of it is at hand at size 0, or it is not all
  // between the first and the last samples (of a face).
  bool run_at(const GridPlace& at, double within, Walk& walk);

 private:
  static constexpr std::uint32_t kNowhere = 0xffffffffu;
  struct Slot {
    NodeKey key;
    std::uint32_t next = kNowhere;    // of the same hash value
    std::uint32_t parent = kNowhere;  // where the parent was last
    std::uint64_t last_used = 0;      // 0: empty
  };
  // Quads of a node, in nodes' rows of vertices.
  struct Part {
    int i = 0, k = 0;  // the first
    int quads = kNodeQuads;
  };
  using Places = std::array<glm::dvec3, kNodeVertices>;  // rows from the north, west first
  struct Blocks {
    std::span<Tile> tiles;
    std::span<Slot> slots;
    std::span<std::uint32_t> heads;
    std::span<std::byte> workspace;

    template <class Visit>
    void each_block(const Limits& limits, Visit&& visit) {
      visit(Consumer::queries, limits.tiles, tiles);
      visit(Consumer::queries, limits.tiles, slots);
      visit(Consumer::queries, head_count(limits.tiles), heads);
      visit(Consumer::queries, limits.workspace, workspace);
    }
  };

  static std::size_t head_count(std::uint32_t tiles);
  std::uint32_t& head(NodeKey key) const;
  std::uint32_t find(NodeKey key) const;
  void take_out(std::uint32_t slot);
  // A tile and those above it are used now.
  void touch(std::uint32_t slot);
  // Valid until the next call. Null: not there, and not to be read or not readable.
  const Tile* tile(NodeKey key, const TilePlace& place, bool read);
  void make_places(const Tile& tile, NodeKey node, Part part, Places& places) const;
  void visit_node(const Tile& tile, NodeKey node, Walk& walk) const;
  void visit_part(const Places& places, Met met, Walk& walk) const;

  GroundInfo info_;
  LatticeBox box_;
  const Tile* root_ = nullptr;
  TileReading reading_;
  Blocks blocks_;
  ReadAllowance* allowance_ = nullptr;
  std::uint64_t clock_ = 0;
  std::uint64_t failed_reads_ = 0;
  std::uint64_t tiles_read_ = 0;
  Status trouble_;
};

}  // namespace karst::core
