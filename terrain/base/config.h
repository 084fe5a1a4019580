// SPDX-License-Identifier: MIT
// Every limit of a terrain, decided before it is created: memory is taken once for exactly these numbers
// and never grows (design 5). kConfigFields states default, range, unit and reason of each; `karst budget`
// and docs/memory.md print that table, and validate() enforces it.
//
// The defaults hold K's test scene (section 5.4.3: 3,560 patches in 2,544 volumes; level 5) in 10 MiB of CPU
// memory and 16 MiB of GPU memory. Programs that open a world start from the sizes that its file states.
#pragma once

#include "karst/status.h"
#include "terrain/base/lattice.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace karst::core {

// GPU vertex memory is handed out in pages, so that a table with one entry a page tells a vertex its patch.
inline constexpr std::uint32_t kPageVertices = 32;  // vertices; 512 bytes at 16 bytes a vertex

// Frames under way at a time: one that the GPU draws, one that the CPU prepares. The renderer waits for older
// ones; what the pool of vertices gives up is kept back for as long.
inline constexpr std::uint32_t kFramesInFlight = 2;
// Views that one frame may have.
inline constexpr std::uint32_t kMostViews = 8;
// Regions of voxels that a ground may have (terrain/ground/ground.h).
inline constexpr std::uint32_t kMostRegions = 16;

struct Config {
  std::uint32_t max_depth = 9;
  std::uint32_t max_octets = 16'384;
  std::uint32_t max_volumes = 4'096;
  std::uint32_t max_patches = 4'096;
  std::uint32_t max_level = 5;
  std::uint32_t max_height_blocks = 3'600;
  std::uint32_t occluder_words = 24'576;
  std::uint32_t sky_words = 7'680;
  std::uint32_t max_draw_items = 4'096;
  std::uint32_t max_resident_patches = 4'096;
  std::uint32_t gpu_vertex_pages = 6'144;
  std::uint32_t stream_indices = 131'072;
  std::uint32_t max_views = 1;
  std::uint32_t ground_tiles = 0;
  std::uint32_t ground_families = 0;
  std::uint32_t max_regions = 1;
  std::uint32_t rim_edges = 0;
  std::uint32_t image_layers = 0;
  std::uint32_t edit_tiles = 0;
  std::uint32_t edit_patches = 0;
  std::uint32_t undo_bytes = 0;
  std::uint32_t paint_width = 0;
  std::uint32_t paint_depth = 0;
  std::uint32_t spare_regions = 0;
  std::uint32_t region_patches = 0;
  std::uint32_t field_blocks = 0;
  std::uint32_t field_sample_blocks = 0;
  std::uint32_t field_material_blocks = 0;
  std::uint32_t field_meshes = 0;
  std::uint32_t field_vertex_pages = 0;
  std::uint32_t field_index_pages = 0;

  // invalid_argument naming the first field outside its range, or too small to draw max_draw_items patches at
  // level 1 in each view; value() is what the field holds.
  Status validate() const;

  friend bool operator==(const Config&, const Config&) = default;
};

struct ConfigField {
  const char* name;
  std::uint32_t Config::*member;
  std::uint32_t default_value;
  std::uint32_t min;  // inclusive
  std::uint32_t max;  // inclusive
  const char* unit;
  const char* reason;  // what the default and the range come from; one clause, no full stop
};

// All octets of a full tree: 1 + 8 + ... + 8^(kMaxDepth - 1).
inline constexpr std::uint32_t kFullTreeOctets = ((1u << (3 * kMaxDepth)) - 1) / 7;
// Far above what the pages of a GPU can show; keeps all sizes made of these limits inside 64 bits.
inline constexpr std::uint32_t kMostPatches = 1u << 24;
// Vertex indices stay below 2^24, the least GL_MAX_ELEMENT_INDEX that OpenGL ES 3.0 allows.
inline constexpr std::uint32_t kMostPages = (1u << 24) / kPageVertices;
// A family has four pages; half of the pages that there may be.
inline constexpr std::uint32_t kMostFamilies = kMostPages / 8;
// Of regions of 512 voxels a side, eight a voxel of their borders.
inline constexpr std::uint32_t kMostRimEdges = kMostRegions * 8 * 4 * (1u << kMaxDepth);
// Layers of the array of image tiles: what OpenGL ES 3.0 allows everywhere.
inline constexpr std::uint32_t kMostImageLayers = 256;
// A patch at level 1 is one page and eight triangles: the least that a drawn patch costs.
inline constexpr std::uint32_t kLeastIndicesPerPatch = 3 * static_cast<std::uint32_t>(patch_triangles(1));

