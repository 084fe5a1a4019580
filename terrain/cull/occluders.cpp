// SPDX-License-Identifier: MIT
// Two copies of the cells of each kind as rows of bits, along x and along z: a rectangle across any axis is
// then a few rows of consecutive bits.
#include "terrain/cull/occluders.h"

#include <algorithm>
#include <bit>

#include <glm/common.hpp>

#include "terrain/surface/bezier/case_tables.h"

namespace karst::core {
namespace {

// Coarsest cells that are of use: a rectangle needs a cell's width of rock.
constexpr int kMostCellLog2 = 3;

// Cells of a size, of 2^(kLatticeBits + cell_log2) steps.
constexpr int cell_bits(int cell_log2) {
  return kLatticeBits + cell_log2;
}

glm::ivec3 cells_of(glm::ivec3 extent, int cell_log2) {
  // Cells that stick out of the world are of no kind.
  return cell_log2 < 0 ? extent << -cell_log2 : extent >> cell_log2;
}

int words_of(int cells) {
  return (cells + 63) / 64;
}

// Bits first..last of the word that holds cells 64 w ...
std::uint64_t mask_of(int word, int first, int last) {
  std::uint64_t mask = ~std::uint64_t{0};
  if (first > word * 64) mask &= ~std::uint64_t{0} << (first - word * 64);
  if (last < word * 64 + 63) mask &= ~std::uint64_t{0} >> (word * 64 + 63 - last);
  return mask;
}

bool touches(const LatticeBox& a, glm::dvec3 low, glm::dvec3 high) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.max[axis] < low[axis] || a.min[axis] > high[axis]) return false;
  }
  return true;
}

// Calls visit(face) for each face of its volume on which the patch has an edge that leads nowhere: the world
// ends there. Faces as in case_tables.h.
template <class Visit>
void for_each_open_face(const Surface& surface, PatchId id, Visit visit) {
  const Patch& patch = surface.patches[id];
  const PatchCase& shape = kCaseTable[surface.volume_of(id).configuration].patch[patch.case_patch];
  for (std::size_t e = 0; e < 4; ++e) {
    if (!patch.neighbour[e].exists() && shape.edge[e].kind == CaseEdge::external) visit(shape.edge[e].a);
  }
}

// Calls visit(patch) for all whose boxes, made larger by `wide`, touch low..high, and maybe some beside them,
// until it returns false; by a stack of nodes: row << 28 | node. Whether none did.
template <class Visit>
bool for_each_near(const BoundsTree& tree, const Surface& surface, glm::dvec3 low, glm::dvec3 high,
                   double wide, Visit visit) {
  if (tree.rows() == 0) return true;  // a ground has no patches
  std::uint32_t stack[BoundsTree::kFanOut * BoundsTree::kMaxRows];
  int top = 0;
  stack[top++] = static_cast<std::uint32_t>(tree.rows() - 1) << 28;
  while (top > 0) {
    const std::uint32_t entry = stack[--top];
    const int row = static_cast<int>(entry >> 28);
    const std::uint32_t n = entry & 0x0fffffffu;
    if (!touches(tree.node(row, n), low - wide, high + wide)) continue;
    if (row == 0) {
      const PatchId first = tree.first_patch(0, n);
      for (PatchId id = first; id < first + tree.patch_count(0, n); ++id) {
        if (!surface.is_free(id) && !visit(id)) return false;
      }
      continue;
    }
    const std::uint32_t end = std::min((n + 1) * BoundsTree::kFanOut, tree.nodes(row - 1));
    for (std::uint32_t child = n * BoundsTree::kFanOut; child < end; ++child) {
      stack[top++] = static_cast<std::uint32_t>(row - 1) << 28 | child;
    }
  }
  return true;
}

}  // namespace

