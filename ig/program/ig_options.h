// SPDX-License-Identifier: MIT
// The command line of karst-ig.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <glm/vec3.hpp>

#include "app/command_line/command_line.h"
#include "app/options/scene_options.h"
#include "app/screen/screen_options.h"
#include "ig/link/udp_link.h"
#include "ig/state/views.h"

namespace karst::ig {

struct IgOptions : app::ScreenArguments {
  std::string world;
  app::SceneArguments scene;  // size: of a headless picture or of the window

  std::string listen = "8004", host = "8005";
  UdpAddress listen_address, host_address;
  bool remote = false;
  int database = 1;
  std::optional<Geodetic> anchor;
  ViewLayout views;
  glm::dvec3 box_m{12, 10, 4};  // of entities: length, width, height
  double rate_hz = 60;          // of displays that tell no refresh

  double seconds = 0;   // to run before ending; 0: no end
  std::string stats;    // empty: none
  std::string picture;  // of the last frame, at the end; empty: none
};

extern const app::CommandSpec kIgSpec;

// The error tells what is wrong with the command line. With --help options are left alone.
Error parse_ig_options(std::span<const char* const> words, app::CommandLine& line, IgOptions& options);

}  // namespace karst::ig
