// SPDX-License-Identifier: MIT
// Four passes over one patch, all in working memory that fits the first or second cache:
//   positions: row by row, and one row inside each neighbour ("ghost" lines);
//   normals:   inside in float, four vertices at a time; on borders and corners as sums that are exact in
//   double,
//              so that every patch at a vertex gets the same bits in whatever order it adds;
//   emission:  level by level from the finest, halving the grid in place after each.
// Where finer levels are not emitted, only rows that emitted vertices and their normals need are made.
// A vertex's normal is the area vector of the polygon of its neighbours: the sum of the cross products of the
// triangles around it (K equation 3.12), whose terms in the vertex itself cancel. In K's triangle pattern a
// vertex with i + j even has eight neighbours and any other four, where the sum is (east - west) x (north -
// south).
#include "terrain/patch/generate_vertices.h"

#include <algorithm>
#include <new>

#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/base/simd.h"
#include "terrain/patch/corner_fan.h"
#include "terrain/patch/displacement.h"
#include "terrain/patch/octahedral.h"

namespace karst::core {

namespace {

using simd::Float4;
using simd::Int4;

// A row of the grid holds its even columns, then its odd ones, so that lanes of one parity lie together: what
// a vertex needs of its neighbours depends on the parity of its column and row. Each half has room before it
// for the lane at column -1 and after it for lanes past the end.
constexpr int kPad = simd::kLanes;
constexpr int half_row(int level) {
  return kPad + (patch_cells(level) / 2 + 1 + simd::kLanes - 1) / simd::kLanes * simd::kLanes + kPad;
}
constexpr int kMaxSide = patch_side(kMaxLevel);
constexpr int kMaxGrid = 2 * half_row(kMaxLevel) * kMaxSide;
constexpr int kMaxLine = kMaxSide + simd::kLanes;

// Where column i of row j lies. Columns i, i + 2, i + 4 and i + 6 are four lanes.
struct Layout {
  int half;  // floats between the halves of a row

