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

}  // namespace

Config World::config_for(const WorldInfo& info, int finest, std::uint32_t detail_pages) {
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
  config.sky_words = static_cast<std::uint32_t>(SkyVisibility::word_count(info.extent));
  config.max_draw_items = limit(std::min(info.patches, kMostPages));
  config.max_resident_patches = config.max_draw_items;
  const std::uint64_t all = std::uint64_t{config.max_draw_items} * slot_pages(finest);
  const std::uint64_t some = std::uint64_t{config.max_draw_items} + detail_pages;
  config.gpu_vertex_pages = static_cast<std::uint32_t>(std::min<std::uint64_t>({all, some, kMostPages}));
  config.stream_indices = std::max(config.stream_indices, config.max_draw_items * kLeastIndicesPerPatch);
  return config;
}

// Loading needs the octree's bytes, the table of volumes and the mask; whom it is lent to afterwards a
// PatchScratch. Never two at once.
std::size_t World::scratch_size(const Config& config) {
  const std::size_t table = ExtractSurface::scratch_size(config.max_volumes) * sizeof(std::uint32_t);
  const std::size_t mask = (std::size_t{config.max_patches} + 7) / 8;
  return std::max({table, mask, WorldReader::octree_room(config.max_octets), patch_scratch_bytes()});
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
  if (const Status status = octree_.create(blocks_.octets, static_cast<int>(config.max_depth)); !status.ok())
    return status;
  table_.create(blocks_.table);
  slots_.create(blocks_.volumes, blocks_.patches, &table_);
  rim_.create(blocks_.rim);
  cache_.create(blocks_.heights);
  tree_.create(blocks_.boxes);
  occluders_.create(blocks_.occluders);
  sky_.create(blocks_.sky);
  return build_index_tables(index_table_level(config), blocks_.index_table);
}

std::size_t World::level_error_count() const {
  return info_.level == 0 ? 0 : info_.patches * level_error_values(info_.level);
}

LatticeBox World::box() const {
  KARST_ASSERT(info_.patches > 0 || ground().exists());
  if (info_.patches == 0) return ground_box(ground());
  const LatticeBox patches = tree_.node(tree_.rows() - 1, 0);
  if (!ground().exists()) return patches;
  const LatticeBox other = ground_box(ground());
  return {glm::min(patches.min, other.min), glm::max(patches.max, other.max)};
}

Heights World::heights() const {
  KARST_ASSERT(holds_all_heights());
  return cache_.heights();
}

HeightSource World::height_source() const {
  return {this, [](const void* context, std::uint32_t group, std::span<std::int16_t> out) {
            const auto* self = static_cast<const World*>(context);
            if (!self->heights_are_read_) {
              return self->reader_.read_heights(group, self->blocks_.height_crcs[group], out);
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
  heights_are_read_ = false;
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
  reader_ = {};
  heights_are_read_ = false;
}

Status World::check_limits(const WorldInfo& info) const {
  const struct {
    std::uint32_t needed, limit;
    const char* name;
  } limits[] = {{static_cast<std::uint32_t>(info.depth), config_.max_depth, "max_depth"},
                {static_cast<std::uint32_t>(info.level), config_.max_level, "max_level"},
                {info.octets, config_.max_octets, "max_octets"},
                {info.volumes, config_.max_volumes, "max_volumes"},
                {info.patches, config_.max_patches, "max_patches"},
                {reader_.ground().rim_edges, config_.rim_edges, "rim_edges"}};
  for (const auto& l : limits) {
    if (l.needed > l.limit)
      return {StatusCode::limit_reached, "the world is larger than a limit", l.name, l.needed};
  }
  return {};
}

Status World::load_parts() {
  if (const Status status = load_surface(); !status.ok()) return status;
  if (const Status status = load_patches(); !status.ok()) return status;
  if (const Status status = load_measures(); !status.ok()) return status;
  if (const Status status = tree_.build(surface(), bounds()); !status.ok()) return status;
  fill_patch_boxes(surface(), bounds(), 0, info_.patches, blocks_.patch_boxes);
  occluders_.build(octree_, info_.extent, surface(), bounds());
  sky_.build(octree_, info_.extent, ground().region.exists());
  return load_heights();
}

Status World::load_surface() {
  if (const Status status = reader_.read_octree(blocks_.scratch, octree_); !status.ok()) return status;
  ExtractSurface extract;
  extract.octree = &octree_;
  extract.extent = info_.extent;
  extract.mirrors = ground().region.exists();
  extract.volumes = blocks_.volumes;
  extract.patches = blocks_.patches;
  extract.scratch = {std::launder(reinterpret_cast<std::uint32_t*>(blocks_.scratch.data())),
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
  if (const Status status = reader_.match_keys(surface()); !status.ok()) return status;
  slots_.adopt(info_.volumes, info_.patches);
  if (const Status status = rim_.build(ground(), surface()); !status.ok()) return status;
  if (rim_.edges().size() != ground().rim_edges)
    return {StatusCode::corrupt, "its region's rim has another number of edges than stated", "rim_edges"};
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
  Status status = reader_.read_level_errors(blocks_.level_errors.first(level_error_count()));
  if (status.ok()) status = reader_.read_bounds(blocks_.bounds.first(info_.patches));
  if (status.ok()) status = reader_.read_cones(blocks_.cones.first(info_.patches));
  if (status.ok()) status = reader_.read_shading_cones(blocks_.shading_cones.first(info_.patches));
  return status;
}

Status World::load_heights() {
  const std::uint32_t groups = height_groups(info_.height_blocks);
  if (const Status status = reader_.read_height_crcs(blocks_.height_crcs.first(groups)); !status.ok())
    return status;
  if (const Status status = cache_.reset(info_.level, info_.height_blocks); !status.ok()) return status;
  if (!holds_all_heights()) return {};
  for (std::uint32_t block = 0; block < info_.height_blocks; block += kHeightGroup) {
    if (const Status status = cache_.hold(block, height_source()); !status.ok()) return status;
  }
  heights_are_read_ = true;
  return check_shared_heights();
}

// Copies of a border vertex that differ would be a crack. Cheaper than for_each_copy: each edge is looked at
// once.
Status World::check_shared_heights() const {
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
    if (!same) return {StatusCode::corrupt, "heights of a vertex that patches share differ", "heights"};
  }
  return {};
}

}  // namespace karst::core
