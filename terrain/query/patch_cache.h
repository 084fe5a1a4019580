// SPDX-License-Identifier: MIT
// What a Query keeps of patches: their vertices at one level with a hierarchy of boxes, made when they are
// asked for, the ones not asked for longest giving way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/budget.h"
#include "terrain/base/simd.h"
#include "terrain/cull/bounds_tree.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/heights.h"
#include "terrain/resident/height_cache.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// What one octree makes. Its patches are numbered from 0, `first` + that for whoever asks.
struct QueryPart {
  Surface surface;
  std::span<const PatchBounds> bounds;  // one a patch
  const BoundsTree* tree = nullptr;     // over them
  glm::ivec3 corner{0};                 // of the octree, voxels from the world's
  PatchId first = 0;
};

// The world that queries ask; borrowed, and constant while they do. Itself the first part.
struct QueryWorld : QueryPart {
  std::span<const QueryPart> others = {};  // in the order of their patches
  // heights.level is the world's. samples: of all blocks, or empty: then source reads them, group by group.
  Heights heights;
  std::uint32_t height_blocks = 0;
  HeightSource source;  // several queries may read at once

  std::size_t parts() const { return 1 + others.size(); }
  const QueryPart& part(std::size_t n) const { return n == 0 ? *this : others[n - 1]; }
  const QueryPart& part_of(PatchId patch) const {
    std::size_t n = 0;
    while (n < others.size() && others[n].first <= patch) ++n;
    return part(n);
  }
};

// Four boxes in lattice steps from the patch's origin, exact in float: the children of a node of the tree of
// tiles. Lane c has the children's quadrant c: lower and upper half in i, then in j.
struct TileNode {
  simd::Float4 min[3];
  simd::Float4 max[3];
};

// The vertices of a patch and the tree over its tiles, 2 x 2 cells each.
struct QueryPatch {
  glm::ivec3 origin{0};                     // of the patch, lattice steps from the world's corner
  const std::int16_t* positions = nullptr;  // [j * side + i][axis], lattice steps from origin
  const TileNode* nodes =
      nullptr;    // children of node k are 4k + 1 .. 4k + 4, tiles the leaves; null at level 1
  int level = 0;  // of positions, 1..kMaxLevel
  bool displaced = true;
};

// Of reading the file, for all that a query does.
struct ReadAllowance {
  std::uint32_t left = 0xffffffffu;  // reads
  std::uint64_t refused = 0;

  bool take() {
    if (left == 0) {
      ++refused;
      return false;
    }
    if (left != 0xffffffffu) --left;
    return true;
  }
};

class QueryPatches {
 public:
  // A Config's numbers, so that memory is planned before there is a world.
  struct Limits {
    int level = 3;                // 1..kMaxLevel: of the surface that is met
    std::uint32_t patches = 128;  // that are kept ready, 1..2^24; about 1 KiB each at level 3
    int max_level = 5;            // level..kMaxLevel: of the largest world's heights
  };

  static void add_to(Budget& budget, const Limits& limits);
  Status create(const Limits& limits, Arena& arena);
  Status set_world(const QueryWorld& world);
  // Borrowed; null: all reads are allowed. After create().
  void set_allowance(ReadAllowance* allowance) { allowance_ = allowance; }

  // Forgets patches that have changed.
  void forget(std::span<const PatchId> patches);

  const QueryWorld& world() const { return world_; }
  int level() const { return level_; }
  std::uint32_t capacity() const { return static_cast<std::uint32_t>(blocks_.links.size()); }

  // Vertices of a patch; they stay until the next call. read: heights may be read from the source. Where they
  // can't be had, the patch is undisplaced.
  QueryPatch get(PatchId patch, bool read);

  // How far undisplaced patches may stand out of the boxes of the tree, lattice steps; 0 where all heights
  // are in memory.
  std::int32_t undisplaced_reach() const { return undisplaced_reach_; }

  std::uint64_t failed_reads() const { return failed_reads_; }  // since set_world()
  const Status& trouble() const { return trouble_; }
  std::uint64_t groups_read() const { return groups_read_; }

  // Values of a patch's vertices, and nodes of the tree over its tiles.
  static constexpr std::size_t position_values(int level) {
    return (3 * static_cast<std::size_t>(patch_vertices(level)) + 7) / 8 * 8;
  }
  static constexpr std::size_t node_count(int level) {
    return ((std::size_t{1} << (2 * (level - 1))) - 1) / 3;
  }

 private:
  static constexpr std::uint32_t kNowhere = 0xffffffffu;
  // A slot's place in the list of a hash value, and in the list by last use.
  struct Link {
    PatchId patch = 0;
    std::uint32_t next = kNowhere;
    std::uint32_t newer = kNowhere;
    std::uint32_t older = kNowhere;
  };

  struct Blocks {
    std::span<std::int16_t> positions;
    std::span<TileNode> nodes;
    std::span<Link> links;
    std::span<std::uint32_t> heads;
    std::span<std::int16_t> group;  // the group of heights that was read last

    template <class Visit>
    void each_block(const Limits& limits, Visit&& visit) {
      const std::size_t slots = limits.patches;
      visit(Consumer::queries, slots * position_values(limits.level), positions);
      visit(Consumer::queries, slots * node_count(limits.level), nodes);
      visit(Consumer::queries, slots, links);
      visit(Consumer::queries, head_count(limits.patches), heads);
      visit(Consumer::queries,
            std::size_t{kHeightGroup} * static_cast<std::size_t>(patch_vertices(limits.max_level)), group);
    }
  };

  static std::size_t head_count(std::uint32_t slots);
  std::uint32_t& head(PatchId patch) const;
  std::uint32_t find(PatchId patch) const;
  std::uint32_t take_slot(PatchId patch);
  void unlink(std::uint32_t slot);
  void use(std::uint32_t slot);
  bool heights_of(PatchId patch, bool read, Heights& heights);
  QueryPatch undisplaced(PatchId patch);
  void make(PatchId patch, const Heights& heights, std::uint32_t slot);

  Limits limits_;
  Blocks blocks_;
  QueryWorld world_;
  ReadAllowance* allowance_ = nullptr;
  int level_ = 0;
  std::int32_t undisplaced_reach_ = 0;
  std::uint32_t group_held_ = kNowhere;
  std::uint32_t filled_ = 0;
  std::uint32_t newest_ = kNowhere;
  std::uint32_t oldest_ = kNowhere;
  std::uint64_t groups_read_ = 0;
  std::uint64_t failed_reads_ = 0;
  Status trouble_;                                   // of the last failed read
  std::int16_t coarse_[3 * patch_vertices(1)] = {};  // of the last undisplaced patch
};

}  // namespace karst::core
