// SPDX-License-Identifier: MIT
// The shadow maps of a frame: which of them have to be drawn anew, and with what.
#include <algorithm>

#include "platform/base/clock.h"
#include "scene/scene.h"

namespace karst::app {
using namespace core;
namespace {

// The sun's disc has set, and its light is zero (renderer/input/frame_block.cpp).
constexpr double kSunset = -1.5;  // degrees

// How far casters may stray (SelectCasters); and at most, where the pool has no room for better ones.
constexpr double kErrorTexels = 1;
constexpr double kMostErrorTexels = 64;

// Whether pixels of the patches listed can lie in the cascade's box and not in a smaller one's.
bool has_receivers(const World& world, std::span<const DrawItem> items, const Cascade& cascade,
                   const Cascade* smaller) {
  for (const DrawItem& item : items) {
    const LatticeBox box = patch_box(world.surface(), world.bounds(), item.patch);
    if (classify(cascade.frustum, box, kAllPlanes) == kOutside) continue;
    if (smaller == nullptr || classify(smaller->inner, box, kAllPlanes) != 0) return true;
  }
  return false;
}

}  // namespace

Status Scene::upload_morph_rows() {
  Status status;
  for (MorphRows rows = residency().take_morph_rows(); !rows.halves.empty() && status.ok();
       rows = residency().take_morph_rows()) {
    status = renderer_.upload_morph_rows(rows.first_row, rows.halves);
  }
  return status;
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
  fit.world = world().box();
  fit.light = &light_space_;
  fit.cascades = cascades_;
  if (const Status status = fit.validate(); !status.ok()) return status;
  fit.run();
  cascade_count_ = count;
  if (until_ms == SceneView::kComplete) {
    // A coarse version of all that may cast, before any of it takes room for detail.
    if (const Status status = generate_bases(record); !status.ok()) return status;
  }
  for (int n = 0; n < count; ++n) {
    const Cascade* smaller = n > 0 ? &cascades_[n - 1] : nullptr;
    if (view.cascade_caching && !has_receivers(world(), eye().items(), cascades_[n], smaller)) {
      ++record.cascades_skipped;
      continue;
    }
    if (const Status status = draw_cascade(n, until_ms, view.cascade_caching, record); !status.ok())
      return status;
  }
  return {};
}

Status Scene::generate_bases(FrameRecord& record) {
  const std::int64_t start = now_ns();
  PatchUpload upload;
  Status status;
  while (status.ok() && residency().generate_base(upload, status)) {
    status = upload_patch(upload);
    ++record.generated;
  }
  record.generate_ms += ms_between(start, now_ns());
  return status;
}

// Makes vertices for casters, for as long as there is time and room; how many patches got some.
Status Scene::generate_casters(std::int64_t start, double until_ms, std::uint32_t& made) {
  PatchUpload upload;
  Status status;
  while (status.ok() && ms_between(start, now_ns()) < until_ms &&
         parts_.casters.generate_next(residency(), upload, status)) {
    status = upload_patch(upload);
    ++made;
  }
  return status;
}

// Makes what casters lack. Where there is no room for it they may stray further: twice as far until there is.
Status Scene::complete_casters(ShadowMap& map, const Cascade& cascade, double until_ms,
                               ShadowCasters::Result& casters, FrameRecord& record) {
  const std::int64_t start = now_ns();
  const bool all = until_ms == SceneView::kComplete;
  Status status;
  bool has_time = true;
  while (casters.lacking > 0 && has_time) {
    std::uint32_t made = 0;
    status = generate_casters(start, until_ms, made);
    if (status.ok() && all) {
      // With nothing in flight, what patches give up is free at once.
      renderer_.finish();
      residency().release_kept_pages();
      status = generate_casters(start, until_ms, made);
    }
    record.generated += made;
    if (!status.ok()) break;
    has_time = ms_between(start, now_ns()) < until_ms;
    status = parts_.casters.select(world(), residency(), eye(), cascade, map.error_texels, casters);
    if (!status.ok() || casters.lacking == 0 || !has_time) break;
    record.flags |= kFlagPool;
    if (map.error_texels >= kMostErrorTexels) break;
    map.error_texels *= 2;
    status = parts_.casters.select(world(), residency(), eye(), cascade, map.error_texels, casters);
    if (!status.ok()) break;
  }
  if (!has_time && casters.lacking > 0) record.flags |= kFlagGenerate;
  record.generate_ms += ms_between(start, now_ns());
  return status;
}

// Whether a map shows what it would show if it were drawn now. While the pool is too small for the view, the
// error that is aimed at swings, and thresholds with it: within a factor of two the map stays.
bool Scene::is_current(const ShadowMap& map, const Cascade& cascade) const {
  if (!map.drawn || !map.complete || !map.cascade.same_as(cascade)) return false;
  if (map.thresholds == residency().thresholds().version(eye().threshold_set())) return true;
  const ErrorScale& now = eye().error_scale();
  if (error_scale_ == 1.0f || now.pixels != map.scale.pixels) return false;
  const float ratio = now.steps_per_step / map.scale.steps_per_step;
  return ratio > 0.5f && ratio < 2.0f;
}

Status Scene::draw_cascade(int index, double until_ms, bool caching, FrameRecord& record) {
  const Cascade& cascade = cascades_[index];
  ShadowMap& map = shadow_maps_[index];
  error_scale_ = record.pool.error_scale;
  if (caching && is_current(map, cascade)) {
    ++record.cascades_skipped;
    return {};
  }
  const std::int64_t start = now_ns();
  const bool same_box = caching && map.drawn && map.cascade.same_as(cascade);
  if (!same_box) map.error_texels = std::max(map.error_texels / 2, kErrorTexels);
  ShadowCasters::Result casters;
  Status status = parts_.casters.select(world(), residency(), eye(), cascade, map.error_texels, casters);
  record.cull_lod_ms += ms_between(start, now_ns());
  if (status.ok() && casters.lacking > 0) status = complete_casters(map, cascade, until_ms, casters, record);
  if (status.code() == StatusCode::limit_reached) {
    record.flags |= kFlagDrawItems;
    status = {};
  }
  if (!status.ok()) return status;
  map.complete = casters.lacking == 0;
  map.thresholds = residency().thresholds().version(eye().threshold_set());
  map.scale = eye().error_scale();
  if (same_box && map.casters == casters.hash) {
    ++record.cascades_skipped;
    return {};
  }
  const std::int64_t listed = now_ns();
  if (status = upload_morph_rows(); !status.ok()) return status;
  CascadeInput input;
  input.cascade = cascade;
  input.first_morph_row = residency().first_morph_row(eye());
  input.items = casters.items;
  input.pages = residency().pages();
  input.index_table = world().index_table();
  input.max_level = world().info().level;
  status = renderer_.draw_cascade(index, input);
  record.shadow_triangles += casters.triangles;
  record.submit_ms += ms_between(listed, now_ns());
  map.drawn = status.ok();
  map.cascade = cascade;
  map.casters = casters.hash;
  return status;
}

}  // namespace karst::app
