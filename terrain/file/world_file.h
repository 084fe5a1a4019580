// SPDX-License-Identifier: MIT
// The .karst world file over bytes that the caller reads, maps and writes; docs/formats.md has it byte by
// byte. It holds the octree, and of patches the heights, the errors of their coarser levels, the boxes and
// the cones of normals; and, where the world has them, materials with their textures, and point lights.
// Patches are not stored: extraction makes them again, in the same order, and their counts tell whether it
// did.
//
// These functions have the whole file in memory: for writing, and for checking all of it. What draws reads it
// piece by piece (world_reader.h).
//
// Bytes are untrusted. read_world_info checks all that can be checked without the octree: sizes, ranges,
// checksums and that the counts fit the sections; the functions after it need a file that it accepted. Every
// error names the field; corrupt and unsupported carry its byte offset in value().
#pragma once

#include "karst/status.h"
#include "terrain/field/octree.h"
#include "terrain/measure/level_error.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/heights.h"
#include "terrain/shading/materials.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::core {

inline constexpr std::uint32_t kWorldFileVersion = 3;
inline constexpr std::size_t kWorldNameBytes = 64;
inline constexpr std::size_t kWorldSectionAlignment = 64;  // bytes, in the file
inline constexpr std::size_t kWorldAlignment = 4;          // bytes, of a whole file in memory

struct WorldInfo {
  double voxel_size_m = 1.0;  // metres, 1e-6..1e9
  double origin_m[3] = {};    // world position of the octree's minimum corner, metres, +-1e12
  glm::ivec3 extent{0};      // voxels in use: x, z in 2..2^depth, y in 1..2^depth - 1 (a layer of air on top)
  int depth = 0;             // of the octree, 1..9
  int level = 0;             // of the height blocks, 1..6
  std::uint32_t octets = 0;  // of the octree
  std::uint32_t volumes = 0;        // that extraction makes
  std::uint32_t patches = 0;        // that extraction makes
  std::uint32_t height_blocks = 0;  // patches that have heights
  char name[kWorldNameBytes] = {};  // printable ASCII, zero-terminated, zero to the end; may be empty
};

// The sections, in the order in which they are written. The last four may be missing.
enum class WorldSection : std::uint8_t {
  octree,
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
  lights
};
inline constexpr std::size_t kWorldSections = 8;  // that every world has
inline constexpr std::size_t kWorldSectionKinds = 12;

struct WorldSectionPlace {
  std::uint64_t offset = 0;  // bytes from the start of the file
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
  std::size_t entry = 0;  // offset of its entry in the section table
  bool present = false;
};
using WorldSections = std::array<WorldSectionPlace, kWorldSectionKinds>;

// Groups of height blocks (heights.h): each has a checksum of its own, so that it can be read alone. The last
// one may be shorter.
constexpr std::uint32_t height_groups(std::uint32_t blocks) {
  return (blocks + kHeightGroup - 1) / kHeightGroup;
}

// What belongs to patches, as it lies in the file. Blocks are in the order of the patches whose bit is set.
struct WorldPatches {
  std::span<const std::byte> mask;  // (patches + 7) / 8 bytes; bit p % 8 of byte p / 8: patch p has heights
  std::span<const std::int16_t>
      samples;  // height_blocks x patch_vertices(level), lattice steps, +-kMaxHeight
  std::span<const std::uint16_t> level_errors =
      {};                                    // of all patches, with heights or without: LevelErrors::values
  std::span<const PatchBounds> bounds = {};  // of all patches
  std::span<const NormalCone> cones = {};    // of all patches
  std::span<const NormalCone> shading_cones = {};  // shading_cone.h: of all patches, or empty: not known
};

// What the ground is made of, and what lights it, as it lies in the file; all of it may be missing.
struct WorldMaterials {
  MaterialSet set;
  std::span<const std::byte> textures = {};      // texture_bytes(set)
  std::span<const std::uint8_t> overrides = {};  // empty, or of all patches: 0, or 1 + its material
  std::span<const PointLight> lights = {};       // at most kMostLights
};

// Ranges of the fields alone. invalid_argument names the first field that is out of its range.
Status validate_world_info(const WorldInfo& info);

// Checks the whole file and reads its header. info is untouched on failure. file must be aligned to 2 bytes
// (invalid_argument), which every mapping and heap block is.
// corrupt: the bytes contradict themselves; unsupported: another version, or a required section of unknown
// kind.
Status read_world_info(std::span<const std::byte> file, WorldInfo& info);

// Replaces the octree's contents, depth included. The octree is empty on failure.
// limit_reached ("max_octets", value: info.octets) where its pool is smaller; corrupt where the section's
// nodes do not make a tree of info.octets octets, fully collapsed, filled only inside the extent.
Status read_octree(std::span<const std::byte> file, const WorldInfo& info, Octree& tree);

// Views into file; no copy. Valid as long as file is.
WorldPatches read_patches(std::span<const std::byte> file, const WorldInfo& info);

WorldMaterials read_materials(std::span<const std::byte> file, const WorldInfo& info);

// Exact length of the file that write_world makes for a valid info; SIZE_MAX where that does not fit size_t.
std::size_t world_file_bytes(const WorldInfo& info);
std::size_t world_file_bytes(const WorldInfo& info, const WorldMaterials& materials);

// Writes the file to out. written is world_file_bytes(info) on success and 0 on failure, when out holds
// garbage. invalid_argument: a field is out of range or contradicts another (same rules as for reading).
// limit_reached ("out", value: bytes that are needed) where out is too short.
Status write_world(const WorldInfo& info, const Octree& tree, const WorldPatches& patches,
                   const WorldMaterials& materials, std::span<std::byte> out, std::size_t& written);
Status write_world(const WorldInfo& info, const Octree& tree, const WorldPatches& patches,
                   std::span<std::byte> out, std::size_t& written);

}  // namespace karst::core
