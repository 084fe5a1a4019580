// SPDX-License-Identifier: MIT
// What is there: a .karst file in memory of stated size, and nothing of any camera. After load() everything
// const may be called from several threads at a time; heights that did not fit memory then come from the
// ByteSource, which must allow that, too.
//
//   World world;
//   world.create(config, arena);  world.load(source);
//   world.surface(), world.bounds(), world.tree() ... are spans into the arena until the next load()
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/budget.h"
#include "terrain/base/config.h"
#include "terrain/base/storage_plan.h"
#include "terrain/cull/bounds_tree.h"
#include "terrain/cull/occluders.h"
#include "terrain/cull/patch_boxes.h"
#include "terrain/field/octree.h"
#include "terrain/field/sky_atlas.h"
#include "terrain/file/byte_source.h"
#include "terrain/file/world_file.h"
#include "terrain/file/world_reader.h"
#include "terrain/isosurface/field_blocks.h"
#include "terrain/measure/level_error.h"
#include "terrain/measure/measure_queue.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/patch/heights.h"
#include "terrain/regions/region_rim.h"
#include "terrain/resident/height_cache.h"
#include "terrain/shading/materials.h"
#include "terrain/surface/bezier/extract_surface.h"
#include "terrain/surface/bezier/update_surface.h"
#include "terrain/surface/patch.h"
#include "terrain/surface/patch_extent.h"
#include "terrain/surface/patch_table.h"
#include "terrain/view/camera.h"

namespace karst::core {

// What one octree makes: all of a world without a ground, or one of its ground's regions. Patches are
// numbered from 0 here, `first` + that in the world. Borrowed until the world's next load().
struct WorldPart {
  glm::ivec3 corner{0};  // of the octree, voxels from the world's
  glm::ivec3 extent{0};
  PatchId first = 0;
  const Octree* octree = nullptr;
  Surface surface;
  std::span<const PatchBounds> bounds;
  std::span<const NormalCone> cones;
  std::span<const NormalCone> shading_cones;
  LevelErrors level_errors;
  const BoundsTree* tree = nullptr;
  std::span<const PatchBoxes> boxes;
  const Occluders* occluders = nullptr;
  const SkyVisibility* sky = nullptr;
  const RegionRim* rim = nullptr;

  std::uint32_t patches() const { return static_cast<std::uint32_t>(surface.patches.size()); }
  // Of an array by the world's patches, those of the part.
  template <class T>
  std::span<T> of(std::span<T> all) const {
    return all.empty() ? all : all.subspan(first, patches());
  }
  // A camera as the part's octree sees it.
  Camera seen_from(const Camera& camera) const {
    Camera moved = camera;
    moved.voxel -= corner;
    return moved;
  }
};

class World {
 public:
  World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // The limits that hold a world with all its heights, and, on the GPU, a coarse version of all of it and
  // `detail_pages` pages for what views need in detail, at most what all of it takes at `finest`
  // (1..info.level). For one view; others set Config::max_views.
  static Config config_for(const WorldInfo& info, int finest, std::uint32_t detail_pages,
                           const GroundInfo& ground = {});
  static Config config_for(const WorldInfo& info, int finest, const GroundInfo& ground = {}) {
    return config_for(info, finest, default_detail_pages(info.patches), ground);
  }
  // Room for so many patches more than the file has, of each region, and for edits that make as many anew;
  // all heights are held then.
  static void add_edit_room(std::uint32_t patches, Config& config);
  // Room for regions that are made where a ground is dug, as many more than the file has, of so many patches
  // each; before add_edit_room(). Nothing of a ground that cannot be dug.
  static void add_dig_room(const WorldInfo& info, const GroundInfo& ground, std::uint32_t regions,
                           std::uint32_t patches, Config& config);
  // What flights over the samples and elevation models take at 1280 x 720 with the default error, and half as
  // much again. At least 1.3 MiB.
  static std::uint32_t default_detail_pages(std::uint32_t patches) {
    return patches / 4 * 3 > kDetailPages ? patches / 4 * 3 : kDetailPages;
  }
  static constexpr std::uint32_t kDetailPages = 2'688;

