// SPDX-License-Identifier: MIT
#include <algorithm>

#include "app/common/json_writer.h"
#include "bake/base/print_text.h"
#include "bake/ground/bake_ground.h"

namespace karst::bake {
namespace {

double bits_a_sample(const BakeGround::Report& report) {
  return 8.0 * static_cast<double>(report.bytes_tiles) /
         (static_cast<double>(report.width) * static_cast<double>(report.height));
}

double void_share(const BakeGround::Report& report) {
  return static_cast<double>(report.voids) /
         (static_cast<double>(report.width) * static_cast<double>(report.height));
}

const char* name_of(ImageFormat format) {
  switch (format) {
    case ImageFormat::none:
      return "none";
    case ImageFormat::etc2_rgb:
      return "etc2";
    case ImageFormat::etc2_rgba:
      return "etc2 with alpha";
    case ImageFormat::rgba8:
      return "rgba8";
  }
  return "";
}

void print_imagery(const BakeGround::Report& report, std::string& out) {
  const BakeImagery::Report& imagery = report.imagery;
  if (!imagery.info.exists()) return;
  for (const ImageFacts& image : imagery.images) {
    print(out, "image         %s, %d x %d pixels of %.6g samples\n", image.kind.c_str(), image.width,
          image.height, image.pixel_samples);
  }
  print(out, "imagery       %llu tiles, %llu bytes, %s, texels of %.6g samples or more, ",
        number(imagery.tiles), number(imagery.bytes), name_of(imagery.info.format), imagery.texel_samples);
  if (imagery.error.squares > 0) {
    print(out, "PSNR %.2f dB, in %.2f s\n", imagery.error.psnr_db(), imagery.seconds);
  } else {
    print(out, "no loss, in %.2f s\n", imagery.seconds);
  }
}

void put_imagery(const BakeGround::Report& report, app::JsonWriter& json) {
  const BakeImagery::Report& imagery = report.imagery;
  json.key("imagery");
  if (!imagery.info.exists()) {
    json.null();
    return;
  }
  json.begin_object().field("format", name_of(imagery.info.format));
  json.field("tiles", imagery.tiles).field("bytes", imagery.bytes);
  json.field("least_size", imagery.info.least_size).field("texel_samples", imagery.texel_samples);
  json.key("psnr_db");
  if (imagery.error.squares > 0) {
    json.value(imagery.error.psnr_db());
  } else {
    json.null();
  }
  json.end_object();
}

}  // namespace

std::string ground_report_text(const Bake& job, const BakeGround::Report& report, double seconds) {
  std::string out;
  const GroundInfo& ground = report.ground.info;
  if (!job.sample.empty()) print(out, "sample        %s\n", job.sample.c_str());
  print(out, "input         %s, %d x %d samples of %.6g x %.6g m, %.3f %% void%s\n", report.source.c_str(),
        report.width, report.height, report.spacing_x_m, report.spacing_z_m, 100 * void_share(report),
        report.voids > 0 ? " (filled)" : "");
  print(out, "heights       %.6g to %.6g m, over %.6g x %.6g m\n", report.lowest_m, report.highest_m,
        report.spacing_x_m * (report.width - 1), report.spacing_z_m * (report.height - 1));
  print(out, "ground        %llu tiles of %d sizes, %llu bytes, %.3f bits a sample\n", number(report.tiles),
        ground.top_size() + 1, number(report.bytes_tiles), bits_a_sample(report));
  print(out, "quantisation  %.6g m\n", report.info.voxel_size_m * kVertexStep / kStepsPerVoxel);
  if (report.attempts > 1)
    print(out, "lattice       %.6g steps a sample, after %d attempts\n",
          std::max(ground.steps[0], ground.steps[1]), report.attempts);
  for (const BakeGround::Report::Region& region : report.regions) {
    if (region.field_triangles > 0) {
      print(out,
            "region        %d x %d x %d voxels of %.6g m, an isosurface of cells of %.6g m, %u blocks, %llu "
            "triangles, %llu bytes\n              up to %.4g m from the ground that stands for it far away\n",
            region.extent.x, region.extent.y, region.extent.z, report.info.voxel_size_m, region.cell_m,
            region.field_blocks, number(region.field_triangles), number(region.bytes), region.deviation_m);
      continue;
    }
    print(out, "region        %d x %d x %d voxels of %.6g m, %llu patches at level %d, %llu bytes\n",
          region.extent.x, region.extent.y, region.extent.z, report.info.voxel_size_m, number(region.patches),
          report.info.level, number(region.bytes));
    print(out,
          "              up to %.4g m from the ground that stands for it far away; %llu vertices missed, "
          "%llu folds left\n",
          region.deviation_m, number(region.misses), number(region.folds_left));
  }
  if (report.unmet > 0)
    print(out, "shapes        %zu of %zu do not meet the ground and are left out\n", report.unmet,
          report.shapes);
  print_imagery(report, out);
  const MaterialSet& set = report.materials.set;
  for (std::uint32_t k = 0; k < set.count; ++k)
    print(out, "%s%s", k == 0 ? "materials     " : ", ", set.materials[k].name);
  if (set.count > 0) print(out, "; %u x %u texels\n", set.side, set.side);
  print(out, "written       %llu bytes in %.2f s (tiles %.2f, materials %.2f)\n", number(report.bytes),
        seconds, report.seconds_tiles, report.seconds_materials);
  return out;
}

std::string ground_report_json(const BakeGround& job, const BakeGround::Report& report, double seconds) {
  app::JsonWriter json;
  const GroundInfo& ground = report.ground.info;
  json.begin_object();
  json.key("input").begin_object();
  if (job.job.sample.empty()) {
    json.field("path", std::string_view(job.job.read.path));
  } else {
    json.field("sample", std::string_view(job.job.sample));
  }
  json.field("kind", std::string_view(report.source));
  json.key("size").begin_array().value(report.width).value(report.height).end_array();
  json.key("spacing_m").begin_array().value(report.spacing_x_m).value(report.spacing_z_m).end_array();
  json.key("size_m").begin_array().value(report.spacing_x_m * (report.width - 1));
  json.value(report.spacing_z_m * (report.height - 1)).end_array();
  json.key("height_range_m").begin_array().value(report.lowest_m).value(report.highest_m).end_array();
  json.field("void_share", void_share(report)).end_object();
  json.key("world").begin_object();
  json.field("name", report.info.name).field("voxel_m", report.info.voxel_size_m);
  json.key("origin_m").begin_array();
  for (const double x : report.info.origin_m) json.value(x);
  json.end_array().end_object();
  json.key("ground").begin_object();
  json.key("steps").begin_array().value(ground.steps[0]).value(ground.steps[1]).end_array();
  json.field("sizes", ground.top_size() + 1).field("tiles", report.tiles);
  json.field("bytes", report.bytes_tiles).field("bits_a_sample", bits_a_sample(report));
  json.field("attempts", report.attempts);
  json.field("samples_sunk", std::uint64_t{report.sunk_samples}).end_object();
  if (!report.regions.empty()) {
    json.key("regions").begin_array();
    for (const BakeGround::Report::Region& region : report.regions) {
      json.begin_object().key("extent").begin_array();
      for (int axis = 0; axis < 3; ++axis) json.value(region.extent[axis]);
      json.end_array().field("patches", region.patches).field("level", report.info.level);
      json.field("bytes", region.bytes).field("deviation_m", region.deviation_m);
      if (region.field_triangles > 0) {
        json.field("field_triangles", region.field_triangles);
        json.field("field_blocks", std::uint64_t{region.field_blocks}).field("cell_m", region.cell_m);
      }
      json.field("misses", region.misses).field("folds_left", region.folds_left);
      json.field("seconds", region.seconds).end_object();
    }
    json.end_array();
  }
  if (report.shapes > 0) {
    json.field("carve_shapes", std::uint64_t{report.shapes});
    json.field("carve_shapes_unmet", std::uint64_t{report.unmet});
  }
  put_imagery(report, json);
  json.field("quantisation_m", report.info.voxel_size_m * kVertexStep / kStepsPerVoxel);
  json.field("bytes", report.bytes).field("seconds", seconds);
  json.key("stage_seconds").begin_object();
  json.field("tiles", report.seconds_tiles).field("materials", report.seconds_materials);
  json.field("imagery", report.imagery.seconds).end_object();
  json.end_object();
  return json.text();
}

}  // namespace karst::bake
