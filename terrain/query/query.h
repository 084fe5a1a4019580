// SPDX-License-Identifier: MIT
// Questions about the surface: where the ground is, what a ray or a moving sphere meets, whether a place is
// in rock. A Query answers on the triangles of one fixed level, whatever a camera sees: its vertices are
// those that are drawn at that level before they morph, so physics does not depend on where anybody looks.
//
//   Query::Limits limits;  limits.level = 3;  limits.patches = 128;
//   Query query;  query.create(limits, arena);  query.set_world(world);
//   query.prepare(place, 20);                                  // now and then, where files may be read
//   QueryHit hit;  if (query.ground(place, 0.5, Wait::never, hit)) ...
//
// One object belongs to one thread at a time; as many as memory was planned for may run beside each other and
// beside the thread that draws. It reads the world, which must not change meanwhile, and writes its own
// memory alone; nothing is allocated after create().
//
// Lengths and places are voxels from the octree's minimum corner, y up. A place with a component that is not
// finite or lies beyond +-kReach, and a ray without length, is answered with false; so is everything in an
// empty world. The same question gets the same bits, whatever was asked before and whatever the cache holds;
// only Wait::never depends on what is ready.
//
// Rays do not slip through edges and corners that triangles share: tests follow Woop, Benthin and Wald,
// "Watertight Ray/Triangle Intersection" (2013), in double. Straight down they are exact: x and z are rounded
// to 2^-22 voxel, and what meets an edge counts once.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/cull/bounds_tree.h"
#include "terrain/field/octree.h"
#include "terrain/field/voxel_index.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/heights.h"
#include "terrain/query/field/query_field.h"
#include "terrain/query/patch_cache.h"
#include "terrain/query/query_ground.h"
#include "terrain/query/segment.h"
#include "terrain/resident/height_cache.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// never: the file is not touched. A patch that is not ready, and whose heights are not in memory, is met
// undisplaced and at level 1: QueryHit::level is 0. Between it and one that is ready there may be a gap.
// for_file: heights are read where they are needed. One that can't be read is treated like never, and
// Query::trouble() tells why.
enum class Wait : std::uint8_t { never, for_file };

struct QueryHit {
  static constexpr PatchId kNone = 0xffffffffu;
  static constexpr PatchId kGround = 0xfffffffeu;
  static constexpr PatchId kField = 0xfffffffdu;

  glm::dvec3 place{0.0};
  glm::dvec3 normal{0.0};  // of the triangle, unit length, out of the rock
  // ray, sphere: from the start. ground, column: how far the surface lies below the place, negative above it.
  double distance = 0.0;
  // kNone: nothing was met; kGround, kField: no patch, but the ground or an isosurface
  PatchId patch = kNone;
  // Of the surface that was met; 0: undisplaced. Of the ground the query's, less one a size, at least 1. Of
  // an isosurface, which is met as it is finest, the query's.
  std::uint8_t level = 0;
  bool coarse = false;  // level is below the query's

  bool found() const { return patch != kNone; }
};

struct PickedVoxel {
  VoxelIndex voxel;  // at the level asked for; its fill bit: all of it is filled
  // The voxel of the same level from which the ray came, where it has one inside the octree.
  VoxelIndex before;
  bool has_before = false;
  double distance = 0.0;  // from the start to the voxel's side; 0 where the ray starts in it
};

// K algorithm 5.1's use (5.2.1): the first voxel of an octree level (0..depth) on the way from one place to
// another that is filled or has something filled in it. False: none, or a bad place (see above).
bool pick_voxel(const Octree& octree, glm::dvec3 from, glm::dvec3 to, int level, PickedVoxel& picked);

class Query {
 public:
  static constexpr double kReach = 0x1p30;  // voxels

  struct Limits : QueryPatches::Limits {
    QueryGround::Limits ground;
  };

  Query() = default;
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  static void add_to(Budget& budget, const Limits& limits) {
    QueryPatches::add_to(budget, limits);
    QueryGround::add_to(budget, limits.ground);
  }

  // Takes exactly what add_to() counts from the arena. invalid_argument naming the field; limit_reached
  // ("memory").
  Status create(const Limits& limits, Arena& arena) {
    const Status status = patches_.create(limits, arena);
    patches_.set_allowance(&allowance_);
    ground_.set_allowance(&allowance_);
    return status.ok() ? ground_.create(limits.ground, arena) : status;
  }

