// SPDX-License-Identifier: MIT
// Cells are gone through slice by slice; vertices are made as soon as both ends of their edge are known and
// are found again by their edge (L 3.3 keeps two slices of cells; here two slices of edges).
#include "terrain/isosurface/extract_block.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "terrain/base/simd.h"
#include "terrain/isosurface/cell_tables.h"
#include "terrain/patch/octahedral.h"

namespace karst::core {
namespace {

constexpr int kCells = kIsoCells;
constexpr int kLines = kCells + 1;
constexpr int kRow = 32;             // samples of a row of the window, of which kLines + 2 are used
constexpr int kWindow = kLines + 2;  // with the samples around, for gradients
constexpr std::uint16_t kNoVertex = 0xffff;
// Of a cell, what vertices near transition cells make free of it.
constexpr int kShiftShare = 4;

template <std::size_t kSide>
struct PlaneEdges {
  std::uint16_t u[kSide + 1][kSide];  // [v][u] along u
  std::uint16_t v[kSide][kSide + 1];
};

// A vertex that made way has these remainders by 4 of its coordinates, by its edge's axis and whether the
// edge begins at an odd line. So those near a corner, whose six edges differ in that, stay apart, and none is
// on an edge, where those are that made none.
constexpr int kMovedSteps[3][2][3] = {{{1, 1, 1}, {3, 3, 3}}, {{1, 1, 3}, {3, 3, 1}}, {{1, 3, 1}, {3, 1, 3}}};

// Axes of a side: u, v, and w away from the neighbour, right-handed.
struct SideAxes {
  int u, v, w;
};
constexpr SideAxes axes_of(int side) {
  const int w = side >> 1;
  const int next = (w + 1) % 3, last = (w + 2) % 3;
  return side & 1 ? SideAxes{last, next, w} : SideAxes{next, last, w};
}

constexpr int place_index(glm::ivec3 o) {
  return o.x + 1 + 3 * (o.y + 1) + 9 * (o.z + 1);
}
constexpr glm::ivec3 side_step(int side) {
  glm::ivec3 step(0);
  step[side >> 1] = side & 1 ? 1 : -1;
  return step;
}

}  // namespace

template <class Sample>
struct ExtractBlock<Sample>::Room {
  alignas(16) Sample window[kWindow][kWindow][kRow];  // level 0: with those around; else without
  std::uint32_t solid[2][kLines];                     // of a slice's rows: bit x: solid
  std::uint16_t along_x[2][kLines][kCells];
  std::uint16_t along_y[2][kCells][kLines];
  std::uint16_t along_z[kLines][kLines];
  PlaneEdges<kCells> side[6];
  PlaneEdges<2 * kCells> fine;
  std::uint64_t fine_solid[2 * kCells + 1];
};

template <class Sample>
std::size_t ExtractBlock<Sample>::room_bytes() {
  return sizeof(Room);
}

namespace {

template <class Sample>
class Extraction {
 public:
  using Job = ExtractBlock<Sample>;
  using Room = typename Job::Room;

  Extraction(const Job& job, Room& room) : job_(job), field_(*job.field), room_(room), level_(job.level) {
    for (int side = 0; side < 6; ++side) transition_[side] = kind(side_step(side)) == IsoNeighbour::finer;
  }

  Status run(typename Job::Result& result) {
    if (!is_uniform()) {
      read_window();
      for (int side = 0; side < 6; ++side) {
        if (transition_[side]) std::memset(&room_.side[side], 0xff, sizeof room_.side[side]);
      }
      slice_edges(0);
      for (int z = 0; z < kCells; ++z) {
        slice_edges(z + 1);
        edges_along_z(z);
        cells(z);
      }
    }
    result.first_transition_triangle = triangle_count_;
    for (int side = 0; side < 6; ++side) {
      if (transition_[side]) transition_cells(side);
    }
    if (vertex_count_ > job_.vertices.size())
      return {StatusCode::limit_reached, "the block has more vertices", "vertices", vertex_count_};
    if (3 * std::size_t{triangle_count_} > job_.triangles.size())
      return {StatusCode::limit_reached, "the block has more triangles", "triangles",
              3 * std::size_t{triangle_count_}};
    result.vertices = vertex_count_;
    result.triangles = triangle_count_;
    return {};
  }

 private:
  struct Crossing {
    glm::ivec3 sample;  // the lower one of the finest edge
    int along = 0;      // from there, 1 / 1024 of a sample's distance
    int steps = 0;      // from the edge's beginning, in samples / 1024
    bool low_solid = false;
  };

