// SPDX-License-Identifier: MIT
// A world in memory of stated size: everything the core needs to load a .karst file, choose what to draw, and
// make the vertices for it piece by piece. All memory is taken in create(), exactly budget() bytes of it;
// from then on nothing is allocated.
//
//   Config config = Terrain::config_for(info);          // or a board's limits
//   std::vector<std::byte> memory(Terrain::budget(config).cpu_bytes() + alignment);
//   Terrain terrain;
//   terrain.create(config, memory);  terrain.load(source);
//   each frame: terrain.begin_frame();  terrain.select(view, result);
//               while (there is time && terrain.generate_next(upload, status)) copy upload to the GPU
//               copy terrain.take_morph_rows() to the GPU;  draw terrain.items() with terrain.pages()
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/budget.h"
#include "terrain/base/config.h"
#include "terrain/cull/occlusion.h"
#include "terrain/draw/draw_list.h"
#include "terrain/field/octree.h"
#include "terrain/file/world_file.h"
#include "terrain/file/world_reader.h"
#include "terrain/lod/morph.h"
#include "terrain/lod/select_lod.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/resident/height_cache.h"
#include "terrain/resident/page_table.h"
#include "terrain/resident/resident_pool.h"
#include "terrain/shading/materials.h"
#include "terrain/shading/patch_shading.h"
#include "terrain/shading/shading.h"
#include "terrain/shadow/cascades.h"
#include "terrain/surface/bezier/extract_surface.h"

namespace karst::core {

struct TerrainView {
  const Camera* camera = nullptr;
  LodSettings lod;      // max_level and resident_level are cut to the world's level
  int width_px = 1280;  // of the picture, 1..65536; what error_px is measured in
  int height_px = 720;
  bool frustum_culling = true;
  bool backface_culling = true;
  bool occlusion_culling = true;
  ShadingSkips shading_skips;
  std::uint32_t occlusion_searches = 256;  // boxes a frame for which hiding rock is searched, about 1 us each
};

// Vertices of one patch for the GPU; valid until the next call of the Terrain.
struct PatchUpload {
  PatchId patch = 0;
  std::uint32_t row = 0;                // its morph row
  int first_vertex = 0;                 // of its slot; those before it are there already
  std::span<const GpuVertex> vertices;  // to its chain of pages (pages()), from first_vertex on
  glm::ivec3 origin{0};                 // voxels
  PatchShading shading;
};

// Rows of morph thresholds that changed: kMorphRow halves each.
struct MorphRows {
  std::uint32_t first_row = 0;
  std::span<const std::uint16_t> halves;  // empty: nothing changed
};

class Terrain {
 public:
  Terrain() = default;
  Terrain(const Terrain&) = delete;
  Terrain& operator=(const Terrain&) = delete;

  // The limits that hold a world with all its heights, and, on the GPU, a coarse version of all of it and
  // `detail_pages` pages for what the view needs in detail, at most what all of it takes at `finest`
  // (1..info.level).
  static Config config_for(const WorldInfo& info, int finest, std::uint32_t detail_pages);
  static Config config_for(const WorldInfo& info, int finest) {
    return config_for(info, finest, default_detail_pages(info.patches));
  }
  // What flights over the samples and elevation models take at 1280 x 720 with the default error, and half as
  // much again. At least 1.3 MiB.
  static std::uint32_t default_detail_pages(std::uint32_t patches) {
    return patches / 4 * 3 > kDetailPages ? patches / 4 * 3 : kDetailPages;
  }
  static constexpr std::uint32_t kDetailPages = 2'688;

  // Exact bytes of the CPU side; the renderer adds its GPU terms. kUnbounded terms where they do not fit
  // size_t.
  static Budget budget(const Config& config);

  // memory: borrowed for the terrain's life, aligned to Arena::kAlignment, at least
  // budget(config).cpu_bytes(). Uses exactly that many. invalid_argument, limit_reached ("memory", bytes
  // needed).
  Status create(const Config& config, std::span<std::byte> memory);

  // Reads a world. Where max_height_blocks holds all its heights, they are read now, copies of shared
  // vertices are compared, and the source need outlive the call only for read_textures(); else heights are
  // read from it whenever vertices are made. Errors of world_reader.h; limit_reached naming the Config field;
  // corrupt ("patches", "volumes", "heights") where the file contradicts the surface of its own voxels. After
  // a failure the terrain holds an empty world and can load again.
  Status load(const ByteSource& source);
  Status load(std::span<const std::byte> file) { return load(ByteSource::of(file)); }

