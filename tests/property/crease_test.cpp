// SPDX-License-Identifier: MIT
// Creases of the undisplaced surface: how far patches are from a common tangent plane along their edges, for
// the fills in the case tables and for every other division of a loop into at most three three- and four-edge
// patches.
//
// On a cube face the plane that both volumes should share is spanned by the curve's tangent and the face's
// normal.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "terrain/surface/bezier/case_tables.h"

namespace karst::core {
namespace {

using Point = glm::dvec3;
using Control = std::array<std::array<Point, 3>, 3>;

Point point(const std::array<std::int8_t, 3>& p) {
  return {p[0], p[1], p[2]};
}
Point face_centre(int face) {
  Point c(0.0);
  c[face / 2] = face % 2 != 0 ? 1 : -1;
  return c;
}

void weights(double t, double (&w)[3], double (&d)[3]) {
  w[0] = (1 - t) * (1 - t);
  w[1] = 2 * t * (1 - t);
  w[2] = t * t;
  d[0] = -2 * (1 - t);
  d[1] = 2 - 4 * t;
  d[2] = 2 * t;
}

Point normal_at(const Control& c, double u, double v) {
  double wu[3], du[3], wv[3], dv[3];
  weights(u, wu, du);
  weights(v, wv, dv);
  Point tangent_u(0.0), tangent_v(0.0);
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      tangent_u += wv[j] * du[i] * c[j][i];
      tangent_v += dv[j] * wu[i] * c[j][i];
    }
  }
  return glm::cross(tangent_u, tangent_v);
}

double angle_deg(Point a, Point b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / 3.14159265358979323846;
}

// Samples along an edge, its very ends left out: there a collapsed patch has no normal.
std::vector<double> samples() {
  std::vector<double> t = {1.0 / 64};
  for (int i = 0; i < 16; ++i) t.push_back((i + 0.5) / 16);
  t.push_back(63.0 / 64);
  return t;
}

Point edge_normal(const Control& c, int edge, double t) {
  switch (edge) {
    case 0:
      return normal_at(c, t, 0);
    case 1:
      return normal_at(c, 1, t);
    case 2:
      return normal_at(c, 1 - t, 1);
    default:
      return normal_at(c, 0, 1 - t);
  }
}

struct Piece {
  std::vector<int> at;  // positions in the loop; collapsed at the first where there are three
};
using Fill = std::vector<Piece>;

Control control(const Loop& loop, const Piece& piece) {
  const int n = loop.size;
  const auto start = [&](int i) { return point(loop.curve[static_cast<std::size_t>(i)].start); };
  const auto middle = [&](int from, int to) {
    return (from + 1) % n == to ? face_centre(loop.curve[static_cast<std::size_t>(from)].face) : Point(0.0);
  };
  const int a = piece.at[0], b = piece.at[1], c = piece.at[2];
  if (piece.at.size() == 3) {
    return {{{start(a), middle(a, b), start(b)},
             {start(a), Point(0.0), middle(b, c)},
             {start(a), middle(c, a), start(c)}}};
  }
  const int d = piece.at[3];
  return {{{start(a), middle(a, b), start(b)},
           {middle(d, a), Point(0.0), middle(b, c)},
           {start(d), middle(c, d), start(c)}}};
}

struct Crease {
  double outer_deg = 0;  // on cube faces, of this side alone; the other side may add as much
  double inner_deg = 0;  // between two patches of the volume
  double worst() const { return std::max(2 * outer_deg, inner_deg); }
};

Crease measure(const Loop& loop, const Fill& fill) {
  Crease crease;
  std::map<std::pair<int, int>, std::vector<std::vector<Point>>> inner;
  for (const Piece& piece : fill) {
    const Control c = control(loop, piece);
    const int sides = static_cast<int>(piece.at.size());
    for (int e = 0; e < sides; ++e) {
      const int from = piece.at[static_cast<std::size_t>(e)];
      const int to = piece.at[static_cast<std::size_t>((e + 1) % sides)];
      std::vector<Point> normals;
      for (const double t : samples()) normals.push_back(edge_normal(c, e, t));
      if ((from + 1) % loop.size == to) {
        const LoopCurve& curve = loop.curve[static_cast<std::size_t>(from)];
        const Point p[3] = {point(curve.start), face_centre(curve.face),
                            point(loop.curve[static_cast<std::size_t>(to)].start)};
        for (std::size_t k = 0; k < normals.size(); ++k) {
          double w[3], d[3];
          weights(samples()[k], w, d);
          const Point tangent = d[0] * p[0] + d[1] * p[1] + d[2] * p[2];
          crease.outer_deg =
              std::max(crease.outer_deg, angle_deg(normals[k], glm::cross(face_centre(curve.face), tangent)));
        }
      } else {
        if (from > to) std::reverse(normals.begin(), normals.end());
        inner[{std::min(from, to), std::max(from, to)}].push_back(normals);
      }
    }
  }
  for (const auto& [edge, sides] : inner) {
    for (std::size_t k = 0; k < sides[0].size(); ++k)
      crease.inner_deg = std::max(crease.inner_deg, angle_deg(sides[0][k], sides[1][k]));
  }
  return crease;
}

