// SPDX-License-Identifier: MIT
// All timing comes before any measuring of errors, so that neither the time nor the memory of the metric is
// part of a figure. Settings take turns, lap by lap: a slow minute of the machine hits them alike.
#include "bench/suites/bench_pareto.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>

#include "app/common/arguments.h"
#include "app/common/camera_path.h"
#include "app/common/progress.h"
#include "app/files/atomic_file.h"
#include "app/files/whole_file.h"
#include "app/stage/camera_ground.h"
#include "bench/frames/bench_view.h"

namespace karst::bench {
using namespace app;
namespace {

// Frames of a flight whose error is measured, evenly spaced: for the peers' path of 240 frames every 40th.
constexpr int kErrorFrames = 6;

constexpr double kMebibyte = 1 << 20;

// For pictures that others are compared with: far above any world's full level.
constexpr std::uint64_t kReferenceMemory = std::uint64_t{1} << 34;  // bytes

struct Setting {
  std::string mode;
  double target = 0;
  LevelChoice lod;
};

struct Flight {
  std::string name;
  std::vector<ViewState> cameras;
};

std::vector<Setting> settings_of(const ParetoOptions& options) {
  std::vector<Setting> settings;
  for (const double target : options.targets) {
    settings.push_back({"error", target, {}});
    settings.back().lod.error_px = target;
  }
  for (const double distance : options.distances) {
    settings.push_back({"distance", distance, {}});
    settings.back().lod.mode = LodMode::distance;
    settings.back().lod.distance_voxels = distance;
  }
  if (options.full) {
    settings.push_back({"full", 0, {}});
    settings.back().lod.mode = LodMode::full;
  }
  return settings;
}

Error file_flight(BenchView& view, const std::string& path, std::vector<Flight>& flights) {
  WholeFile file;
  if (Error error = file.open(path, WholeFile::kMostText); !error.ok()) return error;
  const std::string_view text = file.text();
  std::vector<CameraPlace> places;
  if (Error error = parse_camera_path(text, path, places); !error.ok()) return error;
  Flight& flight = flights.emplace_back();
  flight.name = path.substr(path.find_last_of('/') + 1);
  flight.name = flight.name.substr(0, flight.name.find_last_of('.'));
  CameraGround ground;
  if (Error error = ground.open(view.stage().world()); !error.ok()) return error;
  for (CameraPlace& place : places) {
    if (const Error error = ground.stand(place); !error.ok()) return path + ": " + error.text();
    if (const Error error = view.place(place, flight.cameras.emplace_back()); !error.ok())
      return path + ": " + error.text();
  }
  return {};
}

Error make_flights(BenchView& view, const ParetoOptions& options, std::vector<Flight>& flights) {
  if (!options.path_file.empty()) return file_flight(view, options.path_file, flights);
  const GroundHeights& ground = view.ground();
  for (const std::string_view name : kStandardPaths) {
    Flight& flight = flights.emplace_back();
    flight.name = name;
    const auto path = make_standard_path(name, ground, view.terrain().box(), options.frames);
    if (Error error = view.place(path, flight.cameras); !error.ok()) return error;
  }
  return {};
}

void summarise_times(const std::vector<BenchFrame>& frames, ParetoRow& row) {
  const auto collect = [&](auto get) {
    std::vector<double> values;
    for (const BenchFrame& frame : frames) values.push_back(static_cast<double>(get(frame)));
    return values;
  };
  const auto mid = [&](auto get) {
    std::vector<double> values = collect(get);
    return median(values);
  };
  const auto mean = [&](auto get) {
    double sum = 0;
    for (const double value : collect(get)) sum += value;
    return sum / static_cast<double>(frames.size());
  };
  const auto most = [&](auto get) {
    const std::vector<double> values = collect(get);
    return *std::max_element(values.begin(), values.end());
  };
  std::vector<double> ms = collect([](const BenchFrame& f) { return f.record.frame_ms; });
  row.frame_median_ms = median(ms);
  row.frame_p99_ms = percentile(ms, 0.99);
  row.main_cpu_ms = mid([](const BenchFrame& f) { return f.main_cpu_ms; });
  row.all_cpu_ms = mid([](const BenchFrame& f) { return f.all_cpu_ms; });
  row.cull_lod_ms = mid([](const BenchFrame& f) { return f.record.costs.select_ms; });
  row.generate_ms = mid([](const BenchFrame& f) { return f.record.costs.generate_ms; });
  row.upload_ms = mid([](const BenchFrame& f) { return f.record.costs.upload_ms; });
  row.submit_ms = mid([](const BenchFrame& f) { return f.record.costs.submit_ms; });
  row.triangles = mean([](const BenchFrame& f) { return f.record.costs.triangles; });
  row.most_triangles = most([](const BenchFrame& f) { return f.record.costs.triangles; });
  row.draw_calls = mean([](const BenchFrame& f) { return f.record.costs.draw_calls; });
  row.working_set_mib = most([](const BenchFrame& f) { return f.working_set_bytes; }) / kMebibyte;
  row.bound_px = most([](const BenchFrame& f) { return f.record.result.error_px[0]; });
}

class Measure {
 public:
  Measure(const ParetoOptions& options, ParetoResult& result)
      : options_(options), result_(result), settings_(settings_of(options)) {}

