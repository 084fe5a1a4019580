// SPDX-License-Identifier: MIT
// `karst-bench WORLD --suite frames`: times of frames on the standard flights in one way of drawing, which
// the options say. docs/devices.md has them of several devices.
#pragma once

#include <string>

#include "app/options/scene_options.h"

namespace karst::bench {
using namespace app;

struct FlightTimesOptions {
  std::string world;
  SceneArguments look;
  int frames = 24;        // of each flight
  std::string json;       // file; "-": printed in place of the table; empty: none
  bool gl_times = false;  // what the functions of GL take, too
};

// Flies each flight twice and measures the second time: complete frames, each waited for until the GPU is
// done. Returns the exit code; errors go to stderr.
int run_flight_times(const FlightTimesOptions& options);

}  // namespace karst::bench