// All divisions of the polygon into triangles and quadrilaterals, each triangle with each collapsed corner.
void divide(const std::vector<int>& polygon, const Fill& done, std::vector<Fill>& out) {
  struct Step {
    static void run(std::vector<std::vector<int>> open, const Fill& fill, std::vector<Fill>& result) {
      while (!open.empty() && open.back().size() < 3) open.pop_back();
      if (open.empty()) {
        result.push_back(fill);
        return;
      }
      if (fill.size() == 3) return;
      const std::vector<int> p = open.back();
      open.pop_back();
      const std::size_t n = p.size();
      const auto part = [&](std::size_t a, std::size_t b) {
        return std::vector<int>(p.begin() + static_cast<std::ptrdiff_t>(a),
                                p.begin() + static_cast<std::ptrdiff_t>(b) + 1);
      };
      // The piece that holds the side from the last vertex to the first.
      for (std::size_t i = 1; i + 1 < n; ++i) {
        for (int collapse = 0; collapse < 3; ++collapse) {
          std::vector<int> at = {p[0], p[i], p[n - 1]};
          std::rotate(at.begin(), at.begin() + collapse, at.end());
          std::vector<std::vector<int>> rest = open;
          rest.push_back(part(0, i));
          rest.push_back(part(i, n - 1));
          Fill next = fill;
          next.push_back({at});
          run(rest, next, result);
        }
        for (std::size_t k = i + 1; k + 1 < n; ++k) {
          std::vector<std::vector<int>> rest = open;
          rest.push_back(part(0, i));
          rest.push_back(part(i, k));
          rest.push_back(part(k, n - 1));
          Fill next = fill;
          next.push_back({{p[0], p[i], p[k], p[n - 1]}});
          run(rest, next, result);
        }
      }
    }
  };
  Step::run({polygon}, done, out);
}

// The fill that the case table holds for a loop, as positions in it.
Fill table_fill(const ConfigurationCase& table, const Loop& loop) {
  std::map<std::array<std::int8_t, 3>, int> position;
  for (int i = 0; i < loop.size; ++i) position[loop.curve[static_cast<std::size_t>(i)].start] = i;
  Fill fill;
  for (std::size_t p = 0; p < table.patch_count; ++p) {
    const PatchCase& patch = table.patch[p];
    const bool collapsed = patch.edge[3].kind == CaseEdge::collapsed;
    const auto corners = {patch.control[0][0], patch.control[0][2], patch.control[2][2], patch.control[2][0]};
    std::vector<int> at;
    bool of_this_loop = true;
    for (const auto& c : corners) {
      of_this_loop = of_this_loop && position.count(c) == 1;
      if (of_this_loop) at.push_back(position[c]);
    }
    if (!of_this_loop) continue;
    if (collapsed) at.pop_back();
    fill.push_back({at});
  }
  return fill;
}

TEST(Crease, TableHasTheLeastOfAllFills) {
  std::map<std::string, std::pair<Crease, double>> by_type;  // of the table, and the least found
  for (int c = 1; c < 255; ++c) {
    const Loops loops = configuration_loops(c);
    for (int l = 0; l < loops.count; ++l) {
      const Loop& loop = loops.loop[static_cast<std::size_t>(l)];
      std::string type;
      for (int i = 0; i < loop.size; ++i)
        type += loop.curve[static_cast<std::size_t>(i)].straight ? 'S' : 'C';
      std::string least_type = type;
      for (std::size_t r = 0; r < type.size(); ++r)
        least_type = std::min(least_type, type.substr(r) + type.substr(0, r));
      const Crease ours = measure(loop, table_fill(kCaseTable[static_cast<std::size_t>(c)], loop));
      std::vector<int> polygon;
      for (int i = 0; i < loop.size; ++i) polygon.push_back(i);
      std::vector<Fill> fills;
      divide(polygon, {}, fills);
      double least = 1e9;
      for (const Fill& fill : fills) least = std::min(least, measure(loop, fill).worst());
      EXPECT_LE(ours.worst(), least + 1e-9) << "configuration " << c << " loop " << type;
      by_type[least_type] = {ours, least};
    }
  }
  for (const auto& [type, value] : by_type) {
    std::printf("loop %-8s crease on cube faces %5.2f deg a side, inside %5.2f deg\n", type.c_str(),
                value.first.outer_deg, value.first.inner_deg);
  }
  EXPECT_EQ(by_type.size(), 7u);
  EXPECT_LT(by_type["CCC"].first.worst(), 1e-6);
  EXPECT_LT(by_type["CSCS"].first.worst(), 1e-6);
  EXPECT_LT(by_type["SSSS"].first.worst(), 1e-6);
}

}  // namespace
}  // namespace karst::core
