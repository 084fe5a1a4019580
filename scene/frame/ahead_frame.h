// SPDX-License-Identifier: MIT
// What is read ahead of a frame: tiles and image tiles that moving views will lack, asked for with what the
// reader has free.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "karst/inspect.h"
#include "scene/frame/ground_frame.h"
#include "scene/frame/imagery_frame.h"

namespace karst::core {

class AheadFrame {
 public:
  // Borrowed for the object's life.
  void create(TerrainParts& terrain, const Inspection& inspection);

  // After ground and imagery asked for what views lack. motions: of each view, lattice steps a frame. Looks
  // ahead for one view, by one span of time.
  void run(const GroundFrame& ground, std::span<const ViewRequest> requests,
           std::span<const glm::dvec3> motions, FrameCosts& costs);
  // What was asked for ahead and became of it since the last time.
  void count(FrameCosts& costs);

 private:
  TerrainParts* terrain_ = nullptr;
  const Inspection* inspection_ = nullptr;
  std::size_t view_ = 0;                                      // whose turn it is
  std::array<std::uint32_t, karst::kMostViews> doublings_{};  // by view: how far it looks
  std::uint32_t rests_ = 0;                                   // frames, in which it does not look
  AheadCounts counted_;
};

}  // namespace karst::core
