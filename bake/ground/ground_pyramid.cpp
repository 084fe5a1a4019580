// SPDX-License-Identifier: MIT
#include "bake/ground/ground_pyramid.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>

#include "bake/base/parallel.h"
#include "terrain/base/check.h"
#include "terrain/base/checksum.h"
#include "terrain/ground/ground_box.h"
#include "terrain/ground/measure_ground.h"
#include "terrain/nodes/make_node.h"
#include "tiles/encode_tile.h"
#include "tiles/tile_bytes.h"

namespace karst::bake {
namespace {

// Rows that are in memory. A row of nodes is measured at most eight rows of its size after its last one, and
// a row of tiles when the last of its nodes is.
constexpr std::int64_t kHeightRows = 96;
// What coarser sizes take at once, and as many that come meanwhile.
constexpr std::int64_t kQuadRows = 2 * kMostReferenceRows;
constexpr std::int64_t kNodeRows = 32;
constexpr std::int64_t kPlaceRows = 4;                 // of tiles
constexpr std::int32_t kMostFromOrigin = 32'766 - 16;  // steps of a node's size, as MakeNode clamps

template <class T>
std::span<T> row_of(std::vector<T>& rows, std::int64_t row, std::int64_t kept, std::int64_t wide) {
  return std::span(rows).subspan(static_cast<std::size_t>(row % kept * wide), static_cast<std::size_t>(wide));
}

}  // namespace

struct GroundPyramid::Workers {
  struct Worker {
    tiles::TileEncoder encoder;
    Tile tile;
    std::vector<std::byte> bytes;
  };
  std::vector<std::unique_ptr<Worker>> all;
};

struct GroundPyramid::Level {
  std::int64_t nodes[2], quads[2], tiles[2];
  // Rows that are kept: all, where there are few.
  std::int64_t kept_heights = 0, kept_quads = 0, kept_nodes = 0;
  std::int64_t wide = 0;                                     // vertices in a row
  std::int64_t last_row = 0;                                 // of vertices; those beyond are like it
  std::int64_t row_count = 0;                                // that are there
  std::int64_t quad_rows = 0, node_rows = 0, tile_rows = 0;  // measured, measured, written
  std::vector<std::int32_t> heights;
  std::vector<std::int32_t> quad_low, quad_high;
  // Coarser sizes look at low, high, below and above alone; the rest is gathered when its row is measured.
  std::vector<float> quad_parts[7 + kBands];
  static constexpr std::int64_t kKeptParts = 2;
  std::vector<std::int32_t> node_low, node_high;
  std::vector<float> node_parts[5 + kBands];
  std::vector<std::uint16_t> thresholds;
  std::vector<TilePlace> places;

  Level(const GroundInfo& info, int size) {
    for (int axis = 0; axis < 2; ++axis) {
      quads[axis] = quads_along(info, axis, size);
      nodes[axis] = nodes_along(info, axis, size);
      tiles[axis] = (nodes[axis] + kTileNodes - 1) / kTileNodes;
    }
    wide = kNodeQuads * nodes[0] + 1;
    last_row = quads[1];
    kept_heights = std::min(kHeightRows, quads[1] + 1);
    kept_quads = std::min(kQuadRows, quads[1]);
    kept_nodes = std::min(kNodeRows, nodes[1]);
  }
  std::size_t bytes() const {
    const std::int64_t a_column =
        4 * kept_heights + (4 + 4 + 4 * kKeptParts) * kept_quads + 4 * (std::ssize(quad_parts) - kKeptParts);
    const std::int64_t a_node =
        (4 + 4 + 4 * std::ssize(node_parts) + 2 * std::int64_t{kDemands}) * kept_nodes;
    return static_cast<std::size_t>(a_column * wide + a_node * nodes[0]);
  }
  void take() {
    const auto room = [](std::int64_t rows, std::int64_t values) {
      return static_cast<std::size_t>(rows * values);
    };
    heights.resize(room(kept_heights, wide));
    quad_low.resize(room(kept_quads, wide - 1));
    quad_high.resize(quad_low.size());
    for (std::size_t n = 0; n < std::size(quad_parts); ++n)
      quad_parts[n].resize(room(static_cast<std::int64_t>(n) < kKeptParts ? kept_quads : 1, wide - 1));
    node_low.resize(room(kept_nodes, nodes[0]));
    node_high.resize(node_low.size());
    for (std::vector<float>& part : node_parts) part.resize(node_low.size());
    thresholds.resize(node_low.size() * kDemands);
    places.resize(room(kPlaceRows, tiles[0]));
  }