  static void add_to(Budget& budget, const Config& config) { count_blocks<Blocks>(config, budget); }
  // Takes what add_to() counts. config is valid. limit_reached ("memory").
  Status create(const Config& config, Arena& arena);

  // Reads a world. Where max_height_blocks holds all its heights, they are read now, and copies of shared
  // vertices are compared; else whoever needs heights reads them through height_source(). The source is
  // borrowed until the next load(). Errors of world_reader.h; limit_reached naming the Config field; corrupt
  // ("patches", "volumes", "heights") where the file contradicts the surface of its own voxels. After a
  // failure the world is empty and can be loaded again.
  Status load(const ByteSource& source);
  // The same for a file whose head was read already.
  Status load(const WorldReader& opened);
  Status load(std::span<const std::byte> file) { return load(ByteSource::of(file)); }

  const Config& config() const { return config_; }
  const WorldInfo& info() const { return info_; }
  // One, but for each region of a ground with several; one without patches where nothing is loaded.
  std::span<const WorldPart> parts() const { return std::span(parts_).first(part_count_); }
  std::size_t part_number(PatchId patch) const {
    std::size_t n = 0;
    while (n + 1 < part_count_ && parts_[n + 1].first <= patch) ++n;
    return n;
  }
  // That a patch is of.
  const WorldPart& part_of(PatchId patch) const { return parts_[part_number(patch)]; }
  // Slots of patches, of which some are free where the world can be edited (Surface::is_free).
  std::uint32_t patch_count() const { return patch_slots_; }
  bool is_free(PatchId slot) const {
    if (!is_editable()) return false;
    const WorldPart& part = part_of(slot);
    const PatchId own = slot - part.first;
    return own >= part.patches() || part.surface.is_free(own);
  }
  std::uint32_t free_patches() const;

  // --- Of the first part, which is all of a world without several
  const Octree& octree() const { return octrees_[0]; }
  const Surface& surface() const { return parts_[0].surface; }
  // By key, the slot of each patch of surface(). Empty where no world is loaded.
  const PatchTable& patch_table() const { return tables_[0]; }
  std::span<const PatchBounds> bounds() const { return parts_[0].bounds; }
  std::span<const NormalCone> cones() const { return parts_[0].cones; }
  std::span<const NormalCone> shading_cones() const { return parts_[0].shading_cones; }
  LevelErrors level_errors() const { return parts_[0].level_errors; }
  const BoundsTree& tree() const { return trees_[0]; }
  std::span<const PatchBoxes> patch_boxes() const { return parts_[0].boxes; }
  const Occluders& occluders() const { return occluders_[0]; }
  const SkyVisibility& sky() const { return skies_[0]; }
  const RegionRim& rim() const { return rims_[0]; }  // has no edges where it is no region's

  // --- Of all
  std::span<const std::uint16_t> index_table() const { return blocks_.index_table; }
  // Does not exist where the world has none. Its regions know how high their belts are.
  const GroundInfo& ground() const { return ground_; }
  // After an edit, between frames: of all samples of the ground.
  void set_ground_heights(std::int32_t low, std::int32_t high) {
    ground_.low = low;
    ground_.high = high;
  }
  // After an edit of a region's heights: how high its belt is now. Precondition: the part is a region.
  const GroundRegion& find_belt(std::size_t part);
  LevelErrors all_level_errors() const {
    return {info_.level, blocks_.level_errors.first(level_error_count(patch_slots_))};
  }
  // Where octrees lie, and their sky; of regions that may be made, how much room there is.
  static SkyAtlas sky_atlas_for(const WorldInfo& info, const GroundInfo& ground, const Config& config);
  const SkyAtlas& sky_atlas() const { return sky_atlas_; }
  // To read tiles by; stays until the next load().
  const WorldReader& reader() const { return reader_; }
  // Box of everything, lattice steps. Precondition: there is a patch, a ground or a field.
  LatticeBox box() const;
  // Vertices at levels up to this fit one page, so that it costs what level 1 costs.
  int base_level() const { return info_.level < 2 ? info_.level : 2; }

