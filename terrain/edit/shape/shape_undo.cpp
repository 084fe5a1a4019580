// SPDX-License-Identifier: MIT
#include "terrain/edit/shape/shape_undo.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "terrain/base/check.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/patch_key.h"

namespace karst::core {
namespace {

static_assert(std::is_trivially_copyable_v<VoxelEditCell> && sizeof(PatchCell) == 8);

// Of cubes that are kept voxel by voxel.
constexpr int kBlockLog2 = 3;
constexpr std::size_t kBlockBytes = (std::size_t{1} << (3 * kBlockLog2)) / 8;

glm::ivec3 octant_origin(glm::ivec3 origin, int size_log2, int octant) {
  return origin + (1 << (size_log2 - 1)) * glm::ivec3(octant & 1, octant >> 1 & 1, octant >> 2 & 1);
}

std::size_t bit_of(glm::ivec3 at) {
  return static_cast<std::size_t>((at.z << (2 * kBlockLog2)) | (at.y << kBlockLog2) | at.x);
}

class KeepVoxels {
 public:
  KeepVoxels(const Octree& octree, UndoLog& log) : octree_(octree), log_(log) {}

  // Where two trees differ, the first one.
  void run(Octree::Node was, Octree::Node is, glm::ivec3 origin, int size_log2) const {
    if (was == is) return;
    if (Octree::is_leaf(was)) {
      const auto content = Octree::is_filled(was) ? VoxelCube::filled : VoxelCube::empty;
      log_.add(CellKind::voxels, VoxelCube{origin, size_log2, content}.key(), std::size_t{0});
      return;
    }
    if (size_log2 <= kBlockLog2) {
      std::byte bits[kBlockBytes] = {};
      write(was, glm::ivec3(0), size_log2, bits);
      log_.add(CellKind::voxels, VoxelCube{origin, size_log2, VoxelCube::mixed}.key(), std::span(bits));
      return;
    }
    for (int o = 0; o < 8; ++o)
      run(octree_.child(was, o), octree_.child(is, o), octant_origin(origin, size_log2, o), size_log2 - 1);
  }

 private:
  void write(Octree::Node node, glm::ivec3 at, int size_log2, std::span<std::byte> bits) const {
    if (node == Octree::kEmpty) return;
    if (size_log2 == 0) {
      const std::size_t bit = bit_of(at);
      bits[bit / 8] |= std::byte{1} << bit % 8;
      return;
    }
    for (int o = 0; o < 8; ++o)
      write(octree_.child(node, o), octant_origin(at, size_log2, o), size_log2 - 1, bits);
  }

  const Octree& octree_;
  UndoLog& log_;
};

class RestoreVoxels {
 public:
  RestoreVoxels(Octree& octree, UndoPart part) : octree_(octree), next_(part.begin()), end_(part.end()) {
    find_next();
  }

  Octree::Node run(Octree::Node node, glm::ivec3 origin, int size_log2) {
    if (next_ == end_) return node;
    const UndoCell cell = *next_;
    const VoxelCube cube = VoxelCube::of(cell.key);
    for (int axis = 0; axis < 3; ++axis) {
      if (cube.origin[axis] >> size_log2 != origin[axis] >> size_log2) return node;
    }
    if (cube.size_log2 == size_log2) {
      ++next_;
      find_next();
      if (cube.content == VoxelCube::mixed) return read(node, glm::ivec3(0), size_log2, cell.bytes);
      return cube.content == VoxelCube::filled ? Octree::kFilled : Octree::kEmpty;
    }
    const Octree::Octet old = octree_.children(node);
    Octree::Octet now;
    for (int o = 0; o < 8; ++o)
      now.child[o] = run(old.child[o], octant_origin(origin, size_log2, o), size_log2 - 1);
    return made_of(now, old, node);
  }

 private:
  void find_next() {
    while (!(next_ == end_) && (*next_).kind != CellKind::voxels) ++next_;
  }

