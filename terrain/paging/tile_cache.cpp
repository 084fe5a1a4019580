// SPDX-License-Identifier: MIT
#include "terrain/paging/tile_cache.h"

namespace karst::core {

void TileCache::reset(const TileSource& source, NodeKey root, const Tile& root_tile) {
  source_ = source;
  slots_.reset();
  slots_.pin(root);
  tiles_[0] = root_tile;
}

bool TileCache::wait() {
  if (counts().under_way == 0) return false;
  if (source_.wait != nullptr) source_.wait(source_.context);
  return true;
}

std::uint32_t TileCache::poll(bool one) {
  std::uint32_t came = 0;
  NodeKey key;
  while (counts().under_way > 0 && !(one && came > 0)) {
    const TileSource::Answer answer = source_.poll(source_.context, key, came_);
    if (answer == TileSource::Answer::none) break;
    const std::int32_t slot = slots_.take(key, answer);
    if (slot < 0) continue;
    tiles_[static_cast<std::size_t>(slot)] = came_;
    ++came;
  }
  return came;
}

}  // namespace karst::core
