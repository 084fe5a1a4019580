// SPDX-License-Identifier: MIT
// How an eye moves, as far as its places in the last frames tell.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include <glm/vec3.hpp>

namespace karst::core {

// The motion of the newer half of the frames and that of the older half are compared along each axis: the
// lesser counts, and none where they run against each other. So one jump is no motion, whenever it was; nor
// is trembling.
class EyeMotion {
 public:
  static constexpr std::size_t kFrames = 8;  // that are looked back

  // Where it is in a new frame.
  void add(const glm::dvec3& place) {
    newest_ = (newest_ + 1) % places_.size();
    places_[newest_] = place;
    if (count_ < places_.size()) ++count_;
  }
  // Of the newest place, a frame. 0 where fewer than kFrames + 1 frames were added.
  glm::dvec3 a_frame() const {
    glm::dvec3 motion(0.0);
    if (count_ < places_.size()) return motion;
    const glm::dvec3& middle = places_[(newest_ + places_.size() - kFrames / 2) % places_.size()];
    const glm::dvec3 newer = places_[newest_] - middle;
    const glm::dvec3 older = middle - places_[(newest_ + 1) % places_.size()];
    for (int axis = 0; axis < 3; ++axis) {
      if (!(newer[axis] * older[axis] > 0.0)) continue;
      const double least = std::abs(newer[axis]) < std::abs(older[axis]) ? newer[axis] : older[axis];
      motion[axis] = least / (kFrames / 2);
    }
    return motion;
  }

 private:
  std::array<glm::dvec3, kFrames + 1> places_{};
  std::size_t newest_ = 0;
  std::size_t count_ = 0;
};

}  // namespace karst::core
