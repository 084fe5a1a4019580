// SPDX-License-Identifier: MIT
#include "bench/ground/sweep_view.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "bench/ground/tile_disks.h"
#include "platform/headless/headless_display.h"

namespace karst::bench {
namespace {

constexpr double kUp_m = 10;  // above the ground

}  // namespace

SweepView::~SweepView() {
  if (file_ >= 0) close(file_);
}

Error SweepView::open(const SyntheticGround& ground, const SceneArguments& look) {
  ground_ = &ground;
  const std::vector<std::byte> bytes = ground.file();
  file_ = memfd_create("synthetic ground", MFD_CLOEXEC);
  std::size_t done = 0;
  while (file_ >= 0 && done < bytes.size()) {
    const ssize_t wrote = write(file_, bytes.data() + done, bytes.size() - done);
    if (wrote <= 0) break;
    done += static_cast<std::size_t>(wrote);
  }
  if (file_ < 0 || done < bytes.size()) return "cannot make a file in memory";
  if (Error error = view_.load("/proc/self/fd/" + std::to_string(file_), look); !error.ok()) return error;
  Error error;
  display_ = open_headless_display({}, error);
  if (display_ == nullptr) return error;
  stage().keep_depth = true;
  if (Error attached = stage().attach(*display_, look.width, look.height); !attached.ok()) return attached;
  // The first frame waits for all that it shows: sky, and what might be in front of it.
  TimedDisk disk(ground, 1e6, 0);
  take_tiles(disk.source());
  ViewState camera;
  if (Error placed = place(0, 0, kUp_m, 0, 90, camera); !placed.ok()) return placed;
  BenchFrame frame;
  error = draw(camera, 0, frame);
  take_tiles({});
  return error;
}

void SweepView::take_tiles(const core::TileSource& source) {
  const auto root = std::make_unique<Tile>();
  ground_->make_tile(ground_->root(), *root);
  static_cast<core::WorldObject&>(stage().world()).terrain.ground.attach(ground_->info(), *root, source);
}

Error SweepView::place(double east_m, double south_m, double above_m, double yaw_deg, double pitch_deg,
                       ViewState& camera) {
  const auto index = [](double metres) {
    return static_cast<std::int64_t>(std::floor(metres / SyntheticGround::kSpacing_m));
  };
  const double unit_m = SyntheticGround::kSpacing_m / (ground_->info().steps[0] / core::kVertexStep);
  CameraPlace at;
  at.position_m = {east_m, above_m + ground_->height(index(east_m), index(south_m)) * unit_m, south_m};
  at.yaw_deg = yaw_deg;
  at.pitch_deg = pitch_deg;
  return view_.place(at, camera);
}

Error SweepView::draw(const ViewState& camera, double work_ms, BenchFrame& frame, bool ahead) {
  StageView look = view_.look();
  const double error_px = look.view.error_px;
  look.view = camera;
  look.view.error_px = error_px;
  look.work_ms = work_ms;
  look.wait = true;
  look.inspection.read_ahead = ahead;
  return view_.draw(look, frame);
}

Error SweepView::count_open(std::uint64_t& pixels) {
  if (Error error = view_.read(rgba_, depth_); !error.ok()) return error;
  pixels = static_cast<std::uint64_t>(
      std::count_if(depth_.begin(), depth_.end(), [](float depth) { return !(depth < 1); }));
  return {};
}

}  // namespace karst::bench
