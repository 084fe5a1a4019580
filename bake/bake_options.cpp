// SPDX-License-Identifier: MIT
#include "bake/bake_options.h"

#include "app/common/arguments.h"
#include "bake/materials/material_files.h"
#include "bake/samples/samples.h"
#include "platform/base/text.h"
#include "terrain/base/lattice.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <thread>

namespace karst::bake {
namespace {

using namespace app;
using namespace core;
using Kind = ValueKind;

constexpr int kMaxThreads = 256;

BakeOptions& bake_of(void* options) {
  return *static_cast<BakeOptions*>(options);
}

std::string wrong(const OptionValue& value, std::string_view text) {
  std::string line(value.what);
  return line.append(": ").append(text);
}

Error store_sample(void* options, const OptionValue& value) {
  bake_of(options).job.sample = value.text;
  std::string known;
  for (const SampleName& sample : sample_names()) {
    if (sample.name == value.text) return {};
    known.append(known.empty() ? "" : ", ").append(sample.name);
  }
  return wrong(value, quote(value.text) + " is not one of " + known);
}

Error store_z_scale(void* options, const OptionValue& value) {
  bake_of(options).job.read.z_scale = value.number;
  return value.number == 0 ? wrong(value, "0 leaves no heights") : std::string();
}

Error store_nodata(void* options, const OptionValue& value) {
  Bake& job = bake_of(options).job;
  bool fill = false;
  for (std::string_view list = value.text;;) {
    const std::size_t comma = list.find(',');
    const std::string_view word = list.substr(0, comma);
    if (word == "fill" || word == "hole") {
      fill = fill || word == "fill";
      job.leave_holes = job.leave_holes || word == "hole";
    } else {
      double height = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), height);
      if (word.empty() || error != std::errc() || end != word.data() + word.size()) {
        return wrong(value, quote(word) + " is not a number, fill or hole");
      }
      job.read.nodata.push_back(height);
    }
    if (comma == std::string_view::npos) break;
    list.remove_prefix(comma + 1);
  }
  return fill && job.leave_holes ? wrong(value, "both fill and hole") : std::string();
}

Error store_crop(void* options, const OptionValue& value) {
  double numbers[4];
  if (Error error = parse_numbers(value.text, value.what, ',', numbers); !error.ok()) return error;
  for (int k = 0; k < 4; ++k) {
    const double v = numbers[k];
    if (!(v >= (k < 2 ? 0 : 2) && v <= double{ElevationRows::kMostSide}) || v != static_cast<int>(v)) {
      return wrong(value, "not four whole numbers X,Z,W,H with W and H of 2 or more");
    }
    bake_of(options).job.read.crop[k] = static_cast<int>(v);
  }
  return {};
}

Error store_bounds(void* options, const OptionValue& value) {
  double numbers[4];
  if (Error error = parse_numbers(value.text, value.what, ',', numbers); !error.ok()) return error;
  bake_of(options).job.read.bounds = {numbers[0], numbers[1], numbers[2], numbers[3]};
  return {};
}

Error store_crs(void* options, const OptionValue& value) {
  constexpr std::string_view kPrefix = "EPSG:";
  const std::string_view code = value.text.substr(std::min(kPrefix.size(), value.text.size()));
  int number = 0;
  const auto [end, error] = std::from_chars(code.data(), code.data() + code.size(), number);
  const bool is_code = value.text.starts_with(kPrefix) && !code.empty() && error == std::errc() &&
                       end == code.data() + code.size() && number > 0;
  if (!is_code) return wrong(value, quote(value.text) + " is not EPSG:CODE, as EPSG:4326");
  bake_of(options).job.read.crs = value.text;
  return {};
}

Error store_carve_as(void* options, const OptionValue& value) {
  bake_of(options).job.carves_field = value.text == "field";
  return {};
}

