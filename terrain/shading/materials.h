// SPDX-License-Identifier: MIT
// What the ground is made of: materials with the rules of where they lie, the layout of their textures, and
// point lights. Plain values as they lie in the world file (docs/formats.md); terrain/world/world.h hands
// them out, the renderer's shader covers the ground with them.
#pragma once

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace karst::core {

inline constexpr int kMostMaterials = 8;  // layers of the texture arrays
inline constexpr int kMostLights = 16;

enum class TextureFormat : std::uint8_t {
  rgba8 = 0,
  etc2 = 1,  // blocks of 4 x 4 texels, 16 bytes: EAC alpha, then ETC2 colour
};

// Where a material lies. Materials cover each other in order: a later one hides the earlier where it covers.
// The first lies everywhere. Coverage of a value v by (low, high, soft):
//   smoothstep(low - soft, low + soft, v) * (1 - smoothstep(high - soft, high + soft, v))
struct Material {
  char name[16] = {};                                             // printable ASCII, zero to the end
  float slope_low = -2, slope_high = 2, slope_soft = 0.1f;        // of the normal's y, -1..1; soft > 0
  float height_low = -1e6f, height_high = 1e6f, height_soft = 1;  // voxels from the octree's minimum corner
  float cave = 0;                // 0..1: how much it also covers where the ground lies under rock
  float fray = 0;                // 0..1: share of the softness that noise moves the limits by
  float average[3] = {1, 1, 1};  // linear albedo of the coarsest mip as the texture holds it, decoded
  float roughness = 1;           // of the coarsest mip
};
static_assert(sizeof(Material) == 64 && std::is_trivially_copyable_v<Material>);

// K equation 4.2.
struct PointLight {
  glm::vec3 position{0};  // voxels from the octree's minimum corner
  float radius = 1;       // voxels
  glm::vec3 colour{1};    // linear
  float reserved = 0;
};
static_assert(sizeof(PointLight) == 32 && std::is_trivially_copyable_v<PointLight>);

struct MaterialSet {
  std::uint32_t count = 0;  // 0: the world has none
  std::uint32_t side = 0;   // texels of a texture's side: a power of two, 16..1024
  TextureFormat format = TextureFormat::rgba8;
  Material materials[kMostMaterials] = {};
};

// --- Textures: two arrays of `count` layers with full pyramids, which tile.

enum class TextureArray : std::uint8_t {
  // sRGB albedo; alpha: height 0..1, linear. GL_SRGB8_ALPHA8 or GL_COMPRESSED_SRGB8_ALPHA8_ETC2_EAC.
  albedo_height = 0,
  // r and b: roughness; a and g: the normal's s and t parts, codes 128 + 127 times the part. GL_RGBA8 or
  // GL_COMPRESSED_RGBA8_ETC2_EAC.
  normal_roughness = 1,
};
inline constexpr std::size_t kTextureArrays = 2;
inline constexpr std::uint32_t kLeastTextureSide = 16;
inline constexpr std::uint32_t kMostTextureSide = 1024;
inline constexpr std::size_t kMostTextureLevels = 11;

// Levels of a pyramid down to one texel.
constexpr int texture_levels(std::uint32_t side) {
  int levels = 0;
  for (; side > 0; side /= 2) ++levels;
  return levels;
}

// Bytes of one layer of a level. 0 <= level < texture_levels(side).
constexpr std::size_t texture_image_bytes(TextureFormat format, std::uint32_t side, int level) {
  const std::size_t texels = side >> level;
  if (format == TextureFormat::rgba8) return texels * texels * 4;
  const std::size_t blocks = (texels + 3) / 4;
  return blocks * blocks * 16;
}

// Where an image begins in the texture data: array by array, in it level by level from the finest, in a level
// layer by layer. layer may be count: the end of the level.
constexpr std::size_t texture_offset(const MaterialSet& set, TextureArray array, int level,
                                     std::uint32_t layer) {
  std::size_t pyramid = 0;
  std::size_t before = 0;
  for (int k = 0; k < texture_levels(set.side); ++k) {
    const std::size_t bytes = texture_image_bytes(set.format, set.side, k);
    pyramid += bytes;
    if (k < level) before += bytes;
  }
  const std::size_t first = array == TextureArray::albedo_height ? 0 : pyramid * set.count;
  return first + before * set.count + texture_image_bytes(set.format, set.side, level) * layer;
}

// Of all texture data.
constexpr std::size_t texture_bytes(const MaterialSet& set) {
  return set.count == 0
             ? 0
             : texture_offset(set, TextureArray::normal_roughness, texture_levels(set.side) - 1, set.count);
}

}  // namespace karst::core
