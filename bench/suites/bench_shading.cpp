// SPDX-License-Identifier: MIT
// Both ways of a comparison draw every view in turns, in one process, so that a slow minute of the machine
// hits them alike. Before a frame is measured the same one is drawn unmeasured: vertices, shadow maps and
// caches are then as that way leaves them, and what is measured is a picture that goes on.
//
// Skips are switches of a view. What a renderer is made with (shadow maps, precision, textures) is compared
// by two scenes, each in a context of its own.
#include "bench/suites/bench_shading.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <utility>

#include "app/common/arguments.h"
#include "app/common/progress.h"
#include "app/files/atomic_file.h"
#include "bench/frames/bench_view.h"
#include "bench/measure/picture_error.h"
#include "platform/headless/headless_display.h"

namespace karst::bench {
using namespace app;
namespace {

constexpr std::string_view kFlights[] = {"low", "oblique", "high"};

using Picture = std::vector<std::uint8_t>;

// A world in a context of its own.
struct Place {
  std::unique_ptr<Display> display;
  std::unique_ptr<BenchView> view;

  // Loads a scene, in place of the one before.
  Error set(const std::string& world, const SceneArguments& look) {
    Error error;
    clear();
    if (display == nullptr) display = open_headless_display({}, error);
    if (display == nullptr) return error;
    view = std::make_unique<BenchView>();
    if (const Error current = display->make_current(); !current.ok()) return current.text();
    if (error = view->load(world, look); !error.ok()) return error;
    return view->stage().attach(*display, look.width, look.height);
  }
  // The renderer goes while its context is current.
  void clear() {
    if (view == nullptr) return;
    if (display->make_current().ok()) view->stage().detach();
    view.reset();
  }
};

// One way to draw: a scene, and the switches of its views.
struct Way {
  Place* place = nullptr;
  Inspection switches;
};

class Suite {
 public:
  explicit Suite(const ShadingSuiteOptions& options) : options_(options) {}
  Suite(const Suite&) = delete;
  Suite& operator=(const Suite&) = delete;
  // Closing either display may take the other's context along.
  ~Suite() {
    for (Place* place : {&main_, &other_}) place->clear();
  }

  Error run(ShadingReport& report) {
    if (Error error = main_.set(options_.world, look()); !error.ok()) return error;
    if (Error error = place_cameras(); !error.ok()) return error;
    report.width = options_.look.width;
    report.height = options_.look.height;
    report.views = static_cast<int>(cameras_.size());
    report.rounds = options_.rounds;
    report.renderer = device_info(main_.view->stage().renderer()).renderer;
    if (Error error = compare_skips(report); !error.ok()) return error;
    return compare_features(report);
  }

 private:
  SceneArguments look() const {
    SceneArguments look = options_.look;
    if (look.vertex_bytes == 0) look.vertex_bytes = std::numeric_limits<std::uint64_t>::max();
    return look;
  }

  Error place_cameras() {
    const GroundHeights& ground = main_.view->ground();
    for (const std::string_view flight : kFlights) {
      const auto path = make_standard_path(flight, ground, main_.view->terrain().box(), options_.frames);
      std::vector<ViewState> cameras;
      if (Error error = main_.view->place(path, cameras); !error.ok()) return error;
      cameras_.insert(cameras_.end(), cameras.begin(), cameras.end());
    }
    return {};
  }

  // One view one way: the times of the second frame. picture: may be null.
  Error measure(const Way& way, const ViewState& camera, ShadingTime& time, Picture* picture) {
    StageView view = way.place->view->look();
    const Inspection& levels = view.inspection;
    Inspection switches = way.switches;
    switches.lod = levels.lod;
    switches.distance_voxels = levels.distance_voxels;
    switches.show = levels.show;
    view.inspection = switches;
    view.view = camera;
    BenchFrame frame;
    Error error = way.place->display->make_current();
    for (int k = 0; k < 2 && error.ok(); ++k) error = way.place->view->draw(view, frame);
    if (!error.ok()) return error;
    time = {frame.record.frame_ms, frame.all_cpu_ms};
    if (picture == nullptr) return {};
    picture->resize(static_cast<std::size_t>(options_.look.width) *
                    static_cast<std::size_t>(options_.look.height) * 4);
    const Status status = way.place->view->stage().target().read_colour(*picture);
    return Error("picture", status);
  }

