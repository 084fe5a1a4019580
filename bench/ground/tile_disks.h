// SPDX-License-Identifier: MIT
// Two disks that a synthetic ground's tiles come from. Each borrows the ground and lends its TileSource.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "bench/ground/synthetic_ground.h"
#include "terrain/paging/tile_source.h"
#include "tiles/encode_tile.h"

namespace karst::bench {
using core::TilePlace;
using core::TileSource;

// In a time of its own, so that what comes in which frame is the same on every machine: one read after the
// other, each a seek and the bytes that the tile takes in a world file. Tiles are made when they are asked
// for; what that takes of the caller's time is counted, to be taken off.
class TimedDisk {
 public:
  static constexpr std::size_t kMostAsked = 16;  // as TileReader::kMostAsked

  struct Counts {
    std::uint64_t tiles = 0, bytes = 0;  // asked for
    double made_ms = 0;                  // by the clock, making them
    double made_cpu_ms = 0;
  };

  TimedDisk(const SyntheticGround& ground, double megabytes_per_s, double seek_ms)
      : ground_(ground), ms_per_byte_(1e-3 / megabytes_per_s), seek_ms_(seek_ms) {}
  TimedDisk(const TimedDisk&) = delete;
  TimedDisk& operator=(const TimedDisk&) = delete;

  void pass(double ms) { now_ms_ += ms; }
  const Counts& counts() const { return counts_; }
  TileSource source();

 private:
  struct Read {
    NodeKey key;
    double done_ms = 0;
    std::vector<Tile> tile;  // one
  };

  bool ask(NodeKey key);
  TileSource::Answer poll(NodeKey& key, Tile& out);

  const SyntheticGround& ground_;
  double ms_per_byte_;
  double seek_ms_;
  double now_ms_ = 0;
  std::deque<Read> reads_;
  tiles::TileEncoder encoder_;
  std::vector<std::byte> packed_;
  Counts counts_;
};

// Sleeps before each tile, on a thread.
class SleepingDisk {
 public:
  SleepingDisk(const SyntheticGround& ground, double sleep_ms);
  SleepingDisk(const SleepingDisk&) = delete;
  SleepingDisk& operator=(const SleepingDisk&) = delete;
  ~SleepingDisk();

  TileSource source();
  std::uint64_t tiles();  // that it has made

 private:
  void work();

  const SyntheticGround& ground_;
  double sleep_ms_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  std::uint64_t made_ = 0;
  std::deque<NodeKey> asked_;
  NodeKey ready_key_;
  std::vector<Tile> ready_;  // one at most
  std::thread thread_;
};

}  // namespace karst::bench
