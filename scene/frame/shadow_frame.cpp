// SPDX-License-Identifier: MIT
#include "scene/frame/shadow_frame.h"

#include <algorithm>

namespace karst::core {
namespace {

// The sun's disc has set, and its light is zero (renderer/passes/frame_block.cpp).
constexpr double kSunset = -1.5;  // degrees

// How far casters may stray (SelectCasters); and at most, where the pool has no room for better ones.
constexpr double kErrorTexels = 1;
// On a curved basis: how far mountains cast at most, times the ground's relief; a sun of 7 degrees.
constexpr double kShadowLengths = 8;
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

// What a shadow map's callback needs.
struct HostPass {
  const HostCasters* casters;
  double clip_from_world[16];
};

// From places less the eye, in the simulator's frame, to the map's clip space.
HostPass host_pass(const HostCasters& casters, const LightSpace& space, const Cascade& cascade) {
  HostPass pass{&casters, {}};
  const double depth = 2.0 / (space.near_z - space.far_z);
  const glm::dvec3 rows[3] = {space.x * (2.0 / cascade.side), space.y * (2.0 / cascade.side),
                              space.z * -depth};
  const double moved[3] = {
      (glm::dot(space.x, casters.eye_voxels) - cascade.low.x) * (2.0 / cascade.side) - 1.0,
      (glm::dot(space.y, casters.eye_voxels) - cascade.low.y) * (2.0 / cascade.side) - 1.0,
      (space.near_z - glm::dot(space.z, casters.eye_voxels)) * depth - 1.0};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      pass.clip_from_world[column * 4 + row] = glm::dot(rows[row], casters.voxels_from_sim[column]);
    }
    pass.clip_from_world[12 + row] = moved[row];
  }
  pass.clip_from_world[15] = 1.0;
  return pass;
}

}  // namespace

void ShadowFrame::create(TerrainParts& terrain, Renderer& renderer, VertexWork& work, GroundFrame& ground,
                         MeshFrame& meshes, const CascadeSettings& settings) {
  terrain_ = &terrain;
  renderer_ = &renderer;
  work_ = &work;
  ground_ = &ground;
  meshes_ = &meshes;
  settings_ = settings;
  forget();
}

// What may cast within reach of the eye on a curved basis: all of a planet would leave depth no precision.
LatticeBox ShadowFrame::box_around(const Camera& camera) const {
  const GroundInfo& info = terrain_->ground.info();
  const double relief = (static_cast<double>(info.high) - info.low) * kVertexStep;
  const double reach = settings_.reach_voxels * kStepsPerVoxel + kShadowLengths * relief;
  constexpr double kMost = 1 << 30;
  const LatticeBox all = terrain_->world.box();
  const glm::dvec3 eye = eye_lattice(camera);
  const glm::dvec3 low = glm::clamp(eye - reach, glm::dvec3(all.min), glm::dvec3(all.max));
  const glm::dvec3 high = glm::clamp(eye + reach, glm::dvec3(all.min), glm::dvec3(all.max));
  return {glm::ivec3(glm::clamp(low, -kMost, kMost)), glm::ivec3(glm::clamp(high, -kMost, kMost))};
}

void ShadowFrame::forget() {
  for (Map& map : maps_) map = {};
  count_ = 0;
}

bool ShadowFrame::casts(const FrameLight& light) const {
  return settings_.count > 0 && !(light.sun_elevation_deg < kSunset);
}

Status ShadowFrame::run(const Input& input, FrameCosts& costs, std::uint32_t& limits) {
  count_ = 0;
  const int count = settings_.count;
  if (!casts(input.light)) {
    costs.cascades_skipped += static_cast<std::uint32_t>(count);
    return {};
  }
  FitCascades fit;
  fit.settings = settings_;
  fit.camera = input.camera;
  fit.to_sun = light_direction(input.light);
  fit.world = terrain_->world.box();
  if (ground_->is_curved()) fit.world = box_around(*input.camera);
  fit.light = &light_space_;
  fit.cascades = cascades_;
  if (const Status status = fit.validate(); !status.ok()) return status;
  fit.run();
  count_ = static_cast<std::size_t>(count);
  if (input.wait) {
    // A coarse version of all that may cast, before any of it takes room for detail.
    if (const Status status = work_->make_bases(costs); !status.ok()) return status;
  }
  for (int n = 0; n < count; ++n) {
    const Cascade* const smaller = n > 0 ? &cascades_[static_cast<std::size_t>(n) - 1] : nullptr;
    const Cascade& cascade = cascades_[static_cast<std::size_t>(n)];
    const bool seen = ground_->exists() || meshes_->exists() ||
                      std::any_of(input.views.begin(), input.views.end(), [&](const ViewState& view) {
                        return has_receivers(terrain_->world, view.items(), cascade, smaller);
                      });
    // The host's own things may lie where no terrain is seen.
    if (input.skip && !seen && input.casters.draw == nullptr) {
      ++costs.cascades_skipped;
      continue;
    }
    if (const Status status = draw_map(input, n, costs, limits); !status.ok()) return status;
  }
  return {};
}

