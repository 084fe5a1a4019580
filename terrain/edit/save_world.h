// SPDX-License-Identifier: MIT
// Writes a loaded world as it is now, whatever was edited: a .karst file of the same layout as karst-bake's,
// and of a world that nobody edited the same bytes. What edits change is written from memory, in the order of
// keys; everything else is copied from the world's own file, piece by piece. Sections of kinds that this
// version does not know are left out.
//
// No heap, and no second copy of anything: 4 bytes a patch are working memory.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/file/byte_source.h"
#include "terrain/ground/tile.h"
#include "terrain/surface/patch.h"
#include "terrain/world/world.h"

namespace karst::core {

// Tiles that are written behind those of the file.
struct AddedTiles {
  std::uint64_t kept = 0;   // bytes of the file's tiles, from their first on, that stay where they are
  std::uint64_t bytes = 0;  // behind them
  std::uint32_t crc = 0;    // of all of these
  TilePlace root;           // of the new ground; offsets count from where the file's tiles begin
  // The least and the greatest height of all samples, kVertexStep.
  std::int32_t low = 0;
  std::int32_t high = 0;
  const void* context = nullptr;  // borrowed
  // Writes what is behind.
  Status (*put)(const void* context, const ByteSink& sink) = nullptr;
};

struct SaveWorld {
  // Inputs, borrowed. The world's source can still be read; it holds all heights.
  const World* world = nullptr;
  const AddedTiles* tiles = nullptr;  // null: none

  std::span<PatchId> room;  // working memory: World::patch_count(), or more

  // invalid_argument ("world": it does not hold all its heights; "room"). Errors of reading the file, which
  // is checked against its checksums. limit_reached ("sink") where the sink does not take the bytes.
  Status run(const ByteSink& sink) const;
};

}  // namespace karst::core
