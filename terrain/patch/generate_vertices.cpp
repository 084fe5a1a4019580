// SPDX-License-Identifier: MIT
// Four passes over one patch, all in working memory that fits the first or second cache:
//   positions: row by row, and one row inside each neighbour ("ghost" lines);
//   normals:   inside in float, four vertices at a time; on borders and corners as sums that are exact in double,
//              so that every patch at a vertex gets the same bits in whatever order it adds;
//   emission:  level by level from the finest, halving the grid in place after each.
// A vertex's normal is the area vector of the polygon of its neighbours: the sum of the cross products of the
// triangles around it (K equation 3.12), whose terms in the vertex itself cancel. In K's triangle pattern a vertex with
// i + j even has eight neighbours and any other four, where the sum is (east - west) x (north - south).
#include "terrain/patch/generate_vertices.h"

#include <new>

#include <glm/geometric.hpp>

#include "terrain/patch/corner_fan.h"
#include "terrain/patch/displacement.h"
#include "terrain/patch/octahedral.h"
#include "terrain/patch/simd.h"

namespace karst {

namespace {

using simd::Float4;
using simd::Int4;

constexpr int kLeftPad = simd::kLanes;  // floats before a row, so that lanes at i - 1 can be read
constexpr int kMaxSide = patch_side(kMaxLevel);
constexpr int kMaxStride = kLeftPad + kMaxSide + 2 * simd::kLanes - 1;
constexpr int kMaxGrid = kMaxStride * kMaxSide + simd::kLanes;
constexpr int kMaxLine = kMaxSide + simd::kLanes;

// Floats between rows of the grid: pad, the row, and room for lanes past its end.
constexpr int grid_stride(int level) { return (kLeftPad + patch_side(level) + simd::kLanes) / simd::kLanes * simd::kLanes; }

struct Grid {
  float* x;
  float* y;
  float* z;
};

}  // namespace

struct PatchScratch {
  alignas(64) float position[3][kMaxGrid];
  alignas(64) float normal[3][kMaxGrid];
  alignas(64) float ghost[4][3][kMaxLine];  // one row inside the neighbour across each edge, in this patch's direction
};

namespace {

constexpr int at(int stride, int i, int j) { return j * stride + kLeftPad + i; }

// --- positions ---------------------------------------------------------------------------------------------

void make_positions(const PatchShape& shape, int stride, PatchScratch& s) {
  const int side = patch_side(shape.level);
  for (int j = 0; j < side; ++j) {
    const int row = at(stride, 0, j);
    displace_line(shape, {0, j, 1, 0}, glm::vec3(0), s.position[0] + row, s.position[1] + row, s.position[2] + row);
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
inline Vec4 operator-(const Vec4& a, const Vec4& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec4 operator+(const Vec4& a, const Vec4& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
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

constexpr Int4 kEvenLanes = {-1, 0, -1, 0};
constexpr Int4 kOddLanes = {0, -1, 0, -1};

// Rows 1..n-1. Columns 0 and n get values too, which the border pass replaces.
void make_inner_normals(int n, int stride, PatchScratch& s) {
  for (int j = 1; j < n; ++j) {
    const Int4 eight = j % 2 == 0 ? kEvenLanes : kOddLanes;
    for (int i = 0; i <= n; i += simd::kLanes) {
      const int c = at(stride, i, j);
      const Vec4 v = load(s.position, c);
      const Vec4 e = load(s.position, c + 1) - v;
      const Vec4 w = load(s.position, c - 1) - v;
      const Vec4 north = load(s.position, c + stride) - v;
      const Vec4 south = load(s.position, c - stride) - v;
      const Vec4 four = cross(e - w, north - south);
      const Vec4 ne = load(s.position, c + stride + 1) - v;
      const Vec4 nw = load(s.position, c + stride - 1) - v;
      const Vec4 sw = load(s.position, c - stride - 1) - v;
      const Vec4 se = load(s.position, c - stride + 1) - v;
      const Vec4 ring = (cross(ne, north - e) + cross(nw, w - north)) + (cross(sw, south - w) + cross(se, e - south));
      store(s.normal, c, select(eight, ring, four));
    }
  }
}

// Coordinates are integers below 2^17, so products and sums of products below stay integers below 2^53: exact.
using Exact = glm::dvec3;

Exact grid_position(const PatchScratch& s, int index) { return {s.position[0][index], s.position[1][index], s.position[2][index]}; }
Exact line_position(const float (&line)[3][kMaxLine], int t) { return {line[0][t], line[1][t], line[2][t]}; }

void set_normal(PatchScratch& s, int index, Exact n) {
  for (int axis = 0; axis < 3; ++axis) s.normal[axis][index] = static_cast<float>(n[axis]);
}

// Area vector of the half ring on one side of an edge vertex: from `ahead` over the row inside to `behind`, all relative
// to the vertex. inside: the row's vertices at t + 1, t, t - 1. Even t has triangles to all three, odd t to the middle one.
Exact half_ring(bool even, Exact ahead, Exact behind, Exact inside_ahead, Exact inside, Exact inside_behind) {
  if (even) return glm::cross(inside_ahead, inside - ahead) + glm::cross(inside_behind, behind - inside);
  return glm::cross(ahead, inside) + glm::cross(inside, behind);
}

// Vertices 1..n-1 of edge e.
void make_edge_normals(int e, bool has_neighbour, int level, int stride, PatchScratch& s) {
  const int n = patch_cells(level);
  const GridLine line = GridLine::along_edge(e, 0, level, false);
  const GridLine inner = GridLine::along_edge(e, 1, level, false);
  const int step = at(stride, line.di, line.dj) - at(stride, 0, 0);
  const int first = at(stride, line.i0, line.j0);
  const int first_inner = at(stride, inner.i0, inner.j0);
  for (int t = 1; t < n; ++t) {
    const Exact v = grid_position(s, first + t * step);
    const auto own = [&](int base, int u) { return grid_position(s, base + u * step) - v; };
    const Exact ahead = own(first, t + 1);
    const Exact behind = own(first, t - 1);
    const bool even = t % 2 == 0;
    Exact sum = half_ring(even, ahead, behind, own(first_inner, t + 1), own(first_inner, t), own(first_inner, t - 1));
    if (has_neighbour) {
      const auto theirs = [&](int u) { return line_position(s.ghost[e], u) - v; };
      sum += half_ring(even, behind, ahead, theirs(t - 1), theirs(t), theirs(t + 1));
    }
    set_normal(s, first + t * step, sum);
  }
}

// Area vector of two triangles at a grid corner: (vertex, ahead, diagonal) and (vertex, diagonal, behind), where ahead and
// behind are next to the vertex on the edges that leave and reach the corner.
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
constexpr bool leaves_along_u(int corner) { return corner % 2 == 0; }

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
  const Vertices4 v = displace_vertices(shape, {c.i, c.i + c.di, c.i + c.di, c.i}, {c.j, c.j, c.j + c.dj, c.j + c.dj});
  const bool u = leaves_along_u(at_corner.corner);
  return corner_area(Exact(v.position[0]), Exact(v.position[u ? 1 : 3]), Exact(v.position[2]), Exact(v.position[u ? 3 : 1]));
}

Exact own_corner_area(const GenerateVertices& job, PatchCorner at_corner, int stride, const PatchScratch& s) {
  const int n = patch_cells(job.level);
  if (job.surface.patches[at_corner.patch].collapsed != 0 && at_corner.corner == 0) {
    const Exact v = grid_position(s, at(stride, 0, 0));
    Exact sum(0.0);
    for (int j = 0; j < n; ++j) {
      sum += glm::cross(grid_position(s, at(stride, 1, j)) - v, grid_position(s, at(stride, 1, j + 1)) - v);
    }
    return sum;
  }
  const GridCorner c = grid_corner(at_corner.corner, n);
  const Exact along_u = grid_position(s, at(stride, c.i + c.di, c.j));
  const Exact along_v = grid_position(s, at(stride, c.i, c.j + c.dj));
  const Exact diagonal = grid_position(s, at(stride, c.i + c.di, c.j + c.dj));
  const bool u = leaves_along_u(at_corner.corner);
  return corner_area(grid_position(s, at(stride, c.i, c.j)), u ? along_u : along_v, diagonal, u ? along_v : along_u);
}

// The neighbour across edge e at the corner where e starts (or ends), from the ghost line: its border is ours.
Exact ghost_corner_area(int e, bool start, int level, int stride, const PatchScratch& s) {
  const int n = patch_cells(level);
  const GridLine line = GridLine::along_edge(e, 0, level, false);
  const auto border = [&](int t) { return grid_position(s, at(stride, line.i0 + t * line.di, line.j0 + t * line.dj)); };
  const auto ghost = [&](int t) { return line_position(s.ghost[e], t); };
  // Seen from the neighbour, its edge along ours reaches our start, and leaves from our end.
  return start ? corner_area(border(0), ghost(0), ghost(1), border(1))
               : corner_area(border(n), border(n - 1), ghost(n - 1), ghost(n));
}

void make_corner_normals(const GenerateVertices& job, PatchId patch, int stride, PatchScratch& s) {
  const std::span<const Patch> patches = job.surface.patches;
  const Patch& p = patches[patch];
  const int n = patch_cells(job.level);
  const auto apex = [&](PatchCorner c) { return patches[c.patch].collapsed != 0 && c.corner == 0; };
  for (int corner = 0; corner < 4 - p.collapsed; ++corner) {
    PatchCorner fan[kMaxCornerFan];
    const int count = corner_fan(patches, {patch, corner}, fan);
    const int arriving = (corner + 3) % 4 == 3 && p.collapsed != 0 ? 2 : (corner + 3) % 4;
    Exact sum = own_corner_area(job, fan[0], stride, s);
    for (int f = 1; f < count; ++f) {
      const PatchEdge before = p.neighbour[arriving];
      const PatchEdge after = p.neighbour[corner];
      const auto is = [&](PatchEdge edge, int its_corner) {
        return edge.exists() && edge.patch() == fan[f].patch && its_corner == fan[f].corner && !apex(fan[f]);
      };
      if (is(before, before.edge())) {
        sum += ghost_corner_area(arriving, false, job.level, stride, s);
      } else if (is(after, (after.edge() + 1) & 3)) {
        sum += ghost_corner_area(corner, true, job.level, stride, s);
      } else {
        sum += far_corner_area(job, fan[f]);
      }
    }
    const GridCorner c = grid_corner(corner, n);
    set_normal(s, at(stride, c.i, c.j), sum);
    if (apex(fan[0])) {
      for (int j = 1; j <= n; ++j) set_normal(s, at(stride, 0, j), sum);
    }
  }
}

void normalise(int n, int stride, PatchScratch& s) {
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; i += simd::kLanes) {
      const int c = at(stride, i, j);
      const Vec4 v = load(s.normal, c);
      const Float4 length = simd::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
      const Float4 scale = 1.0f / simd::max(length, simd::splat(1e-12f));
      store(s.normal, c, {v.x * scale, v.y * scale, v.z * scale});
    }
  }
}

// --- emission ----------------------------------------------------------------------------------------------

// Lane-wise encode_octahedral.
inline Int4 encode_octahedral4(const Vec4& n) {
  const Float4 sum = simd::abs(n.x) + simd::abs(n.y) + simd::abs(n.z);
  const Float4 scale = 1.0f / simd::max(sum, simd::splat(1e-30f));
  const Float4 x = n.x * scale;
  const Float4 y = n.y * scale;
  const Int4 lower = n.z < 0.0f;
  const Float4 u = simd::select(lower, simd::copy_sign(1.0f - simd::abs(y), x), x);
  const Float4 v = simd::select(lower, simd::copy_sign(1.0f - simd::abs(x), y), y);
  const auto snorm8 = [](Float4 f) { return simd::to_int(f * 127.0f + simd::copy_sign(simd::splat(0.5f), f)); };
  return (snorm8(u) & 0xff) | (snorm8(v) & 0xff) << 8;
}

struct PackedVertices {
  Int4 vertex[simd::kLanes];  // four GpuVertex
};

// position, morph: integers held in floats; morph_sum is twice the morph position.
inline PackedVertices pack(const Vec4& position, const Vec4& normal, const Vec4& morph_sum, const Vec4& morph_normal) {
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

// A row of odd j: every vertex is new at this level. Even i lie between their neighbours above and below, odd i on
// the diagonal of the coarser cell, which alternates like K's pattern (figure 3.27).
GpuVertex* emit_odd_row(int side, int stride, int j, const PatchScratch& s, GpuVertex* out) {
  const bool rising_first = (j / 2) % 2 == 0;  // diagonal of the first coarser cell goes from (0,0) to (1,1)
  const Int4 lane1 = {0, -1, 0, 0};
  const Int4 lane3 = {0, 0, 0, -1};
  const Int4 rising = rising_first ? lane1 : lane3;
  for (int i = 0; i < side; i += simd::kLanes) {
    const int c = at(stride, i, j);
    const Parents upright = parents(s, c - stride, c + stride);
    const Parents up = parents(s, c - stride - 1, c + stride + 1);
    const Parents down = parents(s, c - stride + 1, c + stride - 1);
    const Vec4 diagonal_position = select(rising, up.position_sum, down.position_sum);
    const Vec4 diagonal_normal = select(rising, up.normal_sum, down.normal_sum);
    const PackedVertices v =
        pack(load(s.position, c), load(s.normal, c), select(kEvenLanes, upright.position_sum, diagonal_position),
             select(kEvenLanes, upright.normal_sum, diagonal_normal));
    const int lanes = side - i < simd::kLanes ? side - i : simd::kLanes;
    for (int lane = 0; lane < lanes; ++lane) simd::store(out++, v.vertex[lane]);
  }
  return out;
}

// A row of even j: odd i are new.
GpuVertex* emit_even_row(int side, int stride, int j, const PatchScratch& s, GpuVertex* out) {
  for (int i = 0; i < side - 1; i += simd::kLanes) {
    const int c = at(stride, i, j);
    const Parents level = parents(s, c - 1, c + 1);
    const PackedVertices v = pack(load(s.position, c), load(s.normal, c), level.position_sum, level.normal_sum);
    simd::store(out++, v.vertex[1]);
    if (i + 3 < side) simd::store(out++, v.vertex[3]);
  }
  return out;
}

// The nine vertices of level 1 stay where they are.
void emit_level_1(int stride, const PatchScratch& s, GpuVertex* out) {
  for (int j = 0; j < 3; ++j) {
    const int c = at(stride, 0, j);
    const Vec4 p = load(s.position, c);
    const Vec4 n = load(s.normal, c);
    const PackedVertices v = pack(p, n, p + p, n);
    for (int lane = 0; lane < 3; ++lane) simd::store(out++, v.vertex[lane]);
  }
}

// Keeps even rows and columns, in place: a value is read before anything lands on it.
void halve(int n, int stride, float (&plane)[3][kMaxGrid]) {
  for (auto& p : plane) {
    for (int j = 0; j <= n / 2; ++j) {
      const float* from = p + at(stride, 0, 2 * j);
      float* to = p + at(stride, 0, j);
      for (int i = 0; i <= n / 2; ++i) to[i] = from[2 * i];
    }
  }
}

void emit(int level, int stride, PatchScratch& s, GpuVertex* out) {
  for (int m = level; m > 1; --m) {
    const int side = patch_side(m);
    GpuVertex* next = out + patch_vertices(m - 1);
    for (int j = 0; j < side; ++j) {
      next = j % 2 != 0 ? emit_odd_row(side, stride, j, s, next) : emit_even_row(side, stride, j, s, next);
    }
    halve(side - 1, stride, s.position);
    halve(side - 1, stride, s.normal);
  }
  emit_level_1(stride, s, out);
}

void make_bounds(int n, int stride, const PatchScratch& s, PatchBounds& bounds) {
  for (int axis = 0; axis < 3; ++axis) {
    float lowest = s.position[axis][at(stride, 0, 0)];
    float highest = lowest;
    Float4 low = simd::splat(lowest);
    Float4 high = low;
    for (int j = 0; j <= n; ++j) {
      const float* row = s.position[axis] + at(stride, 0, j);
      int i = 0;
      for (; i + simd::kLanes <= n; i += simd::kLanes) {
        const Float4 v = simd::load(row + i);
        low = simd::select(v < low, v, low);
        high = simd::max(v, high);
      }
      for (; i <= n; ++i) {
        lowest = row[i] < lowest ? row[i] : lowest;
        highest = row[i] > highest ? row[i] : highest;
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

}  // namespace

Status GenerateVertices::validate() const {
  if (scratch == nullptr) return {StatusCode::invalid_argument, "no working memory given", "scratch"};
  if (heights.level < 1 || heights.level > kMaxLevel) {
    return {StatusCode::invalid_argument, "heights' level is out of 1..6", "heights.level", static_cast<std::uint64_t>(heights.level)};
  }
  if (level < 1 || level > heights.level) {
    return {StatusCode::invalid_argument, "level is out of 1..heights.level", "level", static_cast<std::uint64_t>(level)};
  }
  return {};
}

void GenerateVertices::run(PatchId patch, std::span<GpuVertex> out, PatchBounds* bounds) const {
  PatchScratch& s = *scratch;
  const int stride = grid_stride(level);
  const int n = patch_cells(level);
  const Patch& p = surface.patches[patch];
  make_positions(PatchShape::make(surface, heights, level, patch), stride, s);
  make_ghosts(*this, patch, s);
  if (bounds != nullptr) make_bounds(n, stride, s, *bounds);
  make_inner_normals(n, stride, s);
  for (int e = 0; e < 4 - p.collapsed; ++e) make_edge_normals(e, p.neighbour[e].exists(), level, stride, s);
  make_corner_normals(*this, patch, stride, s);
  normalise(n, stride, s);
  emit(level, stride, s, out.data());
}

std::size_t patch_scratch_bytes() { return sizeof(PatchScratch); }

PatchScratch* make_patch_scratch(std::span<std::byte> memory) {
  if (memory.size() < sizeof(PatchScratch) || reinterpret_cast<std::uintptr_t>(memory.data()) % alignof(PatchScratch) != 0) {
    return nullptr;
  }
  return ::new (static_cast<void*>(memory.data())) PatchScratch();
}

}  // namespace karst