  IsoNeighbour kind(glm::ivec3 o) const { return job_.around[static_cast<std::size_t>(place_index(o))]; }

  // Whether no sample of the block differs from others for sure.
  bool is_uniform() const {
    if (level_ != 0) return false;
    const glm::ivec3 first = job_.corner >> ScalarField<Sample>::kBlockLog2;
    return field_.are_alike(first, first + 1);
  }

  // --- Samples

  void read_window() {
    if (level_ == 0) {
      for (int z = 0; z < kWindow; ++z) {
        for (int y = 0; y < kWindow; ++y) read_row(y - 1, z - 1, room_.window[z][y]);
      }
      return;
    }
    for (int z = 0; z < kLines; ++z) {
      for (int y = 0; y < kLines; ++y) {
        for (int x = 0; x < kLines; ++x)
          room_.window[z + 1][y + 1][x + 1] =
              static_cast<Sample>(field_.at(job_.corner + (glm::ivec3(x, y, z) << level_)));
      }
    }
  }

  // Level 0: samples -1 .. 17 of a row.
  void read_row(int y, int z, Sample* out) const {
    constexpr int kBlock = ScalarField<Sample>::kBlock;
    const glm::ivec3 last = field_.samples() - 1;
    const glm::ivec3 at(job_.corner.x, glm::clamp(job_.corner.y + y, 0, last.y),
                        glm::clamp(job_.corner.z + z, 0, last.z));
    const glm::ivec3 block = at >> ScalarField<Sample>::kBlockLog2;
    const glm::ivec3 inside(0, at.y & (kBlock - 1), at.z & (kBlock - 1));
    const auto row = [&](int x, int from, int count, Sample* to) {
      const std::span<const Sample> samples = field_.block({x, block.y, block.z});
      if (samples.empty()) {
        std::fill_n(to, count, field_.filling({x, block.y, block.z}));
      } else {
        std::copy_n(samples.data() + ScalarField<Sample>::offset(inside) + from, count, to);
      }
    };
    row(block.x, 0, kBlock, out + 1);
    if (block.x > 0) {
      row(block.x - 1, kBlock - 1, 1, out);
    } else {
      out[0] = out[1];
    }
    if (block.x + 1 < field_.blocks().x) {
      row(block.x + 1, 0, 2, out + 1 + kBlock);
    } else {
      out[1 + kBlock] = out[2 + kBlock] = out[kBlock];
    }
  }

  // At level 0 within the window; samples from the block's corner.
  int near(glm::ivec3 s) const { return room_.window[s.z + 1][s.y + 1][s.x + 1]; }
  int sample(glm::ivec3 s) const {
    const bool in_window =
        level_ == 0 && s.x >= -1 && s.y >= -1 && s.z >= -1 && s.x <= kLines && s.y <= kLines && s.z <= kLines;
    return in_window ? near(s) : field_.at(job_.corner + s);
  }

  glm::vec3 gradient(glm::ivec3 s) const {
    glm::vec3 slope = central_gradient(s);
    if (job_.sides == 0) return slope;
    if ((job_.sides & 1u) != 0 && s.x == 0)
      slope.x = static_cast<float>(2 * (sample({1, s.y, s.z}) - sample(s)));
    if ((job_.sides & 8u) != 0 && s.z == 0)
      slope.z = static_cast<float>(2 * (sample({s.x, s.y, 1}) - sample(s)));
    return slope;
  }
  glm::vec3 central_gradient(glm::ivec3 s) const {
    return {static_cast<float>(sample({s.x + 1, s.y, s.z}) - sample({s.x - 1, s.y, s.z})),
            static_cast<float>(sample({s.x, s.y + 1, s.z}) - sample({s.x, s.y - 1, s.z})),
            static_cast<float>(sample({s.x, s.y, s.z + 1}) - sample({s.x, s.y, s.z - 1}))};
  }

  // --- Vertices

  // Of the edge from a sample on, `length` samples long, whose ends differ.
  Crossing cross(glm::ivec3 from, int axis, int length) const {
    glm::ivec3 low = from;
    int at_low = sample(low);
    glm::ivec3 high = from;
    high[axis] += length;
    int at_high = sample(high);
    for (int half = length / 2; half > 0; half /= 2) {
      glm::ivec3 middle = low;
      middle[axis] += half;
      const int value = sample(middle);
      if ((value < 0) == (at_low < 0)) {
        low = middle;
        at_low = value;
      } else {
        at_high = value;
      }
    }
    Crossing out;
    out.sample = low;
    out.along = edge_crossing(at_low, at_high);
    out.low_solid = at_low < 0;
    out.steps = (low[axis] - from[axis]) * kIsoStepsPerCell + out.along;
    return out;
  }

