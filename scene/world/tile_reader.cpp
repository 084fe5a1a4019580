// SPDX-License-Identifier: MIT
#include "scene/world/tile_reader.h"

#include <algorithm>
#include <csignal>
#include <new>

#include "terrain/base/check.h"
#include "tiles/decode_tile.h"

namespace karst::core {
namespace {

constexpr std::size_t whole_lines(std::size_t bytes) {
  return (bytes + 63) / 64 * 64;
}

}  // namespace

std::size_t TileReader::workspace_bytes() {
  return whole_lines(tiles::kMostTileBytes) + tiles::decode_tile_room();
}

std::size_t TileReader::bytes() {
  return whole_lines(kMostReady * sizeof(Tile)) + workspace_bytes();
}

Status TileReader::read(const WorldReader& reader, NodeKey tile, const TilePlace& place,
                        std::span<std::byte> workspace, Tile& out) {
  KARST_ASSERT(workspace.size() >= workspace_bytes());
  if (place.bytes > tiles::kMostTileBytes)
    return {StatusCode::corrupt, "is longer than tiles are", "tile", place.offset};
  const std::span<std::byte> packed = workspace.first(place.bytes);
  if (const Status status = reader.read_tile(place, packed); !status.ok()) return status;
  return tiles::decode_tile(reader.ground(), tile, place, packed,
                            workspace.subspan(whole_lines(tiles::kMostTileBytes)), out);
}

void TileReader::start(const WorldReader& reader, std::span<std::byte> memory) {
  KARST_ASSERT(memory.size() >= bytes() && reader_ == nullptr);
  reader_ = &reader;
  auto* const first = new (memory.data()) Tile[kMostReady];
  tiles_ = {first, kMostReady};
  workspace_ = memory.subspan(whole_lines(kMostReady * sizeof(Tile)));
  stopping_ = reading_ = false;
  asked_count_ = ready_first_ = ready_count_ = 0;
  // Signals are the host's threads'.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  has_thread_ = pthread_create(
                    &thread_, nullptr,
                    [](void* self) -> void* {
                      static_cast<TileReader*>(self)->work();
                      return nullptr;
                    },
                    this) == 0;
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void TileReader::stop() {
  if (has_thread_) {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    pthread_join(thread_, nullptr);
    has_thread_ = false;
  }
  reader_ = nullptr;
}

void TileReader::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return stopping_ || (asked_count_ > 0 && ready_count_ < kMostReady); });
    if (stopping_) return;
    const Asked next = asked_[0];
    std::move(asked_.begin() + 1, asked_.begin() + static_cast<std::ptrdiff_t>(asked_count_), asked_.begin());
    --asked_count_;
    reading_ = true;
    const std::size_t at = (ready_first_ + ready_count_) % kMostReady;
    lock.unlock();
    const Status status = read(*reader_, next.tile, next.place, workspace_, tiles_[at]);
    lock.lock();
    ready_[at] = {next.tile, !status.ok()};
    if (!status.ok()) trouble_ = status;
    ++ready_count_;
    reading_ = false;
    changed_.notify_all();
  }
}

bool TileReader::ask(NodeKey tile, const TilePlace& place) {
  {
    const std::lock_guard lock(mutex_);
    if (asked_count_ == kMostAsked) return false;
    asked_[asked_count_++] = {tile, place};
  }
  changed_.notify_all();
  return true;
}

TileSource::Answer TileReader::poll(NodeKey& tile, Tile& out) {
  std::unique_lock lock(mutex_);
  if (!has_thread_ && asked_count_ > 0) {
    const Asked next = asked_[0];
    std::move(asked_.begin() + 1, asked_.begin() + static_cast<std::ptrdiff_t>(asked_count_), asked_.begin());
    --asked_count_;
    tile = next.tile;
    const Status status = read(*reader_, next.tile, next.place, workspace_, out);
    if (!status.ok()) trouble_ = status;
    return status.ok() ? TileSource::Answer::ready : TileSource::Answer::failed;
  }
  if (ready_count_ == 0) return TileSource::Answer::none;
  // The thread writes to none of those that are ready.
  const std::size_t at = ready_first_;
  lock.unlock();
  tile = ready_[at].tile;
  const bool failed = ready_[at].failed;
  if (!failed) out = tiles_[at];
  lock.lock();
  ready_first_ = (ready_first_ + 1) % kMostReady;
  --ready_count_;
  lock.unlock();
  changed_.notify_all();
  return failed ? TileSource::Answer::failed : TileSource::Answer::ready;
}

Status TileReader::trouble() {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

void TileReader::wait() {
  if (!has_thread_) return;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return ready_count_ > 0 || (asked_count_ == 0 && !reading_); });
}

TileSource TileReader::source() {
  TileSource source;
  source.context = this;
  source.ask = [](void* self, NodeKey tile, const TilePlace& place) {
    return static_cast<TileReader*>(self)->ask(tile, place);
  };
  source.poll = [](void* self, NodeKey& tile, Tile& out) {
    return static_cast<TileReader*>(self)->poll(tile, out);
  };
  source.wait = [](void* self) { static_cast<TileReader*>(self)->wait(); };
  return source;
}

TileReading TileReader::reading() const {
  return {reader_, [](const void* reader, NodeKey tile, const TilePlace& place,
                      std::span<std::byte> workspace, Tile& out) {
            return read(*static_cast<const WorldReader*>(reader), tile, place, workspace, out);
          }};
}

}  // namespace karst::core
