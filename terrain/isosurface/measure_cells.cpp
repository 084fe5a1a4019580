// SPDX-License-Identifier: MIT
#include "terrain/isosurface/measure_cells.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/isosurface/cell_loop.h"
#include "terrain/isosurface/cell_tables.h"

namespace karst::core {
namespace {

// Cells: what float makes of 0.
constexpr float kNoise = 1e-5f;
// From where on loops of other cells are looked at.
constexpr float kFarFromOwn = 0.08f;
constexpr int kGrid = 27;  // samples of a cell: 3 each way, 1, 3 and 9 apart
constexpr std::array<int, 3> kStride{1, 3, 9};
constexpr std::size_t kMostFine = 54;

template <class Sample>
class Cell {
 public:
  Cell(const ScalarField<Sample>& field, int level, glm::ivec3 cell)
      : field_(field), level_(level), low_(cell << level) {}

  // enough: less than that is not looked at closely.
  CellDistance measure(float enough) {
    read();
    find_loops();
    if (loops_ == 0) return lost(enough);
    if (is_enough(enough * enough)) return {};
    for (Loop& loop : std::span(loop_).first(loops_)) loop.measure();
    enough = std::max(enough, kFarFromOwn);
    Distances there;
    there.fill(kUnknown);
    for (const Loop& loop : loops()) towards(loop, there);
    float most = greatest(there);
    int reach = 0;
    if (most > enough) {
      most = from_neighbours(there);
      reach = 1;
    }
    for (const Loop& loop : loops()) {
      unsigned faces = 0;
      float from = back(loop, faces);
      if (from > std::max(most, enough) && faces != 0) {
        from = std::min(from, back_around(loop, faces));
        reach = 1;
      }
      most = std::max(most, from);
    }
    return {most, reach};
  }

 private:
  using FineTriangle = std::array<std::uint8_t, 3>;             // vertices
  using Distances = std::array<float, 8 * kMostCellTriangles>;  // of triangles of F

