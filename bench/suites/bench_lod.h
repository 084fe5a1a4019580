// SPDX-License-Identifier: MIT
// `karst-bench WORLD --suite lod`: what choosing, making and submitting a frame costs, beside K's tables
// 5.9 - 5.12.
#pragma once

#include <string>

#include "app/options/scene_options.h"

namespace karst::bench {
using namespace app;

struct LodSuiteOptions {
  std::string world;
  SceneArguments look;  // its level is not used; vertex_bytes 0: everything stays resident, as K has it
  int frames = 24;      // of the oblique flight
  std::string json;     // file; "-": printed in place of the table; empty: none
};

// Measures levels 4 and 5 (those that the world has) with 1, 2 and 4 passes a frame. Returns the exit code;
// errors go to stderr.
int run_lod_suite(const LodSuiteOptions& options);

}  // namespace karst::bench
