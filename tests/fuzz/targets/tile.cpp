// SPDX-License-Identifier: MIT
// Tiles of a ground: as they are in the file, and what they hold before zstd; and where an image tile says
// that its children lie. Input: a number whose lowest
// bits are the size of the tile's nodes, then the bytes.
#include <zstd.h>

#include <algorithm>
#include <vector>

#include "terrain/base/checksum.h"
#include "terrain/imagery/image_tile.h"
#include "tests/fuzz/run/fuzz_target.h"
#include "tests/fuzz/run/seed_tile.h"
#include "tiles/decode_tile.h"

namespace karst {
namespace {

using namespace core;

void decode(NodeKey key, std::span<const std::byte> bytes) {
  static std::vector<std::byte> room(tiles::decode_tile_room());
  static Tile tile;
  const GroundInfo info = seed_ground();
  const TilePlace place{kSeedTileOffset, static_cast<std::uint32_t>(bytes.size()), crc32c(bytes)};
  const Status status = tiles::decode_tile(info, key, place, bytes, room, tile);
  if (!status.ok()) {
    must(status.code() == StatusCode::corrupt && status.value() == place.offset);
    return;
  }
  for (const std::int32_t height : tile.heights) must(height >= info.low && height <= info.high);
  for (const NodeMeasure& node : tile.nodes) {
    must(node.low <= node.high && node.low >= info.low && node.high <= info.high);
    for (int d = 1; d < kDemands; ++d) must(node.thresholds[d - 1] <= node.thresholds[d]);
    must(key.size > 0 || node.thresholds[kDemands - 1] == 0);
  }
  for (const TilePlace& child : tile.children) {
    if (!child.exists()) continue;
    must(key.size > 0 && child.offset + child.bytes <= place.offset && child.offset < place.offset);
  }
}

// Of an image tile, where its children lie: texels may be anything.
void check_image(NodeKey key, std::span<const std::byte> head) {
  static std::vector<std::byte> bytes(image_tile_bytes(ImageFormat::etc2_rgb));
  std::copy_n(head.begin(), std::min(head.size(), bytes.size()), bytes.begin());
  const GroundInfo info = seed_ground();
  const ImageryInfo imagery{ImageFormat::etc2_rgb, 1};
  const TilePlace place{kSeedImageOffset, static_cast<std::uint32_t>(bytes.size()), crc32c(bytes)};
  ImageChildren children;
  const Status status = check_image_tile(info, imagery, key, place, bytes, children);
  if (!status.ok()) {
    must(status.code() == StatusCode::corrupt && status.value() == place.offset);
    return;
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TilePlace& child = children.places[quadrant];
    if (child == TilePlace()) continue;
    must(key.size > 1 && node_exists(info, key.child(quadrant)));
    must(child.bytes == place.bytes && child.offset <= place.offset - child.bytes);
  }
}

}  // namespace

void fuzz_one(std::span<const std::byte> input) {
  if (input.empty()) return;
  const NodeKey key = seed_tile_key(std::to_integer<int>(input[0]) % 4);
  const std::span<const std::byte> bytes = input.subspan(1);
  decode(key, bytes);
  check_image(key, bytes);
  std::vector<std::byte> packed(ZSTD_compressBound(bytes.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 1));
  decode(key, packed);
}

}  // namespace karst
