// SPDX-License-Identifier: MIT
// Random cameras of every kind that make_camera accepts: rolled, mirrored, off their axis, with oblique
// planes, parallel.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "terrain/view/camera.h"
#include "tests/support/test_world.h"

namespace karst::test {
using namespace core;

enum class AnyProjection {
  plain,     // symmetrical about -z
  off_axis,  // the axis anywhere, even outside of the picture
  oblique,   // with a near plane of any direction
  turned,    // the axis is not -z, and the centre not the view's origin
  parallel,
  sheared,  // parallel, its rays at an angle to the picture's plane
};
inline constexpr AnyProjection kAnyProjections[] = {AnyProjection::plain,    AnyProjection::off_axis,
                                                    AnyProjection::oblique,  AnyProjection::turned,
                                                    AnyProjection::parallel, AnyProjection::sheared};
inline bool is_parallel(AnyProjection kind) {
  return kind == AnyProjection::parallel || kind == AnyProjection::sheared;
}

double between(Random& random, double low, double high);
glm::dvec3 any_direction(Random& random);
glm::dmat3 any_rotation(Random& random, bool mirrored);

// Of any rotation, mirrored or not, depth reversed or not. nearest: of a perspective's near plane; widths of
// parallel views are from size / 4 to size. Voxels.
CameraMatrices any_matrices(Random& random, AnyProjection kind, double nearest, double size);

// Moves the view so that it shows target `depth` in front of the eye, somewhere in the picture.
void show(Random& random, glm::dvec3 target, double depth, CameraMatrices& matrices);

// Of matrices that are accepted.
Camera camera_of(const CameraMatrices& matrices);

}  // namespace karst::test
