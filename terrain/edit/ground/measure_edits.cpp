// SPDX-License-Identifier: MIT
#include "terrain/edit/ground/measure_edits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "terrain/base/check.h"
#include "terrain/lod/morph.h"

namespace karst::core {
namespace {

constexpr double kKept = 1.0 - kNodeMorphShare;

std::int64_t last_node(const GroundInfo& info, int axis, int size) {
  return nodes_along(info, axis, size) - 1;
}

NodeKey key_of(int size, std::int64_t x, std::int64_t z) {
  return {size, static_cast<std::int32_t>(x), static_cast<std::int32_t>(z)};
}

// A node whose measures are not known: split whatever is asked.
NodeMeasure unknown() {
  NodeMeasure measure;
  std::fill(std::begin(measure.thresholds), std::end(measure.thresholds), std::uint16_t{kNeverMorphs});
  return measure;
}

}  // namespace

void GridRect::take(std::int64_t x, std::int64_t z) {
  const std::int64_t at[2] = {x, z};
  const bool first = !exists();
  for (int axis = 0; axis < 2; ++axis) {
    low[axis] = first ? at[axis] : std::min(low[axis], at[axis]);
    high[axis] = first ? at[axis] : std::max(high[axis], at[axis]);
  }
}

GridRect nodes_with(const GroundInfo& info, int size, const GridRect& samples) {
  GridRect nodes;
  for (int axis = 0; axis < 2; ++axis) {
    nodes.low[axis] = std::max<std::int64_t>(samples.low[axis] - 1, 0) / kNodeQuads >> size;
    nodes.high[axis] = std::min(samples.high[axis] / kNodeQuads >> size, last_node(info, axis, size));
  }
  return nodes;
}

GridRect nodes_around(const GroundInfo& info, int size, const GridRect& samples) {
  GridRect nodes = nodes_with(info, size, samples);
  for (int axis = 0; axis < 2; ++axis) {
    nodes.low[axis] = std::max<std::int64_t>(nodes.low[axis] - 1, 0);
    nodes.high[axis] = std::min(nodes.high[axis] + 1, last_node(info, axis, size));
  }
  return nodes;
}

GridRect tiles_around(const GroundInfo& info, int size, const GridRect& samples) {
  GridRect tiles = nodes_around(info, size, samples);
  for (int axis = 0; axis < 2; ++axis) {
    tiles.low[axis] /= kTileNodes;
    tiles.high[axis] /= kTileNodes;
  }
  return tiles;
}

GridRect samples_of(const GroundRegion& region) {
  GridRect samples;
  for (int axis = 0; axis < 2; ++axis) {
    samples.low[axis] = std::int64_t{region.nodes.low[axis]} * kNodeQuads;
    samples.high[axis] = std::int64_t{region.nodes.high[axis]} * kNodeQuads;
  }
  return samples;
}

template <std::size_t kNodes>
NodeRow MeasureEdits::Scratch::Row<kNodes>::first(std::size_t count) {
  NodeRow row;
  row.low = std::span(low).first(count);
  row.high = std::span(high).first(count);
  for (std::size_t n = 0; n < kBands; ++n) row.most[n] = std::span(most[n]).first(count);
  for (std::size_t edge = 0; edge < 4; ++edge) row.border[edge] = std::span(border[edge]).first(count);
  row.tall = std::span(tall).first(count);
  row.thresholds = std::span(thresholds).first(count * kDemands);
  return row;
}

const Tile* MeasureEdits::current(NodeKey tile) {
  if (const EditedTile* const edited = overlay_.find(tile); edited != nullptr) return &edited->tile;
  const Tile* found = nullptr;
  if (const Status status = file_.get(tile, found); !status.ok()) {
    trouble_ = status;
    return nullptr;
  }
  return found;
}

NodeMeasure MeasureEdits::measure(NodeKey node) {
  const Tile* const tile = current(tile_of(node));
  return tile == nullptr ? unknown() : tile->nodes[node_in_tile(node)];
}

void MeasureEdits::run(const GridRect& samples, int exact) {
  KARST_ASSERT(samples.exists() && 0 <= exact && exact <= kReferenceSizes);
  exact_ = exact;
  for (int size = 0; size <= info_.top_size(); ++size) {
    const GridRect nodes = nodes_with(info_, size, samples);
    find_heights(size, nodes);
    if (size == 0) continue;
    if (size <= kReferenceSizes) forget_parts(size, nodes);
    find_thresholds(size, nodes_around(info_, size, samples));
  }
}

void MeasureEdits::measure_again(int size, const GridRect& samples) {
  KARST_ASSERT(samples.exists() && size > 0);
  exact_ = kReferenceSizes;
  find_thresholds(size, nodes_around(info_, size, samples));
}

void MeasureEdits::grow(std::size_t region) {
  grows_ = true;
  const GridRect samples = samples_of(info_.regions()[region]);
  for (int size = 1; size <= info_.top_size(); ++size)
    find_thresholds(size, nodes_around(info_, size, samples));
  grows_ = false;
}

// Least and greatest heights, and how far heights are from the file's.
void MeasureEdits::find_heights(int size, const GridRect& nodes) {
  for (std::int64_t z = nodes.low[1]; z <= nodes.high[1]; ++z) {
    for (std::int64_t x = nodes.low[0]; x <= nodes.high[0]; ++x) {
      const NodeKey node = key_of(size, x, z);
      EditedTile& tile = *overlay_.find(tile_of(node));
      const int at = node_in_tile(node);
      NodeMeasure& own = tile.tile.nodes[at];
      const NodeMeasure before = own;
      HeightChange change;
      own.low = std::numeric_limits<std::int32_t>::max();
      own.high = std::numeric_limits<std::int32_t>::min();
      if (size == 0) {
        const Tile* file = nullptr;
        if (const Status status = file_.get(tile.key, file); !status.ok()) trouble_ = status;
        const int first_i = at % kTileNodes * kNodeQuads, first_k = at / kTileNodes * kNodeQuads;
        for (int k = first_k; k < first_k + kNodeSide; ++k) {
          for (int i = first_i; i < first_i + kNodeSide; ++i) {
            const std::int32_t height = tile.tile.height(i, k);
            own.low = std::min(own.low, height);
            own.high = std::max(own.high, height);
            // What cannot be compared may be anywhere.
            const std::int32_t off = file != nullptr ? height - file->height(i, k) : kMostHeight;
            change.low = std::min(change.low, off);
            change.high = std::max(change.high, off);
          }
        }
      } else {
        for (int quadrant = 0; quadrant < 4; ++quadrant) {
          const NodeKey child = node.child(quadrant);
          if (!node_exists(info_, child)) continue;
          const NodeMeasure finer = measure(child);
          own.low = std::min(own.low, finer.low);
          own.high = std::max(own.high, finer.high);
          const EditedTile* const edited = overlay_.find(tile_of(child));
          if (edited == nullptr) continue;
          const HeightChange& of_child = edited->changes[node_in_tile(child)];
          change.low = std::min(change.low, of_child.low);
          change.high = std::max(change.high, of_child.high);
        }
      }
      tile.changes[at] = change;
      if (!(own == before)) tile.stamp = stamp_;
    }
  }
}

void MeasureEdits::forget_parts(int size, const GridRect& nodes) {
  for (std::int64_t z = nodes.low[1]; z <= nodes.high[1]; ++z) {
    for (std::int64_t x = nodes.low[0]; x <= nodes.high[0]; ++x) {
      const NodeKey node = key_of(size, x, z);
      overlay_.find(tile_of(node))->forget(node_in_tile(node));
    }
  }
}

// Samples of a node and its borders; those beyond the last one are like it.
bool MeasureEdits::read_window(NodeKey node) {
  const int wide = kNodeQuads << node.size;
  const std::int64_t first[2] = {std::int64_t{node.x} * wide, std::int64_t{node.z} * wide};
  const int count = std::min(wide, kTileQuads);  // of a tile's quads
  for (int below = 0; below < wide; below += count) {
    for (int east = 0; east < wide; east += count) {
      const NodeKey key = key_of(0, (first[0] + east) / kTileQuads, (first[1] + below) / kTileQuads);
      const bool has_nodes = node_exists(info_, {0, key.x * kTileNodes, key.z * kTileNodes});
      const Tile* const tile = has_nodes ? current(key) : nullptr;
      if (has_nodes && tile == nullptr) return false;
      for (int k = 0; k <= count; ++k) {
        std::int32_t* const row = scratch_.heights + (below + k) * (wide + 1);
        const std::int64_t z = first[1] + below + k;
        if (tile != nullptr) {
          const int i = static_cast<int>((first[0] + east) % kTileQuads);
          const std::int32_t* const from =
              tile->heights + (z - std::int64_t{key.z} * kTileQuads + kTileRim) * kTileSide + kTileRim + i;
          std::copy(from, from + count + 1, row + east);
          continue;
        }
        // Beyond the ground: the last row and column that were read.
        const bool is_past_z = z > info_.samples[1] - 1 && k > 0;
        for (int i = 0; i <= count; ++i) {
          const bool is_past_x = first[0] + east + i > info_.samples[0] - 1 && i > 0;
          const std::int32_t* from = row + east + i;
          if (is_past_z)
            from -= wide + 1;
          else if (is_past_x)
            --from;
          else
            continue;
          row[east + i] = *from;
        }
      }
    }
  }
  return true;
}

bool MeasureEdits::make_parts(NodeKey node, NodeParts& out) {
  if (!read_window(node)) return false;
  const int n = 1 << node.size;
  const int wide = kNodeQuads * n;
  // The node as a ground of its own, which ends where the ground does.
  GroundInfo info = info_;
  info.basis.turn_quads = 0;
  info.region_count = 0;
  for (int axis = 0; axis < 2; ++axis) {
    const std::int64_t first = std::int64_t{axis == 0 ? node.x : node.z} * wide;
    info.samples[axis] = std::min<std::int64_t>(info_.samples[axis] - first, wide + 1);
  }
  std::fill(std::begin(scratch_.zeros), std::end(scratch_.zeros), 0.0f);
  const std::span<float> zeros(scratch_.zeros);
  std::array<std::span<const std::int32_t>, kMostReferenceRows + 1> heights;
  std::array<QuadRow, kMostReferenceRows> finer;
  std::array<std::int32_t, kNodeQuads> low, high;
  std::array<std::array<float, kNodeQuads>, 7 + kBands> values;
  QuadRow quads;
  quads.low = low;
  quads.high = high;
  quads.below = values[0];
  quads.above = values[1];
  quads.tall = values[2];
  quads.border = {values[3], values[4], values[5], values[6]};
  for (std::size_t band = 0; band < kBands; ++band) quads.most[band] = values[7 + band];
  std::int32_t node_low, node_high;
  NodeRow row;
  row.low = {&node_low, 1};
  row.high = {&node_high, 1};
  for (std::size_t band = 0; band < kBands; ++band) row.most[band] = {&out.most[band], 1};
  for (std::size_t edge = 0; edge < 4; ++edge) row.border[edge] = {&out.border[edge], 1};
  row.tall = {&out.tall, 1};
  for (std::int64_t k = 0; k < quads_along(info, 1, node.size); ++k) {
    for (int r = 0; r <= n; ++r) {
      const std::int32_t* const from = scratch_.heights + (k * n + r) * (wide + 1);
      heights[static_cast<std::size_t>(r)] = {from, static_cast<std::size_t>(wide) + 1};
      if (r == n) continue;
      const std::int32_t* const south = from + wide + 1;
      const auto count = static_cast<std::size_t>(wide);
      QuadRow& of = finer[static_cast<std::size_t>(r)];
      of.low = {scratch_.lows + r * wide, count};
      of.high = {scratch_.highs + r * wide, count};
      of.below = of.above = zeros.first(count);
      for (std::size_t i = 0; i < count; ++i) {
        of.low[i] = std::min(std::min(from[i], from[i + 1]), std::min(south[i], south[i + 1]));
        of.high[i] = std::max(std::max(from[i], from[i + 1]), std::max(south[i], south[i + 1]));
      }
    }
    MeasureQuads job;
    job.info = &info;
    job.size = node.size;
    job.k = k;
    job.heights = std::span(heights).first(static_cast<std::size_t>(n) + 1);
    job.finer = std::span(finer).first(static_cast<std::size_t>(n));
    job.out = quads;
    job.run();
    gather_nodes(info, node.size, k, quads, row);
  }
  ++measured_;
  return true;
}

NodeParts MeasureEdits::parts(NodeKey node) {
  EditedTile* const tile = overlay_.find(tile_of(node));
  const int at = node_in_tile(node);
  if (tile != nullptr && tile->knows(at)) return tile->parts[at];
  NodeParts made;
  if (!make_parts(node, made)) {
    made.most[0] = std::numeric_limits<float>::infinity();
    return made;
  }
  if (tile != nullptr) {
    tile->parts[at] = made;
    tile->know(at);
  }
  return made;
}

// Nodes first .. of row z.
void MeasureEdits::fill(const NodeRow& row, int size, std::int64_t first, std::int64_t z, bool with_parts) {
  for (std::size_t n = 0; n < row.low.size(); ++n) {
    const NodeKey node = key_of(size, first + static_cast<std::int64_t>(n), z);
    const NodeMeasure own = measure(node);
    row.low[n] = own.low;
    row.high[n] = own.high;
    std::copy(std::begin(own.thresholds), std::end(own.thresholds),
              row.thresholds.begin() + static_cast<std::ptrdiff_t>(n * kDemands));
    const NodeParts of = with_parts ? parts(node) : NodeParts{};
    for (std::size_t band = 0; band < kBands; ++band) row.most[band][n] = of.most[band];
    for (std::size_t edge = 0; edge < 4; ++edge) row.border[edge][n] = of.border[edge];
    row.tall[n] = of.tall;
  }
}

void MeasureEdits::find_thresholds(int size, const GridRect& nodes) {
  GridRect in;
  for (std::int64_t tz = nodes.low[1] / kTileNodes; tz <= nodes.high[1] / kTileNodes; ++tz) {
    for (std::int64_t tx = nodes.low[0] / kTileNodes; tx <= nodes.high[0] / kTileNodes; ++tx) {
      // Those that are as in the file lie between places that wait as one.
      if (overlay_.find(key_of(size, tx, tz)) == nullptr) continue;
      const std::int64_t tile[2] = {tx, tz};
      for (int axis = 0; axis < 2; ++axis) {
        in.low[axis] = std::max(nodes.low[axis], tile[axis] * kTileNodes);
        in.high[axis] = std::min(nodes.high[axis], (tile[axis] + 1) * kTileNodes - 1);
      }
      find_thresholds_in(size, in);
    }
  }
}

// nodes: of one tile.
void MeasureEdits::find_thresholds_in(int size, const GridRect& nodes) {
  const bool exact = size <= exact_ && !grows_;
  const std::int64_t first = std::max<std::int64_t>(nodes.low[0] - 1, 0);
  const std::int64_t last = std::min(nodes.high[0] + 1, last_node(info_, 0, size));
  const auto count = static_cast<std::size_t>(last - first + 1);
  const std::int64_t finer_last = std::min(2 * last + 1, last_node(info_, 0, size - 1));
  const auto finer_count = static_cast<std::size_t>(finer_last - 2 * first + 1);
  const std::int64_t south_end = last_node(info_, 1, size);
  // Rows go around.
  NodeRow rows[3];
  for (std::size_t n = 0; n < 3; ++n) rows[n] = scratch_.own[n].first(count);
  const auto row = [&](std::int64_t z) -> NodeRow& { return rows[z % 3]; };
  const std::int64_t begin = std::max<std::int64_t>(nodes.low[1] - 1, 0);
  for (std::int64_t z = begin; z <= nodes.low[1]; ++z) fill(row(z), size, first, z, exact);
  EditedTile& tile = *overlay_.find(tile_of(key_of(size, nodes.low[0], nodes.low[1])));
  for (std::int64_t z = nodes.low[1]; z <= nodes.high[1]; ++z) {
    if (z < south_end) fill(row(z + 1), size, first, z + 1, exact);
    MeasureNodes job;
    job.info = &info_;
    job.size = size;
    job.own = &row(z);
    job.north = z > 0 ? &row(z - 1) : nullptr;
    job.south = z < south_end ? &row(z + 1) : nullptr;
    job.first = first;
    job.z = z;
    job.regions = std::span(regions_).first(growths_.size());
    NodeRow finer[4];
    for (std::size_t n = 0; n < 4; ++n) {
      const std::int64_t finer_z = 2 * z - 1 + static_cast<std::int64_t>(n);
      if (finer_z < 0 || finer_z > last_node(info_, 1, size - 1)) continue;
      finer[n] = scratch_.finer[n].first(finer_count);
      fill(finer[n], size - 1, 2 * first, finer_z, false);
      job.finer[n] = &finer[n];
    }
    job.run();
    const Tile* file = nullptr;
    if (!grows_ && (!exact || info_.region_count > 0)) {
      if (const Status status = file_.get(tile.key, file); !status.ok()) trouble_ = status;
    }
    for (std::int64_t x = nodes.low[0]; x <= nodes.high[0]; ++x) {
      const NodeKey node = key_of(size, x, z);
      const int at = node_in_tile(node);
      std::uint16_t made[kDemands];
      std::copy_n(row(z).thresholds.begin() + (x - first) * kDemands, kDemands, made);
      if (grows_) {
        const NodeMeasure now = measure(node);
        for (std::size_t n = 0; n < kDemands; ++n) made[n] = std::max(made[n], now.thresholds[n]);
      } else if (!exact || !knows_regions(node)) {
        raise(node, file != nullptr ? file->nodes[at] : unknown(), made);
      }
      std::uint16_t(&own)[kDemands] = tile.tile.nodes[at].thresholds;
      if (std::equal(std::begin(made), std::end(made), std::begin(own))) continue;
      std::copy(std::begin(made), std::end(made), std::begin(own));
      tile.stamp = stamp_;
    }
  }
}

// Whether how far all regions are off that the node has in part is known.
bool MeasureEdits::knows_regions(NodeKey node) const {
  for (std::size_t n = 0; n < growths_.size(); ++n) {
    if (!growths_[n].exists() && in_region(info_.regions()[n], node) == InRegion::part) return false;
  }
  return true;
}

HeightChange MeasureEdits::change_around(NodeKey node) const {
  HeightChange change;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dx = -1; dx <= 1; ++dx) {
      const NodeKey at{node.size, node.x + dx, node.z + dz};
      if (!node_exists(info_, at)) continue;
      const EditedTile* const edited = overlay_.find(tile_of(at));
      if (edited == nullptr) continue;
      const HeightChange& own = edited->changes[node_in_tile(at)];
      change.low = std::min(change.low, own.low);
      change.high = std::max(change.high, own.high);
    }
  }
  return change;
}

