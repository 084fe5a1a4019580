// SPDX-License-Identifier: MIT
// What an edit of voxels keeps to be taken back: itself, the voxels that it changed, as they were, and what
// patches had that are gone or reshaped afterwards: heights and material. All else follows from those. To do
// it again it is made anew, in the same world.
//
// Cells of such a part, in this order:
//   voxel_edit     VoxelEditCell; key: 0
//   voxels         a cube that was all the same: no bytes; one of 8 voxels a side (or the whole octree): a
//   bit
//                  each, x fastest, then y, then z; key: VoxelCube. In the octree's order in space
//   patch_heights  PatchCell and, where it says so, the heights; key: the patch's, of its octree alone
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/edit/edit.h"
#include "terrain/edit/shape/edit_octree.h"
#include "terrain/edit/undo_log.h"
#include "terrain/surface/patch.h"
#include "terrain/world/world.h"

namespace karst::core {

struct VoxelEditCell {
  Edit edit;                   // from the corner of the world's part
  glm::ivec3 low{0}, high{0};  // voxels that it changed lie there, both ends included
  std::uint32_t part = 0;      // of the world
};

struct VoxelCube {
  enum Content : std::uint8_t { mixed, empty, filled };
  glm::ivec3 origin{0};
  int size_log2 = 0;
  Content content = mixed;

  std::uint64_t key() const {
    return static_cast<std::uint64_t>(origin.x) | static_cast<std::uint64_t>(origin.y) << 16 |
           static_cast<std::uint64_t>(origin.z) << 32 | static_cast<std::uint64_t>(size_log2) << 48 |
           static_cast<std::uint64_t>(content) << 56;
  }
  static VoxelCube of(std::uint64_t key) {
    return {{static_cast<int>(key & 0xffff), static_cast<int>(key >> 16 & 0xffff),
             static_cast<int>(key >> 32 & 0xffff)},
            static_cast<int>(key >> 48 & 0xff),
            static_cast<Content>(key >> 56)};
  }
};

struct PatchCell {
  bool has_heights = false;
  std::uint8_t material = 0;  // World::material_overrides()
  std::uint8_t unused[6] = {};
};

// Begins a part and adds an edit to it: made, made of the octree's old root; lost: patches that are gone or
// reshaped afterwards. The world is as it was, but for its octree's root.
void keep_shape_edit(const World::Editable& all, const VoxelEditCell& edit, Octree::Node old_root,
                     std::span<const PatchId> lost, int level, UndoLog& log);

// The edit that a part is of. Precondition: its kind is voxel_edit.
VoxelEditCell kept_edit(UndoPart part);
// A tree with the voxels of a part's cells beside the octree's own, as EditOctree makes one. It takes no more
// octets than there were in use while the edit was made.
Octree::Node restore_voxels(Octree& octree, UndoPart part);
// Heights and materials. Precondition: its patches are there.
void restore_patches(const World::Editable& all, int level, UndoPart part);

}  // namespace karst::core