  // Empty where the world has none. With the blend map as it is painted now.
  const MaterialSet& materials() const { return reader_.materials(); }
  std::span<const PointLight> lights() const { return reader_.lights(); }
  const Surroundings& surroundings() const { return reader_.surroundings(); }
  // surroundings().rim_points of them, from the source. Errors as of WorldReader::read_rim.
  Status read_rim(std::span<glm::ivec3> rim) const { return reader_.read_rim(rim); }
  // Of patches: 0, or one more than the number of the material that all of it has, or kPaintedByMap. Empty
  // where none can have one.
  std::span<const std::uint8_t> material_overrides() const {
    return blocks_.overrides.first(reader_.has_overrides() || is_paintable() ? patch_slots_ : 0);
  }
  // Layers [first, first + count) of a level of an array, from the source. out: count x
  // texture_image_bytes(). Errors as of WorldReader::read_textures. Precondition: they are there.
  Status read_textures(TextureArray array, int level, std::uint32_t first, std::uint32_t count,
                       std::span<std::byte> out) const {
    return reader_.read_textures(array, level, first, count, out);
  }

  // Rows of the file's blend map, from the source; as WorldReader::read_blend_rows.
  Status read_blend_rows(std::uint32_t first, std::uint32_t count, std::span<std::byte> out) const {
    return reader_.read_blend_rows(first, count, out);
  }

  bool holds_all_heights() const { return cache_.has_room_for_all(); }
  // All heights. Precondition: holds_all_heights().
  Heights heights() const;
  // Groups of heights, for caches of whoever needs some: copied where all are held, else read and checked.
  // The context is this world. May be read from several threads at a time.
  HeightSource height_source() const;

  // Memory that load() is done with, lent to one user at a time until the next load(): working memory, and,
  // of a world that does not hold all heights, a cache for some.
  struct Lent {
    std::span<std::byte> scratch;
    HeightCache* cache = nullptr;  // null where all heights are held
  };
  Lent lend();

  // The samples of its isosurface; load() leaves it without one.
  const FieldBlocks& field() const { return field_; }
  FieldBlocks& field() { return field_; }
  // By block: the part of a step of UndoLog that kept it last; empty where Config::undo_bytes is 0.
  std::span<std::uint32_t> field_kept() { return blocks_.field_kept; }
  // Which part it is, of a field in a ground, or -1; and where that part begins, else 0.
  int field_part() const {
    for (std::size_t n = 0; field_.info().in_region && n < ground_.regions().size(); ++n) {
      if (ground_.regions()[n].is_field()) return static_cast<int>(n);
    }
    return -1;
  }
  glm::ivec3 field_corner() const {
    const int part = field_part();
    return part < 0 ? glm::ivec3(0) : parts_[static_cast<std::size_t>(part)].corner;
  }

  // --- Edits (terrain/edit)

