// SPDX-License-Identifier: MIT
#include "terrain/world/terrain.h"

#include <algorithm>
#include <cstring>
#include <new>

#include "terrain/patch/index_batches.h"
#include "terrain/patch/shared_vertices.h"

namespace karst {
namespace {

// Loading needs the table of volumes, generating a PatchScratch; never both at once.
std::size_t scratch_bytes(const Config& config) {
  const std::size_t table = ExtractSurface::scratch_size(config.max_volumes) * sizeof(std::uint32_t);
  return std::max(table, patch_scratch_bytes());
}

std::size_t max_height_samples(const Config& config) {
  return std::size_t{config.max_height_blocks} *
         static_cast<std::size_t>(patch_vertices(static_cast<int>(config.max_level)));
}

std::size_t max_level_errors(const Config& config) {
  return config.max_patches * level_error_values(static_cast<int>(config.max_level));
}

}  // namespace

Config Terrain::config_for(const WorldInfo& info, int resident_level) {
  const auto limit = [](std::uint32_t v) { return std::max(v, 1u); };
  Config config;
  config.max_depth = static_cast<std::uint32_t>(info.depth);
  config.max_octets = limit(info.octets);
  config.max_volumes = limit(info.volumes);
  config.max_patches = limit(info.patches);
  config.max_level = static_cast<std::uint32_t>(info.level);
  config.max_height_blocks = info.height_blocks;
  config.max_draw_items = limit(info.patches);
  config.gpu_vertex_pages = limit(info.patches) * slot_pages(resident_level);
  return config;
}

Budget Terrain::budget(const Config& config) {
  Budget b;
  b.add(Consumer::octets, Octree::bytes_for(config.max_octets));
  b.add(Consumer::volumes, Arena::bytes_for<Volume>(config.max_volumes));
  b.add(Consumer::patches, Arena::bytes_for<Patch>(config.max_patches));
  b.add(Consumer::heights, Arena::bytes_for<std::int16_t>(max_height_samples(config)));
  b.add(Consumer::bounds, Arena::bytes_for<PatchBounds>(config.max_patches));
  b.add(Consumer::bounds, Arena::bytes_for<LatticeBox>(BoundsTree::node_count(config.max_patches)));
  b.add(Consumer::level_errors, Arena::bytes_for<std::uint16_t>(max_level_errors(config)));
  b.add(Consumer::thresholds, Arena::bytes_for<PatchLod>(config.max_patches));
  b.add(Consumer::index_tables,
        Arena::bytes_for<std::uint16_t>(index_count(static_cast<int>(config.max_level))));
  b.add(Consumer::draw_list, Arena::bytes_for<std::uint8_t>(config.max_patches));
  b.add(Consumer::draw_list, Arena::bytes_for<DrawItem>(config.max_draw_items));
  b.add(Consumer::draw_list, Arena::bytes_for<std::uint32_t>(config.max_patches));
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
  *this = Terrain();
  config_ = config;
  arena_ = Arena(memory.first(needed));
  if (const Status status = octree_.create(arena_, static_cast<int>(config.max_depth), config.max_octets);
      !status.ok())
    return status;
  volumes_ = arena_.allocate<Volume>(Consumer::volumes, config.max_volumes);
  patches_ = arena_.allocate<Patch>(Consumer::patches, config.max_patches);
  heights_ = arena_.allocate<std::int16_t>(Consumer::heights, max_height_samples(config));
  bounds_ = arena_.allocate<PatchBounds>(Consumer::bounds, config.max_patches);
  boxes_ = arena_.allocate<LatticeBox>(Consumer::bounds, BoundsTree::node_count(config.max_patches));
  level_errors_ = arena_.allocate<std::uint16_t>(Consumer::level_errors, max_level_errors(config));
  lods_ = arena_.allocate<PatchLod>(Consumer::thresholds, config.max_patches);
  index_table_ =
      arena_.allocate<std::uint16_t>(Consumer::index_tables, index_count(static_cast<int>(config.max_level)));
  levels_ = arena_.allocate<std::uint8_t>(Consumer::draw_list, config.max_patches);
  items_ = arena_.allocate<DrawItem>(Consumer::draw_list, config.max_draw_items);
  list_scratch_ = arena_.allocate<std::uint32_t>(Consumer::draw_list, config.max_patches);
  scratch_ = arena_.allocate<std::byte>(Consumer::scratch, scratch_bytes(config));
  arena_.freeze();
  tree_.create(boxes_);
  return build_index_tables(static_cast<int>(config.max_level), index_table_);
}

std::size_t Terrain::height_samples() const {
  return info_.level == 0
             ? 0
             : std::size_t{info_.height_blocks} * static_cast<std::size_t>(patch_vertices(info_.level));
}

std::size_t Terrain::level_error_count() const {
  return info_.level == 0 ? 0 : info_.patches * level_error_values(info_.level);
}

Status Terrain::load(std::span<const std::byte> file) {
  info_ = {};
  thresholds_level_ = 0;
  listed_ = 0;
  patch_scratch_ = nullptr;
  WorldInfo info;
  if (const Status status = read_world_info(file, info); !status.ok()) return status;
  const struct {
    std::uint32_t needed, limit;
    const char* name;
  } limits[] = {{static_cast<std::uint32_t>(info.depth), config_.max_depth, "max_depth"},
                {static_cast<std::uint32_t>(info.level), config_.max_level, "max_level"},
                {info.octets, config_.max_octets, "max_octets"},
                {info.volumes, config_.max_volumes, "max_volumes"},
                {info.patches, config_.max_patches, "max_patches"},
                {info.height_blocks, config_.max_height_blocks, "max_height_blocks"}};
  for (const auto& l : limits) {
    if (l.needed > l.limit)
      return {StatusCode::limit_reached, "the world is larger than a limit", l.name, l.needed};
  }
  Status status = load_surface(file, info);
  if (status.ok()) {
    info_ = info;
    status = check_shared_heights();
  }
  if (!status.ok()) {
    info_ = {};
    return status;
  }
  patch_scratch_ = make_patch_scratch(scratch_);
  return {};
}

Status Terrain::load_surface(std::span<const std::byte> file, const WorldInfo& info) {
  if (const Status status = read_octree(file, info, octree_); !status.ok()) return status;
  ExtractSurface extract;
  extract.octree = &octree_;
  extract.extent = info.extent;
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
  if (made.volumes != info.volumes)
    return {StatusCode::corrupt, "its voxels make another number of volumes than stated", "volumes"};
  if (made.patches != info.patches)
    return {StatusCode::corrupt, "its voxels make another number of patches than stated", "patches"};

  const WorldPatches heights = read_patches(file, info);
  std::uint32_t block = 0;
  for (PatchId p = 0; p < info.patches; ++p) {
    const bool has = (std::to_integer<unsigned>(heights.mask[p / 8]) >> (p % 8) & 1u) != 0;
    patches_[p].height_block = has ? block++ : kNoHeights;
  }
  std::copy(heights.samples.begin(), heights.samples.end(), heights_.begin());
  std::copy(heights.level_errors.begin(), heights.level_errors.end(), level_errors_.begin());
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

void Terrain::generate(PatchId patch, int level, std::span<GpuVertex> out) {
  GenerateVertices generate;
  generate.surface = surface();
  generate.heights = heights();
  generate.level = level;
  generate.scratch = patch_scratch_;
  generate.run(patch, out, level == info_.level ? &bounds_[patch] : nullptr);
}

Status Terrain::finish_bounds() {
  thresholds_level_ = 0;
  return tree_.build(surface(), bounds());
}

LatticeBox Terrain::box() const {
  return tree_.node(tree_.rows() - 1, 0);
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
  return {};
}

Status Terrain::select(const TerrainView& view, Selection& selection) {
  selection = {};
  listed_ = 0;
  if (view.camera == nullptr) return {StatusCode::invalid_argument, "no camera given", "camera"};
  if (view.height_px < 1 || view.height_px > 65'536) {
    return {StatusCode::invalid_argument, "not within 1..65536", "height_px"};
  }
  SelectLod lod;
  lod.settings = view.lod;
  lod.settings.max_level = std::min(lod.settings.max_level, info_.level);
  lod.settings.resident_level = std::min(lod.settings.resident_level, info_.level);
  lod.camera = view.camera;
  lod.surface = surface();
  lod.bounds = bounds();
  lod.tree = &tree_;
  const Frustum frustum = make_frustum(*view.camera);
  lod.frustum = view.frustum_culling ? &frustum : nullptr;
  lod.scale = make_error_scale(*view.camera, view.height_px, lod.settings.error_px);
  lod.lods = lods();
  lod.errors = level_errors();
  lod.levels = levels_.first(info_.patches);
  if (const Status status = lod.validate(); !status.ok()) return status;
  if (const Status status = set_thresholds(lod.settings, lod.scale); !status.ok()) return status;
  selection.lod = lod.run();

  BuildDrawList list;
  list.frustum_culling = view.frustum_culling;
  list.frustum = &frustum;
  list.eye = glm::vec3(eye_lattice(*view.camera));
  list.surface = surface();
  list.bounds = bounds();
  list.tree = &tree_;
  list.levels = levels();
  list.scratch = list_scratch_.first(info_.patches);
  list.items = items_;
  if (const Status status = list.validate(); !status.ok()) return status;
  const Status status = list.run(selection.list);
  listed_ = selection.list.drawn;
  return status;
}

}  // namespace karst