  bool has_row(std::int64_t k) const { return std::min(k, last_row) < row_count; }
  std::span<const std::int32_t> row(std::int64_t k) const {
    k = std::clamp<std::int64_t>(k, 0, last_row);
    KARST_ASSERT(k < row_count && k >= row_count - kept_heights);
    return std::span(heights).subspan(static_cast<std::size_t>(k % kept_heights * wide),
                                      static_cast<std::size_t>(wide));
  }
  QuadRow quad_row(std::int64_t k) {
    const std::int64_t count = wide - 1;
    const auto part = [&](std::size_t n) {
      return row_of(quad_parts[n], k, static_cast<std::int64_t>(n) < kKeptParts ? kept_quads : 1, count);
    };
    QuadRow out;
    out.low = row_of(quad_low, k, kept_quads, count);
    out.high = row_of(quad_high, k, kept_quads, count);
    out.below = part(0);
    out.above = part(1);
    out.tall = part(2);
    out.border = {part(3), part(4), part(5), part(6)};
    for (std::size_t band = 0; band < kBands; ++band) out.most[band] = part(7 + band);
    return out;
  }
  NodeRow node_row(std::int64_t z) {
    const auto part = [&](std::size_t n) { return row_of(node_parts[n], z, kept_nodes, nodes[0]); };
    NodeRow out;
    out.low = row_of(node_low, z, kept_nodes, nodes[0]);
    out.high = row_of(node_high, z, kept_nodes, nodes[0]);
    out.tall = part(0);
    out.border = {part(1), part(2), part(3), part(4)};
    for (std::size_t band = 0; band < kBands; ++band) out.most[band] = part(5 + band);
    out.thresholds = row_of(thresholds, z, kept_nodes, nodes[0] * kDemands);
    return out;
  }
  TilePlace& place(std::int64_t x, std::int64_t z) {
    return places[static_cast<std::size_t>(z % kPlaceRows * tiles[0] + x)];
  }
};

GroundPyramid::GroundPyramid(const GroundInfo& info, std::vector<RegionMeasure> regions, double quantum,
                             int threads, Write write)
    : regions_(std::move(regions)),
      quantum_(quantum),
      threads_(threads),
      write_(std::move(write)),
      workers_(std::make_unique<Workers>()) {
  ground_.info = info;
  for (int size = 0; size <= info.top_size(); ++size) {
    levels_.push_back(std::make_unique<Level>(info, size));
    levels_.back()->take();
  }
  for (int n = 0; n < threads; ++n) workers_->all.push_back(std::make_unique<Workers::Worker>());
}

GroundPyramid::~GroundPyramid() = default;

std::uint64_t GroundPyramid::bytes_for(const GroundInfo& info) {
  std::uint64_t bytes = 0;
  for (int size = 0; size <= info.top_size(); ++size) bytes += Level(info, size).bytes();
  return bytes;
}

std::uint64_t GroundPyramid::tiles_of_size(int size) const {
  const Level& level = *levels_[static_cast<std::size_t>(size)];
  return static_cast<std::uint64_t>(level.tiles[0] * level.tiles[1]);
}

GroundPyramid::Outcome GroundPyramid::push(std::span<const std::int32_t> samples) {
  GroundInfo& info = ground_.info;
  KARST_ASSERT(static_cast<std::int64_t>(samples.size()) == info.samples[0] && rows_ < info.samples[1]);
  const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
  info.low = first_ ? *low : std::min(info.low, *low);
  info.high = first_ ? *high : std::max(info.high, *high);
  first_ = false;
  const bool is_last = rows_ == info.samples[1] - 1;
  for (int size = 0; size <= info.top_size(); ++size) {
    const std::int64_t unit = std::int64_t{1} << size;
    if (rows_ % unit != 0 && !is_last) break;
    Level& level = *levels_[static_cast<std::size_t>(size)];
    const std::span<std::int32_t> row =
        row_of(level.heights, level.row_count, level.kept_heights, level.wide);
    for (std::int64_t i = 0; i < level.wide; ++i) {
      row[static_cast<std::size_t>(i)] =
          samples[static_cast<std::size_t>(sample_of(info.samples[0], size, i))];
    }
    ++level.row_count;
  }
  ++rows_;
  return go_on();
}

GroundPyramid::Outcome GroundPyramid::finish() {
  KARST_ASSERT(rows_ == ground_.info.samples[1]);
  const Level& top = *levels_.back();
  KARST_ASSERT(top.tile_rows == top.tiles[1]);
  ground_.root = levels_.back()->place(0, 0);
  return Outcome::ok;
}

// Sizes from fine to coarse: what one makes is all that the next one waits for. Coarser ones are written
// only after their children for that.
GroundPyramid::Outcome GroundPyramid::go_on() {
  for (bool moved = true; moved;) {
    moved = false;
    for (int size = 0; size < static_cast<int>(levels_.size()); ++size) {
      // Row by row, so that coarser sizes take rows of quads while they are there.
      if (measure_quads_of(size)) moved = true;
      while (measure_nodes_of(size)) moved = true;
      const Outcome outcome = write_tiles_of(size, moved);
      if (outcome != Outcome::ok) return outcome;
    }
  }
  return Outcome::ok;
}

bool GroundPyramid::measure_quads_of(int size) {
  Level& level = *levels_[static_cast<std::size_t>(size)];
  const std::int64_t k = level.quad_rows;
  if (k == level.quads[1]) return false;
  // The coarser sizes have to take the rows that this one would be put over.
  for (int coarser = size + 1; coarser < static_cast<int>(levels_.size()); ++coarser) {
    if (reference_size(coarser) > size) break;
    if (reference_size(coarser) < size) continue;
    const std::int64_t taken = levels_[static_cast<std::size_t>(coarser)]->quad_rows << (coarser - size);
    if (k - taken >= kQuadRows) return false;
  }
  const QuadRow out = level.quad_row(k);
  if (size == 0) {
    if (!level.has_row(k + 1)) return false;
    measure_quads(level.row(k), level.row(k + 1), out);
  } else {
    const int r = reference_size(size);
    Level& finer = *levels_[static_cast<std::size_t>(r)];
    const std::int64_t rows = std::int64_t{1} << (size - r);
    if (finer.quad_rows < std::min((k + 1) * rows, finer.quads[1])) return false;
    std::array<std::span<const std::int32_t>, kMostReferenceRows + 1> heights;
    std::array<QuadRow, kMostReferenceRows> quads;
    for (std::int64_t n = 0; n <= rows; ++n) heights[static_cast<std::size_t>(n)] = finer.row(k * rows + n);
    for (std::int64_t n = 0; n < rows; ++n) {
      quads[static_cast<std::size_t>(n)] = finer.quad_row(std::min(k * rows + n, finer.quads[1] - 1));
    }
    MeasureQuads measure;
    measure.info = &ground_.info;
    measure.size = size;
    measure.k = k;
    measure.heights = std::span(heights).first(static_cast<std::size_t>(rows) + 1);
    measure.finer = std::span(quads).first(static_cast<std::size_t>(rows));
    measure.out = out;
    // As much work a piece at all sizes.
    const auto piece = static_cast<std::size_t>(std::max<std::int64_t>(1, 4096 / (rows * rows)));
    const auto pieces = static_cast<int>(std::min<std::size_t>((out.low.size() + piece - 1) / piece, 1024));
    parallel_chunks(out.low.size(), piece, std::min(threads_, pieces),
                    [&](std::size_t first, std::size_t last, int) {
                      measure.run(static_cast<std::int64_t>(first), static_cast<std::int64_t>(last));
                    });
  }
  gather_nodes(ground_.info, size, k, out, level.node_row(k / kNodeQuads));
  ++level.quad_rows;
  return true;
}

bool GroundPyramid::measure_nodes_of(int size) {
  Level& level = *levels_[static_cast<std::size_t>(size)];
  const std::int64_t z = level.node_rows;
  if (z == level.nodes[1]) return false;
  const auto gathered = [&](std::int64_t row) {
    return level.quad_rows >= std::min((row + 1) * kNodeQuads, level.quads[1]);
  };
  if (!gathered(std::min(z + 1, level.nodes[1] - 1))) return false;
  const NodeRow own = level.node_row(z);
  const NodeRow north = level.node_row(z > 0 ? z - 1 : 0);
  const NodeRow south = level.node_row(z + 1);
  std::array<NodeRow, 4> finer;
  MeasureNodes measure;
  measure.info = &ground_.info;
  measure.size = size;
  measure.own = &own;
  measure.z = z;
  measure.regions = regions_;
  if (z > 0) measure.north = &north;
  if (z + 1 < level.nodes[1]) measure.south = &south;
  if (size > 0) {
    Level& below = *levels_[static_cast<std::size_t>(size) - 1];
    if (below.node_rows < std::min(2 * z + 3, below.nodes[1])) return false;
    for (int n = 0; n < 4; ++n) {
      const std::int64_t row = 2 * z - 1 + n;
      if (row < 0 || row >= below.nodes[1]) continue;
      KARST_ASSERT(row + kNodeRows > below.node_rows + 3);
      finer[static_cast<std::size_t>(n)] = below.node_row(row);
      measure.finer[static_cast<std::size_t>(n)] = &finer[static_cast<std::size_t>(n)];
    }
  }
  measure.run();
  ++level.node_rows;
  return true;
}

void GroundPyramid::fill_tile(NodeKey key, Tile& tile) const {
  tile = {};
  Level& level = *levels_[static_cast<std::size_t>(key.size)];
  for (int k = -kTileRim; k <= kTileQuads + kTileRim; ++k) {
    const std::span<const std::int32_t> row = level.row(std::int64_t{key.z} * kTileQuads + k);
    std::int32_t* out = tile.heights + (k + kTileRim) * kTileSide;
    for (int i = -kTileRim; i <= kTileQuads + kTileRim; ++i, ++out) {
      std::int64_t at = std::int64_t{key.x} * kTileQuads + i;
      // As sample_around().
      if (ground_.info.closes() && at < 0) at += level.quads[0];
      if (ground_.info.closes() && at > level.quads[0] && level.quads[0] % kNodeQuads == 0)
        at -= level.quads[0];
      at = std::clamp<std::int64_t>(at, 0, level.wide - 1);
      *out = row[static_cast<std::size_t>(at)];
    }
  }
  for (int n = 0; n < kTileMeasures; ++n) {
    const std::int64_t x = key.x * kTileNodes + n % kTileNodes;
    const std::int64_t z = key.z * kTileNodes + n / kTileNodes;
    if (x >= level.nodes[0] || z >= level.nodes[1]) continue;
    if (!node_exists(ground_.info, {key.size, static_cast<int>(x), static_cast<int>(z)})) continue;
    const NodeRow row = level.node_row(z);
    const auto at = static_cast<std::size_t>(x);
    tile.nodes[n].low = row.low[at];
    tile.nodes[n].high = row.high[at];
    for (std::size_t d = 0; d < kDemands; ++d)
      tile.nodes[n].thresholds[d] = row.thresholds[at * kDemands + d];
  }
  if (key.size == 0) return;
  Level& finer = *levels_[static_cast<std::size_t>(key.size) - 1];
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const NodeKey child = key.child(quadrant);
    if (child.x < finer.tiles[0] && child.z < finer.tiles[1])
      tile.children[quadrant] = finer.place(child.x, child.z);
  }
}

