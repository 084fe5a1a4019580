// SPDX-License-Identifier: MIT
// What a simulator asks of the ground: heights, hits, contacts. Answers are of the surface at one fixed level
// (Needs::query_level), so that physics does not depend on where a camera looks; of isosurfaces at their
// finest.
//
// One Query a thread; as many as the plan has may run beside each other and beside the renderer. Each keeps a
// fixed number of patches ready and allocates nothing.
#pragma once

#include <cstdint>
#include <span>

#include "karst/export.h"
#include "karst/status.h"
#include "karst/types.h"

namespace karst {

// never: no file is touched; what is not in memory is answered from a coarser surface, and Hit::level says
// so.
enum class Wait : std::uint8_t { never, for_file };

inline constexpr std::uint32_t kGroundPatch = 0xfffffffe, kFieldPatch = 0xfffffffd;  // of Hit::patch

struct Hit {
  Vec3 place;
  Vec3 normal;              // of the triangle that was met, unit length, out of the ground
  double distance = 0;      // metres: from the start; of column() and ground(), below the place asked for
  std::uint32_t patch = 0;  // that was met; kGroundPatch, kFieldPatch: none, but the ground or an isosurface
  std::uint8_t level = 0;   // of the surface that was met; 0: without heights, which only Wait::never meets
  bool found = false;       // of rays(): false where the segment is free
};

struct Voxel {
  Vec3 centre;
  double side_m = 0;
  int level = 0;  // of the octree; 0 is the whole of it
};

inline constexpr std::uint32_t kMostColumn = 64;  // surfaces that Query::column() tells

class KARST_API Query {
 public:
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  // Makes what lies within the radius ready, so that asking there needs no file. limit_reached
  // ("query_patches", patches that it takes): the nearest ones are ready. corrupt: heights are damaged
  // or could not be read ("file").
  Status prepare(Vec3 place, double radius_m) noexcept;

  // Places that are not finite find nothing.

  // The surfaces above and below a place, from the top. Returns how many there are, which may be more than
  // out holds; at most kMostColumn are written. Caves and arches have several.
  std::uint32_t column(Vec3 place, Wait wait, std::span<Hit> out) noexcept;
  // The ground that a walker or a wheel stands on: the highest that is not above place by more than step_m.
  bool ground(Vec3 place, double step_m, Wait wait, Hit& hit) noexcept;
  // The first crossing of the segment; both sides of the surface count. False: it is free.
  bool ray(Vec3 from, Vec3 to, Wait wait, Hit& hit) noexcept;
  // The first contact of a sphere that moves along the segment; hit.distance is the way of its centre.
  bool sphere(Vec3 from, Vec3 to, double radius_m, Wait wait, Hit& hit) noexcept;
  // In rock.
  bool inside(Vec3 place, Wait wait) noexcept;
  // Many at once, for sensors. The spans are equally long; hits[n].found is false where it is free.
  void rays(std::span<const Vec3> from, std::span<const Vec3> to, Wait wait, std::span<Hit> hits) noexcept;
  // The nearest filled voxel of an octree level that the segment meets (K 5.2.1, algorithm 5.1): for editors.
  bool pick(Vec3 from, Vec3 to, int octree_level, Voxel& voxel) noexcept;

  // Failed reads of the file since the start; what they concern was answered coarsely.
  std::uint64_t failed_reads() const noexcept;
  // For callers that must not be kept waiting: so many reads of the file from now on, by all calls together;
  // what would read more is answered as with Wait::never, and counted. At the start 2^32 - 1, which is no
  // limit.
  void allow_reads(std::uint32_t reads) noexcept;
  std::uint64_t refused_reads() const noexcept;  // since the start

 protected:
  Query() = default;
  ~Query() = default;
};

}  // namespace karst
