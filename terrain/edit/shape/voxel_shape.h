// SPDX-License-Identifier: MIT
// Which voxels an edit means: those whose centres are in its shape, and in the part of the octree that is in
// use.
#pragma once

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "terrain/base/lattice.h"
#include "terrain/edit/edit.h"

namespace karst::core {

class VoxelShape {
 public:
  enum class Part : std::uint8_t { none, some, all };

  // low..high: voxels that may change, both ends included. Precondition: the edit is valid, its shape no
  // cylinder.
  VoxelShape(const Edit& edit, int depth, glm::ivec3 low, glm::ivec3 high)
      : shape_(edit.shape), from_(edit.place), to_(edit.place), half_(edit.half), low_(low), high_(high) {
    radius_ = edit.radius;
    if (shape_ == BrushShape::capsule) to_ = edit.to;
    if (shape_ == BrushShape::voxel) {
      const double side = static_cast<double>(1 << (depth - edit.octree_level));
      from_ = (glm::floor(edit.place / side) + 0.5) * side;
      half_ = glm::dvec3(0.5 * side);
    }
  }

  // Of the voxels of a cube. `some` where that is not known; of one voxel it is.
  Part of(glm::ivec3 origin, int size) const {
    const glm::ivec3 last = origin + size - 1;
    for (int axis = 0; axis < 3; ++axis) {
      if (last[axis] < low_[axis] || origin[axis] > high_[axis]) return Part::none;
    }
    if (is_beyond(origin, size)) return Part::none;
    bool all = true;
    for (int axis = 0; axis < 3; ++axis) all = all && origin[axis] >= low_[axis] && last[axis] <= high_[axis];
    // It is convex.
    for (int corner = 0; corner < 8 && all; ++corner) {
      const glm::ivec3 voxel(corner & 1 ? last.x : origin.x, corner & 2 ? last.y : origin.y,
                             corner & 4 ? last.z : origin.z);
      all = holds(glm::dvec3(voxel) + 0.5);
    }
    if (all) return Part::all;
    return size == 1 ? Part::none : Part::some;
  }

 private:
  bool is_box() const { return shape_ == BrushShape::box || shape_ == BrushShape::voxel; }

  glm::dvec3 from_segment(glm::dvec3 at) const {
    const glm::dvec3 way = to_ - from_;
    const double length2 = glm::dot(way, way);
    const double share = length2 > 0 ? glm::clamp(glm::dot(at - from_, way) / length2, 0.0, 1.0) : 0.0;
    return at - (from_ + share * way);
  }

  bool holds(glm::dvec3 at) const {
    if (is_box()) {
      const glm::dvec3 away = glm::abs(at - from_);
      return away.x <= half_.x && away.y <= half_.y && away.z <= half_.z;
    }
    const glm::dvec3 away = from_segment(at);
    return glm::dot(away, away) <= radius_ * radius_;
  }

  // Whether no centre of the cube's voxels is in it, for sure.
  bool is_beyond(glm::ivec3 origin, int size) const {
    constexpr double kSlack = 1e-6;  // far more than doubles lose
    const double half = 0.5 * (size - 1);
    const glm::dvec3 middle = glm::dvec3(origin) + 0.5 * size;
    if (is_box()) {
      const glm::dvec3 away = glm::abs(middle - from_) - half - kSlack;
      return away.x > half_.x || away.y > half_.y || away.z > half_.z;
    }
    return glm::length(from_segment(middle)) > (radius_ + half * 1.7320508076 + kSlack) * (1 + kSlack);
  }

  BrushShape shape_;
  glm::dvec3 from_, to_, half_;
  double radius_ = 0;
  glm::ivec3 low_, high_;
};

}  // namespace karst::core
