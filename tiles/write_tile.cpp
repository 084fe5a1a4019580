// SPDX-License-Identifier: MIT
#include "tiles/write_tile.h"

#include <cstdint>
#include <new>

#include "terrain/base/check.h"
#include "tiles/decode_tile.h"
#include "tiles/frame/zstd_frame.h"
#include "tiles/tile_contents.h"

namespace karst::tiles {
namespace {

constexpr std::size_t kPieces = 14;
static_assert(FrameWriter::most_bytes(kMostContents, kPieces) <= kMostTileBytes);
static_assert(std::size_t{kTileSamples} <= FrameWriter::kMostPiece);
static_assert(kMostContents - kThresholds <= FrameWriter::kMostPiece);

static_assert(sizeof(TileContents) + kMostTileBytes <= kWriteTileRoom);

}  // namespace

std::span<const std::byte> write_tile(NodeKey key, const GroundInfo& info, const Tile& tile,
                                      std::span<const TilePlace, 4> children, std::span<std::byte> room) {
  KARST_ASSERT(room.size() >= kWriteTileRoom);
  KARST_ASSERT(reinterpret_cast<std::uintptr_t>(room.data()) % alignof(TileContents) == 0);
  auto* const made = new (room.data()) TileContents;
  const std::span<std::byte> out = room.subspan(sizeof(TileContents), kMostTileBytes);
  const std::span<const std::byte> contents = made->make(key, info, tile, children, 1);
  FrameWriter frame(out, contents.size());
  std::size_t at = 0;
  const auto add = [&](std::size_t bytes) {
    frame.add(contents.subspan(at, bytes), at + bytes == contents.size());
    at += bytes;
  };
  add(kHeights);
  for (int plane = 0; plane < 4; ++plane) add(kTileSamples);
  if (key.size > 0) {
    for (int plane = 0; plane < 8; ++plane) add(kTileMeasures);  // lows and highs
    add(kMostContents - kThresholds);
  }
  KARST_ASSERT(at == contents.size());
  return out.first(frame.bytes());
}

}  // namespace karst::tiles
