// SPDX-License-Identifier: MIT
#include "bake/pipeline/report.h"

#include "app/common/json_writer.h"
#include "bake/base/print_text.h"

#include <algorithm>
#include <cmath>

namespace karst::bake {
namespace {

void write_fit(app::JsonWriter& json, const Bake::Report& report) {
  if (!report.fit) {
    json.key("fit_m").null();
    return;
  }
  const MeasureFit::Result& fit = *report.fit;
  json.key("fit_m").begin_object();
  json.field("rms", fit.rms_m).field("p999", fit.p999_m).field("max", fit.max_m).end_object();
  json.key("coverage").begin_object();
  json.field("points", fit.points).field("point_spacing_m", fit.point_spacing_m).field("holes", fit.holes);
  json.field("folded", fit.folded).field("partial", report.fit_is_partial);
  json.key("area");
  if (report.fit_is_partial) {
    json.null();
  } else {
    json.value(fit.covered_area);
  }
  json.end_object();
}

// Bytes of the same textures in another format.
std::size_t bytes_as(MaterialSet set, TextureFormat format) {
  set.format = format;
  return texture_bytes(set);
}

// Of a height that is stored in voxels.
double metres(const WorldInfo& info, float voxels) {
  return info.origin_m[1] + info.voxel_size_m * double{voxels};
}

void print_water(std::string& out, const Bake::Report& report) {
  if (!report.surroundings.has_water()) return;
  print(out, "water         up to %.6g m; %zu samples sunk to a bed\n",
        metres(report.info, report.surroundings.water_level), report.sunk_samples);
}

void write_water(app::JsonWriter& json, const Bake::Report& report) {
  if (!report.surroundings.has_water()) {
    json.key("water").null();
    return;
  }
  json.key("water").begin_object();
  json.field("level_m", metres(report.info, report.surroundings.water_level));
  json.field("samples_sunk", std::uint64_t{report.sunk_samples}).end_object();
}

void print_materials(std::string& out, const BakedMaterials& materials) {
  const MaterialSet& set = materials.set;
  if (set.count == 0) return;
  print(out, "materials     ");
  for (std::uint32_t k = 0; k < set.count; ++k) print(out, "%s%s", k == 0 ? "" : ", ", set.materials[k].name);
  print(out, "; %u x %u texels, %zu patches painted, %zu lights\n", set.side, set.side, materials.painted,
        materials.lights.size());
  if (set.blend_map.exists()) {
    print(out, "blend map     %u x %u texels, %zu patches under it\n", set.blend_map.width,
          set.blend_map.depth, materials.under_map);
  }
  if (set.format != TextureFormat::etc2) {
    print(out, "textures      %zu bytes, not compressed\n", materials.textures.size());
    return;
  }
  const TextureLoss& loss = materials.loss;
  print(out, "textures      %zu bytes for %zu; far: albedo %.1f dB, roughness %.1f dB; ",
        materials.textures.size(), bytes_as(set, TextureFormat::rgba8), loss.albedo_db, loss.roughness_db);
  print(out, "near: brightness %.1f dB, height %.1f dB, normals %.2f degrees rms\n", loss.brightness_db,
        loss.height_db, loss.normal_degrees);
}

// A PSNR is infinite where nothing changed.
void write_decibels(app::JsonWriter& json, const char* name, double decibels) {
  if (std::isfinite(decibels)) {
    json.field(name, decibels);
  } else {
    json.key(name).null();
  }
}

void write_materials(app::JsonWriter& json, const BakedMaterials& materials) {
  const MaterialSet& set = materials.set;
  if (set.count == 0) {
    json.key("materials").null();
    return;
  }
  json.key("materials").begin_object();
  json.key("names").begin_array();
  for (std::uint32_t k = 0; k < set.count; ++k) json.value(std::string_view(set.materials[k].name));
  json.end_array();
  json.field("side", std::uint64_t{set.side});
  json.field("format", set.format == TextureFormat::etc2 ? "etc2" : "rgba8");
  json.field("bytes", std::uint64_t{materials.textures.size()});
  json.field("bytes_etc2", std::uint64_t{bytes_as(set, TextureFormat::etc2)});
  json.field("bytes_rgba8", std::uint64_t{bytes_as(set, TextureFormat::rgba8)});
  json.key("psnr_db").begin_object();
  write_decibels(json, "albedo", materials.loss.albedo_db);
  write_decibels(json, "roughness", materials.loss.roughness_db);
  write_decibels(json, "brightness", materials.loss.brightness_db);
  write_decibels(json, "height", materials.loss.height_db);
  json.end_object();
  json.field("normal_rms_degrees", materials.loss.normal_degrees);
  json.field("patches_painted", std::uint64_t{materials.painted});
  json.key("blend_map").begin_object();
  json.field("width", std::uint64_t{set.blend_map.width}).field("depth", std::uint64_t{set.blend_map.depth});
  json.field("patches", std::uint64_t{materials.under_map}).end_object();
  json.field("lights", std::uint64_t{materials.lights.size()}).end_object();
}

}  // namespace

std::string report_text(const Bake& job, const Bake::Report& report, std::size_t bytes, double seconds) {
  std::string out;
  const WorldInfo& info = report.info;
  if (job.sample.empty()) {
    print(out, "input         %s, %d x %d samples of %.6g x %.6g m, %.3f %% void%s\n", report.source.c_str(),
          report.width, report.height, report.spacing_x_m, report.spacing_z_m, 100 * report.void_share,
          report.void_share > 0 ? (job.leave_holes ? " (left out)" : " (filled)") : "");
    print(out, "heights       %.6g to %.6g m, over %.6g x %.6g m\n", report.lowest_m, report.highest_m,
          report.spacing_x_m * (report.width - 1), report.spacing_z_m * (report.height - 1));
  } else {
    print(out, "input         sample %s\n", job.sample.c_str());
  }
  if (report.carve_shapes > 0) print(out, "carved        %zu shapes\n", report.carve_shapes);
  print(out, "world         %d x %d x %d voxels of %.6g m, minimum corner at %.6g, %.6g, %.6g m\n",
        info.extent.x, info.extent.y, info.extent.z, info.voxel_size_m, info.origin_m[0], info.origin_m[1],
        info.origin_m[2]);
  print(out, "voxels        %llu filled, %u octets\n", number(report.filled_voxels), info.octets);
  print(out, "patches       %u in %u volumes, level %d\n", info.patches, info.volumes, info.level);
  print(out, "fitted        %llu heights, %llu without a surface in reach; folds: %llu repaired, %llu left\n",
        number(report.vertices), number(report.misses), number(report.folds_repaired),
        number(report.folds_left));
  if (report.fit) {
    const MeasureFit::Result& fit = *report.fit;
    print(out, "fit           rms %.3f m, p99.9 %.3f m, max %.3f m at %llu points%s\n", fit.rms_m, fit.p999_m,
          fit.max_m, number(fit.points), report.fit_is_partial ? " (without holes and carved places)" : "");
    print(out, "coverage      %llu points in holes, %llu folded triangles\n", number(fit.holes),
          number(fit.folded));
  }
  print_water(out, report);
  print_materials(out, report.materials);
  print(out, "quantisation  %.6g m\n", report.quantisation_m);
  print(
      out,
      "written       %zu bytes in %.2f s (read %.2f, voxels %.2f, heights %.2f, measure %.2f, world %.2f)\n",
      bytes, seconds, report.seconds_read, report.seconds_voxels, report.seconds_fit, report.seconds_measure,
      report.seconds_write);
  return out;
}

std::string report_json(const Bake& job, const Bake::Report& report, std::size_t bytes, double seconds) {
  app::JsonWriter json;
  const WorldInfo& info = report.info;
  json.begin_object();
  json.key("input").begin_object();
  if (job.sample.empty()) {
    json.field("path", std::string_view(job.read.path)).field("kind", std::string_view(report.source));
    json.key("size").begin_array().value(report.width).value(report.height).end_array();
    json.key("spacing_m").begin_array().value(report.spacing_x_m).value(report.spacing_z_m).end_array();
    json.key("size_m").begin_array().value(report.spacing_x_m * (report.width - 1));
    json.value(report.spacing_z_m * (report.height - 1)).end_array();
    json.key("height_range_m").begin_array().value(report.lowest_m).value(report.highest_m).end_array();
    json.field("void_share", report.void_share).field("voids", job.leave_holes ? "hole" : "fill");
  } else {
    json.field("sample", std::string_view(job.sample));
  }
  json.field("carve_shapes", std::uint64_t{report.carve_shapes}).end_object();
  json.key("world").begin_object();
  json.field("name", info.name).field("voxel_m", info.voxel_size_m);
  json.key("origin_m").begin_array();
  for (const double x : info.origin_m) json.value(x);
  json.end_array().key("extent").begin_array();
  json.value(info.extent.x).value(info.extent.y).value(info.extent.z).end_array();
  json.field("depth", info.depth).field("level", info.level).field("octets", info.octets).end_object();
  json.field("voxels", report.filled_voxels).field("volumes", info.volumes).field("patches", info.patches);
  json.field("heights", report.vertices).field("heights_without_surface", report.misses);
  json.field("voxels_settled", report.voxels_settled);
  json.field("folds_repaired", report.folds_repaired).field("folds_left", report.folds_left);
  write_fit(json, report);
  write_water(json, report);
  write_materials(json, report.materials);
  json.field("quantisation_m", report.quantisation_m);
  json.field("bytes", std::uint64_t{bytes}).field("seconds", seconds);
  json.key("stage_seconds").begin_object();
  json.field("read", report.seconds_read).field("voxels", report.seconds_voxels);
  json.field("heights", report.seconds_fit).field("measure", report.seconds_measure);
  json.field("world", report.seconds_write).end_object();
  json.end_object();
  return json.text();
}

}  // namespace karst::bake
