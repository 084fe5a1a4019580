// SPDX-License-Identifier: MIT
#include "scene/scene.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "app/common/mapped_file.h"
#include "app/common/status_text.h"
#include "platform/base/clock.h"
#include "platform/headless/headless_display.h"
#include "scene/resource_counts.h"

namespace karst::app {
using namespace core;
namespace {

std::string format_mebibytes(std::size_t bytes) {
  char text[64];
  std::snprintf(text, sizeof text, "%.1f MiB", static_cast<double>(bytes) / (1 << 20));
  return text;
}

// Adds the time since `start` to `total` and starts anew.
void lap(std::int64_t& start, double& total) {
  const std::int64_t now = now_ns();
  total += ms_between(start, now);
  start = now;
}

}  // namespace

void fit_heights(WorldBudget& needs, std::uint64_t max_memory) {
  const auto total = [&] { return std::uint64_t{needs.budget.cpu_bytes()} + needs.budget.gpu_bytes(); };
  if (total() <= max_memory) return;
  const std::uint64_t over = total() - max_memory;
  const std::uint64_t group =
      std::uint64_t{kHeightGroup} * sizeof(std::int16_t) *
      static_cast<std::uint64_t>(patch_vertices(static_cast<int>(needs.config.max_level)));
  const std::uint64_t groups = height_groups(needs.config.max_height_blocks);
  const std::uint64_t fewer = std::min(groups, over / group + 1);
  const std::uint64_t held = std::max<std::uint64_t>(groups - fewer, HeightCache::kLeastGroups);
  if (held >= groups) return;
  needs.config.max_height_blocks = static_cast<std::uint32_t>(held * kHeightGroup);
  needs.add_up();
}

void WorldBudget::add_up() {
  budget = terrain_budget(config);
  renderer.add_to(budget);
  budget.add(GpuConsumer::targets, picture.bytes());
}

WorldBudget budget_of(const WorldInfo& info, int finest, int width, int height, std::uint64_t vertex_bytes) {
  WorldBudget result;
  result.config = World::config_for(info, finest);
  if (vertex_bytes > 0) {
    const std::uint64_t pages =
        std::max<std::uint64_t>(vertex_bytes / (kPageVertices * sizeof(GpuVertex)), 1);
    Config& config = result.config;
    const std::uint64_t all = std::uint64_t{config.max_patches} * slot_pages(finest);
    config.gpu_vertex_pages = static_cast<std::uint32_t>(std::min<std::uint64_t>({pages, all, kMostPages}));
    config.max_draw_items = std::min(config.max_draw_items, config.gpu_vertex_pages);
    config.max_resident_patches = config.max_draw_items;
  }
  result.picture.width = width;
  result.picture.height = height;
  result.renderer.vertex_pages = result.config.gpu_vertex_pages;
  result.renderer.morph_rows = result.config.max_views * result.config.max_resident_patches;
  result.renderer.stream_indices = result.config.stream_indices;
  result.renderer.extent = info.extent;
  result.renderer.cascades = CascadeSettings().count;
  result.add_up();
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
  drape_.rgba = {};  // on the GPU now, and not to be attached again
  times_.context += opened;
  return error;
}

std::string Scene::load(const SceneOptions& options) {
  options_ = options;
  std::int64_t start = now_ns();
  std::string error = load_drape();
  if (error.empty()) error = load_world();
  lap(start, times_.read);
  return error;
}

std::string Scene::load_world() {
  if (std::string error = file_.open(options_.world); !error.empty()) return error;
  WorldReader reader;
  if (const Status status = reader.open(file_.source()); !status.ok())
    return status_text(options_.world, status);
  const WorldInfo& info = reader.info();
  const int finest = std::min(options_.level, info.level);
  WorldBudget needs = budget_of(info, finest, options_.width, options_.height, options_.vertex_bytes);
  needs.renderer = renderer_settings(needs.config, reader.materials());
  needs.renderer.extent = info.extent;
  needs.picture = picture_settings();
  needs.add_up();
  std::uint64_t max_memory = options_.max_memory;
  if (options_.max_cpu > 0) max_memory = std::min(max_memory, options_.max_cpu + needs.budget.gpu_bytes());
  fit_heights(needs, max_memory);
  budget_ = needs.budget;
  if (std::string error = check_memory(); !error.empty()) return error;
  if (const Status status = needs.config.validate(); !status.ok()) return status_text(options_.world, status);

  const std::size_t cpu = budget_.cpu_bytes();
  memory_.reset(static_cast<std::byte*>(std::aligned_alloc(Arena::kAlignment, cpu)));
  if (memory_ == nullptr) return options_.world + ": cannot get " + format_mebibytes(cpu) + " of memory";
  if (const Status status = parts_.create(needs.config, {memory_.get(), cpu}); !status.ok()) {
    return status_text(options_.world, status);
  }
  if (const Status status = parts_.load(file_.source()); !status.ok())
    return status_text(options_.world, status);
  if (world().patch_count() == 0) return options_.world + ": the world has no surface";
  return {};
}

std::string Scene::load_drape() {
  if (options_.drape.empty()) return {};
  MappedFile file;
  if (std::string error = file.open(options_.drape); !error.empty()) return error;
  const std::string error = decode_png(file.bytes(), PictureSettings::kMaxPicture, drape_);
  return error.empty() ? error : options_.drape + ": " + error;
}

RendererSettings Scene::renderer_settings(const Config& config, const MaterialSet& materials) const {
  RendererSettings settings;
  settings.vertex_pages = config.gpu_vertex_pages;
  settings.morph_rows = config.max_views * config.max_resident_patches;
  settings.stream_indices = config.stream_indices;
  settings.extent = world().info().extent;
  settings.cascades = drape_.rgba.empty() ? options_.shadows.count : 0;
  settings.shadow_size = options_.shadows.size;
  settings.material_count = options_.drape.empty() ? materials.count : 0;
  settings.material_side = materials.side;
  settings.material_format = materials.format;
  settings.high_precision = options_.high_precision;
  settings.show = options_.show;
  settings.timers = true;
  settings.drape_width = drape_.width;
  settings.drape_height = drape_.height;
  settings.drape_repeat = options_.drape_repeat;
  return settings;
}

PictureSettings Scene::picture_settings() const {
  return {.width = options_.width,
          .height = options_.height,
          .rgb565 = options_.rgb565,
          .keep_depth = options_.keep_depth};
}

std::string Scene::check_memory() const {
  const std::size_t cpu = budget_.cpu_bytes();
  const std::size_t gpu = budget_.gpu_bytes();
  if (cpu <= options_.max_memory && gpu <= options_.max_memory - cpu) return {};
  return options_.world + ": needs " + format_mebibytes(cpu) + " of CPU and " + format_mebibytes(gpu) +
         " of GPU memory, more than --max-memory " + format_mebibytes(options_.max_memory) + "; raise it";
}

std::string Scene::attach(Display& display, int width, int height) {
  times_.context = times_.generate = times_.upload = 0;
  std::int64_t start = now_ns();
  options_.width = width;
  options_.height = height;
  std::string error = open_renderer(display);
  lap(start, times_.context);
  return error;
}

std::string Scene::open_renderer(Display& display) {
  const Config& config = world().config();
  const RendererSettings settings = renderer_settings(config, world().materials());
  budget_ = terrain_budget(config);
  settings.add_to(budget_);
  const PictureSettings picture = picture_settings();
  budget_.add(GpuConsumer::targets, picture.bytes());
  if (std::string error = check_memory(); !error.empty()) return error;

  GlLoader loader;
  loader.user = &display;
  loader.load = [](void* user, const char* name) { return static_cast<Display*>(user)->gl_function(name); };
  if (const Status status = target_.create(loader, picture); !status.ok())
    return status_text(display.name(), status);
  Gl gl;
  if (const Status status = load_gl(loader, false, gl); !status.ok())
    return status_text(display.name(), status);
  count_gl_objects(gl);
  if (const Status status = renderer_.create(gl, settings); !status.ok()) {
    std::string error = status_text(display.name(), status);
    if (*renderer_.message() != '\0') error += std::string("; ") + renderer_.message();
    return error;
  }
  if (!drape_.rgba.empty()) {
    if (const Status status = renderer_.upload_drape(drape_.rgba); !status.ok())
      return status_text(options_.drape, status);
  }
  if (std::string error = upload_materials(); !error.empty()) return error;
  renderer_.upload_sky_line(world().octree());
  residency().forget();
  first_frame_ = true;
  gl_objects_at_start_ = gl_objects_made();
  for (ShadowMap& map : shadow_maps_) map.drawn = false;
  return {};
}

// A level of an array at a time: the finest take most of the room.
std::string Scene::upload_materials() {
  const MaterialSet& set = world().materials();
  if (!options_.drape.empty() || set.count == 0) return {};
  std::vector<std::byte> bytes(texture_image_bytes(set.format, set.side, 0) * set.count);
  Status status = renderer_.set_materials(set);
  for (const TextureArray array : {TextureArray::albedo_height, TextureArray::normal_roughness}) {
    for (int level = 0; status.ok() && level < texture_levels(set.side); ++level) {
      const auto out = std::span(bytes).first(texture_image_bytes(set.format, set.side, level) * set.count);
      status = world().read_textures(array, level, 0, set.count, out);
      if (status.ok()) status = renderer_.upload_textures(array, level, 0, static_cast<int>(set.count), out);
    }
  }
  return status.ok() ? std::string() : status_text(options_.world, status);
}

WorldFrame Scene::frame() const {
  const WorldInfo& info = world().info();
  return {{info.origin_m[0], info.origin_m[1], info.origin_m[2]}, info.voxel_size_m};
}

std::string Scene::draw(const SceneView& view, FrameRecord& record) {
  const std::int64_t start = now_ns();
  ViewRequest terrain_view;
  terrain_view.camera = &view.camera;
  terrain_view.lod = view.lod;
  terrain_view.lod.max_level = std::min(view.lod.max_level, options_.level);
  terrain_view.lod.resident_level = terrain_view.lod.max_level;
  terrain_view.width_px = (view.quarter_turns & 1) != 0 ? options_.height : options_.width;
  terrain_view.height_px = (view.quarter_turns & 1) != 0 ? options_.width : options_.height;
  terrain_view.frustum_culling = view.frustum_culling;
  terrain_view.backface_culling = view.backface_culling;
  terrain_view.occlusion_culling = view.occlusion_culling;
  residency().begin_frame();
  Status status = residency().set_shading_skips(view.shading_skips);
  if (status.ok()) status = select(terrain_view, record);
  const bool is_complete = first_frame_ || view.generate_ms == SceneView::kComplete;
  if (status.ok() && is_complete) status = complete(terrain_view, record);
  if (first_frame_) {
    times_.generate = record.generate_ms;
    times_.upload = record.upload_ms;
    first_frame_ = false;
  }
  if (view.wait_for_shadows) renderer_.finish();
  const std::int64_t shadows = now_ns();
  if (status.ok()) status = draw_shadows(view, is_complete ? SceneView::kComplete : view.generate_ms, record);
  if (view.wait_for_shadows) renderer_.finish();
  record.shadow_ms = ms_between(shadows, now_ns());
  if (status.ok()) status = draw_selected(view, record);
  // What the next frames need is made while the GPU draws this one.
  bool made = false;
  if (status.ok() && !is_complete) status = generate(view.generate_ms, record, made);
  if (!status.ok()) return status_text(options_.world, status);
  if (view.wait) renderer_.finish();
  record.frame_ms = ms_between(start, now_ns());
  record.gpu_terrain_ms = renderer_.terrain_gpu_ms();
  record.gpu_shadow_ms = renderer_.shadow_gpu_ms();
  record.resident = residency().pool().resident();
  record.gl_objects = gl_objects_made() - gl_objects_at_start_;
  if (record.pool.pool_full) record.flags |= kFlagPool;
  if (record.selection.lod.capped > 0 && !record.pool.pool_full) record.flags |= kFlagGenerate;
  return {};
}

Status Scene::select(const ViewRequest& view, FrameRecord& record) {
  const std::int64_t start = now_ns();
  Status status;
  {
    const HeapCount count(record.heap_calls);
    status = residency().select(parts_.views_of(1), std::span(&view, 1));
  }
  record.cull_lod_ms += ms_between(start, now_ns());
  record.selection = eye().selection();
  record.pool = residency().governor();
  if (status.code() == StatusCode::limit_reached) {
    record.flags |= kFlagDrawItems;
    status = {};
  }
  return status;
}

Status Scene::upload_patch(const PatchUpload& upload) {
  return renderer_.upload_vertices(residency().pages(), upload.patch,
                                   static_cast<std::uint32_t>(upload.first_vertex), upload.vertices,
                                   upload.origin, upload.row, upload.shading);
}

// Makes vertices for so many milliseconds, or until nothing is to be made.
Status Scene::generate(double until_ms, FrameRecord& record, bool& made) {
  const std::int64_t start = now_ns();
  std::int64_t at = start;
  PatchUpload upload;
  Status status;
  const bool ahead = until_ms != SceneView::kComplete;
  const auto generate_next = [&] {
    const HeapCount count(record.heap_calls);
    return residency().generate_next(ahead, upload, status);
  };
  while (ms_between(start, at) < until_ms && generate_next()) {
    lap(at, record.generate_ms);
    status = upload_patch(upload);
    lap(at, record.upload_ms);
    if (!status.ok()) return status;
    made = true;
    ++record.generated;
  }
  lap(at, record.generate_ms);
  return status;
}

// Until the frame lacks nothing that can be made: what is made changes what neighbours may show, and a pool
// that is full changes the error that is aimed at.
Status Scene::complete(const ViewRequest& view, FrameRecord& record) {
  constexpr int kMostRounds = 64;
  for (int round = 0; round < kMostRounds; ++round) {
    bool made = false;
    if (const Status status = generate(SceneView::kComplete, record, made); !status.ok()) return status;
    const Governor::State& last = record.pool;
    const bool waiting = record.selection.lod.capped > 0 && residency().pool().kept_back() > 0;
    // A scale that falls can wait for the next frame.
    if (!made && !waiting && last.next_error_scale <= last.error_scale) return {};
    if (waiting) {
      // With nothing in flight, what patches gave up is free at once.
      renderer_.finish();
      for (std::uint32_t i = 0; i < kFramesInFlight; ++i) residency().begin_frame();
    }
    if (const Status status = select(view, record); !status.ok()) return status;
  }
  return {};
}

// What any of the patches listed needs.
unsigned Scene::shading_needs(FrameRecord& record) const {
  const std::span<const PatchShading> shading = parts_.residency.shading();
  unsigned needs = 0;
  for (const DrawItem& item : eye().items()) {
    const unsigned own = shading[item.patch].needs;
    needs |= own;
    record.blend_skipped += (own & kShadeBlend) == 0;
    record.cave_skipped += (own & kShadeCave) == 0;
  }
  return needs;
}

Status Scene::draw_selected(const SceneView& view, FrameRecord& record) {
  std::int64_t at = now_ns();
  if (const Status status = upload_morph_rows(); !status.ok()) return status;
  lap(at, record.upload_ms);
  ViewInput input;
  input.camera = view.camera;
  input.shading = shading_needs(record);
  input.skips = view.pixel_skips;
  if (view.lamps) input.lights = world().lights();
  input.light = view.light;
  input.quarter_turns = view.quarter_turns;
  input.items = eye().items();
  if (options_.show == Show::levels) {
    shown_items_.assign(eye().items().begin(), eye().items().end());
    std::stable_sort(shown_items_.begin(), shown_items_.end(),
                     [](const DrawItem& a, const DrawItem& b) { return a.level < b.level; });
    input.items = shown_items_;
  }
  input.least_cos2 = eye().error_scale().least_cos2;
  input.first_morph_row = residency().first_morph_row(eye());
  input.pages = residency().pages();
  input.index_table = world().index_table();
  input.max_level = world().info().level;
  input.light_space = light_space_;
  input.cascades = std::span(cascades_).first(static_cast<std::size_t>(cascade_count_));
  const bool drape = !options_.drape.empty();
  if (drape) {
    // The sky is one colour here; its own shading would cost as much a pixel as the terrain's.
    const glm::vec3 sky = encode_picture(horizon_light(view.light));
    target_.begin({sky.r, sky.g, sky.b});
  } else {
    target_.begin();
  }
  const Status status = renderer_.draw(input, {.viewport = target_.viewport(), .sky = !drape});
  target_.end();
  record.counts = renderer_.end_frame();
  lap(at, record.submit_ms);
  if (record.counts.vertices_lost) {
    residency().forget();
    first_frame_ = true;
    for (ShadowMap& map : shadow_maps_) map.drawn = false;
  }
  return status;
}

}  // namespace karst::app
