// SPDX-License-Identifier: MIT
#include "bench/frames/flight_times.h"

#include <cmath>
#include <cstdio>
#include <iterator>
#include <vector>

#include "app/common/arguments.h"
#include "app/common/json_writer.h"
#include "app/common/progress.h"
#include "app/files/atomic_file.h"
#include "bench/frames/bench_view.h"
#include "bench/measure/gl_times.h"

namespace karst::bench {
using namespace app;
namespace {

constexpr std::string_view kFlights[] = {"low", "oblique", "high"};

// Milliseconds; NaN where nothing was measured.
struct Times {
  double median = 0, p95 = 0, most = 0;
};

struct FlightTimes {
  std::string_view name;
  Times frame, cpu, gpu;  // cpu: of all threads; gpu: of the picture's passes, shadow maps aside
  Times select, generate, upload, submit, shadow;  // FrameCosts
  double triangles = 0, draw_calls = 0;            // means
  double generated = 0, uploaded_bytes = 0;        // means
  std::vector<GlCallTimes> gl;                     // a frame, where asked for
};

template <class Get>
Times times_of(const std::vector<BenchFrame>& frames, Get get) {
  std::vector<double> ms;
  for (const BenchFrame& frame : frames) {
    if (std::isfinite(get(frame))) ms.push_back(get(frame));
  }
  return {median(ms), percentile(ms, 0.95), percentile(ms, 1)};
}

FlightTimes summary_of(std::string_view name, const std::vector<BenchFrame>& frames) {
  FlightTimes f;
  f.name = name;
  f.frame = times_of(frames, [](const BenchFrame& b) { return b.record.frame_ms; });
  f.cpu = times_of(frames, [](const BenchFrame& b) { return b.all_cpu_ms; });
  f.gpu = times_of(frames, [](const BenchFrame& b) { return b.record.costs.gpu_terrain_ms; });
  f.select = times_of(frames, [](const BenchFrame& b) { return b.record.costs.select_ms; });
  f.generate = times_of(frames, [](const BenchFrame& b) { return b.record.costs.generate_ms; });
  f.upload = times_of(frames, [](const BenchFrame& b) { return b.record.costs.upload_ms; });
  f.submit = times_of(frames, [](const BenchFrame& b) { return b.record.costs.submit_ms; });
  f.shadow = times_of(frames, [](const BenchFrame& b) { return b.record.costs.shadow_ms; });
  for (const BenchFrame& frame : frames) {
    f.generated += frame.record.costs.generated / static_cast<double>(frames.size());
    f.uploaded_bytes +=
        static_cast<double>(frame.record.costs.uploaded_bytes) / static_cast<double>(frames.size());
    f.triangles += static_cast<double>(frame.record.costs.triangles) / static_cast<double>(frames.size());
    f.draw_calls += frame.record.costs.draw_calls / static_cast<double>(frames.size());
  }
  return f;
}

Error fly(BenchView& view, std::string_view name, int frames, FlightTimes& flight) {
  std::vector<ViewState> cameras;
  const auto path = make_standard_path(name, view.ground(), view.terrain().box(), frames);
  if (Error error = view.place(path, cameras); !error.ok()) return error;
  std::vector<BenchFrame> first, second;
  for (std::vector<BenchFrame>* lap : {&first, &second}) {
    reset_gl_times();
    for (const ViewState& camera : cameras) {
      if (Error error = view.draw(camera, view.levels(), lap->emplace_back()); !error.ok()) return error;
    }
  }
  flight = summary_of(name, second);
  flight.gl = gl_times();
  return {};
}

void write_times(JsonWriter& json, const char* name, const Times& times) {
  json.key(name);
  if (std::isnan(times.median)) {
    json.null();
    return;
  }
  json.begin_object().field("median", times.median).field("p95", times.p95).field("max", times.most);
  json.end_object();
}

// Means of a frame.
void write_gl(JsonWriter& json, const FlightTimesOptions& options, const std::vector<GlCallTimes>& times) {
  json.key("gl").begin_array();
  for (const GlCallTimes& time : times) {
    json.begin_object().field("function", time.name);
    json.field("calls", static_cast<double>(time.calls) / options.frames);
    json.field("ms", time.ms / options.frames).end_object();
  }
  json.end_array();
}

void print_gl(const FlightTimesOptions& options, const FlightTimes& flight) {
  std::printf("GL functions a frame of %s, by the clock:\n", std::string(flight.name).c_str());
  for (const GlCallTimes& time : flight.gl) {
    if (time.ms / options.frames < 0.001) break;
    std::printf("  %-24s %9.1f calls %9.3f ms\n", time.name, static_cast<double>(time.calls) / options.frames,
                time.ms / options.frames);
  }
}

std::string json_text(const FlightTimesOptions& options, BenchView& view,
                      const std::vector<FlightTimes>& flights) {
  const Stage& stage = view.stage();
  const DeviceInfo device = device_info(stage.renderer());
  JsonWriter json;
  json.begin_object().field("world", stage.world().info().name).field("renderer", device.renderer);
  json.field("driver", device.version).key("size").begin_array();
  json.value(options.look.width).value(options.look.height).end_array().field("frames", options.frames);
  json.field("first_frame_ms", view.first_frame_ms()).key("flights").begin_array();
  for (const FlightTimes& f : flights) {
    json.begin_object().field("name", f.name);
    write_times(json, "frame_ms", f.frame);
    write_times(json, "cpu_ms", f.cpu);
    write_times(json, "gpu_ms", f.gpu);
    write_times(json, "select_ms", f.select);
    write_times(json, "generate_ms", f.generate);
    write_times(json, "upload_ms", f.upload);
    write_times(json, "submit_ms", f.submit);
    write_times(json, "shadow_ms", f.shadow);
    json.field("triangles", f.triangles).field("draw_calls", f.draw_calls).field("generated", f.generated);
    json.field("uploaded_bytes", f.uploaded_bytes);
    if (options.gl_times) write_gl(json, options, f.gl);
    json.end_object();
  }
  json.end_array().key("bytes").begin_object();
  json.field("cpu_budget", stage.cpu_bytes()).field("cpu_used", device.cpu_bytes);
  json.field("gpu_budget", stage.gpu_bytes()).field("gpu_used", stage.gpu_used());
  json.field("process_peak", peak_resident_bytes()).end_object().end_object();
  return json.text();
}

void print_text(const FlightTimesOptions& options, BenchView& view, const std::vector<FlightTimes>& flights) {
  const DeviceInfo device = device_info(view.stage().renderer());
  std::printf("%s, %d x %d, %d frames a flight\n", device.renderer, options.look.width, options.look.height,
              options.frames);
  std::printf("%-8s %9s %9s %9s %9s %9s %10s\n", "flight", "frame ms", "p95", "GPU ms", "p95", "CPU ms",
              "triangles");
  for (const FlightTimes& f : flights) {
    std::printf("%-8s %9.2f %9.2f %9.2f %9.2f %9.2f %10.0f\n", std::string(f.name).c_str(), f.frame.median,
                f.frame.p95, f.gpu.median, f.gpu.p95, f.cpu.median, f.triangles);
  }
  std::printf("\n%-8s %9s %9s %9s %9s %9s %10s %10s\n", "", "select ms", "generate", "upload", "submit",
              "shadow", "generated", "KiB up");
  for (const FlightTimes& f : flights) {
    std::printf("%-8s %9.3f %9.3f %9.3f %9.3f %9.3f %10.0f %10.0f\n", std::string(f.name).c_str(),
                f.select.median, f.generate.median, f.upload.median, f.submit.median, f.shadow.median,
                f.generated, f.uploaded_bytes / 1024);
  }
  if (options.gl_times) {
    for (const FlightTimes& f : flights) print_gl(options, f);
  }
  std::printf("CPU: of all threads. GPU memory: %.2f MiB\n",
              static_cast<double>(view.stage().gpu_used()) / (1 << 20));
}

Error run_suite(const FlightTimesOptions& options) {
  BenchView view;
  if (Error error = view.open_timed(options.world, options.look, options.gl_times); !error.ok()) return error;
  std::vector<FlightTimes> flights;
  Progress progress("flying", std::size(kFlights));
  for (const std::string_view name : kFlights) {
    if (Error error = fly(view, name, options.frames, flights.emplace_back()); !error.ok()) return error;
    progress.update(flights.size());
  }
  progress.finish();
  const std::string text = json_text(options, view, flights);
  if (options.json == "-") {
    std::fputs(text.c_str(), stdout);
    return {};
  }
  print_text(options, view, flights);
  return options.json.empty() ? Error() : write_file_atomic(options.json, std::as_bytes(std::span(text)));
}

}  // namespace

int run_flight_times(const FlightTimesOptions& options) {
  if (const Error error = run_suite(options); !error.ok()) {
    print_error("karst-bench", error.text());
    return kExitFailure;
  }
  return kExitOk;
}

}  // namespace karst::bench
