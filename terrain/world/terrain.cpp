// SPDX-License-Identifier: MIT
#include "terrain/world/terrain.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

#include "terrain/draw/index_batches.h"
#include "terrain/patch/shared_vertices.h"

namespace karst::core {
namespace {

// Loading needs the octree's bytes, the table of volumes and the mask, generating a PatchScratch; never two
// at once.
std::size_t scratch_bytes(const Config& config) {
  const std::size_t table = ExtractSurface::scratch_size(config.max_volumes) * sizeof(std::uint32_t);
  const std::size_t mask = (std::size_t{config.max_patches} + 7) / 8;
  const std::size_t sky = (std::size_t{1} << (2 * config.max_depth)) * sizeof(std::int16_t);
  return std::max({table, mask, sky, WorldReader::octree_room(config.max_octets), patch_scratch_bytes()});
}

std::size_t block_samples(const Config& config) {
  return static_cast<std::size_t>(patch_vertices(static_cast<int>(config.max_level)));
}

// Of patches whose heights are held: whole groups.
std::size_t held_groups(const Config& config) {
  return height_groups(config.max_height_blocks);
}

std::size_t max_level_errors(const Config& config) {
  return config.max_patches * level_error_values(static_cast<int>(config.max_level));
}

// Of worlds that would take more: 1 MiB. Their cells are larger than voxels.
constexpr std::size_t kMostOccluderWords = 131'072;

// Patches a frame that generate_next() looks at beyond what the view lacks.
constexpr std::uint32_t kAheadPatches = 256;
// Nearer by this factor, a patch is about to be needed: the camera gets there within a second or so.
constexpr float kAheadDistance = 0.85f;
// Frames in a row with room to spare before the pool's error scale falls again.
constexpr std::uint32_t kCalmFrames = 8;
constexpr float kMostErrorScale = 65'536.0f;

// Holes are worse than any lack of detail.
constexpr float kHolePx = 1e9f;

bool less_urgent(const LackingPatch& a, const LackingPatch& b) {
  return a.px != b.px ? a.px < b.px : a.patch > b.patch;
}

}  // namespace

Config Terrain::config_for(const WorldInfo& info, int finest, std::uint32_t detail_pages) {
  const auto limit = [](std::uint32_t v) { return std::max(v, 1u); };
  Config config;
  config.max_depth = static_cast<std::uint32_t>(info.depth);
  config.max_octets = limit(info.octets);
  config.max_volumes = limit(info.volumes);
  config.max_patches = limit(info.patches);
  config.max_level = static_cast<std::uint32_t>(info.level);
  config.max_height_blocks = info.height_blocks;
  config.occluder_words = static_cast<std::uint32_t>(std::min<std::size_t>(
      Occluders::word_count(info.extent, Occluders::kLeastCellLog2), kMostOccluderWords));
  config.max_draw_items = limit(std::min(info.patches, kMostPages));
  config.max_resident_patches = config.max_draw_items;
  const std::uint64_t all = std::uint64_t{config.max_draw_items} * slot_pages(finest);
  const std::uint64_t some = std::uint64_t{config.max_draw_items} + detail_pages;
  config.gpu_vertex_pages = static_cast<std::uint32_t>(std::min<std::uint64_t>({all, some, kMostPages}));
  config.stream_indices = std::max(config.stream_indices, config.max_draw_items * kLeastIndicesPerPatch);
  return config;
}

Budget Terrain::budget(const Config& config) {
  Budget b;
  b.add(Consumer::octets, Octree::bytes_for(config.max_octets));
  b.add(Consumer::volumes, Arena::bytes_for<Volume>(config.max_volumes));
  b.add(Consumer::patches, Arena::bytes_for<Patch>(config.max_patches));
  b.add(Consumer::patches, Arena::bytes_for<std::uint8_t>(config.max_patches));
  b.add(Consumer::heights,
        Arena::bytes_for<std::int16_t>(held_groups(config) * kHeightGroup * block_samples(config)));
  b.add(Consumer::heights, Arena::bytes_for<std::uint32_t>(height_groups(config.max_patches)));
  b.add(Consumer::heights, Arena::bytes_for<std::uint32_t>(height_groups(config.max_patches)));
  b.add(Consumer::heights, Arena::bytes_for<std::uint32_t>(held_groups(config)));
  b.add(Consumer::heights, Arena::bytes_for<std::uint32_t>(held_groups(config)));
  b.add(Consumer::bounds, Arena::bytes_for<PatchBounds>(config.max_patches));
  b.add(Consumer::bounds, Arena::bytes_for<NormalCone>(config.max_patches));
  b.add(Consumer::bounds, Arena::bytes_for<NormalCone>(config.max_patches));
  b.add(Consumer::bounds, Arena::bytes_for<PatchShading>(config.max_patches));
  b.add(Consumer::bounds, Arena::bytes_for<LatticeBox>(BoundsTree::node_count(config.max_patches)));
  b.add(Consumer::level_errors, Arena::bytes_for<std::uint16_t>(max_level_errors(config)));
  b.add(Consumer::thresholds, Arena::bytes_for<PatchLod>(config.max_patches));
  b.add(Consumer::thresholds,
        Arena::bytes_for<std::uint16_t>(std::size_t{config.max_resident_patches} * kMorphRow));
  b.add(Consumer::residency, Arena::bytes_for<std::uint32_t>(config.max_patches));
  b.add(Consumer::residency, Arena::bytes_for<std::uint32_t>(config.max_patches));
  b.add(Consumer::residency, Arena::bytes_for<std::uint8_t>(config.max_patches));
  b.add(Consumer::residency, Arena::bytes_for<std::uint32_t>(config.gpu_vertex_pages));
  b.add(Consumer::residency, Arena::bytes_for<PageTexel>(config.gpu_vertex_pages));
  b.add(Consumer::residency, Arena::bytes_for<ResidentPool::Row>(config.max_resident_patches));
  b.add(Consumer::residency, Arena::bytes_for<LackingPatch>(config.max_draw_items));
  b.add(Consumer::occlusion, Arena::bytes_for<std::uint64_t>(config.occluder_words));
  b.add(Consumer::occlusion, Arena::bytes_for<std::uint16_t>(Occlusion::entry_count(config.max_patches)));
  b.add(Consumer::index_tables,
        Arena::bytes_for<std::uint16_t>(index_count(static_cast<int>(config.max_level))));
  b.add(Consumer::draw_list, Arena::bytes_for<std::uint8_t>(config.max_patches));
  b.add(Consumer::draw_list, Arena::bytes_for<DrawItem>(config.max_draw_items));
  b.add(Consumer::draw_list, Arena::bytes_for<std::uint8_t>(config.max_patches));
  b.add(Consumer::draw_list, Arena::bytes_for<std::uint8_t>(config.max_patches));
  b.add(Consumer::draw_list, Arena::bytes_for<DrawItem>(config.max_draw_items));
  b.add(Consumer::draw_list, Arena::bytes_for<std::uint32_t>(config.max_patches));
  b.add(Consumer::scratch, Arena::bytes_for<GpuVertex>(block_samples(config)));
  b.add(Consumer::scratch, Arena::bytes_for<std::byte>(scratch_bytes(config)));
  return b;
}

Status Terrain::create(const Config& config, std::span<std::byte> memory) {
  if (const Status status = config.validate(); !status.ok()) return status;
  const std::size_t needed = budget(config).cpu_bytes();
  if (needed > memory.size())
    return {StatusCode::limit_reached, "the memory given is smaller than the budget", "memory", needed};
  if (reinterpret_cast<std::uintptr_t>(memory.data()) % Arena::kAlignment != 0) {
    return {StatusCode::invalid_argument, "the memory given is not aligned to 64 bytes", "memory"};
  }
  config_ = config;
  info_ = {};
  reader_ = {};
  arena_ = Arena(memory.first(needed));
  if (const Status status = octree_.create(arena_, static_cast<int>(config.max_depth), config.max_octets);
      !status.ok())
    return status;
  const auto take = [&]<class T>(std::span<T>& out, Consumer consumer, std::size_t count) {
    out = arena_.allocate<T>(consumer, count);
  };
  take(volumes_, Consumer::volumes, config.max_volumes);
  take(patches_, Consumer::patches, config.max_patches);
  take(overrides_, Consumer::patches, config.max_patches);
  HeightCache::Storage heights;
  take(heights.samples, Consumer::heights, held_groups(config) * kHeightGroup * block_samples(config));
  take(heights.slot_of_group, Consumer::heights, height_groups(config.max_patches));
  take(height_crcs_, Consumer::heights, height_groups(config.max_patches));
  take(heights.group_of_slot, Consumer::heights, held_groups(config));
  take(heights.used, Consumer::heights, held_groups(config));
  cache_.create(heights);
  take(bounds_, Consumer::bounds, config.max_patches);
  take(cones_, Consumer::bounds, config.max_patches);
  take(shading_cones_, Consumer::bounds, config.max_patches);
  take(shading_, Consumer::bounds, config.max_patches);
  take(boxes_, Consumer::bounds, BoundsTree::node_count(config.max_patches));
  take(level_errors_, Consumer::level_errors, max_level_errors(config));
  take(lods_, Consumer::thresholds, config.max_patches);
  take(morph_rows_, Consumer::thresholds, std::size_t{config.max_resident_patches} * kMorphRow);
  ResidentPool::Storage pool;
  take(pool.first_page, Consumer::residency, config.max_patches);
  take(pool.row_of_patch, Consumer::residency, config.max_patches);
  take(pool.levels, Consumer::residency, config.max_patches);
  take(pool.next_page, Consumer::residency, config.gpu_vertex_pages);
  take(pool.texels, Consumer::residency, config.gpu_vertex_pages);
  take(pool.rows, Consumer::residency, config.max_resident_patches);
  pool_.create(pool);
  take(lacking_, Consumer::residency, config.max_draw_items);
  std::span<std::uint64_t> words;
  take(words, Consumer::occlusion, config.occluder_words);
  occluders_.create(words);
  std::span<std::uint16_t> entries;
  take(entries, Consumer::occlusion, Occlusion::entry_count(config.max_patches));
  occlusion_.create(entries, config.max_patches);
  take(index_table_, Consumer::index_tables, index_count(static_cast<int>(config.max_level)));
  take(levels_, Consumer::draw_list, config.max_patches);
  take(items_, Consumer::draw_list, config.max_draw_items);
  take(caster_wanted_, Consumer::draw_list, config.max_patches);
  take(caster_levels_, Consumer::draw_list, config.max_patches);
  take(caster_items_, Consumer::draw_list, config.max_draw_items);
  take(list_scratch_, Consumer::draw_list, config.max_patches);
  take(vertices_, Consumer::scratch, block_samples(config));
  take(scratch_, Consumer::scratch, scratch_bytes(config));
  arena_.freeze();
  tree_.create(boxes_);
  patch_scratch_ = nullptr;
  listed_ = 0;
  return build_index_tables(static_cast<int>(config.max_level), index_table_);
}

std::size_t Terrain::level_error_count() const {
  return info_.level == 0 ? 0 : info_.patches * level_error_values(info_.level);
}

Status Terrain::load(const ByteSource& source) {
  info_ = {};
  thresholds_level_ = 0;
  listed_ = 0;
  patch_scratch_ = nullptr;
  if (const Status status = reader_.open(source); !status.ok()) return status;
  const WorldInfo& info = reader_.info();
  const struct {
    std::uint32_t needed, limit;
    const char* name;
  } limits[] = {{static_cast<std::uint32_t>(info.depth), config_.max_depth, "max_depth"},
                {static_cast<std::uint32_t>(info.level), config_.max_level, "max_level"},
                {info.octets, config_.max_octets, "max_octets"},
                {info.volumes, config_.max_volumes, "max_volumes"},
                {info.patches, config_.max_patches, "max_patches"}};
  for (const auto& l : limits) {
    if (l.needed <= l.limit) continue;
    const std::uint32_t needed = l.needed;
    reader_ = {};
    return {StatusCode::limit_reached, "the world is larger than a limit", l.name, needed};
  }
  info_ = info;
  if (const Status status = load_world(); !status.ok()) {
    info_ = {};
    reader_ = {};
    return status;
  }
  patch_scratch_ = make_patch_scratch(scratch_);
  forget_resident();
  pool_scale_ = 1.0f;
  return {};
}

Status Terrain::load_world() {
  if (const Status status = load_surface(); !status.ok()) return status;
  if (const Status status = load_patches(); !status.ok()) return status;
  if (const Status status = tree_.build(surface(), bounds()); !status.ok()) return status;
  if (const Status status = find_shading(); !status.ok()) return status;
  occluders_.build(octree_, info_.extent, surface(), bounds());
  occlusion_.reset();
  if (const Status status = cache_.reset(info_.level, info_.height_blocks); !status.ok()) return status;
  if (!holds_all_heights()) return {};
  for (std::uint32_t block = 0; block < info_.height_blocks; block += kHeightGroup) {
    if (const Status status = cache_.hold(block, height_source()); !status.ok()) return status;
  }
  return check_shared_heights();
}

Status Terrain::load_surface() {
  if (const Status status = reader_.read_octree(scratch_, octree_); !status.ok()) return status;
  ExtractSurface extract;
  extract.octree = &octree_;
  extract.extent = info_.extent;
  extract.volumes = volumes_;
  extract.patches = patches_;
  extract.scratch = {std::launder(reinterpret_cast<std::uint32_t*>(scratch_.data())),
                     ExtractSurface::scratch_size(config_.max_volumes)};
  ExtractSurface::Result made;
  if (const Status status = extract.run(made); !status.ok()) {
    // The pools hold what the header states, so too small a pool means that the header is wrong.
    if (status.code() != StatusCode::limit_reached) return status;
    return {StatusCode::corrupt, "its voxels make more surface than its header states", "patches"};
  }
  if (made.volumes != info_.volumes)
    return {StatusCode::corrupt, "its voxels make another number of volumes than stated", "volumes"};
  if (made.patches != info_.patches)
    return {StatusCode::corrupt, "its voxels make another number of patches than stated", "patches"};
  return reader_.match_keys(surface());
}

Status Terrain::load_patches() {
  const std::span<std::byte> mask = scratch_.first((std::size_t{info_.patches} + 7) / 8);
  if (const Status status = reader_.read_mask(mask); !status.ok()) return status;
  std::uint32_t block = 0;
  for (PatchId p = 0; p < info_.patches; ++p) {
    const bool has = (std::to_integer<unsigned>(mask[p / 8]) >> (p % 8) & 1u) != 0;
    patches_[p].height_block = has ? block++ : kNoHeights;
  }
  const std::uint32_t groups = height_groups(info_.height_blocks);
  if (const Status status = reader_.read_height_crcs(height_crcs_.first(groups)); !status.ok()) return status;
  if (const Status status = reader_.read_level_errors(level_errors_.first(level_error_count())); !status.ok())
    return status;
  if (const Status status = reader_.read_bounds(bounds_.first(info_.patches)); !status.ok()) return status;
  if (const Status status = reader_.read_cones(cones_.first(info_.patches)); !status.ok()) return status;
  if (const Status status = reader_.read_shading_cones(shading_cones_.first(info_.patches)); !status.ok())
    return status;
  return reader_.read_overrides(overrides_.first(info_.patches));
}

Status Terrain::find_shading() {
  FindPatchShading find;
  find.surface = surface();
  find.bounds = bounds();
  find.cones = shading_cones();
  find.materials = &materials();
  find.overrides = material_overrides();
  find.octree = &octree_;
  find.extent = info_.extent;
  find.lights = lights();
  find.skips = shading_skips_;
  find.sky = {std::launder(reinterpret_cast<std::int16_t*>(scratch_.data())),
              scratch_.size() / sizeof(std::int16_t)};
  find.out = shading_.first(info_.patches);
  if (const Status status = find.validate(); !status.ok()) return status;
  find.run();
  return {};
}

// Copies of a border vertex that differ would be a crack. Cheaper than for_each_copy: each edge is looked at
// once.
Status Terrain::check_shared_heights() const {
  const Surface s = surface();
  const Heights h = heights();
  const int level = h.level;
  const int n = patch_cells(level);
  const int side = patch_side(level);
  const auto value = [&](const Patch& p, int i, int j) -> std::int32_t {
    return p.height_block == kNoHeights ? 0 : h.block(p.height_block)[j * side + i];
  };
  for (PatchId id = 0; id < s.patches.size(); ++id) {
    const Patch& p = s.patches[id];
    bool same = true;
    for (int e = 0; e < 4; ++e) {
      const PatchEdge other = p.neighbour[e];
      if (!other.exists() || other.patch() < id) continue;
      const GridLine mine = GridLine::along_edge(e, 0, level, false);
      const GridLine theirs = GridLine::along_edge(other.edge(), 0, level, true);
      const Patch& q = s.patches[other.patch()];
      for (int t = 0; t <= n; ++t) {
        same = same && value(p, mine.i0 + t * mine.di, mine.j0 + t * mine.dj) ==
                           value(q, theirs.i0 + t * theirs.di, theirs.j0 + t * theirs.dj);
      }
    }
    if (p.collapsed != 0) {
      for (int j = 1; j <= n; ++j) same = same && value(p, 0, j) == value(p, 0, 0);
    }
    if (!same) return {StatusCode::corrupt, "heights of a vertex that patches share differ", "heights", id};
  }
  return {};
}

HeightSource Terrain::height_source() const {
  return {this, [](const void* context, std::uint32_t group, std::span<std::int16_t> out) {
            const auto* self = static_cast<const Terrain*>(context);
            return self->reader_.read_heights(group, self->height_crcs_[group], out);
          }};
}

Status Terrain::hold_heights(PatchId patch, int level) {
  if (holds_all_heights()) return {};
  GenerateVertices generate;
  generate.surface = surface();
  generate.level = level;
  cache_.begin();
  Status result;
  generate.for_each_block(patch, [&](std::uint32_t block) {
    if (result.ok()) result = cache_.hold(block, height_source());
  });
  return result;
}

Status Terrain::generate(PatchId patch, int level, int emit_level, std::span<GpuVertex> out) {
  if (const Status status = hold_heights(patch, level); !status.ok()) return status;
  GenerateVertices generate;
  generate.surface = surface();
  generate.heights = heights();
  generate.level = level;
  generate.emit_level = emit_level;
  generate.scratch = patch_scratch_;
  generate.run(patch, out, nullptr);
  return {};
}

LatticeBox Terrain::box() const {
  return tree_.node(tree_.rows() - 1, 0);
}

void Terrain::forget_resident() {
  pool_.reset(info_.patches, base_level());
  lacking_count_ = 0;
  ahead_left_ = 0;
  dirty_begin_ = dirty_end_ = 0;
}

Status Terrain::set_thresholds(const LodSettings& lod, const ErrorScale& scale) {
  const bool morphing = lod.mode == LodMode::error;
  if (scale == scale_ && morphing == morphing_ && lod.top_level() == thresholds_level_) return {};
  SetThresholds set;
  set.scale = scale;
  set.morphing = morphing;
  set.max_level = lod.top_level();
  set.surface = surface();
  set.bounds = bounds();
  set.errors = level_errors();
  set.lods = lods_.first(info_.patches);
  if (const Status status = set.validate(); !status.ok()) return status;
  set.run();
  scale_ = scale;
  morphing_ = morphing;
  thresholds_level_ = lod.top_level();
  ++thresholds_version_;
  for (std::uint32_t row = 0; row < pool_.row_end(); ++row) {
    if (pool_.row_at(row).used) touch_morph_row(row);
  }
  return {};
}

void Terrain::touch_morph_row(std::uint32_t row) {
  std::uint16_t* first = morph_rows_.data() + std::size_t{row} * kMorphRow;
  make_morph_row(surface(), lods(), pool_.row_at(row).patch,
                 std::span<std::uint16_t, kMorphRow>(first, kMorphRow));
  if (dirty_begin_ == dirty_end_) dirty_begin_ = dirty_end_ = row;
  dirty_begin_ = std::min(dirty_begin_, row);
  dirty_end_ = std::max(dirty_end_, row + 1);
}

MorphRows Terrain::take_morph_rows() {
  const MorphRows result = {dirty_begin_,
                            morph_rows_.subspan(std::size_t{dirty_begin_} * kMorphRow,
                                                std::size_t{dirty_end_ - dirty_begin_} * kMorphRow)};
  dirty_begin_ = dirty_end_ = 0;
  return result;
}

Status Terrain::select(const TerrainView& view, Selection& selection) {
  selection = {};
  listed_ = 0;
  lacking_count_ = 0;
  if (view.camera == nullptr) return {StatusCode::invalid_argument, "no camera given", "camera"};
  if (view.width_px < 1 || view.width_px > 65'536) {
    return {StatusCode::invalid_argument, "not within 1..65536", "width_px"};
  }
  if (view.height_px < 1 || view.height_px > 65'536) {
    return {StatusCode::invalid_argument, "not within 1..65536", "height_px"};
  }
  SelectLod lod;
  lod.settings = view.lod;
  lod.settings.max_level = std::min(lod.settings.max_level, info_.level);
  lod.settings.resident_level = std::min(lod.settings.resident_level, info_.level);
  lod.settings.error_px = std::min(lod.settings.error_px * double{pool_scale_}, kMostErrorPx);
  lod.camera = view.camera;
  lod.surface = surface();
  lod.bounds = bounds();
  lod.tree = &tree_;
  const Frustum frustum = make_frustum(*view.camera);
  lod.frustum = view.frustum_culling ? &frustum : nullptr;
  lod.scale = make_error_scale(*view.camera, view.width_px, view.height_px, lod.settings.error_px);
  lod.lods = lods();
  if (view.backface_culling) lod.cones = cones();
  occlusion_.end();
  if (view.occlusion_culling && !occluders_.empty()) {
    occlusion_.begin(occluders_, octree_, tree_, surface(), bounds(), *view.camera, view.occlusion_searches);
    lod.occlusion = &occlusion_;
  }
  if (view.shading_skips != shading_skips_) {
    // Vertices carry what their patch needs.
    shading_skips_ = view.shading_skips;
    if (const Status status = find_shading(); !status.ok()) return status;
    patch_scratch_ = make_patch_scratch(scratch_);
    forget_resident();
  }
  lod.errors = level_errors();
  lod.resident = pool_.levels();
  lod.levels = levels_.first(info_.patches);
  lod.lacking = lacking_;
  if (const Status status = lod.validate(); !status.ok()) return status;
  if (const Status status = set_thresholds(lod.settings, lod.scale); !status.ok()) return status;
  lod_settings_ = lod.settings;
  selection.lod = lod.run();
  lacking_count_ = std::min<std::size_t>(selection.lod.capped, lacking_.size());
  lacking_is_heap_ = false;
  eye_ = make_lod_eye(*view.camera, lod.scale.least_cos2);
  ahead_left_ = lod.settings.mode == LodMode::error ? std::min(kAheadPatches, info_.patches) : 0;

  BuildDrawList list;
  list.frustum_culling = view.frustum_culling;
  list.frustum = &frustum;
  list.camera = view.camera;
  list.surface = surface();
  list.bounds = bounds();
  list.tree = &tree_;
  if (view.backface_culling) list.cones = cones();
  list.least_pixels = lod.scale.least_pixels;
  if (selection.lod.missing == 0) list.occlusion = lod.occlusion;
  list.levels = levels();
  list.scratch = list_scratch_.first(info_.patches);
  list.items = items_;
  if (const Status status = list.validate(); !status.ok()) return status;
  const Status status = list.run(selection.list);
  listed_ = selection.list.drawn;
  govern(selection);
  return status;
}

// Tells the pool what the view needs, and raises the error that is aimed at while that is more than the pool
// has (design 4.8). It falls slowly and with room to spare, so that it does not swing.
void Terrain::govern(Selection& selection) {
  std::uint32_t pages = 0;
  pool_.begin_selection();
  for (const DrawItem& item : items()) {
    pool_.see(item.patch, item.level);
    pages += slot_pages(item.level);
  }
  for (const LackingPatch& patch : lacking_.first(lacking_count_)) {
    pool_.see(patch.patch, patch.wanted);
    const int drawn = levels_[patch.patch];
    pages += slot_pages(patch.wanted) - (drawn == 0 ? 0 : slot_pages(drawn));
  }
  // One page a patch is taken whatever the error is.
  const std::uint32_t seen = selection.list.drawn + selection.lod.missing;
  const std::uint32_t base = pool_.keeps_base() ? info_.patches : seen;
  pages += base - std::min(base, seen);
  selection.wanted_pages = pages;
  selection.error_scale = pool_scale_;
  selection.pool_full = pages > pool_.page_count();
  selection.next_error_scale = pool_scale_;
  pool_full_ = selection.pool_full;
  if (!morphing_) return;
  const float use = static_cast<float>(pages) / static_cast<float>(pool_.page_count());
  const std::uint32_t detail = pages - std::min(pages, base);
  const std::uint32_t room = pool_.page_count() - std::min(pool_.page_count(), base);
  if (selection.pool_full) {
    pool_scale_ = std::min(pool_scale_ * std::clamp(use * 1.05f, 1.1f, 2.0f), kMostErrorScale);
    calm_frames_ = 0;
  } else if (pool_scale_ > 1.0f && detail * 4 <= room * 3 && ++calm_frames_ >= kCalmFrames) {
    pool_scale_ = std::max(pool_scale_ * 0.93f, 1.0f);
    calm_frames_ = 0;
  }
  selection.next_error_scale = pool_scale_;
  selection.pool_full = selection.pool_full || pool_scale_ > 1.0f;
  pool_full_ = selection.pool_full;
}

bool Terrain::make_resident(PatchId patch, int level, PatchUpload& upload, Status& status) {
  const int old_level = pool_.level(patch);
  if (!pool_.raise(patch, level)) return false;
  status = generate(patch, info_.level, level, vertices_);
  if (!status.ok()) {
    pool_.lower(patch, old_level);
    return false;
  }
  const int first = old_level == 0 ? 0 : patch_vertices(old_level);
  const Volume& volume = surface().volume_of(patch);
  upload = {patch,
            pool_.row(patch),
            first,
            vertices_.subspan(static_cast<std::size_t>(first),
                              static_cast<std::size_t>(patch_vertices(level) - first)),
            {volume.corner[0], volume.corner[1], volume.corner[2]},
            shading_[patch]};
  if (old_level == 0) touch_morph_row(upload.row);
  return true;
}

bool Terrain::generate_next(bool ahead, PatchUpload& upload, Status& status) {
  status = {};
  LackingPatch* const first = lacking_.data();
  if (!lacking_is_heap_) {
    for (LackingPatch& patch : lacking_.first(lacking_count_)) {
      if (pool_.level(patch.patch) == 0) patch.px += kHolePx;
    }
    std::make_heap(first, first + lacking_count_, less_urgent);
    lacking_is_heap_ = true;
  }
  while (lacking_count_ > 0) {
    std::pop_heap(first, first + lacking_count_, less_urgent);
    const LackingPatch next = first[--lacking_count_];
    // Where the whole need finds no room, a part of it may; in a full pool holes get the least that fills
    // them.
    const bool least = pool_full_ && pool_.level(next.patch) == 0;
    for (int level = least ? std::min(base_level(), int{next.wanted}) : next.wanted;
         level > pool_.level(next.patch); --level) {
      if (!pool_.make_room(next.patch, level)) continue;
      if (make_resident(next.patch, level, upload, status)) return true;
      if (!status.ok()) return false;
    }
  }
  return ahead && generate_ahead(upload, status);
}

// Patches get their turn by number. What is out of view wants the level it would have at the picture's
// corner: turning the camera then finds it ready.
bool Terrain::generate_ahead(PatchUpload& upload, Status& status) {
  const std::uint32_t spare = pool_.page_count() / 8;
  for (; ahead_left_ > 0; --ahead_left_) {
    if (ahead_ >= info_.patches) ahead_ = 0;
    const PatchId patch = ahead_++;
    const PatchLod& lod = lods_[patch];
    const int base = base_level();
    const int wanted = std::max(base, level_at(lod, least_apparent_distance(lod, eye_) * kAheadDistance));
    const int held = pool_.level(patch);
    if (wanted <= held) continue;
    const std::uint32_t pages = slot_pages(wanted) - (held == 0 ? 0 : slot_pages(held));
    // A coarse version of everything comes before details of what is not seen yet.
    if (pages + (wanted > base ? spare : 0) > pool_.free_pages()) continue;
    if (!make_resident(patch, wanted, upload, status)) {
      if (!status.ok()) return false;
      continue;
    }
    --ahead_left_;
    return true;
  }
  return false;
}

}  // namespace karst::core