Error store_basis(void* options, const OptionValue& value) {
  BakeBasis& basis = bake_of(options).job.basis;
  const std::size_t colon = value.text.find(':');
  const std::string_view kind = value.text.substr(0, colon);
  constexpr std::string_view kKinds[] = {"plane", "geographic", "cube", "cylinder", "function"};
  const auto* const found = std::find(std::begin(kKinds), std::end(kKinds), kind);
  if (found == std::end(kKinds))
    return wrong(value,
                 quote(kind) + " is not one of plane, geographic, cube, cylinder[:RADIUS], function:RADIUS");
  basis.kind = static_cast<BakeBasis::Kind>(found - std::begin(kKinds));
  const bool is_function = basis.kind == BakeBasis::Kind::function;
  if (colon == std::string_view::npos && is_function)
    return wrong(value, "the least radius of its curvature is missing, in metres: function:5000");
  if (colon == std::string_view::npos) return {};
  const std::string_view radius = value.text.substr(colon + 1);
  const auto [end, error] = std::from_chars(radius.data(), radius.data() + radius.size(), basis.radius_m);
  const bool is_radius = !radius.empty() && error == std::errc() && end == radius.data() + radius.size() &&
                         std::abs(basis.radius_m) >= 1 && std::abs(basis.radius_m) <= 1e9;
  if (is_function && is_radius && basis.radius_m > 0) return {};
  if (is_function)
    return wrong(value, "the radius of its curvature is within 1 to 1e9 metres: function:5000");
  if (basis.kind != BakeBasis::Kind::cylinder || !is_radius)
    return wrong(value, "only a cylinder has a radius, of 1 to 1e9 metres, below 0 inside: cylinder:-1000");
  return {};
}

Error store_materials(void* options, const OptionValue& value) {
  MaterialOptions& materials = bake_of(options).job.materials;
  materials.none = value.text == "none";
  if (!materials.none) materials.path = value.text;
  return {};
}

Error store_material_side(void* options, const OptionValue& value) {
  bake_of(options).job.materials.side = static_cast<int>(value.integer);
  const bool is_power = std::has_single_bit(static_cast<std::uint64_t>(value.integer));
  return is_power ? std::string() : wrong(value, "not a power of two");
}

Error store_max_texels(void* options, const OptionValue& value) {
  bake_of(options).job.materials.max_texels = static_cast<std::uint64_t>(value.integer);
  return {};
}

Error store_material_format(void* options, const OptionValue& value) {
  bake_of(options).job.materials.format = value.integer == 0 ? TextureFormat::etc2 : TextureFormat::rgba8;
  return {};
}

Error store_imagery(void* options, const OptionValue& value) {
  std::vector<std::string>& files = bake_of(options).imagery.files;
  for (std::string_view list = value.text;;) {
    const std::size_t comma = list.find(',');
    files.emplace_back(list.substr(0, comma));
    if (files.back().empty()) return wrong(value, "a name is empty");
    if (comma == std::string_view::npos) return {};
    list.remove_prefix(comma + 1);
  }
}

Error store_image_format(void* options, const OptionValue& value) {
  bake_of(options).imagery.format = value.integer == 0 ? ImageFormat::etc2_rgba : ImageFormat::rgba8;
  return {};
}

Error store_voxel(void* options, const OptionValue& value) {
  bake_of(options).job.voxel_m = value.number;
  return {};
}

Error store_water(void* options, const OptionValue& value) {
  bake_of(options).job.water_m = value.number;
  return {};
}

Error store_levels(void* options, const OptionValue& value) {
  bake_of(options).job.level = static_cast<int>(value.integer);
  return {};
}

