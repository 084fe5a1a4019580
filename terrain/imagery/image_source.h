// SPDX-License-Identifier: MIT
// Where image tiles come from: asked for, and polled for later; neither waits. Only wait() does, for frames
// that must be complete.
#pragma once

#include <cstddef>
#include <span>

#include "terrain/imagery/image_tile.h"
#include "terrain/paging/tile_source.h"

namespace karst::core {

// A tile that came.
struct ImageArrival {
  NodeKey key;
  ImageChildren children;
  std::span<const std::byte> texels;  // image_texel_bytes(); valid until the source is polled again
};

struct ImageSource {
  void* context = nullptr;  // borrowed, handed to all
  // False where too many are under way: nothing was asked for then.
  bool (*ask)(void* context, NodeKey key, const TilePlace& place) = nullptr;
  // One of those that were asked for, in any order; of one that failed, the key alone.
  TileSource::Answer (*poll)(void* context, ImageArrival& out) = nullptr;
  // Returns when poll() has one for sure, or nothing is under way. Null: poll() always has.
  void (*wait)(void* context) = nullptr;
};

}  // namespace karst::core
