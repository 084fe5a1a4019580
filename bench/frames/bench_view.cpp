// SPDX-License-Identifier: MIT
#include "bench/frames/bench_view.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <optional>

#include "app/stage/camera_ground.h"
#include "bench/measure/bench_clock.h"
#include "bench/measure/gl_times.h"
#include "platform/headless/headless_display.h"
#include "terrain/resident/page_table.h"

namespace karst::bench {
using namespace app;
namespace {

// Heights of a ground that are asked for, along its longer side.
constexpr int kAskedAcross = 512;
// Flights keep away from the ground.
constexpr double kFree = std::numeric_limits<double>::infinity();

// Since this process was started; 0 where the system does not tell.
double process_age_ms() {
  char text[1024];
  std::FILE* file = std::fopen("/proc/self/stat", "r");
  if (file == nullptr) return 0;
  const std::size_t length = std::fread(text, 1, sizeof text - 1, file);
  std::fclose(file);
  text[length] = '\0';
  // Field 22, counted from behind the program's name, which may hold blanks and brackets.
  const char* field = std::strrchr(text, ')');
  for (int n = 2; field != nullptr && n < 22; ++n) field = std::strchr(field + 1, ' ');
  if (field == nullptr) return 0;
  unsigned long long ticks = 0;
  if (std::sscanf(field, "%llu", &ticks) != 1) return 0;
  const double start_ms = static_cast<double>(ticks) * 1e3 / static_cast<double>(sysconf(_SC_CLK_TCK));
  return clock_ms(CLOCK_BOOTTIME) - start_ms;
}

std::uint64_t working_set(const FrameCosts& costs, const PictureSettings& settings) {
  std::uint64_t bytes = costs.triangles * 3 * sizeof(std::uint32_t);
  for (int level = 1; level <= core::kMaxLevel; ++level) {
    bytes += std::uint64_t{costs.at_level[level]} * core::slot_pages(level) * core::kPageVertices *
             sizeof(core::GpuVertex);
  }
  return bytes + static_cast<std::uint64_t>(settings.width) * static_cast<std::uint64_t>(settings.height) * 8;
}

}  // namespace

std::uint64_t resident_bytes() {
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr) return 0;
  unsigned long long pages = 0;
  const bool read = std::fscanf(file, "%*u %llu", &pages) == 1;
  std::fclose(file);
  return read ? pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

std::uint64_t peak_resident_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) << 10;
}

Error BenchView::open(const std::string& world, const SceneArguments& look, bool keep_depth) {
  if (Error error = load(world, look); !error.ok()) return error;
  Error error;
  display_ = open_headless_display({}, error);
  if (display_ == nullptr) return error;
  stage_.keep_depth = keep_depth;
  return stage_.attach(*display_, look.width, look.height);
}

Error BenchView::open_timed(const std::string& world, const SceneArguments& look, bool time_gl) {
  if (!time_gl) return open(world, look);
  if (Error error = load(world, look); !error.ok()) return error;
  Error error;
  display_ = open_headless_display({}, error);
  if (display_ == nullptr) return error;
  timed_ = std::make_unique<TimedDisplay>(*display_);
  return stage_.attach(*timed_, look.width, look.height);
}

Error BenchView::load(const std::string& world, const SceneArguments& look) {
  if (Error error = stage_.load(world, look, {.queries = 1}); !error.ok()) return error;
  look_ = stage_view(look, stage_.world().info());
  look_.work_ms = 0;
  shape_ = {look.width, look.height, look.fov_y_deg, 0};
  return {};
}

const core::World& BenchView::terrain() const {
  return static_cast<const core::WorldObject&>(stage_.world()).terrain.world;
}

const PlacementFrame& BenchView::placement() const {
  return static_cast<const core::WorldObject&>(stage_.world()).placement;
}

LevelChoice BenchView::levels() const {
  return {look_.inspection.lod, look_.view.error_px, look_.inspection.distance_voxels};
}

Error BenchView::draw(const ViewState& camera, const LevelChoice& levels, BenchFrame& frame, double work_ms) {
  StageView view = look_;
  view.view = camera;
  view.view.error_px = levels.error_px;
  view.inspection.lod = levels.mode;
  view.inspection.distance_voxels = levels.distance_voxels;
  view.work_ms = work_ms;
  return draw(view, frame);
}

