// SPDX-License-Identifier: MIT
#include "app/scene.h"

#include <algorithm>
#include <cstdio>

#include "app/common/mapped_file.h"
#include "app/status_text.h"
#include "platform/clock.h"
#include "platform/headless_display.h"

namespace karst::app {
namespace {

double mebibytes(std::size_t bytes) {
  return static_cast<double>(bytes) / (1 << 20);
}

std::string format_mebibytes(std::size_t bytes) {
  char text[64];
  std::snprintf(text, sizeof text, "%.1f MiB", mebibytes(bytes));
  return text;
}

bool fits(const WorldBudget& needs, std::size_t max_memory) {
  const std::size_t cpu = needs.budget.cpu_bytes();
  return needs.config.validate().ok() && cpu <= max_memory && needs.budget.gpu_bytes() <= max_memory - cpu;
}

// Adds the time since `start` to `total` and starts anew.
void lap(std::int64_t& start, double& total) {
  const std::int64_t now = now_ns();
  total += ms_between(start, now);
  start = now;
}

}  // namespace

WorldBudget budget_of(const WorldInfo& info, int resident_level, int width, int height) {
  WorldBudget result;
  result.config = Terrain::config_for(info, resident_level);
  result.renderer.width = width;
  result.renderer.height = height;
  result.renderer.vertex_pages = result.config.gpu_vertex_pages;
  result.renderer.morph_rows = result.config.max_patches;
  result.renderer.stream_indices = result.config.stream_indices;
  result.renderer.extent = info.extent;
  result.budget = Terrain::budget(result.config);
  result.renderer.add_to(result.budget);
  return result;
}

std::string Scene::open(const SceneOptions& options) {
  if (std::string error = load(options); !error.empty()) return error;
  const std::int64_t start = now_ns();
  std::string error;
  display_ = open_headless_display({}, error);
  if (display_ == nullptr) return error;
  const double opened = ms_between(start, now_ns());
  error = attach(*display_, options.width, options.height);
  times_.context += opened;
  return error;
}

std::string Scene::load(const SceneOptions& options) {
  options_ = options;
  std::int64_t start = now_ns();
  std::string error = load_drape(options);
  if (error.empty()) error = load_world(options);
  lap(start, times_.read);
  return error;
}

std::string Scene::attach(Display& display, int width, int height) {
  times_.context = times_.generate = times_.upload = 0;
  std::int64_t start = now_ns();
  const WorldBudget needs = needs_at(terrain_.info(), resident_level_, width, height);
  budget_ = needs.budget;
  renderer_settings_ = needs.renderer;
  if (std::string error = check_memory(options_.world); !error.empty()) return error;
  if (std::string error = open_renderer(display); !error.empty()) return error;
  lap(start, times_.context);
  return upload_patches(options_.world);
}

std::string Scene::check_memory(const std::string& world) const {
  const std::size_t cpu = budget_.cpu_bytes();
  const std::size_t gpu = budget_.gpu_bytes();
  if (cpu <= options_.max_memory && gpu <= options_.max_memory - cpu) return {};
  return world + ": needs " + format_mebibytes(cpu) + " of CPU and " + format_mebibytes(gpu) +
         " of GPU memory, more than --max-memory " + format_mebibytes(options_.max_memory) + "; raise it";
}

WorldFrame Scene::frame() const {
  const WorldInfo& info = terrain_.info();
  return {{info.origin_m[0], info.origin_m[1], info.origin_m[2]}, info.voxel_size_m};
}

std::string Scene::load_drape(const SceneOptions& options) {
  if (options.drape.empty()) return {};
  MappedFile file;
  if (std::string error = file.open(options.drape); !error.empty()) return error;
  const std::string error = decode_png(file.bytes(), RendererSettings::kMaxPicture, drape_);
  return error.empty() ? error : options.drape + ": " + error;
}

WorldBudget Scene::needs_at(const WorldInfo& info, int resident_level, int width, int height) const {
  WorldBudget needs = budget_of(info, resident_level, width, height);
  needs.renderer.rgb565 = options_.rgb565;
  needs.renderer.drape_width = drape_.width;
  needs.renderer.drape_height = drape_.height;
  needs.renderer.drape_repeat = options_.drape_repeat;
  needs.budget = Terrain::budget(needs.config);
  needs.renderer.add_to(needs.budget);
  return needs;
}

std::string Scene::load_world(const SceneOptions& options) {
  MappedFile file;
  if (std::string error = file.open(options.world); !error.empty()) return error;
  WorldInfo info;
  if (const Status status = read_world_info(file.bytes(), info); !status.ok()) {
    return status_text(options.world, status);
  }
  // A world that is too large at its finest level is drawn coarser, and says so.
  const int finest = std::min(options.level, info.level);
  resident_level_ = finest;
  WorldBudget needs = needs_at(info, finest, options.width, options.height);
  while (resident_level_ > 1 && !fits(needs, options.max_memory)) {
    needs = needs_at(info, --resident_level_, options.width, options.height);
  }
  budget_ = needs.budget;
  level_cut_ = resident_level_ < finest;

  const std::size_t cpu = budget_.cpu_bytes();
  if (std::string error = check_memory(options.world); !error.empty()) return error;
  if (const Status status = needs.config.validate(); !status.ok()) return status_text(options.world, status);
  if (level_cut_) {
    std::fprintf(stderr,
                 "%s: drawn at level %d of %d, which is what --max-memory and the limit of GPU pages hold\n",
                 options.world.c_str(), resident_level_, finest);
  }
  memory_.reset(static_cast<std::byte*>(std::aligned_alloc(Arena::kAlignment, cpu)));
  if (memory_ == nullptr) return options.world + ": cannot get " + format_mebibytes(cpu) + " of memory";
  if (const Status status = terrain_.create(needs.config, {memory_.get(), cpu}); !status.ok()) {
    return status_text(options.world, status);
  }
  if (const Status status = terrain_.load(file.bytes()); !status.ok())
    return status_text(options.world, status);
  if (terrain_.patch_count() == 0) return options.world + ": the world has no surface";
  return {};
}

std::string Scene::open_renderer(Display& display) {
  GlLoader loader;
  loader.context = &display;
  loader.load = [](const void* context, const char* name) {
    return static_cast<const Display*>(context)->gl_function(name);
  };
  Gl gl;
  if (const Status status = load_gl(loader, gl); !status.ok()) return status_text(display.name(), status);
  if (const Status status = renderer_.create(gl, renderer_settings_); !status.ok()) {
    std::string error = status_text(display.name(), status);
    if (*renderer_.message() != '\0') error += std::string("; ") + renderer_.message();
    return error;
  }
  if (!drape_.rgba.empty()) {
    if (const Status status = renderer_.upload_drape(drape_.rgba); !status.ok())
      return status_text(options_.drape, status);
  }
  renderer_.upload_sky_line(terrain_.octree());
  first_page_.assign(terrain_.patch_count(), kNoPage);
  next_page_.assign(renderer_settings_.vertex_pages, kNoPage);
  texels_.resize(renderer_settings_.vertex_pages);
  morph_rows_.resize(std::size_t{terrain_.patch_count()} * kMorphRow);
  thresholds_version_ = 0;  // the renderer has none yet
  return {};
}

// Slots lie one behind the other, all of the resident level's size. Vertices are made at the world's level,
// which the boxes of patches need; those of a coarser level are the first of them (gpu_vertex.h).
std::string Scene::upload_patches(const std::string& world) {
  const Surface surface = terrain_.surface();
  const std::uint32_t slot = slot_pages(resident_level_);
  const auto resident = static_cast<std::size_t>(patch_vertices(resident_level_));
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(terrain_.info().level)));
  std::int64_t start = now_ns();
  for (PatchId patch = 0; patch < terrain_.patch_count(); ++patch) {
    terrain_.generate(patch, terrain_.info().level, vertices);
    lap(start, times_.generate);
    const Volume& volume = surface.volume_of(patch);
    first_page_[patch] = patch * slot;
    for (std::uint32_t n = 1; n < slot; ++n) next_page_[patch * slot + n - 1] = patch * slot + n;
    const Status status =
        renderer_.upload_vertices(pages(), patch, 0, std::span(vertices).first(resident),
                                  {volume.corner[0], volume.corner[1], volume.corner[2]}, patch);
    if (!status.ok()) return status_text(world, status);
    lap(start, times_.upload);
  }
  if (const Status status = terrain_.finish_bounds(); !status.ok()) return status_text(world, status);
  lap(start, times_.generate);
  return {};
}

Status Scene::upload_thresholds() {
  if (thresholds_version_ == terrain_.thresholds_version()) return {};
  for (PatchId patch = 0; patch < terrain_.patch_count(); ++patch) {
    std::uint16_t* row = morph_rows_.data() + std::size_t{patch} * kMorphRow;
    make_morph_row(terrain_.surface(), terrain_.lods(), patch,
                   std::span<std::uint16_t, kMorphRow>(row, kMorphRow));
  }
  thresholds_version_ = terrain_.thresholds_version();
  return renderer_.upload_morph_rows(0, morph_rows_);
}

}  // namespace karst::app
