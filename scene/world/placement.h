// SPDX-License-Identifier: MIT
// From the simulator's frame to the world's own metres (east, up, south), to voxels, and back.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "karst/renderer.h"
#include "karst/status.h"
#include "karst/types.h"
#include "terrain/view/camera.h"

namespace karst::core {

inline glm::dvec3 to_glm(Vec3 v) {
  return {v.x, v.y, v.z};
}
inline Vec3 from_glm(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

class PlacementFrame {
 public:
  // invalid_argument naming axes, origin or turn_deg. fraction_bits: CameraMatrices'.
  Status create(const Placement& placement, const WorldFrame& frame, int fraction_bits = kCameraFractionBits);

  // The simulator's axes in the world's, and the other way round. Exact for turns by multiples of 90 degrees.
  const glm::dmat3& world_from_sim() const { return world_from_sim_; }
  const glm::dmat3& sim_from_world() const { return sim_from_world_; }
  const WorldFrame& world() const { return frame_; }

  glm::dvec3 world_m(Vec3 place) const { return world_from_sim_ * (to_glm(place) - origin_); }
  Vec3 place(const glm::dvec3& world_m) const { return from_glm(sim_from_world_ * world_m + origin_); }
  // Voxels from the octree's minimum corner; not checked against kCameraReach.
  glm::dvec3 voxels(Vec3 place) const { return (world_m(place) - frame_.origin_m) / frame_.voxel_size_m; }
  Vec3 place_of_voxels(const glm::dvec3& voxels) const {
    return place(frame_.origin_m + voxels * frame_.voxel_size_m);
  }
  glm::dvec3 world_direction(Vec3 direction) const { return world_from_sim_ * to_glm(direction); }
  Vec3 direction(const glm::dvec3& world) const { return from_glm(sim_from_world_ * world); }

  // invalid_argument naming the view's field that is not finite, outside its range, no rotation or no
  // projection.
  Status make_camera(const karst::ViewState& view, Camera& camera) const;

 private:
  glm::dmat3 world_from_sim_{1.0};
  glm::dmat3 sim_from_world_{1.0};
  glm::dvec3 origin_{0.0};
  WorldFrame frame_;
  int fraction_bits_ = kCameraFractionBits;
};

}  // namespace karst::core
