// SPDX-License-Identifier: MIT
// `karst-bench --suite sweep`: the same views of synthetic grounds from 10^6 to 10^12 samples, in the same
// memory: what a frame costs, what is read, how soon a picture is sharp after a jump, and that no frame waits
// for a disk.
#pragma once

#include <string>
#include <vector>

#include "app/options/scene_options.h"
#include "bench/ground/synthetic_ground.h"

namespace karst::bench {
using namespace app;

struct SweepOptions {
  SceneArguments look;
  // Grounds of 2^n + 1 samples a side.
  std::vector<int> log2_samples = {10, 13, 17, 20};
  int frames = 24;               // of each flight
  int rounds = 3;                // measured laps of each
  int jumps = 8;                 // to new places
  double megabytes_per_s = 100;  // of the disk
  double seek_ms = 5;
  double sleep_ms = 1000;  // of the disk that no frame may wait for
  std::string json;        // file; "-": in place of the table; empty: none
};

// Returns the exit code; errors go to stderr.
int run_sweep_suite(const SweepOptions& options);

}  // namespace karst::bench