  void read() {
    const int step = 1 << (level_ - 1);
    for (int n = 0; n < kGrid; ++n)
      value_[static_cast<std::size_t>(n)] = field_.at(low_ + glm::ivec3(n % 3, n / 3 % 3, n / 9) * step);
    find_fine();
  }
  std::span<const Loop> loops() const { return std::span<const Loop>(loop_).first(loops_); }
  bool solid(int n) const { return value_[static_cast<std::size_t>(n)] < 0; }
  // Samples of the finest level along an edge of `length` of them; a part of a cell from its beginning.
  float crossing(glm::ivec3 from, int axis, int length) const {
    glm::ivec3 low = from, high = from;
    high[axis] += length;
    int at_low = field_.at(low), at_high = field_.at(high);
    for (int half = length / 2; half > 0; half /= 2) {
      glm::ivec3 middle = low;
      middle[axis] += half;
      const int value = field_.at(middle);
      if ((value < 0) == (at_low < 0)) {
        low = middle;
        at_low = value;
      } else {
        at_high = value;
      }
    }
    const int a = std::abs(2 * at_low + 1), b = std::abs(2 * at_high + 1);
    const float along = static_cast<float>(a) / static_cast<float>(a + b);
    return (static_cast<float>(low[axis] - from[axis]) + along) / static_cast<float>(1 << level_);
  }
  glm::vec3 place(glm::ivec3 sample, int axis, int length) const {
    glm::vec3 at = glm::vec3(sample - low_) / static_cast<float>(1 << level_);
    at[axis] += crossing(sample, axis, length);
    return at;
  }
  // The vertex on the edge of half a cell from sample n of the grid on.
  std::uint8_t fine_vertex(int n, int axis) {
    std::uint8_t& vertex = vertex_at_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(n)];
    if (vertex == kNone) {
      const glm::ivec3 grid(n % 3, n / 3 % 3, n / 9);
      vertex = static_cast<std::uint8_t>(vertices_);
      at_[vertices_] = place(low_ + (grid << (level_ - 1)), axis, 1 << (level_ - 1));
      unsigned faces = 0;
      for (int k = 0; k < 3; ++k) {
        if (k == axis) continue;
        faces |= (grid[k] == 0 ? 1u : 0u) << 2 * k | (grid[k] == 2 ? 2u : 0u) << 2 * k;
      }
      faces_[vertices_++] = faces;
    }
    return vertex;
  }
  void find_fine() {
    for (auto& axis : vertex_at_) axis.fill(kNone);
    for (int part = 0; part < 8; ++part) {
      const int first = (part & 1) + 3 * (part >> 1 & 1) + 9 * (part >> 2);
      unsigned state = 0;
      for (int o = 0; o < 8; ++o)
        state |= unsigned{solid(first + (o & 1) + 3 * (o >> 1 & 1) + 9 * (o >> 2))} << o;
      const auto& found = kCellTable[state];
      for (std::size_t t = 0; t < found.triangles; ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
          const int edge = found.edge[3 * t + k];
          const std::array<int, 3> start = edge_start(edge);
          fine_[fine_count_][k] =
              fine_vertex(first + start[0] + 3 * start[1] + 9 * start[2], edge_axis(edge));
        }
        ++fine_count_;
      }
    }
  }
  // at(edge): where a vertex of the level is.
  template <class At>
  static std::size_t make_loops(unsigned state, std::span<Loop, 4> loops, const At& at) {
    const auto& found = kCellTable[state];
    unsigned of_loop = 0;
    std::size_t count = 0;
    for (std::size_t t = 0; t < found.triangles; ++t) {
      const std::uint8_t* const edges = &found.edge[3 * t];
      // Triangles of a loop follow each other.
      const unsigned mask = 1u << edges[0] | 1u << edges[1] | 1u << edges[2];
      if ((mask & of_loop) == 0) {
        loops[count++] = {};
        of_loop = 0;
      }
      of_loop |= mask;
      Loop& loop = loops[count - 1];
      for (std::size_t k = 0; k < 3; ++k) {
        loop.edge[loop.triangles][k] = edges[k];
        loop.triangle[loop.triangles].at[k] = at(edges[k]);
      }
      ++loop.triangles;
    }
    return count;
  }
  void find_loops() {
    unsigned state = 0;
    for (int o = 0; o < 8; ++o)
      state |= unsigned{solid(2 * ((o & 1) + 3 * (o >> 1 & 1) + 9 * (o >> 2)))} << o;
    loops_ = make_loops(state, loop_, [&](int edge) {
      const std::array<int, 3> start = edge_start(edge);
      const int axis = edge_axis(edge);
      // One half of the edge has its crossing.
      int n = 2 * (start[0] + 3 * start[1] + 9 * start[2]);
      const int middle = n + kStride[static_cast<std::size_t>(axis)];
      if (solid(n) == solid(middle)) n = middle;
      const std::uint8_t vertex = fine_vertex(n, axis);
      kept_ |= std::uint64_t{1} << vertex;
      return at_[vertex];
    });
  }

