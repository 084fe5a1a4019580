// SPDX-License-Identifier: MIT
#include "scene/world/query_object.h"

#include <algorithm>
#include <cmath>

namespace karst {
namespace core {
namespace {

static_assert(kGroundPatch == QueryHit::kGround && kFieldPatch == QueryHit::kField);

core::Wait wait_of(karst::Wait wait) {
  return wait == karst::Wait::never ? core::Wait::never : core::Wait::for_file;
}

QueryObject& self(karst::Query* query) {
  return *static_cast<QueryObject*>(query);
}

}  // namespace

QueryObject::QueryObject() = default;

Status QueryObject::create(const core::Query::Limits& limits, const PlacementFrame& frame,
                           std::span<std::byte> memory) {
  arena = Arena(memory);
  placement = &frame;
  return asked.create(limits, arena);
}

Status QueryObject::show(const QueryWorld& world, std::span<const WorldPart> octrees) {
  voxels_of = octrees;
  QueryWorld all = world;
  const std::size_t others = octrees.size() - 1;
  for (std::size_t n = 0; n < others; ++n) {
    const WorldPart& part = octrees[n + 1];
    other_parts[n] = {part.surface, part.bounds, part.tree, part.corner, part.first};
  }
  all.others = std::span(other_parts).first(others);
  return asked.set_world(all);
}

Hit QueryObject::hit_of(const QueryHit& hit) const {
  Hit out;
  out.place = placement->place_of_voxels(hit.place);
  out.normal = placement->direction(hit.normal);
  out.distance = hit.distance * placement->world().voxel_size_m;
  out.patch = hit.patch;
  out.level = hit.level;
  out.found = hit.found();
  return out;
}

}  // namespace core

Status Query::prepare(Vec3 place, double radius_m) noexcept {
  core::QueryObject& q = core::self(this);
  return q.asked.prepare(q.voxels(place), radius_m / q.placement->world().voxel_size_m);
}

std::uint32_t Query::column(Vec3 place, Wait wait, std::span<Hit> out) noexcept {
  core::QueryObject& q = core::self(this);
  core::QueryHit hits[kMostColumn];
  const std::size_t room = std::min(out.size(), std::size(hits));
  const std::uint32_t count =
      q.asked.column(q.voxels(place), core::wait_of(wait), std::span(hits).first(room));
  for (std::size_t n = 0; n < std::min<std::size_t>(room, count); ++n) out[n] = q.hit_of(hits[n]);
  return count;
}

bool Query::ground(Vec3 place, double step_m, Wait wait, Hit& hit) noexcept {
  core::QueryObject& q = core::self(this);
  core::QueryHit met;
  if (!q.asked.ground(q.voxels(place), step_m / q.placement->world().voxel_size_m, core::wait_of(wait), met))
    return false;
  hit = q.hit_of(met);
  return true;
}

bool Query::ray(Vec3 from, Vec3 to, Wait wait, Hit& hit) noexcept {
  core::QueryObject& q = core::self(this);
  core::QueryHit met;
  if (!q.asked.ray(q.voxels(from), q.voxels(to), core::wait_of(wait), met)) return false;
  hit = q.hit_of(met);
  return true;
}

bool Query::sphere(Vec3 from, Vec3 to, double radius_m, Wait wait, Hit& hit) noexcept {
  core::QueryObject& q = core::self(this);
  core::QueryHit met;
  const double radius = radius_m / q.placement->world().voxel_size_m;
  if (!q.asked.sphere(q.voxels(from), q.voxels(to), radius, core::wait_of(wait), met)) return false;
  hit = q.hit_of(met);
  return true;
}

bool Query::inside(Vec3 place, Wait wait) noexcept {
  core::QueryObject& q = core::self(this);
  return q.asked.inside(q.voxels(place), core::wait_of(wait));
}

void Query::rays(std::span<const Vec3> from, std::span<const Vec3> to, Wait wait,
                 std::span<Hit> hits) noexcept {
  core::QueryObject& q = core::self(this);
  // As many at a time as find room on the stack.
  constexpr std::size_t kAtOnce = 256;
  glm::dvec3 starts[kAtOnce];
  glm::dvec3 ends[kAtOnce];
  core::QueryHit met[kAtOnce];
  const std::size_t count = std::min({from.size(), to.size(), hits.size()});
  for (std::size_t done = 0; done < count; done += kAtOnce) {
    const std::size_t some = std::min(kAtOnce, count - done);
    for (std::size_t n = 0; n < some; ++n) {
      starts[n] = q.voxels(from[done + n]);
      ends[n] = q.voxels(to[done + n]);
    }
    q.asked.rays(std::span(starts).first(some), std::span(ends).first(some), core::wait_of(wait),
                 std::span(met).first(some));
    for (std::size_t n = 0; n < some; ++n) {
      hits[done + n] = met[n].found() ? q.hit_of(met[n]) : Hit();
    }
  }
}

bool Query::pick(Vec3 from, Vec3 to, int octree_level, Voxel& voxel) noexcept {
  core::QueryObject& q = core::self(this);
  core::PickedVoxel picked;
  const core::WorldPart* in = nullptr;
  for (const core::WorldPart& part : q.voxels_of) {
    const glm::dvec3 corner(part.corner);
    core::PickedVoxel found;
    // Voxels as large in all, or the whole of an octree that is smaller.
    const int level =
        octree_level < 0 ? octree_level : std::max(0, octree_level - (q.octree_depth - part.octree->depth()));
    if (!core::pick_voxel(*part.octree, q.voxels(from) - corner, q.voxels(to) - corner, level, found) ||
        (in != nullptr && found.distance >= picked.distance))
      continue;
    picked = found;
    in = &part;
  }
  if (in == nullptr) return false;
  const int depth = in->octree->depth();
  voxel.centre = q.placement->place_of_voxels(glm::dvec3(in->corner) +
                                              glm::dvec3(picked.voxel.centre_half_voxels(depth)) * 0.5);
  voxel.side_m = picked.voxel.size(depth) * q.placement->world().voxel_size_m;
  voxel.level = octree_level;
  return true;
}

std::uint64_t Query::failed_reads() const noexcept {
  return static_cast<const core::QueryObject*>(this)->asked.failed_reads();
}

void Query::allow_reads(std::uint32_t reads) noexcept {
  core::self(this).asked.allow_reads(reads);
}

std::uint64_t Query::refused_reads() const noexcept {
  return static_cast<const core::QueryObject*>(this)->asked.refused_reads();
}

}  // namespace karst
