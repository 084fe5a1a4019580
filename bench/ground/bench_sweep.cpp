// SPDX-License-Identifier: MIT
#include "bench/ground/bench_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <memory>
#include <random>

#include "app/common/arguments.h"
#include "app/common/json_writer.h"
#include "app/common/progress.h"
#include "app/files/atomic_file.h"
#include "app/stage/frame_statistics.h"
#include "bench/frames/bench_view.h"
#include "bench/ground/sweep_view.h"
#include "bench/ground/tile_disks.h"

namespace karst::bench {
namespace {

constexpr double kFrameMs = 1000.0 / 60;     // what a disk has time for between frames
constexpr double kWorkMs = 2;                // as FrameInput::work_ms: nothing is waited for
constexpr int kMostFrames = 2000;            // to a sharp picture
constexpr std::uint64_t kSleepingTiles = 2;  // that a disk which sleeps is given time for
// Places that are jumped to lie in this part of the ground's sides: what is seen from there is ground.
constexpr double kJumpPart = 0.2;

// Looks, all on a circle of this radius around the middle, a degree a frame. Down shows nothing but the least
// ground; level shows a ground as far as it reaches.
constexpr double kRadius_m = 1000;
constexpr double kTurnDeg = 1;
struct Look {
  const char* name;
  double above_m, pitch_deg;
};
constexpr Look kLooks[] = {{"down", 1500, -60}, {"level", 60, -8}};
constexpr std::size_t kLookCount = std::size(kLooks);

// Medians and sums over the frames of all rounds.
struct LookFigures {
  std::vector<double> frame_ms, cpu_ms, select_ms;
  double triangles = 0, nodes = 0;            // means
  double first_tiles = 0, first_bytes = 0;    // to the first sharp picture
  double flight_tiles = 0, flight_bytes = 0;  // a frame of the flight from there
};

struct Figures {
  std::int64_t side = 0;  // samples
  LookFigures looks[kLookCount];
  std::uint64_t cpu_planned = 0, cpu_used = 0, gpu_planned = 0, gpu_used = 0;
  std::vector<double> sharp_frames;  // by jump
  double first_px = 0;               // the largest bound of a first frame
  std::uint64_t open_pixels = 0;     // of all first frames
  double sleeping_worst_ms = 0, sleeping_median_ms = 0;
  std::uint64_t sleeping_frames = 0, sleeping_tiles = 0;
};

class Sweep {
 public:
  Sweep(const SweepOptions& options, std::vector<Figures>& figures) : options_(options), figures_(figures) {}

  Error run() {
    for (const int log2 : options_.log2_samples) {
      grounds_.push_back(std::make_unique<SyntheticGround>(log2));
      figures_.emplace_back().side = grounds_.back()->info().samples[0];
    }
    Progress progress("sweeping", grounds_.size() * static_cast<std::size_t>(options_.rounds + 2));
    std::uint64_t done = 0;
    // In turns: a slow minute of the machine hits all sizes.
    for (int round = 0; round < options_.rounds; ++round) {
      for (std::size_t n = 0; n < grounds_.size(); ++n) {
        if (Error error = fly(n); !error.ok()) return error;
        progress.update(++done);
      }
    }
    for (std::size_t n = 0; n < grounds_.size(); ++n) {
      if (Error error = jump(n); !error.ok()) return error;
      progress.update(++done);
      if (Error error = sleep(n); !error.ok()) return error;
      progress.update(++done);
    }
    return {};
  }

 private:
  Error place(SweepView& view, const Look& look, int frame, ViewState& camera) const {
    const double turn_deg = kTurnDeg * frame;
    const double turn = turn_deg * (3.14159265358979323846 / 180);
    return view.place(kRadius_m * std::cos(turn), kRadius_m * std::sin(turn), look.above_m, turn_deg,
                      look.pitch_deg, camera);
  }

