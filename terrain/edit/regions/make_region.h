// SPDX-License-Identifier: MIT
// A region where there was only ground (World::spare_regions()): its voxels are filled up to the ground, and
// its surface is fitted to it. What is drawn is what was drawn before, but for heights that no vertex has.
// Measures are for the time being, as after an edit.
//
//   MakeRegion make{&world, &ground, nodes, bottom, top};
//   status = make.run();          // then the world and the ground have it
//   if (the edit fails) make.take_back();
#pragma once

#include <cstddef>
#include <cstdint>

#include "karst/status.h"
#include "terrain/edit/ground/edit_ground.h"
#include "terrain/world/world.h"

namespace karst::core {

struct MakeRegion {
  // Inputs, borrowed.
  World* world = nullptr;
  EditGround* ground = nullptr;  // the world's; is_settled()
  NodeRect nodes;
  // Of the octree: its corner, and the end of its extent; voxels from the world's corner.
  std::int32_t bottom = 0, top = 0;

  // limit_reached ("dig_regions", "region_patches", "edit_tiles"), invalid_argument ("place": nodes that
  // cannot be a region's, or a surface that does not meet the ground around it), and errors of reading. Then
  // nothing has changed. Precondition: world->ground().can_be_dug.
  Status run();
  // Precondition: run() was ok, and nothing has been changed in the region.
  void take_back();

 private:
  Status fill(const World::Spare& spare, GroundRegion& region) const;
  Status extract(const World::Spare& spare, GroundRegion& region) const;
  void fit(const World::Spare& spare, const GroundRegion& region) const;
  void measure(const World::Spare& spare, const GroundRegion& region) const;
  void empty(const World::Spare& spare) const;
};

}  // namespace karst::core
