// SPDX-License-Identifier: MIT
#include "tests/support/memory_ground.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "terrain/ground/ground_box.h"
#include "terrain/ground/measure_ground.h"
#include "terrain/lod/morph.h"
#include "terrain/measure/level_error.h"

namespace karst::test {

using namespace core;

namespace {

constexpr double kG = 1.1547005383792517;
constexpr double kSlack = 1.002;

}  // namespace

namespace {

GroundInfo plane(std::int64_t wide, std::int64_t deep, double step_x, double step_z) {
  GroundInfo info;
  info.samples[0] = wide;
  info.samples[1] = deep;
  info.steps[0] = step_x;
  info.steps[1] = step_z;
  return info;
}

}  // namespace

MemoryGround::MemoryGround(std::int64_t wide, std::int64_t deep, double step_x, double step_z,
                           const Heights& heights, const Errors& errors,
                           const std::vector<MemoryRegion>& regions)
    : info_(plane(wide, deep, step_x, step_z)) {
  make_tiles(heights, regions);
  measure(errors);
}

MemoryGround::MemoryGround(std::int64_t wide, std::int64_t deep, double step_x, double step_z,
                           const Heights& heights, const std::vector<MemoryRegion>& regions)
    : info_(plane(wide, deep, step_x, step_z)) {
  make_tiles(heights, regions);
  measure(heights);
}

MemoryGround::MemoryGround(const GroundInfo& shape, const Heights& heights, const Errors& errors)
    : info_(shape) {
  make_tiles(heights, {});
  measure(errors);
}

MemoryGround::MemoryGround(const GroundInfo& shape, const Heights& heights) : info_(shape) {
  make_tiles(heights, {});
  measure(heights);
}

MemoryGround MemoryGround::to_dig(std::int64_t wide, std::int64_t deep, double steps,
                                  const Heights& heights) {
  GroundInfo info = plane(wide, deep, steps, steps);
  info.can_be_dug = true;
  if (!place_regions(info)) std::abort();
  return MemoryGround(info, heights);
}

void MemoryGround::for_each_node(int size, const std::function<void(NodeKey)>& take) const {
  for (int z = 0; z < nodes_along(info_, 1, size); ++z) {
    for (int x = 0; x < nodes_along(info_, 0, size); ++x) {
      if (node_exists(info_, {size, x, z})) take({size, x, z});
    }
  }
}

void MemoryGround::make_tiles(const Heights& heights, const std::vector<MemoryRegion>& regions) {
  for (const MemoryRegion& region : regions) {
    GroundRegion& to = info_.region_list[static_cast<std::size_t>(info_.region_count++)];
    to.nodes.low[0] = region.x;
    to.nodes.low[1] = region.z;
    to.extent = {region.extent_x, region.extent_y, region.extent_z};
    to.corner.y = region.y;
    regions_.push_back(region.measure);
  }
  if (!regions.empty() && !place_regions(info_)) std::abort();
  info_.low = info_.high = heights(0, 0);
  for (std::int64_t k = 0; k < info_.samples[1]; ++k) {
    for (std::int64_t i = 0; i < info_.samples[0]; ++i) {
      info_.low = std::min(info_.low, heights(i, k));
      info_.high = std::max(info_.high, heights(i, k));
    }
  }
  for (int size = info_.top_size(); size >= 0; --size) {
    for_each_node(size, [&](NodeKey node) {
      if (!tiles_.contains(key_of(tile_of(node)))) make_tile(tile_of(node), heights);
    });
  }
}

const Tile& MemoryGround::tile(NodeKey key) const {
  return tiles_.at(key_of(key));
}

void MemoryGround::make_tile(NodeKey key, const Heights& heights) {
  Tile& tile = tiles_[key_of(key)];
  tile = {};
  for (int k = -kTileRim; k <= kTileQuads + kTileRim; ++k) {
    for (int i = -kTileRim; i <= kTileQuads + kTileRim; ++i) {
      const auto at = static_cast<std::size_t>((k + kTileRim) * kTileSide + i + kTileRim);
      tile.heights[at] = heights(sample_around(info_, key.size, std::int64_t{key.x} * kTileQuads + i),
                                 sample_of(info_.samples[1], key.size, std::int64_t{key.z} * kTileQuads + k));
    }
  }
  for (int quadrant = 0; quadrant < 4 && key.size > 0; ++quadrant) {
    const NodeKey child = key.child(quadrant);
    for (int n = 0; n < kTileMeasures; ++n) {
      if (node_exists(info_, {child.size, child.x * kTileNodes + n % kTileNodes,
                              child.z * kTileNodes + n / kTileNodes}))
        tile.children[quadrant] = {1, 1, 0};
    }
  }
  for (int n = 0; n < kTileMeasures; ++n) {
    const NodeKey node{key.size, key.x * kTileNodes + n % kTileNodes, key.z * kTileNodes + n / kTileNodes};
    if (!node_exists(info_, node)) continue;
    const auto end = [&](int axis, int index) {
      return sample_of(info_.samples[axis], node.size, (std::int64_t{index} + 1) * kNodeQuads);
    };
    NodeMeasure& measure = tile.nodes[n];
    measure.low = INT32_MAX;
    measure.high = INT32_MIN;
    for (std::int64_t k = std::int64_t{node.z} * kNodeQuads << node.size; k <= end(1, node.z); ++k) {
      for (std::int64_t i = std::int64_t{node.x} * kNodeQuads << node.size; i <= end(0, node.x); ++i) {
        measure.low = std::min(measure.low, heights(i, k));
        measure.high = std::max(measure.high, heights(i, k));
      }
    }
  }
}

NodeMeasure* MemoryGround::measure_of(NodeKey node) {
  if (!node_exists(info_, node)) return nullptr;
  return &tiles_.at(key_of(tile_of(node))).nodes[node_in_tile(node)];
}

void MemoryGround::measure(const Errors& errors) {
  const bool curved = info_.basis.is_curved();
  for (int size = 1; size <= info_.top_size(); ++size) {
    for_each_node(size, [&](NodeKey node) {
      NodeMeasure& own = *measure_of(node);
      const double quad = std::ldexp(1.0, size - 1);
      const double unit = std::ldexp(1.0, info_.page_size(size));  // of the size's lattice
      const double tall = 2.0 * (double(own.high) - own.low);
      const double reach =
          std::sqrt(quad * quad * (info_.steps[0] * info_.steps[0] + info_.steps[1] * info_.steps[1]) +
                    tall * tall) +
          8.0 * unit;
      const double error = errors(node);
      double steps[kDemands];
      for (int n = 0; n < kDemands; ++n) steps[n] = demand(n) * error + kG * reach / (1.0 - kNodeMorphShare);
      for (std::size_t k = 0; k < regions_.size(); ++k) {
        if (in_region(info_.regions()[k], node) != InRegion::part) continue;
        const double change = kG * (regions_[k].reach + 2 * kNodeQuads * reach);
        for (int n = 0; n < kDemands; ++n)
          steps[n] = std::max(steps[n], kSlack * (demand(n) * regions_[k].error + change));
      }
      const auto keep = [&](NodeKey q) {
        const NodeMeasure* const finer = measure_of(q);
        if (finer == nullptr) return;
        const double pad = 4 * unit;
        const double wide = kNodeQuads * quad * info_.steps[0] + pad;
        const double deep = kNodeQuads * quad * info_.steps[1] + pad;
        const double high = 2.0 * (double(finer->high) - finer->low) + pad;
        const double rise = kG * (curved ? 2 * node_radius(info_, finer->low, finer->high, q.size)
                                         : std::sqrt(wide * wide + deep * deep + high * high));
        for (int n = 0; n < kDemands; ++n) {
          const double of_q = double{threshold_steps(finer->thresholds[n])} * unit / 2;
          steps[n] = std::max(steps[n], (of_q + rise) * kSlack / (1.0 - kNodeMorphShare) + 8 * unit);
        }
      };
      // The children and what is around them.
      for (int dz = -1; dz <= 2; ++dz) {
        for (int dx = -1; dx <= 2; ++dx) {
          NodeKey q{size - 1, 2 * node.x + std::clamp(dx, 0, 1), 2 * node.z + std::clamp(dz, 0, 1)};
          const int east = dx - std::clamp(dx, 0, 1), south = dz - std::clamp(dz, 0, 1);
          if (!neighbour_of(info_, q, east, south, q)) continue;
          keep(q);
        }
      }
      for (int n = 0; n < kDemands; ++n) {
        own.thresholds[n] = threshold_half(static_cast<float>(steps[n] / unit * (1 + 1e-6)));
      }
    });
  }
}

namespace {

// All of a size's quads and nodes, row by row.
struct AllQuads {
  explicit AllQuads(const GroundInfo& info, int size)
      : wide(static_cast<std::size_t>(nodes_along(info, 0, size)) * kNodeQuads),
        deep(static_cast<std::size_t>(nodes_along(info, 1, size)) * kNodeQuads),
        low(wide * deep),
        high(wide * deep),
        floats((7 + kBands) * wide * deep) {}
  QuadRow row(std::size_t k) {
    QuadRow out;
    out.low = std::span(low).subspan(k * wide, wide);
    out.high = std::span(high).subspan(k * wide, wide);
    std::size_t n = 0;
    const auto next = [&] { return std::span(floats).subspan((n++ * deep + k) * wide, wide); };
    out.below = next();
    out.above = next();
    for (auto& span : out.most) span = next();
    for (auto& span : out.border) span = next();
    out.tall = next();
    return out;
  }
  std::size_t wide, deep;
  std::vector<std::int32_t> low, high;
  std::vector<float> floats;
};

struct AllNodes {
  explicit AllNodes(const GroundInfo& info, int size)
      : wide(static_cast<std::size_t>(nodes_along(info, 0, size))),
        deep(static_cast<std::size_t>(nodes_along(info, 1, size))),
        low(wide * deep),
        high(wide * deep),
        floats((5 + kBands) * wide * deep),
        halves(kDemands * wide * deep),
        rows(deep) {
    for (std::size_t z = 0; z < deep; ++z) {
      NodeRow& out = rows[z];
      out.low = std::span(low).subspan(z * wide, wide);
      out.high = std::span(high).subspan(z * wide, wide);
      std::size_t n = 0;
      const auto next = [&] { return std::span(floats).subspan((n++ * deep + z) * wide, wide); };
      for (auto& span : out.most) span = next();
      for (auto& span : out.border) span = next();
      out.tall = next();
      out.thresholds = std::span(halves).subspan(kDemands * z * wide, kDemands * wide);
    }
  }
  std::size_t wide, deep;
  std::vector<std::int32_t> low, high;
  std::vector<float> floats;
  std::vector<std::uint16_t> halves;
  std::vector<NodeRow> rows;
};

}  // namespace

void MemoryGround::measure(const Heights& heights) {
  std::vector<AllQuads> quads;
  std::vector<AllNodes> nodes;
  const auto row_of = [&](int size, std::int64_t k, std::size_t count) {
    std::vector<std::int32_t> row(count);
    for (std::size_t i = 0; i < count; ++i) {
      row[i] = heights(sample_of(info_.samples[0], size, static_cast<std::int64_t>(i)),
                       sample_of(info_.samples[1], size, k));
    }
    return row;
  };
  for (int size = 0; size <= info_.top_size(); ++size) {
    AllQuads& own = quads.emplace_back(info_, size);
    AllNodes& of = nodes.emplace_back(info_, size);
    const std::int64_t rows = quads_along(info_, 1, size);
    for (std::int64_t k = 0; k < rows; ++k) {
      const QuadRow out = own.row(static_cast<std::size_t>(k));
      if (size == 0) {
        measure_quads(row_of(0, k, own.wide + 1), row_of(0, k + 1, own.wide + 1), out);
      } else {
        const int r = reference_size(size);
        AllQuads& finer = quads[static_cast<std::size_t>(r)];
        const std::int64_t rows_in = std::int64_t{1} << (size - r);
        std::vector<std::vector<std::int32_t>> h;
        std::vector<std::span<const std::int32_t>> heights_in;
        std::vector<QuadRow> quads_in;
        for (std::int64_t n = 0; n <= rows_in; ++n) h.push_back(row_of(r, k * rows_in + n, finer.wide + 1));
        for (const auto& row : h) heights_in.emplace_back(row);
        for (std::int64_t n = 0; n < rows_in; ++n) {
          quads_in.push_back(
              finer.row(static_cast<std::size_t>(std::min(k * rows_in + n, quads_along(info_, 1, r) - 1))));
        }
        MeasureQuads job;
        job.info = &info_;
        job.size = size;
        job.k = k;
        job.heights = heights_in;
        job.finer = quads_in;
        job.out = out;
        job.run();
      }
      gather_nodes(info_, size, k, out, of.rows[static_cast<std::size_t>(k / kNodeQuads)]);
    }
    for (std::size_t z = 0; z < of.deep; ++z) {
      MeasureNodes job;
      job.info = &info_;
      job.size = size;
      job.north = z > 0 ? &of.rows[z - 1] : nullptr;
      job.own = &of.rows[z];
      job.z = static_cast<std::int64_t>(z);
      job.regions = regions_;
      job.south = z + 1 < of.deep ? &of.rows[z + 1] : nullptr;
      for (std::size_t n = 0; n < 4 && size > 0; ++n) {
        AllNodes& finer = nodes[static_cast<std::size_t>(size) - 1];
        const std::size_t at = 2 * z + n;  // less 1
        job.finer[n] = at >= 1 && at - 1 < finer.deep ? &finer.rows[at - 1] : nullptr;
      }
      job.run();
      for (std::size_t x = 0; x < of.wide; ++x) {
        NodeMeasure* const to = measure_of({size, static_cast<int>(x), static_cast<int>(z)});
        if (to == nullptr) continue;
        to->low = of.rows[z].low[x];
        to->high = of.rows[z].high[x];
        for (std::size_t n = 0; n < kDemands; ++n)
          to->thresholds[n] = of.rows[z].thresholds[x * kDemands + n];
      }
    }
  }
}

TileSource MemoryGround::Source::source() {
  TileSource result;
  result.context = this;
  result.ask = [](void* context, NodeKey tile, const TilePlace&) {
    Source& own = *static_cast<Source*>(context);
    if (own.asked.size() >= own.most_under_way) return false;
    own.asked.push_back(tile);
    ++own.asks;
    return true;
  };
  result.poll = [](void* context, NodeKey& tile, Tile& out) {
    Source& own = *static_cast<Source*>(context);
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    if (own.asked.empty() || chance(own.random) >= own.comes) return TileSource::Answer::none;
    const std::size_t at = own.random() % own.asked.size();
    tile = own.asked[at];
    own.asked[at] = own.asked.back();
    own.asked.pop_back();
    if (chance(own.random) < own.fails) return TileSource::Answer::failed;
    out = own.ground->tile(tile);
    return TileSource::Answer::ready;
  };
  return result;
}

}  // namespace karst::test
