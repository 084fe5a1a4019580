// SPDX-License-Identifier: MIT
// karst-bench: what a world costs.
#include "bench/command/bench_command.h"

#include <cstdio>
#include <string>
#include <vector>

#include "app/command_line/help.h"
#include "app/command_line/manual.h"
#include "app/common/arguments.h"
#include "app/files/output_place.h"
#include "app/files/whole_file.h"
#include "bench/command/bench_options.h"
#include "bench/frames/flight_times.h"
#include "bench/ground/bench_motion.h"
#include "bench/ground/bench_sweep.h"
#include "bench/suites/bench_core.h"
#include "bench/suites/bench_flight.h"
#include "bench/suites/bench_lod.h"
#include "bench/suites/bench_pareto.h"
#include "bench/suites/bench_queries.h"
#include "bench/suites/bench_select.h"
#include "bench/suites/bench_shading.h"
#include "bench/suites/bench_shadows.h"
#include "terrain/file/world_reader.h"

namespace karst::bench {
using namespace app;
namespace {

// What the options leave open stays as the suite has it.
template <class Number>
void take(Number given, Number& out) {
  if (given != 0) out = given;
}

// Reads the world, checks all of it and hands it to a suite of the core.
template <class Suite>
int run_on_file(const std::string& path, Suite&& suite) {
  WholeFile file;
  Error error = file.open(path, WholeFile::kMostBytes);
  if (error.ok()) {
    core::WorldReader reader;
    Status status = reader.open(core::ByteSource::of(file.bytes()));
    if (status.ok()) status = reader.verify();
    if (!status.ok()) error = Error(path, status);
  }
  if (!error.ok()) {
    print_error("karst-bench", error.text());
    return kExitFailure;
  }
  return suite(file.bytes());
}

int run_core(const BenchOptions& options) {
  CoreSuiteOptions core;
  take(options.rounds, core.rounds);
  core.json = options.json;
  return run_on_file(options.world, [&](auto file) { return run_core_suite(file, core); });
}

int run_queries(const BenchOptions& options) {
  QuerySuiteOptions queries;
  take(options.rounds, queries.rounds);
  take(options.query_level, queries.level);
  take(options.query_patches, queries.patches);
  take(options.rays, queries.rays);
  return run_on_file(options.world, [&](auto file) { return run_query_suite(file, queries); });
}

int run_lod(const BenchOptions& options) {
  LodSuiteOptions lod;
  lod.world = options.world;
  lod.look = options.scene;
  take(options.frames, lod.frames);
  lod.json = options.json;
  return run_lod_suite(lod);
}

int run_pareto(const BenchOptions& options) {
  ParetoOptions pareto;
  pareto.world = options.world;
  pareto.look = options.scene;
  pareto.path_file = options.path_file;
  take(options.frames, pareto.frames);
  take(options.rounds, pareto.rounds);
  pareto.errors = options.errors;
  if (options.scene.generate_ms >= 0) pareto.work_ms = options.scene.generate_ms;
  pareto.targets = options.targets;
  pareto.distances = options.distances;
  pareto.full = options.full;
  pareto.elevation = options.elevation;
  pareto.pixel_size_m = options.pixel_size_m;
  pareto.z_scale = options.z_scale;
  pareto.json = options.json;
  pareto.csv = options.csv;
  pareto.svg = options.svg;
  pareto.peers = options.peers;
  return run_pareto_suite(pareto);
}

int run_shading(const BenchOptions& options) {
  ShadingSuiteOptions shading;
  shading.world = options.world;
  shading.look = options.scene;
  take(options.frames, shading.frames);
  take(options.rounds, shading.rounds);
  shading.against = options.against;
  shading.json = options.json;
  return run_shading_suite(shading);
}

int run_shadows(const BenchOptions& options) {
  ShadowSuiteOptions shadows;
  shadows.world = options.world;
  shadows.look = options.scene;
  take(options.frames, shadows.frames);
  return run_shadow_suite(shadows);
}

int run_flight(const BenchOptions& options) {
  FlightSuiteOptions flight;
  flight.world = options.world;
  flight.look = options.scene;
  flight.flight = kFlightNames[static_cast<int>(options.flight)];
  take(options.frames, flight.frames);
  return run_flight_suite(flight);
}

int run_frames(const BenchOptions& options) {
  FlightTimesOptions frames;
  frames.world = options.world;
  frames.look = options.scene;
  take(options.frames, frames.frames);
  frames.json = options.json;
  frames.gl_times = options.gl_times;
  return run_flight_times(frames);
}

int run_select(const BenchOptions& options) {
  SelectSuiteOptions select;
  select.world = options.world;
  select.look = options.scene;
  take(options.frames, select.frames);
  take(options.rounds, select.rounds);
  return run_select_suite(select);
}

int run_sweep(const BenchOptions& options) {
  SweepOptions sweep;
  sweep.look = options.scene;
  take(options.frames, sweep.frames);
  take(options.rounds, sweep.rounds);
  take(options.jumps, sweep.jumps);
  take(options.disk_mb_per_s, sweep.megabytes_per_s);
  if (options.disk_seek_ms >= 0) sweep.seek_ms = options.disk_seek_ms;
  take(options.disk_sleep_ms, sweep.sleep_ms);
  sweep.json = options.json;
  return run_sweep_suite(sweep);
}

int run_motion(const BenchOptions& options) {
  MotionOptions motion;
  motion.look = options.scene;
  take(options.frames, motion.frames);
  take(options.disk_mb_per_s, motion.megabytes_per_s);
  if (options.disk_seek_ms >= 0) motion.seek_ms = options.disk_seek_ms;
  return run_motion_suite(motion);
}

}  // namespace

int run_bench(std::span<const char* const> words) {
  if (!words.empty() && std::string_view(words[0]) == "--print-manual") {
    static constexpr const CommandSpec* kCommands[] = {&kBenchSpec};
    return print_manual({"karst-bench", kBenchSpec.brief, "", kCommands}, words.subspan(1));
  }
  CommandLine line;
  BenchOptions options;
  if (const Error usage = parse_bench_options(words, line, options); !usage.ok()) {
    print_error("karst-bench", usage.text());
    return kExitUsage;
  }
  if (line.wants_help()) {
    std::fputs(help_text(kBenchSpec).c_str(), stdout);
    return kExitOk;
  }
  if (line.has("version")) {
    std::puts("karst-bench " KARST_VERSION);
    return kExitOk;
  }
  const NamedFile outputs[] = {{"--json", options.json}, {"--csv", options.csv}, {"--svg", options.svg}};
  std::vector<NamedFile> inputs = files_read(options.world, options.scene);
  inputs.push_back({"--against", options.against});
  inputs.push_back({"--path", options.path_file});
  inputs.push_back({"--elevation", options.elevation});
  inputs.push_back({"--peers", options.peers});
  if (const Error error = check_outputs_apart(outputs, inputs); !error.ok()) {
    print_error("karst-bench", error.text());
    return kExitFailure;
  }
  constexpr int (*kSuites[])(const BenchOptions&) = {run_core,    run_lod,     run_pareto, run_shading,
                                                     run_shadows, run_queries, run_flight, run_frames,
                                                     run_select,  run_sweep,   run_motion};
  return kSuites[static_cast<int>(options.suite)](options);
}

}  // namespace karst::bench