LatticeBox swept_box(const Surface& surface, std::span<const PatchBounds> bounds, PatchId id) {
  const Patch& patch = surface.patches[id];
  const Volume& volume = surface.volumes[patch.volume];
  LatticeBox box = patch_box(surface, bounds, id);
  const PatchCase& shape = kCaseTable[volume.configuration].patch[patch.case_patch];
  const glm::ivec3 origin = patch_origin(volume);
  for (const auto& row : shape.control) {
    for (const auto& c : row) {
      const glm::ivec3 p = origin + glm::ivec3(c[0], c[1], c[2]) * kStepsPerHalfVoxel;
      box.min = glm::min(box.min, p);
      box.max = glm::max(box.max, p);
    }
  }
  box.min -= Occluders::kMargin;
  box.max += Occluders::kMargin;
  return box;
}

std::size_t Occluders::word_count(glm::ivec3 extent, int cell_log2) {
  const glm::ivec3 cells = cells_of(extent, cell_log2);
  const auto y = static_cast<std::size_t>(cells.y);
  return 2 * (y * static_cast<std::size_t>(cells.z) * static_cast<std::size_t>(words_of(cells.x)) +
              y * static_cast<std::size_t>(cells.x) * static_cast<std::size_t>(words_of(cells.z)));
}

void Occluders::clear_cells(Kind kind, glm::ivec3 low, glm::ivec3 high) {
  const Bits& bits = bits_[static_cast<std::size_t>(kind)];
  low = glm::max(low, glm::ivec3(0));
  high = glm::min(high, size_ - 1);
  if (low.x > high.x || low.y > high.y || low.z > high.z) return;
  const auto clear_row = [](std::uint64_t* row, int first, int last) {
    for (int w = first / 64; w <= last / 64; ++w) row[w] &= ~mask_of(w, first, last);
  };
  for (int y = low.y; y <= high.y; ++y) {
    for (int z = low.z; z <= high.z; ++z) {
      clear_row(bits.along_x.data() + (y * size_.z + z) * words_x_, low.x, high.x);
    }
    for (int x = low.x; x <= high.x; ++x) {
      clear_row(bits.along_z.data() + (y * size_.x + x) * words_z_, low.z, high.z);
    }
  }
}

void Occluders::fill_cells(glm::ivec3 low, glm::ivec3 high) {
  const auto fill_row = [](std::uint64_t* row, int first, int last) {
    for (int w = first / 64; w <= last / 64; ++w) row[w] |= mask_of(w, first, last);
  };
  for (const Bits& bits : bits_) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int z = low.z; z <= high.z; ++z)
        fill_row(bits.along_x.data() + (y * size_.z + z) * words_x_, low.x, high.x);
      for (int x = low.x; x <= high.x; ++x)
        fill_row(bits.along_z.data() + (y * size_.x + x) * words_z_, low.z, high.z);
    }
  }
}

void Occluders::clear_leaves(const Octree& octree, Octree::Node node, glm::ivec3 origin, int size,
                             glm::ivec3 low, glm::ivec3 high) {
  const int shift = cell_bits(cell_log2_);
  const glm::ivec3 first = origin * kStepsPerVoxel >> shift;
  const glm::ivec3 last = ((origin + size) * kStepsPerVoxel - 1) >> shift;
  for (int axis = 0; axis < 3; ++axis) {
    if (first[axis] > high[axis] || last[axis] < low[axis]) return;
  }
  if (Octree::is_leaf(node)) {
    clear_cells(Octree::is_filled(node) ? Kind::air : Kind::rock, glm::max(first, low), glm::min(last, high));
    return;
  }
  const int half = size / 2;
  for (int o = 0; o < 8; ++o) {
    clear_leaves(octree, octree.child(node, o), origin + half * glm::ivec3(o & 1, o >> 1 & 1, o >> 2 & 1),
                 half, low, high);
  }
}

void Occluders::find_interior(const Surface& surface, std::span<const PatchBounds> bounds,
                              glm::ivec3 extent) {
  // The surface ends half a voxel inside the sides, and above the lowest voxels' centres.
  interior_.min = glm::ivec3(kStepsPerHalfVoxel);
  interior_.max = extent * kStepsPerVoxel - kStepsPerHalfVoxel;
  interior_.max.y = kBoxReach;
  for (PatchId id = 0; id < surface.patches.size(); ++id) {
    if (surface.is_free(id)) continue;
    for_each_open_face(surface, id, [&](int face) {
      const LatticeBox box = swept_box(surface, bounds, id);
      const int axis = face / 2;
      if ((face & 1) != 0) {
        interior_.max[axis] = std::min(interior_.max[axis], box.min[axis] - 1);
      } else {
        interior_.min[axis] = std::max(interior_.min[axis], box.max[axis] + 1);
      }
    });
  }
}

