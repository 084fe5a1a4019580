// SPDX-License-Identifier: MIT
// What the ground of a baked world is made of, and its lights: images, rules, textures, painted patches.
#pragma once

#include "app/bake/material_image.h"
#include "app/bake/material_json.h"
#include "app/bake/material_rules.h"
#include "app/bake/solid.h"
#include "terrain/surface/surface.h"
#include "terrain/voxel/octree.h"
#include "terrain/world/world_file.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace karst::bake {

inline constexpr int kDefaultMaterialSide = 256;
inline constexpr TextureFormat kDefaultTextureFormat = TextureFormat::rgba8;

// What the command line says. What it does not say, the file says, or else the defaults.
struct MaterialOptions {
  bool none = false;   // the world has no materials and no lights
  std::string path{};  // of a material file; empty: none
  std::optional<int> side{};
  std::optional<TextureFormat> format{};
};

struct BakedMaterials {
  MaterialSet set;
  std::vector<std::byte> textures;
  std::vector<std::uint8_t> overrides;
  std::vector<PointLight> lights;
  std::size_t painted = 0;  // patches

  WorldMaterials view() const { return {set, textures, overrides, lights}; }
};

// Borrows what it is given for the run.
struct BakeMaterials {
  MaterialOptions options;
  std::string sample;  // of the world; empty: an elevation image
  WorldGrid grid;
  const Octree* octree = nullptr;
  Surface surface;
  std::span<const PatchBounds> bounds;
  int threads = 1;

  // Throws BakeError naming the material file or the image, and the field.
  BakedMaterials run() const;

 private:
  WorldRelief relief() const;
  Material resolve(const MaterialSpec& spec) const;
  std::vector<MaterialImage> read_images(const std::vector<MaterialSpec>& specs, int side) const;
  void paint(const MaterialFile& file, BakedMaterials& baked) const;
  void light(const MaterialFile& file, BakedMaterials& baked) const;
  glm::dvec3 to_voxels(glm::dvec3 position_m) const { return (position_m - grid.origin_m) / grid.voxel_m; }
};

}  // namespace karst::bake
