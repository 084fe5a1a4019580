// SPDX-License-Identifier: MIT
// The bytes a terrain and its renderer take, one term a consumer, known before anything is allocated (design
// 5). This file only adds up. Each module states its own bytes (Octree::bytes_for, ...); terrain/world sums
// them for a Config, because base knows none of the types above it.
#pragma once

#include "terrain/base/arena.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::core {

// Everybody who takes GPU memory. kGpuConsumerNames holds the same words for reports.
enum class GpuConsumer : std::uint8_t {
  vertices,
  page_table,
  morph_rows,
  stream_indices,
  uniforms,
  textures,
  materials,
  imagery,
  shadow_maps,
  g_buffer
};
inline constexpr std::size_t kGpuConsumerCount = 10;
inline constexpr std::array<const char*, kGpuConsumerCount> kGpuConsumerNames = {
    "vertices", "page_table", "morph_rows", "stream_indices", "uniforms",
    "textures", "materials",  "imagery",    "shadow_maps",    "g_buffer"};

class Budget {
 public:
  static constexpr std::size_t kUnbounded = SIZE_MAX;  // bytes; stands for any sum that does not fit size_t

  struct Term {
    const char* name;
    bool gpu;
    std::size_t bytes;
  };

  constexpr Budget() {
    for (std::size_t i = 0; i < kConsumerCount; ++i) terms_[i] = {kConsumerNames[i], false, 0};
    for (std::size_t i = 0; i < kGpuConsumerCount; ++i) {
      terms_[kConsumerCount + i] = {kGpuConsumerNames[i], true, 0};
    }
  }

  // Adds to a consumer's term. Sums saturate at kUnbounded, which no arena can hold.
  // For Consumer, bytes are those of Arena::bytes_for, so that the term equals Arena::used(consumer).
  constexpr void add(Consumer consumer, std::size_t bytes) { grow(index(consumer), bytes); }
  constexpr void add(GpuConsumer consumer, std::size_t bytes) { grow(index(consumer), bytes); }

  constexpr std::size_t bytes(Consumer consumer) const { return terms_[index(consumer)].bytes; }
  constexpr std::size_t bytes(GpuConsumer consumer) const { return terms_[index(consumer)].bytes; }

  // All consumers in fixed order, CPU first; terms that nothing was added to are 0 bytes.
  constexpr std::span<const Term> terms() const { return terms_; }

  // What the arena's memory must hold, and what the renderer's GL objects take. kUnbounded: too large.
  constexpr std::size_t cpu_bytes() const { return sum(false); }
  constexpr std::size_t gpu_bytes() const { return sum(true); }

 private:
  static constexpr std::size_t index(Consumer consumer) { return static_cast<std::size_t>(consumer); }
  static constexpr std::size_t index(GpuConsumer consumer) {
    return kConsumerCount + static_cast<std::size_t>(consumer);
  }
  static constexpr std::size_t saturating_add(std::size_t a, std::size_t b) {
    return b > kUnbounded - a ? kUnbounded : a + b;
  }
  constexpr void grow(std::size_t term, std::size_t bytes) {
    terms_[term].bytes = saturating_add(terms_[term].bytes, bytes);
  }
  constexpr std::size_t sum(bool gpu) const {
    std::size_t total = 0;
    for (const Term& term : terms_) {
      if (term.gpu == gpu) total = saturating_add(total, term.bytes);
    }
    return total;
  }

  std::array<Term, kConsumerCount + kGpuConsumerCount> terms_{};
};

}  // namespace karst::core