  // Whether it is seen at once that both ways are within a distance: by vertices of the loops alone.
  bool is_enough(float most2) const {
    for (const Loop& loop : loops()) {
      if (longest2(loop) / 3 > most2) return false;
    }
    const auto is_near = [&](const FineTriangle& t, glm::vec3 p) {
      return squared(at_[t[0]] - p) <= most2 && squared(at_[t[1]] - p) <= most2 &&
             squared(at_[t[2]] - p) <= most2;
    };
    for (std::size_t n = 0; n < fine_count_; ++n) {
      bool is_one = false;
      for (std::uint64_t kept = kept_; kept != 0 && !is_one; kept &= kept - 1)
        is_one = is_near(fine_[n], at_[static_cast<std::size_t>(std::countr_zero(kept))]);
      if (!is_one) return false;
    }
    return true;
  }
  static float longest2(const Loop& loop) {
    float longest = 0;
    for (std::size_t n = 0; n < loop.triangles; ++n) {
      const auto& at = loop.triangle[n].at;
      for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, squared(at[(k + 1) % 3] - at[k]));
    }
    return longest;
  }

  // From triangles of F to a loop, where it is nearer than what they have; of those that are far.
  void towards(const Loop& loop, Distances& least) const {
    std::array<std::array<float, kMostCellTriangles>, kMostFine> off;  // squared, by vertex
    std::uint64_t known = 0;
    for (std::size_t n = 0; n < fine_count_; ++n) {
      if (least[n] <= kFarFromOwn) continue;
      float any = 0;
      std::array<float, kMostCellTriangles> one{};
      for (const std::uint8_t v : fine_[n]) {
        if ((known >> v & 1) == 0) {
          for (std::size_t k = 0; k < loop.triangles; ++k) off[v][k] = loop.triangle[k].distance2(at_[v]);
          known |= std::uint64_t{1} << v;
        }
        float nearest = kUnknown;
        for (std::size_t k = 0; k < loop.triangles; ++k) {
          nearest = std::min(nearest, off[v][k]);
          one[k] = std::max(one[k], off[v][k]);
        }
        any = std::max(any, nearest);
      }
      float best = std::sqrt(any) + loop.thickness;
      for (std::size_t k = 0; k < loop.triangles; ++k) best = std::min(best, std::sqrt(one[k]));
      least[n] = std::min(least[n], best);
    }
  }
  float greatest(const Distances& of) const {
    return *std::max_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(fine_count_));
  }

  // faces: those by which F's outline goes into that of the loop.
  float back(const Loop& loop, unsigned& faces) const {
    const float any = std::sqrt(longest2(loop) / 3);
    return std::min(any, back_of_graph(loop, faces));
  }

  // How far F's outline is from the loop's, and how far as seen along its normal. clean: each face has one
  // side of the outline, which F's follows.
  struct Beside {
    float off = 0, across = 0;
    bool clean = true;
  };
  Beside beside(const Loop& loop) const {
    std::array<int, 6> side_of{};  // a face's, or -1
    side_of.fill(-1);
    Beside out;
    for (std::size_t n = 0; n < loop.outlined; ++n) {
      const std::size_t next = n + 1 < loop.outlined ? n + 1 : 0;
      const unsigned both = faces_of(loop.outline_edge[n]) & faces_of(loop.outline_edge[next]);
      for (std::size_t f = 0; f < 6; ++f) {
        if ((both >> f & 1) == 0) continue;
        out.clean = out.clean && side_of[f] < 0;
        side_of[f] = static_cast<int>(n);
      }
    }
    for (std::size_t v = 0; v < vertices_; ++v) {
      if ((kept_ >> v & 1) != 0 || faces_[v] == 0) continue;
      out.clean = out.clean && std::popcount(faces_[v]) == 1 && side_of[face_of(faces_[v])] >= 0;
    }
    float off2 = 0, across2 = 0;
    for (std::size_t n = 0; n < fine_count_; ++n) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint8_t a = fine_[n][k], b = fine_[n][(k + 1) % 3];
        const unsigned faces = faces_[a] & faces_[b];
        if (faces == 0) continue;
        float least = kUnknown;
        std::size_t nearest = 0;
        for (std::size_t side = 0; side < loop.outlined; ++side) {
          if (out.clean && side_of[face_of(faces)] != static_cast<int>(side)) continue;
          const float far = from_side(loop, side, at_[a], at_[b], glm::vec3(0.0f));
          if (far < least) nearest = side;
          least = std::min(least, far);
        }
        off2 = std::max(off2, least);
        across2 = std::max(across2, from_side(loop, nearest, at_[a], at_[b], loop.mean));
      }
    }
    out.off = std::sqrt(off2);
    out.across = std::sqrt(across2);
    return out;
  }
  static std::size_t face_of(unsigned faces) { return static_cast<std::size_t>(std::countr_zero(faces)); }
  // The farther of two points from a side of the outline, squared; as seen along a unit vector or 0.
  static float from_side(const Loop& loop, std::size_t side, glm::vec3 a, glm::vec3 b, glm::vec3 along) {
    const auto seen = [&](glm::vec3 p) { return p - along * glm::dot(p, along); };
    const glm::vec3 from = seen(loop.outline[side]);
    const glm::vec3 to = seen(loop.outline[side + 1 < loop.outlined ? side + 1 : 0]);
    return std::max(from_segment(seen(a), from, to), from_segment(seen(b), from, to));
  }
  static unsigned faces_of(int edge) {
    const std::array<int, 3> start = edge_start(edge);
    unsigned faces = 0;
    for (int k = 0; k < 3; ++k) {
      if (k != edge_axis(edge)) faces |= 1u << (2 * k + start[static_cast<std::size_t>(k)]);
    }
    return faces;
  }

  // Where the finer surface is one without folds over the loop, or follows its outline.
  float back_of_graph(const Loop& loop, unsigned& faces) const {
    if (loops_ != 1 || loop.thickness == kUnknown) return kUnknown;
    const float steep = std::sqrt(1 + loop.slope * loop.slope);
    const Beside r = beside(loop);
    // From the loop's outline to F.
    float from_outline = r.off;
    if (!r.clean) {
      const float up = r.off + 2 * r.across * loop.slope;
      from_outline = std::sqrt(r.across * r.across + up * up);
    }
    const float anywhere = r.clean ? loop.radius * steep + r.off : kUnknown;
    std::array<SheetTriangle, 8 * kMostCellTriangles> own;
    add_to_sheet(glm::ivec3(0), 0x3f, own);
    const Sheet sheet = over(loop, std::span<const SheetTriangle>(own).first(fine_count_));
    const float rest = sheet.inwards > kNoise ? sheet.inwards * steep + from_outline : 0;
    faces = sheet.faces;
    return std::min(anywhere, std::max(sheet.off, rest));
  }
  // The same of F in the cells beyond some faces, too, where its outline is not within that of the loop.
  float back_around(const Loop& loop, unsigned faces) const {
    std::array<SheetTriangle, 8 * 8 * kMostCellTriangles> all;
    std::size_t count = 0;
    glm::ivec3 low(0), high(0);
    for (int k = 0; k < 3; ++k) {
      if ((faces >> 2 * k & 3) == 3) return kUnknown;
      if ((faces >> 2 * k & 1) != 0) low[k] = -1;
      if ((faces >> 2 * k & 2) != 0) high[k] = 1;
    }
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          const glm::ivec3 o(x, y, z), corner = low_ + (o << level_);
          if (!is_inside(corner)) return kUnknown;
          unsigned outer = 0;
          for (int k = 0; k < 3; ++k)
            outer |= ((o[k] == low[k] ? 1u : 0u) | (o[k] == high[k] ? 2u : 0u)) << 2 * k;
          Cell beside(field_, level_, corner >> level_);
          beside.read();
          beside.add_to_sheet(o, outer, std::span(all).subspan(count));
          count += beside.fine_count_;
        }
      }
    }
    const Sheet sheet = over(loop, std::span<const SheetTriangle>(all).first(count));
    return sheet.inwards > kNoise ? kUnknown : sheet.off;
  }

  struct SheetTriangle {
    CellTriangle triangle;
    std::array<unsigned, 3> outer{};  // of a side that the outline of all has: the faces that it lies in
  };
  // offset: of the cell, cells. outer: faces where all ends.
  void add_to_sheet(glm::ivec3 offset, unsigned outer, std::span<SheetTriangle> out) const {
    for (std::size_t n = 0; n < fine_count_; ++n) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint8_t a = fine_[n][k], b = fine_[n][(k + 1) % 3];
        out[n].triangle.at[k] = at_[a] + glm::vec3(offset);
        out[n].outer[k] = faces_[a] & faces_[b] & outer;
      }
      out[n].triangle.find_normal();
    }
  }
  struct Sheet {
    float off = kUnknown;  // from the loop to F, where that covers it
    unsigned faces = 0;    // by which F's outline goes into that of the loop
    float inwards = 0;     // how far into the loop's outline that of F goes at most, as seen along its normal
  };
  static Sheet over(const Loop& loop, std::span<const SheetTriangle> sheet) {
    Sheet out;
    for (const SheetTriangle& t : sheet) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (t.outer[k] == 0) continue;
        const float deep = depth(loop, t.triangle.at[k], t.triangle.at[(k + 1) % 3]);
        if (deep > kNoise) out.faces |= t.outer[k];
        out.inwards = std::max(out.inwards, deep);
      }
    }
    float off = 0;
    bool within = false;
    for (const SheetTriangle& t : sheet) {
      const float one = sheet_over(loop, t.triangle);
      if (one < 0) continue;
      if (!(glm::dot(t.triangle.normal, loop.mean) >= -kNoise)) return {kUnknown, out.faces, out.inwards};
      off = std::max(off, one);
      const auto& at = t.triangle.at;
      for (const glm::vec3 p : {(at[0] + at[1] + at[2]) / 3.0f, at[0], at[1], at[2]})
        within = within || is_within(loop, p, out.inwards);
    }
    if (within) out.off = off;
    return out;
  }
  // From a loop to the part of a triangle of F that lies over it, along the normal: greatest at corners of
  // what both have in common as seen along that. Below 0: none.
  static float sheet_over(const Loop& loop, const CellTriangle& t) {
    float most = -1;
    for (std::size_t n = 0; n < loop.triangles; ++n) {
      const CellTriangle& below = loop.triangle[n];
      // 3 corners, and at most half of them and as many crossings more with each side.
      std::array<glm::vec3, 9> part{t.at[0], t.at[1], t.at[2]};
      std::size_t count = 3;
      for (std::size_t k = 0; k < 3 && count > 0; ++k) {
        const glm::vec3 from = below.at[k], inner = glm::cross(loop.mean, below.at[(k + 1) % 3] - from);
        std::array<glm::vec3, 9> next;
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
          const glm::vec3 p = part[i], q = part[i + 1 < count ? i + 1 : 0];
          const float at_p = glm::dot(inner, p - from), at_q = glm::dot(inner, q - from);
          if (at_p >= 0) next[kept++] = p;
          if ((at_p >= 0) != (at_q >= 0)) next[kept++] = p + (q - p) * (at_p / (at_p - at_q));
        }
        part = next;
        count = kept;
      }
      const float along = glm::dot(below.normal, loop.mean);
      for (std::size_t i = 0; i < count; ++i)
        most = std::max(most, std::abs(glm::dot(part[i] - below.at[0], below.normal)) / along);
    }
    return most;
  }
  static float depth(const Loop& loop, glm::vec3 a, glm::vec3 b) {
    float least = kUnknown;
    for (std::size_t side = 0; side < loop.outlined; ++side) {
      const glm::vec3 inner = inwards_of(loop, side), from = loop.outline[side];
      const float deeper = std::max(glm::dot(inner, a - from), glm::dot(inner, b - from));
      least = std::min(least, deeper / std::sqrt(squared(inner)));
    }
    return std::max(least, 0.0f);
  }
  static glm::vec3 inwards_of(const Loop& loop, std::size_t side) {
    return glm::cross(loop.mean, loop.outline[side + 1 < loop.outlined ? side + 1 : 0] - loop.outline[side]);
  }
  // As seen along the loop's normal: within its outline, further than r from it.
  static bool is_within(const Loop& loop, glm::vec3 p, float r) {
    for (std::size_t n = 0; n < loop.outlined; ++n) {
      const glm::vec3 inner = inwards_of(loop, n);
      if (!(glm::dot(inner, p - loop.outline[n]) > r * std::sqrt(squared(inner)))) return false;
    }
    return true;
  }

  // --- What the level lacks

  CellDistance lost(float enough) const {
    Distances there;
    there.fill(kUnknown);
    float near = from_neighbours(there);
    if (near <= enough) return {near, 1};
    near = std::min(near, from_vertices(1));
    const float width = shut_in();
    if (std::min(near, width) < kUnknown) return {std::min(near, width), 1};
    for (const int reach : {3, kFarCells}) {
      const float far = from_vertices(reach);
      if (far < kUnknown) return {far, kFarCells};
    }
    return {kUnknown, kFarCells};
  }
  // To the loops of the cells around, too, where those are nearer.
  float from_neighbours(Distances& least) const {
    std::array<Loop, 4> loops;
    for (int n = 0; n < 27; ++n) {
      const glm::ivec3 corner = low_ + (glm::ivec3(n % 3, n / 3 % 3, n / 9) - 1 << level_);
      if (n == 13 || !is_inside(corner)) continue;
      unsigned state = 0;
      for (int o = 0; o < 8; ++o)
        state |= unsigned{field_.at(corner + (glm::ivec3(o & 1, o >> 1 & 1, o >> 2) << level_)) < 0} << o;
      const std::size_t count = make_loops(state, loops, [&](int edge) {
        const std::array<int, 3> start = edge_start(edge);
        return place(corner + (glm::ivec3(start[0], start[1], start[2]) << level_), edge_axis(edge),
                     1 << level_);
      });
      for (std::size_t k = 0; k < count; ++k) {
        loops[k].measure();
        towards(loops[k], least);
      }
    }
    return greatest(least);
  }
  // Of the field: beyond it there is no finer surface.
  bool is_inside(glm::ivec3 sample) const {
    const glm::ivec3 size = field_.samples();
    for (int k = 0; k < 3; ++k) {
      if (sample[k] < 0 || sample[k] >= size[k]) return false;
    }
    return true;
  }
  // To vertices of the level within so many cells.
  float from_vertices(int reach) const {
    Distances least;
    least.fill(kUnknown);
    const int side = 2 * reach + 2;
    const auto corner = [&](int x, int y, int z) { return low_ + ((glm::ivec3(x, y, z) - reach) << level_); };
    for (int z = 0; z < side; ++z) {
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
          const glm::ivec3 at = corner(x, y, z);
          if (!is_inside(at)) continue;
          const bool is_solid = field_.at(at) < 0;
          for (int axis = 0; axis < 3; ++axis) {
            if (glm::ivec3(x, y, z)[axis] + 1 == side) continue;
            glm::ivec3 next = at;
            next[axis] += 1 << level_;
            if ((field_.at(next) < 0) == is_solid) continue;
            const glm::vec3 vertex = place(at, axis, 1 << level_);
            for (std::size_t n = 0; n < fine_count_; ++n) {
              float far = 0;
              for (const std::uint8_t v : fine_[n]) far = std::max(far, squared(at_[v] - vertex));
              least[n] = std::min(least[n], far);
            }
          }
        }
      }
    }
    float most = 0;
    for (std::size_t n = 0; n < fine_count_; ++n) most = std::max(most, least[n]);
    return std::sqrt(most);
  }
  // All that is finer around has one sign where the cells around end: its width, else kUnknown.
  float shut_in() const {
    constexpr int kSide = 7;
    bool sign[kSide][kSide][kSide];
    const int step = 1 << (level_ - 1);
    for (int z = 0; z < kSide; ++z) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          sign[z][y][x] = field_.at(low_ + (glm::ivec3(x, y, z) - 2) * step) < 0;
          const bool outer = x % 6 == 0 || y % 6 == 0 || z % 6 == 0;
          if (outer && sign[z][y][x] != sign[0][0][0]) return kUnknown;
        }
      }
    }
    glm::ivec3 first(kSide), last(0);
    for (int z = 0; z < kSide; ++z) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          if (sign[z][y][x] == sign[0][0][0]) continue;
          first = glm::min(first, glm::ivec3(x, y, z) - 1);
          last = glm::max(last, glm::ivec3(x, y, z) + 1);
        }
      }
    }
    return 0.5f * std::sqrt(squared(glm::vec3(last - first)));
  }

  static constexpr std::uint8_t kNone = 0xff;

  const ScalarField<Sample>& field_;
  int level_;
  glm::ivec3 low_;  // sample
  std::array<int, kGrid> value_{};
  std::array<std::array<std::uint8_t, kGrid>, 3> vertex_at_;
  std::array<glm::vec3, kMostFine> at_;  // cells
  std::array<unsigned, kMostFine> faces_{};
  std::size_t vertices_ = 0;
  std::uint64_t kept_ = 0;  // vertices of the level, too
  std::array<FineTriangle, 8 * kMostCellTriangles> fine_;
  std::size_t fine_count_ = 0;
  std::array<Loop, 4> loop_;
  std::size_t loops_ = 0;
};

}  // namespace

