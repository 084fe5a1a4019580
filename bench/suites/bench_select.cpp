// SPDX-License-Identifier: MIT
// Flies laps with the memory and the views that programs have, without GL. A frame is what the renderer makes
// of it: one selection of levels and lists, the index stream, then vertices for what is lacking or about to
// be needed. Instead of for --generate-ms of time, vertices are made for as many patches as take that on the
// machine of docs/benchmarks.md, so that all runs see the same frames. With --generate-ms 0 frames are
// complete before they are listed, which takes more selections.
//
// Parts of a selection are timed on their own, on the same input, after the whole one.
#include "bench/suites/bench_select.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <span>
#include <string_view>
#include <vector>

#include "app/common/arguments.h"
#include "bench/frames/bench_view.h"
#include "bench/ground/select_ground.h"
#include "terrain/base/checksum.h"
#include "terrain/draw/expand_indices.h"

namespace karst::bench {
namespace {

using namespace core;
using namespace app;

constexpr double kGenerateMs = 4;         // as of karst view
constexpr double kVertexNs = 50;          // to make one of a patch at full level
constexpr std::size_t kStream = 131'072;  // indices a draw call: Config::stream_indices

// What this thread ran on a core: other programs on the machine do not count.
double thread_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e9 + static_cast<double>(t.tv_nsec);
}

class Series {
 public:
  template <class Work>
  void time(const Work& work) {
    const double start = thread_ns();
    work();
    ns_.push_back(std::max(0.0, thread_ns() - start - clock_ns()));
  }
  double part(double share) const {
    std::vector<double> sorted = ns_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  }
  double median_us() const { return part(0.5) * 1e-3; }
  double p95_us() const { return part(0.95) * 1e-3; }

 private:
  static double clock_ns() {
    static const double cost = [] {
      double least = 1e9;
      for (int n = 0; n < 1000; ++n) {
        const double start = thread_ns();
        least = std::min(least, thread_ns() - start);
      }
      return least;
    }();
    return cost;
  }
  std::vector<double> ns_;
};

struct Counts {
  std::uint64_t frames = 0, selects = 0, drawn = 0, triangles = 0, lacking = 0, lacking_frames = 0,
                lowered = 0;
  std::uint64_t occluded = 0, back_facing = 0, indices = 0;
  std::uint32_t hash = 0;  // of all lists
};

class Flight {
 public:
  Flight(TerrainParts& parts, const StageView& look)
      : parts_(parts),
        look_(look),
        levels_(parts.world.patch_count()),
        scratch_(parts.world.patch_count()),
        items_(parts.world.patch_count()),
        cut_(parts.world.patch_count()),
        culled_(PatchBoxes::count_for(parts.world.patch_count())),
        hidden_(Occlusion::entry_count(parts.world.patch_count())),
        stream_(kStream) {
    occlusion_.create(hidden_, parts.world.patch_count());
  }

  Error run(std::string_view name, std::span<const Camera> cameras, int rounds) {
    parts_.residency.forget();
    counts_ = {};
    for (Series* series : {&select_, &plain_cull_, &cull_, &plain_lod_, &lod_, &list_, &stream_us_})
      *series = {};
    first_ = true;
    for (int round = 0; round <= rounds; ++round) {
      measured_ = round > 0;
      for (const Camera& camera : cameras) {
        if (const Status status = frame(camera); !status.ok()) return Error(std::string(name), status);
      }
    }
    print(name);
    return {};
  }

 private:
  Status select(const ViewRequest& request, bool cuts) {
    Status status;
    const auto all = [&] {
      status = parts_.residency.select(parts_.views_of(1), std::span(&request, 1), cuts);
    };
    if (!measured_) {
      all();
    } else {
      select_.time(all);
      ++counts_.selects;
    }
    return status.code() == StatusCode::limit_reached ? Status() : status;
  }

  // Makes vertices of so many patches. made: how many there were to make.
  Status make(std::uint32_t most, bool ahead, std::uint32_t& made) {
    PatchUpload upload;
    Status status;
    for (made = 0; made < most && parts_.residency.generate_next(ahead, upload, status);) ++made;
    while (!parts_.residency.take_morph_rows().halves.empty()) {
    }
    return status;
  }

  // As the renderer completes a frame (scene/frame/renderer_object.cpp).
  Status complete(const ViewRequest& request, bool cuts) {
    Residency& residency = parts_.residency;
    for (int round = 0; round < 64; ++round) {
      std::uint32_t made = 0;
      if (const Status status = make(~0u, false, made); !status.ok()) return status;
      if (!cuts && residency.complete_selection()) return {};
      const bool lacks = parts_.views[0].selection().lod.capped > 0;
      const bool waiting = lacks && residency.pool().kept_back() > 0;
      const Governor::State& governor = residency.governor();
      if (!cuts && waiting && !governor.pool_full && round == 0) {
        residency.retry_lacking();
        continue;
      }
      if ((cuts || !lacks) && made == 0 && !waiting && governor.next_error_scale <= governor.error_scale) {
        return {};
      }
      cuts = true;
      for (std::uint32_t i = 0; waiting && i < kFramesInFlight; ++i) residency.begin_frame();
      if (const Status status = select(request, cuts); !status.ok()) return status;
    }
    return {};
  }

