// SPDX-License-Identifier: MIT
#include "scene/frame/renderer_object.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "gles_shaders/shader_texts.h"
#include "renderer/input/frame_block.h"
#include "renderer/input/surroundings_block.h"
#include "renderer/passes/terrain_pass.h"
#include "scene/frame/materials/upload_materials.h"

namespace karst {
namespace core {
namespace {

constexpr double kDegreesPerRadian = 180.0 / 3.14159265358979323846;
// -ln 0.05: where 5 % of the contrast is left, haze has gone so many times its own distance.
const double kVisibilityPerHaze = std::log(20.0);
// Without a visibility: haze takes 63 % of the light at so many times the world's width.
constexpr double kHazeWidths = 6.0;
// On a curved basis, whose width says nothing: metres.
constexpr double kCurvedHazeM = 60'000;
constexpr double kWhiteSunDeg = 45;
// That edits have touched and a frame with a limit of time makes; counted, so that frames of a replay are
// alike.
constexpr std::uint32_t kRemadePatches = 128;
// The same of regions that were made, of whose patches the coarsest levels are made.
constexpr std::uint32_t kBasePatches = 512;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

LodMode lod_mode(karst::LodMode mode) {
  switch (mode) {
    case karst::LodMode::distance:
      return LodMode::distance;
    case karst::LodMode::full:
      return LodMode::full;
    case karst::LodMode::error:
      break;
  }
  return LodMode::error;
}

}  // namespace

std::size_t renderer_object_bytes() {
  return sizeof(RendererObject);
}

Status RendererObject::open(const karst::GlLoader& loader, const GlOptions& options) {
  RendererSettings settings = world.layout.renderer;
  settings.first_unit = options.first_unit;
  settings.first_block = options.first_block;
  settings.desktop = options.desktop;
  settings.detail = options.detail;
  settings.water = world.terrain.world.surroundings().has_water();
  settings.patches = world.terrain.world.patch_count() > 0;
  settings.curved = world.terrain.world.ground().basis.is_curved();
  settings.precision = options.precision;
  settings.anisotropy = static_cast<int>(std::min(options.anisotropy, 255u));
  settings.shading = options.shading;
  settings.smooth_edges = options.smooth_edges;
  settings.share_depth = options.share_depth;
  settings.debug = options.debug;
  settings.timers = options.timers;
  settings.drape_repeat = options.drape_repeat;
  Gl table;
  if (const Status status = load_gl(loader, options.desktop, table); !status.ok()) return status;
  const Status created = gl.create(table, settings);
  if (gl.pending_error() != GL_NO_ERROR) {
    world.say(Severity::warning, "an OpenGL error of the host was pending; it was taken");
  }
  if (!created.ok()) {
    if (*gl.message() != '\0') world.say(Severity::error, gl.message());
    return created;
  }
  if (const Status status = upload_materials(world, gl); !status.ok()) return status;
  if (const Status status = upload_skies(); !status.ok()) return status;
  if (const Status status = surround(); !status.ok()) return status;
  CascadeSettings shadows;
  shadows.count = settings.cascades;
  shadows.size = settings.shadow_size;
  // As without a region, whose voxels are finer than four samples.
  const int finer = world.terrain.world.ground().lattice_size;
  const double reach_m = world.made_for.needs.shadow_reach_m;
  if (reach_m > 0) {
    shadows.reach_voxels = std::clamp(reach_m / world.shown.voxel_size_m, 4.0, 0x1p20);
  } else {
    shadows.reach_voxels = std::ldexp(shadows.reach_voxels, finer);
  }
  shadows.nearest_voxels = std::min(std::ldexp(shadows.nearest_voxels, finer), shadows.reach_voxels / 4);
  edit_version_ = world.editor.version;
  sky_version_ = world.editor.sky_version;
  work_.create(world.terrain, gl, inspection);
  ground_.create(world.terrain, gl, inspection);
  imagery_.create(world.terrain, gl, inspection);
  ahead_.create(world.terrain, inspection);
  meshes_.create(world.terrain, gl, inspection);
  shadows_.create(world.terrain, gl, work_, ground_, meshes_, shadows);
  forget_vertices();
  return {};
}

void RendererObject::forget_vertices() {
  world.terrain.residency.forget();
  ground_.forget();
  imagery_.forget();
  meshes_.forget();
  shadows_.forget();
  first_frame_ = true;
}

// Through the staging memory too.
Status RendererObject::surround() {
  const Surroundings& around = world.terrain.world.surroundings();
  surroundings_.world = around;
  surroundings_.voxel_size_m = world.shown.voxel_size_m;
  const GroundInfo& ground = world.terrain.world.ground();
  if (ground.exists()) {
    // Its walls end where it is lowest.
    const float low = static_cast<float>(ground.low) * kVertexStep / kStepsPerVoxel;
    // Of a curved basis the background has a plain of its own (FrameLevel).
    surroundings_.has_plain = !ground.basis.is_curved();
    surroundings_.curved = ground.basis.is_curved();
    surroundings_.world.plain_level = low;
    surroundings_.plain_albedo = level_ground(world.terrain.world.materials(), low);
    return {};
  }
  surroundings_.has_plain = around.rim_points > 0;
  if (!gl.settings().has_rim() || around.rim_points == 0) return {};
  const std::span<glm::ivec3> rim(std::launder(reinterpret_cast<glm::ivec3*>(world.staging.data())),
                                  around.rim_points);
  if (const Status status = world.terrain.world.read_rim(rim); !status.ok()) return status;
  // Its lowest point may be a stream's bed: the plain is of what lies at the rim on average.
  double height = 0;
  for (const glm::ivec3 point : rim) height += point.y;
  height /= static_cast<double>(rim.size()) * kStepsPerVoxel;
  surroundings_.plain_albedo = level_ground(world.terrain.world.materials(), static_cast<float>(height));
  return gl.upload_rim(rim, static_cast<std::int32_t>(around.plain_level * KARST_STEPS_PER_VOXEL));
}

Status RendererObject::take_views(const FrameInput& input) {
  if (input.views.empty() || input.views.size() > world.made_for.needs.views) {
    return refuse("not as many as the plan has, or none", "views");
  }
  if (input.shadow_view >= input.views.size()) return refuse("not one of the views", "shadow_view");
  if (!(input.work_ms >= 0)) return refuse("must not be negative", "work_ms");
  view_count_ = static_cast<std::uint32_t>(input.views.size());
  for (std::uint32_t n = 0; n < view_count_; ++n) {
    const karst::ViewState& view = input.views[n];
    if (const Status status = world.placement.make_camera(view, views_[n].camera); !status.ok())
      return status;
    constexpr auto kMost = static_cast<std::uint32_t>(RendererSettings::kMaxPicture);
    if (view.width_px < 1 || view.width_px > kMost) return refuse("not within 1..16384", "width_px");
    if (view.height_px < 1 || view.height_px > kMost) return refuse("not within 1..16384", "height_px");
    const glm::dvec3 motion = world.placement.world_direction(view.motion);
    if (view.has_motion && !(glm::length(motion) < kInfinite)) return refuse("not a finite motion", "motion");
    views_[n].motion.add(eye_lattice(views_[n].camera));
    motions_[n] =
        view.has_motion ? motion * (kStepsPerVoxel / world.shown.voxel_size_m) : views_[n].motion.a_frame();
    if (!(view.weight >= 1.0 / 64 && view.weight <= 64)) return refuse("not within 1/64..64", "weight");
    ViewRequest& request = requests_[n];
    request.camera = &views_[n].camera;
    request.lod.mode = lod_mode(inspection.lod);
    request.lod.max_level = static_cast<int>(world.made_for.needs.level);
    request.lod.resident_level = request.lod.max_level;
    request.lod.error_px = view.error_px;
    request.lod.distance_voxels = inspection.distance_voxels;
    request.weight = view.weight;
    request.width_px = static_cast<int>(view.width_px);
    request.height_px = static_cast<int>(view.height_px);
    request.frustum_culling = inspection.skip_frustum;
    request.backface_culling = inspection.skip_backface;
    request.occlusion_culling = inspection.skip_occluded;
    request.skipped_parts = ground_.parts_to_skip(n);
  }
  return {};
}

Status RendererObject::take_light(const Sun& sun, std::uint32_t shadow_view) {
  const glm::dvec3 towards = world.placement.world_direction(sun.towards);
  const double length = glm::length(towards);
  if (!std::isfinite(length) || !(length > 0)) return refuse("no direction", "towards");
  light_.sun_elevation_deg = std::asin(std::clamp(towards.y / length, -1.0, 1.0)) * kDegreesPerRadian;
  light_.sun_azimuth_deg = std::atan2(towards.x, -towards.z) * kDegreesPerRadian;
  light_.towards = glm::dvec3(0.0);
  const bool curved = world.terrain.world.ground().basis.is_curved();
  if (curved) {
    light_.towards = towards / length;
    const FrameLevel level = ground_.level(views_[shadow_view].camera);
    const double sine = glm::dot(light_.towards, glm::dvec3(level.up));
    // From above the air the sun is white and never sets.
    const double seen = std::asin(std::clamp(sine, -1.0, 1.0)) * kDegreesPerRadian;
    light_.sun_elevation_deg = kWhiteSunDeg + double{level.sky} * (seen - kWhiteSunDeg);
  }
  if (!(sun.visibility_m >= 0)) return refuse("must not be negative", "visibility_m");
  const LatticeBox box = world.terrain.world.box();
  const glm::dvec3 size = (glm::dvec3(box.max) - glm::dvec3(box.min)) / static_cast<double>(kStepsPerVoxel);
  const double standard = curved ? kCurvedHazeM / world.shown.voxel_size_m
                                 : std::max(1.0, kHazeWidths * std::max(size.x, size.z));
  light_.haze_voxels =
      sun.visibility_m == 0 ? standard : sun.visibility_m / world.shown.voxel_size_m / kVisibilityPerHaze;
  if (!light_.validate().ok()) return refuse("beyond its range", "visibility_m");
  return {};
}

Status RendererObject::upload_skies() {
  const core::World& terrain = world.terrain.world;
  gl.set_sky(terrain.sky_atlas());
  for (std::size_t n = 0; n < terrain.parts().size(); ++n) {
    // Of a ground that was not dug yet there are no voxels.
    if (terrain.ground().can_be_dug && n >= terrain.ground().regions().size()) continue;
    if (const Status status = gl.upload_sky(*terrain.parts()[n].sky, n); !status.ok()) return status;
  }
  return {};
}

// What edits have changed since the last frame, all of it: no frame shows a part of an edit. What they left
// for later takes half the time of frames without one; without a limit it is done at once.
Status RendererObject::follow_edits(double work_ms) {
  EditorObject& editor = world.editor;
  const bool edited = edit_version_ != editor.version;
  if (first_frame_ || work_ms == 0) {
    editor.settle(kInfinite);
  } else if (!edited) {
    editor.settle(work_ms / 2);
  }
  if (sky_version_ != editor.sky_version) {
    if (const Status status = upload_skies(); !status.ok()) return status;
    sky_version_ = editor.sky_version;
  }
  if (const Status status = show_paint(world, gl); !status.ok()) return status;
  if (editor.shape_version > edit_version_) shadows_.forget();
  const bool at_once = first_frame_ || work_ms == 0;
  if (const Status status = work_.remake(at_once ? VertexWork::kAllPatches : kRemadePatches, costs);
      !status.ok())
    return status;
  // A region with a patch that lacks vertices would close. One that was just made is drawn when it has all.
  if (world.terrain.world.ground().region_count > 0) {
    const std::uint32_t fresh = world.terrain.residency.fresh_parts();
    if (const Status status = work_.make_bases(costs, at_once ? VertexWork::kAllPatches : kBasePatches);
        !status.ok())
      return status;
    if (world.terrain.residency.fresh_parts() != fresh) shadows_.forget();
  }
  edit_version_ = editor.version;
  return {};
}

Status RendererObject::select(bool cuts) {
  const std::int64_t start = clock_ns();
  Status status;
  {
    const OwnWork own(inspection);
    status = world.terrain.residency.select(world.terrain.views_of(view_count_),
                                            std::span(requests_).first(view_count_), cuts);
  }
  costs.select_ms += ms_since(start);
  if (status.code() == StatusCode::limit_reached) {
    limits_ |= kLimitDrawItems;
    status = {};
  }
  return status;
}

// Until the frame lacks nothing that can be made: what is made changes what neighbours may show, and a pool
// that is full changes the error that is aimed at. cuts: of the select() before it.
Status RendererObject::complete(bool cuts) {
  constexpr int kMostRounds = 64;
  Residency& residency = world.terrain.residency;
  for (int round = 0; round < kMostRounds; ++round) {
    std::uint32_t made = 0;
    if (const Status status = work_.make(VertexWork::kNoLimit, false, costs, made); !status.ok())
      return status;
    if (!cuts && residency.complete_selection()) return {};
    if (work_.rests()) return select(true);
    std::uint32_t capped = 0;
    for (const ViewState& view : world.terrain.views_of(view_count_)) capped += view.selection().lod.capped;
    const Governor::State& governor = residency.governor();
    const bool waiting = capped > 0 && residency.pool().kept_back() > 0;
    if (!cuts && waiting && !governor.pool_full && round == 0) {
      // With nothing in flight, what patches gave up is free at once.
      gl.finish();
      residency.retry_lacking();
      continue;
    }
    // A scale that falls can wait for the next frame.
    if ((cuts || capped == 0) && made == 0 && !waiting && governor.next_error_scale <= governor.error_scale) {
      return {};
    }
    cuts = true;
    if (waiting) {
      gl.finish();
      for (std::uint32_t i = 0; i < kFramesInFlight; ++i) residency.begin_frame();
    }
    if (const Status status = select(cuts); !status.ok()) return status;
  }
  return {};
}

// What the views list, and what any of their patches needs of shading.
void RendererObject::count_views() {
  costs.left_out = imagery_.left_out();
  const std::span<const PatchShading> shading = world.terrain.residency.shading();
  for (std::uint32_t n = 0; n < view_count_; ++n) {
    const ViewState& view = world.terrain.views[n];
    views_[n].shading = 0;
    for (const DrawItem& item : view.items()) {
      const unsigned own = shading[item.patch].needs;
      views_[n].shading |= own;
      costs.blend_skipped += (own & kShadeBlend) == 0;
      costs.cave_skipped += (own & kShadeCave) == 0;
    }
    const BuildDrawList::Result& list = view.selection().list;
    costs.patches_drawn += list.drawn;
    for (std::size_t part = 0; requests_[n].skipped_parts >> part != 0; ++part) {
      if ((requests_[n].skipped_parts >> part & 1u) != 0)
        costs.patches_skipped += world.terrain.world.parts()[part].patches();
    }
    costs.culled_frustum += list.culled_frustum;
    costs.culled_backface += list.culled_backface;
    costs.culled_occluded += list.culled_occluded;
    costs.patches_missing += view.selection().lod.missing;
    costs.patches_capped += view.selection().lod.capped;
    for (int level = 1; level <= kMaxLevel; ++level) costs.at_level[level] += list.at_level[level];
    const GroundFrame::Sum ground = ground_.sum(n);
    costs.nodes_drawn += ground.drawn;
    costs.culled_frustum += ground.culled;
    costs.left_out += ground.left_out;
    costs.sizes_left_out = std::max(costs.sizes_left_out, ground.sizes_left_out);
    if (ground.drawn > 0) views_[n].shading |= kShadeBlend;
    if (!ground_.draws_meshes(ground_.parts_drawn(n))) meshes_.leave_out(n);
    if (!meshes_.list(n).items.empty()) views_[n].shading |= kShadeBlend;
    costs.culled_frustum += meshes_.list(n).culled;
    costs.blocks_drawn += static_cast<std::uint32_t>(meshes_.list(n).items.size());
  }
}

void RendererObject::fill_result(FrameResult& result) {
  const Governor::State& governor = world.terrain.residency.governor();
  result = {};
  std::uint32_t without_room = 0;
  for (std::uint32_t n = 0; n < view_count_; ++n) {
    const ViewState& view = world.terrain.views[n];
    result.error_px[n] = static_cast<double>(view.selection().lod.bound_px);
    result.lacking += view.selection().lod.capped;
    result.triangles += view.selection().list.triangles;
    const GroundFrame::Sum ground = ground_.sum(n);
    result.error_px[n] = std::max(result.error_px[n], ground.bound_px);
    result.lacking += ground.lacking;
    if (ground_.full()) without_room += ground.lacking;
    result.triangles += ground.triangles;
    if (ground_.exists()) result.triangles += ground_.belts(n).size() / 3;
    if (ground.lacks_room > 0) limits_ |= kLimitVertexMemory;
    result.error_px[n] = std::max(result.error_px[n], double{meshes_.bound_px(n)});
    result.triangles += meshes_.list(n).triangles;
  }
  result.lacking += imagery_.lacking();
  if (imagery_.full()) without_room += imagery_.lacking();
  if (governor.pool_full || meshes_.full() || ground_.error_scale() > 1) limits_ |= kLimitVertexMemory;
  result.lacking += meshes_.lacking();
  if (without_room > 0) limits_ |= kLimitTiles;
  if ((work_.failing() || ground_.failing() || imagery_.failing()) &&
      (result.lacking > 0 || costs.patches_missing > 0)) {
    limits_ |= kLimitFile;
  } else if (result.lacking > without_room && !governor.pool_full) {
    limits_ |= kLimitWork;
  }
  // Hosts that draw when something changed draw on until edits are measured.
  const Residency& residency = world.terrain.residency;
  if (!world.editor.is_settled() || residency.has_plain() || residency.fresh_parts() != 0)
    limits_ |= kLimitWork;
  result.made = costs.generated + made_;
  result.limits = limits_;
  const bool unread = (limits_ & kLimitFile) != 0;
  result.complete = !unread && (result.lacking == without_room || (governor.pool_full && result.made == 0));
  costs.error_scale = std::max(governor.error_scale, static_cast<float>(ground_.error_scale()));
  costs.wanted_pages = governor.wanted_pages;
  costs.resident = world.terrain.residency.pool().resident();
}

Status RendererObject::begin(const FrameInput& input, FrameResult& result) {
  costs = {};
  limits_ = 0;
  if (const Status status = take_views(input); !status.ok()) return status;
  if (const Status status = take_light(input.sun, input.shadow_view); !status.ok()) return status;
  Residency& residency = world.terrain.residency;
  ShadingSkips skips;
  skips.material = inspection.skip_material;
  skips.cave = inspection.skip_cave;
  if (const Status status = residency.set_shading_skips(skips); !status.ok()) return status;
  residency.begin_frame();
  if (const Status status = follow_edits(input.work_ms); !status.ok()) return status;
  work_.begin_frame(input.work_ms > 0);
  const bool waits = first_frame_ || input.work_ms == 0;
  work_ms_ = input.work_ms;
  // Where memory suffices, what lacks is made before anything is drawn, and need not be cut before.
  const bool cuts = !waits || residency.governor().pool_full;
  Status status;
  // A region is drawn whole or not at all: with a coarse version of all its patches, which stays, an eye that
  // turns in a cave always sees it.
  if (first_frame_ && world.terrain.world.ground().region_count > 0) status = work_.make_bases(costs);
  if (status.ok()) status = select(cuts);
  if (status.ok() && waits) status = complete(cuts);
  first_frame_ = first_frame_ && !status.ok();
  if (!status.ok()) return status;
  ground_.begin_frame(input.work_ms, costs);
  const std::span<const ViewRequest> requests = std::span(requests_).first(view_count_);
  // Before the ground, which stands for a region whose meshes are not there.
  if (status = meshes_.run(requests, input.work_ms, waits, costs); !status.ok()) return status;
  std::span<const glm::dvec3> motions;
  if (!waits && inspection.read_ahead) motions = std::span(motions_).first(view_count_);
  ground_.select(world.terrain.views_of(view_count_), requests, motions, waits, shadows_.casts(light_),
                 costs);
  if (ground_.lacks_skipped(requests)) {
    for (ViewRequest& request : requests_) request.skipped_parts = 0;
    status = select(cuts);
    if (status.ok() && waits) status = complete(cuts);
    if (!status.ok()) return status;
    ground_.select(world.terrain.views_of(view_count_), requests, motions, waits, shadows_.casts(light_),
                   costs);
  }
  // As heights that cannot be read: an error where the frame had to be complete.
  if (input.work_ms == 0 && ground_.failing()) return world.tiles.trouble();
  status = imagery_.run(ground_, requests, motions, input.work_ms, waits, costs);
  if (!status.ok()) return status;
  if (input.work_ms == 0 && imagery_.failing()) return world.tiles.trouble();
  if (!motions.empty()) ahead_.run(ground_, requests, motions, costs);
  ahead_.count(costs);
  if (status = ground_.upload(costs); !status.ok()) return status;
  ShadowFrame::Input shadow;
  shadow.views = world.terrain.views_of(view_count_);
  shadow.view = input.shadow_view;
  shadow.camera = &views_[input.shadow_view].camera;
  shadow.light = light_;
  shadow.skip = inspection.skip_cascades;
  shadow.wait = waits;
  shadow.work_ms = input.work_ms;
  shadow.casters = {input.draw_casters,
                    input.user,
                    input.casters_moved,
                    input.views[input.shadow_view].eye,
                    eye_lattice(*shadow.camera) / static_cast<double>(kStepsPerVoxel),
                    world.placement.world_from_sim() / world.shown.voxel_size_m};
  if (inspection.wait_for_gpu) gl.finish();
  const std::int64_t shadows_start = clock_ns();
  if (status = shadows_.run(shadow, costs, limits_); !status.ok()) return status;
  if (input.work_ms == 0 && ground_.failing()) return world.tiles.trouble();
  if (inspection.wait_for_gpu) gl.finish();
  costs.shadow_ms = ms_since(shadows_start);
  if (status = work_.upload_morph_rows(costs); !status.ok()) return status;
  for (std::uint32_t n = 0; n < view_count_; ++n) ground_.build_belts(n, world.terrain.views[n].levels());
  count_views();
  for (std::uint32_t n = 0; n < view_count_; ++n) {
    glm::dmat3 axes = world.placement.world_from_sim() / world.shown.voxel_size_m;
    shader::FrameBlock block = block_of(n);
    if (ground_.is_curved()) {
      // The host's shaders take y for up: theirs are the axes at the eye.
      const glm::dmat3 here = ground_.axes(views_[n].camera);
      axes = glm::transpose(here) * axes;
      for (glm::vec4* v :
           {&block.sun_direction, &block.ray_forward, &block.shadow_x, &block.shadow_y, &block.shadow_z})
        *v = glm::vec4(glm::vec3(glm::transpose(here) * glm::dvec3(*v)), v->w);
    }
    if (status = gl.set_air(n, make_air_block(block, glm::mat4(glm::mat3(axes)))); !status.ok())
      return status;
  }
  fill_result(result);
  made_ = 0;
  return {};
}

shader::FrameBlock RendererObject::block_of(std::uint32_t n) const {
  const ViewState& view = world.terrain.views[n];
  shader::FrameBlock block = make_frame_block(views_[n].camera, view.error_scale().least_cos2, light_,
                                              gl.settings().sky, requests_[n].height_px);
  set_cascades(views_[n].camera, shadows_.light_space(), shadows_.cascades(), gl.settings().shadow_size,
               block);
  block.shadow_x.w = ground_.casters_stray(view.error_scale());
  set_surroundings(views_[n].camera, surroundings_, block);
  return block;
}

Status RendererObject::end() {
  const FrameCounts counts = gl.end_frame();
  costs.draw_calls = counts.draw_calls;
  costs.triangles = counts.triangles;
  costs.uploaded_bytes = counts.uploaded_bytes;
  costs.vertices_lost = counts.vertices_lost;
  costs.gpu_terrain_ms = gl.terrain_gpu_ms();
  costs.gpu_shadow_ms = gl.shadow_gpu_ms();
  if (counts.vertices_lost) {
    forget_vertices();
    return {};
  }
  // What the next frames need is made while the GPU draws this one.
  if (work_ms_ == 0) return {};
  return work_.make(work_ms_, true, costs, made_);
}

Air RendererObject::air_of(std::uint32_t n) const {
  Air air{};
  if (n >= view_count_) return air;
  const shader::FrameBlock block = block_of(n);
  const auto copy = [](const glm::vec4& from, float(&to)[3]) {
    for (int c = 0; c < 3; ++c) to[c] = from[c];
  };
  const Vec3 sun = world.placement.direction(glm::dvec3(block.sun_direction));
  air.sun_towards[0] = static_cast<float>(sun.x);
  air.sun_towards[1] = static_cast<float>(sun.y);
  air.sun_towards[2] = static_cast<float>(sun.z);
  copy(block.sun_light, air.sun_rgb);
  copy(block.sky_zenith, air.zenith_rgb);
  copy(block.sky_horizon, air.horizon_rgb);
  copy(block.sky_light, air.sky_rgb);
  copy(block.ground_light, air.ground_rgb);
  air.haze_per_m = static_cast<float>(static_cast<double>(block.view_scale.x) / world.shown.voxel_size_m);
  copy(glm::vec4(encode_picture(block.sky_horizon), 1.0f), air.horizon_display_rgb);
  air.block = gl.air_block(n);
  air.shadow_texture = gl.shadow_maps();
  return air;
}

namespace {

RendererObject& self(karst::Renderer* renderer) {
  return *static_cast<RendererObject*>(renderer);
}

void end_life(RendererObject& renderer) {
  WorldObject& world = renderer.world;
  renderer.~RendererObject();
  world.has_renderer = false;
}

}  // namespace
}  // namespace core

Status Renderer::create(World& world, const GlLoader& loader, const GlOptions& options,
                        Renderer*& out) noexcept {
  out = nullptr;
  auto& owner = static_cast<core::WorldObject&>(world);
  if (owner.has_renderer) {
    return {StatusCode::invalid_argument, "the world has a renderer already", "world"};
  }
  if (loader.load == nullptr) return {StatusCode::invalid_argument, "missing", "loader"};
  auto* const renderer = new (owner.renderer_room.data()) core::RendererObject(owner);
  owner.has_renderer = true;
  const Status status = renderer->open(loader, options);
  if (status.ok()) {
    out = renderer;
  } else {
    core::end_life(*renderer);
  }
  return status;
}

void Renderer::destroy() noexcept {
  core::end_life(core::self(this));
}

void Renderer::context_lost() noexcept {
  core::RendererObject& renderer = core::self(this);
  renderer.gl.forget();
  core::end_life(renderer);
}

Status Renderer::set_drape(std::span<const std::uint8_t> rgba) noexcept {
  core::RendererObject& renderer = core::self(this);
  const Status status = renderer.gl.upload_drape(rgba);
  renderer.gl.reset_state(false);
  return status;
}

Status Renderer::begin_frame(const FrameInput& input, FrameResult& result) noexcept {
  core::RendererObject& renderer = core::self(this);
  const Status status = renderer.begin(input, result);
  renderer.gl.reset_state(true);
  return status;
}

Status Renderer::draw(std::uint32_t view, const Target& target) noexcept {
  return core::self(this).draw_view(view, target);
}

Status Renderer::end_frame() noexcept {
  core::RendererObject& renderer = core::self(this);
  const Status status = renderer.end();
  renderer.gl.reset_state(false);
  return status;
}

Air Renderer::air(std::uint32_t view) const noexcept {
  return static_cast<const core::RendererObject*>(this)->air_of(view);
}

const char* Renderer::air_glsl() noexcept {
  return core::kAirText;
}

void set_inspection(Renderer& renderer, const Inspection& inspection) noexcept {
  static_cast<core::RendererObject&>(renderer).inspection = inspection;
}

const FrameCosts& costs(const Renderer& renderer) noexcept {
  return static_cast<const core::RendererObject&>(renderer).costs;
}

DeviceInfo device_info(const Renderer& renderer) noexcept {
  const auto& own = static_cast<const core::RendererObject&>(renderer);
  DeviceInfo info;
  info.renderer = own.gl.caps().renderer;
  info.version = own.gl.caps().version;
  info.clip_control = own.gl.caps().clip_control;
  info.deferred = own.gl.settings().deferred();
  info.anisotropy = static_cast<std::uint32_t>(own.gl.settings().anisotropy);
  info.high_precision = own.gl.settings().precision == Precision::high;
  info.depth_texture = own.gl.shared_depth();
  info.gpu_bytes = own.gl.gpu_bytes();
  info.cpu_bytes = own.world.layout.objects_bytes + own.world.layout.staging_bytes +
                   own.world.layout.reading_bytes + own.world.layout.edit_bytes +
                   own.world.terrain.arena.used();
  return info;
}

}  // namespace karst
