// SPDX-License-Identifier: MIT
// What a view and a shadow map are drawn from, and where to.
#pragma once

#include <cstdint>
#include <span>

#include "karst/types.h"
#include "renderer/input/frame_block.h"
#include "renderer/input/frame_counts.h"
#include "renderer/input/surroundings_block.h"
#include "terrain/draw/draw_list.h"
#include "terrain/draw/mesh_items.h"
#include "terrain/imagery/image_view.h"
#include "terrain/lod/morph.h"
#include "terrain/resident/page_table.h"
#include "terrain/shading/materials.h"
#include "terrain/shading/shading.h"
#include "terrain/shadow/cascades.h"
#include "terrain/view/camera.h"

namespace karst::core {

// What a picture shows.
enum class Show : std::uint8_t {
  materials,
  cascades,  // the shadow map that each pixel is looked up in
  levels,    // triangles, by their level of detail or their node's size
  lookups    // how many lookups a pixel takes
};

// What pixels skip that changes no bit of them; false: all pixels do it.
struct PixelSkips {
  bool triplanar = true;  // planes of weight zero
  bool blend = true;      // the second material where the first covers all
  bool detail = true;     // the near scale where it has faded
  bool sun = true;        // shadows and mirrored light where no sun falls
};

struct ViewInput {
  Camera camera;
  FrameLight light;
  float least_cos2 = 1.0f;             // ErrorScale's, which the morph rows were made for
  std::uint32_t first_morph_row = 0;   // of the view's thresholds; a page's texel counts from it
  std::uint32_t first_family_row = 0;  // the same of families
  std::int64_t foot = 0;               // height at which walls of nodes end, lattice steps
  std::span<const DrawItem> items;     // of a valid draw list; may be empty
  // Nodes of the ground: `patch` is the number of a node's page among those of families, `level` kNodeLevel;
  // bit e of lower_edges: the neighbour across edge e is one size coarser (edges:
  // terrain/nodes/family_row.h).
  std::span<const DrawItem> nodes;
  std::size_t near_nodes =
      SIZE_MAX;  // of them, that may be nearer than the split of depth's ranges: the first
  std::span<const std::uint32_t> belts;  // of the region, between items and nodes (terrain/regions/belts.h)
  // Meshes of isosurfaces, behind all others; first_vertex_page is filled in.
  std::span<const MeshItem> meshes;
  MeshPages mesh_pages;
  unsigned shading = kShadeBlend | kShadeCave;  // what any of the items and nodes needs, PatchShading::needs
  PixelSkips skips;
  ImagePlace images;             // of imagery, where the settings have layers
  std::uint32_t image_view = 0;  // whose table pixels look up, of the settings' image_views
  FrameSurroundings surroundings;
  FrameLevel level;  // where the settings say that the basis is curved
  // Chords of what is drawn are so far below what is level that pixels take their heights from vertices: they
  // are shaded while they are drawn.
  bool has_long_chords = false;
  std::span<const PointLight> lights;          // at most kMostLights
  PageTable pages;                             // the one that uploads were made with
  std::span<const std::uint16_t> index_table;  // build_index_tables(); with nodes up to kNodeLevel at least
  int max_level = kMaxLevel;                   // of index_table and items
  Show show = Show::materials;                 // with a drape always what that shows
  // Shadow maps that the sun's light is looked up in, smallest first, at most settings().cascades; their
  // contents are those of the last draw_cascade(). None: the sun reaches everything.
  LightSpace light_space;
  float casters_stray = 0;  // voxels a voxel from the eye, at most, where levels go by distance
  std::span<const Cascade> cascades;
  // Counter-clockwise turns by 90 degrees, for screens that stand on their side: the picture lies turned in
  // the target, and the camera's aspect is that of the upright picture.
  int quarter_turns = 0;
};

// What a view writes.
enum class Writes : std::uint8_t {
  all,
  depth,  // alone: no colour, no sky
  colour  // where Writes::depth has drawn the same view before; and the sky
};

struct DrawTarget {
  Rect viewport;                  // within the framebuffer that is bound; width and height 1..kMaxPicture
  std::uint32_t framebuffer = 0;  // its name, where the settings have a G-buffer
  bool sky = true;                // where depth is what the far plane has; false: what is there stays
  // Light instead of what a display shows, a sunlit white surface being about 3.5: for targets that hold it,
  // or encode sRGB themselves. With a drape: what the display would show, decoded from sRGB.
  bool linear = false;
  Writes writes = Writes::all;
  // Depth reaches the buffer by way of 0..1 in clip space, not -1..1: the same but for rounding, which
  // matters to reversed depth in floating point. Needs caps().clip_control.
  bool depth_zero_to_one = false;
  // Where one range does not do (terrain/view/depth_ranges.h). Not with depth_zero_to_one.
  bool two_ranges = false;
};

// What is drawn into a shadow map. foot, items, nodes, belts, meshes,
// pages, index_table, max_level: as in ViewInput.
struct CascadeInput {
  Cascade cascade;
  std::uint32_t first_morph_row = 0;
  std::uint32_t first_family_row = 0;
  std::int64_t foot = 0;
  LevelView level;  // of cascade.eye, where the settings say that the basis is curved
  std::span<const DrawItem> items;
  std::span<const DrawItem> nodes;
  std::span<const std::uint32_t> belts;
  std::span<const MeshItem> meshes;
  MeshPages mesh_pages;
  PageTable pages;
  std::span<const std::uint16_t> index_table;
  int max_level = kMaxLevel;
  // Draws the host's own casters afterwards: with the map bound, its viewport set, depth tested and both
  // faces drawn; all other state is initial, and whatever it leaves does not matter. May be null.
  void (*draw_more)(void* user) = nullptr;
  void* user = nullptr;
};

}  // namespace karst::core
