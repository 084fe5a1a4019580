// SPDX-License-Identifier: MIT
// `karst-bench WORLD --suite pareto`: what a frame costs against how far its picture is from the truth, for a
// sweep of error targets and of K's distance scheme over flights. docs/run-time-against-error.md shows it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/options/scene_options.h"
#include "bench/measure/picture_error.h"
#include "platform/base/error.h"

namespace karst::bench {
using namespace app;

struct ParetoOptions {
  std::string world;
  SceneArguments look;            // light and skips of its pictures
  std::string path_file;          // empty: the standard flights
  int frames = 120;               // of each standard flight
  int rounds = 1;                 // measured laps of each setting, in turns with all others of the flight
  bool errors = true;             // false: times and memory alone
  double work_ms = 0;             // of timed frames, 0: complete ones; errors are always of complete ones
  std::vector<double> targets;    // pixels; mode error
  std::vector<double> distances;  // voxels; mode distance
  bool full = false;              // measures the full level too
  std::string elevation;          // PNG; empty: pictures are compared with those of the full level
  double pixel_size_m = 0;
  double z_scale = 1;
  std::string json, csv, svg, peers;  // files; empty: none. peers is read
};

// One setting on one flight.
struct ParetoRow {
  std::string path;
  std::string mode;   // "error", "distance", "full"
  double target = 0;  // pixels, voxels; 0 for full
  double frame_median_ms = 0, frame_p99_ms = 0;
  double main_cpu_ms = 0, all_cpu_ms = 0, cull_lod_ms = 0, generate_ms = 0, upload_ms = 0,
         submit_ms = 0;                                      // medians
  double triangles = 0, most_triangles = 0, draw_calls = 0;  // means and a maximum
  double working_set_mib = 0;                                // largest of a frame
  double resident_mib = 0;                                   // the process, after the laps of this setting
  double bound_px = 0;                                       // largest of a frame
  ErrorSummary errors;
  // Mean difference of a colour from the full level's, in steps of 1/255; NaN against elevation.
  double colour_difference = ErrorSummary::kNone;
};

struct ParetoResult {
  std::string world;
  std::string renderer;  // GL_RENDERER
  int width = 0, height = 0;
  double first_frame_ms = 0;
  double peak_resident_mib = 0;  // of the process, up to the last timed frame
  std::vector<ParetoRow> rows;
};

// All timing first, then the errors where options ask for them.
Error measure_pareto(const ParetoOptions& options, ParetoResult& result);

std::string pareto_csv(const ParetoResult& result);
std::string pareto_json(const ParetoResult& result);
std::string pareto_text(const ParetoResult& result);  // for people
// peers_csv: text of a file of peers' results, empty for none; columns are found by the names in its first
// line. An error says what is wrong with it.
Error pareto_svg(const ParetoResult& result, std::string_view peers_csv, std::string& svg);

// Measures, prints a table, writes the files. Returns the exit code; errors go to stderr.
int run_pareto_suite(const ParetoOptions& options);

}  // namespace karst::bench
