// SPDX-License-Identifier: MIT
#include "tiles/decode_tile.h"

#include <cstring>

#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>

#include "terrain/base/check.h"
#include "terrain/base/checksum.h"
#include "terrain/lod/morph.h"
#include "tiles/tile_bytes.h"

namespace karst::tiles {
namespace {

constexpr std::size_t kAlignment = 8;

std::size_t aligned(std::size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

template <class T>
T load(const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

// Each returns what is wrong; null: nothing.

const char* decode_heights(const GroundInfo& info, const std::byte* planes, double quantum,
                           std::int32_t* counts, Tile& tile) {
  // Of counts that stand for heights, with room for rounding: then no prediction overflows.
  const double most = kMostHeight / quantum + 1;
  for (int n = 0; n < kTileSamples; ++n) {
    const std::int32_t predicted = predict_sample(counts, n);
    const std::int64_t count =
        std::int64_t{predicted} + from_zigzag(take_planes(planes, kTileSamples, static_cast<std::size_t>(n)));
    if (!(std::abs(static_cast<double>(count)) <= most)) return "a height is out of range";
    const double height = height_of(count, quantum);
    if (!(height >= info.low && height <= info.high)) return "a height is outside of the ground's";
    counts[n] = static_cast<std::int32_t>(count);
    tile.heights[n] = static_cast<std::int32_t>(height);
  }
  return nullptr;
}

const char* decode_children(const GroundInfo& info, NodeKey key, std::uint64_t begin, const std::byte* bytes,
                            Tile& tile) {
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const std::byte* const at = bytes + static_cast<std::size_t>(quadrant) * sizeof(TilePlace);
    const auto child = load<TilePlace>(at);
    const bool exists = key.size > 0 && tile_exists(info, key.child(quadrant));
    if (exists != child.exists()) return exists ? "a child is missing" : "a child lies outside of the ground";
    if (!exists && !(child == TilePlace())) return "a place without a child is not empty";
    if (child.bytes > kMostTileBytes) return "a child is too long";
    if (child.offset > begin || begin - child.offset < child.bytes)
      return "a child does not end before its parent";
    tile.children[quadrant] = child;
  }
  return nullptr;
}

const char* decode_measures(const GroundInfo& info, NodeKey key, const std::byte* contents, double quantum,
                            const std::int32_t* counts, Tile& tile) {
  for (int node = 0; node < kTileMeasures; ++node) {
    NodeMeasure& measure = tile.nodes[node];
    measure = {};
    const bool exists = node_exists(info, node_of_tile(key, node));
    const Range own = range_of_node(counts, node);
    if (key.size == 0) {
      if (!exists) continue;
      measure.low = static_cast<std::int32_t>(height_of(own.low, quantum));
      measure.high = static_cast<std::int32_t>(height_of(own.high, quantum));
      continue;
    }
    const auto take = [&](std::size_t planes) {
      return take_planes(contents + planes, kTileMeasures, static_cast<std::size_t>(node));
    };
    const std::uint32_t below = take(kLows);
    const std::uint32_t above = take(kHighs);
    std::int32_t threshold = 0;
    for (int n = 0; n < kDemands; ++n) {
      const std::uint32_t rest =
          take_planes<2>(contents + thresholds_at(n), kTileMeasures, static_cast<std::size_t>(node));
      if (!exists && rest != 0) return "no node has measures";
      if (!exists) continue;
      const std::int32_t rise = predict_rise(tile.nodes, node, n) + from_zigzag(rest);
      threshold += rise;
      if (rise < 0 || threshold < kLeastThreshold || threshold > kNeverMorphs)
        return "a threshold is out of range";
      measure.thresholds[n] = static_cast<std::uint16_t>(threshold);
    }
    if (!exists) {
      if (below != 0 || above != 0) return "no node has measures";
      continue;
    }
    const double low = height_of(std::int64_t{own.low} - below, quantum);
    const double high = height_of(std::int64_t{own.high} + above, quantum);
    if (!(low >= info.low && high <= info.high)) return "a node's heights are outside of the ground's";
    measure.low = static_cast<std::int32_t>(low);
    measure.high = static_cast<std::int32_t>(high);
  }
  return nullptr;
}

}  // namespace

std::size_t decode_tile_room() {
  return aligned(ZSTD_estimateDCtxSize()) + aligned(kMostContents) +
         static_cast<std::size_t>(kTileSamples) * sizeof(std::int32_t);
}

Status decode_tile(const GroundInfo& info, NodeKey key, const TilePlace& place,
                   std::span<const std::byte> bytes, std::span<std::byte> room, Tile& tile) {
  KARST_ASSERT(room.size() >= decode_tile_room());
  KARST_ASSERT(reinterpret_cast<std::uintptr_t>(room.data()) % kAlignment == 0);
  const auto corrupt = [&](const char* what) {
    return Status(StatusCode::corrupt, what, "tile", place.offset);
  };
  if (bytes.size() != place.bytes || crc32c(bytes) != place.crc)
    return corrupt("a tile does not match its checksum");
  const std::size_t context_bytes = aligned(ZSTD_estimateDCtxSize());
  ZSTD_DCtx* const context = ZSTD_initStaticDCtx(room.data(), context_bytes);
  KARST_ASSERT(context != nullptr);
  std::byte* const contents = room.data() + context_bytes;
  auto* const counts = reinterpret_cast<std::int32_t*>(contents + aligned(kMostContents));
  const std::size_t length = contents_bytes(key.size);
  const std::size_t got = ZSTD_decompressDCtx(context, contents, length, bytes.data(), bytes.size());
  if (ZSTD_isError(got) != 0 || got != length) return corrupt("a tile cannot be decompressed");
  const auto quantum = load<double>(contents + kQuantum);
  if (!(quantum >= 1 && quantum <= kMostQuantum)) return corrupt("a quantum of heights is out of range");
  const char* what = decode_heights(info, contents + kHeights, quantum, counts, tile);
  if (what == nullptr) what = decode_children(info, key, place.offset, contents + kChildren, tile);
  if (what == nullptr) what = decode_measures(info, key, contents, quantum, counts, tile);
  return what == nullptr ? Status() : corrupt(what);
}

}  // namespace karst::tiles
