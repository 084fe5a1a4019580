// SPDX-License-Identifier: MIT
// The patches of each of the 256 configurations of an intersection volume (K 3.4.2, figures 3.12 - 3.17),
// generated at compile time from the rules of design 4.2, not typed in.
//
// Units: half a voxel, so the volume is the cube [-1, 1]^3, its corners are voxel centres and its centre L a
// voxel corner. Octant o = x + 2y + 4z. Face f = 2 * axis + (1 for the positive side); opposite of f is f
// ^ 1.
#pragma once

#include <array>
#include <cstdint>

namespace karst::core {

inline constexpr int kMaxCasePatches = 4;  // checked when the tables are made
inline constexpr int kFaceCurves = 2;      // on one face: two where two filled voxels are diagonal

// Where an edge of a patch leads.
struct CaseEdge {
  enum Kind : std::uint8_t { external, internal, collapsed };
  Kind kind = collapsed;
  std::uint8_t a = 0;  // external: face; internal: patch in this configuration
  std::uint8_t b = 0;  // external: curve on that face; internal: edge of that patch
};

struct PatchCase {
  // Control points [j][i][axis], each in {-1, 0, 1}; j along v, i along u (surface.h).
  std::array<std::array<std::array<std::int8_t, 3>, 3>, 3> control{};
  std::array<CaseEdge, 4> edge{};  // edge 3 is the collapsed one, if any
};

struct ConfigurationCase {
  std::uint8_t patch_count = 0;
  std::uint8_t loop_count = 0;
  std::array<PatchCase, kMaxCasePatches> patch{};
  // The patch and edge that run along a face's curve: patch << 2 | edge, kNoCurve where there is none. Two
  // volumes that share a face number its curves alike: by the lowest octant that a curve goes around.
  std::array<std::array<std::uint8_t, kFaceCurves>, 6> curve{};
};

inline constexpr std::uint8_t kNoCurve = 0xff;

// One curve of a loop: it starts at an edge point and goes over the face's centre to the next curve's start.
struct LoopCurve {
  std::array<std::int8_t, 3> start{};
  std::uint8_t face = 0;
  std::uint8_t curve = 0;
  bool straight = false;  // its two edge points lie opposite; else it turns a corner
};

// A closed loop of 3 to 7 curves, counter-clockwise as seen from the empty side.
struct Loop {
  int size = 0;
  std::array<LoopCurve, 7> curve{};
};

struct Loops {
  int count = 0;
  std::array<Loop, 4> loop{};
};

// The loops of a configuration (0..255).
Loops configuration_loops(int configuration);

extern const std::array<ConfigurationCase, 256> kCaseTable;

}  // namespace karst::core
