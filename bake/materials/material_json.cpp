// SPDX-License-Identifier: MIT
#include "bake/materials/material_json.h"

#include "app/json/json_fields.h"
#include "bake/procedural/sample_materials.h"

#include <algorithm>
#include <bit>
#include <iterator>

namespace karst::bake {

using app::JsonFields;
using app::parse_json;
using app::read_json_text;

namespace {

using nlohmann::json;

constexpr double kFarM = 1e9;
constexpr std::size_t kMostPathBytes = 4'096;

// [low, high]; null is no limit.
Limits limits(const JsonFields& fields, const char* field, double low, double high) {
  const json& value = fields.get(field);
  Limits result;
  if (!value.is_array() || value.size() != 2) {
    fields.fail(field, "not two limits");
    return result;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    if (!value[k].is_null()) result[k] = fields.number(field, value[k], low, high);
  }
  if (result[0] && result[1] && *result[0] > *result[1])
    fields.fail(field, "the first limit is the higher one");
  return result;
}

std::string material_name(const JsonFields& fields) {
  const std::string name = fields.text("name", sizeof Material::name - 1);
  if (std::any_of(name.begin(), name.end(), [](char c) { return c < 0x20 || c > 0x7e; }))
    fields.fail("name", "not printable ASCII");
  return name;
}

void parse_images(const JsonFields& fields, MaterialSpec& spec) {
  if (fields.has("sample")) {
    for (const char* image : {"albedo", "height", "normal", "roughness", "relief"}) {
      if (fields.has(image)) fields.fail(image, "not beside sample, which has its own");
    }
    spec.sample = fields.word("sample", {"grass", "rock", "strata", "sand", "snow", "ceiling"});
    return;
  }
  if (!fields.has("albedo")) fields.fail("albedo", "missing, and there is no sample");
  spec.albedo = fields.text("albedo", kMostPathBytes);
  if (fields.has("height")) spec.height = fields.text("height", kMostPathBytes);
  if (fields.has("normal")) spec.normal = fields.text("normal", kMostPathBytes);
  if (fields.has("relief")) spec.relief = fields.number("relief", 0, 1);
  if (!fields.has("roughness")) return;
  if (fields.get("roughness").is_string()) {
    spec.roughness = fields.text("roughness", kMostPathBytes);
  } else {
    spec.roughness_value = fields.number("roughness", 0, 1);
  }
}

MaterialSpec parse_material(const JsonFields& fields) {
  fields.only({"name", "sample", "albedo", "height", "normal", "roughness", "relief", "slope", "slope_soft",
               "elevation", "elevation_soft", "cave", "fray"});
  MaterialSpec spec;
  spec.name = material_name(fields);
  parse_images(fields, spec);
  if (fields.has("slope")) spec.slope = limits(fields, "slope", -1, 1);
  if (fields.has("slope_soft")) spec.slope_soft = fields.number("slope_soft", 0.001, 2);
  if (fields.has("elevation")) spec.elevation = limits(fields, "elevation", -kFarM, kFarM);
  if (fields.has("elevation_soft")) spec.elevation_soft = fields.number("elevation_soft", 1e-6, kFarM);
  if (fields.has("cave")) spec.cave = fields.number("cave", 0, 1);
  if (fields.has("fray")) spec.fray = fields.number("fray", 0, 1);
  return spec;
}

PaintBox parse_box(const JsonFields& fields) {
  fields.only({"center", "size", "material"});
  PaintBox box;
  box.centre_m = fields.vector("center", -kFarM, kFarM);
  box.size_m = fields.vector("size", 1e-6, kFarM);
  box.material = fields.text("material", sizeof Material::name - 1);
  return box;
}

BlendMapSpec parse_blend_map(const JsonFields& fields) {
  fields.only({"image", "materials"});
  BlendMapSpec map;
  map.image = fields.text("image", kMostPathBytes);
  for (const json& name : fields.list("materials", std::size(BlendMap().materials))) {
    const bool known = name.is_string() &&
                       std::find(map.materials.begin(), map.materials.end(), name) == map.materials.end();
    if (!known) {
      fields.fail("materials", "not names of materials, each once");
      break;
    }
    map.materials.push_back(name);
  }
  if (map.materials.empty()) fields.fail("materials", "an empty list; name the material of each channel");
  return map;
}

LightSpec parse_light(const JsonFields& fields) {
  fields.only({"position", "radius", "color"});
  LightSpec light;
  light.position_m = fields.vector("position", -kFarM, kFarM);
  light.radius_m = fields.number("radius", 1e-6, kFarM);
  light.colour = fields.vector("color", 0, 1'000);
  return light;
}

// One of T for each object in a list.
template <class T>
Error parse_list(const JsonFields& file, const std::string& name, const char* field, const char* one,
                 std::size_t most, T (*parse)(const JsonFields&), std::vector<T>& result) {
  if (!file.has(field)) return file.error();
  const json& list = file.list(field, most);
  if (!file.error().ok()) return file.error();
  for (std::size_t k = 0; k < list.size(); ++k) {
    const JsonFields fields(list[k], name + ": " + one + " " + std::to_string(k));
    result.push_back(parse(fields));
    if (!fields.error().ok()) return fields.error();
  }
  return {};
}

Error check_names(const std::vector<MaterialSpec>& materials, const std::string& name) {
  for (std::size_t k = 0; k < materials.size(); ++k) {
    for (std::size_t other = 0; other < k; ++other) {
      if (materials[other].name == materials[k].name) {
        return name + ": material " + std::to_string(k) + ": name: the same as of material " +
               std::to_string(other);
      }
    }
  }
  return {};
}

}  // namespace

Error parse_material_file(std::string_view text, const std::string& name, MaterialFile& file) {
  file = {};
  json root;
  if (Error error = parse_json(text, name, {}, "a material file", root); !error.ok()) return error;
  const JsonFields fields(root, name);
  fields.only({"side", "format", "repeat", "materials", "paint", "blend_map", "lights"});
  if (fields.has("side")) {
    const double side = fields.number("side", kLeastTextureSide, kMostTextureSide);
    if (side != static_cast<int>(side) || !std::has_single_bit(static_cast<unsigned>(side)))
      fields.fail("side", "not a power of two");
    file.side = static_cast<int>(side);
  }
  if (fields.has("format")) {
    file.format =
        fields.word("format", {"etc2", "rgba8"}) == "etc2" ? TextureFormat::etc2 : TextureFormat::rgba8;
  }
  if (fields.has("repeat")) file.repeat_m = fields.number("repeat", 1e-6, kFarM);
  Error error =
      parse_list(fields, name, "materials", "material", kMostMaterials, parse_material, file.materials);
  if (!error.ok()) return error;
  if (fields.has("materials") && file.materials.empty()) fields.fail("materials", "an empty list");
  if (!fields.error().ok()) return fields.error();
  if (error = check_names(file.materials, name); !error.ok()) return error;
  error = parse_list(fields, name, "paint", "paint", MaterialFile::kMostBoxes, parse_box, file.paint);
  if (error.ok() && fields.has("blend_map")) {
    const JsonFields map(fields.get("blend_map"), name + ": blend_map");
    file.blend_map = parse_blend_map(map);
    error = map.error();
  }
  if (!error.ok() || !fields.has("lights")) return error;
  return parse_list(fields, name, "lights", "light", kMostLights, parse_light, file.lights.emplace());
}

Error read_material_file(const std::string& path, MaterialFile& file) {
  std::string text;
  if (Error error = read_json_text(path, text); !error.ok()) return error;
  return parse_material_file(text, path, file);
}

}  // namespace karst::bake
