// SPDX-License-Identifier: MIT
// The command line of karst view.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/common/arguments.h"
#include "app/common/camera_path.h"
#include "app/view/frame_scheduler.h"
#include "app/view/navigator.h"
#include "platform/kms/kms_display.h"
#include "renderer/passes/frame_block.h"
#include "scene/scene.h"

namespace karst::app {
using namespace core;

struct ViewOptions {
  enum class Output { kms, headless, window };

  SceneOptions scene;  // size: of a headless picture or of the window
  Output output = Output::kms;
  KmsOptions kms;
  SeatKind seat = SeatKind::automatic;
  bool supervise = true;
  bool list_outputs = false;
  bool json = false;
  double wait_s = -1;  // for a display; below 0: for ever

  bool has_camera = false;
  CameraPlace camera;
  std::string path_file;  // empty: none
  double path_hz = 60;    // lines of the path a second of the world's time
  bool loop = false;
  std::string poses;  // "-", "udp:PORT", "udp:ADDRESS:PORT"; empty: none
  NavigatorMode navigate = NavigatorMode::fly;
  bool input = true;

  FrameScheduler::Settings clock;
  std::int64_t frames = 0;  // to draw before ending; 0: no end
  double seconds = 0;       // to run before ending; 0: no end
  std::string stats;        // empty: none

  FrameLight light;
  bool default_haze = true;
  double fov_y_deg = 60;
  LodSettings lod;
  double generate_ms = 4;  // time a frame to make vertices
};

extern const char* const kViewHelp;

// Empty where the command line is right, else what is wrong with it. With --help options are left alone.
[[nodiscard]] std::string parse_view_options(std::span<const char* const> words, Arguments& arguments,
                                             ViewOptions& options);

}  // namespace karst::app
