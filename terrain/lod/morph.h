// SPDX-License-Identifier: MIT
// Where a vertex of a level morphs, so that no drawn point is further than a stated number of pixels from the
// full-level surface, nothing pops and nothing cracks (design 4.7; K 4.4.2 and 4.4.4). The formulas of
// a vertex are stated once, here; vertex shaders repeat them.
//
// Apparent distance. Seen at distance r and angle theta from the view's axis, a deviation of length e covers
// at most S e / (rho - e) pixels, S being pixels per radian at the axis and rho = r cos^2 theta: by it, not
// by r, vertices morph. Inside the picture rho = z^2 / r; outside, cos theta stays at that of the picture's
// corner. The axis is the direction in which clip w grows. Across it a picture is a linear map of the
// tangents to pixels, and a shift: an axis off the picture's centre, a roll and a mirror change no length,
// and where pixels are not square S is what the map's longest direction gives. So the bound holds for any
// perspective. In a parallel view e covers at most e pixels times a constant, wherever it is: rho is
// kParallelDistance everywhere, and S that constant times rho, with which S e / (rho - e) is a little more.
// rho does not change from place to place, so that what follows holds as well. Departure from design 4.7,
// which uses r: for the same proven bound at the corner r has to be 1 / cos^2 = 2.4 times as large everywhere
// (60 degrees, 16:9), which takes twice the triangles.
//
// Thresholds. A vertex of level m is at home up to (1 - sigma) D, from D on at its morph target, between them
// on the line in between; D is the threshold D(m) of its patch, on an edge the smaller one of the two
// patches. A patch is drawn at the least level whose dropped vertices have all arrived. With G = 2 / sqrt 3,
// the most that rho changes a step, and R = G times the diagonal of the patch's box,
//   (1)  D(m) >= (S / error_px + 1) error(m - 1) + G reach(m) / (1 - sigma)
//   (2)  (1 - sigma) D'(m - 1) >= D(m) + R    for the D' of the patch and of its neighbours
// or D(m) = 0 where error(m - 1) = 0. What follows from them:
//  - Everywhere in a patch that is drawn at level m, rho < D(m) + R; so by (2) no vertex of a lower level has
//    left home in it or on its border, and its neighbours are drawn at m - 1 or finer. Nothing has to be
//    raised.
//  - When level m is dropped, all its vertices have arrived at midpoints of vertices at home: they lie on
//    the edges of level m - 1, and the picture stays as it is. The same holds for the border vertices that
//    an edge to a coarser neighbour leaves out.
//  - Error. Take a triangle of level m and in it the vertex that has gone the larger share s of its way. By
//    level_error.h a point is at most (1 - s) a + s b off, a being its error with both vertices at home, b
//    the largest with some arrived. By (1) b (S / error_px + 1) <= D - G reach, and by (2) for a the same
//    with (1 - sigma) D. While it moves, (1 - s)(1 - sigma) D + s D is that vertex's rho; so the error is at
//    most (rho - G reach) / (S / error_px + 1), and the point's own rho is not less than that vertex's less G
//    reach: at most error_px pixels. Where the two have different thresholds and the border vertex, which has
//    the smaller one, leads, the second one adds nothing, since error(m - 1) counts the border vertex alone
//    by 1 / (1 - sigma). With both at home, the point's rho is at least D(m + 1), which covers a.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/measure/level_error.h"
#include "terrain/patch/bounds.h"
#include "terrain/surface/patch.h"
#include "terrain/view/camera.h"

