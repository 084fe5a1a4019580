// SPDX-License-Identifier: MIT
// The command line of karst render.
#pragma once

#include <span>
#include <string>

#include "app/command_line/command_line.h"
#include "app/options/scene_options.h"

namespace karst::app {

struct RenderOptions {
  std::string world;
  std::string output;  // empty: no pictures
  std::string stats;   // empty: none
  CameraArguments camera;
  SceneArguments scene;
};

extern const CommandSpec kRenderSpec;

// Empty where the command line is right, else what is wrong with it. With --help options are left alone.
[[nodiscard]] std::string parse_render_options(std::span<const char* const> words, CommandLine& line,
                                               RenderOptions& options);

}  // namespace karst::app
