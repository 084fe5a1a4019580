// SPDX-License-Identifier: MIT
// Cells of isosurfaces: all states against all neighbours.
#include "terrain/isosurface/cell_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>
#include <vector>

namespace karst::core {
namespace {

using Edge = std::pair<int, int>;  // of the surface: from a vertex to the next
using Edges = std::set<Edge>;

// Edges of triangles that no other triangle of the cell has the other way round.
template <class Case>
Edges border(const Case& cell, bool& each_once) {
  Edges all;
  each_once = true;
  for (int n = 0; n < cell.triangles; ++n) {
    for (int k = 0; k < 3; ++k) {
      const int from = cell.edge[3 * n + k];
      const int to = cell.edge[3 * n + (k + 1) % 3];
      each_once = each_once && from != to && all.insert({from, to}).second;
    }
  }
  Edges open;
  for (const Edge& e : all) {
    if (!all.contains({e.second, e.first})) open.insert(e);
  }
  return open;
}

// A place on a cell's edge, in halves of a cell.
std::array<int, 3> middle(int edge) {
  std::array<int, 3> m = edge_start(edge);
  for (int& v : m) v *= 2;
  m[static_cast<std::size_t>(edge_axis(edge))] += 1;
  return m;
}

// Of the edges, those that lie in a face of the cell; the face's own two coordinates of each end.
Edges on_face(const Edges& edges, int axis, int side) {
  Edges out;
  for (const Edge& e : edges) {
    const std::array<int, 3> a = middle(e.first), b = middle(e.second);
    const auto n = static_cast<std::size_t>(axis);
    if (a[n] != 2 * side || b[n] != 2 * side) continue;
    const auto key = [&](const std::array<int, 3>& m) {
      return 3 * m[static_cast<std::size_t>((axis + 1) % 3)] + m[static_cast<std::size_t>((axis + 2) % 3)];
    };
    out.insert({key(a), key(b)});
  }
  return out;
}

Edges reversed(const Edges& edges) {
  Edges out;
  for (const Edge& e : edges) out.insert({e.second, e.first});
  return out;
}

TEST(CellTables, EachInnerEdgeOnceFromEachSide) {
  for (unsigned state = 0; state < 256; ++state) {
    bool once = false;
    const Edges open = border(kCellTable[state], once);
    ASSERT_TRUE(once) << state;
    std::size_t on_faces = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 2; ++side) on_faces += on_face(open, axis, side).size();
    }
    EXPECT_EQ(on_faces, open.size()) << state;  // and in one face each
    std::set<int> crossed, used;
    for (int e = 0; e < kCellEdges; ++e) {
      const std::array<int, 3> s = edge_start(e);
      const int from = s[0] + 2 * s[1] + 4 * s[2];
      if ((state >> from & 1) != (state >> (from + (1 << edge_axis(e))) & 1)) crossed.insert(e);
    }
    for (int n = 0; n < 3 * kCellTable[state].triangles; ++n) used.insert(kCellTable[state].edge[n]);
    EXPECT_EQ(used, crossed) << state;
  }
}

// Two cells with a face in common have twelve corners.
TEST(CellTables, AllStatesCloseAgainstAllNeighbours) {
  std::array<Edges, 256> open;
  bool once = false;
  for (unsigned state = 0; state < 256; ++state) open[state] = border(kCellTable[state], once);
  std::size_t pairs = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (unsigned a = 0; a < 256; ++a) {
      for (unsigned b = 0; b < 256; ++b) {
        bool fit = true;
        for (unsigned o = 0; o < 8; ++o) {
          if ((o >> axis & 1) == 1) fit = fit && (a >> o & 1) == (b >> (o ^ 1u << axis) & 1);
        }
        if (!fit) continue;
        ++pairs;
        ASSERT_EQ(on_face(open[a], axis, 1), reversed(on_face(open[b], axis, 0)))
            << axis << " " << a << " " << b;
      }
    }
  }
  EXPECT_EQ(pairs, 3u * 4096);
}

TEST(CellTables, AirIsInFront) {
  // One solid corner: its triangle looks away from it.
  const auto& cell = kCellTable[1];
  ASSERT_EQ(cell.triangles, 1);
  std::array<std::array<int, 3>, 3> p{};
  for (std::size_t k = 0; k < 3; ++k) p[k] = middle(cell.edge[k]);
  std::array<int, 3> u{}, v{};
  for (std::size_t k = 0; k < 3; ++k) {
    u[k] = p[1][k] - p[0][k];
    v[k] = p[2][k] - p[0][k];
  }
  EXPECT_GT(u[1] * v[2] - u[2] * v[1], 0);
  EXPECT_GT(u[2] * v[0] - u[0] * v[2], 0);
  EXPECT_GT(u[0] * v[1] - u[1] * v[0], 0);
}

