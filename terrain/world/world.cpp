// SPDX-License-Identifier: MIT
#include "terrain/world/world.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
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

// The heights that a belt reaches: those of its rim, and of the ground beside it, which are in its nodes'
// boxes.
void measure_belt(const WorldPart& part, GroundRegion& region) {
  std::int64_t low = std::numeric_limits<std::int64_t>::max();
  std::int64_t high = std::numeric_limits<std::int64_t>::min();
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

const GroundRegion& World::find_belt(std::size_t part) {
  measure_belt(parts_[part], ground_.region_list[part]);
  return ground_.region_list[part];
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
  const auto octrees = std::span(boxes).first(sky_boxes(info, ground, config, boxes));
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
  const std::uint64_t parts = config.max_regions;
  const auto add = [&](std::uint32_t& limit, std::uint64_t more, std::uint32_t most) {
    limit = static_cast<std::uint32_t>(std::min<std::uint64_t>(limit + parts * more, most));
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
  if (const Status status = take_blocks(config, arena, blocks_); !status.ok()) return status;
  if (const Status status = octrees_[0].create(blocks_.octets, static_cast<int>(config.max_depth));
      !status.ok())
    return status;
  cache_.create(blocks_.heights);
  field_.create(blocks_.field);
  unload();
  return build_index_tables(index_table_level(config), blocks_.index_table);
}

std::size_t World::level_error_count(std::uint32_t patches) const {
  return info_.level == 0 ? 0 : patches * level_error_values(info_.level);
}

LatticeBox World::box() const {
  KARST_ASSERT(info_.patches > 0 || ground().exists() || field_.exists());
  bool any = ground().exists();
  LatticeBox all = any ? ground_box(ground()) : LatticeBox();
  if (field_.exists()) {
    const glm::ivec3 low = field_corner() * kStepsPerVoxel + field_.info().low_steps();
    const LatticeBox box{low, low + field_.info().drawn_steps()};
    all = any ? LatticeBox{glm::min(all.min, box.min), glm::max(all.max, box.max)} : box;
    any = true;
  }
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
            if (!self->state_.heights_are_read) {
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
  field_.clear();
  patch_slots_ = 0;
  state_ = {};
  reader_ = opened;
  Status status = check_limits(reader_.info());
  if (status.ok()) {
    info_ = reader_.info();
    status = load_parts();
  }
  if (status.ok() && reader_.field().exists()) status = reader_.read_field(field_);
  if (!status.ok()) unload();
  return status;
}

void World::unload() {
  info_ = {};
  patch_slots_ = 0;
  state_.editable = false;
  queues_ = {};
  reader_ = {};
  field_.clear();
  ground_ = {};
  parts_ = {};
  part_count_ = 1;
  state_.slot_parts = 1;
  state_.spares = false;
  place_slots();
  place_parts();
  state_.heights_are_read = false;
}

bool World::is_settled(std::size_t part) const {
  return is_staged(part) || (queues_[part].left() == 0 && !skies_[part].is_behind());
}

bool World::is_settled() const {
  for (std::size_t n = 0; n < part_count_; ++n) {
    if (!is_settled(n)) return false;
  }
  return true;
}

std::uint32_t World::free_patches() const {
  std::uint32_t used = 0;
  if (!is_editable()) return 0;
  for (std::size_t n = 0; n < part_count_; ++n) used += is_staged(n) ? 0 : tables_[n].size();
  return patch_slots_ - used;
}

World::Counts World::file_counts(std::size_t part) const {
  const std::size_t of_file = state_.spares ? state_.file_regions : part_count_;
  if (part >= of_file) return {};
  if (of_file == 1) return {info_.octets, info_.volumes, info_.patches};
  const GroundRegion& region = ground_.regions()[part];
  return {region.octets, region.volumes, region.patches};
}

// What is free is shared alike. Of one part all that there is memory for is used, which shows a wrong header.
World::Counts World::slot_counts(std::size_t part) const {
  if (state_.slot_parts == 1) {
    return {static_cast<std::uint32_t>(blocks_.octets.size()),
            static_cast<std::uint32_t>(blocks_.volumes.size()),
            static_cast<std::uint32_t>(blocks_.patches.size())};
  }
  Counts counts = file_counts(part);
  if (!state_.editable) return counts;
  const auto parts = static_cast<std::uint32_t>(state_.slot_parts);
  const Counts spare = state_.spares ? spare_counts(config_) : Counts();
  const auto spares = static_cast<std::uint32_t>(state_.spares ? state_.slot_parts - state_.file_regions : 0);
  const auto add = [&](std::uint32_t& own, std::uint32_t all, std::uint32_t of_file, std::uint32_t of_spare) {
    const std::uint32_t taken = of_file + spares * of_spare;
    own += (all > taken ? all - taken : 0) / parts +
           (state_.spares && part >= state_.file_regions ? of_spare : 0);
  };
  add(counts.octets, config_.max_octets, info_.octets, spare.octets);
  add(counts.volumes, config_.max_volumes, info_.volumes, spare.volumes);
  add(counts.patches, config_.max_patches, info_.patches, spare.patches);
  return counts;
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

// Shares memory of voxels and patches among the parts, which are empty then. Without edits slots of several
// are not handed out.
void World::place_slots() {
  Counts used;
  std::size_t entries = 0;
  for (std::size_t n = 0; n < state_.slot_parts; ++n) {
    const Counts file = file_counts(n), slots = slot_counts(n);
    parts_[n] = {};
    parts_[n].first = used.patches;
    parts_[n].surface = {blocks_.volumes.subspan(used.volumes, file.volumes),
                         blocks_.patches.subspan(used.patches, file.patches)};
    const std::span<Octree::Octet> octets = blocks_.octets.subspan(used.octets, slots.octets);
    const Status status = octrees_[n].create(octets, static_cast<int>(config_.max_depth));
    KARST_ASSERT(status.ok());
    static_cast<void>(status);
    if (state_.slot_parts == 1 || state_.editable) {
      const std::size_t count = PatchTable::entry_count(slots.patches);
      tables_[n].create({blocks_.table.keys.subspan(used.patches, slots.patches),
                         blocks_.table.entries.subspan(entries, count)});
      slots_[n].create(blocks_.volumes.subspan(used.volumes, slots.volumes),
                       blocks_.patches.subspan(used.patches, slots.patches), &tables_[n]);
      entries += count;
    } else if (n == 0) {
      tables_[n].create(blocks_.table);
    }
    used.octets += slots.octets;
    used.volumes += slots.volumes;
    used.patches += slots.patches;
  }
}

// Shares the memory of what follows among the parts, and empties it.
void World::place_parts() {
  const auto share = [](auto block, std::size_t& used, std::size_t count) {
    const auto own = block.subspan(used, count);
    used += count;
    return own;
  };
  std::array<SkyBox, kMostRegions> boxes;
  const auto octrees = std::span(boxes).first(sky_boxes(info_, ground_, config_, boxes));
  sky_atlas_ = sky_atlas_for(info_, ground_, config_);
  std::size_t all_words = 0;
  for (const SkyBox& box : octrees) all_words += Occluders::word_count(box.extent, Occluders::kLeastCellLog2);
  std::size_t edges = 0, nodes = 0, eights = 0, words = 0, sky_words = 0;
  for (std::size_t n = 0; n < state_.slot_parts; ++n) {
    WorldPart& part = parts_[n];
    const bool one = state_.slot_parts == 1 && !state_.spares;
    const bool spare = state_.spares && n >= ground_.regions().size();
    const std::uint32_t patches = slot_counts(n).patches;
    const std::size_t rim = one     ? blocks_.rim.edges.size()
                            : spare ? spare_rim_edges(config_)
                                    : ground_.regions()[n].rim_edges;
    rims_[n].create({blocks_.rim.edges.subspan(edges, rim), blocks_.rim.marks.subspan(edges, rim)});
    edges += rim;
    trees_[n].create(share(blocks_.boxes, nodes,
                           one ? blocks_.boxes.size() : std::size_t{BoundsTree::node_count(patches)}));
    part.boxes =
        share(blocks_.patch_boxes, eights, PatchBoxes::count_for(state_.editable ? patches : part.patches()));
    if (spare) part.boxes = part.boxes.first(0);
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
    part.corner = spare ? glm::ivec3(0) : octrees[n].corner;
    part.extent = spare ? info_.extent : octrees[n].extent;
    Nothing& nothing = state_.nothing;
    part.octree = spare ? &nothing.octree : &octrees_[n];
    part.tree = spare ? &nothing.tree : &trees_[n];
    part.occluders = spare ? &nothing.occluders : &occluders_[n];
    part.sky = spare ? &nothing.sky : &skies_[n];
    part.rim = spare ? &nothing.rim : &rims_[n];
  }
}

Status World::load_parts() {
  if (const Status status = load_paint(); !status.ok()) return status;
  ground_ = reader_.ground();
  part_count_ = info_.regions;
  // Of a ground without regions there are no voxels.
  state_.spares = has_spares(ground_, config_) && info_.level > 0;
  state_.file_regions = ground_.regions().size();
  state_.slot_parts = state_.spares ? slot_parts_of(info_, ground_, config_) : part_count_;
  state_.editable = config_.edit_patches > 0 && info_.level > 0 &&
                    (!ground_.exists() || ground_.region_count > 0 || state_.spares);
  if (const Status status = load_surface(); !status.ok()) return status;
  if (const Status status = load_patches(); !status.ok()) return status;
  if (const Status status = load_measures(); !status.ok()) return status;
  patch_slots_ = info_.patches;
  if (state_.editable) open_slots();
  std::size_t eights = 0;
  for (std::size_t n = 0; n < part_count_; ++n) {
    WorldPart& part = parts_[n];
    set_spans(part);
    if (const Status status = trees_[n].build(part.surface, part.bounds); !status.ok()) return status;
    const std::size_t count = PatchBoxes::count_for(part.patches());
    fill_patch_boxes(part.surface, part.bounds, 0, part.patches(),
                     blocks_.patch_boxes.subspan(eights, count));
    eights += count;
    if (state_.spares && n >= ground_.regions().size()) continue;
    const bool is_field = ground_.region_count > 0 && ground_.regions()[n].is_field();
    if (!is_field) occluders_[n].build(octrees_[n], part.extent, part.surface, part.bounds);
    skies_[n].build(octrees_[n], part.extent, ground_.region_count > 0);
    if (ground_.region_count > 0 && !is_field) measure_belt(part, ground_.region_list[n]);
  }
  return load_heights();
}

// Of arrays by patch, those of a part.
void World::set_spans(WorldPart& part) const {
  part.bounds = part.of(std::span<const PatchBounds>(blocks_.bounds.first(patch_slots_)));
  part.cones = part.of(std::span<const NormalCone>(blocks_.cones.first(patch_slots_)));
  part.shading_cones = part.of(std::span<const NormalCone>(blocks_.shading_cones.first(patch_slots_)));
  const std::size_t values = info_.level == 0 ? 0 : level_error_values(info_.level);
  part.level_errors = {info_.level,
                       all_level_errors().values.subspan(part.first * values, part.patches() * values)};
}

Status World::load_surface() {
  place_slots();
  place_parts();
  if (const Status status = reader_.read_octrees(blocks_.scratch, std::span(octrees_).first(part_count_));
      !status.ok())
    return status;
  std::array<Surface, kMostRegions> surfaces;
  for (std::size_t n = 0; n < part_count_; ++n) {
    if (const Status status = extract_part(n); !status.ok()) return status;
    surfaces[n] = parts_[n].surface;
  }
  const Status matched = reader_.match_keys(std::span<const Surface>(surfaces).first(part_count_));
  if (!matched.ok()) return matched;
  for (std::size_t n = 0; n < part_count_; ++n) {
    const Counts file = file_counts(n);
    if (state_.slot_parts == 1 || state_.editable) slots_[n].adopt(file.volumes, file.patches);
  }
  for (std::size_t n = 0; n < part_count_ && ground_.region_count > 0; ++n) {
    const GroundRegion& region = ground_.regions()[n];
    if (region.is_field()) continue;
    if (const Status status = rims_[n].build(region, ground_.lattice_size, parts_[n].surface); !status.ok())
      return status;
    if (rims_[n].edges().size() != region.rim_edges)
      return {StatusCode::corrupt, "a region's rim has another number of edges than stated", "rim_edges"};
  }
  return {};
}

Status World::extract_part(std::size_t n) {
  const WorldPart& part = parts_[n];
  if (ground_.region_count > 0 && ground_.regions()[n].is_field()) return {};
  const Counts slots = slot_counts(n);
  ExtractSurface extract;
  extract.octree = &octrees_[n];
  extract.extent = part.extent;
  extract.mirrors = ground_.region_count > 0;
  const auto first_volume = static_cast<std::size_t>(part.surface.volumes.data() - blocks_.volumes.data());
  extract.volumes = blocks_.volumes.subspan(first_volume, slots.volumes);
  extract.patches = blocks_.patches.subspan(part.first, slots.patches);
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
  PatchId p = 0;  // of the file
  for (const WorldPart& part : parts()) {
    for (PatchId id = 0; id < part.patches(); ++id, ++p) {
      const bool has = (std::to_integer<unsigned>(mask[p / 8]) >> (p % 8) & 1u) != 0;
      blocks_.patches[part.first + id].height_block = has ? block++ : kNoHeights;
    }
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
  const std::uint32_t blocks = state_.editable ? patch_slots_ : info_.height_blocks;
  if (const Status status = cache_.reset(info_.level, blocks); !status.ok()) return status;
  if (state_.editable && !holds_all_heights()) {
    return {StatusCode::limit_reached, "too few for a world that is edited", "max_height_blocks", blocks};
  }
  if (!holds_all_heights()) return {};
  for (std::uint32_t block = 0; block < info_.height_blocks; block += kHeightGroup) {
    if (const Status status = cache_.hold(block, height_source()); !status.ok()) return status;
  }
  state_.heights_are_read = true;
  if (state_.editable) spread_heights();
  return check_shared_heights();
}

// What the file has of its patches, in their order, to their slots; 0 to the free ones behind them.
template <class T>
void World::spread(std::span<T> all, std::size_t values) const {
  std::size_t end = info_.patches;
  const std::size_t parts = state_.slot_parts;
  const auto at = [&](std::size_t patch) {
    return all.begin() + static_cast<std::ptrdiff_t>(patch * values);
  };
  for (std::size_t n = parts; n-- > 0;) {
    const std::size_t first = parts_[n].first, count = file_counts(n).patches;
    if (first + count != end) std::copy_backward(at(end - count), at(end), at(first + count));
    std::fill(at(first + count), at(first + slot_counts(n).patches), T{});
    end -= count;
  }
}

// Free slots behind those of the file, in each part.
void World::open_slots() {
  patch_slots_ = 0;
  for (std::size_t n = 0; n < state_.slot_parts; ++n) patch_slots_ += slot_counts(n).patches;
  spread(blocks_.bounds, 1);
  spread(blocks_.cones, 1);
  spread(blocks_.shading_cones, 1);
  spread(blocks_.overrides, 1);
  spread(blocks_.level_errors, level_error_values(info_.level));
  Patch free;
  free = {};
  free.volume = kNoVolume;
  free.height_block = kNoHeights;
  std::ranges::fill(blocks_.edit.kept, 0u);
  std::size_t first_volume = 0;
  for (std::size_t n = 0; n < state_.slot_parts; ++n) {
    WorldPart& part = parts_[n];
    const Counts file = file_counts(n), slots = slot_counts(n);
    const std::span<Volume> volumes = blocks_.volumes.subspan(first_volume, slots.volumes);
    const std::span<Patch> patches = blocks_.patches.subspan(part.first, slots.patches);
    std::ranges::fill(volumes.subspan(file.volumes), Volume{});
    std::ranges::fill(patches.subspan(file.patches), free);
    part.surface = {volumes, patches};
    if (state_.spares && n >= ground_.regions().size()) part.surface = {};
    queues_[n].create({blocks_.edit.queue.own.subspan(part.first, slots.patches),
                       blocks_.edit.queue.states.subspan(part.first, slots.patches)});
    queues_[n].reset();
    first_volume += slots.volumes;
  }
}

// A map of the file's is as large as the file says.
Status World::load_paint() {
  if (!is_paintable()) return {};
  BlendMap& map = reader_.painted_map();
  std::ranges::fill(blocks_.paint_kept, 0u);
  if (map.exists()) {
    if (map.width != config_.paint_width)
      return {StatusCode::limit_reached, "not that of the world's blend map", "paint_width", map.width};
    if (map.depth != config_.paint_depth)
      return {StatusCode::limit_reached, "not that of the world's blend map", "paint_depth", map.depth};
    return reader_.read_blend_rows(0, map.depth, blocks_.paint);
  }
  map.width = config_.paint_width;
  map.depth = config_.paint_depth;
  std::ranges::fill(blocks_.paint, std::byte{0});
  return {};
}

World::Paint World::paint() {
  KARST_ASSERT(is_paintable());
  return {&reader_.painted_map(), blocks_.paint, blocks_.overrides.first(patch_slots_), blocks_.paint_kept};
}

// To each patch's slot the block of its number. The last ones first: no block has a higher number than its
// patch, and no patch than its slot.
void World::spread_heights() {
  cache_.hold_rest();
  for (std::size_t n = part_count_; n-- > 0;) {
    const PatchId first = parts_[n].first;
    for (PatchId slot = first + file_counts(n).patches; slot-- > first;) {
      std::uint32_t& block = blocks_.patches[slot].height_block;
      if (block == kNoHeights || block == slot) continue;
      const std::span<const std::int16_t> from = cache_.block(block);
      std::copy(from.begin(), from.end(), cache_.block(slot).begin());
      block = slot;
    }
  }
}

World::Editable World::edit(std::size_t n) {
  KARST_ASSERT(state_.editable && (n < part_count_ || is_staged(n)));
  const WorldPart& part = this->part(n);
  const std::size_t values = level_error_values(info_.level);
  Editable all;
  all.extent = part.extent;
  all.mirrors = ground_.region_count > 0 || is_staged(n);
  all.first = part.first;
  all.octree = &octrees_[n];
  all.slots = &slots_[n];
  all.heights = &cache_;
  all.surface = part.surface;
  all.patches = part.of(blocks_.patches);
  all.bounds = part.of(blocks_.bounds);
  all.cones = part.of(blocks_.cones);
  all.shading_cones = part.of(blocks_.shading_cones);
  all.level_errors = blocks_.level_errors.subspan(part.first * values, part.patches() * values);
  all.overrides = part.of(blocks_.overrides.first(material_overrides().size()));
  all.boxes = blocks_.patch_boxes.subspan(
      static_cast<std::size_t>(part.boxes.data() - blocks_.patch_boxes.data()), part.boxes.size());
  all.tree = &trees_[n];
  all.occluders = &occluders_[n];
  all.sky = &skies_[n];
  all.queue = &queues_[n];
  // Where its sky lies among all.
  std::size_t words = 0;
  for (std::size_t before = 0; before < n; ++before) words += sky_atlas_.places[before].words;
  all.sky_room = state_.slot_parts == 1 && !state_.spares
                     ? blocks_.edit.sky
                     : blocks_.edit.sky.subspan(words, sky_atlas_.places[n].words);
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
