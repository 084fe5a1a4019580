// SPDX-License-Identifier: MIT
// The boxes of space that the sun's shadow maps cover: one to three, each around the eye and larger than the
// one before, the last one around the whole world where that is small enough. Splits by the practical scheme:
// F. Zhang, H. Sun, L. Xu, L. K. Lun, "Parallel-Split Shadow Maps for Large-scale Virtual Environments",
// 2006.
//
// Boxes are made so that they seldom change, because a map is drawn anew only when its box does:
//  - They reach equally far in all directions from the eye, and not only where it looks: turning the camera
//    changes nothing. That costs about half of a map's resolution.
//  - They move in steps of an eighth of their size, which are whole texels of a grid that depends on the sun
//    alone: the same point of the world falls on the same place in a texel wherever the camera is, and shadow
//    edges do not crawl.
//  - Levels of detail and morphing in a map are chosen for a place that moves in the same steps, by plain
//    distance (an apparent distance of morph.h with least_cos2 = 1). A map's surface is therefore within
//    error_px pixels, measured at the picture's centre, of the full one, like the picture's own, or within a
//    texel where that is more (select_casters.h). For a parallel view they are the picture's own.
// A box has no near end: whatever of the world lies towards the sun casts into it.
#pragma once

#include <span>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/view/camera.h"
#include "terrain/view/frustum.h"

namespace karst::core {

inline constexpr int kMostCascades = 3;

// Texels at a map's sides in which nothing is looked up: the filter and the offset along the normal reach
// beyond a point's own texel.
inline constexpr int kCascadeBorder = 4;

// Texels a side of a map: the least whose texels are no larger than a voxel in 256 voxels of reach, the most
// that every OpenGL ES 3.0 has. A box's steps of an eighth of its size are whole texels.
inline constexpr int kLeastCascadeSize = 512;
inline constexpr int kMostCascadeSize = 2048;
inline constexpr int kCascadeSizeStep = 16;

struct CascadeSettings {
  int count = 2;              // 0..kMostCascades
  int size = 1024;            // kLeastCascadeSize..kMostCascadeSize, a multiple of kCascadeSizeStep
  double reach_voxels = 256;  // 4..2^20: beyond it from the eye there are no shadows, if not in the world's
                              // box; 256 voxels in 1,024 texels are half a voxel each
  double nearest_voxels = 1;  // where the logarithmic split begins; above 0, at most a quarter of the reach
  // invalid_argument naming the first field outside its range.
  Status validate() const;
};

// Directions and range of depth that all cascades of a sun share. Lengths in voxels from the octree's minimum
// corner.
struct LightSpace {
  glm::dvec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};  // unit vectors in world axes; z is towards the sun
  double near_z = 1;  // where depth is 0: the world's point nearest to the sun; depth grows downwards
  double far_z = 0;   // where depth is 1
};

struct Cascade {
  // What the map is drawn for: levels and morphs are chosen for its place, and vertices are relative to its
  // voxel. Its direction means nothing.
  Camera eye;
  Frustum frustum;              // of casters: no near and no far plane
  Frustum inner;                // what lies in it is looked up in this map or a smaller one
  glm::mat4 clip_from_lattice;  // from lattice steps relative to eye.voxel
  glm::dvec2 low{0.0};          // of the box in light space, voxels
  double side = 1;              // voxels
  double texel = 1;             // voxels
  float least_cos2 = 1;         // of apparent distances: 1, or the picture's own if that is parallel

  // Whether the same surface makes the same map.
  bool same_as(const Cascade& other) const {
    return eye.voxel == other.eye.voxel && eye.fine == other.eye.fine && least_cos2 == other.least_cos2 &&
           clip_from_lattice == other.clip_from_lattice;
  }
};

struct FitCascades {
  CascadeSettings settings;

  // Inputs.
  const Camera* camera = nullptr;  // borrowed; only its place counts, and whether it is parallel
  glm::dvec3 to_sun{0, 1, 0};      // unit length
  LatticeBox world;                // of all that casts shadows

  // Outputs, borrowed: settings.count cascades, smallest first.
  LightSpace* light = nullptr;
  std::span<Cascade> cascades;

  // invalid_argument naming the first field that is missing or outside its range.
  Status validate() const;
  // Precondition: validate() is ok.
  void run() const;
};

}  // namespace karst::core
