// SPDX-License-Identifier: MIT
// The ground in a rectangle of nodes as a region's voxels see it: voxels from the region's corner.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/edit/ground/edit_ground.h"
#include "terrain/ground/ground.h"

namespace karst::core {

// In a quad of size 0, as nodes draw it. h: its corners north-west, north-east, south-west, south-east; u, v:
// 0..1 to the east and to the south; odd: the sum of its two numbers is.
inline double height_in_quad(const double (&h)[4], double u, double v, bool odd) {
  if (!odd)
    return u > v ? h[0] + u * (h[1] - h[0]) + v * (h[3] - h[1])
                 : h[0] + v * (h[2] - h[0]) + u * (h[3] - h[2]);
  return u + v < 1 ? h[0] + u * (h[1] - h[0]) + v * (h[2] - h[0])
                   : h[3] + (1 - u) * (h[2] - h[3]) + (1 - v) * (h[1] - h[3]);
}

// What surfaces of a region are fitted to: curves through the samples whose slopes there are those that
// normals of nodes have (Catmull and Rom 1974); at the sides, where the ground begins, the lines that nodes
// draw there, into which they bend in so few voxels that light and materials, which go by slopes, go on from
// nodes, whose normals are no flat triangle's.
class RegionHeights {
 public:
  // Samples of nodes low..high - 1, and one more around. floats: that read() takes.
  RegionHeights(const GroundInfo& info, const NodeRect& nodes)
      : spacing_(info.steps[0] / kStepsPerVoxel),
        first_{std::int64_t{nodes.low[0]} * kNodeQuads, std::int64_t{nodes.low[1]} * kNodeQuads},
        quads_{(nodes.high[0] - nodes.low[0]) * kNodeQuads, (nodes.high[1] - nodes.low[1]) * kNodeQuads} {}
  std::size_t floats() const { return row() * static_cast<std::size_t>(quads_[1] + 3); }
  // room: floats(), borrowed. corner_y: of the region, voxels from the world's. Errors of reading.
  // Precondition: there is ground all around.
  Status read(EditGround& ground, std::int32_t corner_y, std::span<float> room) {
    samples_ = room;
    std::size_t at = 0;
    for (std::int64_t k = -1; k <= quads_[1] + 1; ++k) {
      for (std::int64_t i = -1; i <= quads_[0] + 1; ++i) {
        std::int32_t height = 0;
        if (const Status status = ground.height(first_[0] + i, first_[1] + k, height); !status.ok())
          return status;
        samples_[at++] = static_cast<float>(double{kVertexStep} * height / kStepsPerVoxel - corner_y);
      }
    }
    return {};
  }
  // What read() has left in its room.
  void use(std::span<float> room) { samples_ = room; }
  double at(double x, double z) const {
    const double along[2] = {(x - 0.5) / spacing_, (z - 0.5) / spacing_};
    int quad[2];
    double part[2];
    for (int axis = 0; axis < 2; ++axis) {
      quad[axis] = std::clamp(static_cast<int>(std::floor(along[axis])), 0, quads_[axis] - 1);
      part[axis] = along[axis] - quad[axis];
    }
    // The north-western of 4 x 4 samples around.
    const float* const corner = sample(quad[0] - 1, quad[1] - 1);
    double rows[4];
    for (std::size_t k = 0; k < 4; ++k) rows[k] = curve(corner + k * row(), 1, part[0]);
    double height = curve(rows, 1, part[1]);
    // At the sides it ends in what nodes draw.
    for (int axis = 0; axis < 2; ++axis) {
      const bool far = 2 * along[axis] > quads_[axis];
      const double samples = std::max(far ? quads_[axis] - along[axis] : along[axis], 0.0);
      const double from_side = samples / std::min(kBend / spacing_, 1.0);
      if (from_side >= 1) continue;
      const int side = far ? quads_[axis] : 0;
      const float* const line =
          axis == 0 ? sample(side, quad[1] - 1) : sample(quad[0] - 1, side);  // four along it
      const std::size_t stride = axis == 0 ? row() : 1;
      const double t = part[1 - axis];
      const double before = double{line[stride]}, after = double{line[2 * stride]};
      const double drawn = before + t * (after - before);
      const double share = 1 - from_side * from_side * (3 - 2 * from_side);
      height += share * (drawn - curve(line, stride, t));
    }
    return height;
  }

 private:
  static constexpr double kBend = 2;  // voxels from a side

  std::size_t row() const { return static_cast<std::size_t>(quads_[0]) + 3; }
  const float* sample(int i, int k) const {
    return samples_.data() + static_cast<std::size_t>(k + 1) * row() + static_cast<std::size_t>(i + 1);
  }
  // Through the middle two of four.
  template <class T>
  static double curve(const T* h, std::size_t stride, double t) {
    const double a = double{h[0]}, b = double{h[stride]}, c = double{h[2 * stride]},
                 d = double{h[3 * stride]};
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
  }

  double spacing_;  // voxels
  std::int64_t first_[2];
  int quads_[2];
  std::span<float> samples_;
};

}  // namespace karst::core
