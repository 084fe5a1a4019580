// SPDX-License-Identifier: MIT
// Brings a surface up to date after voxels changed: patches that are still there keep their slots, and with
// them all that lies at their slots; those that are gone give theirs back; new ones take some.
//
//   voxels low_voxel..high_voxel of the octree change
//   const CornerBox box = corners_touched(low_voxel, high_voxel);
//   ExtractSurface extract{..., box.low, box.high, ...};  extract.run(made);
//   UpdateSurface update{{volumes, patches}, box, &slots, changes};  update.run(result);
//   fit heights of what appeared, measure what changed and its neighbours
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/surface/patch.h"
#include "terrain/surface/patch_table.h"

namespace karst::core {

// Volumes and patches by slot; free ones lie between those in use (patch.h says how to tell). Memory is
// borrowed and of fixed length.
class SurfaceSlots {
 public:
  // table: created, with as many slots as there are patches.
  void create(std::span<Volume> volumes, std::span<Patch> patches, PatchTable* table);

  // Takes over what an extraction of everything has written to the memory given in create(): numbers become
  // slots. Precondition: volumes and patches are what it made.
  void adopt(std::uint32_t volumes, std::uint32_t patches);

  // All slots up to the last one in use, free ones included.
  Surface surface() const { return {volumes_.first(volume_end_), patches_.first(table_->end())}; }
  const PatchTable& table() const { return *table_; }
  std::uint32_t volume_count() const { return volume_count_; }  // in use
  std::uint32_t max_volumes() const { return static_cast<std::uint32_t>(volumes_.size()); }

 private:
  friend struct UpdateSurface;

  std::uint32_t take_volume();  // precondition: one is free
  void release_volume(std::uint32_t slot);

  std::span<Volume> volumes_;
  std::span<Patch> patches_;
  PatchTable* table_ = nullptr;
  std::uint32_t volume_end_ = 0;
  std::uint32_t volume_count_ = 0;
  std::uint32_t free_volume_ = kNoVolume;
};

// Voxel corners, both ends included.
struct CornerBox {
  glm::ivec3 low{0};
  glm::ivec3 high{0};
};

// Corners whose volumes may look another way after voxels low..high changed: a volume has the gradients at
// its eight voxels, each of which reads two voxels to either side.
inline CornerBox corners_touched(glm::ivec3 low, glm::ivec3 high) {
  return {low - 2, high + 3};
}

struct PatchChange {
  enum Kind : std::uint8_t {
    appeared,  // its slot is new, and has no heights
    vanished,  // its slot is free
    changed,   // it is still there, but its volume's gradients are others
    reshaped   // one of its key is still there, but its volume's voxels are others: so is its border
  };
  PatchId slot = 0;
  Kind kind = appeared;
};

struct UpdateSurface {
  // Inputs, borrowed: what extraction made of the corners in the box, with the voxels as they are now.
  // Outside of it nothing may have changed (corners_touched).
  Surface fresh;
  CornerBox box;

  // Brought up to date. Edges of patches around the box are linked anew.
  SurfaceSlots* slots = nullptr;

  // Output, borrowed: vanished ones first, the others by key. Room for all patches in the box, before and
  // after, is enough.
  std::span<PatchChange> changes;

  struct Result {
    std::uint32_t changes = 0;  // of all kinds together
    std::uint32_t appeared = 0;
    std::uint32_t vanished = 0;
    std::uint32_t kept = 0;  // patches in the box that are still there, changed or not
  };

  // What run() fails of, and how many patches are in the box before it.
  Status check(std::uint32_t& patches_before) const;
  // Patches that run() takes away or reshapes: their slots, as they are before it. out: as many as changes.
  std::span<PatchId> list_lost(std::span<PatchId> out) const;
  // limit_reached ("max_volumes", "max_patches", "changes", value: what it would take) where there is no
  // room: nothing has changed then.
  Status run(Result& result) const;

 private:
  struct Counts;

  template <class Visit>
  void for_each_old(const Visit& visit) const;
  const Volume* fresh_volume(PatchKey key) const;
  Counts count() const;
  Status check(const Counts& counts) const;
  void remove_old(Result& result) const;
  void put_patches(Result& result) const;
  void link_inside(const Patch& fresh_patch, Patch& patch) const;
  void link_outside(const Volume& volume) const;
};

}  // namespace karst::core