namespace karst::core {

// --- The formulas of a vertex. All distances in lattice steps, in float, as on the GPU.

// G, the most that the apparent distance changes a step. Its gradient inside the picture is 2 u z^ - u^2 r^
// with u = cos theta and unit vectors z^, r^; its squared length is 4 u^2 - 3 u^4, at most 4/3.
inline constexpr double kSteepest = 1.1547005383792517;

// The apparent distance of everything in a parallel view. A power of two, so that thresholds tell exactly
// what is beyond it.
inline constexpr float kParallelDistance = 0x1p16f * kStepsPerVoxel;

// from_eye: the vertex at home less the eye. forward: the view's direction, unit length. least_cos2: cos^2
// theta at the picture's corner; below 0: the apparent distance is -least_cos2.
inline float apparent_distance(glm::vec3 from_eye, glm::vec3 forward, float least_cos2) {
  const float ahead = from_eye.x * forward.x + from_eye.y * forward.y + from_eye.z * forward.z;
  const float r2 = from_eye.x * from_eye.x + from_eye.y * from_eye.y + from_eye.z * from_eye.z;
  const float z = ahead > 0.0f ? ahead : 0.0f;
  const float z2 = z * z;
  const float least = least_cos2 * r2;
  const float seen = (z2 > least ? z2 : least) / std::sqrt(r2 > 1.0f ? r2 : 1.0f);
  return least_cos2 < 0.0f ? -least_cos2 : seen;
}

// The share of the way to its target that a vertex has gone, 0..1.
// last: the share of the threshold's distance over which a vertex moves.
inline float morph_share(float apparent, float threshold, float last = kMorphShare) {
  const float width = last * threshold;
  const float share = (apparent - (1.0f - last) * threshold) / (width > 1.0f ? width : 1.0f);
  return share > 0.0f ? (share < 1.0f ? share : 1.0f) : 0.0f;
}

// home, target: relative to the camera's voxel, each rounded once (terrain/nodes/node_place.h). way: target
// less home, exact. The sum is made relative to the camera and not to the patch's origin: then it is the same
// bits in all patches that share the vertex. What has arrived is at its target to the bit: there lies a
// vertex of what is one size coarser.
inline glm::vec3 morph_position(glm::vec3 home, glm::vec3 way, glm::vec3 target, float share) {
  return share < 1.0f ? glm::vec3(home.x + way.x * share, home.y + way.y * share, home.z + way.z * share)
                      : target;
}

// --- Thresholds as the GPU gets them: a row of half floats a patch, in units of kThresholdUnit.

inline constexpr float kThresholdUnit = 64.0f * kStepsPerVoxel;  // lattice steps
inline constexpr std::uint16_t kLeastThreshold = 0x0400;  // 2^-14 units, 32 steps: halves below lose bits
inline constexpr std::uint16_t kNeverMorphs = 0x7bff;     // 65,504 units, 4.2 million voxels: out of reach

// A threshold in lattice steps; 0 stays 0.
inline float threshold_steps(std::uint16_t half) {
  if (half == 0) return 0.0f;
  return std::bit_cast<float>((std::uint32_t{half} << 13) + (112u << 23)) * kThresholdUnit;
}

// The least half not below; never between 0 and kLeastThreshold, never beyond kNeverMorphs.
std::uint16_t threshold_half(float steps);

// Five classes of vertices of a level have thresholds of their own: those inside the patch and those on each
// edge. Corners are of level 1 and never move; nor do the vertices of a collapsed edge, which are one point.
inline constexpr int kMorphClasses = 5;
constexpr int morph_class_edge(int edge) {
  return 1 + edge;
}

// Entry in a row, for levels 2..kMaxLevel. Entry 0 holds kNeverMorphs, for vertices of level 1.
inline constexpr int kMorphRow = 32;
constexpr int morph_entry(int level, int morph_class) {
  return 1 + (level - 2) * kMorphClasses + morph_class;
}
static_assert(morph_entry(kMaxLevel, kMorphClasses - 1) < kMorphRow);

// out[n] = the entry of a slot's vertex n (gpu_vertex.h), for a slot at the level; a table for a level begins
// with those of the levels below. invalid_argument: level not in 1..kMaxLevel, out below
// patch_vertices(level).
Status build_morph_entries(int level, std::span<std::uint8_t> out);

// --- What a view asks for.

struct ErrorScale {
  float pixels = 0;        // S
  float least_pixels = 0;  // S for the longer side of a pixel that is not square
  float steps_per_step =
      0;  // S / error_px + 1, after error_px has paid for positions rounded to float; or infinite
  float least_cos2 = 1;  // cos^2 theta at the picture's corner; parallel: -kParallelDistance