constexpr OptionRow kWorldRows[] = {
    {.name = "output",
     .letter = 'o',
     .kind = Kind::file,
     .value = "FILE",
     .help = "the world file; written whole or not at all",
     .store = put<&BakeOptions::output>},
    {.name = "sample",
     .kind = Kind::other,
     .value = "NAME",
     .words = "canyon caves arches hills",
     .help = "a procedural world instead of a DEM: canyon, caves, arches or hills",
     .store = store_sample},
    {.name = "features",
     .kind = Kind::file,
     .value = "FILE",
     .help = "a ground of noise, hills, mountains, dunes and rivers instead of a DEM, as the JSON file says "
             "(docs/features.md)",
     .store = put<&BakeOptions::job, &Bake::features_path>},
    {.name = "no-ground",
     .help = "voxels alone, 512 a side at most, and no ground around them: a slab with sides; a DEM becomes "
             "that with --voxel, --levels, --accept-fit or --nodata hole, too, but where --carve is given",
     .store = put<&BakeOptions::no_ground>},
    {.name = "ground",
     .initial = "of DEMs and samples, but for what only voxels have",
     .help = "a ground of tiles at the DEM's own resolution, in memory that does not grow with it; with "
             "--carve voxels stand where shapes meet it, of --voxel",
     .store = put<&BakeOptions::ground>},
    {.name = "basis",
     .kind = Kind::other,
     .value = "B",
     .initial = "plane",
     .words = "plane geographic cube cylinder function",
     .help =
         "makes a ground on a basis: plane; geographic, longitude and latitude on the ellipsoid as they are; "
         "cube, a whole planet on six faces; cylinder:RADIUS in metres, below 0 inside; function:RADIUS, "
         "where a host's own function puts it, RADIUS being the least of its curvature",
     .store = store_basis},
    {.name = "voxel",
     .kind = Kind::number,
     .value = "M",
     .initial = "half of a shape's radius, of --dig the distance of samples; samples: 8 or 10; without a "
                "ground about 128 voxels across",
     .unit = "metres",
     .min = 1e-6,
     .max = 1e9,
     .help = "size of a voxel",
     .store = store_voxel},
    {.name = "levels",
     .kind = Kind::integer,
     .value = "K",
     .initial = "vertices 3/4 of a sample apart; samples: 5",
     .min = 1,
     .max = kMaxLevel,
     .help = "level of the heights: 2^K + 1 a patch side",
     .store = store_levels},
    {.name = "water",
     .kind = Kind::number,
     .value = "M",
     .initial = "none",
     .unit = "metres",
     .min = -1e5,
     .max = 1e5,
     .help = "height up to which still water stands, a sea's or a lake's; of a DEM, what is flat at this "
             "height is sunk to a bed",
     .store = store_water},
    {.name = "carve",
     .kind = Kind::file,
     .value = "FILE",
     .help = "fills or empties boxes, spheres and tunnels (docs/formats.md)",
     .store = put<&BakeOptions::job, &Bake::carve_path>},
    {.name = "carve-as",
     .kind = Kind::word,
     .value = "KIND",
     .initial = "patches",
     .words = "patches field",
     .help = "what stands in a ground where shapes are carved: patches with heights, or the field of an "
             "isosurface",
     .store = store_carve_as},
    {.name = "dig",
     .help = "makes a ground that edits can dig anywhere, with voxels of --voxel; tunnels and caves are made "
             "where somebody digs them (docs/editing.md)",
     .store = put<&BakeOptions::job, &Bake::can_be_dug>},
    {.name = "max-carve",
     .kind = Kind::integer,
     .value = "N",
     .initial = "131072 and 4 for each column of the world",
     .min = 1,
     .max = 1 << 24,
     .help = "takes shapes that reach so many columns of voxels together",
     .store = put<&BakeOptions::job, &Bake::max_carve>},
};

