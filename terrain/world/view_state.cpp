// SPDX-License-Identifier: MIT
#include "terrain/world/view_state.h"

#include <algorithm>

#include "terrain/view/frustum.h"

namespace karst::core {
namespace {

// Holes are worse than any lack of detail.
constexpr float kHolePx = 1e9f;

constexpr double kMostWeight = 1024;

Status invalid(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

}  // namespace

Status ViewState::create(const Config& config, Arena& arena) {
  if (const Status status = take_blocks(config, arena, blocks_); !status.ok()) return status;
  occlusion_.create(blocks_.hidden, config.max_patches);
  return {};
}

void ViewState::attach(const World& world) {
  patches_ = world.patch_count();
  std::fill(blocks_.levels.begin(), blocks_.levels.end(), std::uint8_t{0});
  occlusion_.reset();
  selection_ = {};
  lacking_count_ = 0;
  threshold_set_ = -1;
}

Status ViewState::begin(const World& world, const ViewRequest& request, double error_scale) {
  selection_ = {};
  lacking_count_ = 0;
  request_ = request;
  if (request.camera == nullptr) return invalid("no camera given", "camera");
  if (request.width_px < 1 || request.width_px > 65'536) {
    return invalid("not within 1..65536", "width_px");
  }
  if (request.height_px < 1 || request.height_px > 65'536) {
    return invalid("not within 1..65536", "height_px");
  }
  if (!(request.weight >= 1 / kMostWeight && request.weight <= kMostWeight)) {
    return invalid("not within 2^-10..2^10", "weight");
  }
  if (!(request.lod.error_px >= kLeastErrorPx && request.lod.error_px <= kMostErrorPx)) {
    return invalid("not within 0.01..1000 pixels", "error_px");
  }
  lod_ = {};
  lod_.settings = request.lod;
  lod_.settings.max_level = std::min(lod_.settings.max_level, world.info().level);
  lod_.settings.resident_level = std::min(lod_.settings.resident_level, world.info().level);
  wanted_error_px_ = lod_.settings.error_px;
  weight_ = request.weight;
  lod_.settings.error_px = std::min(lod_.settings.error_px * error_scale, kMostErrorPx);
  lod_.scale = make_error_scale(*request.camera, request.width_px, request.height_px, lod_.settings.error_px);
  eye_ = make_lod_eye(*request.camera, lod_.scale.least_cos2);
  selection_.error_scale = static_cast<float>(error_scale);
  return {};
}

ThresholdSets::Key ViewState::threshold_key() const {
  return {lod_.scale, lod_.settings.mode == LodMode::error, lod_.settings.top_level()};
}

Status ViewState::choose(const World& world, std::span<const PatchLod> lods,
                         std::span<const std::uint8_t> resident, bool cuts,
                         std::span<std::uint32_t> scratch) {
  const Camera& camera = *request_.camera;
  const Frustum frustum = make_frustum(camera);
  CullView cull;
  cull.frustum = request_.frustum_culling ? &frustum : nullptr;
  cull.tree = &world.tree();
  cull.boxes = world.patch_boxes();
  cull.out = blocks_.culled;
  occlusion_.end();
  if (request_.occlusion_culling && !world.occluders().empty()) {
    occlusion_.begin(world.occluders(), world.octree(), world.tree(), world.surface(), world.bounds(), camera,
                     request_.occlusion_searches);
    cull.occlusion = &occlusion_;
    cull.levels = levels();
  }
  if (const Status status = cull.validate(); !status.ok()) return status;
  const std::span<const CulledEight> culled = blocks_.culled.first(cull.run());

  lod_.camera = &camera;
  lod_.surface = world.surface();
  lod_.bounds = world.bounds();
  lod_.tree = &world.tree();
  lod_.culled = culled;
  lod_.lods = lods;
  if (request_.backface_culling) lod_.cones = world.cones();
  lod_.errors = world.level_errors();
  lod_.resident = resident;
  lod_.cuts = cuts;
  lod_.levels = blocks_.levels.first(patches_);
  lod_.lacking = blocks_.lacking;
  lod_.cut = blocks_.cut;
  if (const Status status = lod_.validate(); !status.ok()) return status;
  selection_.lod = lod_.run();
  restore_lacking();

  BuildDrawList list;
  list.camera = &camera;
  list.surface = world.surface();
  list.boxes = world.patch_boxes();
  list.culled = culled;
  list.shows_hidden = cuts && selection_.lod.missing > 0;
  if (request_.backface_culling) list.cones = world.cones();
  list.least_pixels = lod_.scale.least_pixels;
  list.levels = levels();
  list.scratch = scratch.first(patches_);
  list.items = blocks_.items;
  if (const Status status = list.validate(); !status.ok()) return status;
  return list.run(selection_.list);
}

void ViewState::restore_lacking() {
  lacking_count_ = std::min<std::size_t>(selection_.lod.capped, blocks_.lacking.size());
  lacking_is_heap_ = false;
}

bool ViewState::is_held(std::span<const std::uint8_t> resident) const {
  if (selection_.lod.capped > blocks_.lacking.size()) return false;
  // What was taken out lies behind what was not.
  const auto lacking = blocks_.lacking.first(selection_.lod.capped);
  return std::all_of(lacking.begin(), lacking.end(),
                     [&](const LackingPatch& patch) { return resident[patch.patch] >= patch.wanted; });
}

void ViewState::order_lacking(const ResidentPool& pool) {
  LackingPatch* const first = blocks_.lacking.data();
  for (LackingPatch& patch : blocks_.lacking.first(lacking_count_)) {
    if (pool.level(patch.patch) == 0) patch.px += kHolePx;
  }
  std::make_heap(first, first + lacking_count_, less_urgent);
  lacking_is_heap_ = true;
}

LackingPatch ViewState::pop_lacking() {
  KARST_ASSERT(lacking_is_heap_ && lacking_count_ > 0);
  LackingPatch* const first = blocks_.lacking.data();
  std::pop_heap(first, first + lacking_count_, less_urgent);
  return first[--lacking_count_];
}

}  // namespace karst::core
