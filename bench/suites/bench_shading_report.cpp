// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdio>
#include <limits>

#include "app/common/json_writer.h"
#include "bench/suites/bench_shading.h"
#include "etc2/etc2.h"

namespace karst::bench {
using namespace core;
using namespace app;
namespace {

const char* format_name(TextureFormat format) {
  return format == TextureFormat::etc2 ? "etc2" : "rgba8";
}

// The finest level of a layer, what its four channels stand for: of the far array 0..1, of the near one
// brightness, height and slopes.
Error read_layer(const core::World& world, TextureArray array, std::uint32_t layer,
                 std::vector<double>& texels) {
  const MaterialSet& set = world.materials();
  const TextureFormat format = texture_format(set.format, array);
  const std::uint32_t side = texture_side(set.side, array);
  std::vector<std::uint8_t> bytes(texture_image_bytes(set.format, set.side, array, 0)), codes;
  const Status status =
      world.read_textures(array, 0, layer, 1, std::as_writable_bytes(std::span<std::uint8_t>(bytes)));
  if (!status.ok()) return Error("textures", status);
  if (format == TextureFormat::etc2) {
    codes.resize(std::size_t{side} * side * 4);
    if (const Status decoded = etc2::decode_etc2(bytes, side, side, codes); !decoded.ok())
      return Error("textures", decoded);
  } else if (format == TextureFormat::rgba4) {
    for (std::size_t i = 0; i < bytes.size(); i += 2) {
      const unsigned texel = bytes[i] | unsigned{bytes[i + 1]} << 8;
      for (const unsigned shift : {12u, 8u, 4u, 0u})
        codes.push_back(static_cast<std::uint8_t>(texel >> shift & 15));
    }
  } else {
    codes = bytes;
  }
  const NearCodes near = near_codes(format);
  const Material& material = set.materials[layer];
  texels.clear();
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const int code = codes[i];
    const double span = i % 4 == 0 ? double{material.brightness_span} : double{material.slope_span};
    const bool plain = array == TextureArray::far || i % 4 == 1;
    texels.push_back(plain ? 1.0 * code / near.most : span * (code - near.middle) / near.steps);
  }
  return {};
}

struct SquaredErrors {
  double of[4] = {};  // sums by channel
  double texels = 0;

  // Of channels first..last together, the peak being 1.
  double psnr_db(int first, int last) const {
    double sum = 0;
    for (int c = first; c <= last; ++c) sum += of[c];
    if (sum == 0) return std::numeric_limits<double>::infinity();
    return 10 * std::log10(texels * (last - first + 1) / sum);
  }
};

Error compare_arrays(const core::World& on, const core::World& off, TextureArray array,
                     SquaredErrors& errors) {
  std::vector<double> a, b;
  for (std::uint32_t layer = 0; layer < on.materials().count; ++layer) {
    Error error = read_layer(on, array, layer, a);
    if (error.ok()) error = read_layer(off, array, layer, b);
    if (!error.ok()) return error;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double d = a[i] - b[i];
      errors.of[i % 4] += d * d;
    }
    errors.texels += static_cast<double>(a.size() / 4);
  }
  return {};
}

// Nanoseconds of a frame's milliseconds for each pixel of the picture.
double ns_a_pixel(const ShadingReport& report, double ms) {
  return ms * 1e6 / (static_cast<double>(report.width) * report.height);
}

void print_row(const ShadingReport& report, const ShadingComparison& row) {
  std::printf("%-12s %-10s %-8s %9.2f %9.2f %8.3f %8.3f %6d %9.4f\n", row.name.c_str(), row.on.c_str(),
              row.off.c_str(), ns_a_pixel(report, row.on_time.frame_ms),
              ns_a_pixel(report, row.off_time.frame_ms), row.ratio.frame_ms, row.ratio.cpu_ms,
              row.most_difference, row.mean_difference);
}

void write_way(JsonWriter& json, const ShadingReport& report, const char* key, const std::string& what,
               const ShadingTime& time, const std::vector<ShadingTime>& rounds) {
  json.key(key).begin_object().field("what", what);
  json.field("ns_a_pixel", ns_a_pixel(report, time.frame_ms));
  json.field("cpu_ns_a_pixel", ns_a_pixel(report, time.cpu_ms));
  json.key("frame_ms").begin_array();
  for (const ShadingTime& round : rounds) json.value(round.frame_ms);
  json.end_array().key("cpu_ms").begin_array();
  for (const ShadingTime& round : rounds) json.value(round.cpu_ms);
  json.end_array().end_object();
}