  // Working memory of an edit; sizes follow from Config::edit_patches.
  struct EditRoom {
    std::span<Volume> volumes;  // of the corners that an edit touches, as their patches
    std::span<Patch> patches;
    std::span<std::uint32_t> table;
    std::span<PatchChange> changes;
    std::span<PatchId> changed;
    std::span<PatchId> touched;
    std::span<PatchExtent> extents;  // by changed
    std::span<GridRows> rows;        // by touched
    std::span<GpuVertex> vertices;
    std::span<std::byte> scratch;
    // New heights: of kWhole patches and one more, and of the borders of all.
    std::span<std::int16_t> heights;
    // By slot: the part of a step of UndoLog that last kept the patch's heights, its number's lower half.
    std::span<std::uint32_t> kept;
    std::span<std::uint64_t> sky;  // that is found anew
    std::span<float> tops;         // of a region that is made: heights of columns, and of samples
    MeasureQueue::Storage queue;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      const std::size_t most = config.edit_patches;
      visit(Consumer::edits, most, volumes);
      visit(Consumer::edits, most, patches);
      visit(Consumer::edits, most > 0 ? ExtractSurface::scratch_size(most) : 0, table);
      visit(Consumer::edits, 2 * most, changes);
      visit(Consumer::edits, 2 * most, changed);
      visit(Consumer::edits, kTouched * most, touched);
      visit(Consumer::edits, 2 * most, extents);
      visit(Consumer::edits, kTouched * most, rows);
      const auto of_patch = static_cast<std::size_t>(patch_vertices(static_cast<int>(config.max_level)));
      visit(Consumer::edits, most > 0 ? of_patch : 0, vertices);
      visit(Consumer::edits, most > 0 ? patch_scratch_bytes() : 0, scratch);
      const auto border = static_cast<std::size_t>(4 * patch_cells(static_cast<int>(config.max_level)));
      visit(Consumer::edits, most > 0 ? (kWhole + 1) * of_patch + most * border : 0, heights);
      visit(Consumer::edits, most > 0 ? config.max_patches : 0, kept);
      visit(Consumer::edits, most > 0 ? config.sky_words : 0, sky);
      visit(Consumer::edits, config.spare_regions > 0 ? 3 * std::size_t{config.region_patches} : 0, tops);
      queue.each_block(config, visit);
    }
    static constexpr std::size_t kTouched = 3;
    static constexpr std::size_t kWhole = 16;
  };
  // Everything that follows from the voxels and heights of a part, to be kept together by whoever changes
  // some of it. Spans are by patch of the part, of all its slots; those of free ones are 0. Borrowed until
  // the next load().
  struct Editable {
    glm::ivec3 extent{0};
    bool mirrors = false;  // ExtractSurface
    PatchId first = 0;     // WorldPart
    Octree* octree = nullptr;
    SurfaceSlots* slots = nullptr;
    HeightCache* heights = nullptr;  // block `first` + n is of slot n, where the patch has one
    Surface surface;
    std::span<Patch> patches;  // the surface's
    std::span<PatchBounds> bounds;
    std::span<NormalCone> cones;
    std::span<NormalCone> shading_cones;
    std::span<std::uint16_t> level_errors;
    std::span<std::uint8_t> overrides;
    std::span<PatchBoxes> boxes;
    BoundsTree* tree = nullptr;
    Occluders* occluders = nullptr;
    SkyVisibility* sky = nullptr;
    MeasureQueue* queue = nullptr;
    std::span<std::uint64_t> sky_room;  // SkyVisibility::step()
    const EditRoom* room = nullptr;
  };
  // Where Config::edit_patches is not 0 and a world with voxels is loaded, or a ground that can be dug.
  bool is_editable() const { return state_.editable; }
  // Precondition: is_editable(), part < parts().size() or is_staged(part).
  Editable edit(std::size_t part);
  // Regions that may still be made.
  std::size_t spare_regions() const {
    return state_.spares ? state_.slot_parts - ground_.regions().size() : 0;
  }
  // Memory of the next one, in which nothing is.
  struct Spare {
    std::size_t region = 0;  // its number to be
    PatchId first = 0;       // WorldPart
    Octree* octree = nullptr;
    SurfaceSlots* slots = nullptr;
    RegionRim* rim = nullptr;
    MeasureQueue* queue = nullptr;
    HeightCache* heights = nullptr;
    std::span<Volume> volumes;
    std::span<Patch> patches;
    PatchMeasures measures;
    std::span<std::uint32_t> scratch;  // ExtractSurface::scratch_size() of the volumes
    const EditRoom* room = nullptr;
  };
  // Precondition: spare_regions() > 0.
  Spare spare();
  // A region that is under way in a spare's memory: edit() has it, and nobody else knows of it. Of surface
  // and rim that were made there; with counts, extent, depth, first node and place of its corner.
  void stage_region(const GroundRegion& region);
  // Boxes, tree, rock that hides and sky of what is staged, from its heights and measures.
  void build_staged();
  // What is staged is the last of parts() from now on.
  void open_region();
  // It is a spare again. Whoever made it empties its memory.
  void unstage_region();
  bool is_staged(std::size_t part) const { return state_.staged.exists && part == ground_.regions().size(); }
  // Of parts(), or what is staged.
  const WorldPart& part(std::size_t n) const { return is_staged(n) ? state_.staged.part : parts_[n]; }
  // Whether measures or the sky are still to follow edits (terrain/edit/settle.h), of a part and of all.
  bool is_settled(std::size_t part) const;
  bool is_settled() const;

