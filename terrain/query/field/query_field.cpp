// SPDX-License-Identifier: MIT
// A segment goes through blocks, and through the cells of a block, slice by slice along the axis on which it
// is longest. Of each slice all boxes are taken that the segment, grown by the sphere and by more than
// roundings, may reach between the slice's sides.
#include "terrain/query/field/query_field.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>

#include "terrain/isosurface/cell_tables.h"
#include "terrain/isosurface/edge_place.h"

namespace karst::core {
namespace {

constexpr int kBlock = ScalarField<std::int8_t>::kBlock;
// Cells. Places are less than 2^23 cells from the world's corner, of which a double keeps 2^-29.
constexpr double kMargin = 1e-6;

// A segment in cells from sample (0, 0, 0), and how far around it is looked.
struct CellWay {
  glm::dvec3 from, way;
  double reach;
  int along;  // the axis

  // Calls visit(place) for the boxes, `side` cells wide, of low..high (boxes, both included) that may be met,
  // until the slice that begins beyond limit().
  template <class Limit, class Visit>
  void each_box(glm::ivec3 low, glm::ivec3 high, double side, const Limit& limit, const Visit& visit) const {
    const bool back = way[along] < 0;
    for (int n = low[along]; n <= high[along]; ++n) {
      const int slice = back ? low[along] + high[along] - n : n;
      double first = 0, last = 1;
      const double below = slice * side - reach - from[along],
                   above = (slice + 1) * side + reach - from[along];
      if (way[along] == 0) {
        if (below > 0 || above < 0) continue;
      } else {
        const double inverse = 1 / way[along];
        first = std::max(first, (back ? above : below) * inverse - kMargin);
        last = std::min(last, (back ? below : above) * inverse + kMargin);
        if (first > last) continue;
        if (first > limit()) return;
      }
      glm::ivec3 begin = low, end = high;
      begin[along] = end[along] = slice;
      for (int axis = 0; axis < 3; ++axis) {
        if (axis == along) continue;
        const double a = from[axis] + first * way[axis], b = from[axis] + last * way[axis];
        const double least = (std::min(a, b) - reach) / side, most = (std::max(a, b) + reach) / side;
        begin[axis] = std::max(begin[axis], static_cast<int>(std::floor(std::max(least, -1.0))));
        end[axis] = std::min(end[axis], static_cast<int>(std::floor(std::min(most, 1e9))));
      }
      for (int z = begin.z; z <= end.z; ++z) {
        for (int y = begin.y; y <= end.y; ++y) {
          for (int x = begin.x; x <= end.x; ++x) visit(glm::ivec3(x, y, z));
        }
      }
    }
  }
};

template <class Sample>
class FieldWalk {
 public:
  using Field = ScalarField<Sample>;

  // low: where sample (0, 0, 0) lies, lattice steps.
  FieldWalk(const Field& field, const FieldInfo& info, glm::ivec3 low, QueryField::Walk& walk)
      : field_(field), walk_(walk), low_(low), drawn_(info.drawn_blocks()), cell_log2_(info.cell_log2) {}

  void run(const CellWay& way) const {
    const auto limit = [&] { return walk_.limit(); };
    way.each_box(glm::ivec3(0), drawn_ - 1, kBlock, limit, [&](glm::ivec3 block) {
      if (field_.are_alike(block, block + 1)) return;
      const glm::ivec3 first = block * kBlock;
      way.each_box(first, first + kBlock - 1, 1, limit, [&](glm::ivec3 cell) { visit_cell(block, cell); });
    });
  }

 private:
  // Corner n of a cell lies at n & 1 along x, n >> 1 & 1 along y and n >> 2 along z.
  void read_corners(glm::ivec3 block, glm::ivec3 cell, int (&value)[8]) const {
    const glm::ivec3 inside = cell - block * kBlock;
    const std::span<const Sample> samples = field_.block(block);
    if (!samples.empty() && glm::all(glm::lessThan(inside, glm::ivec3(kBlock - 1)))) {
      const Sample* const first = samples.data() + Field::offset(inside);
      for (int n = 0; n < 8; ++n) value[n] = first[Field::offset({n & 1, n >> 1 & 1, n >> 2})];
      return;
    }
    for (int n = 0; n < 8; ++n) value[n] = field_.at(cell + glm::ivec3(n & 1, n >> 1 & 1, n >> 2));
  }

  void visit_cell(glm::ivec3 block, glm::ivec3 cell) const {
    int value[8];
    read_corners(block, cell, value);
    unsigned state = 0;
    for (unsigned n = 0; n < 8; ++n) state |= (value[n] < 0 ? 1u : 0u) << n;
    const auto& found = kCellTable[state];
    const glm::ivec3 blocks = field_.blocks();
    const std::int64_t number =
        ((std::int64_t{block.z} * blocks.y + block.y) * blocks.x + block.x) * (kBlock * kBlock * kBlock) +
        static_cast<std::int64_t>(Field::offset(cell - block * kBlock));
    for (int t = 0; t < found.triangles; ++t) {
      glm::dvec3 corner[3];
      for (int k = 0; k < 3; ++k) corner[k] = vertex(found.edge[3 * t + k], cell, value);
      walk_.visit(number * 8 + t, corner);
    }
  }

  glm::dvec3 vertex(int edge, glm::ivec3 cell, const int (&value)[8]) const {
    const int axis = edge_axis(edge);
    const std::array<int, 3> start = edge_start(edge);
    const int low = start[0] + 2 * start[1] + 4 * start[2];
    const int steps = edge_crossing(value[low], value[low + (1 << axis)]);
    const glm::ivec3 from = cell + glm::ivec3(start[0], start[1], start[2]);
    glm::ivec3 place = from << cell_log2_;
    place[axis] += edge_steps(steps, 0, side_line(axis, from)) << (cell_log2_ - kLeastCellLog2);
    return glm::dvec3(low_ + place);
  }

  const Field& field_;
  QueryField::Walk& walk_;
  glm::ivec3 low_;
  glm::ivec3 drawn_;  // blocks
  int cell_log2_;
};

static_assert(1 << kLeastCellLog2 == kIsoStepsPerCell);

}  // namespace

void QueryField::run(const glm::dvec3& from, const glm::dvec3& way_steps, double radius, Walk& walk) const {
  const FieldInfo& info = field_->info();
  const double cells = 1.0 / (1 << info.cell_log2);  // a lattice step
  CellWay way;
  way.from = (from - glm::dvec3(low())) * cells;
  way.way = way_steps * cells;
  way.reach = 1.000002 * radius * cells + kMargin;
  way.along = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(way.way[axis]) > std::abs(way.way[way.along])) way.along = axis;
  }
  field_->with([&](const auto& field) {
    using Sample = std::remove_cvref_t<decltype(field.filling(glm::ivec3(0)))>;
    FieldWalk<Sample>(field, info, low(), walk).run(way);
  });
}

}  // namespace karst::core
