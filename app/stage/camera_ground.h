// SPDX-License-Identifier: MIT
// Cameras and the ground: heights above it, and cameras that are below it by mistake.
#pragma once

#include <cstdint>
#include <optional>

#include "app/common/camera_path.h"
#include "karst/query.h"
#include "karst/world.h"
#include "platform/base/error.h"

namespace karst::app {

class CameraGround {
 public:
  CameraGround() = default;
  CameraGround(const CameraGround&) = delete;
  CameraGround& operator=(const CameraGround&) = delete;
  ~CameraGround();

  // Takes a query of the world, which must outlive this object.
  Error open(World& world);
  bool is_open() const { return query_ != nullptr; }
  // Reads of the world that failed: what was asked for there was answered coarsely.
  std::uint64_t failed_reads() const { return query_->failed_reads(); }

  // Where place is on the map or counts from the ground, makes it metres of the world. Else one line without
  // its subject: the world knows no map, or there is no ground there; place is then unchanged.
  Error stand(CameraPlace& place);
  // One line, where the camera is inside rock; none where it is in the air. place does not count from the
  // ground.
  Error in_rock(const CameraPlace& place);
  // Height of the ground, metres, that is no higher than step_m above the place; none where there is none. On
  // a curved basis heights count along up at the place, and that of the place is its y.
  std::optional<double> below_m(const glm::dvec3& place_m, double step_m);
  // What is met straight below or above a place, whatever its height: the highest ground. False: none.
  // reads: of the file; else it may be coarse.
  bool top(const glm::dvec3& place_m, bool reads, Hit& hit);
  // Metres from the place to the nearest surface, at most kClearance of the world's voxels.
  double clearance_m(const glm::dvec3& place_m);
  LocalAxes axes_at(const glm::dvec3& place_m) const;

 private:
  Error find_on_map(CameraPlace& place);

  World* world_ = nullptr;
  Query* query_ = nullptr;
  double height_m_ = 0;  // above the ground, of a place on the map
};

}  // namespace karst::app
