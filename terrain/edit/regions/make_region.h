// SPDX-License-Identifier: MIT
// A region where there was only ground (World::spare_regions()): its voxels are filled up to the ground, and
// its surface is fitted to it. What is drawn is what was drawn before, but for heights that no vertex has.
// Measures are for the time being, as after an edit. All that can fail is done first; the rest in steps.
//
//   MakeRegion make{&world, &ground, nodes, bottom, top};
//   status = make.begin();        // the world has it staged, and the ground knows of it
//   if (the edit fails) make.take_back();
//   while (!make.step()) ...      // now or later
//   world.open_region();
#pragma once

#include <cstddef>
#include <cstdint>

#include "karst/status.h"
#include "terrain/edit/ground/edit_ground.h"
#include "terrain/world/world.h"

namespace karst::core {

struct MakeRegion {
  // Vertices of patches that a step fits, or whose measures it bounds: some 3 ms and 1.
  static constexpr std::uint32_t kFitted = 12'000, kBounded = 48'000;

  // Inputs, borrowed.
  World* world = nullptr;
  EditGround* ground = nullptr;  // the world's; is_settled()
  NodeRect nodes;
  // Of the octree: its corner, and the end of its extent; voxels from the world's corner.
  std::int32_t bottom = 0, top = 0;

  // How far it is: patches, and those of them that are fitted and that are measured.
  PatchId patches = 0, fitted = 0, measured = 0;

  // limit_reached ("dig_regions", "region_patches", "edit_tiles"), invalid_argument ("place": nodes that
  // cannot be a region's, or a surface that does not meet the ground around it), and errors of reading. Then
  // nothing has changed. Precondition: world->ground().can_be_dug.
  // Uses the memory that the world lends.
  Status begin();
  // A part of what is left to do. Returns whether that was all. Preconditions: begin() was ok, step() was not
  // true yet, and the ground beneath is what it was then.
  bool step();
  // begin() and all steps, and all see it.
  Status run();
  // Preconditions: begin() was ok, step() was not true yet.
  void take_back();

 private:
  Status fill(const World::Spare& spare, GroundRegion& region) const;
  Status extract(const World::Spare& spare, GroundRegion& region) const;
  void fit(PatchId first, PatchId end) const;
  void measure(PatchId first, PatchId end) const;
  void empty(const World::Spare& spare) const;
};

}  // namespace karst::core
