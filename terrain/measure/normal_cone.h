// SPDX-License-Identifier: MIT
// A cone around the normals of all that can be drawn of a patch: every level, every state of its morph and of
// its edges. Where all of its directions point away from the eye the patch is back-facing and need not be
// drawn (Shirman and Abi-Ezzi, "The cone of normals technique for fast processing of curved patches", 1993).
//
// A morphing triangle's normal is a product of two edges, each of which is linear in the share that one
// vertex has gone; so it lies in the conic hull of the products with both vertices at home or at their
// targets, and a convex cone that holds these holds all. The vertex of a coarser level is at home (morph.h).
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// 4 bytes. The axis is not of unit length, so that it needs no decoding.
struct NormalCone {
  static constexpr std::uint8_t kNone = 255;  // sine: no cone narrower than a half-space holds the normals
  static constexpr float kSineUnit = 0.5f;

  std::int8_t axis[3] = {0, 127, 0};  // about 127 long
  std::uint8_t sine = kNone;  // of the half angle, times the axis's length, in units of kSineUnit; rounded up

  friend bool operator==(const NormalCone&, const NormalCone&) = default;
};
static_assert(sizeof(NormalCone) == 4);

// Slack of the test below, in lattice steps, for an eye given in float: its rounding and that of the GPU's
// positions, 2^-20 of all coordinates.
inline float back_facing_slack(glm::vec3 eye) {
  return 16.0f + (std::fabs(eye.x) + std::fabs(eye.y) + std::fabs(eye.z)) * 0x1p-20f;
}

// Whether every point of a box, with every normal of the cone, faces away from the eye. centre: of the box,
// less the eye; half: half its size; lattice steps. Never true where that is not so.
//
// snap_sine: how much further away they must face, as a sine. GPUs move vertices to a subpixel grid, which
// turns small triangles that are seen nearly edge-on; one that is turned to the eye may show in a pixel.
//
// A point p and a normal face away when their product is above 0: for all normals of a cone with axis a, when
// a p > sine |p|. Over the box the left side is least in a corner, and |p| at most the centre's and half the
// diagonal.
inline bool is_back_facing(const NormalCone& cone, glm::vec3 centre, glm::vec3 half, float slack,
                           float snap_sine = 0.0f) {
  const glm::vec3 a(cone.axis[0], cone.axis[1], cone.axis[2]);
  const float along = a.x * centre.x + a.y * centre.y + a.z * centre.z;
  const float across = std::fabs(a.x) * half.x + std::fabs(a.y) * half.y + std::fabs(a.z) * half.z;
  const float least = along - across - 128.0f * slack;
  if (cone.sine == NormalCone::kNone || !(least > 0.0f)) return false;
  const float sine = NormalCone::kSineUnit * static_cast<float>(cone.sine) + 128.0f * snap_sine;
  const float length = std::sqrt(centre.x * centre.x + centre.y * centre.y + centre.z * centre.z) +
                       std::sqrt(half.x * half.x + half.y * half.y + half.z * half.z);
  return least > sine * length;
}

// The same for an eye infinitely far away, which looks along `forward`, of unit length: wherever a point
// lies.
inline bool is_back_facing(const NormalCone& cone, glm::vec3 forward, float snap_sine = 0.0f) {
  constexpr float kSlack = 127.0f * 0x1p-20f;  // forward is rounded
  if (cone.sine == NormalCone::kNone) return false;
  const glm::vec3 a(cone.axis[0], cone.axis[1], cone.axis[2]);
  const float along = a.x * forward.x + a.y * forward.y + a.z * forward.z;
  return along > NormalCone::kSineUnit * static_cast<float>(cone.sine) + 128.0f * snap_sine + kSlack;
}

// The same for a patch whose box is given; eye: lattice steps from the octree's minimum corner.
inline bool is_back_facing(const NormalCone& cone, const PatchBounds& box, glm::ivec3 origin, glm::vec3 eye,
                           float slack, float snap_sine = 0.0f) {
  const glm::vec3 low(box.min[0], box.min[1], box.min[2]);
  const glm::vec3 high(box.max[0], box.max[1], box.max[2]);
  return is_back_facing(cone, glm::vec3(origin) - eye + 0.5f * (low + high), 0.5f * (high - low), slack,
                        snap_sine);
}

// The sine for triangles at a level, `distance` lattice steps away. A vertex moves by half a subpixel of 1/16
// pixel, the coarsest grid that OpenGL ES 3.0 allows; a triangle is about half a cell high at its lowest.
inline float snap_sine(float distance, int level, float pixels_per_radian) {
  if (!(pixels_per_radian > 0.0f)) return 0.0f;
  const float subpixel = distance / (pixels_per_radian * 16.0f);
  const float height = 0.5f * static_cast<float>(kStepsPerVoxel >> level);
  return subpixel < height ? subpixel / height : 1.0f;
}

// Of one patch; heights.level is the full one. Needs nothing of its neighbours.
NormalCone measure_normal_cone(const Surface& surface, const Heights& heights, PatchId patch);
struct LevelGrid;  // level_triangles.h
NormalCone measure_normal_cone(const LevelGrid& grid);

// Ranges of patches may run on several threads.
struct MeasureNormalCones {
  // Inputs, borrowed.
  Surface surface;
  Heights heights;

  // Output, borrowed: one a patch.
  std::span<NormalCone> cones;

  // invalid_argument naming the first field of another size than the surface, or heights.level out of range.
  Status validate() const;

  // Patches first .. last - 1. Precondition: validate() is ok.
  void run(PatchId first, PatchId last) const;
};

}  // namespace karst::core
