// SPDX-License-Identifier: MIT
// A tile of the ground to bytes of a world file, in memory that is given: for edited worlds. decode_tile()
// makes the same tile of them again. What it writes is longer than TileEncoder's by 1 - 30 %.
#pragma once

#include <cstddef>
#include <span>

#include "terrain/ground/tile.h"

namespace karst::tiles {

using namespace core;

// Working memory of write_tile(), bytes.
inline constexpr std::size_t kWriteTileRoom = 84 * 1024;

// tile: as decode_tile() takes it, but for its children, which lie at `children`. room: kWriteTileRoom
// bytes or more, aligned to 8, whose contents do not matter. Returns a part of room.
std::span<const std::byte> write_tile(NodeKey key, const GroundInfo& info, const Tile& tile,
                                      std::span<const TilePlace, 4> children, std::span<std::byte> room);

}  // namespace karst::tiles