constexpr OptionRow kDemRows[] = {
    {.name = "band",
     .kind = Kind::integer,
     .value = "N",
     .initial = "the only one",
     .min = 1,
     .max = 65'535,
     .help = "of a raster with several bands: the one that holds the heights",
     .store = put<&BakeOptions::job, &Bake::read, &ReadElevation::band>},
    {.name = "pixel-size",
     .kind = Kind::number,
     .value = "M",
     .unit = "metres",
     .min = kMinSpacingM,
     .max = kMaxSpacingM,
     .help = "between samples, for images that do not say, or say it wrong",
     .store = put<&BakeOptions::job, &Bake::read, &ReadElevation::pixel_size_m>},
    {.name = "crs",
     .kind = Kind::other,
     .value = "EPSG:CODE",
     .help = "coordinate reference system, for files that have none, or a wrong one",
     .store = store_crs},
    {.name = "bounds",
     .kind = Kind::other,
     .value = "W,S,E,N",
     .help = "where the image's edges lie in it, for files that do not say: --bounds -180,-90,180,90",
     .store = store_bounds},
    {.name = "z-scale",
     .kind = Kind::number,
     .value = "S",
     .initial = "1",
     .min = -1e9,
     .max = 1e9,
     .help = "multiplies heights",
     .store = store_z_scale},
    {.name = "nodata",
     .kind = Kind::other,
     .value = "LIST",
     .initial = "fill",
     .help =
         "how voids are known and what becomes of them: any of a value, fill (from around) and hole (left "
         "out), with commas: --nodata -9999,hole",
     .store = store_nodata},
    {.name = "crop",
     .kind = Kind::other,
     .value = "X,Z,W,H",
     .help = "only these samples: first column, first row, columns, rows",
     .store = store_crop},
    {.name = "max-samples",
     .kind = Kind::integer,
     .value = "N",
     .initial = "524288 and 4 for each byte of the files",
     .min = 4,
     .max = static_cast<double>(ElevationRows::kMostSamples),
     .help = "takes so many samples of what is compressed to next to nothing, a sea or a bomb",
     .store = put<&BakeOptions::job, &Bake::read, &ReadElevation::max_samples>},
    {.name = "accept-fit",
     .help = "writes the world even where its ground misses the DEM by more than a voxel",
     .store = put<&BakeOptions::job, &Bake::accept_fit>},
    {.name = "allow-8bit",
     .help = "takes 8-bit images, whose heights are steps",
     .store = put<&BakeOptions::job, &Bake::read, &ReadElevation::allow_8bit>},
};

constexpr OptionRow kMaterialRows[] = {
    {.name = "materials",
     .kind = Kind::file,
     .value = "FILE",
     .help = "what the ground is made of, painted boxes, lights (docs/materials.md); none: nothing",
     .store = store_materials},
    {.name = "material-side",
     .kind = Kind::integer,
     .value = "N",
     .initial = "256",
     .unit = "texels, a power of two",
     .min = kLeastTextureSide,
     .max = kMostTextureSide,
     .help = "of a texture's side",
     .store = store_material_side},
    {.name = "material-format",
     .kind = Kind::word,
     .value = "F",
     .initial = "etc2",
     .words = "etc2 rgba8",
     .help = "of textures: etc2 or rgba8",
     .store = store_material_format},
    {.name = "max-texels",
     .kind = Kind::integer,
     .value = "N",
     .initial = "4194304 and 16 for each byte of the images",
     .min = 1,
     .max = static_cast<double>(kMostImageTexels),
     .help = "takes images with so many together, however small their files are",
     .store = store_max_texels},
};

constexpr OptionRow kImageryRows[] = {
    {.name = "imagery",
     .kind = Kind::file,
     .value = "FILES",
     .help = "makes a ground, and lays over it images as GDAL reads and places them, with commas between; "
             "later ones lie over "
             "earlier ones. One that does not say where it lies is laid over all of the DEM, if it has its "
             "shape",
     .store = store_imagery},
    {.name = "image-format",
     .kind = Kind::word,
     .value = "F",
     .initial = "etc2",
     .words = "etc2 rgba8",
     .help = "of their tiles: etc2, half a byte a texel, or one where images do not cover all of the ground; "
             "rgba8, four",
     .store = store_image_format},
};

Error store_field_shape(void* options, const OptionValue& value) {
  bake_of(options).field.shape = value.text;
  std::string known = "sphere, torus, gyroid, noise";
  for (const std::string_view name : {"sphere", "torus", "gyroid", "noise"}) {
    if (name == value.text) return {};
  }
  for (const SampleName& sample : sample_names()) {
    if (sample.name == value.text) return {};
    known.append(", ").append(sample.name);
  }
  return wrong(value, quote(value.text) + " is not one of " + known);
}

Error store_field_size(void* options, const OptionValue& value) {
  double numbers[3];
  if (Error error = parse_numbers(value.text, value.what, ',', numbers); !error.ok()) return error;
  double samples = 1;
  for (int k = 0; k < 3; ++k) {
    const double v = numbers[k];
    samples *= v;
    if (!(v >= 2 && v <= FieldGrid::kMostSide) || v != static_cast<int>(v))
      return wrong(value, "not three whole numbers X,Y,Z within 2 to 4080");
    bake_of(options).field.size[k] = static_cast<int>(v);
  }
  if (samples > double{FieldGrid::kMostSamples}) return wrong(value, "more than 67108864 samples");
  return {};
}

