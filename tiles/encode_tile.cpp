// SPDX-License-Identifier: MIT
#include "tiles/encode_tile.h"

#include <array>
#include <cstring>
#include <new>

#include <zstd.h>

#include "terrain/base/check.h"
#include "tiles/decode_tile.h"
#include "tiles/tile_bytes.h"

namespace karst::tiles {
namespace {

constexpr int kZstdLevel = 1;  // what is left after prediction has no repeats to look for

// The count that stands for a height, where there is one.
bool count_of(std::int32_t height, double quantum, std::int32_t& count) {
  count = static_cast<std::int32_t>(std::floor(height / quantum + 0.5));
  return height_of(count, quantum) == static_cast<double>(height);
}

}  // namespace

struct TileEncoder::Room {
  ZSTD_CCtx* context = nullptr;
  std::array<std::int32_t, kTileSamples> counts{};
  std::array<std::int32_t, kTileMeasures> lows{}, highs{};
  std::array<std::byte, kMostContents> contents{};

  // False where some height is no count of the quantum.
  bool count(const Tile& tile, double quantum) {
    for (std::size_t n = 0; n < counts.size(); ++n) {
      if (!count_of(tile.heights[n], quantum, counts[n])) return false;
    }
    for (std::size_t n = 0; n < lows.size(); ++n) {
      if (!count_of(tile.nodes[n].low, quantum, lows[n])) return false;
      if (!count_of(tile.nodes[n].high, quantum, highs[n])) return false;
    }
    return true;
  }

  void store_heights() {
    for (int n = 0; n < kTileSamples; ++n) {
      const auto at = static_cast<std::size_t>(n);
      const std::int32_t predicted = predict_sample(counts.data(), n);
      put_planes(contents.data() + kHeights, kTileSamples, at, zigzag(counts[at] - predicted));
    }
  }

  void store_measures(NodeKey key, const GroundInfo& info, const Tile& tile) {
    for (int node = 0; node < kTileMeasures; ++node) {
      const auto at = static_cast<std::size_t>(node);
      const bool exists = node_exists(info, node_of_tile(key, node));
      const NodeMeasure& measure = tile.nodes[node];
      const Range own = range_of_node(counts.data(), node);
      KARST_ASSERT(exists || measure == NodeMeasure());
      KARST_ASSERT(!exists || (lows[at] <= own.low && highs[at] >= own.high));
      const auto put = [&](std::size_t planes, std::uint32_t value) {
        put_planes(contents.data() + planes, kTileMeasures, at, value);
      };
      put(kLows, exists ? static_cast<std::uint32_t>(own.low - lows[at]) : 0);
      put(kHighs, exists ? static_cast<std::uint32_t>(highs[at] - own.high) : 0);
      for (int n = 0; n < kDemands; ++n) {
        const std::int32_t rest = rise_of(measure, n) - predict_rise(tile.nodes, node, n);
        put_planes<2>(contents.data() + thresholds_at(n), kTileMeasures, at, exists ? zigzag(rest) : 0);
      }
    }
  }
};

TileEncoder::TileEncoder() : room_(std::make_unique<Room>()) {
  room_->context = ZSTD_createCCtx();
  if (room_->context == nullptr) throw std::bad_alloc();
}

TileEncoder::~TileEncoder() {
  ZSTD_freeCCtx(room_->context);
}

void TileEncoder::run(NodeKey key, const GroundInfo& info, const Tile& tile, double quantum,
                      std::vector<std::byte>& out) {
  Room& room = *room_;
  if (!(quantum > 1 && quantum <= kMostQuantum) || !room.count(tile, quantum)) {
    quantum = 1;
    const bool counted = room.count(tile, quantum);
    KARST_ASSERT(counted);
  }
  std::memcpy(room.contents.data() + kQuantum, &quantum, sizeof quantum);
  std::memcpy(room.contents.data() + kChildren, tile.children, sizeof tile.children);
  room.store_heights();
  if (key.size > 0) room.store_measures(key, info, tile);
  const std::size_t length = contents_bytes(key.size);
  out.resize(kMostTileBytes);
  const std::size_t got =
      ZSTD_compressCCtx(room.context, out.data(), out.size(), room.contents.data(), length, kZstdLevel);
  // There is room for the worst, so that memory is all that can be missing.
  if (ZSTD_isError(got) != 0) throw std::bad_alloc();
  out.resize(got);
}

}  // namespace karst::tiles
