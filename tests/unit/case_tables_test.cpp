// SPDX-License-Identifier: MIT
// The case tables against K's figures and the rules of design 4.2, exhaustively.
#include "terrain/surface/bezier/case_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace karst::core {
namespace {

glm::ivec3 point(const std::array<std::int8_t, 3>& p) {
  return {p[0], p[1], p[2]};
}
glm::ivec3 octant_centre(int o) {
  return {(o & 1) * 2 - 1, (o >> 1 & 1) * 2 - 1, (o >> 2 & 1) * 2 - 1};
}

// The configuration after one of the 48 symmetries of the cube: axes permuted, then mirrored.
int transformed(int configuration, int symmetry) {
  constexpr int kPermutation[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  const int(&axes)[3] = kPermutation[symmetry >> 3];
  int result = 0;
  for (int o = 0; o < 8; ++o) {
    if ((configuration >> o & 1) == 0) continue;
    int to = 0;
    for (int k = 0; k < 3; ++k) to |= ((o >> axes[k] & 1) ^ (symmetry >> k & 1)) << k;
    result |= 1 << to;
  }
  return result;
}

int canonical(int configuration) {
  int least = 256;
  for (int s = 0; s < 48; ++s) least = std::min(least, transformed(configuration, s));
  return least;
}

std::vector<int> face_connected_groups(int configuration) {
  std::vector<int> groups;
  for (int left = configuration; left != 0;) {
    int group = left & -left;
    for (int before = 0; before != group;) {
      before = group;
      for (int o = 0; o < 8; ++o) {
        for (int axis = 0; axis < 3; ++axis) {
          if ((group >> o & 1) != 0 && (left >> (o ^ 1 << axis) & 1) != 0) group |= 1 << (o ^ 1 << axis);
        }
      }
    }
    groups.push_back(group);
    left &= ~group;
  }
  return groups;
}

std::string curve_types(const Loop& loop) {
  std::string types;
  for (int i = 0; i < loop.size; ++i) types += loop.curve[static_cast<std::size_t>(i)].straight ? 'S' : 'C';
  std::string best = types;
  for (std::size_t r = 0; r < types.size(); ++r) best = std::min(best, types.substr(r) + types.substr(0, r));
  return best;
}

// "types of each loop, sorted", for example "CCC CCC".
std::string loop_signature(int configuration) {
  const Loops loops = configuration_loops(configuration);
  std::vector<std::string> all;
  for (int l = 0; l < loops.count; ++l) all.push_back(curve_types(loops.loop[static_cast<std::size_t>(l)]));
  std::sort(all.begin(), all.end());
  std::string joined;
  for (const std::string& s : all) joined += (joined.empty() ? "" : " ") + s;
  return joined;
}

// K figures 3.14 - 3.17: 12 configurations, with their loops and how many patches fill them.
TEST(CaseTables, TwelveConfigurations) {
  std::set<int> distinct;
  for (int c = 1; c < 255; ++c) {
    for (const int group : face_connected_groups(c)) {
      if (group != 255) distinct.insert(canonical(group));
    }
  }
  ASSERT_EQ(distinct.size(), 12u);

  // Filled voxels by bit x + 2y + 4z.
  const struct {
    const char* name;
    int configuration;
    const char* loops;
    int patches;
  } expected[] = {
      {"1", 0b00000001, "CCC", 1},
      {"2", 0b00000011, "CSCS", 1},
      {"3", 0b00000111, "CCCSS", 2},
      {"4 plane", 0b00001111, "SSSS", 1},
      {"4 claw", 0b00010111, "CCCCCC", 2},
      {"4 zigzag", 0b00011011, "CCSCCS", 2},
      {"5, complement of an L", 0b11111000, "CCCSS", 2},
      {"6, empties adjacent", 0b11111100, "CSCS", 1},
      {"6, empties across a face", 0b11110110, "CCCCCC", 2},
      {"6, empties across the cube", 0b01111110, "CCC CCC", 2},
      {"7", 0b11111110, "CCC", 1},
  };
  std::set<int> found;
  for (const auto& e : expected) {
    EXPECT_EQ(loop_signature(e.configuration), e.loops) << e.name;
    EXPECT_EQ(kCaseTable[static_cast<std::size_t>(e.configuration)].patch_count, e.patches) << e.name;
    found.insert(canonical(e.configuration));
  }
  EXPECT_EQ(found.size(), 11u);
  // The twelfth: five filled voxels whose complement is no L.
  std::vector<int> rest;
  for (const int c : distinct) {
    if (found.count(c) == 0) rest.push_back(c);
  }
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(__builtin_popcount(static_cast<unsigned>(rest[0])), 5);
  EXPECT_EQ(loop_signature(rest[0]), "CCCCSCS");
  EXPECT_EQ(kCaseTable[static_cast<std::size_t>(rest[0])].patch_count, 3);
}

struct EdgePoints {
  glm::ivec3 p[3];
};

EdgePoints edge_points(const PatchCase& patch, int edge) {
  constexpr int kAt[4][3][2] = {
      {{0, 0}, {1, 0}, {2, 0}}, {{2, 0}, {2, 1}, {2, 2}}, {{2, 2}, {1, 2}, {0, 2}}, {{0, 2}, {0, 1}, {0, 0}}};
  EdgePoints e{};
  for (int k = 0; k < 3; ++k) {
    e.p[k] = point(
        patch.control[static_cast<std::size_t>(kAt[edge][k][1])][static_cast<std::size_t>(kAt[edge][k][0])]);
  }
  return e;
}

bool reversed(const EdgePoints& a, const EdgePoints& b) {
  return a.p[0] == b.p[2] && a.p[1] == b.p[1] && a.p[2] == b.p[0];
}

TEST(CaseTables, EveryEdgeHasItsPartner) {
  for (std::size_t c = 0; c < 256; ++c) {
    const ConfigurationCase& table = kCaseTable[c];
    int external = 0;
    for (std::size_t p = 0; p < table.patch_count; ++p) {
      for (std::size_t e = 0; e < 4; ++e) {
        const CaseEdge& edge = table.patch[p].edge[e];
        const EdgePoints points = edge_points(table.patch[p], static_cast<int>(e));
        if (edge.kind == CaseEdge::collapsed) {
          EXPECT_EQ(e, 3u);
          EXPECT_TRUE(points.p[0] == points.p[1] && points.p[1] == points.p[2]);
        } else if (edge.kind == CaseEdge::internal) {
          const CaseEdge& back = table.patch[edge.a].edge[edge.b];
          EXPECT_EQ(back.kind, CaseEdge::internal);
          EXPECT_EQ(back.a, p);
          EXPECT_EQ(back.b, e);
          EXPECT_TRUE(reversed(points, edge_points(table.patch[edge.a], edge.b)));
          EXPECT_EQ(points.p[1], glm::ivec3(0));
        } else {
          ++external;
          EXPECT_EQ(table.curve[edge.a][edge.b], p << 2 | e);
          glm::ivec3 centre(0);
          centre[edge.a / 2] = edge.a % 2 != 0 ? 1 : -1;
          EXPECT_EQ(points.p[1], centre);
        }
        EXPECT_EQ(point(table.patch[p].control[1][1]), glm::ivec3(0));
      }
    }
    int curves = 0;
    for (const auto& face : table.curve) {
      for (const std::uint8_t curve : face) curves += curve != kNoCurve;
    }
    EXPECT_EQ(curves, external) << c;
    EXPECT_EQ(table.patch_count == 0, c == 0 || c == 255);
  }
}

// All 3 x 2^12 pairs of volumes that share a face: the same curves, run the other way.
TEST(CaseTables, FaceSharingPairsMatch) {
  int pairs = 0;
  int curves = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int field = 0; field < 1 << 12; ++field) {
      // 3 x 2 x 2 voxels along the axis: layer l, then the two other axes.
      const auto filled = [field](int layer, int u, int v) { return field >> (layer * 4 + u + 2 * v) & 1; };
      int configuration[2] = {0, 0};
      for (int side = 0; side < 2; ++side) {
        for (int o = 0; o < 8; ++o) {
          const int u = o >> ((axis + 1) % 3) & 1;
          const int v = o >> ((axis + 2) % 3) & 1;
          configuration[side] |= filled(side + (o >> axis & 1), u, v) << o;
        }
      }
      ++pairs;
      const ConfigurationCase& low = kCaseTable[static_cast<std::size_t>(configuration[0])];
      const ConfigurationCase& high = kCaseTable[static_cast<std::size_t>(configuration[1])];
      glm::ivec3 offset(0);
      offset[axis] = 2;  // from the lower volume's centre to the upper's, half voxels
      for (std::size_t k = 0; k < kFaceCurves; ++k) {
        const std::uint8_t a = low.curve[static_cast<std::size_t>(2 * axis + 1)][k];
        const std::uint8_t b = high.curve[static_cast<std::size_t>(2 * axis)][k];
        ASSERT_EQ(a == kNoCurve, b == kNoCurve);
        if (a == kNoCurve) continue;
        ++curves;
        const EdgePoints mine = edge_points(low.patch[a >> 2], a & 3);
        EdgePoints theirs = edge_points(high.patch[b >> 2], b & 3);
        for (glm::ivec3& p : theirs.p) p += offset;
        EXPECT_TRUE(reversed(mine, theirs)) << "axis " << axis << " field " << field;
      }
    }
  }
  EXPECT_EQ(pairs, 3 * 4096);
  EXPECT_GT(curves, 8192);
}