  std::uint16_t add_vertex(glm::ivec3 place, const Crossing& crossing, int axis, bool makes_way) {
    glm::ivec3 upper = crossing.sample;
    ++upper[axis];
    const auto along = static_cast<float>(crossing.along);
    const glm::vec3 slope = gradient(crossing.sample) * (1024.0f - along) + gradient(upper) * along;
    IsoVertex vertex{};
    vertex.normal = encode_octahedral(slope);
    if (job_.materials != nullptr)
      vertex.material = job_.materials->at(job_.corner + (crossing.low_solid ? crossing.sample : upper));
    const glm::ivec3 moved = makes_way ? make_way(place, axis, vertex.normal) : place;
    for (int k = 0; k < 3; ++k) {
      vertex.primary[k] = static_cast<std::int16_t>(place[k]);
      vertex.place[k] = static_cast<std::int16_t>(moved[k]);
    }
    if (vertex_count_ < job_.vertices.size()) job_.vertices[vertex_count_] = vertex;
    return static_cast<std::uint16_t>(vertex_count_++);
  }

  // Whether all blocks of the level that have a vertex make the same way for a side's transition cells, and
  // no block sees it that does not. planes: for each axis the side that the vertex lies on, or 0.
  bool is_agreed(int side, glm::ivec3 planes) const {
    planes[side >> 1] = 0;
    for (int subset = 1; subset < 8; ++subset) {
      glm::ivec3 o(0);
      bool counts = true;
      for (int k = 0; k < 3; ++k) {
        if ((subset >> k & 1) == 0) continue;
        counts = counts && planes[k] != 0;
        o[k] = planes[k];
      }
      if (!counts || kind(o) == IsoNeighbour::finer) continue;
      if (kind(o) == IsoNeighbour::coarser || kind(o + side_step(side)) != IsoNeighbour::finer) return false;
    }
    return true;
  }

  glm::ivec3 make_way(glm::ivec3 place, int axis, std::uint16_t normal) const {
    glm::vec3 way(0);
    const glm::ivec3 by = shift(place, normal, way);
    if (by == glm::ivec3(0)) return place;
    const int* const rest = kMovedSteps[axis][place[axis] / kIsoStepsPerCell & 1];
    glm::ivec3 moved;
    for (int k = 0; k < 3; ++k) {
      moved[k] = ((place[k] + by[k] - rest[k] + 2) >> 2) * 4 + rest[k];
      // Not beyond the side that it goes away from.
      if (way[k] > 0 && moved[k] < 0) moved[k] += 4;
      if (way[k] < 0 && moved[k] > kCells * kIsoStepsPerCell) moved[k] -= 4;
    }
    return moved;
  }

  // way: before it is turned into the tangent plane.
  glm::ivec3 shift(glm::ivec3 place, std::uint16_t normal, glm::vec3& way) const {
    constexpr int kEnd = kCells * kIsoStepsPerCell;
    glm::ivec3 planes(0);
    for (int k = 0; k < 3; ++k) planes[k] = place[k] == 0 ? -1 : (place[k] == kEnd ? 1 : 0);
    bool any = false;
    for (int side = 0; side < 6; ++side) {
      const int axis = side >> 1;
      const int from_side = side & 1 ? kEnd - place[axis] : place[axis];
      if (!transition_[side] || from_side >= kIsoStepsPerCell || !is_agreed(side, planes)) continue;
      way[axis] +=
          static_cast<float>((side & 1 ? from_side - kIsoStepsPerCell : kIsoStepsPerCell - from_side)) /
          kShiftShare;
      any = true;
    }
    if (!any) return glm::ivec3(0);
    const glm::vec3 n = decode_octahedral(normal);
    const float along = n.x * way.x + n.y * way.y + n.z * way.z;
    glm::ivec3 out;
    for (int k = 0; k < 3; ++k) {
      const float v = way[k] - n[k] * along;
      out[k] = static_cast<int>(v + (v < 0 ? -0.5f : 0.5f));
    }
    if ((job_.sides & (planes.x < 0 ? 1u : 4u)) != 0 && planes.x != 0) out.x = 0;
    if ((job_.sides & (planes.z < 0 ? 8u : 2u)) != 0 && planes.z != 0) out.z = 0;
    // A surface along the side cannot make way.
    for (int k = 0; k < 3; ++k) {
      if (way[k] != 0 && out[k] == 0) return glm::ivec3(0);
    }
    return out;
  }

