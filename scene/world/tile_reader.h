// SPDX-License-Identifier: MIT
// Reads a world's tiles: for frames on a thread of its own, so that none waits for a disk; for queries at
// once. And image tiles, on the same thread, when no tile of the ground is asked for.
//
// The thread is the only one that karst starts. It takes no signals, and touches the file, through the host's
// Source, and memory of its own alone. Where it cannot be made, tiles are read by the frame that polls.
#pragma once

#include <pthread.h>

#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>

#include "karst/status.h"
#include "terrain/file/world_reader.h"
#include "terrain/imagery/image_source.h"
#include "terrain/paging/tile_source.h"
#include "terrain/query/query_ground.h"

namespace karst::core {

class TileReader {
 public:
  TileReader() = default;
  TileReader(const TileReader&) = delete;
  TileReader& operator=(const TileReader&) = delete;
  ~TileReader() { stop(); }

  static constexpr std::size_t kMostAsked = 16;
  static constexpr std::size_t kMostReady = 4;
  static constexpr std::size_t kMostImagesAsked = 8;
  static constexpr std::size_t kMostImagesReady = 2;

  // Of memory for start(); images: the world's.
  static std::size_t bytes(ImageFormat images);
  // Of memory that reading one tile takes: QueryGround::Limits::workspace.
  static std::size_t workspace_bytes();

  // reader: borrowed until stop(), its source too. memory: of bytes(reader.imagery().format), aligned to 64.
  void start(const WorldReader& reader, std::span<std::byte> memory);
  void stop();
  bool has_thread() const { return has_thread_; }
  // Of the last tile that could not be read for a frame.
  Status trouble();

  // For Ground::attach(); of one thread.
  TileSource source();
  // For Imagery::attach(); of the same thread.
  ImageSource image_source();
  // For queries; any thread.
  TileReading reading() const;

  // corrupt, unsupported, io, as WorldReader.
  static Status read(const WorldReader& reader, NodeKey tile, const TilePlace& place,
                     std::span<std::byte> workspace, Tile& out);
  // out: image_tile_bytes() of the world's format; what is behind the head are the texels.
  static Status read_image(const WorldReader& reader, NodeKey tile, const TilePlace& place,
                           std::span<std::byte> out, ImageChildren& children);

 private:
  struct Asked {
    NodeKey tile;
    TilePlace place;
  };
  struct Ready {
    NodeKey tile;
    bool failed = false;
  };

  struct ReadyImage {
    NodeKey tile;
    ImageChildren children;
    bool failed = false;
  };

  void work();
  void work_on_tile(std::unique_lock<std::mutex>& lock);
  void work_on_image(std::unique_lock<std::mutex>& lock);
  bool ask_image(NodeKey tile, const TilePlace& place);
  TileSource::Answer poll_image(ImageArrival& out);
  void wait_for_image();
  std::span<std::byte> image_room(std::size_t at) const;
  bool ask(NodeKey tile, const TilePlace& place);
  TileSource::Answer poll(NodeKey& tile, Tile& out);
  void wait();

  const WorldReader* reader_ = nullptr;
  std::span<Tile> tiles_;  // kMostReady, of ready_
  std::span<std::byte> workspace_;
  pthread_t thread_{};
  bool has_thread_ = false;

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  bool reading_ = false;  // the thread has one in hand
  Status trouble_;
  std::array<Asked, kMostAsked> asked_{};
  std::size_t asked_count_ = 0;
  std::array<Ready, kMostReady> ready_{};
  std::size_t ready_first_ = 0;
  std::size_t ready_count_ = 0;

  // Of images, as above.
  struct Images {
    std::span<std::byte> room;  // kMostImagesReady of them, of ready
    bool reading = false;
    bool is_lent = false;  // the first ready one
    std::array<Asked, kMostImagesAsked> asked{};
    std::size_t asked_count = 0;
    std::array<ReadyImage, kMostImagesReady> ready{};
    std::size_t first = 0;
    std::size_t count = 0;
  } images_;
};

}  // namespace karst::core
