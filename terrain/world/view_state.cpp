// SPDX-License-Identifier: MIT
#include "terrain/world/view_state.h"

#include <algorithm>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

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

ViewState::ViewState() = default;

Status ViewState::create(const Config& config, Arena& arena) {
  if (const Status status = take_blocks(config, arena, blocks_); !status.ok()) return status;
  occlusion_.create(blocks_.hidden, config.max_patches);
  return {};
}

void ViewState::attach(const World& world) {
  patches_ = world.patch_count();
  std::fill(blocks_.levels.begin(), blocks_.levels.end(), std::uint8_t{0});
  occlusion_.reset();
  occluded_part_ = 0;
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

namespace {

// How far from the eye a part's voxels begin.
double distance_to(const WorldPart& part, const Camera& camera) {
  const glm::dvec3 eye = glm::dvec3(part.seen_from(camera).voxel);
  return glm::length(eye - glm::clamp(eye, glm::dvec3(0.0), glm::dvec3(part.extent)));
}

void add(SelectLod::Result& sum, const SelectLod::Result& part) {
  sum.raised += part.raised;
  sum.lowered += part.lowered;
  sum.capped += part.capped;
  sum.missing += part.missing;
  sum.cut += part.cut;
  sum.bound_px = std::max(sum.bound_px, part.bound_px);
}

void add(BuildDrawList::Result& sum, const BuildDrawList::Result& part) {
  sum.drawn += part.drawn;
  sum.dropped += part.dropped;
  sum.culled_frustum += part.culled_frustum;
  sum.culled_backface += part.culled_backface;
  sum.culled_occluded += part.culled_occluded;
  sum.missing += part.missing;
  sum.triangles += part.triangles;
  for (int level = 0; level <= kMaxLevel; ++level) sum.at_level[level] += part.at_level[level];
}

}  // namespace

// Part by part, the nearest first: each has patches of its own, and an octree that the camera is moved to.
Status ViewState::choose(const World& world, std::span<const PatchLod> lods,
                         std::span<const std::uint8_t> resident, bool cuts,
                         std::span<std::uint32_t> scratch) {
  const std::span<const WorldPart> parts = world.parts();
  std::array<std::size_t, kMostRegions> order{};
  std::array<double, kMostRegions> away{};
  for (std::size_t n = 0; n < parts.size(); ++n) {
    away[n] = distance_to(parts[n], *request_.camera);
    std::size_t at = n;
    for (; at > 0 && away[order[at - 1]] > away[n]; --at) order[at] = order[at - 1];
    order[at] = n;
  }
  complete_parts_ = 0;
  chosen_count_ = 0;
  occlusion_.end();
  // Rock of the nearest part hides what is in it.
  if (occluded_part_ != order[0]) occlusion_.reset();
  occluded_part_ = static_cast<std::uint32_t>(order[0]);
  Status limit;
  for (const std::size_t n : std::span(order).first(parts.size())) {
    const Status status = choose_part(world, n, lods, resident, cuts, scratch);
    if (status.code() == StatusCode::limit_reached) {
      limit = status;
    } else if (!status.ok()) {
      return status;
    }
  }
  restore_lacking();
  return limit;
}

Status ViewState::choose_part(const World& world, std::size_t n, std::span<const PatchLod> lods,
                              std::span<const std::uint8_t> resident, bool cuts,
                              std::span<std::uint32_t> scratch) {
  const WorldPart& part = world.parts()[n];
  const Camera camera = part.seen_from(*request_.camera);
  eyes_[n] = make_lod_eye(camera, lod_.scale.least_cos2);
  if ((request_.skipped_parts >> n & 1u) != 0) return {};
  const Frustum frustum = make_frustum(camera);
  const std::span<std::uint8_t> levels = part.of(blocks_.levels.first(patches_));
  CullView cull;
  cull.frustum = request_.frustum_culling ? &frustum : nullptr;
  cull.tree = part.tree;
  cull.boxes = part.boxes;
  cull.out = blocks_.culled;
  const bool hides = n == occluded_part_ && request_.occlusion_culling && !part.occluders->empty();
  if (hides) {
    occlusion_.begin(*part.occluders, *part.octree, *part.tree, part.surface, part.bounds, camera,
                     request_.occlusion_searches);
    cull.occlusion = &occlusion_;
    cull.levels = levels;
  }
  if (const Status status = cull.validate(); !status.ok()) return status;
  const std::span<const CulledEight> culled = blocks_.culled.first(cull.run());

  // What was listed of parts before.
  const std::size_t lacking = std::min<std::size_t>(selection_.lod.capped, blocks_.lacking.size());
  const std::uint32_t cut = selection_.lod.cut, listed = selection_.list.drawn;
  lod_.camera = &camera;
  lod_.surface = part.surface;
  lod_.bounds = part.bounds;
  lod_.tree = part.tree;
  lod_.culled = culled;
  lod_.lods = part.of(lods);
  lod_.cones = request_.backface_culling ? part.cones : std::span<const NormalCone>();
  lod_.errors = part.level_errors;
  lod_.resident = part.of(resident);
  lod_.cuts = cuts;
  lod_.levels = levels;
  lod_.lacking = blocks_.lacking.subspan(lacking);
  lod_.cut = blocks_.cut.subspan(cut);
  if (const Status status = lod_.validate(); !status.ok()) return status;
  const SelectLod::Result chosen = lod_.run();
  const std::size_t lacks = std::min<std::size_t>(chosen.capped, lod_.lacking.size());
  for (LackingPatch& patch : lod_.lacking.first(lacks)) patch.patch += part.first;
  for (PatchId& patch : lod_.cut.first(chosen.cut)) patch += part.first;
  add(selection_.lod, chosen);

  BuildDrawList list;
  list.camera = &camera;
  list.surface = part.surface;
  list.boxes = part.boxes;
  list.culled = culled;
  list.shows_hidden = cuts && chosen.missing > 0;
  if (request_.backface_culling) list.cones = part.cones;
  list.least_pixels = lod_.scale.least_pixels;
  list.levels = levels;
  list.scratch = scratch.first(part.patches());
  list.items = blocks_.items.subspan(listed);
  if (const Status status = list.validate(); !status.ok()) return status;
  BuildDrawList::Result made;
  const Status status = list.run(made);
  for (DrawItem& item : list.items.first(made.drawn)) item.patch += part.first;
  add(selection_.list, made);
  chosen_[chosen_count_++] = {n, chosen, made};
  // bound_px is 0 where none could be in view.
  const std::uint32_t bit = chosen.bound_px > 0 && made.dropped == 0 ? std::uint32_t{1} << n : 0;
  complete_parts_ |= bit;
  if (chosen.missing == 0) selection_.whole_parts |= bit;
  return status;
}

void ViewState::keep_parts(std::uint32_t parts) {
  BuildDrawList::Result list;
  std::uint32_t from = 0, capped = 0;
  float bound = 0;
  // Nothing is missing any more of what was completed.
  const bool complete = selection_.lod.missing == 0 && selection_.lod.capped == 0;
  for (const Chosen& chosen : std::span(chosen_).first(chosen_count_)) {
    const bool kept = (parts >> chosen.part & 1u) != 0;
    BuildDrawList::Result own = chosen.list;
    const auto items = blocks_.items.subspan(from, own.drawn);
    from += own.drawn;
    if (kept) {
      std::copy(items.begin(), items.end(), blocks_.items.begin() + list.drawn);
    } else {
      own.drawn = own.triangles = 0;
      for (std::uint32_t& count : own.at_level) count = 0;
    }
    add(list, own);
    if (!kept && (complete || chosen.lod.missing == 0)) continue;
    bound = std::max(bound, chosen.lod.bound_px);
    if (!complete) capped += chosen.lod.capped;
  }
  selection_.list = list;
  selection_.lod.bound_px = bound;
  selection_.lod.capped = capped;
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
