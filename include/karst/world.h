// SPDX-License-Identifier: MIT
// The CPU's side of a terrain, without OpenGL: what is there, in memory of planned size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/export.h"
#include "karst/plan.h"
#include "karst/query.h"
#include "karst/status.h"
#include "karst/types.h"

namespace karst {

inline constexpr std::uint32_t kMostRegions = 16;  // of a ground

struct WorldInfo {
  char name[64] = {};  // printable ASCII, zero-terminated; may be empty
  double voxel_size_m = 0;
  Vec3 origin_m;                // of the octree's minimum corner, in the world's own metres (Placement)
  std::int32_t extent[3] = {};  // voxels in use: to the east, up, to the south
  // Of the deepest octree; of a ground that can be dug, of any that there may be: 9.
  std::int32_t octree_depth = 0;
  std::int32_t level = 0;  // finest that the file has
  std::uint32_t octets = 0, volumes = 0, patches = 0, height_blocks = 0;
  std::uint32_t materials = 0, lights = 0;
  char material_names[8][16] = {};  // of the materials, zero-terminated
  std::uint32_t blend_map[2] = {};  // texels along x and z of the painted weights; 0: there are none
  // Still water stands up to water_m, a height in the world's own metres. It is drawn; queries are of the
  // ground, which may be its bed.
  bool has_water = false;
  double water_m = 0;
  // Of the ground, a height field as a quadtree; 0: there is none.
  std::int64_t ground_samples[2] = {};  // to the east and to the south
  double ground_spacing_m[2] = {};      // from one to the next
  std::int32_t ground_sizes = 0;        // of nodes, each of twice the side of the one before
  std::uint64_t tile_bytes = 0;         // of all its tiles in the file, those of imagery too
  double image_texel_m = 0;             // the finest texel of its imagery, along x; 0: there is none
  std::int32_t field_samples[3] = {};   // of the field of an isosurface, each way; 0: there is none
  std::int32_t field_sample_bits = 0;   // 8 or 16
  std::uint32_t field_blocks = 0;       // of 16^3 samples, that are neither all solid nor all air
  double field_cell_m = 0;              // between samples
  bool field_has_materials = false;     // of its samples, beside what rules say
  // Of its regions, where the voxels are: nodes, of 4 x 4 samples each, from the first on to the east and to
  // the south.
  std::uint32_t regions = 0;  // ..kMostRegions
  bool can_be_dug = false;    // edits may make regions anywhere in it (karst/edit.h)
  std::int32_t region_first[kMostRegions][2] = {}, region_nodes[kMostRegions][2] = {};
  double ground_low_m = 0, ground_high_m = 0;  // heights of its samples, in the world's own metres
  // What it lies on. Of a cube samples are those of its grid, which holds six faces; of all that are not
  // planes spacing is the greatest and heights stand above the basis.
  Basis basis = Basis::plane;
  double radius_m = 0;     // of the ellipsoid at the equator, or of the cylinder, below 0 inside; 0: a plane
  std::uint32_t epsg = 0;  // code of the coordinate reference system it is in; 0: not known
  bool is_geodetic = false;   // World::to_geodetic() knows places
  bool is_projected = false;  // World::to_projected() does
  // Box of the surface, in the world's own metres. World::info() alone knows it.
  Vec3 low_m, high_m;
};

// What a file's head says; nothing else of it is read. Of no head: nothing.
KARST_API WorldInfo info_of(const Head& head) noexcept;
KARST_API Status read_world_info(const Source& file, WorldInfo& info) noexcept;
// Reads all of it and checks every byte against checksums, ranges and counts.
KARST_API Status check_world(const Source& file, WorldInfo& info) noexcept;

class Editor;

class KARST_API World {
 public:
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Lives at the start of memory: plan.cpu_bytes of it, aligned to kMemoryAlignment, the caller's until
  // destroy() has returned. Reads the file behind its head, which plan has, and later reads heights from it
  // where they did not all find room (plan.holds_all_heights), so the source must outlive the world. Any
  // thread. invalid_argument ("plan": not made for this file; "ground": its function is missing; "memory");
  // corrupt, unsupported: the file, which names "file" where it cannot be read.
  static Status create(const Plan& plan, const Source& file, std::span<std::byte> memory, World*& out,
                       Log log = {}) noexcept;
  // Renderers and queries first.
  void destroy() noexcept;

  const WorldInfo& info() const noexcept;
  const Plan& plan() const noexcept;

  // limit_reached ("queries"). Any thread; give it back with release().
  Status take_query(Query*& out) noexcept;
  void release(Query* query) noexcept;

  // The world's one editor (karst/edit.h). invalid_argument ("edit_patches") where the plan has no room for
  // edits, limit_reached ("editors") where it is taken. Give it back with release().
  Status take_editor(Editor*& out) noexcept;
  void release(Editor* editor) noexcept;
  void release(std::nullptr_t) noexcept {}

  // Between the simulator's frame and the world's own metres.
  Vec3 to_world(Vec3 place) const noexcept;
  Vec3 from_world(Vec3 place_m) const noexcept;

  // Longitude, latitude and altitude of a place, and back. Known of worlds on an ellipsoid and of planes
  // whose coordinates are degrees or a transverse Mercator projection's, as all UTM zones' are; else false.
  // Any thread.
  bool to_geodetic(Vec3 place, Geodetic& out) const noexcept;
  bool from_geodetic(const Geodetic& geodetic, Vec3& place) const noexcept;
  // The same of coordinates of the elevation's reference system (WorldInfo::epsg). Known of planes that it
  // was known for; and of cylinders, as metres along the circle and against the axis; else false.
  bool to_projected(Vec3 place, Projected& out) const noexcept;
  bool from_projected(const Projected& projected, Vec3& place) const noexcept;
  // East, up and north at a place: of a plane the same everywhere.
  LocalAxes axes_at(Vec3 place) const noexcept;

 protected:
  World() = default;
  ~World() = default;
};

}  // namespace karst