void Occluders::build(const Octree& octree, glm::ivec3 extent, const Surface& surface,
                      std::span<const PatchBounds> bounds) {
  clear();
  cell_log2_ = kLeastCellLog2;
  while (word_count(extent, cell_log2_) > storage_.size()) ++cell_log2_;
  const glm::ivec3 cells = cells_of(extent, cell_log2_);
  if (cell_log2_ > kMostCellLog2 || cells.x == 0 || cells.y == 0 || cells.z == 0) return;
  size_ = cells;
  extent_ = extent;
  words_x_ = words_of(size_.x);
  words_z_ = words_of(size_.z);
  const auto rows = [&](int other) { return static_cast<std::size_t>(size_.y * other); };
  std::size_t used = 0;
  const auto take = [&](std::size_t words) {
    used += words;
    const std::span<std::uint64_t> taken = storage_.subspan(used - words, words);
    std::fill(taken.begin(), taken.end(), ~std::uint64_t{0});
    return taken;
  };
  for (Bits& bits : bits_) {
    bits.along_x = take(rows(size_.z) * static_cast<std::size_t>(words_x_));
    bits.along_z = take(rows(size_.x) * static_cast<std::size_t>(words_z_));
  }
  clear_leaves(octree, octree.root(), glm::ivec3(0), octree.size(), glm::ivec3(0), size_ - 1);
  find_interior(surface, bounds, extent);
  const int shift = cell_bits(cell_log2_);
  widest_ = 0;
  for (PatchId id = 0; id < surface.patches.size(); ++id) {
    if (surface.is_free(id)) continue;
    const LatticeBox swept = swept_box(surface, bounds, id);
    widen(surface, bounds, id);
    clear_cells(swept.min >> shift, swept.max >> shift);
  }
  clear_outside(glm::ivec3(0), size_ - 1);
}

void Occluders::widen(const Surface& surface, std::span<const PatchBounds> bounds, PatchId id) {
  const LatticeBox swept = swept_box(surface, bounds, id);
  const LatticeBox box = patch_box(surface, bounds, id);
  for (int axis = 0; axis < 3; ++axis)
    widest_ = std::max({widest_, box.min[axis] - swept.min[axis], swept.max[axis] - box.max[axis]});
}

// What is not wholly in the interior, of cells first..last.
void Occluders::clear_outside(glm::ivec3 first, glm::ivec3 last) {
  const int shift = cell_bits(cell_log2_);
  for (int axis = 0; axis < 3; ++axis) {
    glm::ivec3 low = first;
    glm::ivec3 high = last;
    high[axis] = std::min(last[axis], (interior_.min[axis] - 1) >> shift);
    clear_cells(low, high);
    high = last;
    low[axis] = std::max(first[axis], (interior_.max[axis] + 1) >> shift);
    clear_cells(low, high);
  }
}

// Cells low..high, but for what is outside of the interior.
void Occluders::renew(const Octree& octree, const Surface& surface, std::span<const PatchBounds> bounds,
                      const BoundsTree& tree, glm::ivec3 low, glm::ivec3 high) {
  low = glm::max(low, glm::ivec3(0));
  high = glm::min(high, size_ - 1);
  if (low.x > high.x || low.y > high.y || low.z > high.z) return;
  const int shift = cell_bits(cell_log2_);
  fill_cells(low, high);
  clear_leaves(octree, octree.root(), glm::ivec3(0), octree.size(), low, high);
  const auto clear = [&](PatchId id) {
    const LatticeBox swept = swept_box(surface, bounds, id);
    clear_cells(glm::max(swept.min >> shift, low), glm::min(swept.max >> shift, high));
    return true;
  };
  // Cells hold more than a box.
  const glm::dvec3 from(low << shift), to((high + 1) << shift);
  for_each_near(tree, surface, from, to, widest_, clear);
}

