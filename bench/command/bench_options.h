// SPDX-License-Identifier: MIT
// The command line of karst-bench: what to measure, and the options of a scene, which karst render has too.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/command_line/command_line.h"
#include "app/options/scene_options.h"
#include "platform/base/error.h"

namespace karst::bench {

enum class SuiteName : std::uint8_t {
  core,
  lod,
  pareto,
  shading,
  shadows,
  queries,
  flight,
  frames,
  select,
  sweep,
  motion
};

enum class FlightName : std::uint8_t { overview, low, oblique, high, teleport };
inline constexpr const char* kFlightNames[] = {"default", "low", "oblique", "high", "teleport"};

struct BenchOptions {
  std::string world;
  SuiteName suite = SuiteName::core;
  app::SceneArguments scene;
  int rounds = 0;              // 0: the suite's own
  int frames = 0;              // 0: the suite's own
  std::string json, csv, svg;  // files to write; empty: none
  std::string against;
  std::string path_file;
  std::string elevation, peers;
  std::vector<double> targets = {0.25, 0.5, 1, 2, 4, 8, 16};
  std::vector<double> distances = {16, 32, 64, 128};
  bool full = false;
  bool errors = true;
  double pixel_size_m = 0;  // 0: not given
  double z_scale = 1;
  int query_level = 0;              // 0: the suite's own
  std::uint32_t query_patches = 0;  // 0: the suite's own
  std::uint32_t rays = 0;           // 0: the suite's own
  FlightName flight = FlightName::overview;
  int jumps = 0;             // 0: the suite's own
  double disk_mb_per_s = 0;  // 0: the suite's own
  double disk_seek_ms = -1;  // less than 0: the suite's own
  double disk_sleep_ms = 0;  // 0: the suite's own
  bool gl_times = false;
};

extern const app::CommandSpec kBenchSpec;

// The error tells what is wrong with the command line: an option that the suite has no use for, too.
// With --help and --version options are left alone.
Error parse_bench_options(std::span<const char* const> words, app::CommandLine& line, BenchOptions& options);

}  // namespace karst::bench
