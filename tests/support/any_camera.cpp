// SPDX-License-Identifier: MIT
#include "tests/support/any_camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "terrain/view/projection.h"

namespace karst::test {
namespace {

using glm::dvec4;

glm::dmat4 from_rows(dvec4 x, dvec4 y, dvec4 z, dvec4 w) {
  return glm::transpose(glm::dmat4(x, y, z, w));
}

glm::dmat4 perspective(Random& random, AnyProjection kind, double near) {
  const double height = std::exp2(between(random, -2, 2));
  const double width = height * between(random, 0.4, 2.6);
  const bool off = kind != AnyProjection::plain;
  const double x = off ? width * between(random, -0.8, 0.8) : 0.0;
  const double y = off ? height * between(random, -0.8, 0.8) : 0.0;
  const dvec4 right(2 / width, 0, 2 * x / width, 0);
  const dvec4 up(0, 2 / height, 2 * y / height, 0);
  const dvec4 w(0, 0, -1, 0);
  const double far = near * std::exp2(between(random, 6, 16));
  const bool endless = random.below(4) == 0;
  const double share = endless ? 1.0 : (far + near) / (far - near);
  const double moved = endless ? -2.0 * near : -2.0 * far * near / (far - near);
  const dvec4 depth(0, 0, -share, moved);
  if (kind != AnyProjection::oblique) return from_rows(right, up, depth, w);
  // E. Lengyel, "Oblique View Frustum Depth Projection and Clipping", 2005: any plane is the near one, and
  // the far one goes through the corner farthest from it.
  const glm::dmat4 inverse = glm::inverse(from_rows(right, up, {0, 0, -1, -2 * near}, w));
  dvec4 plane;
  dvec4 corner;
  do {  // until it leaves something of the view
    plane = {between(random, -1.5, 1.5), between(random, -1.5, 1.5), -1.0, -near};
    corner = inverse * dvec4(plane.x < 0 ? -1 : 1, plane.y < 0 ? -1 : 1, 1, 1);
  } while (glm::dot(plane, corner) < 0.3 * glm::length(plane) * glm::length(corner));
  const double scale = 2.0 * glm::dot(w, corner) / glm::dot(plane, corner);
  return from_rows(right, up, plane * scale - w, w);
}

glm::dmat4 parallel(Random& random, bool sheared, double size) {
  const double width = size * between(random, 0.25, 1);
  const double height = size * between(random, 0.25, 1);
  const double near = between(random, -200, 0);
  const double far = between(random, 20, 400);
  const dvec4 along(0, 0, sheared ? between(random, -1, 1) : 0.0, between(random, -0.5, 0.5) * size);
  const dvec4 beside(0, 0, sheared ? between(random, -1, 1) : 0.0, between(random, -0.5, 0.5) * size);
  return from_rows((dvec4(1, 0, 0, 0) + along) * (2 / width), (dvec4(0, 1, 0, 0) + beside) * (2 / height),
                   {0, 0, -2 / (far - near), -(far + near) / (far - near)}, {0, 0, 0, 1});
}

}  // namespace

double between(Random& random, double low, double high) {
  return low + (high - low) * random.unit();
}

glm::dvec3 any_direction(Random& random) {
  for (;;) {
    const glm::dvec3 d(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
    const double length = glm::length(d);
    if (length > 0.1 && length < 1) return d / length;
  }
}

glm::dmat3 any_rotation(Random& random, bool mirrored) {
  const glm::dvec3 back = any_direction(random);
  const glm::dvec3 right = glm::normalize(glm::cross(any_direction(random), back));
  const glm::dvec3 up = glm::cross(back, right);
  return glm::transpose(glm::dmat3(right, mirrored ? -up : up, back));
}

CameraMatrices any_matrices(Random& random, AnyProjection kind, double nearest, double size) {
  CameraMatrices m;
  m.view_from_world = any_rotation(random, random.below(2) == 0);
  m.clip_from_view = is_parallel(kind) ? parallel(random, kind == AnyProjection::sheared, size)
                                       : perspective(random, kind, nearest);
  if (kind == AnyProjection::turned) {
    glm::dmat4 moved(any_rotation(random, random.below(2) == 0));
    moved[3] = {between(random, -3, 3), between(random, -3, 3), between(random, -3, 3), 1.0};
    m.clip_from_view = m.clip_from_view * moved;
  }
  // Rows that change what is seen of nothing: a mirrored picture, reversed depth, another scale of w.
  glm::dmat4 rows(1.0);
  if (random.below(2) == 0) rows[0][0] = -1.0;
  m.reversed_depth = random.below(2) == 0;
  if (m.reversed_depth) rows[2][2] = -1.0;
  m.clip_from_view = rows * m.clip_from_view * (random.below(2) == 0 ? 1.0 : between(random, 0.01, 100));
  return m;
}

void show(Random& random, glm::dvec3 target, double depth, CameraMatrices& matrices) {
  matrices.position = glm::dvec3(0.0);
  const Camera camera = camera_of(matrices);
  const ViewRays rays = view_rays(camera);
  const glm::dvec3 ray = rays.right * between(random, -0.9, 0.9) + rays.up * between(random, -0.9, 0.9);
  const glm::dvec3 eye = eye_lattice(camera) / double{kStepsPerVoxel};
  const glm::dvec3 seen =
      camera.parallel ? rays.start + ray + rays.middle * depth : (rays.middle + ray) * depth;
  matrices.position = target - seen - eye;
}

Camera camera_of(const CameraMatrices& matrices) {
  Camera camera;
  const Status status = make_camera(matrices, camera);
  EXPECT_TRUE(status.ok()) << status.field() << ": " << status.what();
  return camera;
}

}  // namespace karst::test
