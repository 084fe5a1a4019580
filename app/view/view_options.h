// SPDX-License-Identifier: MIT
// The command line of karst view.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "app/command_line/command_line.h"
#include "app/editor/edit_session.h"
#include "app/motion/navigator.h"
#include "app/options/scene_options.h"
#include "app/screen/screen_options.h"
#include "platform/base/error.h"

namespace karst::app {

struct ViewOptions : ScreenArguments {
  std::string world;
  SceneArguments scene;  // size: of a headless picture or of the window
  CameraArguments camera;

  double path_hz = 60;  // lines of the path a second of the world's time
  bool loop = false;
  std::string poses;  // "-", "udp:PORT", "udp:ADDRESS:PORT"; empty: none
  NavigatorMode navigate = NavigatorMode::fly;

  bool edit = false;
  EditSession::Files edit_files;            // world: as above
  std::uint64_t edit_bytes = 128ull << 20;  // of memory, about

  bool fixed_clock = false;
  std::int64_t frames = 0;  // to draw before ending; 0: no end
  double seconds = 0;       // to run before ending; 0: no end
  std::string stats;        // empty: none
};

extern const CommandSpec kViewSpec;

// The error tells what is wrong with the command line. With --help options are left alone.
Error parse_view_options(std::span<const char* const> words, CommandLine& line, ViewOptions& options);

}  // namespace karst::app
