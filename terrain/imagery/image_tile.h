// SPDX-License-Identifier: MIT
// Imagery: colours of the ground as seen from above, as tiles of a quadtree that is aligned with the ground's
// own (terrain/ground/ground.h). Image tile (s, x, z) covers node (s, x, z), and has so many texels whatever
// its size; so a texel of size s is 2^s / 60 samples wide. A tile exists where some image has that
// resolution or a finer one; elsewhere the nearest coarser one is used.
//
// A tile has kImageInside texels a side, and kImageBorder of its neighbours' around them, so that it can be
// looked up with filters alone. Its second level has half as many of both: what the next greater size has
// there. So a lookup between two sizes needs one tile.
//
// Bytes of a tile, as a file and the GPU have them: four TilePlaces, those of its children by quadrant; then
// the first level's texels and the second one's. Colours are sRGB; alpha, where the format has it, is how
// much of the texel an image covers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/ground/tile.h"

namespace karst::core {

inline constexpr int kImageInside = 240;  // texels, whole blocks of ETC2 on both levels
inline constexpr int kImageBorder = 8;
inline constexpr int kImageSide = kImageInside + 2 * kImageBorder;  // 256
inline constexpr int kImageLevels = 2;
inline constexpr int kTexelsPerSample = kImageInside / kNodeQuads;  // at size 0

enum class ImageFormat : std::uint32_t {
  none,       // there is no imagery
  etc2_rgb,   // 8 bytes a block of 4 x 4 texels; images cover all of the ground
  etc2_rgba,  // 16 bytes a block
  rgba8       // 4 bytes a texel
};
inline constexpr std::uint32_t kImageFormats = 4;

struct ImageryInfo {
  ImageFormat format = ImageFormat::none;
  std::int32_t least_size = 0;  // 0..the ground's top_size(): no tile is of a smaller size

  bool exists() const { return format != ImageFormat::none; }
  friend bool operator==(const ImageryInfo&, const ImageryInfo&) = default;
};

// Of a level's texels, 0 or 1.
constexpr std::size_t image_level_bytes(ImageFormat format, int level) {
  const auto side = static_cast<std::size_t>(kImageSide >> level);
  switch (format) {
    case ImageFormat::none:
      return 0;
    case ImageFormat::etc2_rgb:
      return side * side / 2;
    case ImageFormat::etc2_rgba:
      return side * side;
    case ImageFormat::rgba8:
      return side * side * 4;
  }
  return 0;
}
inline constexpr std::size_t kImageHeadBytes = 4 * sizeof(TilePlace);
// Of a tile's texels, and of a tile.
constexpr std::size_t image_texel_bytes(ImageFormat format) {
  return image_level_bytes(format, 0) + image_level_bytes(format, 1);
}
constexpr std::size_t image_tile_bytes(ImageFormat format) {
  return kImageHeadBytes + image_texel_bytes(format);
}

// Of the tile that all others descend from: the ground's top_size(), or, of a cube, that of a node over all
// cells of its grid, since a cube has six roots. Tiles of such sizes are not looked up.
inline int image_top_size(const GroundInfo& ground) {
  int size = ground.top_size();
  for (int cells = 1; ground.is_cube() && cells < kCubeCells[0]; cells *= 2) ++size;
  return size;
}
// Whether a tile may cover some of the ground.
inline bool image_tile_exists(const GroundInfo& ground, NodeKey key) {
  const int above = key.size - ground.top_size();
  if (above <= 0) return node_exists(ground, key);
  return key.x >= 0 && key.z >= 0 && key.x << above < kCubeCells[0] && key.z << above < kCubeCells[1];
}
static_assert(kCubeCells[0] >= kCubeCells[1]);

// Where a tile's children lie.
struct ImageChildren {
  TilePlace places[4];
};

// Checks the bytes of a tile: untrusted, those of place. corrupt ("image tile", value: place.offset) where
// they do not match place's checksum or length, or a child lies outside of the ground, is of a size that
// there is none of, or does not end before this tile begins, so that no chain of children is endless.
Status check_image_tile(const GroundInfo& ground, const ImageryInfo& imagery, NodeKey key,
                        const TilePlace& place, std::span<const std::byte> bytes, ImageChildren& children);

}  // namespace karst::core
