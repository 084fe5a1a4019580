// SPDX-License-Identifier: MIT
// The rim of an isosurface that stands in a ground (terrain/ground/ground.h): the line in which the meshes
// that are drawn end in the region's four sides, whatever their levels. Sides, the walk and columns are those
// of terrain/regions/region_rim.h.
//
// Each mesh keeps its *runs*, pieces of that line one behind the other, when it is made: of kRunHeader values
// the side and how many vertices, then for each of these which of the mesh, and its place along the side and
// upwards, in steps of the mesh. A choice of blocks joins the runs of its meshes by the places of their ends,
// which are the same bits: it is one closed line, or there is none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "terrain/base/storage_plan.h"
#include "terrain/blocks/block_key.h"
#include "terrain/isosurface/extract_block.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::core {

// Finds the runs of one block's mesh.
struct FindRuns {
  static constexpr std::size_t kRunHeader = 2;
  static constexpr std::size_t kPointValues = 3;

  std::span<const IsoVertex> vertices;
  std::span<const std::uint16_t> triangles;
  unsigned sides = 0;  // bit s: the block ends at side s of the field
  std::span<std::uint16_t> out;

  // Returns how many values were written: none where they are more than there is room for.
  std::size_t run() const;
};

// The sides of a field that a block ends at.
unsigned sides_of(const FieldInfo& info, BlockKey block);

class BlockRim {
 public:
  struct Point {
    std::uint32_t vertex = 0;  // of the pages of meshes
    std::int64_t along = 0;    // lattice steps from the beginning of its side
  };
  // Of a mesh: its vertices' place in the walk.
  struct Run {
    std::int64_t side_along = 0;  // of its beginning: the side, and along it
    std::int64_t up = 0;
    std::uint32_t mesh = 0;
    std::uint32_t first = 0;  // value of the mesh's
    std::uint32_t count = 0;  // vertices
  };
  struct Storage {
    std::span<Point> points;
    std::span<Run> runs;
    std::span<std::uint32_t> marks;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      const std::size_t edges = config.field_blocks > 0 ? config.rim_edges : 0;
      visit(Consumer::fields, 2 * edges, points);
      visit(Consumer::fields, 2 * edges, runs);
      visit(Consumer::fields, edges, marks);
    }
  };
  void create(const Storage& storage) { storage_ = storage; }

  // Whether there is a line, and so a surface that a ground can be joined to.
  bool exists() const { return point_count_ > 0; }
  void clear() { point_count_ = 0; }
  std::span<const Point> points() const { return storage_.points.first(point_count_); }
  std::uint32_t count() const { return static_cast<std::uint32_t>(point_count_); }
  // The first point that is not before a column's beginning; and the first column of a side, side 4:
  // columns().
  std::uint32_t mark(std::uint32_t column) const { return storage_.marks[column]; }
  std::uint32_t columns() const { return first_[4]; }
  std::uint32_t first_column(int side) const { return first_[side]; }

  // Joins the runs of meshes first..last - 1 (items(n) is the mesh's number) of a pool to one line. column:
  // lattice steps of a column. No line where that is not one, or there is no room.
  template <class Pool>
  void build(const Pool& pool, std::span<const std::uint32_t> meshes, const FieldInfo& info,
             std::int64_t column);

 private:
  bool add_run(const Run& run) {
    if (run_count_ == storage_.runs.size()) return false;
    storage_.runs[run_count_++] = run;
    return true;
  }
  void sort_runs();
  const Run* find_run(std::int64_t side_along, std::int64_t up) const;
  bool set_marks(const FieldInfo& info, std::int64_t column);

  // A side is a part of one number, of which places along it are others.
  static constexpr std::int64_t kSide = std::int64_t{1} << 32;
  static std::int64_t length(const FieldInfo& info, int side) {
    return info.drawn_steps()[side % 2 == 0 ? 2 : 0];
  }

  Storage storage_;
  std::size_t point_count_ = 0;
  std::size_t run_count_ = 0;
  std::uint32_t first_[5] = {};
};

template <class Pool>
void BlockRim::build(const Pool& pool, std::span<const std::uint32_t> meshes, const FieldInfo& info,
                     std::int64_t column) {
  point_count_ = run_count_ = 0;
  const auto along_of = [&](int side, std::int64_t corner, std::int64_t place) {
    return side < 2 ? corner + place : length(info, side) - corner - place;
  };
  // Where a value of a mesh lies in the walk, and upwards.
  const auto begin_of = [&](const typename Pool::Mesh& mesh, int side, std::uint16_t along, std::uint16_t up,
                            Run& run) {
    const int log2 = mesh.block.block.level + info.cell_log2;
    const glm::ivec3 corner = mesh.block.block.place() * (kIsoCells << log2);
    const int step_log2 = log2 - 10;  // of the mesh
    run.side_along =
        kSide * side + along_of(side, corner[side % 2 == 0 ? 2 : 0], std::int64_t{along} << step_log2);
    run.up = corner.y + (std::int64_t{up} << step_log2);
  };
  for (const std::uint32_t number : meshes) {
    const typename Pool::Mesh& mesh = pool.mesh(number);
    for (std::uint32_t at = 0; at + FindRuns::kRunHeader <= mesh.rim;) {
      Run run;
      const int side = pool.rim_value(number, at);
      run.count = pool.rim_value(number, at + 1);
      run.mesh = number;
      run.first = at + FindRuns::kRunHeader;
      begin_of(mesh, side, pool.rim_value(number, run.first + 1), pool.rim_value(number, run.first + 2), run);
      at = run.first + run.count * static_cast<std::uint32_t>(FindRuns::kPointValues);
      if (!add_run(run)) return;
    }
  }
  sort_runs();
  std::size_t used = 0, points = 0;
  const Run* at = run_count_ == 0 ? nullptr : &storage_.runs[0];
  if (at == nullptr || at->side_along != 0) return;
  const std::int64_t first_up = at->up;
  for (;;) {
    if (++used > run_count_) return;
    const typename Pool::Mesh& mesh = pool.mesh(at->mesh);
    const auto side = static_cast<int>(at->side_along / kSide);
    Run end;
    for (std::uint32_t n = 0; n < at->count; ++n) {
      const std::uint32_t value = at->first + n * static_cast<std::uint32_t>(FindRuns::kPointValues);
      begin_of(mesh, side, pool.rim_value(at->mesh, value + 1), pool.rim_value(at->mesh, value + 2), end);
      if (n + 1 == at->count) break;  // the first of the next run
      if (points == storage_.points.size()) return;
      storage_.points[points++] = {pool.vertex_place(at->mesh, pool.rim_value(at->mesh, value)),
                                   end.side_along};
    }
    if (end.side_along == kSide * side + length(info, side)) end.side_along = kSide * (side + 1);
    if (end.side_along == 4 * kSide) {
      if (used != run_count_ || end.up != first_up) return;
      break;
    }
    at = find_run(end.side_along, end.up);
    if (at == nullptr) return;
  }
  point_count_ = points;
  if (!set_marks(info, column)) point_count_ = 0;
}

}  // namespace karst::core
