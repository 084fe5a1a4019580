// SPDX-License-Identifier: MIT
// Rows of elevation without voids, from the north on.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "bake/elevation/elevation.h"

namespace karst::bake {

// Elevation of up to kMostHeld samples is read as a whole, its voids are filled (fill_voids) and its sea is
// sunk (SinkSea). Of more, voids are filled strip by strip, each with the rows around it, and the sea stays.
// What is void at the north or south border for a whole strip is like the nearest row that is not.
class GroundRows {
 public:
  static constexpr std::int64_t kMostHeld = 1 << 24;

  // Both outlive this.
  GroundRows(const ReadElevation& settings, std::optional<double> water_m)
      : settings_(settings), water_m_(water_m) {}

  Error open();
  // Instead of open(): elevation that is in no file, without voids, in whole units.
  void hold(Elevation made, double unit_m);
  // Instead of open(): elevation that make(first, count, out) makes, count rows from the first on, without
  // voids, in whole units; facts: without heights. Called by up to `threads` threads at once.
  using Make = std::function<void(int first, int count, std::span<float> out)>;
  void make(Elevation facts, double unit_m, int threads, Make make);
  const Elevation& facts() const { return is_made_ ? held_ : rows_.facts(); }
  int width() const { return is_made_ ? held_.width : rows_.width(); }
  int height() const { return is_made_ ? held_.height : rows_.height(); }
  double unit_m() const { return is_made_ ? made_unit_m_ : rows_.unit_m(); }
  std::uint64_t file_bytes() const { return is_made_ ? 0 : rows_.file_bytes(); }
  SamplePlace place() const { return is_made_ ? SamplePlace() : rows_.place(); }
  bool is_held() const { return holds_ || std::int64_t{width()} * height() <= kMostHeld; }

  // Calls take(row), which returns whether to go on, for each. May be called again.
  using Take = std::function<bool(std::span<const float>)>;
  Error run(const Take& take);
  // Of the last run().
  std::uint64_t voids() const { return voids_; }
  std::size_t sunk_samples() const { return sunk_; }

 private:
  Error read_all();
  Error run_strips(const Take& take);
  void run_made(const Take& take) const;

  const ReadElevation& settings_;
  std::optional<double> water_m_;
  ElevationRows rows_;
  Elevation held_;
  bool holds_ = false;
  bool is_made_ = false;
  double made_unit_m_ = 0;
  Make make_;  // of elevation that is not held
  int threads_ = 1;
  std::uint64_t voids_ = 0;
  std::size_t sunk_ = 0;
};

}  // namespace karst::bake