Error store_field_solid(void* options, const OptionValue& value) {
  bake_of(options).field.solid_above = value.integer == 1;
  return {};
}

Error store_field_bits(void* options, const OptionValue& value) {
  bake_of(options).field.sample_bits = static_cast<int>(value.integer);
  return value.integer == 8 || value.integer == 16 ? std::string() : wrong(value, "neither 8 nor 16");
}

Error store_field_materials(void* options, const OptionValue& value) {
  bake_of(options).field.materials_path = value.text;
  return {};
}

constexpr OptionRow kFieldRows[] = {
    {.name = "field",
     .kind = Kind::file,
     .value = "FILE",
     .help =
         "makes an isosurface of values on a grid in space: NRRD (raw or gzip, also with a detached header), "
         "or with --field-type raw numbers; x to the east is fastest, then y up, then z to the south",
     .store = put<&BakeOptions::field, &BakeField::path>},
    {.name = "field-shape",
     .kind = Kind::other,
     .value = "NAME",
     .words = "sphere torus gyroid noise canyon caves arches hills",
     .help = "the same of distances to a shape: sphere, torus, gyroid, noise, or a --sample's",
     .store = store_field_shape},
    {.name = "field-size",
     .kind = Kind::other,
     .value = "X,Y,Z",
     .initial = "of shapes 129,129,129",
     .unit = "samples",
     .help = "samples each way, of a shape or of raw numbers",
     .store = store_field_size},
    {.name = "field-type",
     .kind = Kind::word,
     .value = "T",
     .words = "int8 uint8 int16 uint16 int32 uint32 float double",
     .help = "the file is raw numbers: int8, uint8, int16, uint16, int32, uint32, float or double, "
             "little-endian",
     .store = put<&BakeOptions::field, &BakeField::type>},
    {.name = "field-iso",
     .kind = Kind::number,
     .value = "V",
     .initial = "0",
     .min = -1e30,
     .max = 1e30,
     .help = "the value of the surface",
     .store = put<&BakeOptions::field, &BakeField::iso>},
    {.name = "field-solid",
     .kind = Kind::word,
     .value = "W",
     .initial = "below",
     .words = "below above",
     .help = "what is solid: values below --field-iso, as of distances, or above, as of densities",
     .store = store_field_solid},
    {.name = "field-spacing",
     .kind = Kind::number,
     .value = "M",
     .initial = "as the file says, or 1",
     .unit = "metres",
     .min = 1e-6,
     .max = 1e6,
     .help = "between samples, of shapes, and of files that do not say",
     .store = put<&BakeOptions::field, &BakeField::spacing_m>},
    {.name = "field-bits",
     .kind = Kind::integer,
     .value = "N",
     .initial = "8",
     .min = 8,
     .max = 16,
     .help = "of a sample in the world: 8 or 16",
     .store = store_field_bits},
    {.name = "field-reach",
     .kind = Kind::number,
     .value = "N",
     .initial = "2",
     .unit = "cells",
     .min = 1,
     .max = 64,
     .help = "how far from the surface samples tell distances; farther is coarser",
     .store = put<&BakeOptions::field, &BakeField::reach_cells>},
    {.name = "field-materials",
     .kind = Kind::file,
     .value = "FILE",
     .help =
         "what samples are made of: a byte each, raw or NRRD; 0: by the rules of --materials, 1 to 8: the "
         "material of that number; or the word layers: strata",
     .store = store_field_materials},
};

constexpr OptionRow kRunRows[] = {
    {.name = "threads",
     .kind = Kind::integer,
     .value = "N",
     .initial = "all",
     .min = 1,
     .max = kMaxThreads,
     .help = "the world does not depend on it",
     .store = put<&BakeOptions::job, &Bake::threads>},
    {.name = "stats",
     .kind = Kind::file,
     .value = "FILE",
     .help = "writes the report as JSON",
     .store = put<&BakeOptions::stats>},
    {.name = "json", .help = "prints the report as JSON", .store = put<&BakeOptions::json>},
    {.name = "quiet", .help = "prints no report and no progress", .store = put<&BakeOptions::quiet>},
    {.name = "version", .help = "prints the version"},
};

