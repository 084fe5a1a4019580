// SPDX-License-Identifier: MIT
// Memory before anything else: what a simulator needs, and what that takes to the byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/export.h"
#include "karst/status.h"
#include "karst/types.h"

namespace karst {

inline constexpr std::uint32_t kMostViews = 8;
inline constexpr std::uint32_t kMostQueries = 64;
inline constexpr std::uint32_t kMostShadowMaps = 3;
inline constexpr std::uint32_t kLeastShadowSize = 512, kMostShadowSize = 2048,
                               kShadowSizeStep = 16;  // texels
inline constexpr std::uint32_t kFinestLevel = 6;
inline constexpr std::uint32_t kMostPictureSide = 16'384;  // pixels

// Defaults suit one view of 1280 x 720. 0 in a field that says so: karst chooses.
struct Needs {
  std::uint32_t views = 1;  // most in one frame, 1..kMostViews
  std::uint32_t level = 6;  // finest level of detail that is drawn, 1..6; cut to the world's
  // Of GPU memory for vertices; 0: what flights at 4 px of error take. Each patch of a ground's regions has
  // 512 bytes at least, whatever this says: caves are never closed for want of them.
  std::uint64_t vertex_bytes = 0;
  std::uint64_t image_bytes = 0;      // of GPU memory for imagery, where the world has some; 0: the same
  std::uint32_t queries = 0;          // Query objects at a time, 0..kMostQueries
  std::uint32_t query_level = 3;      // of the surface that queries meet, whatever is drawn, 1..6; cut alike
  std::uint32_t query_patches = 128;  // that each keeps ready, 16..65536
  // Of a ground's tiles, 64 samples a side, that each keeps ready, 22..65536; at most as many as there are.
  std::uint32_t query_tiles = 30;
  std::uint32_t shadow_maps = 2;     // 0..kMostShadowMaps
  std::uint32_t shadow_size = 1024;  // texels a side of each, 512..2048, a multiple of 16
  double shadow_reach_m = 0;         // from the eye, beyond which there are no shadows; 0: 256 voxels
  // The largest view, pixels, both 0 or both 1..16384, whose pixels are shaded once, after all that lies in
  // them is known, at 12 bytes of GPU memory a pixel. 0: while they are drawn, which small triangles do
  // several times; so are parallel views, larger ones, those under a drape and imagery on a curved basis.
  std::uint32_t deferred_width = 0;
  std::uint32_t deferred_height = 0;
  std::uint32_t drape_width = 0;   // pixels of an image over the world that takes the materials' place,
  std::uint32_t drape_height = 0;  // both 0 or both 1..16384
  // Tiles of a ground, 64 samples a side, that edits may change (karst/edit.h), 0..65536: one or more of each
  // size at each place, of regions too. 0: it is not edited.
  std::uint32_t edit_tiles = 0;
  // Patches that edits may add to those of the file, in each region, and that one edit may make anew,
  // 0..2^20; 0: no voxels are edited. All heights are held in memory then.
  std::uint32_t edit_patches = 0;
  // Regions that may be made where a ground that can be dug is dug (karst/edit.h), up to 16 with those of the
  // file, and patches that each may have when it is made, 64..2^20: one or more a column of voxels. Both only
  // where edit_patches is not 0.
  std::uint32_t dig_regions = 0;
  std::uint32_t region_patches = 4096;
  // Texels along x and z of the painted map (EditTool::paint), both 0 or both 1..1024; of a world that has
  // one, its own count. 4 bytes of memory each, and 5.3 of GPU memory. 0: nothing is painted.
  std::uint32_t paint_width = 0;
  std::uint32_t paint_depth = 0;
  // Of memory for what steps of edits keep to be taken back (karst/edit.h), 0..2^30; 0: none can be.
  std::uint64_t undo_bytes = 0;
  // Room for the samples of an isosurface's field beyond what the file has: blocks of 16^3 samples of any
  // kind, 0..2^24, and those that are neither all solid nor all air, at 8 bits a sample, 0..2^20. Edits
  // (karst/edit.h) take the latter; 0: the field is not edited.
  std::uint32_t field_blocks = 0;
  std::uint32_t field_sample_blocks = 0;
  // The same of blocks that take materials of their own, 0..2^20; of a file without materials in its field,
  // 0: there are none.
  std::uint32_t field_material_blocks = 0;
  // Of GPU memory for the vertices of an isosurface; 0: as its blocks need, 8 MiB at most.
  std::uint64_t mesh_bytes = 0;
  std::uint64_t max_cpu_bytes = 512ull << 20;  // heights that find no room are read from the file when needed
  std::uint64_t max_gpu_bytes = 64ull << 20;
};

// A file's head, read and checked once and handed on: what becomes of the file afterwards changes none of it.
struct Head {
  std::uint64_t hash = 0;                 // of the head's bytes; 0: none was read
  alignas(8) std::byte state[6144] = {};  // karst's own
};

// Bytes of one part, for people and for CI.
struct Term {
  const char* name;
  bool gpu;
  std::uint64_t bytes;
};

// A limit inside, as it follows from the needs and the file.
struct Limit {
  const char* name;
  std::uint32_t value, standard, least, most;
  const char* unit;
  const char* reason;
};

// needs, placement and ground are the caller's; make_plan() fills in the rest.
struct Plan {
  Needs needs;
  Placement placement;
  GroundFunction ground;  // World::create() wants it, where the world's basis is one

  std::uint64_t cpu_bytes = 0;  // of the memory that World::create() wants, aligned to kMemoryAlignment
  std::uint64_t gpu_bytes = 0;  // of GL objects; the host's framebuffers are its own
  bool holds_all_heights = false;
  Head head;  // that it was made for: World::create() refuses another file; hash 0: none
  Term terms[40] = {};
  std::uint32_t term_count = 0;
  Limit limits[32] = {};
  std::uint32_t limit_count = 0;
};
inline constexpr std::uint64_t kMemoryAlignment = 64;

// Errors of the file.
KARST_API Status read_head(const Source& file, Head& head) noexcept;
// For the file whose head that is, without reading it. Errors of needs and placement (invalid_argument names
// the field), and limit_reached ("max_cpu_bytes", "max_gpu_bytes", with the bytes that are needed) where a
// coarse version of the whole world finds no room.
KARST_API Status make_plan(const Head& head, Plan& plan) noexcept;
// Both in one.
KARST_API Status make_plan(const Source& file, Plan& plan) noexcept;
// Without a file: for a world as large as the defaults of the limits.
KARST_API Status make_plan(Plan& plan) noexcept;

}  // namespace karst
