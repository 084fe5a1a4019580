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

template <class Asked, std::size_t kMost>
Asked take_first(std::array<Asked, kMost>& asked, std::size_t& count) {
  const Asked first = asked[0];
  std::move(asked.begin() + 1, asked.begin() + static_cast<std::ptrdiff_t>(count), asked.begin());
  --count;
  return first;
}

}  // namespace

std::size_t TileReader::workspace_bytes() {
  return whole_lines(tiles::kMostTileBytes) + tiles::decode_tile_room();
}

std::size_t TileReader::bytes(ImageFormat images) {
  std::size_t bytes = whole_lines(kMostReady * sizeof(Tile)) + whole_lines(workspace_bytes());
  if (images != ImageFormat::none) bytes += kMostImagesReady * whole_lines(image_tile_bytes(images));
  return bytes;
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

Status TileReader::read_image(const WorldReader& reader, NodeKey tile, const TilePlace& place,
                              std::span<std::byte> out, ImageChildren& children) {
  if (place.bytes != out.size())
    return {StatusCode::corrupt, "is of another length than all are", "image tile", place.offset};
  if (const Status status = reader.read_tile(place, out); !status.ok()) return status;
  return check_image_tile(reader.ground(), reader.imagery(), tile, place, out, children);
}

void TileReader::start(const WorldReader& reader, std::span<std::byte> memory) {
  KARST_ASSERT(memory.size() >= bytes(reader.imagery().format) && reader_ == nullptr);
  reader_ = &reader;
  auto* const first = new (memory.data()) Tile[kMostReady];
  tiles_ = {first, kMostReady};
  workspace_ = memory.subspan(whole_lines(kMostReady * sizeof(Tile)), whole_lines(workspace_bytes()));
  images_.room = memory.subspan(whole_lines(kMostReady * sizeof(Tile)) + whole_lines(workspace_bytes()));
  stopping_ = reading_ = images_.reading = images_.is_lent = false;
  asked_count_ = ready_first_ = ready_count_ = 0;
  images_.asked_count = images_.first = images_.count = 0;
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
    const auto has_tile = [&] { return asked_count_ > 0 && ready_count_ < kMostReady; };
    const auto has_image = [&] { return images_.asked_count > 0 && images_.count < kMostImagesReady; };
    changed_.wait(lock, [&] { return stopping_ || has_tile() || has_image(); });
    if (stopping_) return;
    if (has_tile()) {
      work_on_tile(lock);
    } else {
      work_on_image(lock);
    }
    changed_.notify_all();
  }
}

void TileReader::work_on_tile(std::unique_lock<std::mutex>& lock) {
  const Asked next = take_first(asked_, asked_count_);
  reading_ = true;
  const std::size_t at = (ready_first_ + ready_count_) % kMostReady;
  lock.unlock();
  const Status status = read(*reader_, next.tile, next.place, workspace_, tiles_[at]);
  lock.lock();
  ready_[at] = {next.tile, !status.ok()};
  if (!status.ok()) trouble_ = status;
  ++ready_count_;
  reading_ = false;
}

std::span<std::byte> TileReader::image_room(std::size_t at) const {
  const std::size_t bytes = image_tile_bytes(reader_->imagery().format);
  return images_.room.subspan(at * whole_lines(bytes), bytes);
}

void TileReader::work_on_image(std::unique_lock<std::mutex>& lock) {
  const Asked next = take_first(images_.asked, images_.asked_count);
  images_.reading = true;
  const std::size_t at = (images_.first + images_.count) % kMostImagesReady;
  ReadyImage& ready = images_.ready[at];
  lock.unlock();
  ready.tile = next.tile;
  const Status status = read_image(*reader_, next.tile, next.place, image_room(at), ready.children);
  lock.lock();
  ready.failed = !status.ok();
  if (!status.ok()) trouble_ = status;
  ++images_.count;
  images_.reading = false;
}

bool TileReader::ask_image(NodeKey tile, const TilePlace& place) {
  {
    const std::lock_guard lock(mutex_);
    if (images_.asked_count == kMostImagesAsked) return false;
    images_.asked[images_.asked_count++] = {tile, place};
  }
  changed_.notify_all();
  return true;
}

TileSource::Answer TileReader::poll_image(ImageArrival& out) {
  std::unique_lock lock(mutex_);
  if (images_.is_lent) {
    images_.is_lent = false;
    images_.first = (images_.first + 1) % kMostImagesReady;
    --images_.count;
    changed_.notify_all();
  }
  if (!has_thread_ && images_.asked_count > 0) work_on_image(lock);
  if (images_.count == 0) return TileSource::Answer::none;
  images_.is_lent = true;
  const ReadyImage& ready = images_.ready[images_.first];
  out.key = ready.tile;
  if (ready.failed) return TileSource::Answer::failed;
  out.children = ready.children;
  out.texels = image_room(images_.first).subspan(kImageHeadBytes);
  return TileSource::Answer::ready;
}

void TileReader::wait_for_image() {
  if (!has_thread_) return;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] {
    return images_.count > (images_.is_lent ? 1u : 0u) || (images_.asked_count == 0 && !images_.reading);
  });
}

ImageSource TileReader::image_source() {
  ImageSource source;
  source.context = this;
  source.ask = [](void* self, NodeKey tile, const TilePlace& place) {
    return static_cast<TileReader*>(self)->ask_image(tile, place);
  };
  source.poll = [](void* self, ImageArrival& out) { return static_cast<TileReader*>(self)->poll_image(out); };
  source.wait = [](void* self) { static_cast<TileReader*>(self)->wait_for_image(); };
  return source;
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
    const Asked next = take_first(asked_, asked_count_);
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