  const Config& config() const { return config_; }
  const Arena& arena() const { return arena_; }
  const WorldInfo& info() const { return info_; }
  const Octree& octree() const { return octree_; }
  Surface surface() const { return {volumes_.first(info_.volumes), patches_.first(info_.patches)}; }
  LevelErrors level_errors() const { return {info_.level, level_errors_.first(level_error_count())}; }
  std::span<const std::uint16_t> index_table() const { return index_table_; }
  std::uint32_t patch_count() const { return info_.patches; }
  std::span<const PatchBounds> bounds() const { return bounds_.first(info_.patches); }
  std::span<const NormalCone> cones() const { return cones_.first(info_.patches); }
  std::span<const NormalCone> shading_cones() const { return shading_cones_.first(info_.patches); }
  std::span<const PatchShading> shading() const { return shading_.first(info_.patches); }
  const BoundsTree& tree() const { return tree_; }
  // Empty where the world has none.
  const MaterialSet& materials() const { return reader_.materials(); }
  std::span<const PointLight> lights() const { return reader_.lights(); }
  // Of patches: 0, or one more than the number of the material that all of it has. Empty where none has one.
  std::span<const std::uint8_t> material_overrides() const {
    return overrides_.first(reader_.has_overrides() ? info_.patches : 0);
  }
  // Layers [first, first + count) of a level of an array, from the source. out: count x
  // texture_image_bytes(). Errors as of WorldReader::read_textures. Precondition: they are there.
  Status read_textures(TextureArray array, int level, std::uint32_t first, std::uint32_t count,
                       std::span<std::byte> out) const {
    return reader_.read_textures(array, level, first, count, out);
  }
  // Box of everything, lattice steps. Precondition: there is a patch.
  LatticeBox box() const;
  // Where all heights are held: of the world. Else of what happens to be held.
  Heights heights() const { return cache_.heights(); }
  bool holds_all_heights() const { return cache_.has_room_for_all(); }
  std::uint64_t height_groups_read() const { return cache_.groups_read(); }

  // Vertices of one patch at a level or, with emit_level, those of its coarser levels alone
  // (GenerateVertices); patch_vertices() of the level emitted, in slot order. Errors of reading heights.
  // Precondition: patch < patch_count(), 1 <= emit_level <= level <= info().level.
  Status generate(PatchId patch, int level, int emit_level, std::span<GpuVertex> out);

  // --- A frame

  // Call once for each frame that is drawn, before its first select().
  void begin_frame() { pool_.begin_frame(); }

  struct Selection {
    SelectLod::Result lod;
    BuildDrawList::Result list;
    std::uint32_t wanted_pages = 0;  // that the view takes at the levels it wants
    // The pages do not hold what error_px wants: error_scale times as much is aimed at until they do.
    bool pool_full = false;
    float error_scale = 1.0f;
    float next_error_scale = 1.0f;  // of the next select()
  };
  // Chooses levels, no finer than what is resident, and lists what the camera sees. May be called several
  // times a frame. limit_reached ("max_draw_items") leaves a valid, shorter list.
  Status select(const TerrainView& view, Selection& selection);

  // Makes the vertices that the last select() lacked, what is off by most pixels first. Then, with `ahead`,
  // of patches that are about to be needed, as long as the pool has room to spare. False: there is nothing to
  // do, or no room. status: errors of reading heights.
  bool generate_next(bool ahead, PatchUpload& upload, Status& status);

  // What is resident takes effect in the next select().
  PageTable pages() const { return pool_.pages(); }
  const ResidentPool& pool() const { return pool_; }
  // Forgets what is on the GPU: after its buffers were lost or made anew.
  void forget_resident();

  // Thresholds that were not taken yet, of the last select() and generate_next().
  MorphRows take_morph_rows();
  // They change only when the lod settings, picture's size, camera's projection, bounds or the pool's
  // error_scale do, and the version with them. 0 before the first select().
  std::uint32_t thresholds_version() const { return thresholds_version_; }
  const ErrorScale& error_scale() const { return scale_; }
  std::span<const PatchLod> lods() const { return lods_.first(info_.patches); }

  // --- Casters of shadows, after the frame's last select()

