// SPDX-License-Identifier: MIT
#include "terrain/edit/ground/file_tiles.h"

#include <algorithm>

#include "terrain/base/check.h"

namespace karst::core {

void FileTiles::reset(NodeKey root, const Tile& tile, const TileReading& reading) {
  std::fill(storage_.slots.begin(), storage_.slots.end(), Slot{});
  root_ = root;
  reading_ = reading;
  clock_ = reads_ = 0;
  storage_.tiles[0] = tile;
}

Status FileTiles::get(NodeKey key, const Tile*& tile) {
  KARST_ASSERT(key.size <= root_.size);
  if (key == root_) {
    tile = &storage_.tiles[0];
    return {};
  }
  ++clock_;
  std::size_t oldest = 1;
  for (std::size_t n = 1; n < storage_.slots.size(); ++n) {
    Slot& slot = storage_.slots[n];
    if (slot.last_used != 0 && slot.key == key) {
      slot.last_used = clock_;
      tile = &storage_.tiles[n];
      return {};
    }
    if (slot.last_used < storage_.slots[oldest].last_used) oldest = n;
  }
  const NodeKey above = key.parent();
  const Tile* parent = nullptr;
  if (const Status status = get(above, parent); !status.ok()) return status;
  const TilePlace place = parent->children[key.quadrant()];
  // Looking for the parent may have taken the oldest slot.
  for (std::size_t n = 1; n < storage_.slots.size(); ++n) {
    if (storage_.slots[n].last_used < storage_.slots[oldest].last_used) oldest = n;
  }
  Slot& slot = storage_.slots[oldest];
  slot = {};
  if (const Status status =
          reading_.read(reading_.context, key, place, storage_.workspace, storage_.tiles[oldest]);
      !status.ok()) {
    return status;
  }
  ++reads_;
  slot = {key, clock_};
  tile = &storage_.tiles[oldest];
  return {};
}

}  // namespace karst::core