std::uint32_t ShadowFrame::version(const Input& input) const {
  const ViewState& view = input.views[input.view];
  return terrain_->residency.thresholds().version(view.threshold_set());
}

// Whether a map shows what it would show if it were drawn now. While the pool is too small for the views, the
// error that is aimed at changes, and thresholds with it: within a factor of two the map stays.
bool ShadowFrame::is_current(const Input& input, const Map& map, const Cascade& cascade) const {
  if (!map.drawn || !map.complete || !map.cascade.same_as(cascade)) return false;
  if (map.thresholds == version(input)) return true;
  const ViewState& view = input.views[input.view];
  const ErrorScale& now = view.error_scale();
  if (view.selection().error_scale == 1.0f || now.pixels != map.scale.pixels) return false;
  const float ratio = now.steps_per_step / map.scale.steps_per_step;
  return ratio > 0.5f && ratio < 2.0f;
}

Status ShadowFrame::make_casters(const Input& input, std::int64_t start, FrameCosts& costs) {
  PatchUpload upload;
  Status status;
  if (work_->rests()) return {};
  while (status.ok() && (input.wait || ms_since(start) < input.work_ms) &&
         terrain_->casters.generate_next(terrain_->residency, upload, status)) {
    status = work_->upload(upload);
    ++costs.generated;
  }
  return status.ok() ? status : work_->judge(status);
}

// Makes what casters lack. Where there is no room for it they may stray further: twice as far until there is.
Status ShadowFrame::complete_casters(const Input& input, Map& map, const Cascade& cascade,
                                     std::uint32_t parts, ShadowCasters::Result& casters, FrameCosts& costs,
                                     std::uint32_t& limits) {
  const std::int64_t start = clock_ns();
  const ViewState& view = input.views[input.view];
  const auto select = [&] {
    return terrain_->casters.select(terrain_->world, terrain_->residency, view, cascade, map.error_texels,
                                    parts, casters);
  };
  Status status;
  bool has_time = true;
  while (casters.lacking > 0 && has_time) {
    status = make_casters(input, start, costs);
    if (status.ok() && input.wait) {
      // With nothing in flight, what patches give up is free at once.
      renderer_->finish();
      terrain_->residency.release_kept_pages();
      status = make_casters(input, start, costs);
    }
    if (!status.ok()) break;
    has_time = input.wait || ms_since(start) < input.work_ms;
    status = select();
    if (!status.ok() || casters.lacking == 0 || !has_time || work_->rests()) break;
    limits |= kLimitVertexMemory;
    if (map.error_texels >= kMostErrorTexels) break;
    map.error_texels *= 2;
    status = select();
    if (!status.ok()) break;
  }
  if (!has_time && casters.lacking > 0) limits |= kLimitWork;
  costs.generate_ms += ms_since(start);
  return status;
}

