// SPDX-License-Identifier: MIT
// What edits leave to be done when there is time: measures of touched patches and the sky. Once
// World::is_settled(), all is, by key and to the bit, what a file of the edited world would be loaded with.
//
//   Settled done;
//   while (!world.is_settled() && there is time) settle_some(world, done);
#pragma once

#include <cstddef>

#include "terrain/surface/patch.h"
#include "terrain/world/world.h"

namespace karst::core {

struct Settled {
  static constexpr PatchId kNone = 0xffffffffu;

  std::size_t part = 0;      // of the world, that was looked at
  PatchId measured = kNone;  // the world's patch whose errors, cones or box may be others now
  bool sky_changed = false;
};

// A patch, or a step of the sky. Precondition: world.is_settled() is false.
void settle_some(World& world, Settled& done);
// Boxes of a part's patches that edits left loose come before. Returns whether there was one. tight: grows by
// it. Unlike settle_some() it changes what queries read.
bool fit_next(World& world, std::size_t part, Settled& done, LatticeBox& tight);

}  // namespace karst::core
