// SPDX-License-Identifier: MIT
// What a .karst world file holds; docs/formats.md has it byte by byte. The octree; of patches their keys, the
// heights, the errors of their coarser levels, the boxes and the cones of normals; and, where the world has
// them, materials with their textures, point lights, and what is around the ground. Patches are not stored:
// extraction makes them again, and their keys (patch_key.h) say which is which.
//
// Read by WorldReader (world_reader.h), written by WorldWriter (world_writer.h).
//
// Bytes are untrusted. Every error names the field; corrupt and unsupported carry its byte offset in value().
#pragma once

#include "karst/status.h"
#include "terrain/basis/georeference.h"
#include "terrain/ground/tile.h"
#include "terrain/imagery/image_tile.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/heights.h"
#include "terrain/shading/materials.h"
#include "terrain/shading/surroundings.h"
#include "terrain/surface/patch_key.h"

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::core {

inline constexpr std::uint32_t kWorldFileVersion = 5;
inline constexpr std::size_t kWorldNameBytes = 64;
inline constexpr std::size_t kWorldSectionAlignment = 64;  // bytes, in the file

struct WorldInfo {
  double voxel_size_m = 1.0;  // metres, 1e-6..1e9
  double origin_m[3] = {};    // world position of the octrees' minimum corner, metres, +-1e12
  // Voxels in use: x, z in 2..2^depth, y in 1..2^depth - 1 (a layer of air on top). Of several octrees, which
  // are regions of a ground, the most; the counts below are of all.
  glm::ivec3 extent{0};
  int depth = 0;                    // of the octree, 1..9; the same
  std::uint32_t regions = 1;        // octrees, 1..kMostRegions
  int level = 0;                    // of the height blocks, 1..6
  std::uint32_t octets = 0;         // of the octree
  std::uint32_t volumes = 0;        // that extraction makes
  std::uint32_t patches = 0;        // that extraction makes
  std::uint32_t height_blocks = 0;  // patches that have heights
  char name[kWorldNameBytes] = {};  // printable ASCII, zero-terminated, zero to the end; may be empty
};

// The sections, in the order in which they are written, but tiles, which are written first. Those after the
// first nine may be missing.
enum class WorldSection : std::uint8_t {
  octree,
  keys,
  mask,
  samples,
  sample_crcs,
  level_errors,
  bounds,
  cones,
  shading_cones,
  materials,
  textures,
  overrides,
  lights,
  surroundings,
  blend_map,
  ground,
  tiles,
  region,
  imagery,
  field
};
inline constexpr std::size_t kWorldSections = 9;  // that every world has
inline constexpr std::size_t kWorldSectionKinds = 20;

// Groups of height blocks (heights.h): each has a checksum of its own, so that it can be read alone. The last
// one may be shorter.
constexpr std::uint32_t height_groups(std::uint32_t blocks) {
  return (blocks + kHeightGroup - 1) / kHeightGroup;
}

// What belongs to patches, as it lies in the file: in the order of their keys, which ascend. Blocks are in
// the order of the patches whose bit is set.
struct WorldPatches {
  std::span<const PatchKey> keys;
  std::span<const std::byte> mask;  // (patches + 7) / 8 bytes; bit p % 8 of byte p / 8: patch p has heights
  std::span<const std::int16_t>
      samples;  // height_blocks x patch_vertices(level), lattice steps, +-kMaxHeight
  std::span<const std::uint16_t> level_errors =
      {};                                    // of all patches, with heights or without: LevelErrors::values
  std::span<const PatchBounds> bounds = {};  // of all patches
  std::span<const NormalCone> cones = {};    // of all patches
  std::span<const NormalCone> shading_cones = {};  // shading_cone.h: of all patches, or empty: not known
};

// What the ground is made of, what lights it and what is around it, as it lies in the file; all of it may be
// missing.
struct WorldMaterials {
  MaterialSet set;
  std::span<const std::byte> textures = {};  // texture_bytes(set)
  // Empty, or of all patches: 0, or 1 + its material, or kPaintedByMap.
  std::span<const std::uint8_t> overrides = {};
  std::span<const PointLight> lights = {};  // at most kMostLights
  Surroundings surroundings = {};
  std::span<const glm::ivec3> rim = {};       // surroundings.rim_points
  std::span<const std::byte> blend_map = {};  // texels of set.blend_map, row by row
};

// The ground (terrain/ground/ground.h). A world may have one and no patches: then the octree is empty,
// voxel_size_m is the length of kStepsPerVoxel steps, and sample (0, 0) at height 0 lies at origin_m; of a
// curved basis the frame's origin does, which is 0. With patches they are its regions: place_regions() was
// called, and the counts are those of each.
struct WorldGround {
  GroundInfo info;  // does not exist: the world has no ground
  Georeference earth;
  TilePlace root;  // offsets of places count from where the tiles begin
  std::uint64_t tile_bytes = 0;
  std::uint32_t tile_crc = 0;  // of all of them
  ImageryInfo imagery;         // its tiles lie among those of the ground
  TilePlace image_root;        // of size info.top_size(); must exist where imagery does
};

// Ranges of the fields alone. invalid_argument names the first field that is out of its range.
Status validate_world_info(const WorldInfo& info);

}  // namespace karst::core
