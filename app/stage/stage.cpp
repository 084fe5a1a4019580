// SPDX-License-Identifier: MIT
#include "app/stage/stage.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "app/files/whole_file.h"
#include "app/stage/resource_counts.h"
#include "platform/base/clock.h"

namespace karst::app {
namespace {

std::string format_mebibytes(std::uint64_t bytes) {
  char text[64];
  std::snprintf(text, sizeof text, "%.1f MiB", static_cast<double>(bytes) / (1 << 20));
  return text;
}

constexpr unsigned kRedOfLookup = 12;  // Show::lookups

// Decoded bytes of a drape, whatever its length, and for each byte of it.
constexpr std::uint64_t kFreeDrapeBytes = 32u << 20;
constexpr std::uint64_t kDrapeBytesAByte = 64;

// Adds the time since `start` to `total` and starts anew.
void lap(std::int64_t& start, double& total) {
  const std::int64_t now = now_ns();
  total += ms_between(start, now);
  start = now;
}

// What is taken back takes a quarter; patches and a ground's tiles share the rest. What one of them costs is
// the world's affair.
Status divide_edit_memory(const Head& head, std::uint64_t bytes, Plan& plan) {
  if (bytes == 0) return {};
  constexpr std::uint32_t kSome = 1024;
  Plan trial = plan;
  trial.needs.max_cpu_bytes = trial.needs.max_gpu_bytes = UINT64_MAX;
  const auto cost = [&](std::uint32_t patches, std::uint32_t tiles, std::uint64_t& out) {
    trial.needs.edit_patches = patches;
    trial.needs.edit_tiles = tiles;
    const Status status = make_plan(head, trial);
    out = trial.cpu_bytes + trial.gpu_bytes;
    return status;
  };
  std::uint64_t none = 0, patches = 0, tiles = 0;
  Status status = cost(0, 0, none);
  if (status.ok()) status = cost(kSome, 0, patches);
  if (status.ok()) status = cost(kSome, kSome, tiles);
  if (!status.ok()) return status;
  const auto count = [&](std::uint64_t taken, std::uint64_t most) {
    const std::uint64_t share = bytes / 4 * 3 / (patches > none && tiles > patches ? 2 : 1);
    const std::uint64_t each = std::max<std::uint64_t>(taken / kSome, 1);
    return static_cast<std::uint32_t>(taken == 0 ? kSome
                                                 : std::clamp<std::uint64_t>(share / each, kSome / 8, most));
  };
  if (info_of(head).can_be_dug) {
    // A quarter for regions that are made.
    constexpr std::uint32_t kDigRegions = 4;
    bytes = bytes / 4 * 3;
    trial.needs.dig_regions = kDigRegions;
    trial.needs.region_patches = kSome;
    std::uint64_t regions = 0;
    status = cost(kSome, kSome, regions);
    if (!status.ok()) return status;
    plan.needs.dig_regions = kDigRegions;
    const std::uint64_t each = std::max<std::uint64_t>((regions - tiles) / kSome, 1);
    plan.needs.region_patches =
        static_cast<std::uint32_t>(std::clamp<std::uint64_t>(bytes / 3 / each, kSome, 1u << 20));
  }
  if (info_of(head).field_samples[0] > 0) {
    // Of a field's samples a quarter, as many as there are at most.
    constexpr std::uint64_t kBlockBytes = 4096;
    const WorldInfo info = info_of(head);
    std::uint64_t most = static_cast<std::uint64_t>(info.field_sample_bits) / 8;
    for (const std::int32_t samples : info.field_samples) most *= static_cast<std::uint64_t>(samples) / 16;
    plan.needs.field_sample_blocks =
        static_cast<std::uint32_t>(std::clamp<std::uint64_t>(bytes / 4 / kBlockBytes, 1, most));
    if (info.materials > 0) plan.needs.field_material_blocks = plan.needs.field_sample_blocks;
  }
  plan.needs.undo_bytes = bytes / 4;
  plan.needs.edit_patches = count(patches - none, 1u << 20);
  plan.needs.edit_tiles = count(tiles - patches, 65'536);
  // A painted map of a world that has none: 1 MiB and as much of the GPU's, which is not counted.
  plan.needs.paint_width = plan.needs.paint_depth = 512;
  return {};
}

// Counts karst's heap calls between on(true) and on(false).
struct OwnWork {
  std::uint64_t before = 0;
  std::uint64_t total = 0;
  static void on(void* user, bool begins) {
    auto* const own = static_cast<OwnWork*>(user);
    if (begins) {
      own->before = heap_calls();
    } else {
      own->total += heap_calls() - own->before;
    }
  }
};

}  // namespace

Stage::~Stage() {
  detach();
  if (world_ != nullptr) world_->destroy();
}

Error Stage::load(const std::string& world, const SceneArguments& scene, const StageNeeds& needs) {
  path_ = world;
  scene_ = scene;
  width_ = scene.width;
  height_ = scene.height;
  plan_.needs.views = needs.views;
  plan_.needs.queries = needs.queries;
  overlay_bytes_ = needs.overlay_bytes;
  edit_bytes_ = needs.edit_bytes;
  std::int64_t start = now_ns();
  if (Error error = load_drape(); !error.ok()) return error;
  if (Error error = file_.open(path_); !error.ok()) return error;
  source_ = file_.source();
  Head head;
  if (const Status status = read_head(source_, head); !status.ok()) return {path_, status};
  // A patch of level l takes about 16 bytes * 4^l.
  const auto level = static_cast<unsigned>(std::clamp(std::min(scene.level, info_of(head).level), 1, 6));
  const std::uint64_t patches = std::min<std::uint64_t>(needs.query_bytes >> (4 + 2 * level), 65'536);
  plan_.needs.query_patches = std::max(needs.query_patches, static_cast<std::uint32_t>(patches));
  plan_.needs.query_tiles = needs.query_tiles;
  if (Error error = make_plan_for(head); !error.ok()) return error;
  memory_.reset(static_cast<std::byte*>(std::aligned_alloc(kMemoryAlignment, plan_.cpu_bytes)));
  if (memory_ == nullptr) return path_ + ": cannot get " + format_mebibytes(plan_.cpu_bytes) + " of memory";
  const karst::Log log{
      [](void* user, Severity, const char* text) { static_cast<Stage*>(user)->driver_words_ = text; }, this};
  const Status status = World::create(plan_, source_, {memory_.get(), plan_.cpu_bytes}, world_, log);
  lap(start, times_.read);
  return {path_, status};
}

Error Stage::load_drape() {
  if (scene_.drape.empty()) return {};
  WholeFile file;
  if (Error error = file.open(scene_.drape, WholeFile::kMostBytes); !error.ok()) return error;
  constexpr int kMostPixels = 16'384;
  // The pixels are held for a lost context, and the GPU takes a third more than as much.
  const std::uint64_t most = scene_.max_memory / 7 * 3;
  // Pictures hold a pixel in a few bits. More, of one colour or made to take memory, is for who asks for it.
  const std::uint64_t usual = std::max(kFreeDrapeBytes, kDrapeBytesAByte * file.bytes().size());
  const bool is_asked_for = scene_.max_memory > SceneArguments().max_memory;
  const std::uint64_t allowed = is_asked_for ? most : std::min(most, usual);
  const Error error = decode_png(file.bytes(), kMostPixels, allowed, drape_);
  if (error.ok()) return {};
  const std::string why = allowed < most ? "; its " + std::to_string(file.bytes().size()) +
                                               " bytes hold few; --max-memory above 512 takes it"
                                         : "; --max-memory is " + format_mebibytes(scene_.max_memory);
  return scene_.drape + ": " + error.text() + why;
}

std::uint64_t Stage::target_bytes() const {
  PictureSettings picture;
  picture.width = width_;
  picture.height = height_;
  picture.rgb565 = scene_.rgb565;
  picture.samples = samples_of(scene_.antialias);
  picture.own_depth = renderer_ == nullptr ? !may_share_depth() : device_info(*renderer_).depth_texture == 0;
  return picture.bytes() + overlay_bytes_;
}

// Pictures that go by the G-buffer need no depth of their own; larger ones do not go by it, and of several
// views each begins elsewhere in it.
bool Stage::may_share_depth() const {
  return plan_.needs.views == 1 && static_cast<std::uint32_t>(width_) <= plan_.needs.deferred_width &&
         static_cast<std::uint32_t>(height_) <= plan_.needs.deferred_height;
}

// All memory, --max-memory, is the CPU's and the GPU's together: what GL takes is known first, and heights
// get what is left.
Error Stage::make_plan_for(const Head& head) {
  const WorldInfo info = info_of(head);
  Needs& needs = plan_.needs;
  plan_.placement.axes = Axes::east_up_south;
  needs.level = static_cast<std::uint32_t>(scene_.level);
  needs.query_level = needs.level;  // cameras stand on what is drawn
  needs.vertex_bytes = scene_.vertex_bytes;
  needs.shadow_maps = scene_.drape.empty() ? static_cast<std::uint32_t>(scene_.shadows) : 0;
  needs.shadow_size = static_cast<std::uint32_t>(scene_.shadow_size);
  // Of a ground a voxel is four samples, however fine those of its region are.
  const bool finer = info.regions > 0 || info.can_be_dug;
  const double voxel_m = finer ? 4 * info.ground_spacing_m[0] : info.voxel_size_m;
  needs.shadow_reach_m = scene_.shadow_reach_voxels * voxel_m;
  const bool sampled = samples_of(scene_.antialias) > 1;
  if (scene_.shading != ShadingChoice::forward && scene_.drape.empty() && !sampled) {
    needs.deferred_width = static_cast<std::uint32_t>(scene_.width);
    needs.deferred_height = static_cast<std::uint32_t>(scene_.height);
  }
  needs.drape_width = static_cast<std::uint32_t>(drape_.width);
  needs.drape_height = static_cast<std::uint32_t>(drape_.height);
  needs.max_cpu_bytes = needs.max_gpu_bytes = UINT64_MAX;
  if (const Status status = divide_edit_memory(head, edit_bytes_, plan_); !status.ok())
    return {path_, status};
  if (const Status status = make_plan(head, plan_); !status.ok()) return {path_, status};
  const std::uint64_t others = gpu_bytes() + drape_.rgba.size();
  std::uint64_t max_cpu = scene_.max_memory - std::min(scene_.max_memory, others);
  if (scene_.max_cpu > 0) max_cpu = std::min(max_cpu, scene_.max_cpu);
  needs.max_cpu_bytes = max_cpu;
  const Status status = make_plan(head, plan_);
  if (Error error = check_memory(); !error.ok()) return error;
  return {path_, status};
}

Error Stage::check_memory() const {
  const std::uint64_t cpu = cpu_bytes();
  const std::uint64_t gpu = gpu_bytes();
  if (cpu <= scene_.max_memory && gpu <= scene_.max_memory - cpu) return {};
  return path_ + ": needs " + format_mebibytes(cpu) + " of CPU and " + format_mebibytes(gpu) +
         " of GPU memory, more than --max-memory " + format_mebibytes(scene_.max_memory) + "; raise it";
}

Error Stage::attach(Display& display, int width, int height) {
  times_.context = times_.generate = times_.upload = 0;
  std::int64_t start = now_ns();
  width_ = width;
  height_ = height;
  if (Error error = check_memory(); !error.ok()) return error;
  const GlLoader loader{
      [](void* user, const char* name) { return static_cast<const Display*>(user)->gl_function(name); },
      &display};
  GlOptions options;
  options.detail = static_cast<Detail>(scene_.detail);
  options.precision = static_cast<Precision>(scene_.precision);
  options.anisotropy = static_cast<std::uint32_t>(scene_.anisotropy);
  options.shading = static_cast<Shading>(scene_.shading);
  options.share_depth = may_share_depth();
  options.smooth_edges = scene_.antialias == Antialias::edges;
  options.timers = true;
  options.drape_repeat = scene_.drape_repeat;
  driver_words_.clear();
  if (const Status status = Renderer::create(*world_, counting_loader(loader), options, renderer_);
      !status.ok()) {
    const Error error(display.name(), status);
    return driver_words_.empty() ? error : Error(error.text() + "; " + driver_words_);
  }
  PictureSettings picture;
  picture.width = width;
  picture.height = height;
  picture.rgb565 = scene_.rgb565;
  picture.samples = samples_of(scene_.antialias);
  picture.keep_depth = keep_depth;
  picture.float_depth = reversed_depth();
  picture.depth_texture = device_info(*renderer_).depth_texture;
  picture.own_depth = picture.depth_texture == 0;
  if (const Status status = target_.create(counting_loader(loader), picture); !status.ok()) {
    detach();
    return {display.name(), status};
  }
  if (!drape_.rgba.empty()) {
    if (const Status status = renderer_->set_drape(drape_.rgba); !status.ok()) return {scene_.drape, status};
  }
  first_frame_ = true;
  gl_objects_at_start_ = gl_objects_made();
  lap(start, times_.context);
  return {};
}

void Stage::detach(bool lost) {
  if (renderer_ == nullptr) return;
  if (lost) {
    renderer_->context_lost();
    target_.forget();
    gl_objects_lost();
  } else {
    target_.destroy();
    renderer_->destroy();
  }
  renderer_ = nullptr;
}

std::uint64_t Stage::gpu_used() const {
  return renderer_ == nullptr ? 0 : device_info(*renderer_).gpu_bytes + target_bytes();
}

Error Stage::draw(const StageView& view, FrameRecord& record) {
  const std::int64_t start = now_ns();
  OwnWork own;
  Inspection inspection = view.inspection;
  inspection.own_work = OwnWork::on;
  inspection.user = &own;
  set_inspection(*renderer_, inspection);
  FrameInput input;
  const std::span<const ViewState> views = view.views.empty() ? std::span(&view.view, 1) : view.views;
  input.views = views;
  input.sun = view.sun;
  input.work_ms = view.work_ms;
  Status status = renderer_->begin_frame(input, record.result);
  if (first_frame_) {
    times_.generate = costs(*renderer_).generate_ms;
    times_.upload = costs(*renderer_).upload_ms;
    first_frame_ = false;
  }
  if (status.ok()) {
    // The sky is one colour with a drape; its own shading would cost as much a pixel as the terrain's.
    const float farthest = views[0].reversed_depth ? 0.0f : 1.0f;
    const bool counts = inspection.show == Show::lookups && !has_drape();
    if (counts) {
      target_.begin({0, 0, 0}, farthest);
    } else if (has_drape()) {
      target_.begin(renderer_->air(0).horizon_display_rgb, farthest);
    } else {
      target_.begin(farthest);
    }
    Target target;
    target.depth_zero_to_one = views[0].reversed_depth;
    target.two_ranges = !target.depth_zero_to_one && !keep_depth;  // read_depth() has one
    target.framebuffer = target_.framebuffer();
    target.sky = !has_drape() && !counts;
    for (std::size_t n = 0; n < views.size() && status.ok(); ++n) {
      target.viewport = view.views.empty() ? target_.viewport() : view.parts[n];
      status = renderer_->draw(static_cast<std::uint32_t>(n), target);
      if (status.ok() && view.draw_over != nullptr) view.draw_over(view.user, views[n], target.two_ranges);
    }
    target_.end();
  }
  if (status.ok()) status = renderer_->end_frame();
  if (!status.ok()) return {path_, status};
  if (view.wait) target_.finish();
  record.frame_ms = ms_between(start, now_ns());
  record.costs = costs(*renderer_);
  record.heap_calls = own.total;
  record.gl_objects = gl_objects_made() - gl_objects_at_start_;
  return {};
}

Error Stage::count_lookups(StageView view, double& a_pixel) {
  a_pixel = 0;
  if (has_drape()) return {};
  view.inspection.show = Show::lookups;
  FrameRecord record;
  if (Error error = draw(view, record); !error.ok()) return error;
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 4);
  if (const Status status = target_.read_colour(rgba); !status.ok()) return {"lookups", status};
  std::uint64_t pixels = 0;
  std::uint64_t lookups = 0;
  for (std::size_t n = 0; n < rgba.size(); n += 4) {
    if (rgba[n + 2] == 0) continue;
    ++pixels;
    lookups += rgba[n] / kRedOfLookup;
  }
  if (pixels > 0) a_pixel = static_cast<double>(lookups) / static_cast<double>(pixels);
  return {};
}

}  // namespace karst::app
