// SPDX-License-Identifier: MIT
// karst info: what a world file holds.
#include <cstdio>
#include <string>

#include "app/command_line/command_line.h"
#include "app/command_line/help.h"
#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/json_writer.h"
#include "app/files/file_source.h"
#include "karst/world.h"
#include "platform/base/error.h"

namespace karst::app {
namespace {

struct InfoOptions {
  bool json = false;
};

constexpr OptionRow kRows[] = {{.name = "json", .help = "for programs", .store = put<&InfoOptions::json>}};
constexpr OptionGroup kGroups[] = {{"output", kRows}};
constexpr OptionPart kParts[] = {kGroups};
// In the order of Basis.
constexpr const char* kBases[] = {"plane", "geographic", "cube", "cylinder", "function"};

void print_json(const WorldInfo& info, std::uint64_t file_bytes) {
  JsonWriter json;
  json.begin_object();
  json.field("name", info.name).field("file_bytes", file_bytes);
  json.field("voxel_size_m", info.voxel_size_m);
  json.key("origin_m").begin_array();
  json.value(info.origin_m.x).value(info.origin_m.y).value(info.origin_m.z);
  json.end_array().key("extent_voxels").begin_array();
  for (int axis = 0; axis < 3; ++axis) json.value(info.extent[axis]);
  json.end_array();
  json.field("depth", info.octree_depth).field("level", info.level).field("octets", info.octets);
  json.field("volumes", info.volumes)
      .field("patches", info.patches)
      .field("height_blocks", info.height_blocks);
  json.field("materials", info.materials).field("lights", info.lights);
  json.key("material_names").begin_array();
  for (std::uint32_t m = 0; m < info.materials; ++m) json.value(info.material_names[m]);
  json.end_array();
  json.key("blend_map").begin_array().value(info.blend_map[0]).value(info.blend_map[1]).end_array();
  if (info.has_water) {
    json.field("water_m", info.water_m);
  } else {
    json.key("water_m").null();
  }
  if (info.ground_samples[0] > 0) {
    json.key("ground").begin_object().key("samples").begin_array();
    json.value(info.ground_samples[0]).value(info.ground_samples[1]).end_array();
    json.key("spacing_m").begin_array();
    json.value(info.ground_spacing_m[0]).value(info.ground_spacing_m[1]).end_array();
    json.key("height_range_m").begin_array().value(info.ground_low_m).value(info.ground_high_m).end_array();
    json.field("sizes", info.ground_sizes).field("tile_bytes", info.tile_bytes);
    json.field("basis", kBases[static_cast<int>(info.basis)]).field("epsg", info.epsg);
    json.field("geodetic", info.is_geodetic);
    json.field("image_texel_m", info.image_texel_m);
    json.field("can_be_dug", info.can_be_dug);
    json.key("regions").begin_array();
    for (std::uint32_t n = 0; n < info.regions; ++n) {
      json.begin_object().key("first_node").begin_array();
      json.value(info.region_first[n][0]).value(info.region_first[n][1]).end_array();
      json.key("nodes").begin_array();
      json.value(info.region_nodes[n][0]).value(info.region_nodes[n][1]).end_array().end_object();
    }
    json.end_array();
    json.end_object();
  } else {
    json.key("ground").null();
  }
  if (info.field_samples[0] > 0) {
    json.key("field").begin_object().key("samples").begin_array();
    for (const std::int32_t samples : info.field_samples) json.value(samples);
    json.end_array().field("cell_m", info.field_cell_m).field("sample_bits", info.field_sample_bits);
    json.field("blocks", info.field_blocks).field("materials", info.field_has_materials).end_object();
  } else {
    json.key("field").null();
  }
  json.end_object();
  std::fputs(json.text().c_str(), stdout);
}

void print_materials(const WorldInfo& info) {
  std::printf("materials      %u", info.materials);
  for (std::uint32_t m = 0; m < info.materials; ++m)
    std::printf("%s%s", m == 0 ? ": " : ", ", info.material_names[m]);
  std::printf("; %u lights\n", info.lights);
}

void print_ground(const WorldInfo& info) {
  const auto wide = static_cast<double>(info.ground_samples[0]);
  const auto deep = static_cast<double>(info.ground_samples[1]);
  std::printf("ground         %.0f x %.0f samples of %.10g x %.10g m, over %.10g x %.10g m\n", wide, deep,
              info.ground_spacing_m[0], info.ground_spacing_m[1], info.ground_spacing_m[0] * (wide - 1),
              info.ground_spacing_m[1] * (deep - 1));
  if (info.basis == Basis::function) {
    std::printf("basis          where a function of the host says\n");
  } else if (info.basis != Basis::plane) {
    std::printf("basis          %s of %.10g m\n", kBases[static_cast<int>(info.basis)], info.radius_m);
  }
  if (info.epsg > 0) {
    std::printf("coordinates    EPSG:%u, longitude and latitude %s\n", info.epsg,
                info.is_geodetic ? "known" : "not known");
  }
  std::printf("heights        %.10g to %.10g m\n", info.ground_low_m, info.ground_high_m);
  const auto tile_bytes = static_cast<unsigned long long>(info.tile_bytes);
  if (info.image_texel_m > 0) {
    std::printf("tiles          %llu bytes, %d sizes, with imagery of texels of %.10g m or more\n",
                tile_bytes, info.ground_sizes, info.image_texel_m);
  } else {
    std::printf("tiles          %llu bytes, %d sizes, %.3g bits a sample\n", tile_bytes, info.ground_sizes,
                8 * static_cast<double>(info.tile_bytes) / (wide * deep));
  }
  if (info.can_be_dug) std::printf("digging        anywhere, voxels of %.10g m\n", info.voxel_size_m);
  for (std::uint32_t n = 0; n < info.regions; ++n) {
    std::printf("region         %d x %d nodes of 4 x 4 samples, from node %d, %d: of voxels\n",
                info.region_nodes[n][0], info.region_nodes[n][1], info.region_first[n][0],
                info.region_first[n][1]);
  }
}

void print_field(const WorldInfo& info) {
  std::printf("field          %d x %d x %d samples of %d bits, %.10g m apart\n", info.field_samples[0],
              info.field_samples[1], info.field_samples[2], info.field_sample_bits, info.field_cell_m);
  std::printf("blocks         %u of 16^3 samples that hold surface%s\n", info.field_blocks,
              info.field_has_materials ? "; samples have materials" : "");
}

void print_text(const WorldInfo& info, std::uint64_t file_bytes) {
  const double size = info.voxel_size_m;
  const Vec3& low = info.origin_m;
  const double far_m[3] = {low.x + size * info.extent[0], low.y + size * info.extent[1],
                           low.z + size * info.extent[2]};
  const double side = (1 << info.level) + 1;  // vertices of a patch
  const double patch = side * side;
  if (info.name[0] != '\0') std::printf("name           %s\n", info.name);
  std::printf("file           %llu bytes\n", static_cast<unsigned long long>(file_bytes));
  if (info.ground_samples[0] > 0) print_ground(info);
  if (info.field_samples[0] > 0) print_field(info);
  if (info.patches == 0 && (info.ground_samples[0] > 0 || info.field_samples[0] > 0)) {
    print_materials(info);
    if (info.has_water) std::printf("water          up to %.10g m\n", info.water_m);
    return;
  }
  std::printf("voxels         %d x %d x %d of %g m%s, octree of %d levels\n", info.extent[0], info.extent[1],
              info.extent[2], size, info.regions > 1 ? " at most" : "", info.octree_depth);
  std::printf("from           %.10g, %.10g, %.10g m\n", low.x, low.y, low.z);
  // Of several regions it is where the first begin.
  if (info.regions <= 1 && !info.can_be_dug)
    std::printf("to             %.10g, %.10g, %.10g m\n", far_m[0], far_m[1], far_m[2]);
  print_materials(info);
  if (info.blend_map[0] > 0)
    std::printf("blend map      %u x %u texels\n", info.blend_map[0], info.blend_map[1]);
  if (info.has_water) std::printf("water          up to %.10g m\n", info.water_m);
  std::printf("octets         %u\n", info.octets);
  std::printf("volumes        %u\n", info.volumes);
  std::printf("patches        %u, %u of them with heights\n", info.patches, info.height_blocks);
  std::printf("level          %d: %.0f vertices a patch, %.0f in all\n", info.level, patch,
              patch * info.patches);
}

}  // namespace

constinit const CommandSpec kInfoSpec = {.name = "karst info",
                                         .brief = "says what a world file holds",
                                         .usage = "WORLD [--json]",
                                         .about = "Checks a world file and says what it holds.",
                                         .parts = kParts,
                                         .examples = "karst info canyon.karst\n"};

int run_info(std::span<const char* const> words) {
  CommandLine line;
  InfoOptions options;
  Error usage = line.parse(words, kInfoSpec);
  if (usage.ok() && line.wants_help()) {
    std::fputs(help_text(kInfoSpec).c_str(), stdout);
    return kExitOk;
  }
  if (usage.ok() && line.positional().size() != 1) usage = "takes one WORLD";
  void* const targets[] = {&options};
  if (usage.ok()) usage = line.store(targets);
  if (!usage.ok()) {
    print_error("karst info", usage.text());
    return kExitUsage;
  }
  const std::string path(line.positional()[0]);
  FileSource file;
  Error error = file.open(path);
  WorldInfo info;
  const Source source = file.source();
  if (error.ok()) error = {path, check_world(source, info)};
  if (!error.ok()) {
    print_error("karst info", error.text());
    return kExitFailure;
  }
  options.json ? print_json(info, source.bytes) : print_text(info, source.bytes);
  return kExitOk;
}

}  // namespace karst::app
