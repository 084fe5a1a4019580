// SPDX-License-Identifier: MIT
#include "app/stage/frame_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/common/json_writer.h"

namespace karst::app {
namespace {

template <class Get>
double median_of(const std::vector<FrameRecord>& frames, Get get) {
  std::vector<double> values;
  values.reserve(frames.size());
  for (const FrameRecord& frame : frames) {
    const double value = static_cast<double>(get(frame));
    if (std::isfinite(value)) values.push_back(value);
  }
  return median(values);
}

template <class Get>
double mean_of(const std::vector<FrameRecord>& frames, Get get) {
  double sum = 0;
  for (const FrameRecord& frame : frames) sum += static_cast<double>(get(frame));
  return sum / static_cast<double>(frames.size());
}

void write_times(JsonWriter& json, const std::vector<FrameRecord>& frames) {
  std::vector<double> ms;
  for (const FrameRecord& frame : frames) ms.push_back(frame.frame_ms);
  json.key("frame_ms").begin_object();
  json.field("median", median(ms))
      .field("p99", percentile(ms, 0.99))
      .field("max", percentile(ms, 1.0))
      .end_object();
  json.key("cpu_ms").begin_object();
  json.field("cull_lod", median_of(frames, [](const FrameRecord& f) { return f.costs.select_ms; }));
  json.field("generate", median_of(frames, [](const FrameRecord& f) { return f.costs.generate_ms; }));
  json.field("upload", median_of(frames, [](const FrameRecord& f) { return f.costs.upload_ms; }));
  json.field("submit", median_of(frames, [](const FrameRecord& f) { return f.costs.submit_ms; }));
  json.end_object();
  json.key("gpu_ms").begin_object();
  json.field("shadow", median_of(frames, [](const FrameRecord& f) { return f.costs.gpu_shadow_ms; }));
  json.field("terrain", median_of(frames, [](const FrameRecord& f) { return f.costs.gpu_terrain_ms; }));
  json.end_object();
}

void write_patches(JsonWriter& json, const WorldInfo& world, const std::vector<FrameRecord>& frames) {
  const auto mean = [&](const char* name, auto FrameCosts::*member) {
    json.field(name, mean_of(frames, [member](const FrameRecord& f) { return f.costs.*member; }));
  };
  json.key("patches").begin_object();
  json.field("total", world.patches).field("resident", frames.back().costs.resident);
  mean("drawn", &FrameCosts::patches_drawn);
  mean("culled_frustum", &FrameCosts::culled_frustum);
  mean("culled_backface", &FrameCosts::culled_backface);
  mean("culled_occluded", &FrameCosts::culled_occluded);
  mean("coarser_than_wanted", &FrameCosts::patches_capped);
  mean("missing", &FrameCosts::patches_missing);
  mean("wanted_pages", &FrameCosts::wanted_pages);
  mean("error_scale", &FrameCosts::error_scale);
  mean("generated", &FrameCosts::generated);
  json.key("at_level").begin_array();
  for (int level = 1; level <= world.level; ++level) {
    json.value(mean_of(frames, [level](const FrameRecord& f) { return f.costs.at_level[level]; }));
  }
  json.end_array().end_object();
}

void write_tiles(JsonWriter& json, const std::vector<FrameRecord>& frames) {
  std::uint64_t asked = 0, used = 0, wasted = 0;
  std::uint32_t below = 0;
  for (const FrameRecord& frame : frames) {
    asked += frame.costs.ahead_asked;
    used += frame.costs.ahead_used;
    wasted += frame.costs.ahead_wasted;
    below = std::max(below, frame.costs.sizes_left_out);
  }
  json.key("tiles").begin_object();
  json.field("ahead_asked", asked).field("ahead_used", used).field("ahead_wasted", wasted);
  json.field("left_out", mean_of(frames, [](const FrameRecord& f) { return f.costs.left_out; }));
  json.field("below_size", std::uint64_t{below}).end_object();
}

void write_flags(JsonWriter& json, const std::vector<FrameRecord>& frames) {
  std::uint32_t flags = 0;
  for (const FrameRecord& frame : frames) flags |= frame.result.limits;
  json.key("flags").begin_array();
  if ((flags & kLimitDrawItems) != 0) json.value("max_draw_items");
  if ((flags & kLimitVertexMemory) != 0) json.value("gpu_vertex_pages");
  if ((flags & kLimitWork) != 0) json.value("generate_ms");
  if ((flags & kLimitFile) != 0) json.value("file");
  if ((flags & kLimitTiles) != 0) json.value("ground_tiles");
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

std::string statistics_json(const Stage& stage, const std::vector<FrameRecord>& frames, double lookups) {
  const DeviceInfo device = device_info(stage.renderer());
  JsonWriter json;
  json.begin_object();
  json.field("frames", std::uint64_t{frames.size()});
  json.key("size").begin_array().value(stage.width()).value(stage.height()).end_array();
  json.field("renderer", device.renderer);
  json.field("driver", device.version);
  json.key("shading").begin_object().field("way", device.deferred ? "deferred" : "forward");
  json.field("precision", device.high_precision ? "high" : "medium");
  json.field("anisotropy", std::uint64_t{device.anisotropy});
  json.field("lookups_per_pixel", lookups).end_object();
  write_times(json, frames);
  const LoadTimes& times = stage.load_times();
  json.key("load_ms").begin_object().field("read", times.read).field("context", times.context);
  json.field("generate", times.generate).field("upload", times.upload).end_object();
  json.field("triangles", mean_of(frames, [](const FrameRecord& f) { return f.costs.triangles; }));
  json.field("draw_calls", mean_of(frames, [](const FrameRecord& f) { return f.costs.draw_calls; }));
  write_patches(json, stage.world().info(), frames);
  write_tiles(json, frames);
  json.key("skips").begin_object();
  json.field("material", mean_of(frames, [](const FrameRecord& f) { return f.costs.blend_skipped; }));
  json.field("cave", mean_of(frames, [](const FrameRecord& f) { return f.costs.cave_skipped; }));
  json.field("cascades", mean_of(frames, [](const FrameRecord& f) { return f.costs.cascades_skipped; }));
  json.end_object();
  json.key("bytes").begin_object().field("cpu_budget", stage.cpu_bytes()).field("cpu_used", device.cpu_bytes);
  json.field("gpu_budget", stage.gpu_bytes()).field("gpu_used", stage.gpu_used());
  json.field("uploaded", mean_of(frames, [](const FrameRecord& f) { return f.costs.uploaded_bytes; }));
  json.end_object();
  std::uint64_t heap_calls = 0;
  for (const FrameRecord& frame : frames) heap_calls += frame.heap_calls;
  json.field("heap_calls_after_init", heap_calls).field("gl_objects_after_init", frames.back().gl_objects);
  double bound_px = 0;
  for (const FrameRecord& frame : frames) bound_px = std::max(bound_px, frame.result.error_px[0]);
  json.key("error_px").begin_object().field("bound", bound_px).end_object();
  write_flags(json, frames);
  json.end_object();
  return json.text();
}

}  // namespace karst::app