  Octree::Node made_of(const Octree::Octet& now, const Octree::Octet& old, Octree::Node node) {
    if (std::ranges::equal(now.child, old.child)) return node;
    Octree::Node made = Octree::kEmpty;
    const Status status = octree_.make_node(now, made);
    KARST_ASSERT(status.ok());  // there was room for them beside these
    static_cast<void>(status);
    return made;
  }

  Octree::Node read(Octree::Node node, glm::ivec3 at, int size_log2, std::span<const std::byte> bits) {
    if (size_log2 == 0) {
      const std::size_t bit = bit_of(at);
      return (bits[bit / 8] >> bit % 8 & std::byte{1}) != std::byte{0} ? Octree::kFilled : Octree::kEmpty;
    }
    const Octree::Octet old = octree_.children(node);
    Octree::Octet now;
    for (int o = 0; o < 8; ++o)
      now.child[o] = read(old.child[o], octant_origin(at, size_log2, o), size_log2 - 1, bits);
    return made_of(now, old, node);
  }

  Octree& octree_;
  UndoPart::Iterator next_, end_;
};

}  // namespace

void keep_shape_edit(const World::Editable& all, const VoxelEditCell& edit, Octree::Node old_root,
                     std::span<const PatchId> lost, int level, UndoLog& log) {
  log.begin_part();
  log.add(CellKind::voxel_edit, 0, std::as_bytes(std::span(&edit, 1)));
  const Octree& octree = *all.octree;
  KeepVoxels(octree, log).run(old_root, octree.root(), glm::ivec3(0), octree.depth());
  const std::size_t block_bytes = sizeof(std::int16_t) * static_cast<std::size_t>(patch_vertices(level));
  for (const PatchId patch : lost) {
    const std::uint32_t block = all.patches[patch].height_block;
    PatchCell head;
    head.has_heights = block != kNoHeights;
    head.material = all.overrides.empty() ? std::uint8_t{0} : all.overrides[patch];
    const std::span<std::byte> room = log.add(CellKind::patch_heights, key_of(all.surface, patch).bits(),
                                              sizeof head + (block != kNoHeights ? block_bytes : 0));
    if (room.empty()) return;  // the step is lost
    std::memcpy(room.data(), &head, sizeof head);
    if (block != kNoHeights)
      std::memcpy(room.data() + sizeof head, all.heights->block(block).data(), block_bytes);
  }
}

VoxelEditCell kept_edit(UndoPart part) {
  const UndoCell cell = *part.begin();
  KARST_ASSERT(cell.kind == CellKind::voxel_edit && cell.bytes.size() == sizeof(VoxelEditCell));
  VoxelEditCell edit;
  std::memcpy(&edit, cell.bytes.data(), sizeof edit);
  return edit;
}

Octree::Node restore_voxels(Octree& octree, UndoPart part) {
  return RestoreVoxels(octree, part).run(octree.root(), glm::ivec3(0), octree.depth());
}

void restore_patches(const World::Editable& all, int level, UndoPart part) {
  const std::size_t block_bytes = sizeof(std::int16_t) * static_cast<std::size_t>(patch_vertices(level));
  for (const UndoCell cell : part) {
    if (cell.kind != CellKind::patch_heights) continue;
    const PatchId patch = all.slots->table().find(PatchKey::from_bits(cell.key));
    KARST_ASSERT(patch != PatchTable::kNone);
    PatchCell head;
    std::memcpy(&head, cell.bytes.data(), sizeof head);
    if (!all.overrides.empty()) all.overrides[patch] = head.material;
    all.patches[patch].height_block = head.has_heights ? all.first + patch : kNoHeights;
    if (head.has_heights)
      std::memcpy(all.heights->block(all.first + patch).data(), cell.bytes.data() + sizeof head, block_bytes);
  }
}

}  // namespace karst::core
