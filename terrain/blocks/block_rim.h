// SPDX-License-Identifier: MIT
// The rim of an isosurface that stands in a ground (terrain/ground/ground.h): the line in which the meshes
// that are drawn end in the region's four sides, whatever their levels. Sides, the walk and columns are those
// of terrain/regions/region_rim.h.
//
// Each mesh keeps its *runs*, pieces of that line one behind the other, when it is made: of kRunHeader values
// the side and how many vertices, then for each of these which of the mesh, and its place along the side and
// upwards, in steps of the mesh. A choice of blocks joins the runs of its meshes by the places of their ends,
// which are the same bits, to closed lines: the rim goes around the region, or there is none. Others are
// *loops*, where what is below the ground is cut by a side, or a coarse block does not have what a fine one
// beside it has: the belt fills them.
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
  static constexpr std::int64_t kSide = std::int64_t{1} << 32;

  struct Point {
    std::uint32_t vertex = 0;  // of the pages of meshes
    std::int64_t along = 0;    // kSide a side that was gone along, and lattice steps from its beginning
  };
  // Of a mesh: its vertices' place in the walk.
  struct Run {
    std::int64_t side_along = 0;  // of its beginning: a side, and along it; never a side's end
    std::int64_t up = 0;
    std::uint32_t mesh = 0;
    std::uint32_t first = 0;  // value of the mesh's
    std::uint32_t count = 0;  // vertices
    std::uint16_t side = 0;
    bool used = false;
  };
  struct Storage {
    std::span<Point> points;
    std::span<Run> runs;
    std::span<std::uint32_t> marks, loops;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      const std::size_t edges = config.field_blocks > 0 ? config.rim_edges : 0;
      visit(Consumer::fields, 2 * edges, points);
      visit(Consumer::fields, 2 * edges, runs);
      visit(Consumer::fields, edges, marks);
      visit(Consumer::fields, edges, loops);
    }
  };
  void create(const Storage& storage) { storage_ = storage; }

  // Whether there is a line, and so a surface that a ground can be joined to.
  bool exists() const { return point_count_ > 0; }
  void clear() { point_count_ = loop_count_ = 0; }
  std::span<const Point> points() const { return storage_.points.first(point_count_); }
  std::size_t loops() const { return loop_count_; }
  std::span<const Point> loop(std::size_t n) const {
    const std::uint32_t end = n + 1 < loop_count_ ? storage_.loops[n + 1] : all_points_;
    return storage_.points.subspan(storage_.loops[n], end - storage_.loops[n]);
  }
  std::uint32_t count() const { return static_cast<std::uint32_t>(point_count_); }
  // The first point that is not before a column's beginning; and the first column of a side, side 4:
  // columns().
  std::uint32_t mark(std::uint32_t column) const { return storage_.marks[column]; }
  std::uint32_t columns() const { return first_[4]; }
  std::uint32_t first_column(int side) const { return first_[side]; }

  // Joins the runs of meshes first..last - 1 (items(n) is the mesh's number) of a pool . column: lattice
  // steps of a column. No rim where they do not close, or there is no room.
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
  // One that is not used.
  Run* find_run(std::int64_t side_along, std::int64_t up);
  template <class Pool, class BeginOf>
  bool trace(const Pool& pool, const FieldInfo& info, Run& start, int& turns, const BeginOf& begin_of);
  bool set_marks(const FieldInfo& info, std::int64_t column);

  static std::int64_t length(const FieldInfo& info, int side) {
    return info.drawn_steps()[side % 2 == 0 ? 2 : 0];
  }

  // The end of a side is where the next one begins.
  static std::int64_t join(const FieldInfo& info, const Run& run) {
    const bool ends = run.side_along == kSide * run.side + length(info, run.side);
    return ends ? kSide * ((run.side + 1) % 4) : run.side_along;
  }

  Storage storage_;
  std::size_t point_count_ = 0;  // of the rim
  std::uint32_t all_points_ = 0;
  std::size_t loop_count_ = 0;
  std::size_t run_count_ = 0;
  std::uint32_t first_[5] = {};
};

template <class Pool>
void BlockRim::build(const Pool& pool, std::span<const std::uint32_t> meshes, const FieldInfo& info,
                     std::int64_t column) {
  clear();
  run_count_ = 0;
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
    run.side = static_cast<std::uint16_t>(side);
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
      run.side_along = join(info, run);
      at = run.first + run.count * static_cast<std::uint32_t>(FindRuns::kPointValues);
      if (!add_run(run)) return;
    }
  }
  sort_runs();
  // The rim begins in the first corner, above all else.
  std::size_t first = 0;
  while (first < run_count_ && storage_.runs[first].side_along == 0) ++first;
  bool found = false;
  int turns = 0;
  while (!found && first-- > 0) {
    all_points_ = 0;
    for (Run& run : storage_.runs.first(run_count_)) run.used = false;
    found = trace(pool, info, storage_.runs[first], turns, begin_of) && turns == 4;
  }
  if (!found) return;
  const std::uint32_t rim_points = all_points_;
  for (Run& run : storage_.runs.first(run_count_)) {
    if (run.used) continue;
    if (loop_count_ == storage_.loops.size()) return;
    storage_.loops[loop_count_++] = all_points_;
    // What is cut all around has no wall.
    if (!trace(pool, info, run, turns, begin_of) || turns != 0) return;
  }
  point_count_ = rim_points;
  if (!set_marks(info, column)) point_count_ = 0;
}

// From a run on until that comes again. turns: corners that it went around, less those backwards. False:
// it does not, or there is no room.
template <class Pool, class BeginOf>
bool BlockRim::trace(const Pool& pool, const FieldInfo& info, Run& start, int& turns,
                     const BeginOf& begin_of) {
  Run* at = &start;
  turns = 0;
  // In the first corner the last side ends.
  const int first = start.side_along == 0 && start.side == 3 ? -1 : 0;
  for (;;) {
    at->used = true;
    const typename Pool::Mesh& mesh = pool.mesh(at->mesh);
    const int side = at->side;
    Run end;
    for (std::uint32_t n = 0; n < at->count; ++n) {
      const std::uint32_t value = at->first + n * static_cast<std::uint32_t>(FindRuns::kPointValues);
      begin_of(mesh, side, pool.rim_value(at->mesh, value + 1), pool.rim_value(at->mesh, value + 2), end);
      if (n + 1 == at->count) break;  // the first of the next run
      if (all_points_ == storage_.points.size()) return false;
      storage_.points[all_points_++] = {pool.vertex_place(at->mesh, pool.rim_value(at->mesh, value)),
                                        end.side_along + kSide * (first + turns - side)};
    }
    end.side_along = join(info, end);
    const bool closes = end.side_along == start.side_along && end.up == start.up;
    at = closes ? &start : find_run(end.side_along, end.up);
    if (at == nullptr) return false;
    turns += at->side == side ? 0 : (at->side == (side + 1) % 4 ? 1 : -1);
    if (closes) return true;
  }
}

}  // namespace karst::core