// Two curves on a face go around the filled voxels: a diagonal never joins.
TEST(CaseTables, DiagonalFacesKeepFilledVoxelsApart) {
  for (int c = 1; c < 255; ++c) {
    const Loops loops = configuration_loops(c);
    for (int l = 0; l < loops.count; ++l) {
      const Loop& loop = loops.loop[static_cast<std::size_t>(l)];
      for (int k = 0; k < loop.size; ++k) {
        const LoopCurve& curve = loop.curve[static_cast<std::size_t>(k)];
        if (curve.straight) continue;
        glm::ivec3 centre(0);
        centre[curve.face / 2] = curve.face % 2 != 0 ? 1 : -1;
        const glm::ivec3 start = point(curve.start);
        const glm::ivec3 end = point(loop.curve[static_cast<std::size_t>((k + 1) % loop.size)].start);
        // A corner curve turns around the voxel centre between its two edge points.
        const glm::ivec3 around = start + end - centre;
        int filled = 0;
        for (int o = 0; o < 8; ++o) {
          if (octant_centre(o) == around) filled = c >> o & 1;
        }
        int on_face = 0;
        for (int o = 0; o < 8; ++o)
          on_face += octant_centre(o)[curve.face / 2] == centre[curve.face / 2] && (c >> o & 1) != 0;
        if (on_face == 2) {
          EXPECT_EQ(filled, 1) << "configuration " << c;
        }
      }
    }
  }
}

