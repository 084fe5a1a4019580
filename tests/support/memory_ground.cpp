// SPDX-License-Identifier: MIT
#include "tests/support/memory_ground.h"

#include <algorithm>
#include <cmath>

#include "terrain/measure/level_error.h"

namespace karst::test {

using namespace core;

namespace {

constexpr double kG = 1.1547005383792517;
constexpr double kSlack = 1.002;

}  // namespace

MemoryGround::MemoryGround(std::int64_t wide, std::int64_t deep, double step_x, double step_z,
                           const Heights& heights, const Errors& errors) {
  info_.samples[0] = wide;
  info_.samples[1] = deep;
  info_.steps[0] = step_x;
  info_.steps[1] = step_z;
  info_.low = info_.high = heights(0, 0);
  for (std::int64_t k = 0; k < deep; ++k) {
    for (std::int64_t i = 0; i < wide; ++i) {
      info_.low = std::min(info_.low, heights(i, k));
      info_.high = std::max(info_.high, heights(i, k));
    }
  }
  for (int size = info_.top_size(); size >= 0; --size) {
    for (int z = 0; node_exists(info_, {size, 0, z * kTileNodes}); ++z) {
      for (int x = 0; node_exists(info_, {size, x * kTileNodes, 0}); ++x) make_tile({size, x, z}, heights);
    }
  }
  measure(errors);
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
      tile.heights[at] = heights(sample_of(info_.samples[0], key.size, std::int64_t{key.x} * kTileQuads + i),
                                 sample_of(info_.samples[1], key.size, std::int64_t{key.z} * kTileQuads + k));
    }
  }
  for (int quadrant = 0; quadrant < 4 && key.size > 0; ++quadrant) {
    const NodeKey child = key.child(quadrant);
    const bool exists = node_exists(info_, {child.size, child.x * kTileNodes, child.z * kTileNodes});
    if (exists) tile.children[quadrant] = {1, 1, 0};
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
  for (int size = 1; size <= info_.top_size(); ++size) {
    for (int z = 0; node_exists(info_, {size, 0, z}); ++z) {
      for (int x = 0; node_exists(info_, {size, x, z}); ++x) {
        NodeMeasure& own = *measure_of({size, x, z});
        const double quad = std::ldexp(1.0, size - 1);
        const double tall = 2.0 * (double(own.high) - own.low);
        const double reach =
            std::sqrt(quad * quad * (info_.steps[0] * info_.steps[0] + info_.steps[1] * info_.steps[1]) +
                      tall * tall) +
            8.0 * quad * 2;
        double error = errors({size, x, z});
        double chain = kG * reach / (1.0 - kMorphShare);
        for (int dz = -1; dz <= 2; ++dz) {
          for (int dx = -1; dx <= 2; ++dx) {
            const NodeKey q{size - 1, 2 * x + dx, 2 * z + dz};
            const NodeMeasure* const finer = measure_of(q);
            if (finer == nullptr) continue;
            error = std::max(error, kSlack * double{finer->error} / (1.0 - kMorphShare));
            const double pad = std::ldexp(8.0, q.size);
            const double wide = kNodeQuads * quad * info_.steps[0] + pad;
            const double deep = kNodeQuads * quad * info_.steps[1] + pad;
            const double high = 2.0 * (double(finer->high) - finer->low) + pad;
            const double rise = kG * std::sqrt(wide * wide + deep * deep + high * high);
            chain = std::max(
                chain, (double{finer->chain} + rise) * kSlack / (1.0 - kMorphShare) + std::ldexp(8.0, size));
          }
        }
        own.error = static_cast<float>(error * (1 + 1e-6));
        own.chain = static_cast<float>(chain * (1 + 1e-6));
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
