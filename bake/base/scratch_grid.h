// SPDX-License-Identifier: MIT
// A grid of numbers that a bake reads in any direction: in memory, or, of many, in a file without a name,
// which ends with the program and of which the system keeps in memory what it has room for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "platform/base/error.h"

namespace karst::bake {

// Numbers lie in squares of kSide, so that neighbours in any direction lie in few pages. What nobody set is
// 0.
class ScratchGrid {
 public:
  static constexpr std::int64_t kSide = 64;

  ScratchGrid() = default;
  ScratchGrid(const ScratchGrid&) = delete;
  ScratchGrid& operator=(const ScratchGrid&) = delete;
  ~ScratchGrid() { clear(); }

  // Of width x height, at least 1 each. In memory up to held_bytes; else in a file in the folder, whose room
  // is taken at once, so that no later write fails.
  Error open(std::int64_t width, std::int64_t height, std::uint64_t held_bytes, const std::string& folder);
  void clear();
  bool is_file() const { return mapped_bytes_ > 0; }
  static std::uint64_t bytes_for(std::int64_t width, std::int64_t height) {
    return static_cast<std::uint64_t>(squares(width) * squares(height) * kSide * kSide) * sizeof(float);
  }

  // x 0..width - 1, y 0..height - 1. Several threads may write different numbers.
  float at(std::int64_t x, std::int64_t y) const { return numbers_[index(x, y)]; }
  void set(std::int64_t x, std::int64_t y, float value) { numbers_[index(x, y)] = value; }

 private:
  static std::int64_t squares(std::int64_t count) { return (count + kSide - 1) / kSide; }
  std::size_t index(std::int64_t x, std::int64_t y) const {
    const std::int64_t square = y / kSide * squares_wide_ + x / kSide;
    return static_cast<std::size_t>((square * kSide + y % kSide) * kSide + x % kSide);
  }

  std::int64_t squares_wide_ = 0;
  std::vector<float> held_;
  float* numbers_ = nullptr;
  std::size_t mapped_bytes_ = 0;
};

}  // namespace karst::bake