// From the least to the greatest height of a node and of those around it.
std::int64_t MeasureEdits::span_around(NodeKey node) {
  NodeMeasure all = measure(node);
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dx = -1; dx <= 1; ++dx) {
      const NodeKey at{node.size, node.x + dx, node.z + dz};
      if (!node_exists(info_, at)) continue;
      const NodeMeasure own = measure(at);
      all.low = std::min(all.low, own.low);
      all.high = std::max(all.high, own.high);
    }
  }
  return std::int64_t{all.high} - all.low;
}

// Thresholds of what finer sizes and regions ask for, as of a level node, raised to those of the node's own
// error. Heights are off by low .. high from the file's, those of the full surface and, as means of vertices,
// of any state: their difference, the error, by high - low at most. Where the ground ends states lie between
// two planes along a slope, which are apart by four times that more at most. What a child spans grows by
// three times that: its own heights, and the deviations at home at both ends; and a node's box, which counts
// where a region is in part, by less. The same holds of a level ground, from which heights are off by what
// they span: but where the file alone knows of a region the lesser of both is taken, so that a file which is
// edited and saved again and again does not ask for more and more.
void MeasureEdits::raise(NodeKey node, const NodeMeasure& file, std::uint16_t (&out)[kDemands]) {
  const HeightChange change = change_around(node);
  const double unit = std::ldexp(1.0, info_.page_size(node.size));
  const auto raised = [&](std::uint16_t from, double off, double demanded) {
    if (from >= kNeverMorphs) return from;
    const double error = off * (has_end(info_, node) ? 4 : 1) / kKept;
    const double least = kSteepest * 3 * off / kKept;
    const double steps = double{threshold_steps(from)} * unit + demanded * error + least;
    return threshold_half(static_cast<float>(steps / unit * (1.0 + 0x1p-22)));
  };
  const double off = (static_cast<double>(change.high) - change.low) * kVertexStep;
  const bool is_bounded = change.exists() && knows_regions(node);
  const double span = is_bounded ? static_cast<double>(span_around(node)) * kVertexStep : 0;
  for (std::size_t n = 0; n < kDemands; ++n) {
    const double demanded = demand(static_cast<int>(n));
    std::uint16_t own = file.thresholds[n];
    if (change.exists()) own = raised(own, off, demanded);
    if (is_bounded) own = std::min(own, raised(out[n], span, demanded));
    out[n] = std::max(out[n], own);
  }
}

}  // namespace karst::core
