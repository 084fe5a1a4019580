// SPDX-License-Identifier: MIT
// The ground's part of a frame: what views and shadow maps draw of it, with the tiles, vertices and
// thresholds that takes.
#pragma once

#include <cstdint>
#include <span>

#include "karst/inspect.h"
#include "karst/renderer.h"
#include "renderer/renderer.h"
#include "terrain/shadow/cascades.h"
#include "terrain/world/terrain_parts.h"

namespace karst::core {

class GroundFrame {
 public:
  // Borrowed for the object's life.
  void create(TerrainParts& terrain, Renderer& renderer, const Inspection& inspection);
  bool exists() const { return terrain_->ground.exists(); }
  void forget() { terrain_->ground.forget(); }

  // A frame begins: takes tiles that came, for work_ms at most.
  void begin_frame(double work_ms, FrameCosts& costs);
  // Chooses for all views, which were selected and keep the parts that they draw, and asks for what they
  // lack. motions: of each, lattice steps a frame; empty: nothing is left out, and as much is asked for as
  // the reader takes. wait: until nothing is lacking that can be had; needs them empty. casts: shadow maps
  // are drawn afterwards.
  void select(std::span<ViewState> views, std::span<const ViewRequest> requests,
              std::span<const glm::dvec3> motions, bool wait, bool casts, FrameCosts& costs);
  // Of which parts patches need not be chosen for a view: in its last frame the ground stood for them
  // although their patches were there. Of parts that its request skips, select() takes them to be there
  // still.
  std::uint32_t parts_to_skip(std::size_t view) const;
  // Whether a view draws any that were skipped: then all of it is to be selected again, without.
  bool lacks_skipped(std::span<const ViewRequest> requests) const;
  // What select() asked for a view.
  const GroundRequest& request(std::size_t view) const { return requests_[view]; }
  // For a shadow map, at the error of a view; the last one's is given up. texel: lattice steps that casters
  // may stray. parts: bit n, patches of region n can cast. True where it is complete.
  bool select_casters(const ViewState& view, const Cascade& cascade, double texel, std::uint32_t parts,
                      bool wait, FrameCosts& costs);
  // Vertices and rows that the GPU lacks of all that was selected.
  Status upload(FrameCosts& costs);

  // Of which parts of the world a view draws patches, a bit each: of all, where there is no ground.
  static constexpr std::uint32_t kAllParts = 0xffffffffu;
  std::uint32_t parts_drawn(std::size_t view) const {
    return exists() ? terrain_->ground.view(view).result().regions : kAllParts;
  }
  // Whether the isosurface is drawn where these parts are: of a region, where that is.
  bool draws_meshes(std::uint32_t parts) const { return (parts & mesh_part()) == mesh_part(); }
  // The isosurface's part, where there is one, and it can be drawn.
  std::uint32_t mesh_part() const {
    const int part = terrain_->world.field_part();
    return part < 0 ? 0 : std::uint32_t{1} << part;
  }
  // Of some parts, those that can be drawn: the isosurface's only where its meshes end in one closed line.
  std::uint32_t drawable(std::uint32_t parts) const {
    return terrain_->isosurface.rim().exists() ? parts : parts & ~mesh_part();
  }
  // The belts of a view, whose patches are drawn at these levels. Not before upload().
  void build_belts(std::size_t view, std::span<const std::uint8_t> levels);
  std::span<const std::uint32_t> belts(std::size_t view) const { return terrain_->ground.belts(view); }

  // What a view draws, and where its rows begin among all; of the shadow map that was selected last.
  std::span<const DrawItem> nodes(std::size_t view) const { return terrain_->ground.view(view).items(); }
  // How many of them, from the first on, hold all that may be nearer than so many lattice steps.
  std::size_t nodes_within(std::size_t view, double steps) const;
  std::uint32_t first_row(std::size_t view) const {
    return renderer_->settings().morph_rows + static_cast<std::uint32_t>(view) * terrain_->ground.row_count();
  }
  // Where walls end: the lowest height of all.
  std::int64_t foot() const { return std::int64_t{terrain_->ground.info().low} * kVertexStep; }
  // Of a curved basis: whether it is one, and what is level for a camera.
  bool is_curved() const { return exists() && terrain_->ground.info().basis.is_curved(); }
  FrameLevel level(const Camera& camera) const;
  // Whether quads that a view draws bend by more than a height that materials may be off by.
  bool has_long_chords(std::size_t view) const;
  // East, up and south there, as columns.
  glm::dmat3 axes(const Camera& camera) const;
  std::size_t shadow_view() const { return terrain_->ground.shadow_view(); }
  std::uint64_t casters_hash() const {
    return terrain_->ground.view(shadow_view()).hash() ^ terrain_->ground.edits() * 0x9e3779b97f4a7c15ull;
  }

  // Whether the last tile that was asked for could not be read.
  bool failing() const { return exists() && terrain_->ground.counts().failing; }
  // Whether the last one that came found no room beside what is looked at.
  bool full() const { return exists() && terrain_->ground.counts().full; }

  struct Sum {
    double bound_px = 0;
    std::uint32_t lacking = 0;     // nodes that should be split and lack a tile
    std::uint32_t lacks_room = 0;  // and that lack a family
    std::uint32_t left_out = 0;    // of those that lack a tile, whose tile would come too late
    std::uint32_t sizes_left_out = 0;
    std::uint32_t triangles = 0, drawn = 0, culled = 0, visited = 0;
  };
  Sum sum(std::size_t view) const;

  // How many times as large as asked for errors are aimed at, for want of families; of the next frame, where
  // it does not wait.
  double error_scale() const { return error_scale_; }
  // The error that a view aims at, as a share of the distance. In parallel views what is seen and what casts
  // have the same levels.
  float casters_stray(const ErrorScale& scale) const {
    if (scale.least_cos2 < 0 || !(scale.steps_per_step > 1)) return 0;
    return static_cast<float>(error_scale_) / (scale.steps_per_step - 1);
  }

 private:
  void complete_views(std::span<const ViewState> views, bool wait);
  void complete(std::size_t first, std::size_t end, bool all, bool wait);

  double error_scale_ = 1;
  TerrainParts* terrain_ = nullptr;
  Renderer* renderer_ = nullptr;
  const Inspection* inspection_ = nullptr;
  std::array<GroundRequest, karst::kMostViews + 1> requests_{};
  bool all_ = true;  // is asked for, in this frame
};

}  // namespace karst::core
