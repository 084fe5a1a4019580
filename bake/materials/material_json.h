// SPDX-License-Identifier: MIT
// A material file: what the ground of a world is made of, in JSON (docs/materials.md). Distances are metres.
#pragma once

#include "platform/base/error.h"
#include "terrain/shading/materials.h"

#include <glm/vec3.hpp>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace karst::bake {
using namespace core;

// Two limits; a missing one is no limit.
using Limits = std::array<std::optional<double>, 2>;

struct MaterialSpec {
  std::string name;    // 1 to 15 bytes of printable ASCII
  std::string sample;  // a procedural material's name; or empty, and albedo is an image
  std::string albedo, height, normal, roughness;  // paths of images, as the file has them; may be empty
  double relief = 0.03;                           // repeats that height 1 is high
  double roughness_value = 0.85;                  // where there is no image

  // Rules; what is missing is the sample's, or no limit.
  std::optional<Limits> slope;      // of the normal's y
  std::optional<Limits> elevation;  // metres
  std::optional<double> slope_soft;
  std::optional<double> elevation_soft;  // metres
  std::optional<double> cave, fray;
};

struct PaintBox {
  glm::dvec3 centre_m{0}, size_m{0};
  std::string material;  // its name
};

// Painted weights: a channel of the image for each name.
struct BlendMapSpec {
  std::string image;                   // path, as the file has it
  std::vector<std::string> materials;  // 1 to 4 names, all different
};

struct LightSpec {
  glm::dvec3 position_m{0};
  double radius_m = 1;
  glm::dvec3 colour{1};  // linear
};

struct MaterialFile {
  std::optional<int> side;
  std::optional<TextureFormat> format;
  std::optional<double> repeat_m;       // that a texture covers at the first scale
  std::vector<MaterialSpec> materials;  // empty: the world's own
  std::vector<PaintBox> paint;
  std::optional<BlendMapSpec> blend_map;
  std::optional<std::vector<LightSpec>> lights;

  static constexpr std::size_t kMostBoxes = 10'000;
};

// text: the JSON; name: the file, for messages. The error names file, entry and field.
Error parse_material_file(std::string_view text, const std::string& name, MaterialFile& file);
Error read_material_file(const std::string& path, MaterialFile& file);

}  // namespace karst::bake
