// SPDX-License-Identifier: MIT
// A pass is one view of the world, chosen, listed and drawn by itself. K's second to fifth passes draw shadow
// maps from the sun; here each further pass looks in another direction from the same place, the circle being
// divided evenly: as many patches are in view again, and none of the first pass's work is of use.
//
// What K counts as "frustum culling" is here culling, levels and draw list; K's "index buffer updates" are
// the index stream, part of submit. With a software driver submit also holds the driver's vertex work.
#include "bench/suites/bench_lod.h"

#include <cstdio>
#include <iterator>
#include <limits>
#include <memory>
#include <vector>

#include "app/common/arguments.h"
#include "app/common/json_writer.h"
#include "app/common/progress.h"
#include "app/files/atomic_file.h"
#include "bench/frames/bench_view.h"

namespace karst::bench {
using namespace app;
namespace {

constexpr int kLevels[] = {4, 5};
constexpr int kPasses[] = {1, 2, 4};

// K's test scene (3,560 patches) on K's machine, milliseconds. shadow_*: of the shadow map passes alone,
// table 5.11; the others: all passes, table 5.12, with as many shadow maps as passes here.
struct KFigures {
  int level, passes;
  double culling, indices, rendering;
  double shadow_culling, shadow_indices, shadow_rendering;
};
constexpr KFigures kReference[] = {
    {4, 1, 0.05, 0.15, 3.9, 0.05, 0.04, 0.6}, {4, 2, 0.1, 0.25, 4.4, 0.1, 0.14, 1.1},
    {4, 4, 0.25, 0.4, 5.4, 0.2, 0.3, 2.3},    {5, 1, 0.05, 0.7, 10, 0.05, 0.3, 2.1},
    {5, 2, 0.1, 1, 12.1, 0.1, 0.6, 4.3},      {5, 4, 0.25, 1.5, 16, 0.2, 1.1, 8.5},
};
// Table 5.9, all columns but the last: vertices of the whole scene, once. Level 4 and 5.
constexpr double kReferenceVerticesMs[] = {600, 1800};

struct Figures {
  int level = 0, passes = 0;
  double vertices_ms = 0;  // the first frame's, making and uploading
  double cull_lod_ms = 0, generate_ms = 0, upload_ms = 0, submit_ms = 0, frame_ms = 0;  // medians
  double triangles = 0, draw_calls = 0, patches = 0;                                    // means
  std::uint32_t total_patches = 0;
};

void add(const FrameRecord& pass, FrameRecord& frame) {
  frame.frame_ms += pass.frame_ms;
  frame.costs.select_ms += pass.costs.select_ms;
  frame.costs.generate_ms += pass.costs.generate_ms;
  frame.costs.upload_ms += pass.costs.upload_ms;
  frame.costs.submit_ms += pass.costs.submit_ms;
  frame.costs.triangles += pass.costs.triangles;
  frame.costs.draw_calls += pass.costs.draw_calls;
  frame.costs.patches_drawn += pass.costs.patches_drawn;
}

Error draw_frames(BenchView& view, std::span<const CameraSettings> path, int passes,
                  std::vector<FrameRecord>& frames) {
  for (CameraSettings settings : path) {
    FrameRecord& frame = frames.emplace_back();
    for (int pass = 0; pass < passes; ++pass) {
      std::vector<ViewState> camera;
      if (Error error = view.place({&settings, 1}, camera); !error.ok()) return error;
      BenchFrame drawn;
      if (Error error = view.draw(camera[0], view.levels(), drawn); !error.ok()) return error;
      add(drawn.record, frame);
      settings.yaw_deg += 360.0 / passes;
    }
  }
  return {};
}

template <class Get>
double median_of(const std::vector<FrameRecord>& frames, Get get) {
  std::vector<double> values;
  for (const FrameRecord& frame : frames) values.push_back(get(frame));
  return median(values);
}

template <class Get>
double mean_of(const std::vector<FrameRecord>& frames, Get get) {
  double sum = 0;
  for (const FrameRecord& frame : frames) sum += static_cast<double>(get(frame));
  return sum / static_cast<double>(frames.size());
}

Error measure_level(const LodSuiteOptions& options, int level, Progress& progress,
                    std::vector<Figures>& all) {
  SceneArguments look = options.look;
  look.level = level;
  if (look.vertex_bytes == 0) look.vertex_bytes = std::numeric_limits<std::uint64_t>::max();
  BenchView view;
  if (Error error = view.open(options.world, look); !error.ok()) return error;
  const core::World& terrain = view.terrain();
  if (terrain.info().level < level) return {};
  const auto path = make_standard_path("oblique", view.ground(), terrain.box(), options.frames);
  for (const int passes : kPasses) {
    std::vector<FrameRecord> warm, frames;
    for (std::vector<FrameRecord>* lap : {&warm, &frames}) {
      if (Error error = draw_frames(view, path, passes, *lap); !error.ok()) return error;
    }
    Figures& f = all.emplace_back();
    f.level = level;
    f.passes = passes;
    f.total_patches = terrain.patch_count();
    f.vertices_ms = view.stage().load_times().generate + view.stage().load_times().upload;
    f.cull_lod_ms = median_of(frames, [](const FrameRecord& r) { return r.costs.select_ms; });
    f.generate_ms = median_of(frames, [](const FrameRecord& r) { return r.costs.generate_ms; });
    f.upload_ms = median_of(frames, [](const FrameRecord& r) { return r.costs.upload_ms; });
    f.submit_ms = median_of(frames, [](const FrameRecord& r) { return r.costs.submit_ms; });
    f.frame_ms = median_of(frames, [](const FrameRecord& r) { return r.frame_ms; });
    f.triangles = mean_of(frames, [](const FrameRecord& r) { return r.costs.triangles; });
    f.draw_calls = mean_of(frames, [](const FrameRecord& r) { return r.costs.draw_calls; });
    f.patches = mean_of(frames, [](const FrameRecord& r) { return r.costs.patches_drawn; });
    progress.update(all.size());
  }
  return {};
}

const KFigures& reference_of(const Figures& f) {
  for (const KFigures& k : kReference) {
    if (k.level == f.level && k.passes == f.passes) return k;
  }
  return kReference[0];
}

void print_text(const std::vector<Figures>& all) {
  std::printf("%5s %6s | %8s %8s %8s %8s %8s | %9s %6s %8s | K: %7s %7s %9s\n", "level", "passes", "cull lod",
              "generate", "upload", "submit", "frame", "triangles", "draws", "patches", "culling", "indices",
              "rendering");
  for (const Figures& f : all) {
    const KFigures& k = reference_of(f);
    std::printf("%5d %6d | %8.3f %8.3f %8.3f %8.2f %8.2f | %9.0f %6.1f %8.0f | K: %7.2f %7.2f %9.1f\n",
                f.level, f.passes, f.cull_lod_ms, f.generate_ms, f.upload_ms, f.submit_ms, f.frame_ms,
                f.triangles, f.draw_calls, f.patches, k.culling, k.indices, k.rendering);
  }
  for (const Figures& f : all) {
    if (f.passes != 1) continue;
    std::printf(
        "level %d: vertices of the first frame %.1f ms, of %u patches; K, all of its scene: %.0f ms\n",
        f.level, f.vertices_ms, f.total_patches, kReferenceVerticesMs[f.level - 4]);
  }
  std::printf(
      "Milliseconds a frame, all passes. K: table 5.12, on K's machine; the shadow map passes alone,\n"
      "table 5.11:");
  for (const Figures& f : all) {
    const KFigures& k = reference_of(f);
    std::printf(" level %d, %d: %.2f + %.2f + %.1f;", k.level, k.passes, k.shadow_culling, k.shadow_indices,
                k.shadow_rendering);
  }
  std::printf("\n");
}

std::string json_text(const std::vector<Figures>& all) {
  JsonWriter json;
  json.begin_object().key("frames").begin_array();
  for (const Figures& f : all) {
    json.begin_object().field("level", f.level).field("passes", f.passes).field("cull_lod_ms", f.cull_lod_ms);
    json.field("generate_ms", f.generate_ms).field("upload_ms", f.upload_ms).field("submit_ms", f.submit_ms);
    json.field("frame_ms", f.frame_ms).field("triangles", f.triangles).field("draw_calls", f.draw_calls);
    json.field("patches_drawn", f.patches).field("patches", f.total_patches);
    json.field("first_vertices_ms", f.vertices_ms).end_object();
  }
  json.end_array().end_object();
  return json.text();
}

Error run_suite(const LodSuiteOptions& options) {
  std::vector<Figures> all;
  Progress progress("measuring", std::size(kLevels) * std::size(kPasses));
  for (const int level : kLevels) {
    if (Error error = measure_level(options, level, progress, all); !error.ok()) return error;
  }
  progress.finish();
  if (all.empty()) return options.world + ": has neither level 4 nor level 5";
  const std::string text = json_text(all);
  if (options.json == "-") {
    std::fputs(text.c_str(), stdout);
    return {};
  }
  print_text(all);
  return options.json.empty() ? Error() : write_file_atomic(options.json, std::as_bytes(std::span(text)));
}

}  // namespace

int run_lod_suite(const LodSuiteOptions& options) {
  if (const Error error = run_suite(options); !error.ok()) {
    print_error("karst-bench", error.text());
    return kExitFailure;
  }
  return kExitOk;
}

}  // namespace karst::bench
