// SPDX-License-Identifier: MIT
// Generation of the case tables. Each configuration goes through three steps:
//   curves: on every face, one curve around each run of filled corners (design 4.2: around the filled voxels,
//   always); loops:  every edge point ends one curve and starts one, so the curves close into loops; fill: a
//   loop becomes one to three patches by the rule for its curve types.
// The fills are those with the least crease among all divisions of a loop into at most three three- and
// four-edge patches whose inner edges run edge point - L - edge point; tests/property/crease_test.cpp
// searches them all.
#include "terrain/surface/bezier/case_tables.h"

namespace karst::core {
namespace {

using Point = std::array<std::int8_t, 3>;

constexpr int kAxes = 3;

constexpr Point midpoint(Point a, Point b) {
  Point m{};
  for (std::size_t k = 0; k < 3; ++k) m[k] = static_cast<std::int8_t>((a[k] + b[k]) / 2);
  return m;
}

constexpr int octant(Point corner) {
  return (corner[0] > 0 ? 1 : 0) + (corner[1] > 0 ? 2 : 0) + (corner[2] > 0 ? 4 : 0);
}

constexpr bool is_filled(int configuration, Point corner) {
  return (configuration >> octant(corner) & 1) != 0;
}

constexpr Point face_center(int face) {
  Point c{};
  c[static_cast<std::size_t>(face / 2)] = static_cast<std::int8_t>(face % 2 != 0 ? 1 : -1);
  return c;
}

// The four voxel centres at the corners of a face, counter-clockwise as seen from outside the cube.
constexpr std::array<Point, 4> face_ring(int face) {
  const std::size_t axis = static_cast<std::size_t>(face / 2);
  std::size_t u = (axis + 1) % kAxes;
  std::size_t v = (axis + 2) % kAxes;
  if (face % 2 == 0) {
    const std::size_t t = u;
    u = v;
    v = t;
  }
  constexpr int kTurn[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  std::array<Point, 4> ring{};
  for (std::size_t i = 0; i < 4; ++i) {
    ring[i] = face_center(face);
    ring[i][u] = static_cast<std::int8_t>(kTurn[i][0]);
    ring[i][v] = static_cast<std::int8_t>(kTurn[i][1]);
  }
  return ring;
}

constexpr std::size_t point_key(Point p) {
  return static_cast<std::size_t>((p[0] + 1) + 3 * (p[1] + 1) + 9 * (p[2] + 1));
}

struct DirectedCurve {
  bool exists = false;
  LoopCurve curve;
  Point end{};
};

// Curves by the key of their start. Filled voxels lie to the right as seen from outside the cube, which makes
// the loops counter-clockwise as seen from the empty side.
constexpr std::array<DirectedCurve, 27> directed_curves(int configuration) {
  std::array<DirectedCurve, 27> curves{};
  for (int face = 0; face < 6; ++face) {
    const std::array<Point, 4> ring = face_ring(face);
    bool filled[4]{};
    int runs = 0;
    for (std::size_t i = 0; i < 4; ++i) filled[i] = is_filled(configuration, ring[i]);
    for (std::size_t i = 0; i < 4; ++i) runs += filled[i] && !filled[(i + 3) % 4];
    for (std::size_t i = 0; i < 4; ++i) {
      if (!filled[i] || filled[(i + 3) % 4]) continue;
      std::size_t length = 1;
      while (filled[(i + length) % 4]) ++length;
      DirectedCurve c;
      c.exists = true;
      c.curve.start = midpoint(ring[(i + 3) % 4], ring[i]);
      c.end = midpoint(ring[(i + length - 1) % 4], ring[(i + length) % 4]);
      c.curve.face = static_cast<std::uint8_t>(face);
      // Two runs are two single voxels, diagonal to each other: the higher octant is curve 1.
      c.curve.curve = runs == 2 && octant(ring[i]) > octant(ring[(i + 2) % 4]) ? 1 : 0;
      c.curve.straight = length == 2;
      curves[point_key(c.curve.start)] = c;
    }
  }
  return curves;
}

constexpr Loops make_loops(int configuration) {
  std::array<DirectedCurve, 27> curves = directed_curves(configuration);
  Loops loops;
  for (std::size_t first = 0; first < curves.size(); ++first) {
    if (!curves[first].exists) continue;
    Loop& loop = loops.loop[static_cast<std::size_t>(loops.count++)];
    std::size_t at = first;
    do {
      loop.curve[static_cast<std::size_t>(loop.size++)] = curves[at].curve;
      curves[at].exists = false;
      at = point_key(curves[at].end);
    } while (at != first);
  }
  return loops;
}

// How a loop is filled. `straight`: curve types in order, '1' straight. A piece lists three or four positions
// in the loop, counter-clockwise; a three-edge piece is collapsed at its first.
struct Piece {
  int size = 0;
  int at[4]{};
};
struct Fill {
  int loop_size = 0;
  const char* straight = "";
  bool opposite =
      false;  // positions 0 and 3 must be opposite edge points: else their common edge would be a fold
  int pieces = 0;
  Piece piece[3];
};
constexpr Fill kFills[] = {
    {3, "000", false, 1, {{3, {0, 1, 2}}}},
    {4, "0101", false, 1, {{4, {0, 1, 2, 3}}}},
    {4, "1111", false, 1, {{4, {0, 1, 2, 3}}}},
    {5, "00011", false, 2, {{4, {0, 1, 2, 3}}, {3, {4, 0, 3}}}},
    {6, "000000", true, 2, {{4, {0, 1, 2, 3}}, {4, {0, 3, 4, 5}}}},
    {6, "001001", false, 2, {{4, {0, 1, 4, 5}}, {4, {1, 2, 3, 4}}}},
    {7, "0000101", false, 3, {{4, {0, 1, 2, 6}}, {3, {2, 5, 6}}, {4, {2, 3, 4, 5}}}},
};

struct FillMatch {
  const Fill* fill = nullptr;
  int rotation = 0;  // position p of the fill is curve (p + rotation) mod size of the loop
};

constexpr FillMatch match_fill(const Loop& loop) {
  for (const Fill& fill : kFills) {
    if (fill.loop_size != loop.size) continue;
    for (int rotation = 0; rotation < loop.size; ++rotation) {
      bool same = true;
      for (int i = 0; i < loop.size; ++i) {
        same = same && loop.curve[static_cast<std::size_t>((i + rotation) % loop.size)].straight ==
                           (fill.straight[i] == '1');
      }
      if (fill.opposite) {
        const Point a = loop.curve[static_cast<std::size_t>(rotation)].start;
        const Point b = loop.curve[static_cast<std::size_t>((rotation + 3) % loop.size)].start;
        for (std::size_t k = 0; k < 3; ++k) same = same && a[k] == -b[k];
      }
      if (same) return {&fill, rotation};
    }
  }
  return {};
}

// A side of a piece between two positions of the loop, both as positions in the fill.
struct Side {
  int from = 0;
  int to = 0;
  bool collapsed = false;
};

constexpr void add_piece(const Loop& loop, int rotation, const Piece& piece, std::array<Side, 4>& sides,
                         PatchCase& patch) {
  const auto curve_at = [&](int position) -> const LoopCurve& {
    return loop.curve[static_cast<std::size_t>((position + rotation) % loop.size)];
  };
  // Grid corners 0..3; a three-edge piece has its first position at corners 0 and 3.
  int corner[4]{};
  for (int c = 0; c < 4; ++c) corner[c] = c < piece.size ? piece.at[c] : piece.at[0];
  Point middle[4]{};
  for (std::size_t e = 0; e < 4; ++e) {
    const int from = corner[e];
    const int to = corner[(e + 1) % 4];
    sides[e] = {from, to, from == to};
    if (from == to) {
      middle[e] = curve_at(from).start;
      patch.edge[e].kind = CaseEdge::collapsed;
    } else if ((from + 1) % loop.size == to) {
      const LoopCurve& c = curve_at(from);
      middle[e] = face_center(c.face);
      patch.edge[e] = {CaseEdge::external, c.face, c.curve};
    } else {
      patch.edge[e].kind = CaseEdge::internal;  // middle stays L = (0, 0, 0); its partner is found later
    }
  }
  patch.control[0] = {curve_at(corner[0]).start, middle[0], curve_at(corner[1]).start};
  patch.control[1] = {middle[3], Point{}, middle[1]};
  patch.control[2] = {curve_at(corner[3]).start, middle[2], curve_at(corner[2]).start};
}

constexpr void fill_loop(const Loop& loop, ConfigurationCase& result) {
  const FillMatch match = match_fill(loop);
  const int base = result.patch_count;
  std::array<std::array<Side, 4>, 3> sides{};
  for (int p = 0; p < match.fill->pieces; ++p) {  // a null fill stops the compilation here
    add_piece(loop, match.rotation, match.fill->piece[p], sides[static_cast<std::size_t>(p)],
              result.patch[static_cast<std::size_t>(base + p)]);
  }
  for (std::size_t p = 0; p < static_cast<std::size_t>(match.fill->pieces); ++p) {
    for (std::size_t e = 0; e < 4; ++e) {
      CaseEdge& edge = result.patch[static_cast<std::size_t>(base) + p].edge[e];
      if (edge.kind == CaseEdge::external) {
        result.curve[edge.a][edge.b] =
            static_cast<std::uint8_t>((static_cast<std::size_t>(base) + p) << 2 | e);
      }
      if (edge.kind != CaseEdge::internal) continue;
      for (std::size_t q = 0; q < static_cast<std::size_t>(match.fill->pieces); ++q) {
        for (std::size_t f = 0; f < 4; ++f) {
          if (sides[q][f].from != sides[p][e].to || sides[q][f].to != sides[p][e].from ||
              sides[q][f].collapsed)
            continue;
          edge.a = static_cast<std::uint8_t>(static_cast<std::size_t>(base) + q);
          edge.b = static_cast<std::uint8_t>(f);
        }
      }
    }
  }
  result.patch_count = static_cast<std::uint8_t>(base + match.fill->pieces);
}

constexpr ConfigurationCase make_case(int configuration) {
  ConfigurationCase result;
  for (auto& face : result.curve) face = {kNoCurve, kNoCurve};
  const Loops loops = make_loops(configuration);
  result.loop_count = static_cast<std::uint8_t>(loops.count);
  for (int l = 0; l < loops.count; ++l) fill_loop(loops.loop[static_cast<std::size_t>(l)], result);
  return result;
}

constexpr std::array<ConfigurationCase, 256> make_table() {
  std::array<ConfigurationCase, 256> table{};
  for (int c = 0; c < 256; ++c) table[static_cast<std::size_t>(c)] = make_case(c);
  return table;
}

}  // namespace

constexpr std::array<ConfigurationCase, 256> kCaseTable = make_table();

Loops configuration_loops(int configuration) {
  return make_loops(configuration);
}

}  // namespace karst::core
