// SPDX-License-Identifier: MIT
// A bump arena over bytes that the caller owns. Open while its users are created, frozen ever after: a frozen
// arena hands out nothing. Every block is counted against the consumer that asked for it.
// Nothing is returned to the arena; consumers that reuse memory keep pools inside their own blocks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <type_traits>

namespace karst::core {

// Everybody who takes memory from the arena. kConsumerNames holds the same words for reports.
enum class Consumer : std::uint8_t {
  octets,
  volumes,
  patches,
  heights,
  bounds,
  level_errors,
  thresholds,
  residency,
  occlusion,
  index_tables,
  draw_list,
  scratch,
  queries,
  ground,
  imagery,
  edits,
  fields
};
inline constexpr std::size_t kConsumerCount = 17;
inline constexpr std::array<const char*, kConsumerCount> kConsumerNames = {
    "octets",     "volumes",   "patches",   "heights",      "bounds",    "level_errors",
    "thresholds", "residency", "occlusion", "index_tables", "draw_list", "scratch",
    "queries",    "ground",    "imagery",   "edits",        "fields"};

class Arena {
 public:
  static constexpr std::size_t kAlignment = 64;  // bytes; one cache line, so no two blocks share one

  // memory: borrowed, aligned to kAlignment (validated by allocate: an unaligned arena is always full).
  explicit Arena(std::span<std::byte> memory) : memory_(memory) {}

  // Exact bytes that allocate<T>(count) takes; SIZE_MAX where that overflows.
  template <class T>
  static constexpr std::size_t bytes_for(std::size_t count) {
    if (count > (SIZE_MAX - kAlignment) / sizeof(T)) return SIZE_MAX;
    return (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
  }

  // count value-initialised objects, or an empty span when frozen or full. Objects are never destroyed.
  template <class T>
  std::span<T> allocate(Consumer consumer, std::size_t count) {
    static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= kAlignment);
    void* block = take(consumer, bytes_for<T>(count));
    if (block == nullptr) return {};
    T* first = static_cast<T*>(block);
    for (std::size_t i = 0; i < count; ++i) ::new (static_cast<void*>(first + i)) T();
    return {first, count};
  }

  void freeze() { frozen_ = true; }
  bool frozen() const { return frozen_; }
  std::size_t capacity() const { return memory_.size(); }
  std::size_t used() const { return used_; }
  std::size_t used(Consumer consumer) const { return by_consumer_[static_cast<std::size_t>(consumer)]; }

 private:
  void* take(Consumer consumer, std::size_t bytes);

  std::span<std::byte> memory_;
  std::size_t used_ = 0;
  std::array<std::size_t, kConsumerCount> by_consumer_{};
  bool frozen_ = false;
};

}  // namespace karst::core
