// SPDX-License-Identifier: MIT
// A tile of the ground from its bytes in a world file. Nothing is taken from the heap.
#pragma once

#include <cstddef>
#include <span>

#include "karst/status.h"
#include "terrain/ground/tile.h"

namespace karst::tiles {

using namespace core;

// The most bytes that an encoded tile may have.
inline constexpr std::size_t kMostTileBytes = 32'768;

// Working memory of decode_tile(): about 120 KiB.
std::size_t decode_tile_room();

// Replaces tile by what was encoded. bytes: untrusted, those of place. room: decode_tile_room() bytes or
// more, aligned to 8, whose contents do not matter. corrupt ("tile", value: place.offset) where they do not
// match place's checksum, or hold what no tile of this ground can be: heights or measures outside of info's
// range, a child that should not be or is missing, or one that does not end before this tile begins, so that
// no chain of children is endless. The tile is garbage then.
Status decode_tile(const GroundInfo& info, NodeKey key, const TilePlace& place,
                   std::span<const std::byte> bytes, std::span<std::byte> room, Tile& tile);

}  // namespace karst::tiles
