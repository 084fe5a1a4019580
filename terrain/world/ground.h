// SPDX-License-Identifier: MIT
// The ground of a world, for all eyes: its tiles in memory, its families on the GPU, and what each view
// draws.
//
//   each frame:
//     ground.begin_frame();
//     for each view: ground.select(view, request);
//     ground.ask();
//     for (NodeUpload node; ground.next_node(node);) copy it to the GPU
//     for each view: for (MorphRows rows; !(rows = ground.take_rows(view)).halves.empty();) copy rows to the
//     GPU for each view: draw ground.view(view).items()
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/storage_plan.h"
#include "terrain/nodes/family_pool.h"
#include "terrain/nodes/ground_view.h"
#include "terrain/nodes/make_node.h"
#include "terrain/paging/tile_cache.h"
#include "terrain/regions/belts.h"

namespace karst::core {

// One node for the GPU; valid until the next call of the Ground.
struct NodeUpload {
  std::uint32_t page = 0;  // among the families' pages
  std::uint32_t row = 0;   // of thresholds, among the families' rows
  int size = 0;            // of the page
  int quadrant = 0;
  NodeKey key;
  glm::ivec3 origin{0};                 // voxels of the page's size
  std::span<const GpuVertex> vertices;  // kNodePageVertices
};

class Ground {
 public:
  Ground() = default;
  Ground(const Ground&) = delete;
  Ground& operator=(const Ground&) = delete;

  // Views of a frame, and one for shadow maps, which take turns in it.
  static std::size_t view_count(const Config& config) {
    return config.ground_families == 0 ? 0 : std::size_t{config.max_views} + 1;
  }
  static void add_to(Budget& budget, const Config& config);
  // Takes what add_to() counts. config is valid. limit_reached ("memory").
  Status create(const Config& config, Arena& arena);

  // Begins anew with a ground, whose source is borrowed until the next attach(). Precondition: memory for a
  // tile and two families.
  void attach(const GroundInfo& info, const Tile& root, const TileSource& source);
  // There is none.
  void detach() { info_ = {}; }
  bool exists() const { return info_.exists(); }
  const GroundInfo& info() const { return info_; }
  // Constant until the next attach() or replace(); any thread may read it.
  const Tile& root_tile() const { return tiles_.root(); }
  // Forgets what is on the GPU.
  void forget();

  // After an edit, between frames. Heights of all samples.
  void set_heights(std::int32_t low, std::int32_t high) {
    info_.low = low;
    info_.high = high;
    ++edits_;
  }
  // A region was made, or was taken away again: of the ground as it is now.
  void set_regions(const GroundInfo& info) {
    info_.region_count = info.region_count;
    info_.region_list = info.region_list;
    ++edits_;
  }
  // After an edit of a region's heights.
  void set_belt(std::size_t region, std::int64_t low, std::int64_t high) {
    info_.region_list[region].belt_low = low;
    info_.region_list[region].belt_high = high;
  }
  // Another tile in the place of one, where that is in memory.
  void replace(NodeKey tile, const Tile& contents) { tiles_.replace(tile, contents); }
  // That the children of a node are made anew when they are drawn next. Returns how many were on the GPU.
  std::uint32_t remake_children(NodeKey node) { return pool_.retire(node); }
  // Of what edits have changed: another number after each.
  std::uint64_t edits() const { return edits_; }

  // Takes one tile that came, or all.
  void begin_frame();
  std::uint32_t poll(bool one = false) { return tiles_.poll(one); }
  bool wait() { return tiles_.wait(); }
  // Precondition: exists(), view < view_count().
  void select(std::size_t view, const GroundRequest& request);
  // What follows leaves so many families to what comes after it in the frame; 0: none.
  void leave_families(std::uint32_t count) { pool_.leave(count); }
  // The GPU has drawn all frames before this one.
  void rest() { pool_.rest(); }
  // Share of the families that the frame may have which what was selected so far has.
  double share_of_families() const { return static_cast<double>(pool_.seen()) / std::max(pool_.most(), 1u); }
  // Of views that are selected again and again while tiles come: families that only tries needed are free
  // again at the next one.
  void begin_tries() { pool_.begin_tries(); }
  void undo_tries() { pool_.undo_tries(); }
  // Of the source, for what the frame's views lack.
  // all: as TileCache::ask().
  void ask(bool all = true) { tiles_.ask(all); }
  // For looking ahead (terrain/imagery/look_ahead.h).
  TileCache& tiles() { return tiles_; }
  // The next node that the views selected since begin_frame() draw and the GPU lacks. False: none.
  bool next_node(NodeUpload& upload);

  // The belts of what a view drew last begin anew.
  void begin_belts(std::size_t view) { belt_counts_[view] = 0; }
  // The belt of a region, with its patches as the view draws them; none where it is not drawn. belts: info,
  // view and out are filled in here. Returns how many indices it takes. Precondition: its rim is that of the
  // world whose ground this is.
  std::size_t add_belt(std::size_t view, BuildBelts belts);
  // Triangles of all: vertices of the GPU's buffer. Valid until the view's next begin_belts().
  std::span<const std::uint32_t> belts(std::size_t view) const {
    return blocks_.belts[view].first(belt_counts_[view]);
  }

  const GroundView& view(std::size_t n) const { return views_[n]; }
  std::size_t shadow_view() const { return view_count_ - 1; }
  MorphRows take_rows(std::size_t view) { return views_[view].take_rows(); }
  std::span<PageTexel> texels() const { return pool_.texels(); }
  std::span<PageTexel> places() const { return pool_.places(); }
  // Of a view, and of all: on the GPU.
  std::uint32_t row_count() const { return pool_.count() + 1; }
  const TileCache::Counts& counts() const { return tiles_.counts(); }

 private:
  struct Blocks {
    TileCache::Storage tiles;
    FamilyPool::Storage pool;
    std::array<GroundView::Storage, kMostViews + 1> views;
    std::array<std::span<std::uint32_t>, kMostViews + 1> belts;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      tiles.each_block(config, visit);
      pool.each_block(config, visit);
      const std::size_t belt = BuildBelts::room(config.rim_edges, static_cast<int>(config.max_level));
      for (std::size_t n = 0; n < view_count(config); ++n) {
        views[n].each_block(config, visit);
        visit(Consumer::ground, belt, belts[n]);
      }
    }
  };

  GroundInfo info_;
  Blocks blocks_;
  TileCache tiles_;
  FamilyPool pool_;
  std::array<GroundView, kMostViews + 1> views_;
  std::size_t view_count_ = 0;
  std::array<std::size_t, kMostViews + 1> belt_counts_{};
  // Where next_node() goes on.
  struct Turn {
    std::size_t item = 0;
    bool selected = false;
  };
  std::array<Turn, kMostViews + 1> turns_{};
  std::array<GpuVertex, kNodePageVertices> vertices_{};
  std::uint64_t edits_ = 0;
};

}  // namespace karst::core
