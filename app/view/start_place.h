// SPDX-License-Identifier: MIT
// Where karst view begins when nobody says: a person's eyes above the ground near the world's middle, towards
// what stands highest before the sky.
#pragma once

#include "app/common/camera_path.h"
#include "app/stage/camera_ground.h"
#include "karst/world.h"

namespace karst::app {

// ground: open, of the world. Reads the file near the middle alone. On dry land that is not steep, where
// there is some within a quarter of the world's width from the middle; else above the water. False: the world
// has no middle, as a planet, or no ground there; place is unchanged.
bool start_place(CameraGround& ground, const World& world, double eye_height_m, CameraPlace& place);

}  // namespace karst::app