  Error run() {
    if (!options_.elevation.empty()) {
      if (Error error =
              read_elevation_png(options_.elevation, options_.pixel_size_m, options_.z_scale, grid_);
          !error.ok()) {
        return error;
      }
    }
    if (Error error = time_flights(); !error.ok() || !options_.errors) return error;
    if (options_.elevation.empty()) {
      if (Error error = draw_references(); !error.ok()) return error;
    }
    return measure_errors();
  }

 private:
  Error lap(const Flight& flight, const Setting& setting, std::vector<BenchFrame>* frames) {
    BenchFrame frame;
    for (const ViewState& camera : flight.cameras) {
      if (Error error = view_->draw(camera, setting.lod, frame, options_.work_ms); !error.ok()) {
        return error;
      }
      if (frames != nullptr) frames->push_back(frame);
    }
    return {};
  }

  // Opens the world anew: what an earlier part of the work took is given back first.
  Error open(const SceneArguments& look, bool keep_depth) {
    view_ = nullptr;
    view_ = std::make_unique<BenchView>();
    return view_->open(options_.world, look, keep_depth);
  }

  Error time_flights() {
    if (Error error = open(options_.look, false); !error.ok()) return error;
    if (Error error = make_flights(*view_, options_, flights_); !error.ok()) return error;
    result_.world = view_->stage().world().info().name;
    result_.renderer = device_info(view_->stage().renderer()).renderer;
    result_.width = options_.look.width;
    result_.height = options_.look.height;
    Progress progress("timing",
                      flights_.size() * static_cast<std::size_t>(options_.rounds) * settings_.size());
    for (const Flight& flight : flights_) {
      if (Error error = time_flight(flight, progress); !error.ok()) return error;
    }
    result_.first_frame_ms = view_->first_frame_ms();
    result_.peak_resident_mib = static_cast<double>(peak_resident_bytes()) / kMebibyte;
    return {};
  }

  Error time_flight(const Flight& flight, Progress& progress) {
    std::vector<std::vector<BenchFrame>> frames(settings_.size());
    std::vector<double> resident(settings_.size());
    for (int round = 0; round < options_.rounds; ++round) {
      for (std::size_t s = 0; s < settings_.size(); ++s) {
        for (const bool keep : {false, true}) {
          if (Error error = lap(flight, settings_[s], keep ? &frames[s] : nullptr); !error.ok()) return error;
        }
        resident[s] = static_cast<double>(resident_bytes()) / kMebibyte;
        progress.update(++laps_);
      }
    }
    for (std::size_t s = 0; s < settings_.size(); ++s) {
      ParetoRow& row = result_.rows.emplace_back();
      row.path = flight.name;
      row.mode = settings_[s].mode;
      row.target = settings_[s].target;
      row.resident_mib = resident[s];
      summarise_times(frames[s], row);
    }
    return {};
  }

  // The frames of a flight whose error is measured.
  static std::vector<ViewState> error_frames(const Flight& flight) {
    std::vector<ViewState> cameras;
    const std::size_t stride = std::max<std::size_t>(1, flight.cameras.size() / kErrorFrames);
    for (std::size_t i = 0; i < flight.cameras.size(); i += stride) cameras.push_back(flight.cameras[i]);
    return cameras;
  }

  struct Picture {
    std::vector<std::uint8_t> rgba;
    std::vector<float> depth;
  };

