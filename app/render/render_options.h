// SPDX-License-Identifier: MIT
// The command line of karst render.
#pragma once

#include <span>
#include <string>

#include "app/command_line/command_line.h"
#include "app/options/scene_options.h"
#include "platform/base/error.h"

namespace karst::app {

struct RenderOptions {
  std::string world;
  std::string output;  // empty: no pictures
  std::string stats;   // empty: none
  CameraArguments camera;
  SceneArguments scene;
};

extern const CommandSpec kRenderSpec;

// The error tells what is wrong with the command line. With --help options are left alone.
Error parse_render_options(std::span<const char* const> words, CommandLine& line, RenderOptions& options);

}  // namespace karst::app
