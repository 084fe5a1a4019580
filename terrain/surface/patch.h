// SPDX-License-Identifier: MIT
// The extracted surface: intersection volumes that hold surface, and the biquadratic patches in them.
// Plain arrays. As extraction makes them, patches of one volume are contiguous and both arrays follow the
// octree's order in space. Once patches have slots (patch_table.h) and voxels were edited
// (bezier/update_surface.h), neither holds, and slots may be free; a volume's patches are then found by key.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/lattice.h"

namespace karst::core {

using PatchId = std::uint32_t;

// One intersection volume (K 3.4): the cube of one voxel's size centred on a voxel corner. 32 bytes.
struct Volume {
  std::uint16_t corner[3];     // its centre, voxels from the octree's minimum corner
  std::uint8_t configuration;  // bit o: the voxel in octant o (x + 2y + 4z) is filled
  std::uint8_t patch_count;    // 1..4; 0: the slot is free
  // Gradient of the smoothed occupancy at the eight voxel centres around the corner, by octant, pointing from
  // filled to empty; kernel weights are integers, so |component| <= 48 (gradient.h).
  std::int8_t gradient[8][3];
};

// Names one edge of one patch, or none where the surface ends (a side or the bottom of the world).
struct PatchEdge {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::uint32_t bits = kNone;  // patch << 2 | edge

  static constexpr PatchEdge make(PatchId patch, int edge) {
    return {patch << 2 | static_cast<std::uint32_t>(edge)};
  }
  constexpr bool exists() const { return bits != kNone; }
  constexpr PatchId patch() const { return bits >> 2; }
  constexpr int edge() const { return static_cast<int>(bits & 3u); }
  friend constexpr bool operator==(PatchEdge, PatchEdge) = default;
};

inline constexpr std::uint32_t kMaxPatchId = (1u << 30) - 2;  // so that patch << 2 | edge is never kNone

// One biquadratic Bézier patch. Its grid has i along u and j along v, and u x v points out of the solid.
// Corners run counter-clockwise: 0 = (0,0), 1 = (1,0), 2 = (1,1), 3 = (0,1); edge e runs from corner e to
// corner (e+1) mod 4. A three-edge patch has edge 3 collapsed into corner 0 (K figure 3.12). 28 bytes.
struct Patch {
  std::uint32_t volume;     // index into Surface::volumes, or kNoVolume: the slot is free
  std::uint8_t case_patch;  // index among the patches of the volume's configuration (case_tables.h)
  std::uint8_t size_log2;   // voxels a side of its volume, as a power of two; extraction makes 0 only
  std::uint8_t collapsed;   // 1 when edge 3 is a point
  std::uint8_t reserved = 0;
  std::uint32_t height_block;  // index of its block of heights (heights.h), or kNoHeights
  // The edge that lies on this one, by edge; it runs the other way. A collapsed edge has none.
  PatchEdge neighbour[4];
};

inline constexpr std::uint32_t kNoHeights = 0xffffffffu;
inline constexpr std::uint32_t kNoVolume = 0xffffffffu;

// Where a free slot's patch would lie, voxels: beyond everything.
inline constexpr std::uint16_t kFreeCorner = 1u << 13;
inline constexpr Volume kFreeVolume{{kFreeCorner, kFreeCorner, kFreeCorner}, 0, 0, {}};

struct Surface {
  std::span<const Volume> volumes;
  std::span<const Patch> patches;

  bool is_free(PatchId id) const { return patches[id].volume == kNoVolume; }
  // kFreeVolume of a free slot.
  const Volume& volume_of(PatchId id) const {
    return is_free(id) ? kFreeVolume : volumes[patches[id].volume];
  }
};

// A patch's origin on the lattice, in steps: the centre of its intersection volume.
inline glm::ivec3 patch_origin(const Volume& v) {
  return glm::ivec3(v.corner[0], v.corner[1], v.corner[2]) * kStepsPerVoxel;
}

}  // namespace karst::core