  // Views first..first + count, both ways. Pictures are compared in the first round.
  Error draw_round(const Way& on, const Way& off, std::size_t first, std::size_t count,
                   ShadingComparison& row) {
    const bool is_first = row.on_rounds.empty();
    ShadingTime& on_sum = row.on_rounds.emplace_back();
    ShadingTime& off_sum = row.off_rounds.emplace_back();
    const double share = 1 / static_cast<double>(count);
    Picture pictures[2];
    for (std::size_t k = first; k < first + count; ++k) {
      ShadingTime on_time, off_time;
      Error error = measure(on, cameras_[k], on_time, is_first ? &pictures[0] : nullptr);
      if (error.ok()) error = measure(off, cameras_[k], off_time, is_first ? &pictures[1] : nullptr);
      if (!error.ok()) return error;
      on_sum.add(on_time, share);
      off_sum.add(off_time, share);
      if (!is_first) continue;
      for (std::size_t i = 0; i < pictures[0].size(); ++i) {
        const int difference = std::abs(int{pictures[0][i]} - int{pictures[1][i]});
        row.most_difference = std::max(row.most_difference, difference);
      }
      row.mean_difference += mean_colour_difference(pictures[0], pictures[1]) * share;
    }
    return {};
  }

  static void finish(ShadingComparison& row) {
    for (double ShadingTime::*part : {&ShadingTime::frame_ms, &ShadingTime::cpu_ms}) {
      std::vector<double> on, off, ratios;
      for (std::size_t k = 0; k < row.on_rounds.size(); ++k) {
        on.push_back(row.on_rounds[k].*part);
        off.push_back(row.off_rounds[k].*part);
        ratios.push_back(on.back() / off.back());
      }
      row.on_time.*part = median(on);
      row.off_time.*part = median(off);
      row.ratio.*part = median(ratios);
    }
  }

  Error compare_skips(ShadingReport& report) {
    std::vector<Way> off;
    Inspection none;
    for (int n = 0; n < kSkipCount; ++n) {
      const auto skip = static_cast<SkipChoice>(n);
      off.push_back({&main_, {}});
      skip_of(off.back().switches, skip) = false;
      skip_of(none, skip) = false;
      report.skips.push_back(row_of(kSkipNames[n], "skipped", "drawn"));
    }
    const std::size_t alone = off.size();
    off.push_back({&main_, none});
    report.skips.push_back(row_of("all", "skipped", "drawn"));
    for (const std::string_view flight : kFlights)
      report.flights.push_back(row_of("all, " + std::string(flight), "skipped", "drawn"));

    const Way on{&main_, {}};
    const auto rounds = static_cast<std::size_t>(options_.rounds);
    const auto frames = static_cast<std::size_t>(options_.frames);
    Progress progress("skips", rounds * off.size());
    for (std::size_t round = 0; round < rounds; ++round) {
      Error error;
      for (std::size_t k = 0; k < alone && error.ok(); ++k) {
        error = draw_round(on, off[k], 0, cameras_.size(), report.skips[k]);
        progress.update(round * off.size() + k + 1);
      }
      for (std::size_t k = 0; k < report.flights.size() && error.ok(); ++k)
        error = draw_round(on, off[alone], k * frames, frames, report.flights[k]);
      if (!error.ok()) return error;
    }
    join(report.flights, report.skips[alone]);
    for (ShadingComparison& row : report.skips) finish(row);
    for (ShadingComparison& row : report.flights) finish(row);
    return {};
  }

  static ShadingComparison row_of(std::string name, std::string on, std::string off) {
    ShadingComparison row;
    row.name = std::move(name);
    row.on = std::move(on);
    row.off = std::move(off);
    return row;
  }