  // Of the edge along an axis that begins at a cell's lower corner.
  std::uint16_t edge_vertex(int axis, glm::ivec3 cell) {
    const Crossing crossing = cross(cell << level_, axis, 1 << level_);
    const int line = side_line(axis, cell);
    glm::ivec3 place = cell * kIsoStepsPerCell;
    place[axis] += edge_steps(crossing.steps, level_, line);
    const std::uint16_t vertex = add_vertex(place, crossing, axis, true);
    if (line != kInside) note_side(axis, cell, vertex);
    return vertex;
  }

  void note_side(int axis, glm::ivec3 cell, std::uint16_t vertex) {
    for (int k = 0; k < 3; ++k) {
      if (k == axis || (cell[k] != 0 && cell[k] != kCells)) continue;
      const int side = 2 * k + (cell[k] == 0 ? 0 : 1);
      if (!transition_[side]) continue;
      const SideAxes axes = axes_of(side);
      if (axis == axes.u) {
        room_.side[side].u[cell[axes.v]][cell[axes.u]] = vertex;
      } else {
        room_.side[side].v[cell[axes.v]][cell[axes.u]] = vertex;
      }
    }
  }

  // --- Cells

  void slice_edges(int z) {
    std::uint32_t* solid = room_.solid[z & 1];
    for (int y = 0; y < kLines; ++y) {
      const Sample* const row = &room_.window[z + 1][y + 1][1];
      solid[y] = simd::signs(row) | static_cast<std::uint32_t>(row[kCells] < 0) << kCells;
    }
    for (int y = 0; y < kLines; ++y) {
      for (std::uint32_t bits = (solid[y] ^ solid[y] >> 1) & 0xffffu; bits != 0; bits &= bits - 1) {
        const int x = std::countr_zero(bits);
        room_.along_x[z & 1][y][x] = edge_vertex(0, {x, y, z});
      }
      if (y == kCells) break;
      for (std::uint32_t bits = solid[y] ^ solid[y + 1]; bits != 0; bits &= bits - 1) {
        const int x = std::countr_zero(bits);
        room_.along_y[z & 1][y][x] = edge_vertex(1, {x, y, z});
      }
    }
  }

  void edges_along_z(int z) {
    for (int y = 0; y < kLines; ++y) {
      for (std::uint32_t bits = room_.solid[0][y] ^ room_.solid[1][y]; bits != 0; bits &= bits - 1) {
        const int x = std::countr_zero(bits);
        room_.along_z[y][x] = edge_vertex(2, {x, y, z});
      }
    }
  }

  std::uint16_t vertex_of(int edge, int x, int y, int z) const {
    const int a = edge & 1, b = edge >> 1 & 1;
    switch (edge >> 2) {
      case 0:
        return room_.along_x[(z + b) & 1][y + a][x];
      case 1:
        return room_.along_y[(z + b) & 1][y][x + a];
      default:
        return room_.along_z[y + b][x + a];
    }
  }

  void cells(int z) {
    const std::uint32_t* const low = room_.solid[z & 1];
    const std::uint32_t* const high = room_.solid[(z + 1) & 1];
    for (int y = 0; y < kCells; ++y) {
      const std::uint32_t rows[4] = {low[y], low[y + 1], high[y], high[y + 1]};
      const std::uint32_t some = rows[0] | rows[1] | rows[2] | rows[3];
      const std::uint32_t all = rows[0] & rows[1] & rows[2] & rows[3];
      std::uint32_t mixed = (some | some >> 1) & ~(all & all >> 1) & 0xffffu;
      for (; mixed != 0; mixed &= mixed - 1) {
        const int x = std::countr_zero(mixed);
        unsigned state = 0;
        for (unsigned r = 0; r < 4; ++r) state |= (rows[r] >> x & 3u) << 2 * r;
        const auto& found = kCellTable[state];
        for (int n = 0; n < found.triangles; ++n) {
          const std::uint8_t* const edge = &found.edge[3 * n];
          add_triangle(vertex_of(edge[0], x, y, z), vertex_of(edge[1], x, y, z), vertex_of(edge[2], x, y, z));
        }
      }
    }
  }

  void add_triangle(std::uint16_t a, std::uint16_t b, std::uint16_t c) {
    const std::size_t first = 3 * std::size_t{triangle_count_++};
    if (first + 3 > job_.triangles.size()) return;
    job_.triangles[first] = a;
    job_.triangles[first + 1] = b;
    job_.triangles[first + 2] = c;
  }

  // --- Transition cells

