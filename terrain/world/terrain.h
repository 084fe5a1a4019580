// SPDX-License-Identifier: MIT
// A world in memory of stated size: everything the core needs to load a .karst file, make its vertices and
// choose what to draw. All memory is taken in create(), exactly budget() bytes of it; from then on nothing is
// allocated.
//
//   Config config = Terrain::config_for(info);          // or a board's limits
//   std::vector<std::byte> memory(Terrain::budget(config).cpu_bytes() + alignment);
//   Terrain terrain;
//   terrain.create(config, memory);  terrain.load(file_bytes);
//   for each patch: terrain.generate(patch, vertices);  terrain.finish_bounds();
//   each frame: terrain.select(view, result);  draw terrain.items()
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "terrain/base/arena.h"
#include "terrain/base/budget.h"
#include "terrain/base/config.h"
#include "terrain/base/status.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/patch/page_table.h"
#include "terrain/surface/extract_surface.h"
#include "terrain/view/draw_list.h"
#include "terrain/view/morph.h"
#include "terrain/view/select_lod.h"
#include "terrain/voxel/octree.h"
#include "terrain/world/world_file.h"

namespace karst {

struct TerrainView {
  const Camera* camera = nullptr;
  LodSettings lod;      // max_level and resident_level are cut to the world's level
  int height_px = 720;  // of the picture, 1..65536; what error_px is measured in
  bool frustum_culling = true;
};

class Terrain {
 public:
  // The least limits that hold a world with all of it drawn and resident at `resident_level` (1..info.level).
  // stream_indices is what a frame may take before it is drawn in several parts.
  static Config config_for(const WorldInfo& info, int resident_level);

  // Exact bytes of the CPU side; the renderer adds its GPU terms. kUnbounded terms where they do not fit
  // size_t.
  static Budget budget(const Config& config);

  // memory: borrowed for the terrain's life, aligned to Arena::kAlignment, at least
  // budget(config).cpu_bytes(). Uses exactly that many. invalid_argument, limit_reached ("memory", bytes
  // needed).
  Status create(const Config& config, std::span<std::byte> memory);

  // Reads a world; file need not outlive the call. Errors of world_file.h; limit_reached naming the Config
  // field; corrupt ("patches", "volumes", "heights") where the file contradicts the surface of its own
  // voxels. Heights of a vertex that patches share must agree. After a failure the terrain holds an empty
  // world and can load again.
  Status load(std::span<const std::byte> file);

  const Config& config() const { return config_; }
  const Arena& arena() const { return arena_; }
  const WorldInfo& info() const { return info_; }
  const Octree& octree() const { return octree_; }
  Surface surface() const { return {volumes_.first(info_.volumes), patches_.first(info_.patches)}; }
  Heights heights() const { return {info_.level, heights_.first(height_samples())}; }
  LevelErrors level_errors() const { return {info_.level, level_errors_.first(level_error_count())}; }
  std::span<const std::uint16_t> index_table() const { return index_table_; }
  std::uint32_t patch_count() const { return info_.patches; }

  // Vertices of one patch at the world's level (or a lower one) in slot order, patch_vertices(level) of them;
  // also sets the patch's bounds when level is the world's. Precondition: patch < patch_count(), 1 <= level
  // <= info().level.
  void generate(PatchId patch, int level, std::span<GpuVertex> out);

  // The box hierarchy, once every patch has been generated at the world's level.
  Status finish_bounds();
  std::span<const PatchBounds> bounds() const { return bounds_.first(info_.patches); }
  // Box of everything, lattice steps. Precondition: finish_bounds() was ok and there is a patch.
  LatticeBox box() const;

  struct Selection {
    SelectLod::Result lod;
    BuildDrawList::Result list;
  };
  // Chooses levels and lists what the camera sees. limit_reached ("max_draw_items") leaves a valid, shorter
  // list.
  Status select(const TerrainView& view, Selection& selection);
  // Morph thresholds of the last select(): they change only when its lod settings, its height_px, the
  // camera's field of view or the bounds do, and the version with them. 0 before the first select().
  std::uint32_t thresholds_version() const { return thresholds_version_; }
  const ErrorScale& error_scale() const { return scale_; }
  std::span<const PatchLod> lods() const { return lods_.first(info_.patches); }

  std::span<const DrawItem> items() const { return items_.first(listed_); }
  // Of patches in view and their neighbours, and of all without frustum_culling.
  std::span<const std::uint8_t> levels() const { return levels_.first(info_.patches); }

 private:
  std::size_t height_samples() const;
  std::size_t level_error_count() const;
  Status set_thresholds(const LodSettings& lod, const ErrorScale& scale);
  Status check_shared_heights() const;
  Status load_surface(std::span<const std::byte> file, const WorldInfo& info);

  Config config_;
  Arena arena_{{}};
  WorldInfo info_;
  Octree octree_;
  std::span<Volume> volumes_;
  std::span<Patch> patches_;
  std::span<std::int16_t> heights_;
  std::span<PatchBounds> bounds_;
  std::span<LatticeBox> boxes_;
  BoundsTree tree_;
  std::span<std::uint16_t> level_errors_;
  std::span<PatchLod> lods_;
  ErrorScale scale_;  // what lods_ are for, with the next two
  bool morphing_ = false;
  int thresholds_level_ = 0;  // 0: lods_ are out of date
  std::uint32_t thresholds_version_ = 0;
  std::span<std::uint16_t> index_table_;
  std::span<std::uint8_t> levels_;
  std::span<DrawItem> items_;
  std::span<std::uint32_t> list_scratch_;
  std::span<std::byte> scratch_;  // working memory of loading and of generating, by turns
  PatchScratch* patch_scratch_ = nullptr;
  std::size_t listed_ = 0;
};

}  // namespace karst
