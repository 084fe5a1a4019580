// SPDX-License-Identifier: MIT
#include "tiles/encode_tile.h"

#include <new>

#include <zstd.h>

#include "tiles/decode_tile.h"
#include "tiles/tile_contents.h"

namespace karst::tiles {
namespace {

constexpr int kZstdLevel = 1;  // what is left after prediction has no repeats to look for

}  // namespace

struct TileEncoder::Room {
  ZSTD_CCtx* context = nullptr;
  TileContents contents;
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
  const std::span<const std::byte> contents = room_->contents.make(key, info, tile, tile.children, quantum);
  out.resize(kMostTileBytes);
  const std::size_t got =
      ZSTD_compressCCtx(room_->context, out.data(), out.size(), contents.data(), contents.size(), kZstdLevel);
  // There is room for the worst, so that memory is all that can be missing.
  if (ZSTD_isError(got) != 0) throw std::bad_alloc();
  out.resize(got);
}

}  // namespace karst::tiles