  // Flights of as many views make up the whole.
  static void join(const std::vector<ShadingComparison>& flights, ShadingComparison& whole) {
    const double share = 1 / static_cast<double>(flights.size());
    whole.on_rounds.resize(flights[0].on_rounds.size());
    whole.off_rounds.resize(whole.on_rounds.size());
    for (const ShadingComparison& flight : flights) {
      for (std::size_t k = 0; k < whole.on_rounds.size(); ++k) {
        whole.on_rounds[k].add(flight.on_rounds[k], share);
        whole.off_rounds[k].add(flight.off_rounds[k], share);
      }
      whole.most_difference = std::max(whole.most_difference, flight.most_difference);
      whole.mean_difference += flight.mean_difference * share;
    }
  }

  // What the main scene has, against a scene without it.
  Error compare_feature(const char* name, const std::string& on, const std::string& off,
                        const std::string& world, const SceneArguments& without, ShadingReport& report) {
    if (Error error = other_.set(world, without); !error.ok()) return error;
    return compare_ways(row_of(name, on, off), {&other_, {}}, report);
  }

  Error compare_lamps(ShadingReport& report) {
    const std::size_t count = main_.view->terrain().lights().size();
    if (count == 0) return {};
    Way off{&main_, {}};
    off.switches.lamps = false;
    return compare_ways(row_of("lamps", std::to_string(count), "none"), off, report);
  }

  Error compare_ways(ShadingComparison row, const Way& off, ShadingReport& report) {
    Progress progress(row.name, static_cast<std::uint64_t>(options_.rounds));
    for (int round = 0; round < options_.rounds; ++round) {
      if (Error error = draw_round({&main_, {}}, off, 0, cameras_.size(), row); !error.ok()) return error;
      progress.update(static_cast<std::uint64_t>(round) + 1);
    }
    finish(row);
    report.features.push_back(std::move(row));
    return {};
  }

  Error compare_features(ShadingReport& report) {
    Error error;
    if (options_.look.shadows > 0) {
      SceneArguments without = look();
      without.shadows = 0;
      const std::string maps =
          std::to_string(options_.look.shadows) + " of " + std::to_string(options_.look.shadow_size);
      error = compare_feature("shadows", maps, "none", options_.world, without, report);
    }
    if (error.ok()) {
      SceneArguments medium = look();
      medium.precision = PrecisionChoice::medium;
      error = compare_feature("precision", "as asked", "medium", options_.world, medium, report);
    }
    if (error.ok()) error = compare_lamps(report);
    if (!error.ok() || options_.against.empty()) return error;
    if (error = check_world(report.textures); !error.ok()) return error;
    return compare_feature("textures", report.textures.on, report.textures.off, options_.against, look(),
                           report);
  }

  // Before it is drawn: whether it is the same world, and how its textures differ.
  Error check_world(TextureComparison& textures) const {
    BenchView other;
    if (Error error = other.load(options_.against, look()); !error.ok()) return error;
    const core::World& a = main_.view->terrain();
    const core::World& b = other.terrain();
    if (a.info().extent != b.info().extent || a.patch_count() != b.patch_count())
      return options_.against + ": is not " + options_.world + " baked another way";
    const Error error = compare_textures(a, b, textures);
    return error.ok() ? error : options_.against + ": " + error.text();
  }

  const ShadingSuiteOptions& options_;
  Place main_, other_;
  std::vector<ViewState> cameras_;
};

Error run_suite(const ShadingSuiteOptions& options) {
  ShadingReport report;
  if (Error error = Suite(options).run(report); !error.ok()) return error;
  const std::string text = shading_json(report);
  if (options.json == "-") {
    std::fputs(text.c_str(), stdout);
    return {};
  }
  print_shading(report);
  return options.json.empty() ? Error() : write_file_atomic(options.json, std::as_bytes(std::span(text)));
}

}  // namespace

int run_shading_suite(const ShadingSuiteOptions& options) {
  if (const Error error = run_suite(options); !error.ok()) {
    print_error("karst-bench", error.text());
    return kExitFailure;
  }
  return kExitOk;
}

}  // namespace karst::bench
