// SPDX-License-Identifier: MIT
#include "scene/frame/meshes/mesh_frame.h"

#include <limits>

#include "scene/frame/clock/own_work.h"

namespace karst::core {

void MeshFrame::create(TerrainParts& terrain, Renderer& renderer, const Inspection& inspection) {
  terrain_ = &terrain;
  renderer_ = &renderer;
  inspection_ = &inspection;
}

Status MeshFrame::run(std::span<const ViewRequest> requests, double work_ms, bool wait, FrameCosts& costs) {
  lists_ = {};
  bounds_px_ = {};
  if (!exists()) return {};
  const std::int64_t start = clock_ns();
  Isosurface& isosurface = terrain_->isosurface;
  std::array<BlockEye, kMostViews> eyes;
  std::array<ErrorScale, kMostViews> scales;
  std::array<Camera, kMostViews> cameras;  // as its region sees them
  for (std::size_t v = 0; v < requests.size(); ++v) {
    const ViewRequest& request = requests[v];
    cameras[v] = *request.camera;
    cameras[v].voxel -= terrain_->world.field_corner();
    scales[v] = make_error_scale(cameras[v], request.width_px, request.height_px, request.lod.error_px);
    eyes[v] = {make_lod_eye(cameras[v], scales[v].least_cos2), scales[v].steps_per_step};
    // All of it at its finest.
    if (request.lod.mode == LodMode::full) eyes[v].steps_per_step = std::numeric_limits<float>::infinity();
  }
  isosurface.begin_frame();
  const bool has_all = isosurface.drawn().size() > 0;
  if (wait || isosurface.is_complete()) isosurface.choose(std::span(eyes).first(requests.size()));
  costs.select_ms += ms_since(start);
  const std::int64_t makes = clock_ns();
  // Of an isosurface that is not there at all, everything is made at once.
  const auto has_time = [&] { return wait || !has_all || ms_since(makes) < work_ms; };
  PageTable pages = terrain_->residency.pages();
  pages.mesh_texels = texels();
  MeshUpload upload;
  Status status;
  for (bool retried = false; has_time();) {
    bool made = false;
    {
      const OwnWork own(*inspection_);
      made = isosurface.make_next(upload, status);
    }
    if (!status.ok()) return status;
    if (!made) {
      if (!isosurface.lacks_room() || isosurface.is_complete() || !wait || retried) break;
      // With nothing in flight, what meshes gave up is free at once.
      renderer_->finish();
      isosurface.release_kept();
      retried = true;
      continue;
    }
    retried = false;
    const MeshPage page{upload.first_page, upload.origin, upload.size};
    status = renderer_->upload_mesh(pages, this->pages(), page, upload.vertices);
    if (!status.ok()) return status;
    ++costs.generated;
  }
  costs.generate_ms += ms_since(makes);
  for (std::size_t v = 0; v < requests.size(); ++v) {
    const Frustum frustum = make_frustum(cameras[v]);
    lists_[v] = isosurface.list(v, requests[v].frustum_culling ? &frustum : nullptr);
    bounds_px_[v] = isosurface.bound_px(eyes[v].eye, scales[v].pixels);
  }
  return {};
}

Isosurface::List MeshFrame::casters(const Cascade& cascade) const {
  if (!exists()) return {};
  const Frustum frustum = frustum_from(terrain_->world.field_corner(), cascade.frustum);
  return terrain_->isosurface.list(terrain_->world.config().max_views, &frustum);
}

}  // namespace karst::core