// Where the interior grows, what was outside of it was cleared.
void Occluders::update(const Octree& octree, const Surface& surface, std::span<const PatchBounds> bounds,
                       const BoundsTree& tree, std::span<const PatchId> changed, const LatticeBox& box,
                       bool sides) {
  if (empty()) return;
  const int shift = cell_bits(cell_log2_);
  for (const PatchId id : changed) widen(surface, bounds, id);
  renew(octree, surface, bounds, tree, box.min >> shift, box.max >> shift);
  const LatticeBox before = interior_;
  if (sides) find_interior(surface, bounds, extent_);
  for (int axis = 0; axis < 3; ++axis) {
    glm::ivec3 low(0), high = size_ - 1;
    if (interior_.min[axis] < before.min[axis]) {
      low[axis] = (interior_.min[axis] - 1) >> shift;
      high[axis] = (before.min[axis] - 1) >> shift;
      renew(octree, surface, bounds, tree, low, high);
    }
    if (interior_.max[axis] > before.max[axis]) {
      low[axis] = (before.max[axis] + 1) >> shift;
      high[axis] = size_[axis] - 1;
      renew(octree, surface, bounds, tree, low, high);
    }
  }
  const bool same = interior_.min == before.min && interior_.max == before.max;
  clear_outside(same ? glm::max(box.min >> shift, glm::ivec3(0)) : glm::ivec3(0),
                same ? glm::min(box.max >> shift, size_ - 1) : size_ - 1);
}

std::uint64_t Occluders::count(Kind kind) const {
  if (empty()) return 0;
  std::uint64_t result = 0;
  const auto row = static_cast<std::size_t>(words_x_);
  const std::span<const std::uint64_t> along_x = bits_[static_cast<std::size_t>(kind)].along_x;
  for (std::size_t w = 0; w < along_x.size(); ++w) {
    const int first = static_cast<int>(w % row) * 64;
    const std::uint64_t inside = mask_of(first / 64, 0, size_.x - 1);
    result += static_cast<std::uint64_t>(std::popcount(along_x[w] & inside));
  }
  return result;
}

bool Occluders::covers(Kind kind, int axis, int layer, glm::ivec2 low, glm::ivec2 high) const {
  const int rows = axis == 1 ? size_.z : size_.y;
  const int columns = axis == 0 ? size_.z : size_.x;
  if (low.x < 0 || high.x >= rows || low.y < 0 || high.y >= columns) return false;
  if (layer < 0 || layer >= size_[axis]) return false;
  const Bits& of = bits_[static_cast<std::size_t>(kind)];
  const std::uint64_t* bits = axis == 0 ? of.along_z.data() : of.along_x.data();
  const int words = axis == 0 ? words_z_ : words_x_;
  int start = 0;  // row `low.x` of the layer, and from there to the next
  int step = words;
  if (axis == 0) {
    start = (low.x * size_.x + layer) * words;
    step = size_.x * words;
  } else if (axis == 1) {
    start = (layer * size_.z + low.x) * words;
  } else {
    start = (low.x * size_.z + layer) * words;
    step = size_.z * words;
  }
  for (int w = low.y / 64; w <= high.y / 64; ++w) {
    const std::uint64_t mask = mask_of(w, low.y, high.y);
    const std::uint64_t* row = bits + start + w;
    for (int r = low.x; r <= high.x; ++r, row += step) {
      if ((*row & mask) != mask) return false;
    }
  }
  return true;
}

bool Occluders::is_outside(const Octree& octree, const BoundsTree& tree, const Surface& surface,
                           std::span<const PatchBounds> bounds, glm::dvec3 eye, double reach) const {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(eye[axis] - reach > interior_.min[axis] && eye[axis] + reach < interior_.max[axis])) return false;
  }
  const glm::ivec3 voxel(glm::floor(eye / double{kStepsPerVoxel}));
  if (voxel.y < extent_.y && octree.filled(voxel)) return false;
  const glm::dvec3 low = eye - reach;
  const glm::dvec3 high = eye + reach;
  return for_each_near(tree, surface, low, high, widest_,
                       [&](PatchId id) { return !touches(swept_box(surface, bounds, id), low, high); });
}

}  // namespace karst::core
