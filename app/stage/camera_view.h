// SPDX-License-Identifier: MIT
// From a camera as users state it to a view of karst: programs place worlds with Axes::east_up_south, so that
// places are metres to the east, up and to the south.
#pragma once

#include "app/common/camera_path.h"
#include "karst/renderer.h"
#include "karst/world.h"

namespace karst::app {

// What a camera sees, beside its place.
struct PictureShape {
  int width = 0;  // pixels of the target
  int height = 0;
  double fov_y_deg = 60;  // of the upright picture's whole height
  // Counter-clockwise turns by 90 degrees, for screens that stand on their side: the picture lies turned in
  // the target.
  int quarter_turns = 0;
  bool reversed_depth = false;
};

// Voxels: surfaces further from the eye than this do not matter to place_view().
inline constexpr double kClearance = 0.25;

// Near and far fitted to the world's box, near also to the eye's clearance: metres from it to the nearest
// surface, or more than kClearance. Near moves in steps of 2, so that it is the same in most frames of a
// flight. axes: at the place (World::axes_at); a plane's are not looked at. invalid_argument naming position,
// yaw_deg or pitch_deg.
Status place_view(const CameraPlace& place, const WorldInfo& world, const LocalAxes& axes,
                  const PictureShape& shape, double clearance_m, ViewState& view);

// Turns the picture of a view counter-clockwise in its target; its width and height are the caller's to swap.
void turn_view(int quarter_turns, ViewState& view);

// What place_view() says of the place itself, whatever the picture's shape: for paths and poses, checked
// before they are shown.
Status check_place(const CameraPlace& place, const WorldInfo& world);

// What cameras begin with, in the world's own metres: a box around the voxels where the world is a ground
// with a region and no place on the earth, as samples are; else the world's.
struct ShownBox {
  Vec3 low_m, high_m;
};
ShownBox shown_box(const WorldInfo& world);

// Looks over that box from above its south-east corner.
CameraPlace overview(const WorldInfo& world, double fov_y_deg);

}  // namespace karst::app