  // The painted map in memory, which starts as the file's, or empty where that has none.
  struct Paint {
    static constexpr std::uint32_t kBlock = 16;  // texels a side of what edits keep of it

    BlendMap* map = nullptr;
    std::span<std::byte> texels;        // row by row, kBlendTexelBytes each
    std::span<std::uint8_t> overrides;  // of all slots of patches; EditRoom::kept is by slot, too
    // By block, row by row, and of the map's materials: the part of a step of UndoLog that last kept it.
    std::span<std::uint32_t> kept;
  };
  // Where Config::paint_width is not 0, and the world has materials.
  bool is_paintable() const { return !blocks_.paint.empty() && materials().count > 0; }
  // Preconditions: is_paintable().
  Paint paint();
  std::span<const std::byte> painted_texels() const { return blocks_.paint; }

 private:
  struct Blocks {
    std::span<Octree::Octet> octets;
    std::span<Volume> volumes;
    std::span<Patch> patches;
    PatchTable::Blocks table;
    RegionRim::Storage rim;
    std::span<std::uint8_t> overrides;
    HeightCache::Storage heights;
    std::span<std::uint32_t> height_crcs;  // by group
    std::span<PatchBounds> bounds;
    std::span<NormalCone> cones;
    std::span<NormalCone> shading_cones;
    std::span<LatticeBox> boxes;  // the tree's
    std::span<PatchBoxes> patch_boxes;
    std::span<std::uint16_t> level_errors;
    std::span<std::uint64_t> occluders;
    std::span<std::uint64_t> sky;
    std::span<std::uint16_t> index_table;
    std::span<std::byte> scratch;
    EditRoom edit;
    std::span<std::byte> paint;
    std::span<std::uint32_t> paint_kept;
    FieldBlocks::Storage field;
    std::span<std::uint32_t> field_kept;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      const std::size_t patches_most = config.max_patches;
      visit(Consumer::octets, config.max_octets, octets);
      visit(Consumer::volumes, config.max_volumes, volumes);
      visit(Consumer::patches, patches_most, patches);
      table.each_block(config, visit);
      rim.each_block(config, visit);
      visit(Consumer::patches, patches_most, overrides);
      heights.each_block(config, visit);
      visit(Consumer::heights, height_groups(config.max_patches), height_crcs);
      visit(Consumer::bounds, patches_most, bounds);
      visit(Consumer::bounds, patches_most, cones);
      visit(Consumer::bounds, patches_most, shading_cones);
      const std::uint32_t more = config.max_regions - 1;  // for each of which rows and eights begin anew
      visit(Consumer::bounds, BoundsTree::node_count(config.max_patches) + more * kMoreNodes, boxes);
      visit(Consumer::bounds, PatchBoxes::count_for(config.max_patches) + more, patch_boxes);
      visit(Consumer::level_errors, patches_most * level_error_values(static_cast<int>(config.max_level)),
            level_errors);
      visit(Consumer::occlusion, config.occluder_words, occluders);
      visit(Consumer::occlusion, config.sky_words, sky);
      visit(Consumer::index_tables, index_table_size(config), index_table);
      visit(Consumer::scratch, scratch_size(config), scratch);
      edit.each_block(config, visit);
      const std::size_t width = config.paint_width, depth = config.paint_depth;
      visit(Consumer::edits, width * depth * kBlendTexelBytes, paint);
      const auto blocks = [](std::size_t texels) { return (texels + Paint::kBlock - 1) / Paint::kBlock; };
      visit(Consumer::edits, width > 0 ? blocks(width) * blocks(depth) + 1 : 0, paint_kept);
      field.each_block(config, visit);
      visit(Consumer::fields, config.undo_bytes > 0 ? config.field_blocks : 0, field_kept);
    }
  };

  static constexpr std::uint32_t kMoreNodes = BoundsTree::kMaxRows;

  static int index_table_level(const Config& config);
  static std::size_t index_table_size(const Config& config);
  static std::size_t scratch_size(const Config& config);
  std::size_t level_error_count(std::uint32_t patches) const;
  Status check_limits(const WorldInfo& info) const;
  void unload();
  Status load_parts();
  Status load_surface();
  // Of one part, of the file, and with what is free.
  struct Counts {
    std::uint32_t octets = 0, volumes = 0, patches = 0;
  };
  Counts file_counts(std::size_t part) const;
  Counts slot_counts(std::size_t part) const;
  static Counts spare_counts(const Config& config);
  // Whether regions may be made, by how many parts memory is shared then, and what goes by that.
  static bool has_spares(const GroundInfo& ground, const Config& config);
  static std::size_t slot_parts_of(const WorldInfo& info, const GroundInfo& ground, const Config& config);
  static std::size_t sky_boxes(const WorldInfo& info, const GroundInfo& ground, const Config& config,
                               std::span<SkyBox, kMostRegions> boxes);
  static std::uint32_t spare_rim_edges(const Config& config);
  // Of worlds that would take more: 1 MiB. Their cells are larger than voxels.
  static constexpr std::size_t kMostOccluderWords = 131'072;
  // Of an edit's new octree, beside the old one, along the ways to a few voxels.
  static constexpr std::uint32_t kEditPathOctets = 64;
  void set_spans(WorldPart& part) const;
  Status extract_part(std::size_t n);
  void place_slots();
  void place_parts();
  template <class T>
  void spread(std::span<T> all, std::size_t values) const;
  Status load_patches();
  Status load_measures();
  void open_slots();
  void spread_heights();
  Status load_paint();
  Status load_heights();
  Status check_shared_heights() const;
  Status check_shared_heights(const Surface& surface) const;

  Config config_;
  Blocks blocks_;
  WorldReader reader_;
  WorldInfo info_;
  GroundInfo ground_;
  std::array<WorldPart, kMostRegions> parts_{};
  std::size_t part_count_ = 1;
  std::uint32_t patch_slots_ = 0;
  std::array<Octree, kMostRegions> octrees_;
  std::array<PatchTable, kMostRegions> tables_;
  std::array<SurfaceSlots, kMostRegions> slots_;  // of tables_
  std::array<RegionRim, kMostRegions> rims_;
  HeightCache cache_;
  std::array<BoundsTree, kMostRegions> trees_;
  std::array<Occluders, kMostRegions> occluders_;
  std::array<SkyVisibility, kMostRegions> skies_;
  SkyAtlas sky_atlas_;
  std::array<MeasureQueue, kMostRegions> queues_;
  FieldBlocks field_;
  // What edit() has and parts() do not.
  struct Staged {
    bool exists = false;
    WorldPart part;
    GroundRegion region;
  };
  // What a part refers to whose region is not there.
  struct Nothing {
    Octree octree;
    BoundsTree tree;
    Occluders occluders;
    SkyVisibility sky;
    RegionRim rim;
  };
  struct State {
    Staged staged;
    Nothing nothing;
    bool editable = false;
    bool spares = false;            // regions may be made
    std::size_t file_regions = 0;   // where they may: those of the file
    std::size_t slot_parts = 1;     // that memory is shared by
    bool heights_are_read = false;  // all of them are in the cache, which then stays as it is
  };
  State state_;
};

}  // namespace karst::core
