// SPDX-License-Identifier: MIT
// Each frame is drawn twice, one after the other, so that a slow minute of the machine hits both alike: as it
// is, then with all maps drawn anew. The GPU's work is waited for before and after the maps.
#include "bench/suites/bench_shadows.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "app/common/arguments.h"
#include "bench/frames/bench_view.h"

namespace karst::bench {
using namespace app;
namespace {

struct Costs {
  std::vector<double> ms;
  std::uint64_t triangles = 0;
  int maps = 0;

  void add(const FrameRecord& record, int count) {
    ms.push_back(record.costs.shadow_ms);
    triangles += record.costs.shadow_triangles;
    maps += count - static_cast<int>(record.costs.cascades_skipped);
  }
  double mean_ms() const {
    double sum = 0;
    for (const double v : ms) sum += v;
    return sum / static_cast<double>(ms.size());
  }
};

// The flight's first place, from which it looks around once.
std::vector<CameraSettings> turn(CameraSettings from, int frames) {
  std::vector<CameraSettings> path;
  for (int n = 0; n < frames; ++n) {
    from.yaw_deg = 360.0 * n / frames - 180.0;
    path.push_back(from);
  }
  return path;
}

Error fly(BenchView& view, const char* name, const std::vector<CameraSettings>& path, int maps) {
  std::vector<ViewState> cameras;
  if (Error error = view.place(path, cameras); !error.ok()) return error;
  StageView shown = view.look();
  shown.inspection.wait_for_gpu = true;
  Costs kept, all;
  BenchFrame frame;
  bool first = true;
  for (const ViewState& camera : cameras) {
    shown.view = camera;
    shown.inspection.skip_cascades = true;
    if (Error error = view.draw(shown, frame); !error.ok()) return error;
    // The first frame draws its maps whatever the way they are kept.
    if (!first) kept.add(frame.record, maps);
    shown.inspection.skip_cascades = false;
    if (Error error = view.draw(shown, frame); !error.ok()) return error;
    if (!first) all.add(frame.record, maps);
    first = false;
  }
  const auto frames = static_cast<double>(kept.ms.size());
  std::printf("%-9s %5.2f of %d  %9.0f of %9.0f  %7.3f of %7.3f  %6.1f %%  %7.3f of %7.3f  %6.1f %%\n", name,
              kept.maps / frames, maps, static_cast<double>(kept.triangles) / frames,
              static_cast<double>(all.triangles) / frames, median(kept.ms), median(all.ms),
              100 * median(kept.ms) / median(all.ms), kept.mean_ms(), all.mean_ms(),
              100 * kept.mean_ms() / all.mean_ms());
  return {};
}

Error measure(const ShadowSuiteOptions& options) {
  BenchView view;
  if (Error error = view.open(options.world, options.look); !error.ok()) return error;
  const GroundHeights& ground = view.ground();
  const core::LatticeBox box = view.terrain().box();
  const int maps = options.look.shadows;
  std::printf("a frame    maps drawn  triangles in maps          ms, median             ms, mean\n");
  for (const std::string_view name : {"oblique", "low"}) {
    const std::vector<CameraSettings> path = make_standard_path(name, ground, box, 8);
    const std::string label = "turn " + std::string(name.substr(0, 3));
    if (Error error = fly(view, label.c_str(), turn(path[0], options.frames), maps); !error.ok())
      return error;
  }
  for (const std::string_view name : kStandardPaths) {
    const std::vector<CameraSettings> path = make_standard_path(name, ground, box, options.frames);
    if (Error error = fly(view, std::string(name).c_str(), path, maps); !error.ok()) return error;
  }
  return {};
}

}  // namespace

int run_shadow_suite(const ShadowSuiteOptions& options) {
  const Error error = measure(options);
  if (error.ok()) return kExitOk;
  print_error("karst-bench", error.text());
  return kExitFailure;
}

}  // namespace karst::bench
