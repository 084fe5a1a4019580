// SPDX-License-Identifier: MIT
// The isosurface's part of a frame: its blocks for all views, their meshes on the GPU, and what views and
// shadow maps draw of them.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "karst/inspect.h"
#include "karst/renderer.h"
#include "renderer/renderer.h"
#include "terrain/shadow/cascades.h"
#include "terrain/world/terrain_parts.h"

namespace karst::core {

class MeshFrame {
 public:
  // Borrowed for the object's life.
  void create(TerrainParts& terrain, Renderer& renderer, const Inspection& inspection);
  bool exists() const { return terrain_->isosurface.exists(); }
  void forget() { terrain_->isosurface.forget(); }

  // Chooses for all views, makes meshes for work_ms at most, and copies them to the GPU. wait: until none is
  // missing. Lists what each view draws.
  Status run(std::span<const ViewRequest> requests, double work_ms, bool wait, FrameCosts& costs);

  // A view draws none of it: the ground stands for its region.
  void leave_out(std::size_t view) {
    lists_[view] = {};
    bounds_px_[view] = 0;
  }
  const Isosurface::List& list(std::size_t view) const { return lists_[view]; }
  // Of a shadow map; the last one's is given up.
  Isosurface::List casters(const Cascade& cascade) const;
  MeshPages pages() const { return terrain_->isosurface.pool().pages(0); }
  std::span<PageTexel> texels() const { return terrain_->isosurface.pool().texels(); }
  // Most pixels that a view's are off by.
  float bound_px(std::size_t view) const { return bounds_px_[view]; }
  std::uint32_t lacking() const { return exists() ? terrain_->isosurface.lacking() : 0; }
  // Whether memory is too small for what views aim at.
  bool full() const {
    return exists() && (terrain_->isosurface.lacks_room() || terrain_->isosurface.error_scale() > 1);
  }

 private:
  TerrainParts* terrain_ = nullptr;
  Renderer* renderer_ = nullptr;
  const Inspection* inspection_ = nullptr;
  std::array<Isosurface::List, kMostViews> lists_{};
  std::array<float, kMostViews> bounds_px_{};
};

}  // namespace karst::core
