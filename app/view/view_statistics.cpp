// SPDX-License-Identifier: MIT
#include "app/view/view_statistics.h"

#include <sys/resource.h>

#include "app/common/json_writer.h"
#include "app/stage/resource_counts.h"

namespace karst::app {
namespace {

void write_series(JsonWriter& json, const char* name, const Series& series) {
  json.key(name).begin_object().field("median", series.percentile(0.5)).field("p99", series.percentile(0.99));
  json.field("max", series.most()).end_object();
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

}  // namespace

std::string ViewStatistics::json(const Display& display, const Stage& stage, const PoseLines& poses,
                                 const Series& edit_ms) const {
  const FrameTimes& times = display.times();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  JsonWriter json;
  json.begin_object();
  json.field("frames", frames());
  json.key("size").begin_array().value(stage.width()).value(stage.height()).end_array();
  json.key("renderer");
  if (stage.attached()) {
    json.value(device_info(stage.renderer()).renderer);
  } else {
    json.null();
  }
  json.field("display", std::string_view(display.name()));
  json.field("refresh_ms", static_cast<double>(display.refresh_ns()) * 1e-6);
  write_series(json, "draw_ms", draw_ms_);
  write_series(json, "present_ms", present_ms_);
  write_series(json, "latency_ms", times.latency_ms());
  json.field("missed_flips", times.missed()).field("lost_flips", times.lost());
  json.field("modes_set", times.modes_set()).field("recoveries", times.recovery_ms().count());
  write_series(json, "recovery_ms", times.recovery_ms());
  json.field("cpu_s", seconds(usage.ru_utime) + seconds(usage.ru_stime));
  json.key("poses")
      .begin_object()
      .field("taken", poses.poses())
      .field("malformed", poses.malformed())
      .end_object();
  json.field("edits", edit_ms.count());
  write_series(json, "edit_ms", edit_ms);
  // What must not grow in months.
  json.field("descriptors", open_descriptors()).field("gl_objects", gl_objects_alive());
  json.key("bytes").begin_object();
  json.field("cpu_budget", stage.cpu_bytes());
  json.field("gpu_budget", stage.gpu_bytes()).field("gpu_used", stage.gpu_used()).end_object();
  json.end_object();
  return json.text();
}

}  // namespace karst::app
