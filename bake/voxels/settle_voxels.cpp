// SPDX-License-Identifier: MIT
#include "bake/voxels/settle_voxels.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace karst::bake {
namespace {

constexpr int kMostSweeps =
    40;  // few voxels change after the third; where the rules contradict each other, some never rest

class Settle {
 public:
  explicit Settle(const SettleVoxels& job) : extent_(job.extent), values_(job.values) {}

  std::uint64_t run() {
    std::vector<std::uint8_t> changed(values_.size(), 0);
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      std::uint64_t flips = 0;
      for (int z = 0; z < extent_.z; ++z) {
        for (int y = 0; y < extent_.y - 1; ++y) {
          for (int x = 0; x < extent_.x; ++x) {
            const glm::ivec3 v(x, y, z);
            if (is_tip(v)) flips += flip(v, changed);
            flips += part_diagonals(v, changed);
          }
        }
      }
      if (flips == 0) break;
    }
    return static_cast<std::uint64_t>(std::count(changed.begin(), changed.end(), std::uint8_t{1}));
  }

 private:
  std::size_t at(glm::ivec3 v) const {
    return (static_cast<std::size_t>(v.z) * static_cast<std::size_t>(extent_.y) +
            static_cast<std::size_t>(v.y)) *
               static_cast<std::size_t>(extent_.x) +
           static_cast<std::size_t>(v.x);
  }
  glm::ivec3 inside(glm::ivec3 v) const {
    for (int k = 0; k < 3; ++k) v[k] = std::clamp(v[k], 0, extent_[k] - 1);
    return v;
  }
  bool filled(glm::ivec3 v) const { return values_[at(inside(v))] > 0; }

  std::uint64_t flip(glm::ivec3 v, std::vector<std::uint8_t>& changed) {
    constexpr float kLeast = 1e-6f;
    float& value = values_[at(v)];
    value = value > 0 ? -kLeast : kLeast;
    changed[at(v)] = 1;
    return 1;
  }

  auto less_sure() const {
    return [this](glm::ivec3 a, glm::ivec3 b) { return std::abs(values_[at(a)]) < std::abs(values_[at(b)]); };
  }

  // Sticks out: beyond it lies the other kind, and of the four voxels beside it at most one is of its kind.
  bool is_tip(glm::ivec3 v) const {
    const bool kind = filled(v);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int way : {-1, 1}) {
        glm::ivec3 ahead = v;
        ahead[axis] += way;
        if (filled(ahead) == kind) continue;
        int beside = 0;
        for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
          for (const int side : {-1, 1}) {
            glm::ivec3 n = v;
            n[other] += side;
            beside += filled(n) == kind ? 1 : 0;
          }
        }
        if (beside < 2) return true;
      }
    }
    return false;
  }

  // Two voxels of one kind that touch only across an edge: changes the least sure of the four around the
  // edge. v is the one with the least coordinates.
  std::uint64_t part_diagonals(glm::ivec3 v, std::vector<std::uint8_t>& changed) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 a(0), b(0);
      a[(axis + 1) % 3] = 1;
      b[(axis + 2) % 3] = 1;
      const glm::ivec3 four[4] = {v, v + a, v + a + b, v + b};
      if (four[2] != inside(four[2]) || four[2].y >= extent_.y - 1) continue;
      const bool kind = filled(four[0]);
      if (filled(four[2]) != kind || filled(four[1]) == kind || filled(four[3]) == kind) continue;
      return flip(*std::min_element(std::begin(four), std::end(four), less_sure()), changed);
    }
    return part_corner(v, changed);
  }

  // The same across a corner, between the two voxels of one kind or the only two of the other kind.
  std::uint64_t part_corner(glm::ivec3 v, std::vector<std::uint8_t>& changed) {
    const glm::ivec3 last = v + 1;
    if (last != inside(last) || last.y >= extent_.y - 1) return 0;
    int count = 0, sum = 0;
    glm::ivec3 octant[8];
    for (int o = 0; o < 8; ++o) {
      octant[o] = v + glm::ivec3(o & 1, o >> 1 & 1, o >> 2);
      if (!filled(octant[o])) continue;
      ++count;
      sum += o;
    }
    // Opposite octants add up to 7; all eight to 28.
    const bool two = count == 2, six = count == 6;
    if (!(two && sum == 7) && !(six && sum == 21)) return 0;
    for (int o = 0; o < 4; ++o) {
      if (filled(octant[o]) != two || filled(octant[7 - o]) != two) continue;
      const glm::ivec3 pair[2] = {octant[o], octant[7 - o]};
      return flip(less_sure()(pair[0], pair[1]) ? pair[0] : pair[1], changed);
    }
    return 0;
  }

  glm::ivec3 extent_;
  std::span<float> values_;
};

}  // namespace

std::uint64_t SettleVoxels::run() const {
  return Settle(*this).run();
}

}  // namespace karst::bake
