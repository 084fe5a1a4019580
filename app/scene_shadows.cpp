// SPDX-License-Identifier: MIT
// The shadow maps of a frame: which of them have to be drawn anew, and with what.
#include "app/scene.h"
#include "platform/clock.h"

namespace karst::app {
namespace {

// The sun's disc has set, and its light is zero (renderer/frame_block.cpp).
constexpr double kSunset = -1.5;  // degrees

// Whether pixels of the patches listed can lie in the cascade's box and not in a smaller one's.
bool has_receivers(const Terrain& terrain, const Cascade& cascade, const Cascade* smaller) {
  for (const DrawItem& item : terrain.items()) {
    const LatticeBox box = patch_box(terrain.surface(), terrain.bounds(), item.patch);
    if (classify(cascade.frustum, box, kAllPlanes) == kOutside) continue;
    if (smaller == nullptr || classify(smaller->inner, box, kAllPlanes) != 0) return true;
  }
  return false;
}

}  // namespace

Status Scene::upload_morph_rows() {
  const MorphRows rows = terrain_.take_morph_rows();
  return rows.halves.empty() ? Status() : renderer_.upload_morph_rows(rows.first_row, rows.halves);
}

// until_ms: time to make vertices of patches that the picture does not show.
Status Scene::draw_shadows(const SceneView& view, double until_ms, FrameRecord& record) {
  cascade_count_ = 0;
  const int count = renderer_.settings().cascades;
  if (count == 0 || view.light.sun_elevation_deg < kSunset) {
    record.cascades_skipped = count;
    return {};
  }
  if (const Status status = view.light.validate(); !status.ok()) return status;
  FitCascades fit;
  fit.settings = options_.shadows;
  fit.camera = &view.camera;
  fit.to_sun = sun_direction(view.light);
  fit.world = terrain_.box();
  fit.light = &light_space_;
  fit.cascades = cascades_;
  if (const Status status = fit.validate(); !status.ok()) return status;
  fit.run();
  cascade_count_ = count;
  for (int n = 0; n < count; ++n) {
    const Cascade* smaller = n > 0 ? &cascades_[n - 1] : nullptr;
    if (view.cascade_caching && !has_receivers(terrain_, cascades_[n], smaller)) {
      ++record.cascades_skipped;
      continue;
    }
    if (const Status status = draw_cascade(n, until_ms, view.cascade_caching, record); !status.ok())
      return status;
  }
  return {};
}

Status Scene::draw_cascade(int index, double until_ms, bool caching, FrameRecord& record) {
  const Cascade& cascade = cascades_[index];
  ShadowMap& map = shadow_maps_[index];
  const bool same_box = caching && map.drawn && map.cascade.same_as(cascade);
  if (same_box && map.residency == terrain_.residency_version() &&
      map.thresholds == terrain_.thresholds_version()) {
    ++record.cascades_skipped;
    return {};
  }
  const std::int64_t start = now_ns();
  Terrain::Casters casters;
  Status status = terrain_.select_casters(cascade, casters);
  double making_ms = 0;
  if (casters.lacking > 0) {
    const std::int64_t selected = now_ns();
    PatchUpload upload;
    bool made = false;
    while (ms_between(start, now_ns()) < until_ms && terrain_.generate_next_caster(cascade, upload, status)) {
      status = renderer_.upload_vertices(terrain_.pages(), upload.patch,
                                         static_cast<std::uint32_t>(upload.first_vertex), upload.vertices,
                                         upload.origin, upload.row);
      if (!status.ok()) return status;
      made = true;
      ++record.generated;
    }
    making_ms = ms_between(selected, now_ns());
    if (made) status = terrain_.select_casters(cascade, casters);
  }
  if (status.code() == StatusCode::limit_reached) {
    record.flags |= kFlagDrawItems;
    status = {};
  }
  if (!status.ok()) return status;
  const std::int64_t listed = now_ns();
  record.generate_ms += making_ms;
  record.cull_lod_ms += ms_between(start, listed) - making_ms;
  map.residency = terrain_.residency_version();
  map.thresholds = terrain_.thresholds_version();
  if (same_box && map.casters == casters.hash) {
    ++record.cascades_skipped;
    return {};
  }
  if (status = upload_morph_rows(); !status.ok()) return status;
  CascadeInput input;
  input.cascade = cascade;
  input.items = casters.items;
  input.pages = terrain_.pages();
  input.index_table = terrain_.index_table();
  input.max_level = terrain_.info().level;
  status = renderer_.draw_cascade(index, input);
  record.submit_ms += ms_between(listed, now_ns());
  map.drawn = status.ok();
  map.cascade = cascade;
  map.casters = casters.hash;
  return status;
}

}  // namespace karst::app