  // Of a side's fine grid, its samples from the block's corner.
  glm::ivec3 side_sample(int side, const SideAxes& axes, int u, int v) const {
    glm::ivec3 s(0);
    s[axes.w] = side & 1 ? kCells << level_ : 0;
    s[axes.u] = u << (level_ - 1);
    s[axes.v] = v << (level_ - 1);
    return s;
  }

  std::uint16_t fine_vertex(int side, const SideAxes& axes, int u, int v, bool along_u) {
    std::uint16_t& vertex = along_u ? room_.fine.u[v][u] : room_.fine.v[v][u];
    if (vertex != kNoVertex) return vertex;
    const int axis = along_u ? axes.u : axes.v;
    const glm::ivec3 from = side_sample(side, axes, u, v);
    const Crossing crossing = cross(from, axis, 1 << (level_ - 1));
    glm::ivec3 place(0);
    place[axes.w] = side & 1 ? kCells * kIsoStepsPerCell : 0;
    place[axes.u] = u * (kIsoStepsPerCell / 2);
    place[axes.v] = v * (kIsoStepsPerCell / 2);
    place[axis] += edge_steps(crossing.steps, level_ - 1, along_u ? v : u) / 2;
    return vertex = add_vertex(place, crossing, axis, false);
  }

  void transition_cells(int side) {
    const SideAxes axes = axes_of(side);
    constexpr int kFineLines = 2 * kCells + 1;
    std::uint64_t any = 0, all = ~std::uint64_t{0} >> (64 - kFineLines);
    for (int v = 0; v < kFineLines; ++v) {
      std::uint64_t bits = 0;
      for (int u = 0; u < kFineLines; ++u)
        bits |= std::uint64_t{sample(side_sample(side, axes, u, v)) < 0} << u;
      room_.fine_solid[v] = bits;
      any |= bits;
      all &= bits;
    }
    if (any == 0 || all == ~std::uint64_t{0} >> (64 - kFineLines)) return;
    std::memset(&room_.fine, 0xff, sizeof room_.fine);
    for (int v = 0; v < kCells; ++v) {
      for (int u = 0; u < kCells; ++u) {
        unsigned state = 0;
        for (int row = 0; row < 3; ++row)
          state |= static_cast<unsigned>(room_.fine_solid[2 * v + row] >> 2 * u & 7u) << 3 * row;
        const auto& found = kTransitionTable[state];
        for (int n = 0; n < found.triangles; ++n) {
          std::uint16_t corner[3];
          for (int k = 0; k < 3; ++k) corner[k] = transition_vertex(side, axes, u, v, found.edge[3 * n + k]);
          add_triangle(corner[0], corner[1], corner[2]);
        }
      }
    }
  }

  std::uint16_t transition_vertex(int side, const SideAxes& axes, int u, int v, int edge) {
    if (edge < 6) return fine_vertex(side, axes, 2 * u + (edge & 1), 2 * v + edge / 2, true);
    if (edge < kFirstCoarseEdge)
      return fine_vertex(side, axes, 2 * u + (edge - 6) % 3, 2 * v + (edge - 6) / 3, false);
    const int second = edge & 1;
    return edge < kFirstCoarseEdge + 2 ? room_.side[side].u[v + second][u]
                                       : room_.side[side].v[v][u + second];
  }

  const Job& job_;
  const ScalarField<Sample>& field_;
  Room& room_;
  int level_;
  bool transition_[6] = {};
  std::uint32_t vertex_count_ = 0;
  std::uint32_t triangle_count_ = 0;
};

}  // namespace

template <class Sample>
Status ExtractBlock<Sample>::run(std::span<std::byte> room, Result& result) const {
  result = {};
  const auto refuse = [](const char* what, const char* name) {
    return Status(StatusCode::invalid_argument, what, name);
  };
  if (field == nullptr) return refuse("missing", "field");
  if (level < 0 || level > kIsoMaxLevel) return refuse("not within 0..8", "level");
  const int side = kIsoCells << level;
  for (int k = 0; k < 3; ++k) {
    if (corner[k] < 0 || corner[k] % side != 0 || corner[k] >= field->samples()[k])
      return refuse("not a block's of the level", "corner");
  }
  if (level == 0 && std::ranges::find(around, IsoNeighbour::finer) != around.end())
    return refuse("nothing is finer than level 0", "around");
  if (materials != nullptr && materials->blocks() != field->blocks())
    return refuse("not the field's", "materials");
  if (room.size() < sizeof(Room)) return refuse("too short", "room");
  return Extraction<Sample>(*this, *reinterpret_cast<Room*>(room.data())).run(result);
}

template struct ExtractBlock<std::int8_t>;
template struct ExtractBlock<std::int16_t>;

}  // namespace karst::core