void write_rows(JsonWriter& json, const ShadingReport& report, const char* key,
                const std::vector<ShadingComparison>& rows) {
  json.key(key).begin_array();
  for (const ShadingComparison& row : rows) {
    json.begin_object().field("name", row.name);
    write_way(json, report, "on", row.on, row.on_time, row.on_rounds);
    write_way(json, report, "off", row.off, row.off_time, row.off_rounds);
    json.field("ratio", row.ratio.frame_ms).field("cpu_ratio", row.ratio.cpu_ms);
    json.field("difference_max", row.most_difference).field("difference_mean", row.mean_difference);
    json.end_object();
  }
  json.end_array();
}

}  // namespace

Error compare_textures(const core::World& on, const core::World& off, TextureComparison& result) {
  const MaterialSet& a = on.materials();
  const MaterialSet& b = off.materials();
  if (a.count == 0 || a.count != b.count || a.side != b.side)
    return "its materials are not as many or not of the same size";
  SquaredErrors far, near;
  Error error = compare_arrays(on, off, TextureArray::far, far);
  if (error.ok()) error = compare_arrays(on, off, TextureArray::near, near);
  if (!error.ok()) return error;
  result.made = true;
  result.on = format_name(a.format);
  result.off = format_name(b.format);
  result.on_bytes = texture_bytes(a);
  result.off_bytes = texture_bytes(b);
  result.albedo_db = far.psnr_db(0, 2);
  result.roughness_db = far.psnr_db(3, 3);
  result.brightness_db = near.psnr_db(0, 0);
  result.height_db = near.psnr_db(1, 1);
  result.slope_db = near.psnr_db(2, 3);
  return {};
}

void print_shading(const ShadingReport& report) {
  std::printf("%d x %d, %d views, medians of %d rounds; %s\n", report.width, report.height, report.views,
              report.rounds, report.renderer.c_str());
  std::printf("%-12s %-10s %-8s %9s %9s %8s %8s %6s %9s\n", "", "on", "off", "on ns/px", "off ns/px",
              "on/off", "cpu", "max", "mean");
  for (const auto* rows : {&report.skips, &report.flights, &report.features}) {
    for (const ShadingComparison& row : *rows) print_row(report, row);
  }
  std::printf(
      "ns/px: a frame's time, all of it, by the picture's pixels. cpu: on/off of all threads' time. max, "
      "mean:\n"
      "how far the pictures differ, of 255. all: all skips against none, over all views and by flight.\n");
  const TextureComparison& t = report.textures;
  if (!t.made) return;
  std::printf(
      "textures: %s %.0f KiB, %s %.0f KiB; PSNR in dB: albedo %.1f, roughness %.1f, brightness %.1f, "
      "height %.1f, slopes %.1f\n",
      t.on, static_cast<double>(t.on_bytes) / 1024, t.off, static_cast<double>(t.off_bytes) / 1024,
      t.albedo_db, t.roughness_db, t.brightness_db, t.height_db, t.slope_db);
}

std::string shading_json(const ShadingReport& report) {
  JsonWriter json;
  json.begin_object().key("size").begin_array().value(report.width).value(report.height).end_array();
  json.field("views", report.views).field("rounds", report.rounds).field("renderer", report.renderer);
  write_rows(json, report, "skips", report.skips);
  write_rows(json, report, "flights", report.flights);
  write_rows(json, report, "features", report.features);
  json.key("textures");
  const TextureComparison& t = report.textures;
  if (t.made) {
    json.begin_object().field("on", t.on).field("off", t.off);
    json.field("on_bytes", t.on_bytes).field("off_bytes", t.off_bytes);
    json.key("psnr_db").begin_object().field("albedo", t.albedo_db).field("roughness", t.roughness_db);
    json.field("brightness", t.brightness_db).field("height", t.height_db);
    json.field("slope", t.slope_db).end_object().end_object();
  } else {
    json.null();
  }
  json.end_object();
  return json.text();
}

}  // namespace karst::bench
