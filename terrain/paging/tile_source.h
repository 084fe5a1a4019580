// SPDX-License-Identifier: MIT
// Where tiles come from: asked for, and polled for later; neither waits. Only wait() does, for frames that
// must be complete.
#pragma once

#include <cstdint>

#include "terrain/ground/tile.h"

namespace karst::core {

struct TileSource {
  enum class Answer : std::uint8_t {
    none,    // nothing is ready
    ready,   // a tile came
    failed,  // this one cannot be read; it may be asked for again
  };

  void* context = nullptr;  // borrowed, handed to both
  // False where too many are under way: nothing was asked for then.
  bool (*ask)(void* context, NodeKey tile, const TilePlace& place) = nullptr;
  // One of those that were asked for, in any order. tile: which one. out: its contents where it is ready.
  Answer (*poll)(void* context, NodeKey& tile, Tile& out) = nullptr;
  // Returns when poll() has one for sure, or nothing is under way. Null: poll() always has.
  void (*wait)(void* context) = nullptr;
};

}  // namespace karst::core
