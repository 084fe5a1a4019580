// SPDX-License-Identifier: MIT
// `karst-bench WORLD --suite shadows`: what shadow maps cost that are drawn only when something in them
// changed, beside drawing all of them in every frame.
#pragma once

#include <string>
#include "app/options/scene_options.h"

namespace karst::bench {
using namespace app;

struct ShadowSuiteOptions {
  std::string world;
  SceneArguments look;  // light, skips and levels of its pictures
  int frames = 36;      // of each flight
};

// Measures a camera that turns once in place, and the standard flights. Returns the exit code; errors go to
// stderr.
int run_shadow_suite(const ShadowSuiteOptions& options);

}  // namespace karst::bench
