// SPDX-License-Identifier: MIT
// From what the command line says to what the scene takes. The only place where the two meet.
#pragma once

#include <string>

#include "app/options/scene_options.h"
#include "scene/scene.h"

namespace karst::app {
using namespace core;

SceneOptions scene_settings(const SceneArguments& arguments, const std::string& world);

// Light, levels, skips and time of a view; its camera and the rest are left as they are by default. Where the
// arguments leave haze open it is set by set_haze(), generate_ms by the caller.
SceneView view_settings(const SceneArguments& arguments);

// Where the arguments leave it open: six times the size of the world, box in lattice steps.
void set_haze(const SceneArguments& arguments, const LatticeBox& box, FrameLight& light);

}  // namespace karst::app
