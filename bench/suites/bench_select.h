// SPDX-License-Identifier: MIT
// `karst-bench WORLD --suite select`: what choosing levels, listing patches and writing indices cost.
#pragma once

#include <string>

#include "app/options/scene_options.h"

namespace karst::bench {

struct SelectSuiteOptions {
  std::string world;
  app::SceneArguments look;
  int frames = 240;  // a lap, at least 1
  int rounds = 3;    // measured laps, at least 1
};

// Prints to stdout. Returns the exit code; errors go to stderr.
int run_select_suite(const SelectSuiteOptions& options);

}  // namespace karst::bench
