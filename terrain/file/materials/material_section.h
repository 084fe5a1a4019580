// SPDX-License-Identifier: MIT
// The sections of materials (MATL), of their textures (MTEX), of patches that have a material of their own
// (MOVR), of point lights (LGTS), of surroundings (SURR) and of painted weights (BMAP) in a world file: their
// checks, the same for reading and writing. For world_layout.cpp, world_reader.cpp and world_writer.cpp
// alone; docs/formats.md has the offsets.
#pragma once

#include "terrain/shading/materials.h"
#include "terrain/shading/surroundings.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::core::material_section {

inline constexpr std::size_t kHeaderBytes = 16;  // count, side, format, repeat_log2
inline constexpr std::size_t kMostImages = kTextureArrays * kMostTextureLevels * kMostMaterials;
inline constexpr std::size_t kMostBytes =
    kHeaderBytes + kMostMaterials * sizeof(Material) + kMostImages * sizeof(std::uint32_t);

// Images have a checksum each, so that they can be read alone: array by array, level by level, layer by
// layer.
std::size_t image_count(const MaterialSet& set);
std::size_t image_index(const MaterialSet& set, TextureArray array, int level, std::uint32_t layer);

// Of MATL.
std::size_t section_bytes(const MaterialSet& set);

struct Fault {
  const char* what = nullptr;  // null: none
  std::size_t offset = 0;      // bytes from the section's start
};

// Numbers out of range, names that are none. A set of no materials has no section and no fault.
Fault check_set(const MaterialSet& set);
// Number, and each light's ranges.
Fault check_lights(std::span<const PointLight> lights);
// Of a world of this extent; offsets are those in SURR.
Fault check_surroundings(const Surroundings& surroundings, glm::ivec3 extent);
// rim: whole points of SURR.
Fault check_rim(std::span<const std::byte> rim);

// BMAP: width, depth, materials of the channels, a reserved word; a checksum of each row; then the rows, so
// that they can be read some at a time.
inline constexpr std::size_t kBlendHeaderBytes = 16;
std::size_t blend_section_bytes(const BlendMap& map);
// Of a world with so many materials. A map of no texels has no section and no fault.
Fault check_blend_map(const BlendMap& map, std::uint32_t materials);
// The header alone.
Fault decode_blend_map(std::span<const std::byte, kBlendHeaderBytes> header, std::uint32_t materials,
                       BlendMap& map);
void encode_blend_header(const BlendMap& map, std::span<std::byte, kBlendHeaderBytes> out);

// set is untouched and crcs are garbage on a fault. crcs: room for kMostImages, image_count() are written.
Fault decode(std::span<const std::byte> section, MaterialSet& set, std::span<std::uint32_t> crcs);

// out: section_bytes(set). Preconditions: check_set finds no fault, textures are texture_bytes(set).
void encode(const MaterialSet& set, std::span<const std::byte> textures, std::span<std::byte> out);

// Where an image begins in the texture data.
std::size_t image_offset(const MaterialSet& set, std::size_t index);

}  // namespace karst::core::material_section
