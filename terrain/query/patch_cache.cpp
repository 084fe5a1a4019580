// SPDX-License-Identifier: MIT
// Slots are found through a hash table with chains and given up by a list in the order of use, so the cost of
// neither grows with their number.
#include "terrain/query/patch_cache.h"

#include <algorithm>

#include "terrain/base/storage_plan.h"
#include "terrain/patch/displacement.h"

namespace karst::core {
namespace {

using simd::Int4;

constexpr PatchId kNoPatch = 0xffffffffu;

// Vertices of a patch lie within half a voxel of its origin before they are displaced.
constexpr std::int32_t kUndisplacedReach = kStepsPerHalfVoxel;

void make_positions(const PatchShape& shape, std::int16_t* out) {
  const int side = patch_side(shape.level);
  float line[3][patch_side(kMaxLevel) + simd::kLanes];
  for (int j = 0; j < side; ++j) {
    displace_line(shape, {0, j, 1, 0}, glm::vec3(0), line[0], line[1], line[2]);
    for (int i = 0; i < side; ++i) {
      for (const auto& axis : line) *out++ = static_cast<std::int16_t>(axis[i]);
    }
  }
}

glm::ivec3 origin_of(const QueryPart& part, PatchId patch) {
  return patch_origin(part.surface.volume_of(patch - part.first)) + part.corner * kStepsPerVoxel;
}

struct Box {
  Int4 min, max;  // lanes are axes
};

Box tile_box(const std::int16_t* positions, int level, int a, int b) {
  const int side = patch_side(level);
  Box box{};
  for (int j = 2 * b; j <= 2 * b + 2; ++j) {
    const std::int16_t* p = positions + 3 * (j * side + 2 * a);
    for (int i = 0; i < 3; ++i, p += 3) {
      const Int4 at = {p[0], p[1], p[2], 0};
      if (i == 0 && j == 2 * b) {
        box = {at, at};
      } else {
        box.min = simd::select(at < box.min, at, box.min);
        box.max = simd::select(at > box.max, at, box.max);
      }
    }
  }
  return box;
}

// Fills node `node`, whose tiles are from (a, b) on, 2^log2 a side, and those below it; returns its box.
Box make_nodes(const std::int16_t* positions, int level, TileNode* nodes, std::size_t node, int log2, int a,
               int b) {
  if (log2 == 0) return tile_box(positions, level, a, b);
  const int half = 1 << (log2 - 1);
  Box all{};
  for (int c = 0; c < 4; ++c) {
    const Box box = make_nodes(positions, level, nodes, 4 * node + 1 + static_cast<std::size_t>(c), log2 - 1,
                               a + (c & 1) * half, b + (c >> 1) * half);
    for (int axis = 0; axis < 3; ++axis) {
      nodes[node].min[axis][c] = static_cast<float>(box.min[axis]);
      nodes[node].max[axis][c] = static_cast<float>(box.max[axis]);
    }
    if (c == 0) {
      all = box;
    } else {
      all.min = simd::select(box.min < all.min, box.min, all.min);
      all.max = simd::select(box.max > all.max, box.max, all.max);
    }
  }
  return all;
}

}  // namespace

std::size_t QueryPatches::head_count(std::uint32_t slots) {
  std::size_t count = 1;
  while (count < slots) count *= 2;
  return count;
}

void QueryPatches::add_to(Budget& budget, const Limits& limits) {
  Blocks blocks;
  blocks.each_block(limits, CountBlocks(budget));
}

Status QueryPatches::create(const Limits& limits, Arena& arena) {
  *this = QueryPatches();
  if (limits.level < 1 || limits.level > kMaxLevel) {
    return {StatusCode::invalid_argument, "a level is 1 to 6", "query_level",
            static_cast<std::uint64_t>(limits.level)};
  }
  if (limits.max_level < limits.level || limits.max_level > kMaxLevel) {
    return {StatusCode::invalid_argument, "less than query_level, or above 6", "max_level",
            static_cast<std::uint64_t>(limits.max_level)};
  }
  if (limits.patches < 1 || limits.patches > 1u << 24) {
    return {StatusCode::invalid_argument, "1 to 2^24 patches", "query_patches", limits.patches};
  }
  TakeBlocks take(arena);
  blocks_.each_block(limits, take);
  if (!take.complete()) {
    *this = QueryPatches();
    return {StatusCode::limit_reached, "the memory given is smaller than the budget", "memory"};
  }
  limits_ = limits;
  return {};
}

Status QueryPatches::set_world(const QueryWorld& world) {
  level_ = 0;
  for (std::size_t n = 0; n < world.parts(); ++n) {
    const QueryPart& part = world.part(n);
    const std::size_t patches = part.surface.patches.size();
    if (part.bounds.size() != patches) {
      return {StatusCode::invalid_argument, "must hold one box a patch", "bounds", part.bounds.size()};
    }
    if (part.tree == nullptr || part.tree->patches() != patches) {
      return {StatusCode::invalid_argument, "not a tree over the surface", "tree"};
    }
  }
  if (world.heights.level < 1 || world.heights.level > kMaxLevel ||
      (world.height_blocks > 0 && world.heights.samples.empty() && world.source.read == nullptr)) {
    return {StatusCode::invalid_argument, "neither heights nor a way to read them", "heights"};
  }
  if (world.heights.level > limits_.max_level) {
    return {StatusCode::limit_reached, "the world is larger than a limit", "max_level",
            static_cast<std::uint64_t>(world.heights.level)};
  }
  world_ = world;
  level_ = std::min(limits_.level, world.heights.level);
  std::fill(blocks_.heads.begin(), blocks_.heads.end(), kNowhere);
  group_held_ = newest_ = oldest_ = kNowhere;
  filled_ = 0;
  failed_reads_ = 0;
  trouble_ = {};
  undisplaced_reach_ = 0;
  if (world.height_blocks == 0 || !world.heights.samples.empty()) return {};
  for (std::size_t n = 0; n < world.parts(); ++n) {
    for (const PatchBounds& box : world.part(n).bounds) {
      for (int axis = 0; axis < 3; ++axis) {
        undisplaced_reach_ = std::max(
            {undisplaced_reach_, box.min[axis] + kUndisplacedReach, kUndisplacedReach - box.max[axis]});
      }
    }
  }
  return {};
}

std::uint32_t& QueryPatches::head(PatchId patch) const {
  return blocks_.heads[(patch * 0x9e3779b1u >> 8) &
                       (blocks_.heads.size() - 1)];  // Fibonacci hashing: 2^32 / golden ratio
}

std::uint32_t QueryPatches::find(PatchId patch) const {
  std::uint32_t slot = head(patch);
  while (slot != kNowhere && blocks_.links[slot].patch != patch) slot = blocks_.links[slot].next;
  return slot;
}

// Takes a slot out of the list by use.
void QueryPatches::unlink(std::uint32_t slot) {
  const Link& link = blocks_.links[slot];
  (link.newer == kNowhere ? newest_ : blocks_.links[link.newer].older) = link.older;
  (link.older == kNowhere ? oldest_ : blocks_.links[link.older].newer) = link.newer;
}

void QueryPatches::use(std::uint32_t slot) {
  blocks_.links[slot].newer = kNowhere;
  blocks_.links[slot].older = newest_;
  (newest_ == kNowhere ? oldest_ : blocks_.links[newest_].newer) = slot;
  newest_ = slot;
}

// A slot for a patch that has none: an unused one, or that of the patch not asked for longest.
std::uint32_t QueryPatches::take_slot(PatchId patch) {
  std::uint32_t slot = filled_;
  if (filled_ < blocks_.links.size()) {
    ++filled_;
  } else {
    slot = oldest_;
    unlink(slot);
    std::uint32_t* at = &head(blocks_.links[slot].patch);
    while (*at != slot) at = &blocks_.links[*at].next;
    *at = blocks_.links[slot].next;
  }
  blocks_.links[slot].patch = patch;
  blocks_.links[slot].next = head(patch);
  head(patch) = slot;
  use(slot);
  return slot;
}

// A slot that is forgotten holds a patch that there is none of, until it is taken again as the oldest.
void QueryPatches::forget(std::span<const PatchId> patches) {
  for (const PatchId patch : patches) {
    const std::uint32_t slot = find(patch);
    if (slot == kNowhere) continue;
    std::uint32_t* at = &head(patch);
    while (*at != slot) at = &blocks_.links[*at].next;
    *at = blocks_.links[slot].next;
    blocks_.links[slot].patch = kNoPatch;
    blocks_.links[slot].next = head(kNoPatch);
    head(kNoPatch) = slot;
  }
}

// False: they are not in memory, and may not or can't be read.
bool QueryPatches::heights_of(PatchId patch, bool read, Heights& heights) {
  const QueryPart& part = world_.part_of(patch);
  const std::uint32_t block = part.surface.patches[patch - part.first].height_block;
  heights = world_.heights;
  if (block == kNoHeights || !world_.heights.samples.empty()) return true;
  const std::uint32_t group = block / kHeightGroup;
  const std::size_t samples = static_cast<std::size_t>(patch_vertices(world_.heights.level));
  const std::uint32_t blocks = std::min(kHeightGroup, world_.height_blocks - group * kHeightGroup);
  if (group != group_held_) {
    if (!read || (allowance_ != nullptr && !allowance_->take())) return false;
    group_held_ = kNowhere;
    const Status status =
        world_.source.read(world_.source.context, group, blocks_.group.first(blocks * samples));
    if (!status.ok()) {
      ++failed_reads_;
      trouble_ = status;
      return false;
    }
    ++groups_read_;
    group_held_ = group;
  }
  // The block is the one of these samples, whatever its number in the file.
  heights.samples = blocks_.group.subspan(block % kHeightGroup * samples, samples);
  heights.groups = {};
  return true;
}

QueryPatch QueryPatches::undisplaced(PatchId patch) {
  const QueryPart& part = world_.part_of(patch);
  make_positions(PatchShape::make(part.surface, Heights{}, 1, patch - part.first), coarse_);
  return {origin_of(part, patch), coarse_, nullptr, 1, false};
}

QueryPatch QueryPatches::get(PatchId patch, bool read) {
  std::uint32_t slot = find(patch);
  if (slot == newest_ && slot != kNowhere) {
    // It is where it would be moved to.
  } else if (slot != kNowhere) {
    unlink(slot);
    use(slot);
  } else {
    Heights heights;
    if (!heights_of(patch, read, heights)) return undisplaced(patch);
    slot = take_slot(patch);
    make(patch, heights, slot);
  }
  return {origin_of(world_.part_of(patch), patch),
          blocks_.positions.data() + slot * position_values(limits_.level),
          blocks_.nodes.data() + slot * node_count(limits_.level), level_, true};
}

void QueryPatches::make(PatchId patch, const Heights& heights, std::uint32_t slot) {
  const QueryPart& part = world_.part_of(patch);
  Patch own = part.surface.patches[patch - part.first];
  if (own.height_block != kNoHeights && world_.heights.samples.empty()) own.height_block = 0;
  PatchShape shape = PatchShape::make({part.surface.volumes, {&own, 1}}, heights, level_, 0);
  std::int16_t* positions = blocks_.positions.data() + slot * position_values(limits_.level);
  make_positions(shape, positions);
  make_nodes(positions, level_, blocks_.nodes.data() + slot * node_count(limits_.level), 0, level_ - 1, 0, 0);
}

}  // namespace karst::core
