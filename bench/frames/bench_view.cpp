// SPDX-License-Identifier: MIT
#include "bench/frames/bench_view.h"

#include <ctime>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "app/common/camera_path.h"
#include "app/common/status_text.h"
#include "app/options/scene_settings.h"

namespace karst::bench {
using namespace app;
namespace {

double clock_ms(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

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

std::uint64_t working_set(const ViewState::Selection& selection, const FrameCounts& counts,
                          const PictureSettings& settings) {
  std::uint64_t bytes = counts.triangles * 3 * sizeof(std::uint32_t);
  for (int level = 1; level <= kMaxLevel; ++level) {
    bytes +=
        std::uint64_t{selection.list.at_level[level]} * slot_pages(level) * kPageVertices * sizeof(GpuVertex);
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

std::string BenchView::open(const SceneOptions& options, const SceneArguments& look) {
  if (std::string error = scene_.open(options); !error.empty()) return error;
  set_look(look);
  return {};
}

std::string BenchView::load(const SceneOptions& options, const SceneArguments& look) {
  if (std::string error = scene_.load(options); !error.empty()) return error;
  set_look(look);
  return {};
}

void BenchView::set_look(const SceneArguments& look) {
  look_ = view_settings(look);
  set_haze(look, scene_.world().box(), look_.light);
  fov_y_deg_ = look.fov_y_deg;
}

std::string BenchView::draw(const Camera& camera, const LodSettings& lod, BenchFrame& frame,
                            double generate_ms) {
  SceneView view = look_;
  view.camera = camera;
  view.lod = lod;
  view.generate_ms = generate_ms;
  return draw(view, frame);
}

std::string BenchView::draw(SceneView view, BenchFrame& frame) {
  frame = {};
  const double main_start = clock_ms(CLOCK_THREAD_CPUTIME_ID);
  const double all_start = clock_ms(CLOCK_PROCESS_CPUTIME_ID);
  if (std::string error = scene_.draw(view, frame.record); !error.empty()) return error;
  frame.main_cpu_ms = clock_ms(CLOCK_THREAD_CPUTIME_ID) - main_start;
  frame.all_cpu_ms = clock_ms(CLOCK_PROCESS_CPUTIME_ID) - all_start;
  frame.working_set_bytes =
      working_set(frame.record.selection, frame.record.counts, scene_.target().settings());
  if (first_frame_ms_ == 0) first_frame_ms_ = process_age_ms();
  return {};
}

std::string BenchView::read(std::vector<std::uint8_t>& rgba, std::vector<float>& depth) {
  const PictureSettings& settings = scene_.target().settings();
  depth.resize(static_cast<std::size_t>(settings.width) * static_cast<std::size_t>(settings.height));
  rgba.resize(depth.size() * 4);
  Status status = scene_.target().read_colour(rgba);
  if (status.ok()) status = scene_.target().read_depth(depth);
  return status.ok() ? std::string() : status_text("picture", status);
}

GroundHeights BenchView::ground() {
  const World& world = scene_.world();
  GroundHeights ground({world.info().extent.x, world.info().extent.z});
  const Surface surface = world.surface();
  for (PatchId patch = 0; patch < world.patch_count(); ++patch) {
    ground.add(patch_box(surface, world.bounds(), patch));
  }
  return ground;
}

std::string BenchView::place(std::span<const CameraSettings> path, std::vector<Camera>& cameras) {
  const WorldFrame frame = scene_.frame();
  const PictureSettings& settings = scene_.target().settings();
  const double aspect = static_cast<double>(settings.width) / settings.height;
  cameras.clear();
  for (const CameraSettings& settings_of_frame : path) {
    CameraPlace place;
    place.position_m = frame.origin_m + settings_of_frame.position * frame.voxel_size_m;
    place.yaw_deg = settings_of_frame.yaw_deg;
    place.pitch_deg = settings_of_frame.pitch_deg;
    const Status status =
        place_camera(place, frame, scene_.world().box(), fov_y_deg_, aspect, cameras.emplace_back());
    if (!status.ok()) return status_text("camera", status);
  }
  return {};
}

}  // namespace karst::bench