  Error draw(const ViewState& camera, const LevelChoice& lod, Picture& picture) {
    BenchFrame frame;
    if (Error error = view_->draw(camera, lod, frame); !error.ok()) return error;
    return view_->read(picture.rgba, picture.depth);
  }

  // Everything at the full level, whatever memory that takes.
  Error draw_references() {
    SceneArguments look = options_.look;
    look.vertex_bytes = std::numeric_limits<std::uint64_t>::max();
    look.max_memory = kReferenceMemory;
    if (Error error = open(look, true); !error.ok()) return error;
    LevelChoice full;
    full.mode = LodMode::full;
    for (const Flight& flight : flights_) {
      for (const ViewState& camera : error_frames(flight)) {
        if (Error error = draw(camera, full, references_.emplace_back()); !error.ok()) return error;
      }
    }
    return {};
  }

  Error measure_errors() {
    if (Error error = open(options_.look, true); !error.ok()) return error;
    Progress progress("measuring", flights_.size() * settings_.size());
    std::size_t reference = 0;
    for (std::size_t f = 0; f < flights_.size(); ++f) {
      const std::vector<ViewState> cameras = error_frames(flights_[f]);
      for (std::size_t s = 0; s < settings_.size(); ++s) {
        ParetoRow& row = result_.rows[f * settings_.size() + s];
        if (Error error = measure(cameras, reference, settings_[s].lod, row); !error.ok()) return error;
        progress.update(f * settings_.size() + s + 1);
      }
      reference += cameras.size();
    }
    return {};
  }

  Error measure(std::span<const ViewState> cameras, std::size_t first_reference, const LevelChoice& lod,
                ParetoRow& row) {
    std::vector<float> px;
    Picture drawn;
    double difference = 0;
    DepthPicture picture;
    picture.width = result_.width;
    picture.height = result_.height;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      if (const Status status = view_->placement().make_camera(cameras[i], picture.camera); !status.ok())
        return Error("camera", status);
      if (Error error = draw(cameras[i], lod, drawn); !error.ok()) return error;
      picture.depth = drawn.depth;
      if (options_.elevation.empty()) {
        const Picture& reference = references_[first_reference + i];
        errors_against_picture(picture, reference.depth, px);
        difference += mean_colour_difference(drawn.rgba, reference.rgba);
      } else {
        errors_against_elevation(picture, view_->placement().world(), grid_, px);
      }
    }
    row.errors = summarise_errors(px);
    if (options_.elevation.empty()) row.colour_difference = difference / static_cast<double>(cameras.size());
    return {};
  }

  const ParetoOptions& options_;
  ParetoResult& result_;
  std::vector<Setting> settings_;
  std::vector<Flight> flights_;
  ElevationGrid grid_;
  std::vector<Picture> references_;  // flight by flight
  std::uint64_t laps_ = 0;
  std::unique_ptr<BenchView> view_;
};

Error write_text(const std::string& path, const std::string& text) {
  return path.empty() ? Error() : write_file_atomic(path, std::as_bytes(std::span(text)));
}

Error run_suite(const ParetoOptions& options) {
  for (const std::string* path : {&options.json, &options.csv, &options.svg}) {
    if (path->empty()) continue;
    if (Error error = check_writable(*path); !error.ok()) return error;
  }
  WholeFile peers;
  if (!options.peers.empty()) {
    if (Error error = peers.open(options.peers, WholeFile::kMostText); !error.ok()) return error;
  }
  ParetoResult result;
  if (Error error = measure_pareto(options, result); !error.ok()) return error;
  std::fputs(pareto_text(result).c_str(), stdout);
  if (Error error = write_text(options.json, pareto_json(result)); !error.ok()) return error;
  if (Error error = write_text(options.csv, pareto_csv(result)); !error.ok()) return error;
  if (options.svg.empty()) return {};
  std::string svg;
  const std::string_view text = peers.text();
  if (const Error error = pareto_svg(result, text, svg); !error.ok())
    return options.peers + ": " + error.text();
  return write_text(options.svg, svg);
}

}  // namespace

Error measure_pareto(const ParetoOptions& options, ParetoResult& result) {
  return Measure(options, result).run();
}

int run_pareto_suite(const ParetoOptions& options) {
  if (const Error error = run_suite(options); !error.ok()) {
    print_error("karst-bench", error.text());
    return kExitFailure;
  }
  return kExitOk;
}

}  // namespace karst::bench