glm::ivec3 cross(glm::ivec3 a, glm::ivec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// At every patch corner the normal is the normal of the voxel face that the edge point is the centre of
// (design 4.2).
TEST(CaseTables, CornerNormalsAreVoxelFaceNormals) {
  int corners = 0;
  for (std::size_t c = 0; c < 256; ++c) {
    const ConfigurationCase& table = kCaseTable[c];
    for (std::size_t p = 0; p < table.patch_count; ++p) {
      const PatchCase& patch = table.patch[p];
      for (int corner = 0; corner < 4; ++corner) {
        // Tangents: the control polygon's first and last leg there; a collapsed corner uses the edges on both
        // sides.
        const EdgePoints leaving =
            edge_points(patch, patch.edge[3].kind == CaseEdge::collapsed && corner == 3 ? 0 : corner);
        const int before = (corner + 3) % 4;
        const EdgePoints arriving = edge_points(
            patch, patch.edge[static_cast<std::size_t>(before)].kind == CaseEdge::collapsed ? 2 : before);
        const glm::ivec3 at = leaving.p[0];
        ASSERT_EQ(at, arriving.p[2]);
        const glm::ivec3 normal = cross(leaving.p[1] - at, arriving.p[1] - at);
        // The edge point lies between two voxel centres along one axis: the only zero coordinate.
        int axis = -1;
        for (int k = 0; k < 3; ++k) {
          if (at[k] == 0) axis = k;
        }
        ASSERT_GE(axis, 0);
        glm::ivec3 expected(0);
        int lower_octant = 0;
        for (int k = 0; k < 3; ++k) lower_octant |= (at[k] > 0 ? 1 : 0) << k;
        expected[axis] = (c >> lower_octant & 1) != 0 ? 1 : -1;
        for (int k = 0; k < 3; ++k) {
          if (k == axis) continue;
          EXPECT_EQ(normal[k], 0) << "configuration " << c << " patch " << p << " corner " << corner;
        }
        // Straight chains through an apex have parallel legs: then the cross product vanishes, and says
        // nothing.
        if (normal[axis] != 0) {
          EXPECT_GT(normal[axis] * expected[axis], 0) << "configuration " << c;
        }
        ++corners;
      }
    }
  }
  EXPECT_GT(corners, 1000);
}

}  // namespace
}  // namespace karst::core
