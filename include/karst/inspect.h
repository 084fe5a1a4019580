// SPDX-License-Identifier: MIT
// EXPERIMENTAL: may change with any version. What karst's own programs use to measure and to look inside:
// switches of a renderer, and what its last frame did and cost.
#pragma once

#include <cstdint>

#include "karst/export.h"
#include "karst/renderer.h"

namespace karst {

enum class LodMode : std::uint8_t {
  error,     // the coarsest levels that keep the view's error_px
  distance,  // patches: K equation 4.13, nothing morphs; nodes: distance over side (S), which morph
  full       // every patch at its finest level
};

// What a picture shows. With a drape always what that shows.
enum class Show : std::uint8_t {
  materials,
  cascades,  // the shadow map that each pixel is looked up in
  levels,    // triangles, by their level of detail
  lookups    // texture lookups of each pixel's shading: 12 a lookup in red, 64 in blue; no sky
};

// Of all frames from the next on. A skip that is off changes no pixel: what would be skipped is done.
struct Inspection {
  LodMode lod = LodMode::error;
  double distance_voxels = 64;  // of LodMode::distance: patches from here on are at level 1; 0..2^20
  Show show = Show::materials;
  bool skip_frustum = true;    // patches out of view
  bool skip_backface = true;   // that face away
  bool skip_occluded = true;   // that rock hides
  bool skip_cascades = true;   // shadow maps that would not change
  bool skip_material = true;   // by patch: materials that cannot lie on it
  bool skip_cave = true;       // by patch: what only caves need
  bool skip_triplanar = true;  // by pixel: planes of weight zero
  bool skip_blend = true;      // by pixel: the second material where the first covers all
  bool skip_detail = true;     // by pixel: the near scale where it has faded
  bool skip_sun = true;        // by pixel: shadows and mirrored light where no sun falls
  bool read_ahead = true;      // tiles that moving views will lack; and not those that would come too late
  bool lamps = true;           // the world's point lights
  bool wait_for_gpu = false;   // before and after shadow maps, so that shadow_ms holds the GPU's work
  // Told when work of karst begins and ends in which no GL is called, to count heap calls. May be null.
  void (*own_work)(void* user, bool begins) = nullptr;
  void* user = nullptr;
};
KARST_API void set_inspection(Renderer& renderer, const Inspection& inspection) noexcept;

// Of a frame, from begin_frame() to end_frame(); sums over all views. Milliseconds of this thread.
struct FrameCosts {
  double select_ms = 0;                          // choosing levels and listing patches
  double generate_ms = 0;                        // making vertices
  double upload_ms = 0;                          // of vertices and thresholds
  double submit_ms = 0;                          // GL calls of passes
  double shadow_ms = 0;                          // finding out what casts, and drawing it
  double gpu_terrain_ms = 0, gpu_shadow_ms = 0;  // the newest that the driver tells; NaN: not known
  std::uint32_t patches_drawn = 0, patches_missing = 0, patches_capped = 0;
  std::uint32_t patches_skipped = 0;  // not looked at: of regions that the ground stands for
  std::uint32_t nodes_drawn = 0;      // of the ground
  std::uint32_t blocks_drawn = 0;     // of an isosurface
  // Of the ground's tiles and imagery's: asked for before a view lacked them; of such, first looked at in
  // this frame; and that gave way without having been. Their sums are those of all frames.
  std::uint32_t ahead_asked = 0, ahead_used = 0, ahead_wasted = 0;
  // Nodes and image tiles that lack what would come too late to be of use, so that it is not asked for; and
  // below which size nodes do, 0: none does.
  std::uint32_t left_out = 0, sizes_left_out = 0;
  std::uint32_t culled_frustum = 0, culled_backface = 0, culled_occluded = 0;
  std::uint32_t at_level[7] = {};                     // patches drawn, by level
  std::uint32_t blend_skipped = 0, cave_skipped = 0;  // patches drawn that need none
  std::uint32_t cascades_drawn = 0, cascades_skipped = 0;
  std::uint64_t shadow_triangles = 0;
  std::uint32_t generated = 0, resident = 0, wanted_pages = 0;
  std::uint32_t draw_calls = 0;
  std::uint64_t triangles = 0;  // submitted, all passes
  std::uint64_t uploaded_bytes = 0;
  std::uint64_t morph_bytes = 0;  // of them, thresholds
  float error_scale = 1;          // of error_px, by what memory holds
  bool vertices_lost = false;     // the driver lost its buffer: draw the frame again
};
KARST_API const FrameCosts& costs(const Renderer& renderer) noexcept;

// Of the device and of what is really there.
struct DeviceInfo {
  const char* renderer = "";  // as the driver names itself
  const char* version = "";
  bool clip_control = false;     // for Target::depth_zero_to_one
  bool deferred = false;         // pixels are shaded once, from a G-buffer
  bool high_precision = false;   // all of a pixel is computed in 32 bits
  std::uint32_t anisotropy = 1;  // places at most that a lookup in the ground's textures mixes
  // GL_DEPTH_COMPONENT32F, Needs::deferred_width x deferred_height; 0: none is shared
  // (GlOptions::share_depth).
  std::uint32_t depth_texture = 0;
  std::uint64_t gpu_bytes = 0;  // of the objects that exist
  std::uint64_t cpu_bytes = 0;  // taken of the world's memory
};
KARST_API DeviceInfo device_info(const Renderer& renderer) noexcept;

}  // namespace karst