namespace {

// Whether the heights of all nodes can be stored around their origins.
bool fits(const GroundInfo& info, NodeKey key, const Tile& tile) {
  for (int n = 0; n < kTileMeasures; ++n) {
    const NodeKey node{key.size, key.x * kTileNodes + n % kTileNodes, key.z * kTileNodes + n / kTileNodes};
    if (!node_exists(info, node)) continue;
    if (info.basis.is_curved()) {
      const NodeMeasure& measure = tile.nodes[n];
      const double reach = std::ldexp(node_radius(info, measure.low, measure.high, key.size), -key.size);
      if (reach + kStepsPerHalfVoxel > kMostFromOrigin) return false;
      continue;
    }
    const int first_i = n % kTileNodes * kNodeQuads;
    const int first_k = n / kTileNodes * kNodeQuads;
    std::int32_t low = tile.height(first_i, first_k);
    std::int32_t high = low;
    for (int k = 0; k < kNodeSide; ++k) {
      for (int i = 0; i < kNodeSide; ++i) {
        low = std::min(low, tile.height(first_i + i, first_k + k));
        high = std::max(high, tile.height(first_i + i, first_k + k));
      }
    }
    const std::int64_t origin = std::int64_t{node_origin(info, tile.nodes[n], node).y} * kStepsPerVoxel;
    if (place_at_size(high, info.page_size(key.size)) * kVertexStep - origin > kMostFromOrigin ||
        place_at_size(low, info.page_size(key.size)) * kVertexStep - origin < -kMostFromOrigin)
      return false;
  }
  return true;
}

}  // namespace