  friend bool operator==(const ErrorScale&, const ErrorScale&) = default;
};

// width_px, height_px: of the picture, any shape of pixels. error_px: the bound, above 0. Depends on the
// camera's projection alone; of a parallel one also, in powers of two, on how far the eye is from the world.
ErrorScale make_error_scale(const Camera& camera, int width_px, int height_px, double error_px);

// What choosing a level needs to know of a patch. 32 bytes.
struct PatchLod {
  float centre[3] = {};             // of its box, lattice steps from the octree's minimum corner
  float reach = 0;                  // half of R: its points' rho is within this of the centre's
  std::uint16_t threshold[8] = {};  // [m]: D(m) inside the patch, m = 2..kMaxLevel; falls with m, 0 ends it
};
static_assert(sizeof(PatchLod) == 32);

struct SetThresholds {
  ErrorScale scale;
  bool morphing = true;       // false: nothing ever morphs, and every patch asks for max_level
  int max_level = kMaxLevel;  // 1..kMaxLevel; vertices of finer levels are not drawn, and count as arrived

  // Inputs, borrowed.
  Surface surface;
  std::span<const PatchBounds> bounds;  // by patch
  LevelErrors errors;                   // of all patches

  // Output, borrowed: by patch.
  std::span<PatchLod> lods;

  // invalid_argument naming the first field that is out of its range or of another size than the surface.
  Status validate() const;

  // Precondition: validate() is ok. Neither fails nor allocates. Independent of where the camera is.
  void run() const;

  // lods are what run() made of bounds and errors that were others for `changed`, and of other edges of
  // theirs: makes them what it would make now. list: first the changed ones, each once, and room for one of
  // each patch. Returns how many of the list may be others now; entries beyond the changed ones are added.
  // Precondition: validate() is ok, max_level is not below errors.level.
  std::size_t update(std::span<PatchId> list, std::size_t changed) const;

 private:
  struct Factors;
  Factors factors() const;
  std::uint16_t threshold(const Factors& by, PatchId p, int m) const;
};

// Fills a patch's row for the GPU, morph_entry by morph_entry; entries beyond the last are 0.
void make_morph_row(const Surface& surface, std::span<const PatchLod> lods, PatchId patch,
                    std::span<std::uint16_t, kMorphRow> row);

// --- Levels.

// What one frame's choice of levels depends on.
struct LodEye {
  glm::vec3 eye{0.0f};  // lattice steps from the octree's minimum corner
  glm::vec3 forward{0.0f, 0.0f, -1.0f};
  float least_cos2 = 1;

  friend bool operator==(const LodEye&, const LodEye&) = default;
};
LodEye make_lod_eye(const Camera& camera, float least_cos2);

// No point of the patch has a smaller apparent distance. The slack covers float here and on the GPU: what
// counts as arrived here has a share of exactly 1 there.
inline float least_apparent_distance(const PatchLod& lod, const LodEye& view) {
  if (view.least_cos2 < 0.0f) return -view.least_cos2;
  const glm::vec3 d(lod.centre[0] - view.eye.x, lod.centre[1] - view.eye.y, lod.centre[2] - view.eye.z);
  const float r = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
  return apparent_distance(d, view.forward, view.least_cos2) - r * 0x1p-18f - (lod.reach + 2.0f);
}

// The least level whose dropped vertices have all arrived at this distance or further.
inline int level_at(const PatchLod& lod, float least_apparent) {
  const float units = least_apparent * (1.0f / kThresholdUnit);
  // As a half, cut off: a threshold is above it exactly when it is above the distance. 0: nearer than any.
  // Unsigned, because the bits of negative distances are as low as they get.
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(units) - (112u << 23);
  const std::int32_t half = units > 0x1p-14f ? static_cast<std::int32_t>(bits >> 13) : 0;
  int level = 1;
  for (int m = 2; m <= kMaxLevel; ++m) level += lod.threshold[m] > half ? 1 : 0;
  return level;
}

}  // namespace karst::core
