// SPDX-License-Identifier: MIT
// The six planes of a view on the lattice, and the n/p-vertex box test (Assarsson and Moeller, "Optimized
// View Frustum Culling Algorithms for Bounding Boxes", 2000, sections 2 and 4.2: plane masking).
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "terrain/base/simd.h"
#include "terrain/view/camera.h"

namespace karst::core {

// In lattice steps from the octree's minimum corner. min <= max on every axis; |component| < kBoxReach.
struct LatticeBox {
  glm::ivec3 min{0};
  glm::ivec3 max{0};
};

// Voxels of the largest world and the reach of int16 beside it, in steps. Below 2^24: exact in float.
inline constexpr std::int32_t kBoxReach = ((1 << kMaxDepth) + 5) * kStepsPerVoxel;
static_assert(kBoxReach < 1 << 24);

// Points p with normal . p + offset >= 0 are on its inner side. The normal has unit length.
struct Plane {
  glm::vec3 normal{0.0f};
  float offset = 0.0f;  // lattice steps; includes the margin that makes the test conservative (frustum.cpp)
};

struct Frustum {
  static constexpr int kPlanes = 6;
  Plane planes[kPlanes];  // near, left, right, bottom, top, far
};

// What is left to test of a box: bit n is set when the box crosses plane n. 0: wholly inside.
using PlaneMask = std::uint32_t;
inline constexpr PlaneMask kAllPlanes = (1u << Frustum::kPlanes) - 1;
inline constexpr PlaneMask kOutside = 0xffffffffu;  // no part of the box can be seen

Frustum make_frustum(const Camera& camera);

// Tests box against the planes in mask only: those that a box around it was wholly inside of need no second
// test. Never returns kOutside for a box that holds a point which the GPU could draw inside the view.
inline PlaneMask classify(const Frustum& frustum, const LatticeBox& box, PlaneMask mask) {
  const glm::vec3 low(box.min);
  const glm::vec3 high(box.max);
  PlaneMask crossed = 0;
  for (int n = 0; n < Frustum::kPlanes; ++n) {
    const PlaneMask bit = 1u << n;
    if ((mask & bit) == 0) continue;
    const Plane& plane = frustum.planes[n];
    // Nearest and farthest of each axis's two products: the p-vertex is made of the greater, the n-vertex of
    // the lesser ones.
    float inmost = plane.offset;
    float outmost = plane.offset;
    for (int axis = 0; axis < 3; ++axis) {
      const float a = plane.normal[axis] * low[axis];
      const float b = plane.normal[axis] * high[axis];
      inmost += a > b ? a : b;
      outmost += a > b ? b : a;
    }
    if (inmost < 0.0f) return kOutside;
    if (outmost < 0.0f) crossed |= bit;
  }
  return crossed;
}

// The planes side by side, for boxes that are tested against all of them at once.
class PlaneLanes {
 public:
  explicit PlaneLanes(const Frustum& frustum) {
    // Nothing is outside the two lanes that no plane fills.
    for (int n = Frustum::kPlanes; n < kAll; ++n) offset_[n] = 1.0f;
    for (int n = 0; n < Frustum::kPlanes; ++n) {
      for (int axis = 0; axis < 3; ++axis) normal_[axis][n] = frustum.planes[n].normal[axis];
      offset_[n] = frustum.planes[n].offset;
    }
  }

  struct Test {
    PlaneMask mask;  // what classify() returns for all planes
    bool is_near;    // with all planes moved outwards by `around` steps it would not be kOutside
  };
  Test test(const LatticeBox& box, float around) const {
    PlaneMask crossed = 0;
    simd::Float4 least = simd::splat(0.0f);
    for (int half = 0; half < kAll; half += simd::kLanes) {
      simd::Float4 inmost = simd::load(offset_ + half);
      simd::Float4 outmost = inmost;
      for (int axis = 0; axis < 3; ++axis) {
        const simd::Float4 normal = simd::load(normal_[axis] + half);
        const simd::Float4 a = normal * simd::splat(static_cast<float>(box.min[axis]));
        const simd::Float4 b = normal * simd::splat(static_cast<float>(box.max[axis]));
        inmost += simd::max(a, b);
        outmost += simd::min(a, b);
      }
      least = simd::min(least, inmost);
      crossed |= simd::lanes(outmost < simd::splat(0.0f)) << half;
    }
    if (!simd::any(least < simd::splat(0.0f))) return {crossed, true};
    return {kOutside, !simd::any(least < simd::splat(-around))};
  }

 private:
  static constexpr int kAll = 8;
  float normal_[3][kAll] = {};
  float offset_[kAll] = {};
};

}  // namespace karst::core
