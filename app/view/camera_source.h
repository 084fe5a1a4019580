// SPDX-License-Identifier: MIT
// Where the pictures of karst view are taken from: a stated camera, a path, poses of another program, or
// hands.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/motion/navigator.h"
#include "app/motion/pose_stream.h"
#include "app/stage/camera_ground.h"
#include "app/view/view_options.h"
#include "platform/base/error.h"

namespace karst::app {

class CameraSource {
 public:
  // options and messages must outlive this object.
  CameraSource(const ViewOptions& options, Messages& messages) : options_(options), messages_(messages) {}

  // Reads the path and opens the poses.
  Error open();
  // The world is there: checks the path, finds the first place, on the ground where it is asked for, and
  // tells once of a camera in rock. Places count from here on. To be called once; world outlives this object.
  Error begin(World& world);
  bool has_begun() const { return navigator_.has_value(); }

  int fd() const { return poses_.fd(); }  // -1: no poses to wait for
  const PoseLines& poses() const { return poses_.lines(); }
  // Takes the poses that came; whether the place is another one.
  bool take_poses();
  // An event of a device at a time; whether the place changed at once.
  bool handle(const InputEvent& event, std::int64_t now_ns);

  // Whether it goes on by itself.
  bool moving() const;
  // The place of a frame that begins now, which check_place() accepts: world_s into the path; fixed_s: time
  // since the last one, below 0: by the clock.
  const CameraPlace& advance(double world_s, std::int64_t now_ns, double fixed_s);
  // From that place to the nearest surface: for place_view().
  LocalAxes axes() const { return ground_.axes_at(place_.position_m); }
  double clearance_m() { return ground_.clearance_m(place_.position_m); }

 private:
  bool take(CameraPlace pose);
  // On the ground, where the place counts from there, and within reach of the world.
  Error settle(CameraPlace& place);
  bool play_path(double world_s);

  const ViewOptions& options_;
  Messages& messages_;
  WorldInfo world_;  // of begin()
  CameraGround ground_;
  std::optional<Navigator> navigator_;
  PoseStream poses_;
  std::vector<CameraPlace> path_;
  std::size_t path_frame_ = 0;
  CameraPlace place_;
  bool posed_ = false;         // place_ is a pose that no frame has shown yet
  std::int64_t moved_at_ = 0;  // ns
};

}  // namespace karst::app