GroundPyramid::Outcome GroundPyramid::write_tiles_of(int size, bool& wrote) {
  Level& level = *levels_[static_cast<std::size_t>(size)];
  for (;;) {
    const std::int64_t z = level.tile_rows;
    if (z == level.tiles[1]) return Outcome::ok;
    const std::int64_t last_node = std::min((z + 1) * kTileNodes, level.nodes[1]);
    if (level.node_rows < last_node || !level.has_row((z + 1) * kTileQuads + kTileRim)) return Outcome::ok;
    if (size > 0) {
      const Level& finer = *levels_[static_cast<std::size_t>(size) - 1];
      if (finer.tile_rows < std::min(2 * z + 2, finer.tiles[1])) return Outcome::ok;
    }
    std::vector<std::vector<std::byte>> bytes(static_cast<std::size_t>(level.tiles[0]));
    std::atomic<bool> too_steep = false;
    parallel_chunks(bytes.size(), 1, threads_, [&](std::size_t x, std::size_t, int worker) {
      Workers::Worker& own = *workers_->all[static_cast<std::size_t>(worker)];
      const NodeKey key{size, static_cast<int>(x), static_cast<int>(z)};
      if (!tiles::tile_exists(ground_.info, key)) return;
      fill_tile(key, own.tile);
      if (!fits(ground_.info, key, own.tile)) too_steep = true;
      own.encoder.run(key, ground_.info, own.tile, quantum_, own.bytes);
      bytes[x].assign(own.bytes.begin(), own.bytes.end());  // of its length: a row of tiles waits
      TilePlace& place = level.place(static_cast<std::int64_t>(x), z);
      place.bytes = static_cast<std::uint32_t>(bytes[x].size());
      place.crc = crc32c(bytes[x]);
    });
    if (too_steep) return Outcome::too_steep;
    for (std::size_t x = 0; x < bytes.size(); ++x) {
      if (bytes[x].empty()) {
        level.place(static_cast<std::int64_t>(x), z) = {};
        continue;
      }
      level.place(static_cast<std::int64_t>(x), z).offset = ground_.tile_bytes;
      if (!write_(bytes[x])) return Outcome::unwritten;
      ground_.tile_crc = crc32c(bytes[x], ground_.tile_crc);
      ground_.tile_bytes += bytes[x].size();
      ++tiles_;
    }
    ++level.tile_rows;
    wrote = true;
  }
}

}  // namespace karst::bake