  Status frame(const Camera& camera) {
    ViewRequest request;
    request.camera = &camera;
    constexpr core::LodMode kModes[] = {core::LodMode::error, core::LodMode::distance, core::LodMode::full};
    request.lod.mode = kModes[static_cast<int>(look_.inspection.lod)];
    request.lod.max_level = parts_.world.info().level;
    request.lod.resident_level = request.lod.max_level;
    request.lod.error_px = look_.view.error_px;
    request.lod.distance_voxels = look_.inspection.distance_voxels;
    request.width_px = static_cast<int>(look_.view.width_px);
    request.height_px = static_cast<int>(look_.view.height_px);
    request.frustum_culling = look_.inspection.skip_frustum;
    request.backface_culling = look_.inspection.skip_backface;
    request.occlusion_culling = look_.inspection.skip_occluded;
    parts_.residency.begin_frame();
    const bool waits = first_ || look_.work_ms == 0;
    const bool cuts = !waits || parts_.residency.governor().pool_full;
    Status status = select(request, cuts);
    if (status.ok() && waits) status = complete(request, cuts);
    first_ = false;
    if (status.ok() && measured_) status = take_parts(camera, request);
    if (!status.ok() || look_.work_ms == 0) return status;
    const double patch_ms = patch_vertices(parts_.world.info().level) * kVertexNs * 1e-6;
    std::uint32_t made = 0;
    return make(static_cast<std::uint32_t>(look_.work_ms / patch_ms) + 1, true, made);
  }

  Status take_parts(const Camera& camera, const ViewRequest& request) {
    const core::ViewState& view = parts_.views[0];
    const core::World& world = parts_.world;
    count(view);
    const Frustum frustum = make_frustum(camera);
    CullView cull;
    cull.frustum = request.frustum_culling ? &frustum : nullptr;
    cull.tree = &world.tree();
    cull.boxes = world.patch_boxes();
    cull.out = culled_;
    if (const Status status = cull.validate(); !status.ok()) return status;
    std::uint32_t eights = 0;
    plain_cull_.time([&] { eights = cull.run(); });
    cull_.time([&] {
      occlusion_.end();
      if (request.occlusion_culling && !world.occluders().empty()) {
        occlusion_.begin(world.occluders(), world.octree(), world.tree(), world.surface(), world.bounds(),
                         camera, request.occlusion_searches);
        cull.occlusion = &occlusion_;
        cull.levels = levels_;
      }
      eights = cull.run();
    });

    SelectLod lod;
    lod.settings = view.settings();
    lod.camera = &camera;
    lod.surface = world.surface();
    lod.bounds = world.bounds();
    lod.tree = &world.tree();
    lod.culled = std::span(culled_).first(eights);
    lod.scale = view.error_scale();
    lod.lods = parts_.residency.thresholds().lods(view.threshold_set());
    if (request.backface_culling) lod.cones = world.cones();
    lod.errors = world.level_errors();
    lod.levels = levels_;
    lod.cut = cut_;
    if (const Status status = lod.validate(); !status.ok()) return status;
    plain_lod_.time([&] { lod.run(); });
    lod.resident = parts_.residency.pool().levels();
    SelectLod::Result selected;
    lod_.time([&] { selected = lod.run(); });

    BuildDrawList list;
    list.camera = &camera;
    list.surface = world.surface();
    list.boxes = world.patch_boxes();
    list.culled = lod.culled;
    list.shows_hidden = selected.missing > 0;
    if (request.backface_culling) list.cones = world.cones();
    list.least_pixels = lod.scale.least_pixels;
    list.levels = levels_;
    list.scratch = scratch_;
    list.items = items_;
    if (const Status status = list.validate(); !status.ok()) return status;
    BuildDrawList::Result listed;
    Status status;
    list_.time([&] { status = list.run(listed); });
    if (!status.ok()) return status;

    const ExpandIndices expand{world.index_table(), view.items(), parts_.residency.pages(), stream_};
    stream_us_.time([&] {
      for (ExpandIndices::Chunk chunk; chunk.next_item < expand.items.size();
           counts_.indices += chunk.indices) {
        chunk = expand.run(chunk.next_item);
      }
    });
    return status;
  }