Status ShadowFrame::draw_map(const Input& input, int index, FrameCosts& costs, std::uint32_t& limits) {
  const Cascade& cascade = cascades_[static_cast<std::size_t>(index)];
  Map& map = maps_[static_cast<std::size_t>(index)];
  const bool host_moved = input.casters.draw != nullptr && input.casters.moved;
  // What casts of it is the frame's choice, whichever that is.
  const Isosurface::List mesh_casters = meshes_->casters(cascade);
  const std::uint64_t mesh_hash = mesh_casters.hash;
  if (input.skip && !host_moved && map.meshes == mesh_hash && is_current(input, map, cascade)) {
    ++costs.cascades_skipped;
    return {};
  }
  const ViewState& view = input.views[input.view];
  const bool same_box = input.skip && map.drawn && map.cascade.same_as(cascade);
  if (!same_box) map.error_texels = std::max(map.error_texels / 2, kErrorTexels);
  const double texel_steps = kErrorTexels * cascade.texel * kStepsPerVoxel;
  // Far away the ground casts where a region is, and alone until its patches are there.
  bool whole_ground =
      ground_->select_casters(view, cascade, texel_steps, GroundFrame::kAllParts, input.wait, costs);
  ShadowCasters::Result casters;
  Status status;
  std::uint32_t parts = ground_->parts_drawn(ground_->shadow_view());
  while (parts != 0) {
    const std::int64_t casters_start = clock_ns();
    status = terrain_->casters.select(terrain_->world, terrain_->residency, view, cascade, map.error_texels,
                                      parts, casters);
    costs.select_ms += ms_since(casters_start);
    if (status.ok() && casters.lacking > 0) {
      status = complete_casters(input, map, cascade, parts, casters, costs, limits);
    }
    if (status.code() == StatusCode::limit_reached) {
      limits |= kLimitDrawItems;
      status = {};
    }
    if (!status.ok()) return status;
    casters.whole_parts |= ground_->mesh_part();
    if (!ground_->exists() || (parts & ~casters.whole_parts) == 0) break;
    whole_ground =
        ground_->select_casters(view, cascade, texel_steps, parts & casters.whole_parts, input.wait, costs);
    parts = ground_->parts_drawn(ground_->shadow_view());
  }
  if (parts == 0) casters.items = {};
  const std::uint64_t ground_hash = ground_->exists() ? ground_->casters_hash() : 0;
  map.complete = casters.lacking == 0 && whole_ground;
  map.thresholds = version(input);
  map.scale = view.error_scale();
  if (same_box && !host_moved && map.casters == casters.hash && map.ground == ground_hash &&
      map.meshes == mesh_hash) {
    ++costs.cascades_skipped;
    return {};
  }
  const std::int64_t listed = clock_ns();
  if (status = work_->upload_morph_rows(costs); !status.ok()) return status;
  if (status = ground_->upload(costs); !status.ok()) return status;
  CascadeInput pass;
  pass.cascade = cascade;
  const std::size_t own_view = ground_->shadow_view();
  pass.items = casters.items;
  pass.pages = terrain_->residency.pages();
  pass.index_table = terrain_->world.index_table();
  pass.max_level = terrain_->world.info().level;
  pass.first_morph_row = terrain_->residency.first_morph_row(view);
  if (ground_->exists()) {
    ground_->build_belts(own_view, casters.levels);
    pass.nodes = ground_->nodes(own_view);
    pass.belts = ground_->belts(own_view);
    pass.first_family_row = ground_->first_row(own_view);
    pass.foot = ground_->foot();
    if (ground_->is_curved()) pass.level = ground_->level(cascade.eye).view;
    pass.pages.family_texels = terrain_->ground.texels();
    pass.pages.family_places = terrain_->ground.places();
  }
  if (meshes_->exists()) {
    if (ground_->draws_meshes(parts)) pass.meshes = mesh_casters.items;
    pass.mesh_pages = meshes_->pages();
    pass.pages.mesh_texels = meshes_->texels();
  }
  HostPass host = host_pass(input.casters, light_space_, cascade);
  if (input.casters.draw != nullptr) {
    pass.draw_more = [](void* user) {
      const auto* own = static_cast<const HostPass*>(user);
      own->casters->draw(own->casters->user, own->clip_from_world, own->casters->eye);
    };
    pass.user = &host;
  }
  status = renderer_->draw_cascade(index, pass);
  ++costs.cascades_drawn;
  costs.shadow_triangles += casters.triangles + ground_->sum(ground_->shadow_view()).triangles +
                            (ground_->draws_meshes(parts) ? mesh_casters.triangles : 0);
  costs.submit_ms += ms_since(listed);
  map.drawn = status.ok();
  map.cascade = cascade;
  map.casters = casters.hash;
  map.ground = ground_hash;
  map.meshes = mesh_hash;
  return status;
}

}  // namespace karst::core
