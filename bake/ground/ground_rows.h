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
  const Elevation& facts() const { return rows_.facts(); }
  int width() const { return rows_.width(); }
  int height() const { return rows_.height(); }
  double unit_m() const { return rows_.unit_m(); }
  std::uint64_t file_bytes() const { return rows_.file_bytes(); }
  SamplePlace place() const { return rows_.place(); }
  bool is_held() const { return std::int64_t{width()} * height() <= kMostHeld; }

  // Calls take(row), which returns whether to go on, for each. May be called again.
  using Take = std::function<bool(std::span<const float>)>;
  Error run(const Take& take);
  // Of the last run().
  std::uint64_t voids() const { return voids_; }
  std::size_t sunk_samples() const { return sunk_; }

 private:
  Error hold();
  Error run_strips(const Take& take);

  const ReadElevation& settings_;
  std::optional<double> water_m_;
  ElevationRows rows_;
  Elevation held_;
  bool holds_ = false;
  std::uint64_t voids_ = 0;
  std::size_t sunk_ = 0;
};

}  // namespace karst::bake
