// SPDX-License-Identifier: MIT
// A ground without a file, of any size, for benchmarks: its tiles are made when they are asked for, the same
// bits every time. Hills of all sizes, a function of the place from the ground's middle alone, so that the
// middle looks the same in a ground of a million samples and in one of 10^12.
//
// Heights are a sum of octaves of value noise (smoothstep between random values at the corners of squares).
// What is measured of nodes is not measured but follows from it, and is the same for all nodes of a size:
//   - From linear pieces over right triangles with legs d an octave of amplitude a and wavelength w deviates
//     by at most M d^2 / 4 (M: its greatest second derivative in any direction, 21 a / w^2) and by 2 a.
//   - Over a way of length l along the axes it rises by at most 3 a l / w and by 2 a.
// Thresholds are made of those bounds by MeasureNodes (terrain/ground/measure_ground.h), so that (1) and (2)
// of terrain/nodes/ground_view.h hold. They are larger than what the same hills would be measured at. A
// node's heights are those of its own vertices, widened by the deviation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "terrain/ground/tile.h"

namespace karst::bench {
using core::GroundInfo;
using core::NodeKey;
using core::Tile;

class SyntheticGround {
 public:
  static constexpr double kSpacing_m = 10;
  static constexpr int kLeastLog2 = 10, kMostLog2 = 20;

  // 2^log2_samples + 1 samples a side, kLeastLog2..kMostLog2.
  explicit SyntheticGround(int log2_samples);

  const GroundInfo& info() const { return info_; }
  NodeKey root() const { return core::tile_of({info_.top_size(), 0, 0}); }
  // kVertexStep. Samples from the middle; those of the ground only.
  std::int32_t height(std::int64_t east, std::int64_t south) const;
  // The tile of this key. Each child's place is that of one byte: no source reads there.
  void make_tile(NodeKey key, Tile& out) const;
  // A world file with this ground, of which only the root's tile is there.
  std::vector<std::byte> file() const;

 private:
  void bound();

  GroundInfo info_;
  std::int64_t middle_ = 0;  // index of the sample there, along both axes
  std::array<std::array<std::uint16_t, core::kDemands>, core::kMostSize + 1> thresholds_{};  // by size
  std::array<std::int32_t, core::kMostSize + 1> strays_{};  // by size: most that samples leave its surface by
};

}  // namespace karst::bench
