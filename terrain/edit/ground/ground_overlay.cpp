// SPDX-License-Identifier: MIT
#include "terrain/edit/ground/ground_overlay.h"

#include <algorithm>

#include "terrain/base/check.h"
#include "terrain/ground/key_hash.h"

namespace karst::core {

void GroundOverlay::reset(const TileSource& file, const TileReading& reading) {
  file_ = file;
  file_reading_ = reading;
  count_ = 0;
  asked_count_ = 0;
  std::fill(storage_.chains.begin(), storage_.chains.end(), -1);
}

std::int32_t& GroundOverlay::chain_of(NodeKey key) const {
  return storage_.chains[key_hash(key) % storage_.chains.size()];
}

const EditedTile* GroundOverlay::find(NodeKey key) const {
  if (count_ == 0) return nullptr;
  std::int32_t at = chain_of(key);
  while (at >= 0) {
    const EditedTile& tile = storage_.tiles[static_cast<std::size_t>(at)];
    if (tile.key == key) return &tile;
    at = tile.next;
  }
  return nullptr;
}

EditedTile& GroundOverlay::add(NodeKey key, const Tile& file) {
  KARST_ASSERT(room() > 0 && find(key) == nullptr);
  EditedTile& tile = storage_.tiles[count_];
  tile.tile = file;
  std::fill(std::begin(tile.changes), std::end(tile.changes), HeightChange{});
  std::fill(std::begin(tile.known), std::end(tile.known), std::uint64_t{0});
  tile.key = key;
  tile.stamp = 0;
  std::int32_t& chain = chain_of(key);
  tile.next = chain;
  chain = static_cast<std::int32_t>(count_++);
  return tile;
}

bool GroundOverlay::ask(NodeKey tile, const TilePlace& place) {
  if (find(tile) == nullptr) return file_.ask(file_.context, tile, place);
  if (asked_count_ == asked_.size()) return false;
  asked_[asked_count_++] = tile;
  return true;
}

TileSource::Answer GroundOverlay::poll(NodeKey& tile, Tile& out) {
  if (asked_count_ > 0) {
    tile = asked_[0];
    std::copy(asked_.begin() + 1, asked_.begin() + static_cast<std::ptrdiff_t>(asked_count_), asked_.begin());
    --asked_count_;
    out = find(tile)->tile;
    return TileSource::Answer::ready;
  }
  const TileSource::Answer answer = file_.poll(file_.context, tile, out);
  if (answer == TileSource::Answer::none) return answer;
  // Edited since it was asked for.
  const EditedTile* const edited = find(tile);
  if (edited == nullptr) return answer;
  out = edited->tile;
  return TileSource::Answer::ready;
}

void GroundOverlay::wait() {
  if (asked_count_ == 0 && file_.wait != nullptr) file_.wait(file_.context);
}

TileSource GroundOverlay::source() {
  TileSource source;
  source.context = this;
  source.ask = [](void* self, NodeKey tile, const TilePlace& place) {
    return static_cast<GroundOverlay*>(self)->ask(tile, place);
  };
  source.poll = [](void* self, NodeKey& tile, Tile& out) {
    return static_cast<GroundOverlay*>(self)->poll(tile, out);
  };
  source.wait = [](void* self) { static_cast<GroundOverlay*>(self)->wait(); };
  return source;
}

TileReading GroundOverlay::reading() const {
  return {this, [](const void* self, NodeKey tile, const TilePlace& place, std::span<std::byte> workspace,
                   Tile& out) {
            const auto& own = *static_cast<const GroundOverlay*>(self);
            if (const EditedTile* const edited = own.find(tile); edited != nullptr) {
              out = edited->tile;
              return Status();
            }
            return own.file_reading_.read(own.file_reading_.context, tile, place, workspace, out);
          }};
}

}  // namespace karst::core