template <class Sample>
CellDistance MeasureCells<Sample>::run(glm::ivec3 low, glm::ivec3 high, float enough) const {
  const glm::ivec3 last = glm::min(high, (field->samples() - 1) >> level);
  const int step = 1 << (level - 1);
  CellDistance out;
  for (int z = low.z; z <= last.z; ++z) {
    for (int y = low.y; y <= last.y; ++y) {
      // Nine rows of samples of half a cell: a bit each where one is solid, and where all are.
      std::uint64_t any = 0, all = ~std::uint64_t{0};
      const int width = 2 * (last.x - low.x + 1) + 1;
      for (int row = 0; row < 9; ++row) {
        std::uint64_t bits = 0;
        const glm::ivec3 first(low.x << level, (2 * y + row % 3) * step, (2 * z + row / 3) * step);
        for (int x = 0; x < width; ++x)
          bits |= std::uint64_t{field->at(first + glm::ivec3(x * step, 0, 0)) < 0} << x;
        any |= bits;
        all &= bits;
      }
      for (int x = low.x; x <= last.x; ++x) {
        const int at = 2 * (x - low.x);
        if ((any >> at & 7) == 0 || (all >> at & 7) == 7) continue;
        const CellDistance one = Cell<Sample>(*field, level, {x, y, z}).measure(std::max(out.most, enough));
        out.most = std::max(out.most, one.most);
        out.reach = std::max(out.reach, one.reach);
      }
    }
  }
  return out;
}

template struct MeasureCells<std::int8_t>;
template struct MeasureCells<std::int16_t>;

}  // namespace karst::core