constexpr OptionGroup kGroups[] = {{"world", kWorldRows},        {"of a DEM", kDemRows},
                                   {"materials", kMaterialRows}, {"imagery", kImageryRows},
                                   {"isosurface", kFieldRows},   {"run", kRunRows}};
constexpr OptionPart kParts[] = {kGroups};

// A ground is asked for by what there is on one alone, too.
bool asks_for_ground(const CommandLine& line) {
  return line.has("ground") || line.has("basis") || line.has("imagery") || line.has("dig");
}

// A DEM is a ground, unless something is said that voxels alone have. Carved shapes have voxels in a ground.
bool means_voxels(const CommandLine& line, bool leaves_holes) {
  if (line.has("no-ground")) return true;
  if (asks_for_ground(line)) return false;
  if (line.has("accept-fit") || leaves_holes) return true;
  return !line.has("carve") && (line.has("voxel") || line.has("levels"));
}

// Of an isosurface, which takes nothing of a ground or of voxels.
Error check_field(const CommandLine& line) {
  const bool shape = line.has("field-shape");
  if (shape && line.has("field")) return "both --field and --field-shape are given";
  if (line.has("sample") || !line.positional().empty())
    return "--field and --field-shape: a DEM or --sample is given, too";
  for (const OptionGroup& group : {kGroups[0], kGroups[1], kGroups[3]}) {
    for (const OptionRow& row : group.rows) {
      if (line.has(row.name) && std::string_view(row.name) != "output")
        return std::string("--") + row.name + ": not for an isosurface; leave it or --field away";
    }
  }
  if (shape && line.has("field-type")) return "--field-type: only for --field, not for --field-shape";
  if (line.has("field") && line.has("field-size") != line.has("field-type"))
    return "--field-size and --field-type: for raw numbers both are needed";
  if (!line.has("output")) return "-o WORLD.karst is needed; see --help";
  return {};
}

Error check_source(const CommandLine& line) {
  if (line.has("field") || line.has("field-shape")) return check_field(line);
  for (const OptionRow& row : kFieldRows) {
    if (line.has(row.name)) return std::string("--") + row.name + ": without --field or --field-shape";
  }
  const bool sample = line.has("sample");
  const bool features = line.has("features");
  if (sample && !line.positional().empty()) return "both a DEM and --sample are given";
  if (features && (sample || !line.positional().empty()))
    return "--features: a DEM or --sample is given, too";
  if (!sample && !features && line.positional().empty())
    return "a DEM, --sample NAME or --features FILE is needed; see --help";
  if (features) {
    for (const char* name : {"basis", "no-ground", "accept-fit", "levels", "imagery"}) {
      if (line.has(name)) return std::string("--") + name + ": not for --features; leave it away";
    }
  }
  for (const OptionRow& row : kDemRows) {
    if ((sample || features) && line.has(row.name))
      return std::string("--") + row.name + ": only for a DEM, not for --sample and --features";
  }
  if (line.has("ground") && line.has("no-ground")) return "both --ground and --no-ground are given";
  if (asks_for_ground(line)) {
    if (line.has("accept-fit")) return "--accept-fit: only for a world of voxels; leave --ground away";
    for (const char* name : {"voxel", "levels", "max-carve"}) {
      if (line.has(name) && !line.has("carve") && !line.has("dig") && !sample) {
        return std::string("--") + name +
               ": a ground has voxels only with --carve or --dig; or leave --ground away";
      }
    }
  }
  if (line.has("basis") && line.has("no-ground"))
    return "--basis: only of a ground of tiles; leave --no-ground away";
  if (line.has("basis") && sample) return "--basis: only for a DEM, not for --sample";
  if (line.has("basis") && line.has("carve"))
    return "--basis: carved shapes lie on a plane alone; leave --basis away";
  if (line.has("carve-as") && !line.has("carve")) return "--carve-as: without --carve";
  if (line.has("carve-as") && line.has("no-ground"))
    return "--carve-as: only in a ground of tiles; leave --no-ground away";
  if (line.has("basis") && line.has("dig"))
    return "--basis: a ground is dug on a plane alone; leave --basis or --dig away";
  if (line.has("dig") && line.has("no-ground"))
    return "--dig: a world of voxels alone can be dug anyway; leave --dig or --no-ground away";
  if (line.has("imagery") && line.has("no-ground"))
    return "--imagery: only over a ground of tiles; leave --no-ground away";
  if (line.has("image-format") && !line.has("imagery")) return "--image-format: without --imagery";
  if (!line.has("output")) return "-o WORLD.karst is needed; see --help";
  return {};
}

}  // namespace

