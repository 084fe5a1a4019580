// SPDX-License-Identifier: MIT
// What the ground of a baked world is made of, and its lights: images, rules, textures, painted patches.
#pragma once

#include "bake/elevation/solid.h"
#include "bake/materials/material_json.h"
#include "bake/materials/material_rules.h"
#include "bake/textures/material_image.h"
#include "bake/textures/texture_pyramid.h"
#include "platform/base/error.h"
#include "terrain/field/octree.h"
#include "terrain/file/world_file.h"
#include "terrain/surface/patch.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace karst::bake {
using namespace core;

inline constexpr int kDefaultMaterialSide = 256;
// Texels that a material file's textures may have together by its own side; the command line's may have more.
inline constexpr int kMostFileTexels = 1 << 19;
inline constexpr TextureFormat kDefaultTextureFormat = TextureFormat::etc2;

// What the command line says. What it does not say, the file says, or else the defaults.
struct MaterialOptions {
  bool none = false;   // the world has no materials and no lights
  std::string path{};  // of a material file; empty: none
  std::optional<int> side{};
  std::optional<TextureFormat> format{};
  // Of images, though their files are too short to hold so many. TexelBudget says what may be without it.
  std::uint64_t max_texels = 0;
};

// The images that a material file names; none where it cannot be read, which load() tells.
std::vector<std::string> material_images(const MaterialOptions& options);

struct BakedMaterials {
  MaterialSet set;
  std::vector<std::byte> textures;
  std::vector<std::uint8_t> overrides;
  std::vector<PointLight> lights;
  std::vector<std::byte> blend_map;  // texels of set.blend_map
  std::size_t painted = 0;           // patches, by boxes
  std::size_t under_map = 0;         // and by the blend map, in part or whole
  TextureLoss loss;

  WorldMaterials view() const {
    WorldMaterials world{set, textures, overrides, lights};
    world.blend_map = blend_map;
    return world;
  }
};

// Two steps: load() reads files, before the work of a bake, so that a mistake in them costs no time; run()
// needs what the bake made. Borrows what it is given.
class BakeMaterials {
 public:
  MaterialOptions options;
  int threads = 1;

  // The error names the material file or the image, and the field.
  Error load();

  std::string sample;  // of the world; empty: an elevation image
  WorldGrid grid;
  const Octree* octree = nullptr;
  Surface surface;
  std::span<const PatchBounds> bounds;

  // Of a ground: its least and greatest height, voxels. None: of the surface.
  std::optional<std::array<float, 2>> heights{};

  // What run() makes but for textures, whose bytes are counted by texture_bytes().
  Error outline(BakedMaterials& baked) const;
  // Whether the file paints patches, which a ground does not have.
  bool paints() const { return !file_.paint.empty() || file_.blend_map.has_value(); }

  // Once: uses up what load() read. An error where the file paints with a material that is not there, by
  // boxes or by its blend map.
  Error run(BakedMaterials& baked);

 private:
  WorldRelief relief() const;
  static int number_of(const MaterialSet& set, const std::string& name);
  Material resolve(const MaterialSpec& spec) const;
  std::vector<MaterialSpec> list(MaterialSet& set) const;
  Error check_side() const;
  Error paint(BakedMaterials& baked) const;
  Error blend(BakedMaterials& baked) const;
  void mark_painted(BakedMaterials& baked) const;
  void light(BakedMaterials& baked) const;
  int side() const { return options.side.value_or(file_.side.value_or(kDefaultMaterialSide)); }
  glm::dvec3 to_voxels(glm::dvec3 position_m) const { return (position_m - grid.origin_m) / grid.voxel_m; }

  MaterialFile file_;
  std::vector<MaterialImage> images_;  // of the file's materials; empty ones are procedural
  BlendMap map_;                       // without its materials
  std::vector<std::byte> map_texels_;
};

}  // namespace karst::bake
