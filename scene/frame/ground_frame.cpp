// SPDX-License-Identifier: MIT
#include "scene/frame/ground_frame.h"

#include <algorithm>

#include "scene/frame/vertex_work.h"

namespace karst::core {
namespace {

// A frame that waits gives up after so many rounds of asking: more than tiles can be deep.
constexpr int kMostRounds = 4 * kMostSize;

}  // namespace

void GroundFrame::create(TerrainParts& terrain, Renderer& renderer, const Inspection& inspection) {
  terrain_ = &terrain;
  renderer_ = &renderer;
  inspection_ = &inspection;
}

void GroundFrame::begin_frame(double work_ms, FrameCosts& costs) {
  if (!exists()) return;
  const std::int64_t start = clock_ns();
  Ground& ground = terrain_->ground;
  ground.begin_frame();
  const OwnWork own(*inspection_);
  while (ground.poll(true) > 0 && ms_since(start) < work_ms) {
  }
  costs.generate_ms += ms_since(start);
}

// Selects views first .. end - 1 and asks for what they lack; with wait again and again.
void GroundFrame::complete(std::size_t first, std::size_t end, bool wait) {
  Ground& ground = terrain_->ground;
  const OwnWork own(*inspection_);
  for (int round = 0; round < kMostRounds; ++round) {
    std::uint32_t lacking = 0;
    for (std::size_t v = first; v < end; ++v) {
      ground.select(v, requests_[v]);
      lacking += ground.view(v).result().lacks_tile;
    }
    ground.ask();
    if (!wait || lacking == 0 || !ground.wait()) return;
    if (ground.poll() == 0 && ground.counts().under_way == 0) return;  // nothing can be read, or finds room
  }
}

void GroundFrame::select(std::span<const ViewState> views, std::span<const ViewRequest> requests, bool wait,
                         FrameCosts& costs) {
  if (!exists()) return;
  const std::int64_t start = clock_ns();
  const bool has_patches = terrain_->world.patch_count() > 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    GroundRequest& request = requests_[v];
    request = {};
    request.camera = requests[v].camera;
    request.scale = views[v].error_scale();
    request.error_px = views[v].settings().error_px;
    const LodSettings& lod = views[v].settings();
    request.morphing = lod.mode != LodMode::full;
    // As K's patches: one whose side is a node's is at the node's level from half of that distance on.
    if (lod.mode == LodMode::distance) request.sides_away = std::max(lod.distance_voxels, 1e-3) / 4;
    request.culls = requests[v].frustum_culling;
    // All patches that are in view are listed; bound_px is 0 where none could be.
    const ViewState::Selection& selection = views[v].selection();
    request.has_region = has_patches && selection.lod.bound_px > 0 && selection.lod.missing == 0 &&
                         selection.list.dropped == 0;
  }
  complete(0, views.size(), wait);
  costs.select_ms += ms_since(start);
}

bool GroundFrame::select_casters(const ViewState& view, const Cascade& cascade, double texel, bool has_region,
                                 bool wait, FrameCosts& costs) {
  if (!exists()) return true;
  const std::int64_t start = clock_ns();
  GroundRequest& request = requests_[shadow_view()];
  request = {};
  request.camera = &cascade.eye;
  request.scale = view.error_scale();
  request.scale.least_cos2 = cascade.least_cos2;
  request.error_px = view.settings().error_px;
  request.morphing = view.settings().mode != LodMode::full;
  request.frustum = &cascade.frustum;
  request.spared_error = static_cast<float>(texel);
  request.has_region = has_region;
  complete(shadow_view(), shadow_view() + 1, wait);
  costs.select_ms += ms_since(start);
  return terrain_->ground.view(shadow_view()).result().lacks_tile == 0;
}

Status GroundFrame::upload(FrameCosts& costs) {
  if (!exists()) return {};
  const std::int64_t start = clock_ns();
  Ground& ground = terrain_->ground;
  PageTable pages = terrain_->residency.pages();
  pages.family_texels = ground.texels();
  NodeUpload node;
  while (ground.next_node(node)) {
    NodePage page;
    page.origin = node.origin;
    page.size = node.size;
    page.quadrant = node.quadrant;
    page.row = node.row;
    if (const Status status =
            renderer_->upload_node(pages, node.page, page, node.vertices.first<kNodePageVertices>());
        !status.ok()) {
      return status;
    }
    ++costs.generated;
  }
  for (std::size_t v = 0; v <= shadow_view(); ++v) {
    for (MorphRows rows; !(rows = ground.take_rows(v)).halves.empty();) {
      const std::uint32_t first = first_row(v) + rows.first_row;
      if (const Status status = renderer_->upload_morph_rows(first, rows.halves); !status.ok()) return status;
      costs.morph_bytes += rows.halves.size_bytes();
    }
  }
  costs.upload_ms += ms_since(start);
  return {};
}

void GroundFrame::build_belts(std::size_t view, std::span<const std::uint8_t> levels) {
  if (!exists()) return;
  ResidentPool& pool = terrain_->residency.pool();
  BuildBelts belts;
  belts.rim = &terrain_->world.rim();
  belts.levels = levels;
  belts.resident = pool.levels();
  belts.pages = pool.pages();
  belts.first_node_page = renderer_->settings().vertex_pages;
  terrain_->ground.build_belts(view, belts);
  if (terrain_->ground.belts(view).empty()) return;
  // The GPU reads vertices of patches that are out of view, too: they must not be given to others.
  for (const RegionRim::Edge& edge : belts.rim->edges()) {
    const PatchId patch = edge.edge.patch();
    const int level = std::min<int>(levels[patch], pool.level(patch));
    if (level > 0) pool.see(patch, level);
  }
}

GroundFrame::Sum GroundFrame::sum(std::size_t view) const {
  if (!exists()) return {};
  const GroundView::Result& result = terrain_->ground.view(view).result();
  return {double{result.bound_px}, result.lacks_tile, result.lacks_room, result.triangles, result.drawn,
          result.culled,           result.visited};
}

}  // namespace karst::core
