// SPDX-License-Identifier: MIT
// Making vertices and copying them to the GPU, with what it cost.
#pragma once

#include <cstdint>
#include <limits>

#include "karst/inspect.h"
#include "renderer/renderer.h"
#include "scene/frame/clock/own_work.h"
#include "terrain/world/terrain_parts.h"

namespace karst::core {

class VertexWork {
 public:
  static constexpr std::uint32_t kAllPatches = 0xffffffffu;
  static constexpr double kNoLimit = std::numeric_limits<double>::infinity();

  // Borrowed for the object's life.
  void create(TerrainParts& terrain, Renderer& renderer, const Inspection& inspection) {
    terrain_ = &terrain;
    renderer_ = &renderer;
    inspection_ = &inspection;
  }

  // A frame begins. tolerant: heights that cannot be read do not end it; it draws what there is, and they are
  // asked for again after a while.
  void begin_frame(bool tolerant) { tolerant_ = tolerant; }
  // Whether it is too soon to ask again: nothing is made then.
  bool rests() const;
  // Whether the last heights that were asked for could not be read.
  bool failing() const { return failing_; }
  // Takes note of how an attempt to make vertices ended. Returns what the frame is to make of it.
  Status judge(const Status& status);

  // What the frame's views lack, for so many milliseconds; with `ahead` also what is about to be needed.
  // made: patches.
  Status make(double work_ms, bool ahead, FrameCosts& costs, std::uint32_t& made);
  // What edits have touched: all of it, but finer than plain no more than so many patches.
  Status remake(std::uint32_t most, FrameCosts& costs);
  // The coarsest vertices of all patches that have none; of regions that are fresh of no more than so many.
  Status make_bases(FrameCosts& costs, std::uint32_t most = kAllPatches);

  Status upload(const PatchUpload& upload) {
    if (upload.vertices.empty()) {
      return renderer_->upload_shading(terrain_->residency.pages(), upload.patch,
                                       static_cast<std::uint32_t>(upload.first_vertex), upload.origin,
                                       upload.row, upload.shading);
    }
    return renderer_->upload_vertices(terrain_->residency.pages(), upload.patch,
                                      static_cast<std::uint32_t>(upload.first_vertex), upload.vertices,
                                      upload.origin, upload.row, upload.shading);
  }
  Status upload_morph_rows(FrameCosts& costs);

 private:
  bool generate_next(bool ahead, PatchUpload& next, Status& status);

  const Inspection* inspection_ = nullptr;
  TerrainParts* terrain_ = nullptr;
  Renderer* renderer_ = nullptr;
  bool tolerant_ = false;
  bool failing_ = false;
  std::int64_t retry_at_ns_ = 0;
};

}  // namespace karst::core
