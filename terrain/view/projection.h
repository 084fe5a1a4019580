// SPDX-License-Identifier: MIT
// What follows from a camera's projection, be it a perspective, off its axis or not, or parallel.
#pragma once

#include <glm/vec3.hpp>

#include "terrain/view/camera.h"

namespace karst::core {

// Where the picture's points are seen. At the place (x, y) in it, -1..1 to the right and upwards, and at
// depth d, the distance from the eye along camera.forward, lies the point, in voxels from the eye, world
// axes,
//   perspective: d (middle + x right + y up); start is 0
//   parallel:    d middle + x right + y up + start; middle is forward
// right, up and start are perpendicular to forward.
struct ViewRays {
  glm::dvec3 right{0.0}, up{0.0}, middle{0.0}, start{0.0};
};
ViewRays view_rays(const Camera& camera);

// cos^2 of the angle between forward and the picture's farthest corner; 1 if parallel.
double corner_cos2(const Camera& camera);

// Perspective: the most and the fewest pixels that a small angle, in radians, covers where forward meets the
// picture's plane. Parallel: that a voxel across forward covers. Both are those of the picture's height where
// pixels are square but for rounding.
struct PixelScale {
  double most, least;
};
PixelScale pixel_scale(const Camera& camera, int width_px, int height_px);

// How many times half the picture's height a length of 1 across forward, at depth 1, covers upwards at most.
double vertical_scale(const Camera& camera);

// The farthest that a corner of the near or the far plane is from the eye, voxels; may be infinite.
double near_reach(const Camera& camera);
double far_reach(const Camera& camera);

// How near a plain perspective's near plane would be, its far plane infinitely far, for a depth buffer to
// tell apart what it does here. Not above near_voxels. Not for parallel views.
double depth_near(const Camera& camera);

// Sets what follows from the other members, for make_camera: clip_from_view is invertible, its w as stated.
// ok, or the field that is wrong.
Status derive_view(Camera& camera);

}  // namespace karst::core
