// SPDX-License-Identifier: MIT
// `karst-bench --suite motion`: flights over a synthetic ground whose tiles come from a disk, with reading
// ahead and without: how far pictures are off, how soon they are sharp after a stop, and what is read.
#pragma once

#include "app/options/scene_options.h"

namespace karst::bench {

struct MotionOptions {
  app::SceneArguments look;
  int frames = 240;             // of each flight
  double megabytes_per_s = 20;  // of the disk
  double seek_ms = 8;
};

// Returns the exit code; errors go to stderr.
int run_motion_suite(const MotionOptions& options);

}  // namespace karst::bench
