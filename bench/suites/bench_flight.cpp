// SPDX-License-Identifier: MIT
#include "bench/suites/bench_flight.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "app/common/arguments.h"
#include "bench/frames/bench_view.h"

namespace karst::bench {
using namespace app;
namespace {

Error run_suite(const FlightSuiteOptions& options) {
  BenchView view;
  if (Error error = view.open(options.world, options.look, true); !error.ok()) return error;
  const std::vector<CameraPlace> flight = view.flight(options.flight, options.frames);
  std::vector<std::uint8_t> rgba;
  std::vector<float> depth;
  std::printf("# %s: a line a frame, behind it the pixels of %d x %d that show terrain\n",
              options.flight.c_str(), options.look.width, options.look.height);
  for (const CameraPlace& place : flight) {
    ViewState camera;
    BenchFrame frame;
    if (Error error = view.place(place, camera); !error.ok()) return error;
    if (Error error = view.draw(camera, view.levels(), frame); !error.ok()) return error;
    if (Error error = view.read(rgba, depth); !error.ok()) return error;
    const auto covered = std::count_if(depth.begin(), depth.end(), [](float d) { return d < 1; });
    std::printf("%.12g %.12g %.12g %.12g %.12g # %td\n", place.position_m.x, place.position_m.y,
                place.position_m.z, place.yaw_deg, place.pitch_deg, covered);
  }
  return {};
}

}  // namespace

int run_flight_suite(const FlightSuiteOptions& options) {
  const Error error = run_suite(options);
  if (error.ok()) return kExitOk;
  print_error("karst-bench", error.text());
  return kExitFailure;
}

}  // namespace karst::bench