  // Forgets all patches. invalid_argument ("bounds", "tree", "heights"), limit_reached ("max_level").
  Status set_world(const QueryWorld& world) {
    field_.set_field(nullptr, glm::ivec3(0));
    return patches_.set_world(world);
  }
  // As QueryGround's; after set_world(). The ground is met at size 0, and coarser where Wait::never has no
  // tile.
  void set_ground(const GroundInfo& info, const Tile* root, const TileReading& reading) {
    ground_.set_ground(info, root, reading);
  }

  // After set_world(); borrowed. Null: there is no isosurface.
  void set_field(const FieldBlocks* field, glm::ivec3 corner = glm::ivec3(0)) {
    field_.set_field(field, corner);
  }

  // Of the ground, after an edit.
  void set_ground_heights(std::int32_t low, std::int32_t high) { ground_.set_heights(low, high); }
  void forget_tile(NodeKey tile) { ground_.forget(tile); }
  // Of a world that was edited: patches that have changed.
  void forget(std::span<const PatchId> patches) { patches_.forget(patches); }

  // The level that answers are of: that of the limits, or the world's where it is less.
  int level() const { return patches_.level(); }

  // Makes the patches, and the ground's tiles, within radius of a place ready, which reads the file where
  // heights are not in memory. invalid_argument ("place", "radius"); limit_reached ("query_patches", value:
  // how many there are): nearer ones are ready; errors of reading.
  Status prepare(glm::dvec3 place, double radius);

  // All surfaces on the vertical line through a place, from the top. Returns how many there are; the first
  // out.size() of them are written.
  std::uint32_t column(glm::dvec3 place, Wait wait, std::span<QueryHit> out);

  // What a walker or a wheel stands on: the highest surface that faces up and is not above place.y + step.
  bool ground(glm::dvec3 place, double step, Wait wait, QueryHit& hit);

  // First crossing of a segment, its ends included; both sides of the surface count. False: it is free.
  bool ray(glm::dvec3 from, glm::dvec3 to, Wait wait, QueryHit& hit);

  // Many of them, as if asked one by one. All spans are equally long; what is free has found() false. Faster
  // where rays that follow each other lie close together.
  void rays(std::span<const glm::dvec3> from, std::span<const glm::dvec3> to, Wait wait,
            std::span<QueryHit> hits);

  // First contact of a sphere that moves from one place to another, which may be the same: then, and where it
  // touches from the start, distance is 0 and place is the nearest point of the surface. radius: 0..kReach;
  // else false.
  bool sphere(glm::dvec3 from, glm::dvec3 to, double radius, Wait wait, QueryHit& hit);

  // Whether a place is in rock, by the surface: more of it faces up above the place than down. False beyond
  // the sides of the world.
  bool inside(glm::dvec3 place, Wait wait);

  // Reads that failed since set_world(), and what the last one said.
  std::uint64_t failed_reads() const { return patches_.failed_reads() + ground_.failed_reads(); }
  const Status& trouble() const { return patches_.trouble().ok() ? ground_.trouble() : patches_.trouble(); }
  // Reads of the file from now on, all calls together; more is answered as with Wait::never. At the start as
  // many as are wanted: 2^32 - 1.
  void allow_reads(std::uint32_t reads) { allowance_.left = reads; }
  std::uint64_t refused_reads() const { return allowance_.refused; }  // since create()
  // Groups of heights that were read since create(): how often the file was touched.
  std::uint64_t groups_read() const { return patches_.groups_read(); }
  // The same of tiles of the ground, since set_ground().
  std::uint64_t tiles_read() const { return ground_.tiles_read(); }

 private:
  bool has_patches() const { return level() != 0 && !patches_.world().surface.patches.empty(); }
  bool is_empty() const { return !has_patches() && !ground_.exists() && !field_.exists(); }
  LatticeBox world_box() const;
  bool is_curved() const { return ground_.exists() && ground_.info().basis.is_curved(); }
  bool drop(glm::dvec3 place, double step, Wait wait, QueryHit& hit);
  bool cast(glm::dvec3 from, glm::dvec3 to, Wait wait, const GridPlace* at, QueryHit& hit);
  template <class Limit, class VisitTriangle>
  void walk_field(const Segment& segment, double radius, Limit& limit, VisitTriangle& visit_triangle) const;
  template <class Limit, class Visit, class VisitTriangle>
  void walk_segment(const Segment& segment, double radius, Wait wait, const GridPlace* at, Limit& limit,
                    Visit& visit, VisitTriangle& visit_triangle);
  template <class Limit, class Visit>
  void walk_line(glm::dvec3 place, double top, double bottom, Wait wait, Limit&& limit, Visit&& visit);

  ReadAllowance allowance_;
  QueryPatches patches_;
  QueryGround ground_;
  QueryField field_;
};

}  // namespace karst::core