  Error fly(std::size_t n) {
    SweepView view;
    if (Error error = view.open(*grounds_[n], options_.look); !error.ok()) return error;
    for (std::size_t look = 0; look < kLookCount; ++look) {
      if (Error error = fly(n, view, look); !error.ok()) return error;
    }
    Figures& f = figures_[n];
    const Stage& stage = view.stage();
    const DeviceInfo device = device_info(stage.renderer());
    f.cpu_planned = stage.plan().cpu_bytes;
    f.cpu_used = device.cpu_bytes;
    f.gpu_planned = stage.plan().gpu_bytes;
    f.gpu_used = device.gpu_bytes;
    return {};
  }

  Error fly(std::size_t n, SweepView& view, std::size_t look) {
    TimedDisk disk(*grounds_[n], options_.megabytes_per_s, options_.seek_ms);
    view.take_tiles(disk.source());
    LookFigures& f = figures_[n].looks[look];
    int frames = 0;
    ViewState camera;
    if (Error error = place(view, kLooks[look], 0, camera); !error.ok()) return error;
    if (Error error = sharpen(view, disk, camera, frames, nullptr); !error.ok()) return error;
    f.first_tiles = static_cast<double>(disk.counts().tiles);
    f.first_bytes = static_cast<double>(disk.counts().bytes);
    double triangles = 0, nodes = 0;
    for (int k = 0; k < options_.frames; ++k) {
      if (Error error = place(view, kLooks[look], k, camera); !error.ok()) return error;
      const TimedDisk::Counts start = disk.counts();
      BenchFrame frame;
      if (Error error = view.draw(camera, 0, frame); !error.ok()) return error;
      disk.pass(kFrameMs);
      const TimedDisk::Counts& end = disk.counts();
      f.frame_ms.push_back(frame.record.frame_ms - (end.made_ms - start.made_ms));
      f.cpu_ms.push_back(frame.all_cpu_ms - (end.made_cpu_ms - start.made_cpu_ms));
      // Frames that had to ask choose more than once.
      if (end.tiles == start.tiles) f.select_ms.push_back(frame.record.costs.select_ms);
      triangles += static_cast<double>(frame.record.costs.triangles);
      nodes += frame.record.costs.nodes_drawn;
    }
    const double share = 1.0 / options_.frames;
    f.flight_tiles = (static_cast<double>(disk.counts().tiles) - f.first_tiles) * share;
    f.flight_bytes = (static_cast<double>(disk.counts().bytes) - f.first_bytes) * share;
    f.triangles = triangles * share;
    f.nodes = nodes * share;
    return {};
  }

  // Draws a picture, waiting for nothing, until nothing lacks. frames: how many that took. first: null, or
  // gets what the first one lacks.
  Error sharpen(SweepView& view, TimedDisk& disk, const ViewState& camera, int& frames, Figures* first) {
    frames = 0;
    for (bool sharp = false; !sharp && frames < kMostFrames; ++frames) {
      BenchFrame frame;
      if (Error error = view.draw(camera, kWorkMs, frame); !error.ok()) return error;
      disk.pass(kFrameMs);
      sharp = frame.record.result.complete;
      if (frames > 0 || first == nullptr) continue;
      first->first_px = std::max(first->first_px, frame.record.result.error_px[0]);
      std::uint64_t open = 0;
      if (Error error = view.count_open(open); !error.ok()) return error;
      first->open_pixels += open;
    }
    return {};
  }

