// SPDX-License-Identifier: MIT
#include "terrain/world/shadow_casters.h"

#include <cmath>
#include <cstring>

#include <glm/geometric.hpp>

#include "terrain/shadow/select_casters.h"

namespace karst::core {
namespace {

// FNV-1a over words of eight bytes.
std::uint64_t mix(std::uint64_t hash, std::uint64_t word) {
  return (hash ^ word) * 0x100000001b3u;
}

// A cascade as a part's octree sees it.
Cascade seen_from(const WorldPart& part, const Cascade& cascade) {
  if (part.corner == glm::ivec3(0)) return cascade;
  Cascade moved = cascade;
  moved.eye.voxel -= part.corner;
  moved.frustum = frustum_from(part.corner, cascade.frustum);
  return moved;
}

}  // namespace

Frustum frustum_from(glm::ivec3 corner_voxels, const Frustum& frustum) {
  if (corner_voxels == glm::ivec3(0)) return frustum;
  constexpr double kRounding = 0x1p-19;
  Frustum moved = frustum;
  const glm::dvec3 corner = glm::dvec3(corner_voxels) * double{kStepsPerVoxel};
  for (Plane& plane : moved.planes) {
    const double offset = double{plane.offset} + glm::dot(glm::dvec3(plane.normal), corner);
    plane.offset = static_cast<float>(
        offset + (std::abs(offset) + std::abs(double{plane.offset}) + glm::length(corner)) * kRounding);
  }
  return moved;
}

Status ShadowCasters::create(const Config& config, Arena& arena) {
  next_ = lacking_ = 0;
  return take_blocks(config, arena, blocks_);
}

Status ShadowCasters::select(const World& world, Residency& residency, const ViewState& view,
                             const Cascade& cascade, double error_texels, std::uint32_t parts,
                             Result& result) {
  result = {};
  next_ = lacking_ = 0;
  if (view.threshold_set() < 0) return {StatusCode::invalid_argument, "was not selected yet", "view"};
  const std::uint32_t patches = world.patch_count();
  std::uint32_t drawn = 0;
  Status limit;
  for (std::size_t n = 0; n < world.parts().size(); ++n) {
    if ((parts >> n & 1u) == 0) continue;
    const WorldPart& part = world.parts()[n];
    const Cascade moved = seen_from(part, cascade);
    SelectCasters select;
    select.settings = view.settings();
    select.error_texels = error_texels;
    select.base_level = world.base_level();
    select.cascade = &moved;
    select.surface = part.surface;
    select.bounds = part.bounds;
    select.tree = part.tree;
    select.lods = part.of(residency.thresholds().lods(view.threshold_set()));
    select.errors = part.level_errors;
    select.resident = part.of(residency.pool().levels());
    select.wanted = part.of(blocks_.wanted.first(patches));
    select.levels = part.of(blocks_.levels.first(patches));
    select.lacking = blocks_.lacking.subspan(lacking_, part.patches());
    select.items = blocks_.items.subspan(drawn);
    if (const Status status = select.validate(); !status.ok()) return status;
    SelectCasters::Result selected;
    const Status status = select.run(selected);
    if (!status.ok()) limit = status;
    for (DrawItem& item : select.items.first(selected.drawn)) item.patch += part.first;
    for (std::uint32_t& patch : select.lacking.first(selected.lacking)) patch += part.first;
    // Those that are not held come first.
    const bool holes = selected.lacking > 0 && residency.pool().level(select.lacking[0]) == 0;
    if (selected.drawn > 0 && !holes && status.ok()) result.whole_parts |= std::uint32_t{1} << n;
    drawn += selected.drawn;
    lacking_ += selected.lacking;
    result.triangles += selected.triangles;
  }
  result.items = blocks_.items.first(drawn);
  result.lacking = lacking_;
  result.levels = blocks_.levels.first(patches);
  result.hash = mix(0xcbf29ce484222325u, residency.thresholds().version(view.threshold_set()));
  for (const DrawItem& item : result.items) {
    std::uint64_t word = 0;
    std::memcpy(&word, &item, sizeof item);
    result.hash = mix(result.hash, word);
    // The GPU reads its pages in this frame: they must not be given to others while it does.
    residency.pool().see(item.patch, item.level);
  }
  return limit;
}

bool ShadowCasters::generate_next(Residency& residency, PatchUpload& upload, Status& status) {
  status = {};
  ResidentPool& pool = residency.pool();
  for (; next_ < lacking_; ++next_) {
    const PatchId patch = blocks_.lacking[next_];
    const int level = blocks_.wanted[patch];
    if (pool.level(patch) >= level) continue;
    if (!pool.make_room(patch, level, true)) return false;
    const bool made = residency.make_resident(patch, level, upload, status);
    // The next ones must not take it back.
    if (made) pool.see(patch, level);
    return made;
  }
  return false;
}

}  // namespace karst::core
