// SPDX-License-Identifier: MIT
// What the ground is made of: materials with the rules of where they lie, the layout of their textures, and
// point lights. Plain values as they lie in the world file (docs/formats.md); terrain/world/world.h hands
// them out, the renderer's shader covers the ground with them.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace karst::core {

inline constexpr int kMostMaterials = 8;  // layers of the texture arrays
inline constexpr int kMostLights = 16;

enum class TextureFormat : std::uint8_t {
  rgba8 = 0,
  etc2 = 1,   // blocks of 4 x 4 texels, 16 bytes: EAC alpha, then ETC2 colour
  rgba4 = 2,  // 16 bits a texel, r in the highest four
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
  float average[3] = {1, 1, 1};  // linear albedo
  float roughness = 1;           // of the whole texture seen from afar, all bumps in it
  // Of the near array. Linear albedo is the far array's times 1 + tint * (brightness - 1).
  float tint[3] = {1, 1, 1};
  float brightness_span = 1;  // brightness is within 1 - span .. 1 + 8/7 span
  float slope_span = 1;       // slopes are within -span .. 8/7 span
};
static_assert(sizeof(Material) == 84 && std::is_trivially_copyable_v<Material>);

// K equation 4.2.
struct PointLight {
  glm::vec3 position{0};  // voxels from the octree's minimum corner
  float radius = 1;       // voxels
  glm::vec3 colour{1};    // linear
  float reserved = 0;
};
static_assert(sizeof(PointLight) == 32 && std::is_trivially_copyable_v<PointLight>);

// Painted weights over the ground, K 6.2: an image seen from above over the world's content (BlendSpan); its
// first row lies at the least z, in the north. A texel has a weight for each of up to four materials, of 255;
// what is left to 255 the rules have. What faces down and caves are not painted.
struct BlendMap {
  std::uint32_t width = 0, depth = 0;  // texels along x and z, both 0 or both 1..kMostBlendSide
  std::uint8_t materials[4] = {};      // of r, g, b, a: the material's number plus 1; 0: the channel has none

  bool exists() const { return width > 0; }
};
inline constexpr std::uint32_t kMostBlendSide = 1024;
inline constexpr std::size_t kBlendTexelBytes = 4;
// Of the texture: each half as wide as the one before. So a place mixes texels up to 12 from its own at most,
// and which patches are painted is known.
inline constexpr int kMostBlendLevels = 4;

// What a world's blend map lies over, voxels from the world's corner along x and z: voxels reach from half a
// voxel within their sides, a ground from its first samples to its last ones.
struct BlendSpan {
  glm::dvec2 low{0.5};
  glm::dvec2 size{1};

  static BlendSpan of_voxels(glm::ivec3 extent) {
    const auto side = [](int voxels) { return voxels > 1 ? voxels - 1.0 : 1.0; };
    return {glm::dvec2(0.5), {side(extent.x), side(extent.z)}};
  }
};

// As an override of a patch: some of it may be painted, so that each of its pixels is decided on its own.
inline constexpr std::uint8_t kPaintedByMap = 255;

struct MaterialSet {
  std::uint32_t count = 0;                      // 0: the world has none
  std::uint32_t side = 0;                       // texels of a near texture's side: a power of two, 16..1024
  TextureFormat format = TextureFormat::rgba8;  // or etc2; near textures are rgba4 then
  std::int32_t repeat_log2 = 0;  // a near texture covers 2^this voxels, -16..5; a far one 16 times as many;
                                 // and so on from afar
  Material materials[kMostMaterials] = {};
  BlendMap blend_map;  // of a section of its own
};

// --- Textures: two arrays of `count` layers with full pyramids, which tile. Both hold the same images, of
// which the far one is looked up at the larger scale for what colour lies where, and the near one for detail.
//
// ETC2 keeps channels that go together, and alpha. Those of the near array do not: at four bits each they
// take twice the memory of ETC2 and come out better (docs/materials.md).

enum class TextureArray : std::uint8_t {
  // Half as many texels a side. r, g, b: albedo, sRGB; a: roughness.
  far = 0,
  // r: brightness, luminance by that of the whole texture; g: height 0..1; b, a: slope of the height along s
  // and t. Codes of r, b and a: NearCodes.
  near = 1,
};

// A code c of the near array stands for base + span * (c - middle) / steps. base: 1 of brightness, 0 of
// slopes, which are codes so; span: Material's.
struct NearCodes {
  int most, middle, steps;
};
constexpr NearCodes near_codes(TextureFormat format) {
  return format == TextureFormat::rgba4 ? NearCodes{15, 7, 7} : NearCodes{255, 128, 127};
}

inline constexpr std::size_t kTextureArrays = 2;
inline constexpr std::uint32_t kLeastTextureSide = 16;
inline constexpr std::uint32_t kMostTextureSide = 1024;
inline constexpr std::size_t kMostTextureLevels = 11;
inline constexpr std::int32_t kLeastRepeatLog2 = -16;
inline constexpr std::int32_t kMostRepeatLog2 = 5;

constexpr std::uint32_t texture_side(std::uint32_t side, TextureArray array) {
  return array == TextureArray::far ? side / 2 : side;
}

// Of an array's images, by a set's format.
constexpr TextureFormat texture_format(TextureFormat format, TextureArray array) {
  return format == TextureFormat::etc2 && array == TextureArray::near ? TextureFormat::rgba4 : format;
}

// Levels of a pyramid down to one texel.
constexpr int texture_levels(std::uint32_t side, TextureArray array) {
  int levels = 0;
  for (std::uint32_t texels = texture_side(side, array); texels > 0; texels /= 2) ++levels;
  return levels;
}

// Bytes of one layer of a level, by a set's format and side. 0 <= level < texture_levels(side, array).
constexpr std::size_t texture_image_bytes(TextureFormat format, std::uint32_t side, TextureArray array,
                                          int level) {
  const std::size_t texels = texture_side(side, array) >> level;
  switch (texture_format(format, array)) {
    case TextureFormat::rgba8:
      return texels * texels * 4;
    case TextureFormat::rgba4:
      return texels * texels * 2;
    case TextureFormat::etc2:
      break;
  }
  const std::size_t blocks = (texels + 3) / 4;
  return blocks * blocks * 16;
}

// Bytes of one layer's levels before `level`.
constexpr std::size_t texture_levels_bytes(TextureFormat format, std::uint32_t side, TextureArray array,
                                           int level) {
  std::size_t bytes = 0;
  for (int k = 0; k < level; ++k) bytes += texture_image_bytes(format, side, array, k);
  return bytes;
}

// Where an image begins in the texture data: array by array, in it level by level from the finest, in a level
// layer by layer. layer may be count: the end of the level.
constexpr std::size_t texture_offset(const MaterialSet& set, TextureArray array, int level,
                                     std::uint32_t layer) {
  const std::size_t first = array == TextureArray::far
                                ? 0
                                : texture_levels_bytes(set.format, set.side, TextureArray::far,
                                                       texture_levels(set.side, TextureArray::far));
  const std::size_t before = first + texture_levels_bytes(set.format, set.side, array, level);
  return before * set.count + texture_image_bytes(set.format, set.side, array, level) * layer;
}

// Of all texture data.
constexpr std::size_t texture_bytes(const MaterialSet& set) {
  if (set.count == 0) return 0;
  const int levels = texture_levels(set.side, TextureArray::near);
  return texture_offset(set, TextureArray::near, levels - 1, set.count);
}

}  // namespace karst::core
