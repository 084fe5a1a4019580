// SPDX-License-Identifier: MIT
#include "terrain/world/world.h"

#include <algorithm>
#include <cstring>
#include <new>

#include "terrain/base/check.h"
#include "terrain/draw/index_batches.h"
#include "terrain/ground/ground_box.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/patch/shared_vertices.h"
#include "terrain/resident/page_table.h"
#include "terrain/surface/bezier/extract_surface.h"

namespace karst::core {
namespace {

// Of worlds that would take more: 1 MiB. Their cells are larger than voxels.
constexpr std::size_t kMostOccluderWords = 131'072;

// Of an edit's new octree, beside the old one, along the ways to a few voxels.
constexpr std::uint32_t kEditPathOctets = 64;

// The heights that a belt reaches: those of its rim, and of the ground beside it, which are in its nodes'
// boxes.
void measure_belt(const WorldPart& part, GroundRegion& region) {
  std::int64_t low = region.belt_high, high = region.belt_low;
  const std::int64_t corner = std::int64_t{part.corner.y} * kStepsPerVoxel;
  for (const RegionRim::Edge& edge : part.rim->edges()) {
    const LatticeBox box = patch_box(part.surface, part.bounds, edge.edge.patch());
    low = std::min(low, corner + box.min.y);
    high = std::max(high, corner + box.max.y);
  }
  region.belt_low = low;
  region.belt_high = high;
}

}  // namespace

World::World() = default;

std::size_t World::sky_boxes(const WorldInfo& info, const GroundInfo& ground,
                             std::span<SkyBox, kMostRegions> boxes) {
  if (ground.region_count < 2) {
    boxes[0] = {glm::ivec3(0), glm::max(info.extent, glm::ivec3(1))};
    return 1;
  }
  std::size_t count = 0;
  for (const GroundRegion& region : ground.regions()) boxes[count++] = {region.corner, region.extent};
  return count;
}

Config World::config_for(const WorldInfo& info, int finest, std::uint32_t detail_pages,
                         const GroundInfo& ground) {
  const auto limit = [](std::uint32_t v) { return std::max(v, 1u); };
  Config config;
  config.max_depth = static_cast<std::uint32_t>(info.depth);
  config.max_octets = limit(info.octets);
  config.max_volumes = limit(info.volumes);
  config.max_patches = limit(info.patches);
  config.max_level = static_cast<std::uint32_t>(info.level);
  config.max_height_blocks = info.height_blocks;
  config.max_regions = info.regions;
  for (const GroundRegion& region : ground.regions()) config.rim_edges += region.rim_edges;
  std::array<SkyBox, kMostRegions> boxes;
  const auto octrees = std::span(boxes).first(sky_boxes(info, ground, boxes));
  std::size_t words = 0;
  for (const SkyBox& box : octrees) words += Occluders::word_count(box.extent, Occluders::kLeastCellLog2);
  config.occluder_words = static_cast<std::uint32_t>(std::min(words, kMostOccluderWords));
  config.sky_words = static_cast<std::uint32_t>(SkyAtlas::word_count(octrees));
  config.max_draw_items = limit(std::min(info.patches, kMostPages));
  config.max_resident_patches = config.max_draw_items;
  const std::uint64_t all = std::uint64_t{config.max_draw_items} * slot_pages(finest);
  const std::uint64_t some = std::uint64_t{config.max_draw_items} + detail_pages;
  config.gpu_vertex_pages = static_cast<std::uint32_t>(std::min<std::uint64_t>({all, some, kMostPages}));
  config.stream_indices = std::max(config.stream_indices, config.max_draw_items * kLeastIndicesPerPatch);
  return config;
}

void World::add_edit_room(std::uint32_t patches, Config& config) {
  const auto add = [](std::uint32_t& limit, std::uint64_t more, std::uint32_t most) {
    limit = static_cast<std::uint32_t>(std::min<std::uint64_t>(limit + more, most));
  };
  add(config.max_octets, std::uint64_t{4} * patches + kEditPathOctets, kFullTreeOctets);
  add(config.max_volumes, patches, kMostPatches);
  add(config.max_patches, patches, kMostPatches);
  config.max_height_blocks = config.max_patches;
  add(config.max_draw_items, patches, kMostPages);
  config.max_resident_patches = config.max_draw_items;
  add(config.gpu_vertex_pages, patches, kMostPages);
  config.stream_indices = std::max(config.stream_indices, config.max_draw_items * kLeastIndicesPerPatch);
  config.edit_patches = patches;
}

// Loading needs the octree's bytes, the table of volumes and the mask; whom it is lent to afterwards a
// PatchScratch. Never two at once.
std::size_t World::scratch_size(const Config& config) {
  const std::size_t table = ExtractSurface::scratch_size(config.max_volumes) * sizeof(std::uint32_t);
  const std::size_t mask = (std::size_t{config.max_patches} + 7) / 8;
  return std::max(
      {table, mask, WorldReader::octree_room(config.max_octets, config.max_regions), patch_scratch_bytes()});
}

// Nodes of the ground are drawn from it as well.
int World::index_table_level(const Config& config) {
  return std::max(static_cast<int>(config.max_level), kNodeLevel);
}

std::size_t World::index_table_size(const Config& config) {
  return index_count(index_table_level(config));
}

Status World::create(const Config& config, Arena& arena) {
  config_ = config;
  info_ = {};
  reader_ = {};
  table_ = {};
  if (const Status status = take_blocks(config, arena, blocks_); !status.ok()) return status;
  if (const Status status = octrees_[0].create(blocks_.octets, static_cast<int>(config.max_depth));
      !status.ok())
    return status;
  table_.create(blocks_.table);
  slots_.create(blocks_.volumes, blocks_.patches, &table_);
  cache_.create(blocks_.heights);
  unload();
  return build_index_tables(index_table_level(config), blocks_.index_table);
}

std::size_t World::level_error_count(std::uint32_t patches) const {
  return info_.level == 0 ? 0 : patches * level_error_values(info_.level);
}

LatticeBox World::box() const {
  KARST_ASSERT(info_.patches > 0 || ground().exists());
  bool any = ground().exists();
  LatticeBox all = any ? ground_box(ground()) : LatticeBox();
  for (const WorldPart& part : parts()) {
    if (part.patches() == 0) continue;
    const LatticeBox box = part.tree->around_all(part.corner);
    all = any ? LatticeBox{glm::min(all.min, box.min), glm::max(all.max, box.max)} : box;
    any = true;
  }
  return all;
}

Heights World::heights() const {
  KARST_ASSERT(holds_all_heights());
  return cache_.heights();
}

HeightSource World::height_source() const {
  return {this, [](const void* context, std::uint32_t group, std::span<std::int16_t> out) {
            const auto* self = static_cast<const World*>(context);
            if (!self->heights_are_read_) {
              // Of the file's last group, what is there: a world with free slots has room behind it.
              const std::uint32_t blocks =
                  std::min(kHeightGroup, self->info_.height_blocks - group * kHeightGroup);
              const std::size_t values = blocks * static_cast<std::size_t>(patch_vertices(self->info_.level));
              return self->reader_.read_heights(group, self->blocks_.height_crcs[group], out.first(values));
            }
            const std::int16_t* const held = self->cache_.heights().block(group * kHeightGroup);
            std::memcpy(out.data(), held, out.size_bytes());
            return Status();
          }};
}

World::Lent World::lend() {
  return {blocks_.scratch, holds_all_heights() ? nullptr : &cache_};
}

// --- Loading

Status World::load(const ByteSource& source) {
  WorldReader opened;
  const Status status = opened.open(source);
  if (status.ok()) return load(opened);
  unload();
  return status;
}

Status World::load(const WorldReader& opened) {
  info_ = {};
  patch_slots_ = 0;
  is_editable_ = heights_are_read_ = false;
  reader_ = opened;
  Status status = check_limits(reader_.info());
  if (status.ok()) {
    info_ = reader_.info();
    status = load_parts();
  }
  if (!status.ok()) unload();
  return status;
}

void World::unload() {
  slots_.adopt(0, 0);
  info_ = {};
  patch_slots_ = 0;
  is_editable_ = false;
  queue_ = {};
  reader_ = {};
  ground_ = {};
  parts_ = {};
  part_count_ = 1;
  place_parts();
  heights_are_read_ = false;
}

Status World::check_limits(const WorldInfo& info) const {
  std::uint32_t rim_edges = 0;
  for (const GroundRegion& region : reader_.ground().regions()) rim_edges += region.rim_edges;
  const struct {
    std::uint32_t needed, limit;
    const char* name;
  } limits[] = {{static_cast<std::uint32_t>(info.depth), config_.max_depth, "max_depth"},
                {static_cast<std::uint32_t>(info.level), config_.max_level, "max_level"},
                {info.octets, config_.max_octets, "max_octets"},
                {info.volumes, config_.max_volumes, "max_volumes"},
                {info.patches, config_.max_patches, "max_patches"},
                {info.regions, config_.max_regions, "max_regions"},
                {rim_edges, config_.rim_edges, "rim_edges"}};
  for (const auto& l : limits) {
    if (l.needed > l.limit)
      return {StatusCode::limit_reached, "the world is larger than a limit", l.name, l.needed};
  }
  return {};
}

// Shares the memory among the parts, whose patches are counted by now, and empties them.
void World::place_parts() {
  const auto share = [](auto block, std::size_t& used, std::size_t count) {
    const auto own = block.subspan(used, count);
    used += count;
    return own;
  };
  std::array<SkyBox, kMostRegions> boxes;
  const auto octrees = std::span(boxes).first(sky_boxes(info_, ground_, boxes));
  sky_atlas_ = SkyAtlas::of(octrees, blocks_.sky.size());
  std::size_t all_words = 0;
  for (const SkyBox& box : octrees) all_words += Occluders::word_count(box.extent, Occluders::kLeastCellLog2);
  std::size_t edges = 0, nodes = 0, eights = 0, words = 0, sky_words = 0;
  for (std::size_t n = 0; n < part_count_; ++n) {
    WorldPart& part = parts_[n];
    const bool one = part_count_ == 1;
    const std::uint32_t patches = one ? static_cast<std::uint32_t>(blocks_.patches.size()) : part.patches();
    const std::size_t rim = one ? blocks_.rim.edges.size() : ground_.regions()[n].rim_edges;
    rims_[n].create({blocks_.rim.edges.subspan(edges, rim), blocks_.rim.marks.subspan(edges, rim)});
    edges += rim;
    trees_[n].create(share(blocks_.boxes, nodes,
                           one ? blocks_.boxes.size() : std::size_t{BoundsTree::node_count(patches)}));
    part.boxes = share(blocks_.patch_boxes, eights, PatchBoxes::count_for(part.patches()));
    std::size_t own = blocks_.occluders.size();
    if (!one) {
      own = Occluders::word_count(octrees[n].extent, Occluders::kLeastCellLog2);
      if (all_words > blocks_.occluders.size()) {
        own = static_cast<std::size_t>(static_cast<double>(own) / static_cast<double>(all_words) *
                                       static_cast<double>(blocks_.occluders.size()));
      }
    }
    occluders_[n].create(share(blocks_.occluders, words, own));
    skies_[n].create(share(blocks_.sky, sky_words, one ? blocks_.sky.size() : sky_atlas_.places[n].words));
    skies_[n].set_least_cell(one ? 0 : sky_atlas_.places[n].grid.cell_log2);
    part.corner = octrees[n].corner;
    part.extent = octrees[n].extent;
    part.octree = &octrees_[n];
    part.tree = &trees_[n];
    part.occluders = &occluders_[n];
    part.sky = &skies_[n];
    part.rim = &rims_[n];
  }
}

Status World::load_parts() {
  if (const Status status = load_surface(); !status.ok()) return status;
  if (const Status status = load_patches(); !status.ok()) return status;
  if (const Status status = load_measures(); !status.ok()) return status;
  patch_slots_ = info_.patches;
  if (config_.edit_patches > 0 && part_count_ == 1 && !ground_.exists() && info_.level > 0) open_slots();
  std::size_t eights = 0;
  for (std::size_t n = 0; n < part_count_; ++n) {
    WorldPart& part = parts_[n];
    part.bounds = part.of(std::span<const PatchBounds>(blocks_.bounds.first(patch_slots_)));
    part.cones = part.of(std::span<const NormalCone>(blocks_.cones.first(patch_slots_)));
    part.shading_cones = part.of(std::span<const NormalCone>(blocks_.shading_cones.first(patch_slots_)));
    const std::size_t values = info_.level == 0 ? 0 : level_error_values(info_.level);
    part.level_errors = {info_.level,
                         all_level_errors().values.subspan(part.first * values, part.patches() * values)};
    if (const Status status = trees_[n].build(part.surface, part.bounds); !status.ok()) return status;
    const std::size_t count = PatchBoxes::count_for(part.patches());
    fill_patch_boxes(part.surface, part.bounds, 0, part.patches(),
                     blocks_.patch_boxes.subspan(eights, count));
    eights += count;
    occluders_[n].build(octrees_[n], part.extent, part.surface, part.bounds);
    skies_[n].build(octrees_[n], part.extent, ground_.region_count > 0);
    if (ground_.region_count > 0) measure_belt(part, ground_.region_list[n]);
  }
  return load_heights();
}

Status World::load_surface() {
  ground_ = reader_.ground();
  part_count_ = info_.regions;
  std::size_t octets = 0, volumes = 0;
  PatchId first = 0;
  for (std::size_t n = 0; n < part_count_; ++n) {
    const bool one = part_count_ == 1;
    const GroundRegion* const region = one ? nullptr : &ground_.regions()[n];
    const std::size_t own_octets = one ? blocks_.octets.size() : region->octets;
    const std::size_t own_volumes = one ? info_.volumes : region->volumes;
    const std::size_t own_patches = one ? info_.patches : region->patches;
    const Status status =
        octrees_[n].create(blocks_.octets.subspan(octets, own_octets), static_cast<int>(config_.max_depth));
    if (!status.ok()) return status;
    parts_[n] = {};
    parts_[n].first = first;
    parts_[n].surface = {blocks_.volumes.subspan(volumes, own_volumes),
                         blocks_.patches.subspan(first, own_patches)};
    octets += own_octets;
    volumes += own_volumes;
    first += static_cast<PatchId>(own_patches);
  }
  place_parts();
  if (const Status status = reader_.read_octrees(blocks_.scratch, std::span(octrees_).first(part_count_));
      !status.ok())
    return status;
  std::array<Surface, kMostRegions> surfaces;
  volumes = 0;
  for (std::size_t n = 0; n < part_count_; ++n) {
    if (const Status status = extract_part(n, volumes); !status.ok()) return status;
    volumes += parts_[n].surface.volumes.size();
    surfaces[n] = parts_[n].surface;
  }
  const Status matched = reader_.match_keys(std::span<const Surface>(surfaces).first(part_count_));
  if (!matched.ok()) return matched;
  // Of several regions slots are not handed out: nothing is edited there.
  slots_.adopt(part_count_ == 1 ? info_.volumes : 0, part_count_ == 1 ? info_.patches : 0);
  for (std::size_t n = 0; n < part_count_ && ground_.region_count > 0; ++n) {
    const GroundRegion& region = ground_.regions()[n];
    if (const Status status = rims_[n].build(region, ground_.lattice_size, parts_[n].surface); !status.ok())
      return status;
    if (rims_[n].edges().size() != region.rim_edges)
      return {StatusCode::corrupt, "a region's rim has another number of edges than stated", "rim_edges"};
  }
  return {};
}

Status World::extract_part(std::size_t n, std::size_t first_volume) {
  const WorldPart& part = parts_[n];
  const bool one = part_count_ == 1;
  ExtractSurface extract;
  extract.octree = &octrees_[n];
  extract.extent = part.extent;
  extract.mirrors = ground_.region_count > 0;
  // Of one part there is room for more, which shows a wrong header.
  extract.volumes =
      one ? blocks_.volumes : blocks_.volumes.subspan(first_volume, part.surface.volumes.size());
  extract.patches = one ? blocks_.patches : blocks_.patches.subspan(part.first, part.patches());
  extract.scratch = {std::launder(reinterpret_cast<std::uint32_t*>(blocks_.scratch.data())),
                     ExtractSurface::scratch_size(config_.max_volumes)};
  ExtractSurface::Result made;
  if (const Status status = extract.run(made); !status.ok()) {
    // The pools hold what the header states, so too small a pool means that the header is wrong.
    if (status.code() != StatusCode::limit_reached) return status;
    return {StatusCode::corrupt, "its voxels make more surface than its header states", "patches"};
  }
  if (made.volumes != part.surface.volumes.size())
    return {StatusCode::corrupt, "its voxels make another number of volumes than stated", "volumes"};
  if (made.patches != part.surface.patches.size())
    return {StatusCode::corrupt, "its voxels make another number of patches than stated", "patches"};
  return {};
}

Status World::load_patches() {
  const std::span<std::byte> mask = blocks_.scratch.first((std::size_t{info_.patches} + 7) / 8);
  if (const Status status = reader_.read_mask(mask); !status.ok()) return status;
  std::uint32_t block = 0;
  for (PatchId p = 0; p < info_.patches; ++p) {
    const bool has = (std::to_integer<unsigned>(mask[p / 8]) >> (p % 8) & 1u) != 0;
    blocks_.patches[p].height_block = has ? block++ : kNoHeights;
  }
  return reader_.read_overrides(blocks_.overrides.first(info_.patches));
}

Status World::load_measures() {
  Status status = reader_.read_level_errors(blocks_.level_errors.first(level_error_count(info_.patches)));
  if (status.ok()) status = reader_.read_bounds(blocks_.bounds.first(info_.patches));
  if (status.ok()) status = reader_.read_cones(blocks_.cones.first(info_.patches));
  if (status.ok()) status = reader_.read_shading_cones(blocks_.shading_cones.first(info_.patches));
  return status;
}

Status World::load_heights() {
  const std::uint32_t groups = height_groups(info_.height_blocks);
  if (const Status status = reader_.read_height_crcs(blocks_.height_crcs.first(groups)); !status.ok())
    return status;
  const std::uint32_t blocks = is_editable_ ? patch_slots_ : info_.height_blocks;
  if (const Status status = cache_.reset(info_.level, blocks); !status.ok()) return status;
  if (is_editable_ && !holds_all_heights()) {
    return {StatusCode::limit_reached, "too few for a world that is edited", "max_height_blocks", blocks};
  }
  if (!holds_all_heights()) return {};
  for (std::uint32_t block = 0; block < info_.height_blocks; block += kHeightGroup) {
    if (const Status status = cache_.hold(block, height_source()); !status.ok()) return status;
  }
  heights_are_read_ = true;
  if (is_editable_) spread_heights();
  return check_shared_heights();
}

// Free slots behind those of the file, as many as there is memory for.
void World::open_slots() {
  is_editable_ = true;
  queue_.create(blocks_.edit.queue);
  queue_.reset();
  patch_slots_ = config_.max_patches;
  WorldPart& part = parts_[0];
  const auto rest = [](auto block, std::size_t used) { return block.subspan(used); };
  Patch free;
  free = {};
  free.volume = kNoVolume;
  free.height_block = kNoHeights;
  std::ranges::fill(rest(blocks_.patches, info_.patches), free);
  std::ranges::fill(rest(blocks_.volumes, info_.volumes), Volume{});
  std::ranges::fill(rest(blocks_.bounds, info_.patches), PatchBounds{});
  std::ranges::fill(rest(blocks_.cones, info_.patches), NormalCone{});
  std::ranges::fill(rest(blocks_.shading_cones, info_.patches), NormalCone{});
  std::ranges::fill(rest(blocks_.overrides, info_.patches), std::uint8_t{0});
  std::ranges::fill(rest(blocks_.level_errors, level_error_count(info_.patches)), std::uint16_t{0});
  std::ranges::fill(blocks_.edit.kept, 0u);
  part.surface = {blocks_.volumes, blocks_.patches};
  part.boxes = blocks_.patch_boxes;
}

// To each patch's slot the block of its number. The last ones first: no block has a higher number than its
// patch.
void World::spread_heights() {
  cache_.hold_rest();
  for (PatchId p = info_.patches; p-- > 0;) {
    std::uint32_t& block = blocks_.patches[p].height_block;
    if (block == kNoHeights || block == p) continue;
    const std::span<const std::int16_t> from = cache_.block(block);
    std::copy(from.begin(), from.end(), cache_.block(p).begin());
    block = p;
  }
}

World::Editable World::edit() {
  KARST_ASSERT(is_editable_);
  Editable all;
  all.extent = parts_[0].extent;
  all.octree = &octrees_[0];
  all.slots = &slots_;
  all.heights = &cache_;
  all.surface = parts_[0].surface;
  all.patches = blocks_.patches;
  all.bounds = blocks_.bounds;
  all.cones = blocks_.cones;
  all.shading_cones = blocks_.shading_cones;
  all.level_errors = blocks_.level_errors.first(level_error_count(patch_slots_));
  all.overrides = blocks_.overrides.first(reader_.has_overrides() ? patch_slots_ : 0);
  all.boxes = blocks_.patch_boxes;
  all.tree = &trees_[0];
  all.occluders = &occluders_[0];
  all.sky = &skies_[0];
  all.queue = &queue_;
  all.room = &blocks_.edit;
  return all;
}

// Copies of a border vertex that differ would be a crack. Cheaper than for_each_copy: each edge is looked at
// once.
Status World::check_shared_heights() const {
  for (const WorldPart& part : parts()) {
    if (const Status status = check_shared_heights(part.surface); !status.ok()) return status;
  }
  return {};
}

Status World::check_shared_heights(const Surface& s) const {
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
    if (!same) return {StatusCode::corrupt, "heights of a vertex that patches share differ", "heights"};
  }
  return {};
}

}  // namespace karst::core