  struct Casters {
    std::span<const DrawItem> items;  // valid until the next select_casters()
    std::uint64_t triangles = 0;
    // Patches in the cascade's box that are held coarser than they should cast, or not at all.
    std::uint32_t lacking = 0;
    std::uint64_t hash = 0;  // of the items and their thresholds: the same ones draw the same map
  };
  // What casts into the cascade's map, with the settings of the last select() and no finer than what is
  // resident. error_texels: SelectCasters. limit_reached ("max_draw_items") leaves a valid, shorter list.
  Status select_casters(const Cascade& cascade, double error_texels, Casters& casters);
  // Makes the coarsest vertices of a patch that has none, where the pool keeps room for those of all patches.
  // False: none lacks any, or there is no room. status: errors of reading heights.
  bool generate_base(PatchUpload& upload, Status& status);
  // Makes vertices for a patch that the last select_casters() lacked, holes first. False: none is left, or
  // there is no room now. status: errors of reading heights. Not after the next select().
  bool generate_next_caster(PatchUpload& upload, Status& status);
  // What patches give up in the rest of this frame is free at once. Precondition: the GPU is idle.
  void release_kept_pages() { pool_.release_kept(); }

  std::span<const DrawItem> items() const { return items_.first(listed_); }
  // Of patches in view and their neighbours, and of all without frustum_culling, as SelectLod leaves them.
  std::span<const std::uint8_t> levels() const { return levels_.first(info_.patches); }

 private:
  std::size_t level_error_count() const;
  // All that fits the first page of a patch.
  int base_level() const { return info_.level < 2 ? info_.level : 2; }
  HeightSource height_source() const;
  Status hold_heights(PatchId patch, int level);
  Status set_thresholds(const LodSettings& lod, const ErrorScale& scale);
  Status check_shared_heights() const;
  Status load_surface();
  Status load_patches();
  Status load_world();
  Status find_shading();
  void govern(Selection& selection);
  bool make_resident(PatchId patch, int level, PatchUpload& upload, Status& status);
  bool generate_ahead(PatchUpload& upload, Status& status);
  void touch_morph_row(std::uint32_t row);

  Config config_;
  Arena arena_{{}};
  WorldReader reader_;
  WorldInfo info_;
  Octree octree_;
  std::span<Volume> volumes_;
  std::span<Patch> patches_;
  HeightCache cache_;
  std::span<std::uint32_t> height_crcs_;  // by group
  std::span<PatchBounds> bounds_;
  std::span<NormalCone> cones_;
  std::span<NormalCone> shading_cones_;
  std::span<PatchShading> shading_;
  ShadingSkips shading_skips_;  // what shading_ was found with
  std::span<std::uint8_t> overrides_;
  std::span<LatticeBox> boxes_;
  BoundsTree tree_;
  Occluders occluders_;
  Occlusion occlusion_;
  std::span<std::uint16_t> level_errors_;
  std::span<PatchLod> lods_;
  ErrorScale scale_;  // what lods_ are for, with the next two
  bool morphing_ = false;
  int thresholds_level_ = 0;  // 0: lods_ are out of date
  std::uint32_t thresholds_version_ = 0;
  std::span<std::uint16_t> morph_rows_;  // what the GPU has, or will have
  std::uint32_t dirty_begin_ = 0;        // rows to take
  std::uint32_t dirty_end_ = 0;
  ResidentPool pool_;
  std::span<LackingPatch> lacking_;
  std::size_t lacking_count_ = 0;  // a heap by px, once generate_next() was called
  bool lacking_is_heap_ = false;
  float pool_scale_ = 1.0f;  // times error_px
  bool pool_full_ = false;
  std::uint32_t calm_frames_ = 0;
  PatchId ahead_ = 0;             // where looking ahead goes on
  PatchId next_base_ = 0;         // and where looking for patches that are not resident does
  std::uint32_t ahead_left_ = 0;  // patches to look at in this frame
  LodEye eye_;
  std::span<std::uint16_t> index_table_;
  LodSettings lod_settings_;       // of the last select()
  std::uint32_t next_caster_ = 0;  // of those that list_scratch_ holds, which lack something
  std::uint32_t lacking_casters_ = 0;
  std::span<std::uint8_t> caster_wanted_;
  std::span<std::uint8_t> caster_levels_;
  std::span<DrawItem> caster_items_;
  std::span<std::uint8_t> levels_;
  std::span<DrawItem> items_;
  std::span<std::uint32_t> list_scratch_;
  std::span<GpuVertex> vertices_;  // of one patch
  std::span<std::byte> scratch_;   // working memory of loading and of generating, by turns
  PatchScratch* patch_scratch_ = nullptr;
  std::size_t listed_ = 0;
};

}  // namespace karst::core
