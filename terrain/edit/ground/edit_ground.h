// SPDX-License-Identifier: MIT
// Edits of the ground's samples, live: heights at size 0, then what follows from them at all sizes up to the
// root, as if the ground had been baked so (measure_edits.h). Samples that tiles share, in their rims and at
// all sizes, have one height.
//
//   editor.create(limits, arena);
//   editor.attach(info, root, file, reading);          // as the file has it
//   ground.attach(info, root, editor.overlay().source());
//   log.begin();  editor.apply(edit, &log, change);  log.end();
//   editor.show(change, ground);                       // what is drawn of it from now on
//   log.undo([&](UndoPart part) { editor.exchange(part, change); ... });
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/budget.h"
#include "terrain/edit/edit.h"
#include "terrain/edit/ground/file_tiles.h"
#include "terrain/edit/ground/ground_overlay.h"
#include "terrain/edit/ground/measure_edits.h"
#include "terrain/edit/ground/save_tiles.h"
#include "terrain/edit/undo_log.h"
#include "terrain/world/ground.h"

namespace karst::core {

struct GroundChange {
  bool changed = false;
  GridRect samples;        // that have other heights now; none where a region grew
  std::int32_t least = 0;  // of their heights, before and after; kVertexStep
  std::int32_t greatest = 0;
  std::uint64_t stamp = 0;     // EditedTile::stamp of all tiles that changed
  std::uint32_t tiles = 0;     // of them
  std::uint64_t measured = 0;  // nodes whose deviations were measured
};

class EditGround {
 public:
  struct Limits {
    std::uint32_t tiles = 0;    // Config::edit_tiles; 0: nothing is edited
    std::size_t workspace = 0;  // bytes that reading a tile takes
  };
  // Cells of the log, ground_samples: 16 x 16 samples of size 0, row by row, 4 bytes each; key: z << 32 | x
  // of the block. Edits that follow each other in a step are one part where that is less.
  static constexpr int kBlock = 16;

  static void add_to(Budget& budget, const Limits& limits);
  // limit_reached ("memory").
  Status create(const Limits& limits, Arena& arena);

  // A ground as its file has it, nothing edited. file, reading: borrowed until the next attach().
  void attach(const GroundInfo& info, const Tile& root, const TileSource& file, const TileReading& reading);
  bool exists() const { return info_.exists() && overlay_.capacity() > 0; }

  // With the heights of all samples as they are.
  const GroundInfo& info() const { return info_; }
  GroundOverlay& overlay() { return overlay_; }
  const GroundOverlay& overlay() const { return overlay_; }

  // invalid_argument names the field of karst::Edit; unsupported ("ground"): of what grounds it cannot edit;
  // limit_reached: "edit_tiles" with how many it takes; and errors of reading. After an error no height has
  // changed, and nothing is in the log. log: null, or with a step open. beneath_regions: samples there change
  // too, where they are reserved, and the regions' growth is to follow; else that is refused. Precondition:
  // exists().
  Status apply(const Edit& edit, UndoLog* log, GroundChange& change, bool beneath_regions = false);
  // What apply() refuses whatever the ground is like.
  Status check(const Edit& edit) const;

  // A part that is taken back or done again, and what follows from it. Precondition: its cells are of this
  // ground.
  void exchange(UndoPart part, GroundChange& change);

  // Sizes that are measured with the edit; those up to kReferenceSizes when there is time, their thresholds
  // being no less than what will be measured until then.
  static constexpr int kExactAtOnce = 2;
  bool is_settled() const { return waiting_ == 0; }
  // A size of a place that waits. change: of its tiles no more than measures. Precondition: not is_settled().
  void settle_some(GroundChange& change);

  // A region that was made in the ground, and is reserved then. Errors of reserve_region(), and then there is
  // none. info: the ground's with it, the last one.
  Status add_region(const GroundInfo& info);
  // Takes the last one away again. Precondition: it was just added, and did not grow.
  void drop_region(const GroundInfo& info);
  // Before a region or what is beneath it is edited, for what its thresholds may have to allow for then.
  // limit_reached ("edit_tiles"), and errors of reading.
  Status reserve_region(std::size_t region);
  bool is_reserved(std::size_t region) const { return (reserved_ >> region & 1u) != 0; }
  // Bit n: samples that an edit may reach lie beneath region n, or at its border.
  std::uint32_t regions_reached(const Edit& edit) const;
  std::uint32_t regions_with(const GridRect& samples) const;
  // Of those reserved, whose heights_beneath() looks at some of the samples.
  std::uint32_t regions_looking_at(const GridRect& samples) const;
  // Since it was reserved.
  const RegionGrowth& growth(std::size_t region) const { return growths_[region]; }
  // No less than the error that thresholds of the file allow for (RegionMeasure); lattice steps, or infinite.
  // Precondition: it is reserved.
  double error_before(std::size_t region) const { return errors_[region]; }
  // Of a sample as it is, kVertexStep. Precondition: it exists.
  Status height(std::int64_t i, std::int64_t k, std::int32_t& out);
  // Of all beneath a region, and a little around it. Precondition: it is reserved.
  void heights_beneath(std::size_t region, std::int32_t& low, std::int32_t& high) const;
  // Thresholds allow for that much from now on, at once where it is more, and for no more once it is settled.
  // log: null, or with a step open, which then gets what growth was before, without what is `now`.
  // Precondition: it is reserved.
  void grow_region(std::size_t region, const RegionGrowth& growth, UndoLog* log, GroundChange& change);
  // What it was before grow_region(), which is to be called anew. Precondition: it is reserved.
  void restore_growth(std::size_t region, const RegionGrowth& growth);
  // A part of the kind region_growth is taken back or done again; what is `now` is to be found anew. Returns
  // the region.
  std::size_t exchange_growth(UndoPart part);

