// SPDX-License-Identifier: MIT
#include "terrain/imagery/image_tile.h"

#include <cstring>

#include "terrain/base/checksum.h"

namespace karst::core {

Status check_image_tile(const GroundInfo& ground, const ImageryInfo& imagery, NodeKey key,
                        const TilePlace& place, std::span<const std::byte> bytes, ImageChildren& children) {
  const auto corrupt = [&](const char* what) {
    return Status(StatusCode::corrupt, what, "image tile", place.offset);
  };
  const std::size_t length = image_tile_bytes(imagery.format);
  if (place.bytes != length || bytes.size() != length) return corrupt("is of another length than all are");
  if (crc32c(bytes) != place.crc) return corrupt("does not match its checksum");
  ImageChildren read;
  std::memcpy(static_cast<void*>(read.places), bytes.data(), sizeof read.places);
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TilePlace& child = read.places[quadrant];
    if (child == TilePlace()) continue;
    if (key.size <= imagery.least_size) return corrupt("has a child of a size that there is none of");
    if (!image_tile_exists(ground, key.child(quadrant))) return corrupt("a child lies outside of the ground");
    if (child.bytes != length) return corrupt("a child is of another length than all are");
    if (child.offset > place.offset || place.offset - child.offset < child.bytes)
      return corrupt("a child does not end before its parent");
  }
  children = read;
  return {};
}

}  // namespace karst::core