  // Looking down somewhere else, until nothing lacks.
  Error jump(std::size_t n) {
    SweepView view;
    if (Error error = view.open(*grounds_[n], options_.look); !error.ok()) return error;
    TimedDisk disk(*grounds_[n], options_.megabytes_per_s, options_.seek_ms);
    view.take_tiles(disk.source());
    Figures& f = figures_[n];
    std::mt19937_64 random(1);
    const double half_m = 0.5 * kJumpPart * SyntheticGround::kSpacing_m * static_cast<double>(f.side);
    const auto between = [&](double least, double most) {
      return least + (most - least) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    for (int jump = 0; jump < options_.jumps; ++jump) {
      ViewState camera;
      const double east_m = between(-half_m, half_m), south_m = between(-half_m, half_m);
      if (Error error =
              view.place(east_m, south_m, kLooks[0].above_m, between(0, 360), kLooks[0].pitch_deg, camera);
          !error.ok())
        return error;
      int frames = 0;
      if (Error error = sharpen(view, disk, camera, frames, &f); !error.ok()) return error;
      f.sharp_frames.push_back(frames);
    }
    return {};
  }

  // Frames beside a disk that sleeps before every tile.
  Error sleep(std::size_t n) {
    SweepView view;
    if (Error error = view.open(*grounds_[n], options_.look); !error.ok()) return error;
    SleepingDisk disk(*grounds_[n], options_.sleep_ms);
    view.take_tiles(disk.source());
    Figures& f = figures_[n];
    std::vector<double> ms;
    for (int k = 0; disk.tiles() < kSleepingTiles; k = (k + 1) % options_.frames) {
      ViewState camera;
      if (Error error = place(view, kLooks[0], k, camera); !error.ok()) return error;
      BenchFrame frame;
      if (Error error = view.draw(camera, kWorkMs, frame); !error.ok()) return error;
      // The first one warms the driver.
      if (k > 0 || !ms.empty()) ms.push_back(frame.record.frame_ms);
    }
    f.sleeping_tiles = disk.tiles();
    f.sleeping_frames = ms.size();
    f.sleeping_worst_ms = ms.empty() ? 0 : *std::max_element(ms.begin(), ms.end());
    f.sleeping_median_ms = median(ms);
    // Before the disk goes.
    view.take_tiles({});
    return {};
  }

  const SweepOptions& options_;
  std::vector<Figures>& figures_;
  std::vector<std::unique_ptr<SyntheticGround>> grounds_;
};

double middle(const std::vector<double>& values) {
  std::vector<double> copy = values;
  return median(copy);
}

constexpr double kMebibyte = 1 << 20;

void print_text(const SweepOptions& options, const std::vector<Figures>& all) {
  std::printf("%d x %d, %g px; disk of %g MB/s and %g ms a read, %.1f ms a frame\n", options.look.width,
              options.look.height, options.look.error_px, options.megabytes_per_s, options.seek_ms, kFrameMs);
  std::printf("%-6s %10s %9s %8s %6s %9s %9s %7s %15s %15s\n", "look", "samples", "frame ms", "CPU ms", "",
              "select ms", "triangles", "nodes", "first: tiles, KiB", "a frame");
  for (std::size_t look = 0; look < kLookCount; ++look) {
    for (const Figures& figures : all) {
      const LookFigures& f = figures.looks[look];
      const double least = middle(all[0].looks[look].cpu_ms);
      std::printf("%-6s %10.2g %9.2f %8.2f %5.2fx %9.4f %9.0f %7.0f %7.2f %7.1f %7.2f %7.1f\n",
                  kLooks[look].name, static_cast<double>(figures.side) * static_cast<double>(figures.side),
                  middle(f.frame_ms), middle(f.cpu_ms), middle(f.cpu_ms) / least, middle(f.select_ms),
                  f.triangles, f.nodes, f.first_tiles, f.first_bytes / 1024, f.flight_tiles,
                  f.flight_bytes / 1024);
    }
  }
  std::printf(
      "CPU: of all threads, without what making tiles takes; x: of the least ground's\n"
      "first: read for the first sharp picture; a frame: of the flight from there\n\n");
  std::printf("%10s %22s %22s %14s %10s %6s %24s\n", "samples", "CPU MiB: plan, used", "GPU MiB: plan, used",
              "sharp: median", "most", "open", "asleep: ms, worst, frames");
  for (const Figures& f : all) {
    std::printf("%10.2g %11.2f %10.2f %11.2f %10.2f %14.0f %10.0f %6llu %8.1f %7.1f %7llu\n",
                static_cast<double>(f.side) * static_cast<double>(f.side),
                static_cast<double>(f.cpu_planned) / kMebibyte, static_cast<double>(f.cpu_used) / kMebibyte,
                static_cast<double>(f.gpu_planned) / kMebibyte, static_cast<double>(f.gpu_used) / kMebibyte,
                middle(f.sharp_frames),
                f.sharp_frames.empty() ? 0 : *std::max_element(f.sharp_frames.begin(), f.sharp_frames.end()),
                static_cast<unsigned long long>(f.open_pixels), f.sleeping_median_ms, f.sleeping_worst_ms,
                static_cast<unsigned long long>(f.sleeping_frames));
  }
  std::printf(
      "sharp: frames after a jump; open: pixels of first frames without ground\n"
      "asleep: frames beside a disk that sleeps %g ms a tile\n",
      options.sleep_ms);
}

std::string json_text(const SweepOptions& options, const std::vector<Figures>& all) {
  JsonWriter json;
  json.begin_object().key("size").begin_array();
  json.value(options.look.width).value(options.look.height).end_array();
  json.field("error_px", options.look.error_px).field("disk_mb_per_s", options.megabytes_per_s);
  json.field("disk_seek_ms", options.seek_ms).field("frame_ms_for_disk", kFrameMs);
  json.field("disk_sleep_ms", options.sleep_ms).key("grounds").begin_array();
  for (const Figures& f : all) {
    json.begin_object().field("samples_a_side", f.side).key("looks").begin_array();
    for (std::size_t look = 0; look < kLookCount; ++look) {
      const LookFigures& l = f.looks[look];
      json.begin_object().field("name", kLooks[look].name).field("frame_ms", middle(l.frame_ms));
      json.field("cpu_ms", middle(l.cpu_ms)).field("select_ms", middle(l.select_ms));
      json.field("triangles", l.triangles).field("nodes", l.nodes);
      json.field("first_tiles", l.first_tiles).field("first_bytes", l.first_bytes);
      json.field("frame_tiles", l.flight_tiles).field("frame_bytes", l.flight_bytes).end_object();
    }
    json.end_array().field("cpu_planned", f.cpu_planned).field("cpu_used", f.cpu_used);
    json.field("gpu_planned", f.gpu_planned).field("gpu_used", f.gpu_used).key("sharp_frames").begin_array();
    for (const double frames : f.sharp_frames) json.value(frames);
    json.end_array().field("first_px", f.first_px).field("open_pixels", f.open_pixels);
    json.field("sleeping_median_ms", f.sleeping_median_ms).field("sleeping_worst_ms", f.sleeping_worst_ms);
    json.field("sleeping_frames", f.sleeping_frames).field("sleeping_tiles", f.sleeping_tiles).end_object();
  }
  json.end_array().end_object();
  return json.text();
}

Error run_suite(const SweepOptions& options) {
  if (!options.json.empty() && options.json != "-") {
    if (Error error = check_writable(options.json); !error.ok()) return error;
  }
  std::vector<Figures> figures;
  if (Error error = Sweep(options, figures).run(); !error.ok()) return error;
  const std::string text = json_text(options, figures);
  if (options.json == "-") {
    std::fputs(text.c_str(), stdout);
    return {};
  }
  print_text(options, figures);
  return options.json.empty() ? Error() : write_file_atomic(options.json, std::as_bytes(std::span(text)));
}

}  // namespace

int run_sweep_suite(const SweepOptions& options) {
  const Error error = run_suite(options);
  if (error.ok()) return kExitOk;
  print_error("karst-bench", error.text());
  return kExitFailure;
}

}  // namespace karst::bench