inline constexpr std::array<ConfigField, 31> kConfigFields = {{
    {"max_depth", &Config::max_depth, 9, 1, kMaxDepth, "levels below the octree's root",
     "K 3.3.1: a voxel index has 9 bits an axis; costs no memory by itself"},
    {"max_octets", &Config::max_octets, 16'384, 1, kFullTreeOctets, "groups of eight octree nodes, 32 bytes",
     "four a patch leave room for edits; at most a full tree of 512 voxels a side"},
    {"max_volumes", &Config::max_volumes, 4'096, 1, kMostPatches, "intersection volumes",
     "a volume holds one patch or more, so never more than max_patches are of use"},
    {"max_patches", &Config::max_patches, 4'096, 1, kMostPatches, "patches",
     "K's test scene has 3,560 (table 5.2); at most 2^24, far above what a GPU can show"},
    {"max_level", &Config::max_level, 5, 1, kMaxLevel, "level of detail",
     "K states memory up to level 5 (table 5.6); tables and scratch memory are made for 6 at most"},
    {"max_height_blocks", &Config::max_height_blocks, 3'600, 0, kMostPatches,
     "patches whose heights are held",
     "all of K's test scene at level 5 in 7.5 MiB; fewer than the world has are read when they are needed"},
    {"occluder_words", &Config::occluder_words, 24'576, 0, 1u << 24, "words of rock that hides, 64 bits",
     "K's test scene in cells of half a voxel, four bits each; larger cells where that is too little; 0 "
     "hides "
     "nothing"},
    {"sky_words", &Config::sky_words, 7'680, 0, 1u << 24, "words of sky visibility, 64 bits",
     "K's test scene in cells of a voxel, nine bits each in rows of 64; larger cells where that is too "
     "little; "
     "0: open sky everywhere"},
    {"max_draw_items", &Config::max_draw_items, 4'096, 1, kMostPages, "patches a pass",
     "every patch may be in view; each needs a page at least"},
    {"max_resident_patches", &Config::max_resident_patches, 4'096, 1, kMostPages, "patches with GPU vertices",
     "every patch may be in view; each needs a page and 64 bytes of morph thresholds"},
    {"gpu_vertex_pages", &Config::gpu_vertex_pages, 6'144, 1, kMostPages, "pages of 32 vertices, 512 bytes",
     "3 of the 16 MiB: a page a patch and what one pixel of error takes; vertex indices stay below 2^24, the "
     "least maximum OpenGL ES 3.0 allows"},
    {"stream_indices", &Config::stream_indices, 131'072, kLeastIndicesPerPatch, 1u << 26,
     "32-bit indices a draw call",
     "0.5 of the 16 MiB, 43,690 triangles; a pass with more takes several calls"},
    {"max_views", &Config::max_views, 1, 1, kMostViews, "views a frame",
     "each has lists and thresholds of its own; all share the pages"},
    {"ground_tiles", &Config::ground_tiles, 0, 0, 1u << 16, "tiles of the ground in memory",
     "27 KiB each; 0: the world has no ground"},
    {"ground_families", &Config::ground_families, 0, 0, kMostFamilies,
     "nodes of the ground with children in view",
     "each has four pages, 2 KiB; page numbers stay below those of vertices that OpenGL ES 3.0 allows"},
    {"max_regions", &Config::max_regions, 1, 1, kMostRegions, "octrees: regions of the ground",
     "each has lists of its own in what is shared, 720 bytes; a world without a ground is one"},
    {"rim_edges", &Config::rim_edges, 0, 0, kMostRimEdges, "edges of patches around all regions",
     "12 bytes, and in each view indices of the belts there; 0: the ground has no region"},
    {"image_layers", &Config::image_layers, 0, 0, kMostImageLayers, "image tiles on the GPU",
     "40 to 320 KiB each by their format; at most what every OpenGL ES 3.0 device takes; 0: the world has no "
     "imagery"},
    {"edit_tiles", &Config::edit_tiles, 0, 0, 1u << 16, "tiles of the ground that edits have changed",
     "41 KiB each, one or more a size at each place; 0: the ground is not edited"},
    {"edit_patches", &Config::edit_patches, 0, 0, 1u << 20, "patches that one edit makes anew",
     "some 370 bytes of working memory each, 108 a patch slot; 0: nothing is edited"},
    {"undo_bytes", &Config::undo_bytes, 0, 0, 1u << 30, "bytes that steps of edits keep to be taken back",
     "the oldest steps give way; 0: nothing is taken back"},
    {"paint_width", &Config::paint_width, 0, 0, 1'024, "texels along x of the painted map in memory",
     "4 bytes a texel; 0: nothing is painted"},
    {"paint_depth", &Config::paint_depth, 0, 0, 1'024, "texels along z of the painted map in memory",
     "as paint_width"},
    {"spare_regions", &Config::spare_regions, 0, 0, kMostRegions, "regions that are made where edits dig",
     "each has room for region_patches; 0: a ground is dug in its file's regions alone"},
    {"region_patches", &Config::region_patches, 0, 0, 1u << 20, "patches of a region that is made",
     "some 700 bytes each beside heights and pages of vertices; their octets, volumes, rim and sky, too"},
    {"field_blocks", &Config::field_blocks, 0, 0, 1u << 24, "blocks of 16^3 samples of a field, of any kind",
     "10 bytes each, and 1.2 MiB for making meshes; 0: the world has no isosurface"},
    {"field_sample_blocks", &Config::field_sample_blocks, 0, 0, 1u << 20,
     "blocks of a field that take samples", "4 KiB each, and two of them where samples have 16 bits"},
    {"field_material_blocks", &Config::field_material_blocks, 0, 0, 1u << 20,
     "blocks of a field that take materials",
     "4 KiB each, and 4 bytes a block of any kind; 0: all lies by the materials' rules"},
    {"field_meshes", &Config::field_meshes, 0, 0, 1u << 16, "meshes of blocks of an isosurface",
     "some 95 bytes each, and 16 in each view and for shadow maps; a choice takes half of them"},
    {"field_vertex_pages", &Config::field_vertex_pages, 0, 0, kMostPages, "pages of an isosurface's vertices",
     "512 bytes of GPU memory each, behind those of the ground"},
    {"field_index_pages", &Config::field_index_pages, 0, 0, kMostPages,
     "pages of 192 indices of an isosurface", "388 bytes each; a vertex takes six indices or so"},
}};

}  // namespace karst::core
