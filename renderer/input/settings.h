// SPDX-License-Identifier: MIT
// What a renderer is made for. All of it is decided when it is created.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "karst/types.h"
#include "terrain/base/budget.h"
#include "terrain/field/sky_atlas.h"
#include "terrain/imagery/image_tile.h"
#include "terrain/shading/materials.h"

namespace karst::core {

struct RendererSettings {
  std::uint32_t vertex_pages = 0;  // Config::gpu_vertex_pages, 1..kMostPages
  // Rows of thresholds: Config::max_views x max_resident_patches, 1..kMostViews x kMostPages.
  std::uint32_t morph_rows = 0;
  // Of the ground's families: their pages, 4 each, which lie behind those of patches in the buffer, and rows
  // of thresholds, which lie behind those of patches; 0 both: there is no ground. All pages together are
  // kMostPages at most. Each view, and all shadow maps together, have a row for the root and one a family.
  std::uint32_t family_pages = 0;
  std::uint32_t family_rows = 0;
  std::uint32_t mesh_pages = 0;  // of meshes of isosurfaces, behind all others: Config::field_vertex_pages
  bool mesh_materials = false;   // their vertices have materials; not with a drape, nor without materials
  std::uint32_t stream_indices = 0;  // Config::stream_indices, at least max_patch_indices(max level drawn)
  glm::ivec3 extent{1};              // of the world, voxels, 1..2^20 on each axis
  bool rim = true;                   // there may be a wall around it (Renderer::upload_rim)
  SkyAtlas sky;                      // of the world's octrees
  // An image that is laid over the world from above instead of its materials; 0: none. Pixels, both 0 or
  // both 1..kMaxPicture.
  int drape_width = 0;
  int drape_height = 0;
  double drape_repeat = 1;  // times that it covers the world's content on each axis, 2^-10..2^10
  // Of the materials' textures, terrain/shading/materials.h; count 0: one plain material.
  std::uint32_t material_count = 0;  // 0..kMostMaterials
  std::uint32_t material_side = 0;   // texels, a power of two within 16..1024
  TextureFormat material_format = TextureFormat::rgba8;
  // Of its blend map, texels, both 0 or both 1..kMostBlendSide; 0: there is none.
  std::uint32_t blend_width = 0;
  std::uint32_t blend_depth = 0;
  BlendSpan blend_span;  // what it lies over
  // Image tiles on the GPU, Config::image_layers, and views that look at them; 0 both, or a drape: the world
  // has no imagery. 0..kMostImageLayers, 0..kMostViews.
  std::uint32_t image_layers = 0;
  std::uint32_t image_views = 0;
  ImageFormat image_format = ImageFormat::none;
  Detail detail = Detail::medium;
  Precision precision = Precision::automatic;
  // Places at most that a lookup in the ground's textures mixes along a pixel's longer side, 0..16; 0: as
  // fits the device. create() sets it to what is done.
  int anisotropy = 0;
  bool water = true;    // of the world; false: shaders know none
  bool patches = true;  // of voxels, with collapsed edges; false: the ground's nodes alone
  bool curved = false;  // its ground lies on a curved basis: up and height are functions of the place
  karst::Shading shading = karst::Shading::automatic;
  // Of the G-buffer, pixels, both 0 or both 1..kMaxPicture; 0, a drape or imagery on a curved basis: there
  // is none. create() sets
  // them to 0 where pixels are shaded while they are drawn.
  int deferred_width = 0;
  int deferred_height = 0;
  bool smooth_edges = false;  // of what goes by the G-buffer
  bool share_depth = false;   // of the G-buffer, with the targets of what goes by it
  int cascades = 0;           // shadow maps, 0..kMostCascades; with a drape there are none
  int shadow_size = 1024;     // texels a side, as in CascadeSettings
  int shadow_bits = 16;       // of depth, 16 or 24 (which takes 32)
  int air_blocks = 0;         // uniform buffers for the host's own shaders (set_air), 0..kMostAirBlocks

  // In the host's context: texture units first_unit .. first_unit + KARST_UNITS - 1 and uniform blocks
  // first_block and first_block + 1 are karst's while it draws.
  std::uint32_t first_unit = 0;
  std::uint32_t first_block = 0;
  bool desktop = false;  // a context of OpenGL 4.3 or later with ARB_ES3_compatibility, instead of ES 3.0
  bool timers = false;   // GPU times of passes; the host must not time with the same kind of query then
  bool debug = false;    // takes the driver's error messages (message()); wants a debug context of one's own

  static constexpr int kMaxPicture = 16384;  // pixels a side
  static constexpr int kMostAirBlocks = 8;
  static constexpr int kMostAnisotropy = 16;
  static constexpr int kAutomaticAnisotropy = 4;  // where a GPU renders

  std::uint32_t all_pages() const { return vertex_pages + family_pages + mesh_pages; }
  // Rows of the page table: of all pages, and, where imagery lies on a curved basis, of the places of nodes.
  bool has_node_places() const { return curved && image_layers > 0 && drape_width == 0; }
  std::uint32_t all_rows() const { return morph_rows + family_rows; }
  bool deferred() const { return deferred_width > 0 && drape_width == 0 && !has_node_places(); }
  // Whether the G-buffer has materials of voxels.
  bool has_geometry_voxels() const { return deferred() && mesh_materials; }
  // Whether there is room for a rim: with a drape a world has none.
  bool has_rim() const { return rim && drape_width == 0; }

  // invalid_argument naming the first field outside its range.
  Status validate() const;
  // Adds what create() will take.
  void add_to(Budget& budget) const;
};

}  // namespace karst::core