  // Hands a change to what is drawn. Returns how many nodes are made anew.
  std::uint32_t show(const GroundChange& change, Ground& ground) const;
  // The same of settle_some(): vertices are as they were.
  void show_measures(const GroundChange& change, Ground& ground) const;

  // What a file of the ground as it is holds. Precondition: is_settled(). reader: of the file that was
  // attached. write: takes kWritingRoom bytes at most. Until the next edit.
  SaveTiles saving(const WorldReader& reader, WriteTile write);
  static constexpr std::size_t kWritingRoom = sizeof(MeasureEdits::Scratch);

  // Of the last change: where measures could not be made for want of tiles, nodes are drawn finer.
  const Status& trouble() const { return trouble_; }

 private:
  struct Scratch {
    MeasureEdits::Scratch measure;
    std::int32_t fresh[(kTileQuads + 1) * (kTileQuads + 1)];
  };
  struct Blocks {
    GroundOverlay::Storage overlay;
    FileTiles::Storage file;
    std::span<Scratch> scratch;

    template <class Visit>
    void each_block(const Limits& limits, Visit&& visit) {
      const bool any = limits.tiles > 0;
      overlay.each_block(limits.tiles, visit);
      file.each_block(any, limits.workspace, visit);
      visit(Consumer::ground, any ? 1 : 0, scratch);
    }
  };

  GridRect footprint(const Edit& edit) const;
  int size_beneath(std::size_t region) const;
  std::int64_t owner(int axis, std::int64_t sample) const;
  Status current(NodeKey key, const Tile*& tile);
  double edited(const Edit& edit, const Tile& tile, std::int64_t i, std::int64_t k, int at_i, int at_k) const;
  Status make_fresh(const Edit& edit, NodeKey key, const Tile& tile, const GridRect& samples);
  GridRect vertices_of(NodeKey tile, const GridRect& samples) const;
  Status try_out(const Edit& edit, const GridRect& samples, GroundChange& change);
  Status reserve(const GridRect& samples, int least_size = 0);
  void count_tiles(GroundChange& change) const;
  Status check_regions(const GridRect& samples, bool beneath) const;
  std::span<const RegionGrowth> growths() const { return std::span(growths_).first(info_.regions().size()); }
  Status check_fit(const Edit& edit, const GroundChange& change);
  bool will_fit(NodeKey key, const Tile& tile, NodeKey node, const GridRect& samples) const;
  void choose_part(const GridRect& samples, UndoLog& log);
  void keep_blocks(EditedTile& edited, const GridRect& changed, UndoLog& log) const;
  void set_heights(const Edit& edit, const GridRect& samples, UndoLog* log);
  void exchange(UndoCell cell, GroundChange& change);
  void set_sizes(int size, const GridRect& samples);
  void follow(GroundChange& change);
  void wait(const GridRect& samples, int least_size = kExactAtOnce + 1);
  Status find_error(std::size_t region, double& error);

  GroundInfo info_;
  Blocks blocks_;
  GroundOverlay overlay_;
  FileTiles file_;
  std::array<RegionGrowth, kMostRegions> growths_{};
  std::array<double, kMostRegions> errors_{};  // error_before()
  std::uint32_t reserved_ = 0;                 // bit n: region n
  std::uint64_t stamp_ = 0;
  // The open part of the log.
  GridRect part_samples_;
  std::int64_t part_area_ = 0;  // sum over its edits
  // Samples around which measures wait, of all sizes from wait_size_ on; of that one, from wait_turn_ on.
  static constexpr std::size_t kWaiting = 8;
  GridRect waiting_at_[kWaiting];
  std::size_t waiting_ = 0;
  std::size_t wait_turn_ = 0;
  int wait_size_ = 0;
  Status trouble_;
};

}  // namespace karst::core