constinit const CommandSpec kBakeSpec = {
    .name = "karst-bake",
    .brief = "makes a .karst world from an elevation image or a procedural sample",
    .usage =
        "DEM... -o WORLD.karst [options]\n--sample NAME -o WORLD.karst [options]\n"
        "--features FILE -o WORLD.karst [options]\n"
        "--field FILE -o WORLD.karst [options]",
    .about =
        "DEM is a raster that GDAL reads as GeoTIFF, PNG, ESRI's and ENVI's raw files with a .hdr beside "
        "them, Arc/Info ASCII grid, SRTM's .hgt, DTED, USGS DEM, Erdas Imagine, JPEG 2000 or VRT, or an "
        "OpenEXR image. Several of one grid make one world. Heights are metres unless the file says feet. "
        "North is -z in the world, whose x = z = 0 is the raster's centre.",
    .parts = kParts,
    .examples =
        "karst-bake dem.tif -o world.karst\n"
        "karst-bake dem.tif -o voxels.karst --voxel 256 --levels 4\n"
        "karst-bake srtm.bil -o world.karst --nodata -9999,hole\n"
        "karst-bake N46E007.hgt N46E008.hgt -o alps.karst\n"
        "karst-bake coast.tif -o world.karst --water 0\n"
        "karst-bake height.png -o world.karst --pixel-size 2 --z-scale 0.01\n"
        "karst-bake dem.tif -o world.karst --imagery region.tif,city.tif\n"
        "karst-bake --features valley.json -o valley.karst\n"
        "karst-bake --sample canyon -o canyon.karst --json\n"
        "karst-bake --field scan.nrrd -o scan.karst --field-iso 300 --field-solid above\n"
        "karst-bake --field sdf.raw -o rock.karst --field-size 256,128,256 --field-type float "
        "--field-spacing 0.5\n"
        "karst-bake --field-shape caves -o caves.karst --field-size 257,65,257 --field-materials layers\n"};

Error parse_bake_options(std::span<const char* const> words, CommandLine& line, BakeOptions& options) {
  if (Error error = line.parse(words, kBakeSpec); !error.ok()) return error;
  if (line.wants_help() || line.has("version")) return {};
  if (Error error = check_source(line); !error.ok()) return error;
  const bool field = line.has("field") || line.has("field-shape");
  if (!line.positional().empty()) {
    options.job.read.path = line.positional()[0];
    options.job.read.more.assign(line.positional().begin() + 1, line.positional().end());
  }
  options.job.threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMaxThreads);
  void* const targets[] = {&options};
  if (Error error = line.store(targets); !error.ok()) return error;
  options.field.threads = options.job.threads;
  if (options.field.size.x == 0) options.field.size = glm::ivec3(129);
  if (field) {
    for (const OptionRow& row : kMaterialRows)
      options.field.has_materials = options.field.has_materials || line.has(row.name);
    options.field.materials = options.job.materials;
    return {};
  }
  options.ground = line.has("sample") || line.has("features") ? !options.no_ground
                                                              : !means_voxels(line, options.job.leave_holes);
  if (options.ground && options.job.leave_holes)
    return "--nodata hole: only for a world of voxels; leave --ground, --basis and --imagery away, or fill "
           "voids";
  return {};
}

}  // namespace karst::bake
