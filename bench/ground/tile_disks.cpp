// SPDX-License-Identifier: MIT
#include "bench/ground/tile_disks.h"

#include <algorithm>
#include <chrono>

#include "bench/measure/bench_clock.h"

namespace karst::bench {

bool TimedDisk::ask(NodeKey key) {
  if (reads_.size() == kMostAsked) return false;
  const double start = clock_ms(CLOCK_MONOTONIC), start_cpu = clock_ms(CLOCK_THREAD_CPUTIME_ID);
  Read& read = reads_.emplace_back();
  read.key = key;
  read.tile.resize(1);
  ground_.make_tile(key, read.tile[0]);
  encoder_.run(key, ground_.info(), read.tile[0], 1, packed_);
  const double before = reads_.size() > 1 ? reads_[reads_.size() - 2].done_ms : now_ms_;
  read.done_ms = std::max(before, now_ms_) + seek_ms_ + static_cast<double>(packed_.size()) * ms_per_byte_;
  ++counts_.tiles;
  counts_.bytes += packed_.size();
  counts_.made_ms += clock_ms(CLOCK_MONOTONIC) - start;
  counts_.made_cpu_ms += clock_ms(CLOCK_THREAD_CPUTIME_ID) - start_cpu;
  return true;
}

TileSource::Answer TimedDisk::poll(NodeKey& key, Tile& out) {
  if (reads_.empty() || reads_.front().done_ms > now_ms_) return TileSource::Answer::none;
  key = reads_.front().key;
  out = reads_.front().tile[0];
  reads_.pop_front();
  return TileSource::Answer::ready;
}

TileSource TimedDisk::source() {
  TileSource source;
  source.context = this;
  source.ask = [](void* self, NodeKey key, const TilePlace&) {
    return static_cast<TimedDisk*>(self)->ask(key);
  };
  source.poll = [](void* self, NodeKey& key, Tile& out) {
    return static_cast<TimedDisk*>(self)->poll(key, out);
  };
  source.wait = [](void* self) {
    auto& own = *static_cast<TimedDisk*>(self);
    if (!own.reads_.empty()) own.now_ms_ = std::max(own.now_ms_, own.reads_.front().done_ms);
  };
  return source;
}

SleepingDisk::SleepingDisk(const SyntheticGround& ground, double sleep_ms)
    : ground_(ground), sleep_ms_(sleep_ms), thread_([this] { work(); }) {}

SleepingDisk::~SleepingDisk() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void SleepingDisk::work() {
  std::vector<Tile> tile(1);
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return stopping_ || (!asked_.empty() && ready_.empty()); });
    if (stopping_) return;
    const NodeKey key = asked_.front();
    const auto sleep = std::chrono::duration<double, std::milli>(sleep_ms_);
    if (changed_.wait_for(lock, sleep, [&] { return stopping_; })) return;
    lock.unlock();
    ground_.make_tile(key, tile[0]);
    lock.lock();
    asked_.pop_front();
    ready_key_ = key;
    ready_ = tile;
    ++made_;
    changed_.notify_all();
  }
}

std::uint64_t SleepingDisk::tiles() {
  const std::lock_guard lock(mutex_);
  return made_;
}

TileSource SleepingDisk::source() {
  TileSource source;
  source.context = this;
  source.ask = [](void* self, NodeKey key, const TilePlace&) {
    auto& own = *static_cast<SleepingDisk*>(self);
    {
      const std::lock_guard lock(own.mutex_);
      if (own.asked_.size() == TimedDisk::kMostAsked) return false;
      own.asked_.push_back(key);
    }
    own.changed_.notify_all();
    return true;
  };
  source.poll = [](void* self, NodeKey& key, Tile& out) {
    auto& own = *static_cast<SleepingDisk*>(self);
    {
      const std::lock_guard lock(own.mutex_);
      if (own.ready_.empty()) return TileSource::Answer::none;
      key = own.ready_key_;
      out = own.ready_[0];
      own.ready_.clear();
    }
    own.changed_.notify_all();
    return TileSource::Answer::ready;
  };
  source.wait = [](void* self) {
    auto& own = *static_cast<SleepingDisk*>(self);
    std::unique_lock lock(own.mutex_);
    own.changed_.wait(lock, [&] { return !own.ready_.empty() || own.asked_.empty(); });
  };
  return source;
}

}  // namespace karst::bench
