// SPDX-License-Identifier: MIT
// Both kinds of cells are polyhedra: a list of faces, each a ring of corners, counter-clockwise as seen from
// outside. All that follows is the same for both.
#include "terrain/isosurface/cell_tables.h"

namespace karst::core {
namespace {

constexpr int kMostFaces = 9;
constexpr int kMostRing = 5;
constexpr int kMostLoop = 12;

struct Face {
  int size = 0;
  std::array<std::uint8_t, kMostRing> corner{};  // in order
  std::array<std::uint8_t, kMostRing> edge{};    // from corner n to the next; kNoEdge: it is never crossed
};
constexpr std::uint8_t kNoEdge = 0xff;

struct Polyhedron {
  int faces = 0;
  std::array<Face, kMostFaces> face{};
  int edges = 0;
  // Middle of each edge, a fourth of a cell, and a bit for each face that has it.
  std::array<std::array<int, 3>, kTransitionEdges> middle{};
  std::array<std::uint16_t, kTransitionEdges> faces_of{};
  int cost[kTransitionEdges][kTransitionEdges]{};  // of an inner edge between two vertices
};

struct EdgeLoop {
  int size = 0;
  std::uint8_t edge[kMostLoop]{};
};

// --- Polyhedra

constexpr int corner_edge(int a, int b) {
  for (int e = 0; e < kCellEdges; ++e) {
    const std::array<int, 3> start = edge_start(e);
    const int from = start[0] + 2 * start[1] + 4 * start[2];
    const int to = from + (1 << edge_axis(e));
    if ((from == a && to == b) || (from == b && to == a)) return e;
  }
  return kNoEdge;
}

// Short inner edges are better, and ones in a face are none.
constexpr int kNever = 1 << 20;

constexpr int square(int v) {
  return v * v;
}

constexpr void find_costs(Polyhedron& cell) {
  for (std::size_t a = 0; a < kTransitionEdges; ++a) {
    for (std::size_t b = 0; b < kTransitionEdges; ++b) {
      int sum = (cell.faces_of[a] & cell.faces_of[b]) != 0 ? kNever : 0;
      for (std::size_t k = 0; k < 3; ++k) sum += square(cell.middle[a][k] - cell.middle[b][k]);
      cell.cost[a][b] = sum;
    }
  }
}

constexpr void note_faces(Polyhedron& cell) {
  for (int f = 0; f < cell.faces; ++f) {
    const Face& face = cell.face[static_cast<std::size_t>(f)];
    for (int n = 0; n < face.size; ++n) {
      const std::uint8_t edge = face.edge[static_cast<std::size_t>(n)];
      if (edge != kNoEdge) cell.faces_of[edge] = static_cast<std::uint16_t>(cell.faces_of[edge] | 1 << f);
    }
  }
}

constexpr Polyhedron make_cell() {
  Polyhedron cell;
  cell.faces = 6;
  cell.edges = kCellEdges;
  for (int f = 0; f < 6; ++f) {
    Face& face = cell.face[static_cast<std::size_t>(f)];
    const int axis = f / 2;
    const int u = 1 << (axis + (f & 1 ? 1 : 2)) % 3;
    const int v = 1 << (axis + (f & 1 ? 2 : 1)) % 3;
    const int base = f & 1 ? 1 << axis : 0;
    const int ring[4] = {base, base + u, base + u + v, base + v};
    face.size = 4;
    for (int n = 0; n < 4; ++n) {
      face.corner[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(ring[n]);
      face.edge[static_cast<std::size_t>(n)] =
          static_cast<std::uint8_t>(corner_edge(ring[n], ring[(n + 1) % 4]));
    }
  }
  for (int e = 0; e < kCellEdges; ++e) {
    const std::array<int, 3> start = edge_start(e);
    for (std::size_t k = 0; k < 3; ++k) cell.middle[static_cast<std::size_t>(e)][k] = 4 * start[k];
    cell.middle[static_cast<std::size_t>(e)][static_cast<std::size_t>(edge_axis(e))] += 2;
  }
  note_faces(cell);
  find_costs(cell);
  return cell;
}

// Corners 0..8 are the samples, 9..12 those of the coarse face.
constexpr int coarse_corner(int u, int v) {
  return 9 + u / 2 + v;
}
constexpr int sample_of(int corner) {
  return corner < 9 ? corner : ((corner - 9) & 1) * 2 + ((corner - 9) >> 1) * 6;
}

constexpr int transition_edge(int a, int b) {
  if (a > b) return transition_edge(b, a);
  if (a < 9 && b >= 9) return kNoEdge;  // both ends have one sample
  if (a >= 9) {
    const int from = a - 9, to = b - 9;
    return to - from == 1 ? kFirstCoarseEdge + from / 2 : kFirstCoarseEdge + 2 + from % 2;
  }
  const int u = a % 3, v = a / 3;
  return b - a == 1 ? u + 2 * v : 6 + u + 3 * v;
}

constexpr void add_face(Polyhedron& cell, int size, const std::array<int, kMostRing>& ring) {
  Face& face = cell.face[static_cast<std::size_t>(cell.faces++)];
  face.size = size;
  for (int n = 0; n < size; ++n) {
    const int from = ring[static_cast<std::size_t>(n)], to = ring[static_cast<std::size_t>((n + 1) % size)];
    face.corner[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(from);
    face.edge[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(transition_edge(from, to));
  }
}

constexpr Polyhedron make_transition() {
  Polyhedron cell;
  cell.edges = kTransitionEdges;
  for (int v = 0; v < 2; ++v) {
    for (int u = 0; u < 2; ++u) {
      const int s = u + 3 * v;
      add_face(cell, 4, {s, s + 3, s + 4, s + 1});
    }
  }
  add_face(cell, 4, {coarse_corner(0, 0), coarse_corner(2, 0), coarse_corner(2, 2), coarse_corner(0, 2)});
  add_face(cell, 5, {0, 1, 2, coarse_corner(2, 0), coarse_corner(0, 0)});
  add_face(cell, 5, {8, 7, 6, coarse_corner(0, 2), coarse_corner(2, 2)});
  add_face(cell, 5, {6, 3, 0, coarse_corner(0, 0), coarse_corner(0, 2)});
  add_face(cell, 5, {2, 5, 8, coarse_corner(2, 2), coarse_corner(2, 0)});
  for (int e = 0; e < kTransitionEdges; ++e) {
    std::array<int, 3>& middle = cell.middle[static_cast<std::size_t>(e)];
    if (e < 6) {
      middle = {2 * (e % 2) + 1, 2 * (e / 2), 0};
    } else if (e < kFirstCoarseEdge) {
      middle = {2 * ((e - 6) % 3), 2 * ((e - 6) / 3) + 1, 0};
    } else if (e < kFirstCoarseEdge + 2) {
      middle = {2, 4 * (e - kFirstCoarseEdge), 1};
    } else {
      middle = {4 * (e - kFirstCoarseEdge - 2), 2, 1};
    }
  }
  note_faces(cell);
  find_costs(cell);
  return cell;
}

// --- Loops and triangles

// Of each edge that the surface crosses, the one that follows: solid corners lie to the right of a curve as
// seen from outside.
constexpr std::array<std::uint8_t, kTransitionEdges> next_edges(const Polyhedron& cell, unsigned corners) {
  std::array<std::uint8_t, kTransitionEdges> next{};
  next.fill(kNoEdge);
  for (int f = 0; f < cell.faces; ++f) {
    const Face& face = cell.face[static_cast<std::size_t>(f)];
    const auto at = [&](int n) { return static_cast<std::size_t>((n + face.size) % face.size); };
    const auto solid = [&](int n) { return (corners >> face.corner[at(n)] & 1u) != 0; };
    for (int n = 0; n < face.size; ++n) {
      if (!solid(n) || solid(n - 1)) continue;
      int last = n;
      while (solid(last + 1)) ++last;
      next[face.edge[at(n - 1)]] = face.edge[at(last)];
    }
  }
  return next;
}

// The cheapest division of a polygon: cost[i][j] is that of its part from vertex i to vertex j.
template <std::size_t kMost>
constexpr bool cut(const Polyhedron& cell, const EdgeLoop& loop, CellCase<kMost>& out) {
  int cost[kMostLoop][kMostLoop]{};
  std::uint8_t tip[kMostLoop][kMostLoop]{};
  const auto side = [&](int i, int j) {
    const bool outer = j - i == 1 || (i == 0 && j == loop.size - 1);
    return outer ? 0 : cell.cost[loop.edge[i]][loop.edge[j]];
  };
  for (int length = 2; length < loop.size; ++length) {
    for (int i = 0; i + length < loop.size; ++i) {
      const int j = i + length;
      int best = 1 << 30;
      for (int k = i + 1; k < j; ++k) {
        const int sum = cost[i][k] + cost[k][j] + side(i, k) + side(k, j);
        if (sum >= best) continue;
        best = sum;
        tip[i][j] = static_cast<std::uint8_t>(k);
      }
      cost[i][j] = best;
    }
  }
  int open[kMostLoop][2]{};
  int depth = 1;
  open[0][1] = loop.size - 1;
  while (depth > 0) {
    --depth;
    const int i = open[depth][0], j = open[depth][1];
    if (j - i < 2) continue;
    const int k = tip[i][j];
    if (out.triangles == kMost) return false;
    const std::size_t first = 3 * static_cast<std::size_t>(out.triangles++);
    out.edge[first] = loop.edge[i];
    out.edge[first + 1] = loop.edge[k];
    out.edge[first + 2] = loop.edge[j];
    open[depth][0] = i;
    open[depth++][1] = k;
    open[depth][0] = k;
    open[depth++][1] = j;
  }
  return cost[0][loop.size - 1] < kNever;
}

template <std::size_t kMost>
constexpr bool make_case(const Polyhedron& cell, unsigned corners, CellCase<kMost>& out) {
  std::array<std::uint8_t, kTransitionEdges> next = next_edges(cell, corners);
  for (int first = 0; first < cell.edges; ++first) {
    EdgeLoop loop;
    int at = first;
    while (next[static_cast<std::size_t>(at)] != kNoEdge) {
      if (loop.size == kMostLoop) return false;
      loop.edge[loop.size++] = static_cast<std::uint8_t>(at);
      const std::uint8_t to = next[static_cast<std::size_t>(at)];
      next[static_cast<std::size_t>(at)] = kNoEdge;
      at = to;
    }
    if (loop.size > 0 && !cut(cell, loop, out)) return false;
  }
  return true;
}

template <std::size_t kStates, std::size_t kMost>
struct Table {
  std::array<CellCase<kMost>, kStates> cases{};
  bool holds = true;  // all loops could be cut within the limits
};

constexpr auto make_cell_table() {
  Table<256, kMostCellTriangles> table;
  const Polyhedron cell = make_cell();
  for (unsigned state = 0; state < 256; ++state)
    table.holds = make_case(cell, state, table.cases[state]) && table.holds;
  return table;
}

constexpr auto make_transition_table() {
  Table<512, kMostTransitionTriangles> table;
  const Polyhedron cell = make_transition();
  for (unsigned state = 0; state < 512; ++state) {
    unsigned corners = state;
    for (int c = 9; c < 13; ++c) corners |= (state >> sample_of(c) & 1u) << c;
    table.holds = make_case(cell, corners, table.cases[state]) && table.holds;
  }
  return table;
}

constexpr auto kCells = make_cell_table();
static_assert(kCells.holds);
constexpr auto kTransitions = make_transition_table();
static_assert(kTransitions.holds);

}  // namespace

const std::array<CellCase<kMostCellTriangles>, 256> kCellTable = kCells.cases;
const std::array<CellCase<kMostTransitionTriangles>, 512> kTransitionTable = kTransitions.cases;

}  // namespace karst::core