TEST(CellTables, HaveRoomForTheMostAndNoMore) {
  std::size_t most = 0;
  for (const auto& cell : kCellTable) most = std::max<std::size_t>(most, cell.triangles);
  EXPECT_EQ(most, kMostCellTriangles);
  most = 0;
  for (const auto& cell : kTransitionTable) most = std::max<std::size_t>(most, cell.triangles);
  EXPECT_EQ(most, kMostTransitionTriangles);
}

// --- Transition cells: w leads from the fine face to the coarse one, so the fine cells are below it, their
// upper faces in common; x is u, y is v.

Edges fine_curves(unsigned samples, int u, int v) {
  const int s = u + 3 * v;
  unsigned state = 0;  // corners 4..7 of a cell below
  state |= (samples >> s & 1) << 4 | (samples >> (s + 1) & 1) << 5 | (samples >> (s + 3) & 1) << 6 |
           (samples >> (s + 4) & 1) << 7;
  bool once = false;
  Edges out;
  const auto name = [&](int edge) {  // in the transition cell's words
    const std::array<int, 3> start = edge_start(edge);
    return edge_axis(edge) == 0 ? u + 2 * (v + start[1]) : 6 + u + start[0] + 3 * v;
  };
  for (const Edge& e : border(kCellTable[state], once)) {
    const bool both = edge_axis(e.first) < 2 && edge_axis(e.second) < 2 && edge_start(e.first)[2] == 1 &&
                      edge_start(e.second)[2] == 1;
    if (both) out.insert({name(e.first), name(e.second)});
  }
  return out;
}

Edges coarse_curves(unsigned samples) {
  unsigned state = 0;  // corners 0..3 of a cell above
  state |= (samples & 1) | (samples >> 2 & 1) << 1 | (samples >> 6 & 1) << 2 | (samples >> 8 & 1) << 3;
  bool once = false;
  Edges out;
  const auto name = [&](int edge) {
    return edge_axis(edge) == 0 ? 12 + edge_start(edge)[1] : 14 + edge_start(edge)[0];
  };
  for (const Edge& e : border(kCellTable[state], once)) {
    const bool both = edge_axis(e.first) < 2 && edge_axis(e.second) < 2 && edge_start(e.first)[2] == 0 &&
                      edge_start(e.second)[2] == 0;
    if (both) out.insert({name(e.first), name(e.second)});
  }
  return out;
}

// What a transition cell has towards the next one along u or v, in words of both: which of its two fine
// edges there, or the coarse one.
Edges lateral(const Edges& open, bool along_u, int end) {
  const auto name = [&](int edge) {
    for (int half = 0; half < 2; ++half) {
      if (edge == (along_u ? 6 + 2 * end + 3 * half : half + 2 * 2 * end)) return half;
    }
    return edge == (along_u ? 14 + end : 12 + end) ? 2 : -1;
  };
  Edges out;
  for (const Edge& e : open) {
    if (name(e.first) >= 0 && name(e.second) >= 0) out.insert({name(e.first), name(e.second)});
  }
  return out;
}

TEST(TransitionTables, AllStatesCloseAgainstBothResolutionsAndEachOther) {
  std::array<Edges, 512> open;
  for (unsigned state = 0; state < 512; ++state) {
    bool once = false;
    open[state] = border(kTransitionTable[state], once);
    ASSERT_TRUE(once) << state;
    Edges left = open[state];
    const auto take = [&](const Edges& curves) {
      for (const Edge& e : curves) {
        EXPECT_EQ(left.erase({e.second, e.first}), 1u) << state << ": " << e.first << " " << e.second;
      }
    };
    for (int v = 0; v < 2; ++v) {
      for (int u = 0; u < 2; ++u) take(fine_curves(state, u, v));
    }
    take(coarse_curves(state));
    std::size_t sides = 0;
    for (const bool along_u : {true, false}) {
      for (int end = 0; end < 2; ++end) sides += lateral(left, along_u, end).size();
    }
    EXPECT_EQ(sides, left.size()) << state;
  }
  for (unsigned a = 0; a < 512; ++a) {
    for (unsigned b = 0; b < 512; ++b) {
      const auto column = [](unsigned s, int u) {
        return (s >> u & 1) | (s >> (u + 3) & 1) << 1 | (s >> (u + 6) & 1) << 2;
      };
      if (column(a, 2) == column(b, 0)) {
        ASSERT_EQ(lateral(open[a], true, 1), reversed(lateral(open[b], true, 0))) << a << " " << b;
      }
      if ((a >> 6 & 7) == (b & 7)) {
        ASSERT_EQ(lateral(open[a], false, 1), reversed(lateral(open[b], false, 0))) << a << " " << b;
      }
    }
  }
}

}  // namespace
}  // namespace karst::core
