// SPDX-License-Identifier: MIT
// Paths of cameras, and one camera as it is given on a command line.
#include "app/common/camera_path.h"
#include "tests/fuzz/run/fuzz_target.h"

#include <cmath>

namespace karst {
namespace {

void must_be_a_place(const app::CameraPlace& place) {
  for (int axis = 0; axis < 3; ++axis) must(std::isfinite(place.position_m[axis]));
  must(std::isfinite(place.yaw_deg) && std::isfinite(place.pitch_deg));
}

}  // namespace

void fuzz_one(std::span<const std::byte> input) {
  static const std::string name = "path.txt";
  static std::vector<app::CameraPlace> path;
  Error error = app::parse_camera_path(as_text(input), name, path);
  must_be_short(error);
  if (error.ok()) {
    must(!path.empty() && path.size() <= app::kMaxPathFrames);
    for (const app::CameraPlace& place : path) must_be_a_place(place);
  }
  app::CameraPlace place;
  error = app::parse_camera(as_text(input), "--camera", place);
  must_be_short(error);
  must_be_a_place(place);
}

}  // namespace karst
