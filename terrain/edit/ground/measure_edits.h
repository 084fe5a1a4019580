// SPDX-License-Identifier: MIT
// What is measured of nodes after samples changed: the same values, bit by bit, as of a ground that is baked
// so, up to size kReferenceSizes, where they follow from samples alone. Coarser sizes look at what finer ones
// measured of all their samples, which would have to be read: there a threshold is the file's, raised by what
// heights of the node and those around it are off from the file's, and not above what a ground of such
// heights may ask for. How far a region is from the ground is not in the file: where a node has in part a
// region that edits have not reached, a threshold is the file's, raised likewise; once they have, how far it
// is off by now is known (RegionGrowth::now), and thresholds are those of a ground that is baked with it. So
// they are never too small, the file's again where heights and regions are, and saving and loading does not
// raise them. Finer sizes can have such bounds for a while, too: the largest exact nodes look at 257 x 257
// samples each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "terrain/edit/ground/file_tiles.h"
#include "terrain/edit/ground/ground_overlay.h"
#include "terrain/ground/ground.h"
#include "terrain/ground/measure_ground.h"

namespace karst::core {

// Both ends included.
struct GridRect {
  std::int64_t low[2] = {0, 0};
  std::int64_t high[2] = {-1, -1};

  bool exists() const { return high[0] >= low[0] && high[1] >= low[1]; }
  void take(std::int64_t x, std::int64_t z);
};

// Nodes of a size that have one of the samples, in them or at their borders.
GridRect nodes_with(const GroundInfo& info, int size, const GridRect& samples);
// And those around, whose measures look at them.
GridRect nodes_around(const GroundInfo& info, int size, const GridRect& samples);
// Tiles of those.
GridRect tiles_around(const GroundInfo& info, int size, const GridRect& samples);
// Of a region, those at its border included.
GridRect samples_of(const GroundRegion& region);

// How much more than a region's file says the ground that stands for it may be off, by edits of either.
struct RegionGrowth {
  double error = 0;  // lattice steps
  // What it follows from (terrain/edit/regions/region_growth.h); way 0: no edit has reached it.
  double way = 0, stretch = 1;
  // An upper bound of what is as it is now.
  RegionMeasure now;

  bool exists() const { return way > 0; }
};

class MeasureEdits {
 public:
  static constexpr int kWindow = kNodeQuads << kReferenceSizes;  // quads of the largest exact node

  // Working memory.
  struct Scratch {
    std::int32_t heights[(kWindow + 1) * (kWindow + 1)];
    std::int32_t lows[kWindow * kMostReferenceRows];
    std::int32_t highs[kWindow * kMostReferenceRows];
    float zeros[kWindow];
    template <std::size_t kNodes>
    struct Row {
      std::int32_t low[kNodes], high[kNodes];
      float most[kBands][kNodes], border[4][kNodes], tall[kNodes];
      std::uint16_t thresholds[kNodes * kDemands];

      NodeRow first(std::size_t count);
    };
    Row<kTileNodes + 2> own[3];
    Row<2 * (kTileNodes + 2)> finer[4];
  };

  // All outlive this. overlay: with all of tiles_around() of all sizes. growths: of the ground's regions.
  MeasureEdits(const GroundInfo& info, GroundOverlay& overlay, FileTiles& file, Scratch& scratch,
               std::span<const RegionGrowth> growths, std::uint64_t stamp)
      : info_(info), overlay_(overlay), file_(file), scratch_(scratch), growths_(growths), stamp_(stamp) {
    for (std::size_t n = 0; n < growths.size(); ++n) {
      if (growths[n].exists()) regions_[n] = growths[n].now;
    }
  }

  // After heights changed, in tiles of all sizes, at these samples. exact: sizes up to it are measured,
  // within 0..kReferenceSizes; coarser ones have bounds until measure_again().
  void run(const GridRect& samples, int exact);
  // What run() left of a size, all finer sizes being exact.
  void measure_again(int size, const GridRect& samples);
  // After a region grew: thresholds of nodes that have it in part, and of those that look at them, are raised
  // at once, by more than measure_again() will find. Heights are the same.
  void grow(std::size_t region);

  // Nodes of which parts were measured.
  std::uint64_t measured() const { return measured_; }
  // A tile could not be read: nodes that look at it are split whatever is asked, until they are measured
  // again.
  const Status& trouble() const { return trouble_; }

 private:
  const Tile* current(NodeKey tile);
  NodeMeasure measure(NodeKey node);
  void find_heights(int size, const GridRect& nodes);
  void forget_parts(int size, const GridRect& nodes);
  NodeParts parts(NodeKey node);
  bool read_window(NodeKey node);
  bool make_parts(NodeKey node, NodeParts& out);
  void fill(const NodeRow& row, int size, std::int64_t first, std::int64_t z, bool with_parts);
  void find_thresholds(int size, const GridRect& nodes);
  void find_thresholds_in(int size, const GridRect& nodes);
  bool knows_regions(NodeKey node) const;
  HeightChange change_around(NodeKey node) const;
  std::int64_t span_around(NodeKey node);
  void raise(NodeKey node, const NodeMeasure& file, std::uint16_t (&out)[kDemands]);

  const GroundInfo& info_;
  GroundOverlay& overlay_;
  FileTiles& file_;
  Scratch& scratch_;
  std::span<const RegionGrowth> growths_;
  std::uint64_t stamp_;
  int exact_ = kReferenceSizes;
  bool grows_ = false;  // while grow() runs
  std::array<RegionMeasure, kMostRegions> regions_{};
  std::uint64_t measured_ = 0;
  Status trouble_;
};

}  // namespace karst::core
