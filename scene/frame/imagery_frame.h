// SPDX-License-Identifier: MIT
// The imagery's part of a frame: which image tiles views need, and what of them is copied to the GPU.
#pragma once

#include <cstdint>
#include <span>

#include "karst/inspect.h"
#include "karst/renderer.h"
#include "renderer/renderer.h"
#include "scene/frame/ground_frame.h"
#include "terrain/world/terrain_parts.h"

namespace karst::core {

class ImageryFrame {
 public:
  // Borrowed for the object's life.
  void create(TerrainParts& terrain, Renderer& renderer, const Inspection& inspection);
  bool exists() const { return terrain_->imagery.exists(); }
  void forget() { terrain_->imagery.forget(); }

  // After the ground's views were selected: takes what came, for work_ms at most, chooses for all views, asks
  // for what they lack, and brings their tables to the GPU. wait: until nothing is lacking that can be had.
  // motions: as GroundFrame::select().
  Status run(const GroundFrame& ground, std::span<const ViewRequest> requests,
             std::span<const glm::dvec3> motions, double work_ms, bool wait, FrameCosts& costs);
  // ImageRequest::pixel of a view.
  static double pixel(const ViewRequest& request);

  // Tiles that views lack.
  std::uint32_t lacking() const { return lacking_; }
  // Of them, that would come too late to be of use.
  std::uint32_t left_out() const { return left_out_; }
  // Whether the last tile that was asked for could not be read.
  bool failing() const { return exists() && terrain_->imagery.counts().failing; }
  // Whether the last one that came found no room beside what is looked at.
  bool full() const { return exists() && terrain_->imagery.counts().full; }
  const ImagePlace& place(std::size_t view) const { return terrain_->imagery.view(view).place(); }

 private:
  Status take(double work_ms, bool all, std::uint32_t& came);
  void select(const GroundFrame& ground, std::span<const ViewRequest> requests,
              std::span<const glm::dvec3> motions);

  TerrainParts* terrain_ = nullptr;
  Renderer* renderer_ = nullptr;
  const Inspection* inspection_ = nullptr;
  std::uint32_t lacking_ = 0;
  std::uint32_t left_out_ = 0;
};

}  // namespace karst::core
