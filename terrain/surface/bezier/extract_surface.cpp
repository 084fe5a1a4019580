// SPDX-License-Identifier: MIT
// K algorithm 3.1, turned around: instead of a loop over all voxels, a recursion over blocks of voxel corners
// in Morton order that stops where all eight surrounding octree cells are leaves of one kind. Volumes
// therefore come out in the octree's order in space. Adjacency is a table look-up: the neighbour across a
// cube face has the curve of the same number on the opposite face (case_tables.h).
#include "terrain/surface/bezier/extract_surface.h"

#include <glm/common.hpp>

#include "terrain/field/voxel_reader.h"
#include "terrain/surface/bezier/case_tables.h"
#include "terrain/surface/bezier/gradient.h"

namespace karst::core {
namespace {

// Stands for a cell outside the octree: it is never compared, so nothing is made on the octree's own sides.
constexpr Octree::Node kOutside = 0xfffffffeu;

// The 2 x 2 x 2 cells of one size around a block's minimum corner, by octant.
struct Cells {
  Octree::Node node[8];
};

bool uniform(const Cells& cells) {
  Octree::Node seen = kOutside;
  for (const Octree::Node node : cells.node) {
    if (node == kOutside) continue;
    if (!Octree::is_leaf(node) || (seen != kOutside && node != seen)) return false;
    seen = node;
  }
  return true;
}

// The cells of half the size around the minimum corner of child block `child`.
Cells child_cells(const Octree& octree, const Cells& cells, int child) {
  Cells result{};
  for (int o = 0; o < 8; ++o) {
    int parent = 0;
    int octant = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int upper_block = child >> axis & 1;
      const int upper_cell = o >> axis & 1;
      // Lower block: the cells meet at the parents' common plane. Upper block: both halves are the upper
      // parent's.
      parent |= (upper_block | upper_cell) << axis;
      octant |= (upper_block ? upper_cell : 1 - upper_cell) << axis;
    }
    const Octree::Node node = cells.node[parent];
    result.node[o] = node == kOutside ? kOutside : octree.child(node, octant);
  }
  return result;
}

template <class Visitor>
class CornerWalk {
 public:
  // Corners on the octree's own sides are not visited.
  CornerWalk(const ExtractSurface& job, Visitor& visitor)
      : octree_(*job.octree),
        first_(glm::max(job.low, glm::ivec3(1))),
        last_(glm::min(job.high, glm::ivec3(job.extent.x - 1, job.extent.y, job.extent.z - 1))),
        visitor_(visitor) {}

  // False when the visitor asked to stop.
  bool run() {
    Cells cells{};
    for (Octree::Node& node : cells.node) node = kOutside;
    cells.node[7] = octree_.root();
    return visit({0, 0, 0}, octree_.size(), cells);
  }

 private:
  bool visit(glm::ivec3 block, std::int32_t size, const Cells& cells) {
    const glm::ivec3 end = block + size;
    if (block.x > last_.x || block.y > last_.y || block.z > last_.z) return true;
    if (end.x <= first_.x || end.y <= first_.y || end.z <= first_.z || uniform(cells)) return true;
    if (size == 1) {
      int configuration = 0;
      for (int o = 0; o < 8; ++o) configuration |= Octree::is_filled(cells.node[o]) ? 1 << o : 0;
      return visitor_(block, configuration);
    }
    const std::int32_t half = size / 2;
    for (int child = 0; child < 8; ++child) {
      const glm::ivec3 corner = block + half * glm::ivec3(child & 1, child >> 1 & 1, child >> 2);
      if (!visit(corner, half, child_cells(octree_, cells, child))) return false;
    }
    return true;
  }

  const Octree& octree_;
  glm::ivec3 first_;
  glm::ivec3 last_;
  Visitor& visitor_;
};

// Open addressing with linear probing; entries are the first patch of the corner's volume + 1.
class CornerTable {
 public:
  CornerTable(std::span<std::uint32_t> entries, Surface surface)
      : entries_(entries), surface_(surface), mask_(static_cast<std::uint32_t>(entries.size()) - 1) {}

  void clear() {
    for (std::uint32_t& e : entries_) e = 0;
  }

  void insert(PatchId first) {
    const Volume& v = surface_.volume_of(first);
    std::uint32_t at = hash(v.corner[0], v.corner[1], v.corner[2]);
    while (entries_[at & mask_] != 0) ++at;
    entries_[at & mask_] = first + 1;
  }

  // False where the corner has no volume.
  bool find(int x, int y, int z, PatchId& first) const {
    for (std::uint32_t at = hash(x, y, z);; ++at) {
      const std::uint32_t entry = entries_[at & mask_];
      if (entry == 0) return false;
      const Volume& v = surface_.volume_of(entry - 1);
      if (v.corner[0] != x || v.corner[1] != y || v.corner[2] != z) continue;
      first = entry - 1;
      return true;
    }
  }

 private:
  static std::uint32_t hash(int x, int y, int z) {
    const std::uint32_t key = static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 10 |
                              static_cast<std::uint32_t>(z) << 20;
    return (key * 0x9e3779b1u) >> 7;  // Fibonacci hashing: 2^32 / golden ratio
  }

