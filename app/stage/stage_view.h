// SPDX-License-Identifier: MIT
// From what the command line says to what karst is asked for. The only place where the two meet.
#pragma once

#include "app/options/scene_options.h"
#include "app/stage/stage.h"

namespace karst::app {

// Light, levels, skips and time of a view; its camera is left as it is by default. Where the arguments leave
// generate_ms open, work_ms is 0.
StageView stage_view(const SceneArguments& arguments, const WorldInfo& world);
// On a curved basis the sun's azimuth and elevation are those at a place, whose axes are given.
void turn_sun(const LocalAxes& axes, const WorldInfo& world, StageView& view);

// The switch of a skip.
bool& skip_of(Inspection& inspection, SkipChoice skip);

}  // namespace karst::app
