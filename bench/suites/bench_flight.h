// SPDX-License-Identifier: MIT
// `karst-bench WORLD --suite flight`: prints a flight as a path file, with how much terrain its pictures
// show, so that other programs can fly it.
#pragma once

#include <string>

#include "app/options/scene_options.h"

namespace karst::bench {
using namespace app;

struct FlightSuiteOptions {
  std::string world;
  SceneArguments look;
  std::string flight = "default";  // BenchView::flight
  int frames = 24;
};

// Returns the exit code; errors go to stderr.
int run_flight_suite(const FlightSuiteOptions& options);

}  // namespace karst::bench