  std::span<std::uint32_t> entries_;
  Surface surface_;
  std::uint32_t mask_;
};

void link_inside(const ConfigurationCase& c, PatchId first, std::span<Patch> patches) {
  for (PatchId p = 0; p < c.patch_count; ++p) {
    for (std::size_t e = 0; e < 4; ++e) {
      const CaseEdge& edge = c.patch[p].edge[e];
      if (edge.kind == CaseEdge::internal)
        patches[first + p].neighbour[e] = PatchEdge::make(first + edge.a, edge.b);
    }
  }
}

// Links the curves on the positive faces of a volume with those on the negative faces of its neighbours.
void link_across(std::span<const Volume> volumes, PatchId first, const CornerTable& table,
                 std::span<Patch> patches) {
  const Volume& volume = volumes[patches[first].volume];
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t face = static_cast<std::size_t>(2 * axis + 1);
    const ConfigurationCase& own = kCaseTable[volume.configuration];
    if (own.curve[face][0] == kNoCurve) continue;
    int at[3] = {volume.corner[0], volume.corner[1], volume.corner[2]};
    ++at[axis];
    PatchId other = 0;
    if (!table.find(at[0], at[1], at[2], other)) continue;  // the surface ends here: a side of the world
    const ConfigurationCase& theirs = kCaseTable[volumes[patches[other].volume].configuration];
    for (std::size_t curve = 0; curve < kFaceCurves; ++curve) {
      if (own.curve[face][curve] == kNoCurve) continue;
      const PatchId p = first + (own.curve[face][curve] >> 2);
      const PatchId q = other + (theirs.curve[face ^ 1u][curve] >> 2);
      const int e = own.curve[face][curve] & 3;
      const int f = theirs.curve[face ^ 1u][curve] & 3;
      patches[p].neighbour[e] = PatchEdge::make(q, f);
      patches[q].neighbour[f] = PatchEdge::make(p, e);
    }
  }
}

}  // namespace

std::size_t ExtractSurface::scratch_size(std::size_t max_volumes) {
  std::size_t size = 4;
  while (size * 2 < max_volumes * 3) size *= 2;
  return size;
}

Status ExtractSurface::count(Result& result) const {
  result = {};
  if (octree == nullptr) return {StatusCode::invalid_argument, "no octree given", "octree"};
  Result counted;
  auto visitor = [&counted](glm::ivec3, int configuration) {
    ++counted.volumes;
    counted.patches += kCaseTable[static_cast<std::size_t>(configuration)].patch_count;
    return true;
  };
  CornerWalk walk(*this, visitor);
  walk.run();
  result = counted;
  return {};
}

Status ExtractSurface::validate() const {
  if (octree == nullptr) return {StatusCode::invalid_argument, "no octree given", "octree"};
  const std::int32_t size = octree->size();
  const bool fits = extent.x >= 2 && extent.x <= size && extent.z >= 2 && extent.z <= size && extent.y >= 1 &&
                    extent.y < size;
  if (!fits)
    return {StatusCode::invalid_argument, "extent lies outside the octree or leaves no empty layer on top",
            "extent"};
  const std::size_t n = scratch.size();
  if (n < scratch_size(volumes.size()) || (n & (n - 1)) != 0) {
    return {StatusCode::limit_reached, "scratch is too small or no power of two", "max_scratch",
            scratch_size(volumes.size())};
  }
  if (patches.size() > kMaxPatchId)
    return {StatusCode::invalid_argument, "more patches than a PatchId can name", "patches"};
  return {};
}

Status ExtractSurface::run(Result& result) const {
  result = {};
  if (const Status status = validate(); !status.ok()) return status;
  Status status;
  Result made;
  NeighbourhoodReader reader(VoxelReader(*octree, extent, mirrors));
  auto visitor = [&](glm::ivec3 corner, int configuration) {
    const ConfigurationCase& c = kCaseTable[static_cast<std::size_t>(configuration)];
    if (made.volumes == volumes.size()) {
      status = {StatusCode::limit_reached, "intersection volumes are used up", "max_volumes",
                made.volumes + 1};
    } else if (made.patches + c.patch_count > patches.size()) {
      status = {StatusCode::limit_reached, "patches are used up", "max_patches",
                made.patches + c.patch_count};
    }
    if (!status.ok()) return false;
    Volume& v = volumes[made.volumes];
    for (int axis = 0; axis < 3; ++axis) v.corner[axis] = static_cast<std::uint16_t>(corner[axis]);
    v.configuration = static_cast<std::uint8_t>(configuration);
    v.patch_count = c.patch_count;
    corner_gradients(reader.read(corner), v.gradient);
    for (std::uint8_t p = 0; p < c.patch_count; ++p) {
      Patch& patch = patches[made.patches + p];
      patch = Patch{};
      patch.volume = made.volumes;
      patch.case_patch = p;
      patch.collapsed = c.patch[p].edge[3].kind == CaseEdge::collapsed;
      patch.height_block = kNoHeights;
    }
    ++made.volumes;
    made.patches += c.patch_count;
    return true;
  };
  CornerWalk walk(*this, visitor);
  if (!walk.run()) return status;

  CornerTable table(scratch, {volumes, patches});
  table.clear();
  for (PatchId first = 0; first < made.patches; first += volumes[patches[first].volume].patch_count)
    table.insert(first);
  for (PatchId first = 0; first < made.patches;) {
    const Volume& v = volumes[patches[first].volume];
    link_inside(kCaseTable[v.configuration], first, patches);
    link_across(volumes, first, table, patches);
    first += v.patch_count;
  }
  result = made;
  return {};
}

}  // namespace karst::core
