// SPDX-License-Identifier: MIT
#include "bench/ground/bench_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "app/common/arguments.h"
#include "app/stage/frame_statistics.h"
#include "bench/ground/sweep_view.h"
#include "bench/ground/tile_disks.h"

namespace karst::bench {
namespace {

using namespace app;

constexpr int kLog2 = 17;                 // samples a side
constexpr double kFrameMs = 1000.0 / 60;  // what a disk has time for between frames
// As FrameInput::work_ms: nothing is waited for, and all that came is taken.
constexpr double kWorkMs = 50;
constexpr int kMostFrames = 2000;     // to a sharp picture
constexpr double kMostPixels = 1000;  // that a bound counts for

// Eastwards at one height, so far above the highest ground on the way.
struct Flight {
  const char* name;
  double m_per_s, above_m, pitch_deg;
};
constexpr Flight kFlights[] = {
    {"slow", 60, 60, -8}, {"fast", 600, 60, -8}, {"faster", 3000, 60, -8}, {"fast, down", 3000, 1500, -60}};

struct Figures {
  std::vector<double> bound_px, select_ms;
  int sharp = 0, until_sharp = 0;
  double tiles = 0, bytes = 0, left_out = 0;
  std::uint32_t asked = 0, used = 0, wasted = 0, sizes_left_out = 0;
};

Error fly(const MotionOptions& options, const SyntheticGround& ground, const Flight& flight, bool ahead,
          Figures& f) {
  SweepView view;
  if (Error error = view.open(ground, options.look); !error.ok()) return error;
  TimedDisk disk(ground, options.megabytes_per_s, options.seek_ms);
  view.take_tiles(disk.source());
  const double way_m = flight.m_per_s * kFrameMs / 1000;
  double high_m = -1e9;
  ViewState camera;
  for (int k = 0; k < options.frames; ++k) {
    if (Error error = view.place(k * way_m, 0, flight.above_m, -90, flight.pitch_deg, camera); !error.ok())
      return error;
    high_m = std::max(high_m, camera.eye.y);
  }
  BenchFrame frame;
  const auto draw = [&](int k, double work_ms) {
    if (Error error = view.place(k * way_m, 0, flight.above_m, -90, flight.pitch_deg, camera); !error.ok())
      return error;
    camera.eye.y = high_m;
    const Error error = view.draw(camera, work_ms, frame, ahead);
    disk.pass(kFrameMs);
    return error;
  };
  if (Error error = draw(0, 0); !error.ok()) return error;
  const TimedDisk::Counts start = disk.counts();
  const auto count = [&] {
    const FrameCosts& costs = frame.record.costs;
    f.asked += costs.ahead_asked;
    f.used += costs.ahead_used;
    f.wasted += costs.ahead_wasted;
    f.left_out += costs.left_out;
    f.sizes_left_out = std::max(f.sizes_left_out, costs.sizes_left_out);
  };
  for (int k = 0; k < options.frames; ++k) {
    if (Error error = draw(k, kWorkMs); !error.ok()) return error;
    count();
    f.select_ms.push_back(frame.record.costs.select_ms);
    f.bound_px.push_back(std::min(frame.record.result.error_px[0], kMostPixels));
    f.sharp += frame.record.result.error_px[0] <= options.look.error_px ? 1 : 0;
  }
  f.left_out /= options.frames;
  f.tiles = static_cast<double>(disk.counts().tiles - start.tiles);
  f.bytes = static_cast<double>(disk.counts().bytes - start.bytes);
  for (; f.until_sharp < kMostFrames && !frame.record.result.complete; ++f.until_sharp) {
    if (Error error = draw(options.frames - 1, kWorkMs); !error.ok()) return error;
    count();
  }
  return {};
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

int run_motion_suite(const MotionOptions& options) {
  const SyntheticGround ground(kLog2);
  std::printf("%d x %d, %g px; disk of %g MB/s and %g ms a read, %.1f ms a frame; %d frames a flight\n",
              options.look.width, options.look.height, options.look.error_px, options.megabytes_per_s,
              options.seek_ms, kFrameMs, options.frames);
  std::printf("%-11s %6s %6s %7s %8s %8s %6s %6s %8s %22s %16s %9s\n", "flight", "m/s", "ahead", "sharp",
              "px: mean", "p95", "stop", "tiles", "KiB", "ahead: asked used lost", "left out, below",
              "select ms");
  for (const Flight& flight : kFlights) {
    for (const bool ahead : {false, true}) {
      Figures f;
      if (const Error error = fly(options, ground, flight, ahead, f); !error.ok()) {
        print_error("karst-bench", error.text());
        return kExitFailure;
      }
      std::printf("%-11s %6.0f %6s %6.0f%% %8.2f %8.2f %6d %6.0f %8.0f %8u %6u %6u %10.1f %5u %9.3f\n",
                  flight.name, flight.m_per_s, ahead ? "yes" : "no", 100.0 * f.sharp / options.frames,
                  mean(f.bound_px), percentile(f.bound_px, 0.95), f.until_sharp, f.tiles, f.bytes / 1024,
                  f.asked, f.used, f.wasted, f.left_out, f.sizes_left_out, mean(f.select_ms));
    }
  }
  std::printf(
      "sharp: frames whose bound is that asked for; px: bounds, %g at most; stop: frames until the last\n"
      "picture is sharp when it stands still; left out: nodes a frame, of sizes below\n",
      kMostPixels);
  return kExitOk;
}

}  // namespace karst::bench
