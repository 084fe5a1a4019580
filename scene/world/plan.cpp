// SPDX-License-Identifier: MIT
// make_plan(), read_world_info(), check_world().
#include "karst/plan.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include <glm/common.hpp>

#include "scene/world/placement.h"
#include "scene/world/plan_layout.h"
#include "scene/world/tile_reader.h"
#include "terrain/draw/index_batches.h"
#include "terrain/edit/paint/edit_paint.h"
#include "terrain/file/world_reader.h"
#include "terrain/ground/ground_box.h"
#include "terrain/resident/height_cache.h"
#include "terrain/shadow/cascades.h"
#include "terrain/world/terrain_parts.h"

namespace karst {
namespace core {
namespace {

static_assert(karst::kMostViews == core::kMostViews && kMostShadowMaps == kMostCascades);
static_assert(kFinestLevel == kMaxLevel && kMostPictureSide == RendererSettings::kMaxPicture);
static_assert(kLeastShadowSize == kLeastCascadeSize && kMostShadowSize == kMostCascadeSize &&
              kShadowSizeStep == kCascadeSizeStep);

Status refuse(const char* what, const char* field, std::uint64_t value = 0) {
  return {StatusCode::invalid_argument, what, field, value};
}

bool inside(std::uint64_t value, std::uint64_t least, std::uint64_t most) {
  return value >= least && value <= most;
}

constexpr std::size_t whole_lines(std::size_t bytes) {
  return (bytes + kMemoryAlignment - 1) / kMemoryAlignment * kMemoryAlignment;
}

Status check_needs(const Needs& needs) {
  if (!inside(needs.views, 1, karst::kMostViews)) return refuse("not within 1..8", "views", needs.views);
  if (!inside(needs.level, 1, kMaxLevel)) return refuse("not within 1..6", "level", needs.level);
  if (!inside(needs.queries, 0, kMostQueries)) return refuse("not within 0..64", "queries", needs.queries);
  if (!inside(needs.query_level, 1, kMaxLevel))
    return refuse("not within 1..6", "query_level", needs.query_level);
  if (!inside(needs.query_patches, 16, 65'536))
    return refuse("not within 16..65536", "query_patches", needs.query_patches);
  if (!inside(needs.query_tiles, QueryGround::kLeastTiles, 65'536))
    return refuse("not within 22..65536", "query_tiles", needs.query_tiles);
  if (!inside(needs.shadow_maps, 0, kMostShadowMaps))
    return refuse("not within 0..3", "shadow_maps", needs.shadow_maps);
  CascadeSettings shadows;
  shadows.size = static_cast<int>(std::min(needs.shadow_size, 1u << 16));
  if (!shadows.validate().ok())
    return refuse("not a multiple of 16 within 512..2048", "shadow_size", needs.shadow_size);
  if (!(needs.shadow_reach_m >= 0) || !std::isfinite(needs.shadow_reach_m))
    return refuse("not a finite length", "shadow_reach_m");
  constexpr auto kMost = static_cast<std::uint64_t>(RendererSettings::kMaxPicture);
  if (needs.deferred_width != 0 || needs.deferred_height != 0) {
    if (!inside(needs.deferred_width, 1, kMost))
      return refuse("not within 1..16384 pixels", "deferred_width", needs.deferred_width);
    if (!inside(needs.deferred_height, 1, kMost))
      return refuse("not within 1..16384 pixels", "deferred_height", needs.deferred_height);
  }
  if (!inside(needs.edit_tiles, 0, 65'536))
    return refuse("not within 0..65536", "edit_tiles", needs.edit_tiles);
  if (needs.drape_width != 0 || needs.drape_height != 0) {
    if (!inside(needs.drape_width, 1, kMost)) return refuse("not within 1..16384 pixels", "drape_width");
    if (!inside(needs.drape_height, 1, kMost)) return refuse("not within 1..16384 pixels", "drape_height");
  }
  if (needs.edit_patches > 1u << 20)
    return refuse("more than 2^20 patches", "edit_patches", needs.edit_patches);
  if (needs.paint_width != 0 || needs.paint_depth != 0) {
    if (!inside(needs.paint_width, 1, kMostBlendSide))
      return refuse("not within 1..1024 texels", "paint_width", needs.paint_width);
    if (!inside(needs.paint_depth, 1, kMostBlendSide))
      return refuse("not within 1..1024 texels", "paint_depth", needs.paint_depth);
  }
  if (needs.dig_regions > kMostRegions)
    return refuse("more than 16 regions", "dig_regions", needs.dig_regions);
  if (!inside(needs.region_patches, 64, 1u << 20))
    return refuse("not within 64..2^20 patches", "region_patches", needs.region_patches);
  if (!inside(needs.field_blocks, 0, 1u << 24))
    return refuse("not within 0..2^24", "field_blocks", needs.field_blocks);
  if (!inside(needs.field_material_blocks, 0, 1u << 20))
    return refuse("not within 0..2^20", "field_material_blocks", needs.field_material_blocks);
  if (!inside(needs.field_sample_blocks, 0, 1u << 20))
    return refuse("not within 0..2^20", "field_sample_blocks", needs.field_sample_blocks);
  if (needs.undo_bytes > 1u << 30) return refuse("more than 2^30 bytes", "undo_bytes", needs.undo_bytes);
  return {};
}

// Families of a ground: 3 MiB of vertices, what a pixel of error takes over mountains at 1280 x 720; and
// tiles: those of its root to its finest, several times, in 4 MiB.
constexpr std::uint32_t kFamilies = 1'536;
constexpr std::uint32_t kTiles = 160;
constexpr std::uint32_t kLeastFamilies = 64;
// Those of one place at all sizes, and some more.
constexpr std::uint32_t kLeastTiles = kMostSize + 12;
constexpr std::size_t kFamilyBytes = 4 * kPageVertices * sizeof(GpuVertex);

// Image tiles of a view: what 1280 x 720 pixels take at a texel a pixel or finer, with all coarser ones, and
// as much again; and those of one place at all sizes.
constexpr std::uint64_t kImageLayers = 160;
constexpr std::uint64_t kImageBytes = 16u << 20;  // at most, of them
constexpr std::uint32_t kLeastImageLayers = 32;

void set_ground_limits(const PlannedWorld& world, const Needs& needs, Config& config) {
  if (!world.ground.exists()) return;
  config.ground_tiles = kTiles;
  config.edit_tiles = needs.edit_tiles;
  // Under a drape there is none.
  if (world.imagery.exists() && needs.drape_width == 0) {
    const std::uint64_t bytes = image_texel_bytes(world.imagery.format);
    const std::uint64_t wanted =
        needs.image_bytes > 0 ? needs.image_bytes / bytes : std::min(kImageLayers, kImageBytes / bytes);
    config.image_layers =
        static_cast<std::uint32_t>(std::clamp<std::uint64_t>(wanted, kLeastImageLayers, kMostImageLayers));
  }
  config.ground_families = kFamilies;
  if (needs.vertex_bytes > 0 && world.info.patches == 0) {
    config.ground_families = static_cast<std::uint32_t>(
        std::clamp<std::uint64_t>(needs.vertex_bytes / kFamilyBytes, kLeastFamilies, kMostFamilies - 1));
  }
}

void set_limits(const WorldInfo& info, const GroundInfo& ground, const Needs& needs, Config& config) {
  const int finest = std::min(static_cast<int>(needs.level), info.level);
  const std::uint64_t detail = std::uint64_t{World::default_detail_pages(info.patches)} * needs.views;
  config = World::config_for(info, finest,
                             static_cast<std::uint32_t>(std::min<std::uint64_t>(detail, kMostPages)), ground);
  config.max_views = needs.views;
  if (needs.vertex_bytes > 0) {
    const std::uint64_t pages =
        std::max<std::uint64_t>(needs.vertex_bytes / (kPageVertices * sizeof(GpuVertex)), 1);
    const std::uint64_t all = std::uint64_t{config.max_patches} * slot_pages(finest);
    config.gpu_vertex_pages = static_cast<std::uint32_t>(std::min<std::uint64_t>({pages, all, kMostPages}));
    // A cave whose patches lack vertices closes, and who is in it looks through the ground.
    if (ground.region_count > 0)
      config.gpu_vertex_pages = std::max(config.gpu_vertex_pages, std::min(config.max_patches, kMostPages));
    config.max_draw_items = std::min(config.max_draw_items, config.gpu_vertex_pages);
    config.max_resident_patches = config.max_draw_items;
  }
}

// Of an isosurface: meshes of blocks that hold surface, at some levels, twice: those that are drawn, and
// those that are made for the next choice. A block of smooth surface has some 400 vertices.
constexpr std::uint32_t kLeastMeshes = 64;
constexpr std::uint32_t kMostMeshes = 4'096;
constexpr std::uint64_t kPagesPerBlock = 24;
constexpr std::uint64_t kMeshBytes = 8u << 20;
constexpr std::uint64_t kPageBytes = kPageVertices * sizeof(GpuVertex);
// Behind the pages of patches and nodes.
void set_field_limits(const PlannedWorld& world, const Needs& needs, Config& config) {
  config.field_blocks = needs.field_blocks;
  config.field_material_blocks = needs.field_material_blocks;
  config.field_sample_blocks = needs.field_sample_blocks;
  if (world.field.exists()) {
    config.field_blocks += static_cast<std::uint32_t>(world.field.table_blocks());
    config.field_sample_blocks +=
        world.field.stored * static_cast<std::uint32_t>(world.field.sample_bits / 8);
    // Where all blocks are alike, there is still their table.
    if (world.field.has_materials) config.field_material_blocks += std::max(world.field.material_blocks, 1u);
  }
  if (config.field_blocks == 0) return;
  const std::uint64_t taken = config.gpu_vertex_pages + 4 * std::uint64_t{config.ground_families};
  const std::uint64_t left = taken < kMostPages ? kMostPages - taken : 0;
  const std::uint64_t wanted =
      needs.mesh_bytes > 0
          ? needs.mesh_bytes / kPageBytes
          : std::min(kMeshBytes / kPageBytes, kPagesPerBlock * (config.field_sample_blocks + 8));
  const auto pages = static_cast<std::uint32_t>(std::min(wanted, left));
  config.field_vertex_pages = pages;
  // Six indices a vertex.
  config.field_index_pages = pages;
  config.field_meshes = std::clamp(4 * config.field_sample_blocks, kLeastMeshes, kMostMeshes);
}

// Behind all other limits.
void set_edit_limits(const PlannedWorld& world, const Needs& needs, Config& config) {
  const bool digs = world.ground.can_be_dug && needs.dig_regions > 0;
  if (needs.edit_patches > 0 && digs)
    World::add_dig_room(world.info, world.ground, needs.dig_regions, needs.region_patches, config);
  if (needs.edit_patches > 0 && (world.info.patches > 0 || digs))
    World::add_edit_room(needs.edit_patches, config);
  // A map of the file's is as large as that says.
  const MaterialSet& materials = world.materials;
  if (needs.paint_width > 0 && materials.count > 0) {
    const BlendMap& map = materials.blend_map;
    config.paint_width = map.exists() ? map.width : needs.paint_width;
    config.paint_depth = map.exists() ? map.depth : needs.paint_depth;
  }
  const bool sculpts =
      world.field.exists() && (needs.field_sample_blocks > 0 || needs.field_material_blocks > 0);
  if (config.edit_patches > 0 || config.edit_tiles > 0 || config.paint_width > 0 || sculpts)
    config.undo_bytes = static_cast<std::uint32_t>(needs.undo_bytes);
}

// Holds fewer heights where all is more than may be taken; what is missing is read from the file when it is
// needed.
void fit_heights(std::uint64_t max_cpu, std::uint64_t taken, Config& config) {
  if (taken <= max_cpu || config.edit_patches > 0) return;
  const std::uint64_t over = taken - max_cpu;
  const std::uint64_t group = std::uint64_t{kHeightGroup} * sizeof(std::int16_t) *
                              static_cast<std::uint64_t>(patch_vertices(static_cast<int>(config.max_level)));
  const std::uint64_t groups = height_groups(config.max_height_blocks);
  const std::uint64_t fewer = std::min(groups, over / group + 1);
  const std::uint64_t held = std::max<std::uint64_t>(groups - fewer, HeightCache::kLeastGroups);
  if (held < groups) config.max_height_blocks = static_cast<std::uint32_t>(held * kHeightGroup);
}

// Sees the sky in larger cells where even the fewest heights are too many. None of it would be open sky
// everywhere: caves would be lost.
void fit_sky(std::uint64_t max_cpu, std::uint64_t taken, Config& config) {
  if (taken <= max_cpu || config.sky_words == 0) return;
  const std::uint64_t over = (taken - max_cpu) / sizeof(std::uint64_t) + 1;
  constexpr std::uint64_t kLeastWords = 64;
  const std::uint64_t left = config.sky_words > over ? config.sky_words - over : 0;
  config.sky_words =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(config.sky_words, std::max(left, kLeastWords)));
}

// Fewer tiles where all of them are too many.
void fit_tiles(std::uint64_t max_cpu, std::uint64_t taken, Config& config) {
  if (taken <= max_cpu || config.ground_tiles == 0) return;
  const std::uint64_t fewer = (taken - max_cpu) / sizeof(Tile) + 1;
  const std::uint64_t left = config.ground_tiles > fewer ? config.ground_tiles - fewer : 0;
  config.ground_tiles = static_cast<std::uint32_t>(std::max<std::uint64_t>(left, kLeastTiles));
}

// Of a world's ground and voxels.
glm::ivec3 extent_of(const PlannedWorld& world) {
  if (!world.ground.exists()) return world.info.extent;
  const LatticeBox box = ground_box(world.ground);
  return glm::max(world.info.extent, glm::ivec3(glm::ceil((glm::dvec3(box.max) - glm::dvec3(box.min)) /
                                                          double{kStepsPerVoxel})));
}

SkyAtlas sky_of(const PlannedWorld& world, const Config& config) {
  return World::sky_atlas_for(world.info, world.ground, config);
}

void set_renderer(const PlannedWorld& world, const Needs& needs, const Config& config,
                  RendererSettings& renderer) {
  const WorldInfo& info = world.info;
  const MaterialSet& materials = world.materials;
  const bool drape = needs.drape_width > 0;
  renderer.vertex_pages = config.gpu_vertex_pages;
  renderer.morph_rows = config.max_resident_patches * config.max_views;
  renderer.stream_indices = config.stream_indices;
  renderer.mesh_pages = config.field_vertex_pages;
  renderer.mesh_materials = config.field_material_blocks > 0 && !drape && materials.count > 0;
  if (world.ground.exists()) {
    renderer.family_pages = 4 * config.ground_families;
    renderer.family_rows = (config.max_views + 1) * (config.ground_families + 1);
  }
  if (config.image_layers > 0) {
    renderer.image_layers = config.image_layers;
    renderer.image_views = config.max_views;
    renderer.image_format = world.imagery.format;
  }
  renderer.extent = extent_of(world);
  renderer.rim = info.patches > 0 && !world.ground.exists();
  renderer.sky = sky_of(world, config);
  renderer.drape_width = static_cast<int>(needs.drape_width);
  renderer.drape_height = static_cast<int>(needs.drape_height);
  renderer.deferred_width = static_cast<int>(needs.deferred_width);
  renderer.deferred_height = static_cast<int>(needs.deferred_height);
  renderer.material_count = drape ? 0 : materials.count;
  renderer.material_side = materials.side;
  renderer.material_format = materials.format;
  const bool painted = config.paint_width > 0;
  renderer.blend_width = drape ? 0 : painted ? config.paint_width : materials.blend_map.width;
  renderer.blend_depth = drape ? 0 : painted ? config.paint_depth : materials.blend_map.depth;
  renderer.blend_span = blend_span(info, world.ground);
  renderer.cascades = drape ? 0 : static_cast<int>(needs.shadow_maps);
  renderer.shadow_size = static_cast<int>(needs.shadow_size);
  renderer.air_blocks = static_cast<int>(needs.views);
}

void add_up(PlanLayout& layout) {
  layout.budget = terrain_budget(layout.config);
  layout.terrain_bytes = layout.budget.cpu_bytes();
  layout.renderer.add_to(layout.budget);
}

}  // namespace

ByteSource byte_source(const Source& source) {
  return {source.bytes, &source, [](const void* context, std::uint64_t offset, std::span<std::byte> out) {
            const auto* from = static_cast<const Source*>(context);
            return out.empty() ||
                   (from->read != nullptr && from->read(from->user, offset, out.data(), out.size()));
          }};
}

std::uint64_t PlanLayout::cpu_bytes() const {
  return std::uint64_t{objects_bytes} + staging_bytes + terrain_bytes + reading_bytes + edit_bytes +
         undo_bytes;
}

namespace {

// All sizes together; at most 2^32 - 1.
std::uint32_t tiles_of(const GroundInfo& ground) {
  std::uint64_t count = 0;
  for (int size = 0; size <= ground.top_size(); ++size) {
    const std::int64_t quads = std::int64_t{kTileQuads} << size;
    count += static_cast<std::uint64_t>((ground.samples[0] + quads - 2) / quads) *
             static_cast<std::uint64_t>((ground.samples[1] + quads - 2) / quads);
  }
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(count, 0xffffffffu));
}

// From layout.config on.
Status lay_out_config(const PlannedWorld& world, const Needs& needs, PlanLayout& layout) {
  const WorldInfo& info = world.info;
  const MaterialSet& materials = world.materials;
  set_renderer(world, needs, layout.config, layout.renderer);
  layout.query_limits.level = std::min(static_cast<int>(needs.query_level), info.level);
  layout.query_limits.patches = std::min(needs.query_patches, std::max(info.patches, 1u));
  layout.query_limits.max_level = info.level;
  if (world.ground.exists()) {
    layout.query_limits.ground = {
        std::max(std::min(needs.query_tiles, tiles_of(world.ground)), QueryGround::kLeastTiles),
        TileReader::workspace_bytes()};
    layout.reading_bytes = whole_lines(TileReader::bytes(world.imagery.format));
  }
  if (layout.config.edit_tiles > 0) {
    Budget edits;
    layout.edit_limits = {layout.config.edit_tiles, TileReader::workspace_bytes()};
    EditGround::add_to(edits, layout.edit_limits);
    layout.edit_bytes = whole_lines(sizeof(EditGround)) + edits.cpu_bytes();
  }
  layout.undo_bytes = whole_lines(layout.config.undo_bytes);
  Budget query;
  Query::add_to(query, layout.query_limits);
  layout.query_bytes = query.cpu_bytes();
  layout.objects_bytes = whole_lines(objects_bytes(needs.queries)) + needs.queries * layout.query_bytes;
  std::size_t staging = layout.renderer.has_rim() ? most_rim_points(info.extent) * kRimPointBytes : 0;
  if (layout.renderer.material_count > 0) {
    staging = std::max(staging, texture_image_bytes(materials.format, materials.side, TextureArray::near, 0));
    staging = std::max(staging, layout.renderer.blend_width * kBlendTexelBytes);
  }
  layout.staging_bytes = whole_lines(staging);
  add_up(layout);
  const std::uint32_t all = layout.config.max_height_blocks;
  fit_heights(needs.max_cpu_bytes, layout.cpu_bytes(), layout.config);
  layout.holds_all_heights = layout.config.max_height_blocks == all;
  add_up(layout);
  fit_tiles(needs.max_cpu_bytes, layout.cpu_bytes(), layout.config);
  add_up(layout);
  fit_sky(needs.max_cpu_bytes, layout.cpu_bytes(), layout.config);
  layout.renderer.sky = sky_of(world, layout.config);
  add_up(layout);
  return layout.config.validate();
}

}  // namespace

Status lay_out(const PlannedWorld& world, const Needs& needs, PlanLayout& layout) {
  if (const Status status = check_needs(needs); !status.ok()) return status;
  layout = {};
  set_limits(world.info, world.ground, needs, layout.config);
  set_ground_limits(world, needs, layout.config);
  set_edit_limits(world, needs, layout.config);
  set_field_limits(world, needs, layout.config);
  return lay_out_config(world, needs, layout);
}

karst::WorldInfo public_info(const WorldReader& reader) {
  const WorldInfo& info = reader.info();
  const MaterialSet& materials = reader.materials();
  const Surroundings& surroundings = reader.surroundings();
  karst::WorldInfo out;
  static_assert(sizeof out.name == kWorldNameBytes);
  std::memcpy(out.name, info.name, sizeof out.name);
  out.voxel_size_m = info.voxel_size_m;
  out.origin_m = {info.origin_m[0], info.origin_m[1], info.origin_m[2]};
  for (int axis = 0; axis < 3; ++axis) out.extent[axis] = info.extent[axis];
  out.octree_depth = reader.ground().can_be_dug ? kMaxDepth : info.depth;
  out.level = info.level;
  out.octets = info.octets;
  out.volumes = info.volumes;
  out.patches = info.patches;
  out.height_blocks = info.height_blocks;
  out.materials = materials.count;
  for (std::uint32_t m = 0; m < materials.count; ++m)
    std::memcpy(out.material_names[m], materials.materials[m].name, sizeof out.material_names[m]);
  out.blend_map[0] = materials.blend_map.width;
  out.blend_map[1] = materials.blend_map.depth;
  out.lights = static_cast<std::uint32_t>(reader.lights().size());
  if (const FieldInfo& field = reader.field(); field.exists()) {
    for (int axis = 0; axis < 3; ++axis) out.field_samples[axis] = 16 * field.blocks[axis];
    out.field_sample_bits = field.sample_bits;
    out.field_blocks = field.stored;
    out.field_has_materials = field.has_materials;
    out.field_cell_m = info.voxel_size_m / (1 << (kMostCellLog2 - field.cell_log2));
  }
  const GroundInfo& ground = reader.ground();
  if (ground.exists()) {
    out.ground_sizes = ground.top_size() + 1;
    out.tile_bytes = reader.tile_bytes();
    const double step_m = info.voxel_size_m / kStepsPerVoxel;
    for (int axis = 0; axis < 2; ++axis) {
      out.ground_samples[axis] = ground.samples[axis];
      out.ground_spacing_m[axis] = ground.steps[axis] * step_m;
    }
    out.regions = static_cast<std::uint32_t>(ground.region_count);
    out.can_be_dug = ground.can_be_dug;
    for (std::size_t n = 0; n < ground.regions().size(); ++n) {
      const GroundRegion& region = ground.regions()[n];
      for (int axis = 0; axis < 2; ++axis) {
        out.region_first[n][axis] = region.nodes.low[axis];
        out.region_nodes[n][axis] = region.nodes.high[axis] - region.nodes.low[axis];
      }
    }
    if (reader.imagery().exists()) {
      out.image_texel_m = std::ldexp(out.ground_spacing_m[0], reader.imagery().least_size) / kTexelsPerSample;
    }
    const double base_m = ground.basis.is_curved() ? ground.basis.base_m : info.origin_m[1];
    out.ground_low_m = base_m + double{kVertexStep} * ground.low * step_m;
    out.ground_high_m = base_m + double{kVertexStep} * ground.high * step_m;
    out.basis = static_cast<karst::Basis>(ground.basis.kind);
    if (ground.basis.is_curved() && ground.basis.kind != BasisKind::function)
      out.radius_m = ground.basis.radius_m;
    const Georeference& earth = reader.earth();
    out.epsg = earth.epsg;
    out.is_projected =
        ground.basis.kind == BasisKind::cylinder || (!ground.basis.is_curved() && earth.exists());
    out.is_geodetic = ground.basis.is_ellipsoid() || earth.projection == MapProjection::degrees ||
                      earth.projection == MapProjection::transverse_mercator;
  }
  out.has_water = surroundings.has_water();
  if (out.has_water) out.water_m = info.origin_m[1] + info.voxel_size_m * double{surroundings.water_level};
  return out;
}

void store_reader(const WorldReader& reader, Head& head) {
  static_assert(std::is_trivially_copyable_v<WorldReader> && sizeof(WorldReader) <= sizeof head.state);
  // Never 0, which no head has.
  head.hash = std::uint64_t{1} << 32 | reader.head_crc();
  WorldReader alone = reader;
  alone.forget_source();
  std::memcpy(head.state, &alone, sizeof alone);
}

bool read_from(const Head& head, WorldReader& reader) {
  if (head.hash == 0) return false;
  std::memcpy(static_cast<void*>(&reader), head.state, sizeof reader);
  return true;
}

namespace {

void add_term(Plan& plan, const char* name, bool gpu, std::uint64_t bytes) {
  if (bytes > 0 && plan.term_count < std::size(plan.terms))
    plan.terms[plan.term_count++] = {name, gpu, bytes};
}

void fill_plan(const PlanLayout& layout, Plan& plan) {
  plan.term_count = 0;
  plan.limit_count = 0;
  for (const Budget::Term& term : layout.budget.terms()) add_term(plan, term.name, term.gpu, term.bytes);
  const std::uint64_t queries = std::uint64_t{plan.needs.queries} * layout.query_bytes;
  add_term(plan, "objects", false, layout.objects_bytes - queries);
  add_term(plan, "queries", false, queries);
  add_term(plan, "staging", false, layout.staging_bytes);
  add_term(plan, "reading", false, layout.reading_bytes);
  add_term(plan, "ground_edits", false, layout.edit_bytes);
  add_term(plan, "undo", false, layout.undo_bytes);
  for (const ConfigField& field : kConfigFields) {
    if (plan.limit_count == std::size(plan.limits)) break;
    plan.limits[plan.limit_count++] = {
        field.name,  layout.config.*field.member, field.default_value, field.min, field.max, field.unit,
        field.reason};
  }
  plan.cpu_bytes = layout.cpu_bytes();
  plan.gpu_bytes = layout.budget.gpu_bytes();
  plan.holds_all_heights = layout.holds_all_heights;
}

Status check_room(const Plan& plan) {
  if (plan.cpu_bytes > plan.needs.max_cpu_bytes) {
    return {StatusCode::limit_reached, "the world needs more memory than it may take", "max_cpu_bytes",
            plan.cpu_bytes};
  }
  if (plan.gpu_bytes > plan.needs.max_gpu_bytes) {
    return {StatusCode::limit_reached, "the world needs more GPU memory than it may take", "max_gpu_bytes",
            plan.gpu_bytes};
  }
  return {};
}

}  // namespace
}  // namespace core

Status read_head(const Source& file, Head& head) noexcept {
  head = {};
  core::WorldReader reader;
  if (const Status status = reader.open(core::byte_source(file)); !status.ok()) return status;
  core::store_reader(reader, head);
  return {};
}

Status make_plan(const Head& head, Plan& plan) noexcept {
  core::WorldReader reader;
  if (!core::read_from(head, reader)) return {StatusCode::invalid_argument, "holds none", "head"};
  const core::WorldInfo& info = reader.info();
  core::PlacementFrame frame;
  const core::WorldFrame world{{info.origin_m[0], info.origin_m[1], info.origin_m[2]}, info.voxel_size_m};
  if (const Status status = frame.create(plan.placement, world); !status.ok()) return status;
  core::PlanLayout layout;
  if (const Status status = core::lay_out(core::PlannedWorld::of(reader), plan.needs, layout); !status.ok())
    return status;
  plan.head = head;
  core::fill_plan(layout, plan);
  return core::check_room(plan);
}

Status make_plan(const Source& file, Plan& plan) noexcept {
  Head head;
  const Status status = read_head(file, head);
  return status.ok() ? make_plan(head, plan) : status;
}

Status make_plan(Plan& plan) noexcept {
  if (const Status status = core::check_needs(plan.needs); !status.ok()) return status;
  core::PlacementFrame frame;
  if (const Status status = frame.create(plan.placement, core::WorldFrame()); !status.ok()) return status;
  core::PlanLayout layout;
  core::Config& config = layout.config;
  config.max_views = plan.needs.views;
  if (plan.needs.vertex_bytes > 0) {
    config.max_level = std::min(plan.needs.level, config.max_level);
    config.gpu_vertex_pages = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(
        plan.needs.vertex_bytes / (core::kPageVertices * sizeof(core::GpuVertex)), 1, core::kMostPages));
    config.max_draw_items = std::min(config.max_draw_items, config.gpu_vertex_pages);
    config.max_resident_patches = config.max_draw_items;
    config.stream_indices =
        std::min(config.stream_indices,
                 config.max_draw_items * core::max_patch_indices(static_cast<int>(config.max_level)));
  }
  core::WorldInfo info;
  info.depth = static_cast<int>(config.max_depth);
  info.level = static_cast<int>(config.max_level);
  info.extent = glm::ivec3(1 << config.max_depth);
  info.patches = config.max_patches;
  core::PlannedWorld world;
  world.info = info;
  if (const Status status = core::lay_out_config(world, plan.needs, layout); !status.ok()) return status;
  plan.head = {};
  core::fill_plan(layout, plan);
  return core::check_room(plan);
}

namespace {

WorldInfo info_in(const core::WorldReader& reader) {
  return core::public_info(reader);
}

}  // namespace

WorldInfo info_of(const Head& head) noexcept {
  core::WorldReader reader;
  return core::read_from(head, reader) ? info_in(reader) : WorldInfo();
}

Status read_world_info(const Source& file, WorldInfo& info) noexcept {
  core::WorldReader reader;
  if (const Status status = reader.open(core::byte_source(file)); !status.ok()) return status;
  info = info_in(reader);
  return {};
}

Status check_world(const Source& file, WorldInfo& info) noexcept {
  core::WorldReader reader;
  if (const Status status = reader.open(core::byte_source(file)); !status.ok()) return status;
  if (const Status status = reader.verify(); !status.ok()) return status;
  info = info_in(reader);
  return {};
}

}  // namespace karst
