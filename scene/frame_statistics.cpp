// SPDX-License-Identifier: MIT
#include "scene/frame_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/common/json_writer.h"
#include "scene/scene.h"

namespace karst::app {
using namespace core;
namespace {

template <class Get>
std::vector<double> collect(const std::vector<FrameRecord>& frames, Get get) {
  std::vector<double> values;
  values.reserve(frames.size());
  for (const FrameRecord& frame : frames) {
    const double value = static_cast<double>(get(frame));
    if (std::isfinite(value)) values.push_back(value);
  }
  return values;
}

template <class Get>
double median_of(const std::vector<FrameRecord>& frames, Get get) {
  std::vector<double> values = collect(frames, get);
  return median(values);
}

template <class Get>
double mean_of(const std::vector<FrameRecord>& frames, Get get) {
  double sum = 0;
  for (const FrameRecord& frame : frames) sum += static_cast<double>(get(frame));
  return sum / static_cast<double>(frames.size());
}

void write_times(JsonWriter& json, const std::vector<FrameRecord>& frames) {
  std::vector<double> ms = collect(frames, [](const FrameRecord& f) { return f.frame_ms; });
  json.key("frame_ms").begin_object();
  json.field("median", median(ms))
      .field("p99", percentile(ms, 0.99))
      .field("max", percentile(ms, 1.0))
      .end_object();
  json.key("cpu_ms").begin_object();
  json.field("cull_lod", median_of(frames, [](const FrameRecord& f) { return f.cull_lod_ms; }));
  json.field("generate", median_of(frames, [](const FrameRecord& f) { return f.generate_ms; }));
  json.field("upload", median_of(frames, [](const FrameRecord& f) { return f.upload_ms; }));
  json.field("submit", median_of(frames, [](const FrameRecord& f) { return f.submit_ms; })).end_object();
  json.key("gpu_ms").begin_object();
  json.field("shadow", median_of(frames, [](const FrameRecord& f) { return f.gpu_shadow_ms; }));
  json.field("terrain", median_of(frames, [](const FrameRecord& f) { return f.gpu_terrain_ms; }))
      .end_object();
}

void write_patches(JsonWriter& json, Scene& scene, const std::vector<FrameRecord>& frames) {
  json.key("patches").begin_object();
  json.field("total", scene.world().patch_count()).field("resident", frames.back().resident);
  json.field("drawn", mean_of(frames, [](const FrameRecord& f) { return f.selection.list.drawn; }));
  json.field("culled_frustum",
             mean_of(frames, [](const FrameRecord& f) { return f.selection.list.culled_frustum; }));
  json.field("culled_backface",
             mean_of(frames, [](const FrameRecord& f) { return f.selection.list.culled_backface; }));
  json.field("culled_occluded",
             mean_of(frames, [](const FrameRecord& f) { return f.selection.list.culled_occluded; }));
  json.field("coarser_than_wanted",
             mean_of(frames, [](const FrameRecord& f) { return f.selection.lod.capped; }));
  json.field("missing", mean_of(frames, [](const FrameRecord& f) { return f.selection.lod.missing; }));
  json.field("wanted_pages", mean_of(frames, [](const FrameRecord& f) { return f.pool.wanted_pages; }));
  json.field("error_scale", mean_of(frames, [](const FrameRecord& f) { return f.pool.error_scale; }));
  json.field("generated", mean_of(frames, [](const FrameRecord& f) { return f.generated; }));
  json.key("at_level").begin_array();
  for (int level = 1; level <= scene.world().info().level; ++level) {
    json.value(mean_of(frames, [level](const FrameRecord& f) { return f.selection.list.at_level[level]; }));
  }
  json.end_array().end_object();
}

void write_flags(JsonWriter& json, const std::vector<FrameRecord>& frames) {
  std::uint32_t flags = 0;
  for (const FrameRecord& frame : frames) flags |= frame.flags;
  json.key("flags").begin_array();
  if ((flags & kFlagDrawItems) != 0) json.value("max_draw_items");
  if ((flags & kFlagPool) != 0) json.value("gpu_vertex_pages");
  if ((flags & kFlagGenerate) != 0) json.value("generate_ms");
  json.end_array();
}

}  // namespace

double percentile(std::vector<double>& values, double part) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(part * static_cast<double>(values.size()));  // nearest rank
  return values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

double median(std::vector<double>& values) {
  return percentile(values, 0.5);
}

std::string statistics_json(Scene& scene, const std::vector<FrameRecord>& frames) {
  const PictureSettings& settings = scene.target().settings();
  JsonWriter json;
  json.begin_object();
  json.field("frames", std::uint64_t{frames.size()});
  json.key("size").begin_array().value(settings.width).value(settings.height).end_array();
  json.field("renderer", scene.renderer().caps().renderer);
  json.field("driver", scene.renderer().caps().version);
  write_times(json, frames);
  const LoadTimes& times = scene.load_times();
  json.key("load_ms").begin_object().field("read", times.read).field("context", times.context);
  json.field("generate", times.generate).field("upload", times.upload).end_object();
  json.field("triangles", mean_of(frames, [](const FrameRecord& f) { return f.counts.triangles; }));
  json.field("draw_calls", mean_of(frames, [](const FrameRecord& f) { return f.counts.draw_calls; }));
  write_patches(json, scene, frames);
  json.key("skips").begin_object();
  json.field("material", mean_of(frames, [](const FrameRecord& f) { return f.blend_skipped; }));
  json.field("cave", mean_of(frames, [](const FrameRecord& f) { return f.cave_skipped; }));
  json.field("cascades", mean_of(frames, [](const FrameRecord& f) { return f.cascades_skipped; }))
      .end_object();
  json.key("bytes").begin_object().field("cpu_budget", std::uint64_t{scene.budget().cpu_bytes()});
  json.field("cpu_used", std::uint64_t{scene.cpu_used()});
  json.field("gpu_budget", std::uint64_t{scene.budget().gpu_bytes()}).end_object();
  std::uint64_t heap_calls = 0;
  for (const FrameRecord& frame : frames) heap_calls += frame.heap_calls;
  json.field("heap_calls_after_init", heap_calls).field("gl_objects_after_init", frames.back().gl_objects);
  float bound_px = 0;
  for (const FrameRecord& frame : frames) bound_px = std::max(bound_px, frame.selection.lod.bound_px);
  json.key("error_px").begin_object().field("bound", double{bound_px}).end_object();
  write_flags(json, frames);
  json.end_object();
  return json.text();
}

}  // namespace karst::app