  explicit constexpr Layout(int level) : half(half_row(level)) {}
  constexpr int stride() const { return 2 * half; }
  constexpr int at(int i, int j) const { return j * stride() + (i & 1) * half + kPad + (i >> 1); }
};

}  // namespace

struct PatchScratch {
  alignas(64) float position[3][kMaxGrid];
  alignas(64) float normal[3][kMaxGrid];
  // One row inside the neighbour across each edge, in this patch's direction.
  alignas(64) float ghost[4][3][kMaxLine];
};

namespace {

// --- positions ---------------------------------------------------------------------------------------------

// Rows between the `step`-th ones that lie beside none of them are left out.
void make_positions(const PatchShape& shape, int step, Layout layout, PatchScratch& s) {
  const int n = patch_cells(shape.level);
  for (int j = 0; j <= n; ++j) {
    if (((j + 1) & (step - 1)) > 2) continue;
    const GridLine line = {0, j, 1, 0};
    const LineCurve curve = line_curve(shape, line);
    for (int parity = 0; parity < 2; ++parity) {
      const int row = layout.at(parity, j);
      displace_points(shape, curve, line, {parity, 2, n / 2 + 1 - parity}, glm::vec3(0), s.position[0] + row,
                      s.position[1] + row, s.position[2] + row);
    }
  }
}

void make_ghosts(const GenerateVertices& job, PatchId patch, PatchScratch& s) {
  const glm::ivec3 origin = patch_origin(job.surface.volume_of(patch));
  for (int e = 0; e < 4; ++e) {
    const PatchEdge neighbour = job.surface.patches[patch].neighbour[e];
    if (!neighbour.exists()) continue;
    const PatchShape shape = PatchShape::make(job.surface, job.heights, job.level, neighbour.patch());
    const glm::vec3 offset(patch_origin(*shape.volume) - origin);
    const GridLine line = GridLine::along_edge(neighbour.edge(), 1, job.level, true);
    displace_line(shape, line, offset, s.ghost[e][0], s.ghost[e][1], s.ghost[e][2]);
  }
}

// --- normals -----------------------------------------------------------------------------------------------

struct Vec4 {
  Float4 x, y, z;
};
inline Vec4 operator-(const Vec4& a, const Vec4& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec4 operator+(const Vec4& a, const Vec4& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec4 cross(const Vec4& a, const Vec4& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec4 load(const float (&plane)[3][kMaxGrid], int index) {
  return {simd::load(plane[0] + index), simd::load(plane[1] + index), simd::load(plane[2] + index)};
}
inline void store(float (&plane)[3][kMaxGrid], int index, const Vec4& v) {
  simd::store(plane[0] + index, v.x);
  simd::store(plane[1] + index, v.y);
  simd::store(plane[2] + index, v.z);
}
inline Vec4 select(Int4 mask, const Vec4& a, const Vec4& b) {
  return {simd::select(mask, a.x, b.x), simd::select(mask, a.y, b.y), simd::select(mask, a.z, b.z)};
}

// Rows 1..n-1, each `step`-th. Columns 0 and n get values too, which the border passes replace.
// The polygon of eight neighbours is cut into three quadrilaterals; a quadrilateral's area vector is the
// cross product of its diagonals, so the vertex itself is not needed.
void make_inner_normals(int n, int step, Layout layout, PatchScratch& s) {
  const int up = layout.stride();
  for (int j = step; j < n; j += step) {
    for (int parity = 0; parity < 2; ++parity) {
      const int other = layout.at(1 - parity, j);
      for (int k = 0; k < n / 2 + 1 - parity; k += simd::kLanes) {
        const int c = layout.at(parity, j) + k;
        const int east = other + k + (parity == 0 ? 0 : 1);  // column i + 1
        const int west = east - 1;                           // column i - 1
        const Vec4 e = load(s.position, east);
        const Vec4 w = load(s.position, west);
        const Vec4 north = load(s.position, c + up);
        const Vec4 south = load(s.position, c - up);
        if ((parity + j) % 2 != 0) {
          store(s.normal, c, cross(e - w, north - south));
          continue;
        }
        const Vec4 ne = load(s.position, east + up);
        const Vec4 nw = load(s.position, west + up);
        const Vec4 sw = load(s.position, west - up);
        const Vec4 se = load(s.position, east - up);
        const Vec4 upper = cross(north - e, nw - ne);
        const Vec4 middle = cross(w - e, se - nw);
        const Vec4 lower = cross(south - w, se - sw);
        store(s.normal, c, upper + middle + lower);
      }
    }
  }
}

// Coordinates are integers below 2^17, so products and sums of products below stay integers below 2^53:
// exact.
using Exact = glm::dvec3;

Exact grid_position(const PatchScratch& s, int index) {
  return {s.position[0][index], s.position[1][index], s.position[2][index]};
}
Exact line_position(const float (&line)[3][kMaxLine], int t) {
  return {line[0][t], line[1][t], line[2][t]};
}

// An exact zero may come with either sign, depending on the order of terms; adding zero makes it positive.
void set_normal(PatchScratch& s, int index, Exact n) {
  for (int axis = 0; axis < 3; ++axis) s.normal[axis][index] = static_cast<float>(n[axis] + 0.0);
}

// Area vector of the half ring on one side of an edge vertex: from `ahead` over the row inside to `behind`,
// all relative to the vertex. inside: the row's vertices at t + 1, t, t - 1. Even t has triangles to all
// three, odd t to the middle one.
Exact half_ring(bool even, Exact ahead, Exact behind, Exact inside_ahead, Exact inside, Exact inside_behind) {
  if (even) return glm::cross(inside_ahead, inside - ahead) + glm::cross(inside_behind, behind - inside);
  return glm::cross(ahead, inside) + glm::cross(inside, behind);
}

// Vertices 1..n-1 of edge e, each `step`-th.
void make_edge_normals(int e, bool has_neighbour, int level, int step, Layout layout, PatchScratch& s) {
  const int n = patch_cells(level);
  const GridLine line = GridLine::along_edge(e, 0, level, false);
  const GridLine inner = GridLine::along_edge(e, 1, level, false);
  const auto index = [&](GridLine l, int t) { return layout.at(l.i0 + t * l.di, l.j0 + t * l.dj); };
  for (int t = step; t < n; t += step) {
    const Exact behind_at = grid_position(s, index(line, t - 1));
    const Exact at = grid_position(s, index(line, t));
    const Exact ahead_at = grid_position(s, index(line, t + 1));
    const bool even = t % 2 == 0;
    const auto own = [&](int u) { return grid_position(s, index(inner, u)); };
    const auto theirs = [&](int u) { return line_position(s.ghost[e], u); };
    Exact sum;
    if (!has_neighbour) {
      const auto relative = [&](int u) { return own(u) - at; };
      sum = half_ring(even, ahead_at - at, behind_at - at, relative(t + 1), relative(t), relative(t - 1));
    } else if (even) {
      const Exact own_behind = own(t - 1);
      const Exact their_ahead = theirs(t + 1);
      sum = glm::cross(own(t) - ahead_at, own_behind - own(t + 1)) +
            glm::cross(behind_at - ahead_at, their_ahead - own_behind) +
            glm::cross(theirs(t) - behind_at, their_ahead - theirs(t - 1));
    } else {
      sum = glm::cross(ahead_at - behind_at, own(t) - theirs(t));
    }
    set_normal(s, index(line, t), sum);
  }
}

// Area vector of two triangles at a grid corner: (vertex, ahead, diagonal) and (vertex, diagonal, behind),
// where ahead and behind are next to the vertex on the edges that leave and reach the corner.
Exact corner_area(Exact vertex, Exact ahead, Exact diagonal, Exact behind) {
  return glm::cross(diagonal - vertex, behind - ahead);
}

struct GridCorner {
  int i, j, di, dj;  // where it is, and the way inside
};
constexpr GridCorner grid_corner(int corner, int n) {
  const bool right = corner == 1 || corner == 2;
  const bool top = corner >= 2;
  return {right ? n : 0, top ? n : 0, right ? -1 : 1, top ? -1 : 1};
}

// Edge `corner` leaves along u at corners 0 and 2, along v at 1 and 3.
constexpr bool leaves_along_u(int corner) {
  return corner % 2 == 0;
}

// The area at a corner of a patch of which no vertex is known yet.
Exact far_corner_area(const GenerateVertices& job, PatchCorner at_corner) {
  const PatchShape shape = PatchShape::make(job.surface, job.heights, job.level, at_corner.patch);
  const int n = patch_cells(job.level);
  if (job.surface.patches[at_corner.patch].collapsed != 0 && at_corner.corner == 0) {
    // The apex: a fan over the row next to it.
    float line[3][kMaxLine];
    displace_line(shape, {1, 0, 0, 1}, glm::vec3(0), line[0], line[1], line[2]);
    const Exact v(displace_vertices(shape, {0, 0, 0, 0}, {0, 0, 0, 0}).position[0]);
    Exact sum(0.0);
    for (int j = 0; j < n; ++j) sum += glm::cross(line_position(line, j) - v, line_position(line, j + 1) - v);
    return sum;
  }
  const GridCorner c = grid_corner(at_corner.corner, n);
  const Vertices4 v =
      displace_vertices(shape, {c.i, c.i + c.di, c.i + c.di, c.i}, {c.j, c.j, c.j + c.dj, c.j + c.dj});
  const bool u = leaves_along_u(at_corner.corner);
  return corner_area(Exact(v.position[0]), Exact(v.position[u ? 1 : 3]), Exact(v.position[2]),
                     Exact(v.position[u ? 3 : 1]));
}

Exact own_corner_area(const GenerateVertices& job, PatchCorner at_corner, Layout layout,
                      const PatchScratch& s) {
  const int n = patch_cells(job.level);
  if (job.surface.patches[at_corner.patch].collapsed != 0 && at_corner.corner == 0) {
    const Exact v = grid_position(s, layout.at(0, 0));
    Exact sum(0.0);
    for (int j = 0; j < n; ++j) {
      sum += glm::cross(grid_position(s, layout.at(1, j)) - v, grid_position(s, layout.at(1, j + 1)) - v);
    }
    return sum;
  }
  const GridCorner c = grid_corner(at_corner.corner, n);
  const Exact along_u = grid_position(s, layout.at(c.i + c.di, c.j));
  const Exact along_v = grid_position(s, layout.at(c.i, c.j + c.dj));
  const Exact diagonal = grid_position(s, layout.at(c.i + c.di, c.j + c.dj));
  const bool u = leaves_along_u(at_corner.corner);
  return corner_area(grid_position(s, layout.at(c.i, c.j)), u ? along_u : along_v, diagonal,
                     u ? along_v : along_u);
}

// The neighbour across edge e at the corner where e starts (or ends), from the ghost line: its border is
// ours.
Exact ghost_corner_area(int e, bool start, int level, Layout layout, const PatchScratch& s) {
  const int n = patch_cells(level);
  const GridLine line = GridLine::along_edge(e, 0, level, false);
  const auto border = [&](int t) {
    return grid_position(s, layout.at(line.i0 + t * line.di, line.j0 + t * line.dj));
  };
  const auto ghost = [&](int t) { return line_position(s.ghost[e], t); };
  // Seen from the neighbour, its edge along ours reaches our start, and leaves from our end.
  return start ? corner_area(border(0), ghost(0), ghost(1), border(1))
               : corner_area(border(n), border(n - 1), ghost(n - 1), ghost(n));
}

void make_corner_normals(const GenerateVertices& job, PatchId patch, Layout layout, PatchScratch& s) {
  const std::span<const Patch> patches = job.surface.patches;
  const Patch& p = patches[patch];
  const int n = patch_cells(job.level);
  const auto apex = [&](PatchCorner c) { return patches[c.patch].collapsed != 0 && c.corner == 0; };
  for (int corner = 0; corner < 4 - p.collapsed; ++corner) {
    PatchCorner fan[kMaxCornerFan];
    const int count = corner_fan(patches, {patch, corner}, fan);
    const int arriving = (corner + 3) % 4 == 3 && p.collapsed != 0 ? 2 : (corner + 3) % 4;
    Exact sum = own_corner_area(job, fan[0], layout, s);
    for (int f = 1; f < count; ++f) {
      const PatchEdge before = p.neighbour[arriving];
      const PatchEdge after = p.neighbour[corner];
      const auto is = [&](PatchEdge edge, int its_corner) {
        return edge.exists() && edge.patch() == fan[f].patch && its_corner == fan[f].corner && !apex(fan[f]);
      };
      if (is(before, before.edge())) {
        sum += ghost_corner_area(arriving, false, job.level, layout, s);
      } else if (is(after, (after.edge() + 1) & 3)) {
        sum += ghost_corner_area(corner, true, job.level, layout, s);
      } else {
        sum += far_corner_area(job, fan[f]);
      }
    }
    const GridCorner c = grid_corner(corner, n);
    set_normal(s, layout.at(c.i, c.j), sum);
    if (apex(fan[0])) {
      for (int j = 1; j <= n; ++j) set_normal(s, layout.at(0, j), sum);
    }
  }
}

void normalise(int n, int step, Layout layout, PatchScratch& s) {
  for (int j = 0; j <= n; j += step) {
    for (int parity = 0; parity < 2; ++parity) {
      for (int k = 0; k < n / 2 + 1 - parity; k += simd::kLanes) {
        const int c = layout.at(parity, j) + k;
        const Vec4 v = load(s.normal, c);
        const Float4 length = simd::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
        const Float4 scale = 1.0f / simd::max(length, simd::splat(1e-12f));
        store(s.normal, c, {v.x * scale, v.y * scale, v.z * scale});
      }
    }
  }
}

// --- emission ----------------------------------------------------------------------------------------------

// Lane-wise encode_octahedral.
inline Int4 encode_octahedral4(const Vec4& n) {
  const Float4 sum = simd::abs(n.x) + simd::abs(n.y) + simd::abs(n.z);
  const Float4 scale = 1.0f / simd::max(sum, simd::splat(1e-30f));
  Float4 x = n.x * scale;
  Float4 z = n.z * scale;
  const Int4 lower = n.y < 0.0f;
  if (simd::any(lower)) {
    const Float4 fold_x = simd::copy_sign(1.0f - simd::abs(z), x);
    z = simd::select(lower, simd::copy_sign(1.0f - simd::abs(x), z), z);
    x = simd::select(lower, fold_x, x);
  }
  const auto biased = [](Float4 v) { return simd::to_int(v * 127.0f + 128.5f); };
  return (biased(x) | biased(z) << 8) ^ 0x8080;
}

struct PackedVertices {
  Int4 vertex[simd::kLanes];  // four GpuVertex
};

// position, morph: integers held in floats; morph_sum is twice the morph position.
inline PackedVertices pack(const Vec4& position, const Vec4& normal, const Vec4& morph_sum,
                           const Vec4& morph_normal) {
  const auto half = [](Float4 sum) { return (simd::to_int(sum) + 1) >> 1; };
  const Int4 n = encode_octahedral4(normal);
  const Int4 m = encode_octahedral4(morph_normal);
  PackedVertices r;
  r.vertex[0] = (simd::to_int(position.x) & 0xffff) | simd::to_int(position.y) << 16;
  r.vertex[1] = (simd::to_int(position.z) & 0xffff) | n << 16;
  r.vertex[2] = (half(morph_sum.x) & 0xffff) | half(morph_sum.y) << 16;
  r.vertex[3] = (half(morph_sum.z) & 0xffff) | m << 16;
  simd::transpose(r.vertex[0], r.vertex[1], r.vertex[2], r.vertex[3]);
  return r;
}

struct Parents {
  Vec4 position_sum;
  Vec4 normal_sum;
};
inline Parents parents(const PatchScratch& s, int a, int b) {
  return {load(s.position, a) + load(s.position, b), load(s.normal, a) + load(s.normal, b)};
}

// A row of odd j: every vertex is new at this level. Even columns lie between their neighbours above and
// below, odd ones on the diagonal of the coarser cell, which alternates like K's pattern (figure 3.27).
GpuVertex* emit_odd_row(int n, Layout layout, int j, const PatchScratch& s, GpuVertex* out) {
  const int up = layout.stride();
  for (int k = 0; k <= n / 2; k += simd::kLanes) {
    const int c = layout.at(0, j) + k;
    const Parents upright = parents(s, c - up, c + up);
    const PackedVertices v =
        pack(load(s.position, c), load(s.normal, c), upright.position_sum, upright.normal_sum);
    const int lanes = n / 2 + 1 - k < simd::kLanes ? n / 2 + 1 - k : simd::kLanes;
    for (int lane = 0; lane < lanes; ++lane) simd::store(out + 2 * (k + lane), v.vertex[lane]);
  }
  // The first coarser cell's diagonal rises, from (0,0) to (1,1), in even rows of coarser cells.
  const Int4 rising = j / 2 % 2 == 0 ? Int4{-1, 0, -1, 0} : Int4{0, -1, 0, -1};
  for (int k = 0; k < n / 2; k += simd::kLanes) {
    const int c = layout.at(1, j) + k;
    const int west = layout.at(0, j) + k;
    const Parents up_right = parents(s, west - up, west + 1 + up);
    const Parents down_right = parents(s, west + up, west + 1 - up);
    const PackedVertices v = pack(load(s.position, c), load(s.normal, c),
                                  select(rising, up_right.position_sum, down_right.position_sum),
                                  select(rising, up_right.normal_sum, down_right.normal_sum));
    const int lanes = n / 2 - k < simd::kLanes ? n / 2 - k : simd::kLanes;
    for (int lane = 0; lane < lanes; ++lane) simd::store(out + 2 * (k + lane) + 1, v.vertex[lane]);
  }
  return out + n + 1;
}

// A row of even j: odd columns are new.
GpuVertex* emit_even_row(int n, Layout layout, int j, const PatchScratch& s, GpuVertex* out) {
  for (int k = 0; k < n / 2; k += simd::kLanes) {
    const int c = layout.at(1, j) + k;
    const int west = layout.at(0, j) + k;
    const Parents beside = parents(s, west, west + 1);
    const PackedVertices v =
        pack(load(s.position, c), load(s.normal, c), beside.position_sum, beside.normal_sum);
    const int lanes = n / 2 - k < simd::kLanes ? n / 2 - k : simd::kLanes;
    for (int lane = 0; lane < lanes; ++lane) simd::store(out + k + lane, v.vertex[lane]);
  }
  return out + n / 2;
}

// The nine vertices of level 1 stay where they are.
void emit_level_1(Layout layout, const PatchScratch& s, GpuVertex* out) {
  for (int j = 0; j < 3; ++j) {
    for (int parity = 0; parity < 2; ++parity) {
      const int c = layout.at(parity, j);
      const Vec4 p = load(s.position, c);
      const Vec4 n = load(s.normal, c);
      const PackedVertices v = pack(p, n, p + p, n);
      for (int lane = 0; lane < 2 - parity; ++lane)
        simd::store(out + 3 * j + parity + 2 * lane, v.vertex[lane]);
    }
  }
}

// Keeps even rows and columns, in place: the even columns of row 2j become both halves of row j. Values are
// read before anything lands on them: other rows lie behind, and in row 0 four values land where eight were
// read.
// step: of rows of the halved grid that are needed.
void halve(int n, int step, Layout layout, float (&plane)[3][kMaxGrid]) {
  for (auto& p : plane) {
    for (int j = 0; j <= n / 2; j += step) {
      const float* from = p + layout.at(0, 2 * j);
      float* even = p + layout.at(0, j);
      float* odd = p + layout.at(1, j);
      for (int k = 0; k <= n / 4; k += simd::kLanes) {
        const Float4 a = simd::load(from + 2 * k);
        const Float4 b = simd::load(from + 2 * k + simd::kLanes);
        simd::store(even + k, __builtin_shufflevector(a, b, 0, 2, 4, 6));
        simd::store(odd + k, __builtin_shufflevector(a, b, 1, 3, 5, 7));
      }
    }
  }
}

void emit(int level, int emit_level, Layout layout, PatchScratch& s, GpuVertex* out) {
  for (int m = level; m > 1; --m) {
    const int n = patch_cells(m);
    if (m <= emit_level) {
      GpuVertex* next = out + patch_vertices(m - 1);
      for (int j = 0; j <= n; ++j) {
        next = j % 2 != 0 ? emit_odd_row(n, layout, j, s, next) : emit_even_row(n, layout, j, s, next);
      }
    }
    const int step = m > emit_level ? 1 << (m - 1 - emit_level) : 1;
    halve(n, step, layout, s.position);
    halve(n, step, layout, s.normal);
  }
  emit_level_1(layout, s, out);
}

void make_bounds(int n, Layout layout, const PatchScratch& s, PatchBounds& bounds) {
  for (int axis = 0; axis < 3; ++axis) {
    float lowest = s.position[axis][layout.at(0, 0)];
    float highest = lowest;
    Float4 low = simd::splat(lowest);
    Float4 high = low;
    for (int j = 0; j <= n; ++j) {
      for (int parity = 0; parity < 2; ++parity) {
        const float* row = s.position[axis] + layout.at(parity, j);
        const int count = n / 2 + 1 - parity;
        int k = 0;
        for (; k + simd::kLanes <= count; k += simd::kLanes) {
          const Float4 v = simd::load(row + k);
          low = simd::min(v, low);
          high = simd::max(v, high);
        }
        for (; k < count; ++k) {
          lowest = row[k] < lowest ? row[k] : lowest;
          highest = row[k] > highest ? row[k] : highest;
        }
      }
    }
    for (int lane = 0; lane < simd::kLanes; ++lane) {
      lowest = low[lane] < lowest ? low[lane] : lowest;
      highest = high[lane] > highest ? high[lane] : highest;
    }
    bounds.min[axis] = static_cast<std::int16_t>(lowest);
    bounds.max[axis] = static_cast<std::int16_t>(highest);
  }
}

// --- ways to morph targets
// -----------------------------------------------------------------------------------

Float4 squared_way(const Vec4& v, const Vec4& parent, const Vec4& other) {
  const Vec4 way = v + v - parent - other;
  return way.x * way.x + way.y * way.y + way.z * way.z;
}
float squared_way(const PatchScratch& s, int v, int parent, int other) {
  const glm::vec3 way = 2.0f * glm::vec3(s.position[0][v], s.position[1][v], s.position[2][v]) -
                        glm::vec3(s.position[0][parent], s.position[1][parent], s.position[2][parent]) -
                        glm::vec3(s.position[0][other], s.position[1][other], s.position[2][other]);
  return way.x * way.x + way.y * way.y + way.z * way.z;
}

// Of a vertex of a level of n cells that is new there; targets as in emit_odd_row() and emit_even_row().
float squared_way(int i, int j, Layout layout, const PatchScratch& s) {
  const int v = layout.at(i, j);
  if (j % 2 == 0) return squared_way(s, v, layout.at(i - 1, j), layout.at(i + 1, j));
  if (i % 2 == 0) return squared_way(s, v, layout.at(i, j - 1), layout.at(i, j + 1));
  const int up = (i / 2 + j / 2) % 2 == 0 ? 1 : -1;
  return squared_way(s, v, layout.at(i - 1, j - up), layout.at(i + 1, j + up));
}

// Four at a time, those of column n aside.
Float4 row_of_ways(int n, int j, Layout layout, const PatchScratch& s) {
  const int up = layout.stride();
  const Int4 rising = j / 2 % 2 == 0 ? Int4{-1, 0, -1, 0} : Int4{0, -1, 0, -1};
  Float4 most = simd::splat(0.0f);
  for (int k = 0; k < n / 2; k += simd::kLanes) {
    const int west = layout.at(0, j) + k;
    const int c = layout.at(1, j) + k;
    const Vec4 odd = load(s.position, c);
    if (j % 2 == 0) {
      most = simd::max(squared_way(odd, load(s.position, west), load(s.position, west + 1)), most);
      continue;
    }
    most = simd::max(
        squared_way(load(s.position, west), load(s.position, west - up), load(s.position, west + up)), most);
    const Vec4 first = select(rising, load(s.position, west - up), load(s.position, west + up));
    const Vec4 second = select(rising, load(s.position, west + 1 + up), load(s.position, west + 1 - up));
    most = simd::max(squared_way(odd, first, second), most);
  }
  return most;
}

float most_of(Float4 v) {
  return std::max(std::max(v[0], v[1]), std::max(v[2], v[3]));
}

void measure_ways(int level, Layout layout, PatchScratch& s, MorphWays& ways) {
  ways = {};
  for (int m = level; m > 1; --m) {
    const int n = patch_cells(m);
    float& longest = ways.longest[m];
    for (int j = 0; j <= n; ++j) {
      float row = 0;
      if (n / 2 % simd::kLanes == 0) {
        row = most_of(row_of_ways(n, j, layout, s));
      } else {
        for (int i = j % 2 != 0 ? 0 : 1; i < n; i += j % 2 != 0 ? 1 : 2)
          row = std::max(row, squared_way(i, j, layout, s));
      }
      longest = std::max(longest, row);
      if (j == 0 || j == n) ways.on_edge[m][j == 0 ? 0 : 2] = row;
      if (j % 2 == 0) continue;
      const float last = squared_way(n, j, layout, s);
      longest = std::max(longest, last);
      ways.on_edge[m][1] = std::max(ways.on_edge[m][1], last);
      ways.on_edge[m][3] = std::max(ways.on_edge[m][3], squared_way(0, j, layout, s));
    }
    halve(n, 1, layout, s.position);
  }
}

}  // namespace

Status GenerateVertices::validate() const {
  if (scratch == nullptr) return {StatusCode::invalid_argument, "no working memory given", "scratch"};
  if (heights.level < 1 || heights.level > kMaxLevel) {
    return {StatusCode::invalid_argument, "heights' level is out of 1..6", "heights.level",
            static_cast<std::uint64_t>(heights.level)};
  }
  if (level < 1 || level > heights.level) {
    return {StatusCode::invalid_argument, "level is out of 1..heights.level", "level",
            static_cast<std::uint64_t>(level)};
  }
  if (emit_level < 0 || emit_level > level) {
    return {StatusCode::invalid_argument, "emit_level is out of 0..level", "emit_level",
            static_cast<std::uint64_t>(emit_level)};
  }
  return {};
}

void GenerateVertices::run(PatchId patch, std::span<GpuVertex> out, PatchBounds* bounds) const {
  KARST_ASSERT(validate().ok() && patch < surface.patches.size());
  KARST_ASSERT(out.size() >= static_cast<std::size_t>(patch_vertices(emit_level > 0 ? emit_level : level)));
  PatchScratch& s = *scratch;
  const Layout layout(level);
  const int n = patch_cells(level);
  const Patch& p = surface.patches[patch];
  const int emitted = emit_level == 0 ? level : emit_level;
  const int step = 1 << (level - emitted);
  // A fan over a collapsed edge has all rows, and so has the box.
  const bool all_rows = p.collapsed != 0 || bounds != nullptr;
  make_positions(PatchShape::make(surface, heights, level, patch), all_rows ? 1 : step, layout, s);
  make_ghosts(*this, patch, s);
  if (bounds != nullptr) make_bounds(n, layout, s, *bounds);
  make_inner_normals(n, step, layout, s);
  for (int e = 0; e < 4 - p.collapsed; ++e)
    make_edge_normals(e, p.neighbour[e].exists(), level, step, layout, s);
  make_corner_normals(*this, patch, layout, s);
  normalise(n, step, layout, s);
  emit(level, emitted, layout, s, out.data());
}

PatchBounds GenerateVertices::bounds(PatchId patch) const {
  const Layout layout(level);
  make_positions(PatchShape::make(surface, heights, level, patch), 1, layout, *scratch);
  PatchBounds result;
  make_bounds(patch_cells(level), layout, *scratch, result);
  return result;
}

PatchBounds GenerateVertices::bounds(PatchId patch, MorphWays& ways) const {
  const PatchBounds result = bounds(patch);
  measure_ways(level, Layout(level), *scratch, ways);
  return result;
}

std::size_t patch_scratch_bytes() {
  return sizeof(PatchScratch);
}

PatchScratch* make_patch_scratch(std::span<std::byte> memory) {
  if (memory.size() < sizeof(PatchScratch) ||
      reinterpret_cast<std::uintptr_t>(memory.data()) % alignof(PatchScratch) != 0) {
    return nullptr;
  }
  return ::new (static_cast<void*>(memory.data())) PatchScratch();
}

}  // namespace karst::core
