// SPDX-License-Identifier: MIT
// What the pareto suite found: as a table, CSV, JSON and a plot.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <limits>

#include "app/common/json_writer.h"
#include "bench/plots/plot_svg.h"
#include "bench/suites/bench_pareto.h"
#include "platform/base/text.h"

namespace karst::bench {
using namespace app;
namespace {

struct Column {
  const char* name;
  double (*get)(const ParetoRow& row);
};
constexpr Column kColumns[] = {
    {"target", [](const ParetoRow& r) { return r.target; }},
    {"frame_median_ms", [](const ParetoRow& r) { return r.frame_median_ms; }},
    {"frame_p99_ms", [](const ParetoRow& r) { return r.frame_p99_ms; }},
    {"main_cpu_ms", [](const ParetoRow& r) { return r.main_cpu_ms; }},
    {"all_cpu_ms", [](const ParetoRow& r) { return r.all_cpu_ms; }},
    {"cull_lod_ms", [](const ParetoRow& r) { return r.cull_lod_ms; }},
    {"generate_ms", [](const ParetoRow& r) { return r.generate_ms; }},
    {"upload_ms", [](const ParetoRow& r) { return r.upload_ms; }},
    {"submit_ms", [](const ParetoRow& r) { return r.submit_ms; }},
    {"triangles", [](const ParetoRow& r) { return r.triangles; }},
    {"most_triangles", [](const ParetoRow& r) { return r.most_triangles; }},
    {"draw_calls", [](const ParetoRow& r) { return r.draw_calls; }},
    {"working_set_mib", [](const ParetoRow& r) { return r.working_set_mib; }},
    {"resident_mib", [](const ParetoRow& r) { return r.resident_mib; }},
    {"bound_px", [](const ParetoRow& r) { return r.bound_px; }},
    {"error_pixels", [](const ParetoRow& r) { return static_cast<double>(r.errors.pixels); }},
    {"error_mean_px", [](const ParetoRow& r) { return r.errors.mean; }},
    {"error_rms_px", [](const ParetoRow& r) { return r.errors.rms; }},
    {"error_p50_px", [](const ParetoRow& r) { return r.errors.p50; }},
    {"error_p95_px", [](const ParetoRow& r) { return r.errors.p95; }},
    {"error_p99_px", [](const ParetoRow& r) { return r.errors.p99; }},
    {"error_p999_px", [](const ParetoRow& r) { return r.errors.p999; }},
    {"error_max_px", [](const ParetoRow& r) { return r.errors.max; }},
    {"colour_difference", [](const ParetoRow& r) { return r.colour_difference; }},
};

__attribute__((format(printf, 2, 3))) void append(std::string& text, const char* format, ...) {
  char buffer[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  text += buffer;
}

// --- The plot.

// What a panel shows upwards, by our columns and the peers'.
struct Quantity {
  const char* label;
  const char* ours;
  const char* peers;  // column of the peers' file; nullptr: they have none
};
constexpr Quantity kUp[] = {{"frame, median ms", "frame_median_ms", "frame_median_ms"},
                            {"triangles a frame", "triangles", "triangles"},
                            {"GPU bytes that a frame uses, MiB", "working_set_mib", nullptr},
                            {"process, MiB", "resident_mib", "resident_mib"}};
constexpr Quantity kAcross[] = {{"RMS error, px", "error_rms_px", "error_rms_px"},
                                {"p99 error, px", "error_p99_px", "error_p99_px"},
                                {"maximum error, px", "error_max_px", "error_max_px"}};

double value_of(const ParetoRow& row, std::string_view name) {
  for (const Column& column : kColumns) {
    if (name == column.name) return column.get(row);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

struct PeerTable {
  std::vector<std::string_view> names;
  std::vector<std::vector<std::string_view>> rows;

  Error read(std::string_view text) {
    while (!text.empty()) {
      const std::size_t end = text.find('\n');
      std::string_view line = text.substr(0, end);
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
      if (line.empty() || line.front() == '#') continue;
      if (names.empty()) {
        names = split(line);
      } else if (split(line).size() != names.size()) {
        return "a line has not as many values as the first: " + quote(line);
      } else {
        rows.push_back(split(line));
      }
    }
    const bool peer = !names.empty() && names.front() == "peer";
    return rows.empty() || peer ? std::string() : "the first column is not 'peer'";
  }
  // NaN where there is no number.
  double value(std::size_t row, std::string_view name) const {
    const auto it = std::find(names.begin(), names.end(), name);
    double number = std::numeric_limits<double>::quiet_NaN();
    if (it == names.end()) return number;
    const std::string_view text = rows[row][static_cast<std::size_t>(it - names.begin())];
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
  }
};

std::vector<PlotSeries> our_series(const ParetoResult& result, const Quantity& across, const Quantity& up) {
  std::vector<PlotSeries> all;
  std::vector<std::string> paths;
  for (const ParetoRow& row : result.rows) {
    if (std::find(paths.begin(), paths.end(), row.path) == paths.end()) paths.push_back(row.path);
    const std::string label = row.path + (row.mode == "distance" ? ", by distance (K)"
                                          : row.mode == "full"   ? ", full level"
                                                                 : ", by error");
    auto it = std::find_if(all.begin(), all.end(), [&](const PlotSeries& s) { return s.label == label; });
    if (it == all.end()) {
      it = all.insert(all.end(), PlotSeries{});
      it->label = label;
      it->colour = static_cast<int>(std::find(paths.begin(), paths.end(), row.path) - paths.begin());
      it->dashed = row.mode == "distance";
      it->marker = it->dashed ? 1 : 0;
    }
    it->points.push_back({value_of(row, across.ours), value_of(row, up.ours)});
  }
  return all;
}

void add_peers(const PeerTable& peers, const Quantity& across, const Quantity& up,
               std::vector<PlotSeries>& all) {
  if (up.peers == nullptr) return;
  std::vector<std::string> names;
  for (std::size_t r = 0; r < peers.rows.size(); ++r) {
    const std::string name(peers.rows[r][0]);
    auto known = std::find(names.begin(), names.end(), name);
    if (known == names.end()) known = names.insert(names.end(), name);
    auto it = std::find_if(all.begin(), all.end(), [&](const PlotSeries& s) { return s.label == name; });
    if (it == all.end()) {
      it = all.insert(all.end(), PlotSeries{});
      it->label = name;
      const auto n = static_cast<int>(known - names.begin());
      it->colour = 1 + n % (kPlotColours - 1);
      it->line = false;
      it->marker = 2 + n % 2;
    }
    it->points.push_back({peers.value(r, across.peers), peers.value(r, up.peers)});
  }
}

}  // namespace

std::string pareto_csv(const ParetoResult& result) {
  std::string csv = "path,mode";
  for (const Column& column : kColumns) csv += std::string(",") + column.name;
  csv += '\n';
  for (const ParetoRow& row : result.rows) {
    csv += row.path + "," + row.mode;
    for (const Column& column : kColumns) {
      const double value = column.get(row);
      csv += ',';
      if (std::isfinite(value)) append(csv, "%.6g", value);
    }
    csv += '\n';
  }
  return csv;
}

std::string pareto_json(const ParetoResult& result) {
  JsonWriter json;
  json.begin_object().field("world", result.world).field("renderer", result.renderer);
  json.key("size").begin_array().value(result.width).value(result.height).end_array();
  json.field("first_frame_ms", result.first_frame_ms).field("peak_resident_mib", result.peak_resident_mib);
  json.key("settings").begin_array();
  for (const ParetoRow& row : result.rows) {
    json.begin_object().field("path", row.path).field("mode", row.mode);
    for (const Column& column : kColumns) json.field(column.name, column.get(row));
    json.end_object();
  }
  json.end_array().end_object();
  return json.text();
}

std::string pareto_text(const ParetoResult& result) {
  std::string text;
  append(text, "%s, %d x %d, first frame after %.0f ms, at most %.0f MiB resident\n", result.renderer.c_str(),
         result.width, result.height, result.first_frame_ms, result.peak_resident_mib);
  append(text, "%-10s %-9s %6s | %8s %8s %8s %8s | %9s %5s %8s %8s | %6s %7s %7s %7s %7s %6s\n", "path",
         "mode", "target", "frame ms", "p99", "main cpu", "cull lod", "triangles", "draws", "used MiB",
         "RSS MiB", "bound", "mean px", "rms", "p99", "max", "colour");
  for (const ParetoRow& row : result.rows) {
    append(
        text,
        "%-10s %-9s %6g | %8.2f %8.2f %8.2f %8.3f | %9.0f %5.1f %8.1f %8.1f | %6.2f %7.3f %7.3f %7.2f %7.2f "
        "%6.3f\n",
        row.path.c_str(), row.mode.c_str(), row.target, row.frame_median_ms, row.frame_p99_ms,
        row.main_cpu_ms, row.cull_lod_ms, row.triangles, row.draw_calls, row.working_set_mib,
        row.resident_mib, row.bound_px, row.errors.mean, row.errors.rms, row.errors.p99, row.errors.max,
        row.colour_difference);
  }
  return text;
}

Error pareto_svg(const ParetoResult& result, std::string_view peers_csv, std::string& svg) {
  PeerTable peers;
  if (Error error = peers.read(peers_csv); !error.ok()) return error;
  std::vector<PlotPanel> panels;
  for (const Quantity& up : kUp) {
    for (const Quantity& across : kAcross) {
      PlotPanel& panel = panels.emplace_back();
      panel.x_label = across.label;
      panel.y_label = up.label;
      panel.series = our_series(result, across, up);
      add_peers(peers, across, up, panel.series);
    }
  }
  std::string title;
  append(title, "%s: run time, triangles and memory against error, %d x %d, %s", result.world.c_str(),
         result.width, result.height, result.renderer.c_str());
  svg = plot_svg(title, panels, 3);
  return {};
}

}  // namespace karst::bench