  void count(const core::ViewState& view) {
    const core::ViewState::Selection& selection = view.selection();
    ++counts_.frames;
    counts_.drawn += selection.list.drawn;
    counts_.triangles += selection.list.triangles;
    counts_.lacking += selection.lod.capped;
    counts_.lacking_frames += selection.lod.capped > 0;
    counts_.lowered += selection.lod.lowered;
    counts_.occluded += selection.list.culled_occluded;
    counts_.back_facing += selection.list.culled_backface;
    counts_.hash = crc32c(std::as_bytes(view.items()), counts_.hash);
    counts_.hash = crc32c(std::as_bytes(std::span(&selection.lod.bound_px, 1)), counts_.hash);
  }

  void print(std::string_view name) const {
    const auto mean = [&](std::uint64_t sum) {
      return static_cast<double>(sum) / static_cast<double>(counts_.frames);
    };
    std::printf(
        "%.*s: %.0f patches, %.0f triangles a frame; %.1f lack something, in %.0f %% of frames, and lower "
        "%.1f; "
        "%.0f back-facing, %.0f behind rock; lists %08x\n",
        static_cast<int>(name.size()), name.data(), mean(counts_.drawn), mean(counts_.triangles),
        mean(counts_.lacking), 100 * mean(counts_.lacking_frames), mean(counts_.lowered),
        mean(counts_.back_facing), mean(counts_.occluded), counts_.hash);
    const double whole = select_.median_us();
    const auto line = [&](const char* what, double median, double p95) {
      std::printf("  %-28s %8.1f us median %8.1f us p95 %5.0f %%\n", what, median, p95, 100 * median / whole);
    };
    std::printf("  %.2f selections a frame\n", mean(counts_.selects));
    line("a selection", whole, select_.p95_us());
    line("  what is in view, no rock", plain_cull_.median_us(), plain_cull_.p95_us());
    line("  what is in view", cull_.median_us(), cull_.p95_us());
    line("  levels that are wanted", plain_lod_.median_us(), plain_lod_.p95_us());
    line("  levels, cut to what is held", lod_.median_us(), lod_.p95_us());
    line("  list", list_.median_us(), list_.p95_us());
    line("index stream", stream_us_.median_us(), stream_us_.p95_us());
    std::printf("  %.0f indices a frame\n", mean(counts_.indices));
  }

  TerrainParts& parts_;
  const StageView& look_;
  std::vector<std::uint8_t> levels_;
  std::vector<std::uint32_t> scratch_;
  std::vector<DrawItem> items_;
  std::vector<PatchId> cut_;
  std::vector<CulledEight> culled_;
  std::vector<std::uint16_t> hidden_;
  std::vector<std::uint32_t> stream_;
  Occlusion occlusion_;
  bool first_ = true;
  bool measured_ = false;
  Counts counts_;
  Series select_, plain_cull_, cull_, plain_lod_, lod_, list_, stream_us_;
};

Error measure(const SelectSuiteOptions& options) {
  BenchView view;
  if (Error error = view.load(options.world, options.look); !error.ok()) return error;
  auto& world = static_cast<WorldObject&>(view.stage().world());
  const bool has_patches = world.terrain.world.patch_count() > 0;
  StageView look = view.look();
  look.work_ms = options.look.generate_ms >= 0 ? options.look.generate_ms : kGenerateMs;
  look.view.width_px = static_cast<std::uint32_t>(options.look.width);
  look.view.height_px = static_cast<std::uint32_t>(options.look.height);
  const GroundHeights& ground = view.ground();
  Flight flight(world.terrain, look);
  for (const std::string_view name : {"low", "oblique", "still"}) {
    const bool still = name == "still";
    const std::vector<CameraSettings> path = make_standard_path(
        still ? "oblique" : name, ground, world.terrain.world.box(), still ? 1 : options.frames);
    std::vector<karst::ViewState> views;
    if (Error error = view.place(path, views); !error.ok()) return error;
    std::vector<Camera> cameras;
    for (int n = 0; n < options.frames; ++n) {
      const karst::ViewState& placed = views[still ? 0 : static_cast<std::size_t>(n)];
      if (const Status status = world.placement.make_camera(placed, cameras.emplace_back()); !status.ok()) {
        return Error("camera", status);
      }
    }
    if (has_patches) {
      if (Error error = flight.run(name, cameras, options.rounds); !error.ok()) return error;
    }
    if (!world.terrain.ground.exists()) continue;
    if (Error error = run_select_ground(view, look, name, cameras, options.rounds); !error.ok()) return error;
  }
  return {};
}

}  // namespace

int run_select_suite(const SelectSuiteOptions& options) {
  if (const Error error = measure(options); !error.ok()) {
    print_error("karst-bench", error.text());
    return kExitFailure;
  }
  return kExitOk;
}

}  // namespace karst::bench
