// SPDX-License-Identifier: MIT
// Tiles of an edited ground on their way to a world file. The file's tiles stay where they are; behind them
// come those that edits have changed and all above them, which tell where they lie, children first. At the
// end it says where they begin (docs/formats.md): when the world is edited again, all behind that place is
// written anew, so that no tile of an earlier edit is there twice. What edits replace of the first tiles
// stays, unused: saved as often as one likes, the tiles take what they took at first and what one save adds.
//
//   SaveTiles tiles = ground.saving(reader, tiles::write_tile);
//   tiles.plan();
//   SaveWorld{&world, tiles.added(), room}.run(sink);
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/edit/ground/file_tiles.h"
#include "terrain/edit/ground/ground_overlay.h"
#include "terrain/edit/save_world.h"
#include "terrain/file/world_reader.h"

namespace karst::core {

// A tile with other children as bytes, which are a part of room.
using WriteTile = std::span<const std::byte> (*)(NodeKey key, const GroundInfo& info, const Tile& tile,
                                                 std::span<const TilePlace, 4> children,
                                                 std::span<std::byte> room);

class SaveTiles {
 public:
  struct Inputs {
    const GroundInfo& info;  // with the heights of all samples as they are
    const GroundOverlay& overlay;
    FileTiles& file;
    const WorldReader& reader;  // of the world's file
    WriteTile write;
    std::span<std::byte> room;  // of write
  };
  // All is borrowed.
  explicit SaveTiles(const Inputs& inputs) : in_(inputs) {}

  // Errors of reading the file.
  Status plan();
  // What plan() found; null: the file's tiles are those of the ground.
  const AddedTiles* added() const { return added_.bytes > 0 ? &added_ : nullptr; }
  std::uint32_t tiles() const { return tiles_; }  // that are written

 private:
  // Tiles in the order in which they are written.
  struct Pass {
    const ByteSink* sink = nullptr;  // null: they are counted
    std::uint64_t end = 0;
    std::uint32_t crc = 0;
    std::uint32_t tiles = 0;
    bool differs = false;  // some tile from the file's
  };
  Status find_kept();
  Status put(Pass& pass, std::span<const std::byte> bytes) const;
  Status run(Pass& pass, TilePlace& root) const;
  Status visit(NodeKey key, TilePlace& place, Pass& pass) const;
  Status visit_children(NodeKey key, std::span<TilePlace, 4> children, Pass& pass, bool& moved) const;

  Inputs in_;
  AddedTiles added_;
  std::uint32_t tiles_ = 0;
};

}  // namespace karst::core