Error BenchView::draw(const StageView& view, BenchFrame& frame) {
  frame = {};
  const double main_start = clock_ms(CLOCK_THREAD_CPUTIME_ID);
  const double all_start = clock_ms(CLOCK_PROCESS_CPUTIME_ID);
  if (Error error = stage_.draw(view, frame.record); !error.ok()) return error;
  frame.main_cpu_ms = clock_ms(CLOCK_THREAD_CPUTIME_ID) - main_start;
  frame.all_cpu_ms = clock_ms(CLOCK_PROCESS_CPUTIME_ID) - all_start;
  frame.working_set_bytes = working_set(frame.record.costs, stage_.target().settings());
  if (first_frame_ms_ == 0) first_frame_ms_ = process_age_ms();
  return {};
}

Error BenchView::read(std::vector<std::uint8_t>& rgba, std::vector<float>& depth) {
  const PictureSettings& settings = stage_.target().settings();
  depth.resize(static_cast<std::size_t>(settings.width) * static_cast<std::size_t>(settings.height));
  rgba.resize(depth.size() * 4);
  Status status = stage_.target().read_colour(rgba);
  if (status.ok()) status = stage_.target().read_depth(depth);
  return Error("picture", status);
}

const GroundHeights& BenchView::ground() {
  if (ground_) return *ground_;
  const core::World& world = terrain();
  const glm::ivec3 extent = glm::max(world.info().extent, world.box().max / core::kStepsPerVoxel);
  GroundHeights& ground = ground_.emplace(glm::ivec2(extent.x, extent.z));
  for (const core::WorldPart& part : world.parts()) {
    for (core::PatchId patch = 0; patch < part.patches(); ++patch) {
      core::LatticeBox box = core::patch_box(part.surface, part.bounds, patch);
      box.min += part.corner * core::kStepsPerVoxel;
      box.max += part.corner * core::kStepsPerVoxel;
      ground.add(box);
    }
  }
  // load() has asked for the query, so that there is one.
  CameraGround heights;
  if (stage_.world().info().ground_samples[0] == 0 || !heights.open(stage_.world()).ok()) return ground;
  // The corners of squares, each on the squares around it.
  const int side = std::max({1, (extent.x - 1) / kAskedAcross + 1, (extent.z - 1) / kAskedAcross + 1});
  const core::WorldFrame& frame = placement().world();
  for (int z = 0; z <= extent.z; z += side) {
    for (int x = 0; x <= extent.x; x += side) {
      glm::dvec3 above = frame.origin_m + glm::dvec3(x, 0, z) * frame.voxel_size_m;
      above.y = stage_.world().info().high_m.y + frame.voxel_size_m;
      const std::optional<double> height_m = heights.below_m(above, 0);
      if (!height_m) continue;
      const double height = (*height_m - frame.origin_m.y) / frame.voxel_size_m;
      const glm::ivec3 low(std::max(x - side, 0), 0, std::max(z - side, 0));
      const glm::ivec3 high(std::min(x + side, extent.x) - 1, 0, std::min(z + side, extent.z) - 1);
      core::LatticeBox box{low * core::kStepsPerVoxel, high * core::kStepsPerVoxel};
      box.max.y = static_cast<int>(std::ceil(height * core::kStepsPerVoxel));
      ground.add(box);
    }
  }
  return ground;
}

CameraPlace BenchView::place_of(const CameraSettings& settings) const {
  const core::WorldFrame& frame = placement().world();
  CameraPlace at;
  at.position_m = frame.origin_m + settings.position * frame.voxel_size_m;
  at.yaw_deg = settings.yaw_deg;
  at.pitch_deg = settings.pitch_deg;
  return at;
}

std::vector<CameraPlace> BenchView::flight(std::string_view name, int frames) {
  std::vector<CameraPlace> places;
  if (name == "default") {
    places.assign(static_cast<std::size_t>(frames), overview(stage_.world().info(), shape_.fov_y_deg));
    return places;
  }
  for (const CameraSettings& settings : make_standard_path(name, ground(), terrain().box(), frames)) {
    places.push_back(place_of(settings));
  }
  return places;
}

Error BenchView::place(const CameraPlace& place, ViewState& camera) {
  camera = look_.view;
  const Status status =
      place_view(place, stage_.world().info(),
                 stage_.world().axes_at({place.position_m.x, place.position_m.y, place.position_m.z}), shape_,
                 kFree, camera);
  return Error("camera", status);
}

Error BenchView::place(std::span<const CameraSettings> path, std::vector<ViewState>& cameras) {
  cameras.clear();
  for (const CameraSettings& settings : path) {
    if (Error error = place(place_of(settings), cameras.emplace_back()); !error.ok()) return error;
  }
  return {};
}

}  // namespace karst::bench
