// SPDX-License-Identifier: MIT
#include "terrain/basis/basis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "terrain/base/check.h"
#include "terrain/basis/sin_cos.h"

namespace karst::core {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegrees = 180.0 / kPi;
// The least that a radius may be, in metres, and the greatest: a stone and a star.
constexpr double kLeastRadiusM = 1.0;
constexpr double kMostRadiusM = 1e9;
// Bends that are drawn, in radii: quads over 7 degrees, 12 m of a tube of 6 km.
constexpr double kMostBend = 1.0 / 500;
// Of a cube: what a quad of its grid bends by, beside a step of both its sides along a great circle
// (basis_test measures 0.73).
constexpr double kCubeBend = 0.8;

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

bool inside(double value, double least, double most) {
  return value >= least && value <= most;
}

// Axes of a face in the earth's: right, down and out, each one of +-1..3 for +-x, y, z.
struct FaceAxes {
  int right, down, out;
};
constexpr FaceAxes kFaces[kCubeFaces] = {
    {-2, -3, -1},  // longitude 180
    {1, -3, -2},   // -90
    {2, -3, 1},    // 0
    {-1, -3, 2},   // 90
    {2, 1, 3},     // north pole
    {2, -1, -3},   // south pole
};
constexpr int kFaceCells[kCubeFaces][2] = {{1, 2}, {2, 2}, {3, 2}, {4, 2}, {3, 1}, {3, 3}};

void add_along(glm::dvec3& to, int axis, double value) {
  to[axis < 0 ? -axis - 1 : axis - 1] = axis < 0 ? -value : value;
}
double along(const glm::dvec3& v, int axis) {
  return axis < 0 ? -v[-axis - 1] : v[axis - 1];
}

// Sums in the order of the axes: the same bits whichever face asks.
double length_of(const glm::dvec3& v) {
  return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

// Steps that go once around, or 0.
std::int64_t whole_turn(double steps) {
  constexpr double kMost = 1 << 30;
  if (!(steps >= 1 && steps <= kMost)) return 0;
  const double whole = std::round(steps);
  return std::abs(steps - whole) <= 1e-6 ? static_cast<std::int64_t>(whole) : 0;
}

// The direction whose image under the ellipsoid's axes is the place.
glm::dvec3 cube_direction(int face, AxisPlace u, AxisPlace v) {
  const FaceAxes& axes = kFaces[face];
  glm::dvec3 d(0.0);
  add_along(d, axes.out, 1.0);
  add_along(d, axes.right, u.a);
  add_along(d, axes.down, v.a);
  const double length = length_of(d);
  return {d.x / length, d.y / length, d.z / length};
}

glm::dvec3 cube_up(const Basis& basis, const glm::dvec3& d) {
  const double polar = 1.0 - basis.flattening;
  const glm::dvec3 n(d.x, d.y, d.z / polar);
  const double length = length_of(n);
  return {n.x / length, n.y / length, n.z / length};
}

glm::dvec3 geographic_up(AxisPlace longitude, AxisPlace latitude) {
  return {latitude.b * longitude.b, latitude.b * longitude.a, latitude.a};
}

glm::dvec3 turned(const glm::dmat3& m, const glm::dvec3& v) {
  return {m[0].x * v.x + m[1].x * v.y + m[2].x * v.z, m[0].y * v.x + m[1].y * v.y + m[2].y * v.z,
          m[0].z * v.x + m[1].z * v.y + m[2].z * v.z};
}
glm::dvec3 turned_back(const glm::dmat3& m, const glm::dvec3& v) {
  return {m[0].x * v.x + m[0].y * v.y + m[0].z * v.z, m[1].x * v.x + m[1].y * v.y + m[1].z * v.z,
          m[2].x * v.x + m[2].y * v.y + m[2].z * v.z};
}

glm::dvec3 to_frame(const Basis& basis, const glm::dvec3& earth) {
  return turned(basis.frame_from_earth, earth - basis.anchor_m);
}
glm::dvec3 from_frame(const Basis& basis, const glm::dvec3& frame) {
  return turned_back(basis.frame_from_earth, frame) + basis.anchor_m;
}

glm::dvec3 ellipsoid_place(const Basis& basis, AxisPlace longitude, AxisPlace latitude, double height_m) {
  const double e2 = basis.flattening * (2.0 - basis.flattening);
  const double n = basis.radius_m / std::sqrt(1.0 - e2 * latitude.a * latitude.a);
  const double out = (n + height_m) * latitude.b;
  return {out * longitude.b, out * longitude.a, (n * (1.0 - e2) + height_m) * latitude.a};
}

AxisPlace sine_and_cosine(double degrees) {
  const SinCos at = plain_sin_cos_deg(degrees);
  return {at.sin, at.cos};
}

// H. Bowring, "Transformation from spatial to geographical coordinates", Survey Review 23, 1976: repeated,
// each time what is left falls by e^2 and more.
bool earth_to_geodetic(const Basis& basis, const glm::dvec3& earth, Geodetic& out) {
  const double a = basis.radius_m, b = basis.polar_radius_m();
  const double e2 = basis.flattening * (2.0 - basis.flattening);
  const double p = std::hypot(earth.x, earth.y);
  if (!(std::hypot(p, earth.z) > 0.01 * b)) return false;
  // Sine and cosine of the reduced latitude, but for their length, and then of the latitude itself.
  double z = earth.z, across = p * (1.0 - basis.flattening);
  double s = 0, c = 1;
  for (int n = 0; n < 6; ++n) {
    const double length = std::sqrt(z * z + across * across);
    s = z / length;
    c = across / length;
    s = earth.z + e2 / (1.0 - e2) * b * s * s * s;
    c = p - e2 * a * c * c * c;
    z = (1.0 - basis.flattening) * s;
    across = c;
  }
  const double length = std::sqrt(s * s + c * c);
  out.latitude_deg = std::atan2(s, c) * kDegrees;
  s /= length;
  c /= length;
  out.longitude_deg = p > 0 ? std::atan2(earth.y, earth.x) * kDegrees : 0.0;
  out.altitude_m = p * c + earth.z * s - a * std::sqrt(1.0 - e2 * s * s);
  return std::isfinite(out.altitude_m);
}

}  // namespace

int cube_face(int cell_x, int cell_z) {
  for (int face = 0; face < kCubeFaces; ++face) {
    if (kFaceCells[face][0] == cell_x && kFaceCells[face][1] == cell_z) return face;
  }
  return -1;
}

void cube_cell(int face, int& cell_x, int& cell_z) {
  cell_x = kFaceCells[face][0];
  cell_z = kFaceCells[face][1];
}

bool fold_cube(std::int64_t half, int& face, std::int64_t& u, std::int64_t& v) {
  const bool over_u = u < -half || u > half, over_v = v < -half || v > half;
  if (over_u && over_v) return false;
  if (!over_u && !over_v) return true;
  const FaceAxes& axes = kFaces[face];
  const std::int64_t past = over_u ? u : v;
  const int over_axis = over_u ? axes.right : axes.down;
  // Along the earth's axes: what is past the edge goes down the other face.
  std::int64_t place[3] = {};
  const auto set = [&](int axis, std::int64_t value) {
    place[std::abs(axis) - 1] = axis < 0 ? -value : value;
  };
  set(axes.out, 2 * half - std::abs(past));
  set(over_axis, past < 0 ? -half : half);
  set(over_u ? axes.down : axes.right, over_u ? v : u);
  const int out = past < 0 ? -over_axis : over_axis;
  for (face = 0; kFaces[face].out != out;) ++face;
  const auto part = [&](int axis) {
    return axis < 0 ? -place[std::abs(axis) - 1] : place[std::abs(axis) - 1];
  };
  u = part(kFaces[face].right);
  v = part(kFaces[face].down);
  return true;
}

int cube_home(std::int64_t face_quads, std::int64_t& i, std::int64_t& k) {
  int nearest = 0;
  std::int64_t least = -1, from_u = 0, from_v = 0;
  for (int face = 0; face < kCubeFaces; ++face) {
    const std::int64_t u = 2 * (i - kFaceCells[face][0] * face_quads) - face_quads;
    const std::int64_t v = 2 * (k - kFaceCells[face][1] * face_quads) - face_quads;
    const std::int64_t over = std::max<std::int64_t>(std::abs(u) - face_quads, 0) +
                              std::max<std::int64_t>(std::abs(v) - face_quads, 0);
    if (least >= 0 && over >= least) continue;
    least = over;
    nearest = face;
    from_u = u;
    from_v = v;
  }
  // What is beyond two edges is nothing's copy: on one of them.
  const std::int64_t most = 3 * face_quads;
  from_u = std::clamp(from_u, -most, most);
  from_v = std::clamp(from_v, -most, most);
  if (std::abs(from_u) > face_quads) from_v = std::clamp(from_v, -face_quads, face_quads);
  fold_cube(face_quads, nearest, from_u, from_v);
  i = kFaceCells[nearest][0] * face_quads + (from_u + face_quads) / 2;
  k = kFaceCells[nearest][1] * face_quads + (from_v + face_quads) / 2;
  return nearest;
}

Status Basis::finish() {
  if (!std::isfinite(height_unit_m) || !(height_unit_m > 0)) return refuse("not above 0", "height_unit_m");
  if (!inside(base_m, -1e12, 1e12)) return refuse("not within +-1e12 metres", "base_m");
  frame_from_earth = glm::dmat3(1.0);
  anchor_m = glm::dvec3(0.0);
  turn_rad = sagitta_m = 0;
  turn_quads = 0;
  most_bend_m = std::numeric_limits<double>::infinity();
  if (kind == BasisKind::plane) return {};
  if (kind == BasisKind::function) {
    if ((function.place == nullptr) != (function.up == nullptr)) return refuse("missing", "function");
    if (!inside(first[0], -1e9, 1e9) || !inside(first[1], -1e9, 1e9) || !inside(step[0], 1e-6, 1e9) ||
        !inside(step[1], 1e-6, 1e9))
      return refuse("its numbers are not within 1e9", "first");
    if (!inside(function.turn_rad, 0, 10) || !inside(function.sagitta_m, 0, 1e12))
      return refuse("its limits are not known", "function");
    turn_rad = function.turn_rad;
    sagitta_m = function.sagitta_m;
    return {};
  }
  if (!inside(std::abs(radius_m), kLeastRadiusM, kMostRadiusM))
    return refuse("not within 1..1e9 metres", "radius_m");
  if (kind == BasisKind::cylinder) {
    for (const double number : {first[0], first[1], step[0], step[1]}) {
      if (!inside(number, -1e9, 1e9)) return refuse("not within +-1e9 metres", "first");
    }
    turn_rad = step[0] / std::abs(radius_m);
    sagitta_m = step[0] * turn_rad / 8;
    turn_quads = whole_turn(2 * kPi * std::abs(radius_m) / step[0]);
    most_bend_m = kMostBend * std::abs(radius_m);
    return {};
  }
  if (!(radius_m > 0)) return refuse("an ellipsoid's is above 0", "radius_m");
  if (!inside(flattening, 0, 0.1)) return refuse("not within 0..0.1", "flattening");
  most_bend_m = kMostBend * radius_m;
  // The greatest radius of curvature, at the poles.
  const double most_radius_m = radius_m / (1.0 - flattening);
  if (kind == BasisKind::geographic) {
    if (!inside(first[0], -540, 540) || !inside(step[0], 1e-9, 90))
      return refuse("longitudes are not within +-540 degrees, from west to east", "first");
    if (!inside(first[1], -90, 90) || !inside(step[1], -90, -1e-9))
      return refuse("latitudes are not within +-90 degrees, from north to south", "first");
    turn_rad = (step[0] - step[1]) / kDegrees * (1.0 + 2 * flattening);
    sagitta_m = most_radius_m * turn_rad * turn_rad / 8;
    turn_quads = whole_turn(360.0 / step[0]);
  } else {
    if (!inside(face_quads, 4, kMostFaceQuads) || (face_quads & (face_quads - 1)) != 0)
      return refuse("not a power of two within 4..2^19", "face_quads");
    turn_rad = kPi / face_quads * (1.0 + 2 * flattening);
    sagitta_m = kCubeBend * most_radius_m * turn_rad * turn_rad / 8;
  }
  if (centred) {
    // East, north pole and longitude 0 are y, z and x of the earth.
    frame_from_earth = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
    return {};
  }
  if (!inside(anchor_deg[0], -540, 540) || !inside(anchor_deg[1], -90, 90))
    return refuse("no longitude and latitude", "anchor_deg");
  const AxisPlace longitude = sine_and_cosine(anchor_deg[0]), latitude = sine_and_cosine(anchor_deg[1]);
  anchor_m = ellipsoid_place(*this, longitude, latitude, 0.0);
  const glm::dvec3 east(-longitude.a, longitude.b, 0.0);
  const glm::dvec3 up = geographic_up(longitude, latitude);
  const glm::dvec3 south(latitude.a * longitude.b, latitude.a * longitude.a, -latitude.b);
  for (int axis = 0; axis < 3; ++axis) frame_from_earth[axis] = {east[axis], up[axis], south[axis]};
  return {};
}

AxisPlace axis_place(const Basis& basis, int axis, int face, double index) {
  const auto turn = static_cast<double>(basis.turn_quads);
  if (axis == 0 && turn > 0 && !(index >= 0 && index < turn)) index -= turn * std::floor(index / turn);
  switch (basis.kind) {
    case BasisKind::geographic: {
      const double degrees = basis.first[axis] + basis.step[axis] * index;
      return sine_and_cosine(axis == 0 ? degrees : std::clamp(degrees, -90.0, 90.0));
    }
    case BasisKind::cube: {
      const double share = (index - static_cast<double>(kFaceCells[face][axis]) * basis.face_quads) /
                           basis.face_quads;  // exact
      const double degrees = 90.0 * share - 45.0;
      if (std::abs(degrees) == 45.0) return {degrees < 0 ? -1.0 : 1.0, 0.0};
      const SinCos at = plain_sin_cos_deg(degrees);
      return {at.sin / at.cos, 0.0};
    }
    case BasisKind::cylinder: {
      const double metres = basis.first[axis] + basis.step[axis] * index;
      if (axis == 1) return {metres, 0.0};
      return sine_and_cosine(metres / basis.radius_m * kDegrees);
    }
    case BasisKind::plane:
    case BasisKind::function:
      break;
  }
  return {basis.first[axis] + basis.step[axis] * index, 0.0};
}

glm::dvec3 place_m(const Basis& basis, int face, AxisPlace u, AxisPlace v, double height_m) {
  switch (basis.kind) {
    case BasisKind::geographic:
      return to_frame(basis, ellipsoid_place(basis, u, v, height_m));
    case BasisKind::cube: {
      const glm::dvec3 d = cube_direction(face, u, v);
      const glm::dvec3 up = cube_up(basis, d);
      const double polar = basis.polar_radius_m();
      return to_frame(basis, {basis.radius_m * d.x + height_m * up.x, basis.radius_m * d.y + height_m * up.y,
                              polar * d.z + height_m * up.z});
    }
    case BasisKind::cylinder: {
      const double out = basis.radius_m + height_m;
      return {out * u.a, out * u.b - basis.radius_m, v.a};
    }
    case BasisKind::function:
      return basis.function.place(basis.function.context, u.a, v.a, height_m);
    case BasisKind::plane:
      break;
  }
  return {u.a, height_m, v.a};
}

glm::dvec3 up_at(const Basis& basis, int face, AxisPlace u, AxisPlace v) {
  switch (basis.kind) {
    case BasisKind::geographic:
      return turned(basis.frame_from_earth, geographic_up(u, v));
    case BasisKind::cube:
      return turned(basis.frame_from_earth, cube_up(basis, cube_direction(face, u, v)));
    case BasisKind::cylinder:
      return {u.a, u.b, 0.0};
    case BasisKind::function:
      return basis.function.up(basis.function.context, u.a, v.a);
    case BasisKind::plane:
      break;
  }
  return {0.0, 1.0, 0.0};
}

glm::i64vec3 vertex_place(const Basis& basis, int face, AxisPlace u, AxisPlace v, double height) {
  const glm::dvec3 metres = place_m(basis, face, u, v, basis.height_m(height));
  glm::i64vec3 units;
  for (int axis = 0; axis < 3; ++axis)
    units[axis] = static_cast<std::int64_t>(std::floor(metres[axis] / basis.height_unit_m + 0.5));
  return units;
}

bool grid_of(const Basis& basis, glm::dvec3 place, GridPlace& at) {
  at = {};
  switch (basis.kind) {
    case BasisKind::geographic: {
      Geodetic g;
      if (!geodetic_of(basis, place, g)) return false;
      // The turn in which the longitude lies east of the first one, or just before it.
      double east = std::remainder(g.longitude_deg - basis.first[0], 360.0);
      if (east < -1e-9) east += 360.0;
      at = {east / basis.step[0], (g.latitude_deg - basis.first[1]) / basis.step[1], g.altitude_m, 0};
      return true;
    }
    case BasisKind::cube: {
      Geodetic g;
      if (!geodetic_of(basis, place, g)) return false;
      const glm::dvec3 up = geographic_up(sine_and_cosine(g.longitude_deg), sine_and_cosine(g.latitude_deg));
      // The direction whose up that is.
      const glm::dvec3 d(up.x, up.y, up.z * (1.0 - basis.flattening));
      for (int face = 1; face < kCubeFaces; ++face) {
        if (along(d, kFaces[face].out) > along(d, kFaces[at.face].out)) at.face = face;
      }
      const FaceAxes& axes = kFaces[at.face];
      const double out = along(d, axes.out);
      const auto index = [&](int axis, double part) {
        const double share = (std::atan(part / out) * kDegrees + 45.0) / 90.0;
        return (kFaceCells[at.face][axis] + share) * basis.face_quads;
      };
      at.i = index(0, along(d, axes.right));
      at.k = index(1, along(d, axes.down));
      at.height_m = g.altitude_m;
      return true;
    }
    case BasisKind::cylinder: {
      const double y = place.y + basis.radius_m;
      const double out = std::hypot(place.x, y);
      if (!(out > 0)) return false;
      const double sign = basis.radius_m < 0 ? -1.0 : 1.0;
      const double angle = std::atan2(sign * place.x, sign * y);
      double metres = angle * basis.radius_m - basis.first[0];
      const double around = 2 * kPi * std::abs(basis.radius_m);
      metres = std::remainder(metres, around);
      if (metres < -1e-9) metres += around;
      at = {metres / basis.step[0], (place.z - basis.first[1]) / basis.step[1], sign * out - basis.radius_m,
            0};
      return true;
    }
    case BasisKind::function: {
      double u = 0, v = 0;
      if (basis.function.inverse == nullptr ||
          !basis.function.inverse(basis.function.context, place, u, v, at.height_m))
        return false;
      at.i = (u - basis.first[0]) / basis.step[0];
      at.k = (v - basis.first[1]) / basis.step[1];
      return true;
    }
    case BasisKind::plane:
      break;
  }
  return false;
}

glm::dvec3 up_of(const Basis& basis, glm::dvec3 place) {
  GridPlace at;
  return grid_of(basis, place, at) ? up_at(basis, at) : glm::dvec3(0.0, 1.0, 0.0);
}

glm::dmat3 axes_of(const Basis& basis, glm::dvec3 place) {
  if (!basis.is_curved()) return glm::dmat3(1.0);
  const glm::dvec3 up = up_of(basis, place);
  // North is the pole's direction, or along the axis.
  const glm::dvec3 pole = basis.is_ellipsoid() ? basis.frame_from_earth[2] : glm::dvec3(0.0, 0.0, -1.0);
  glm::dvec3 east = glm::cross(pole, up);
  if (!(glm::length(east) > 1e-9)) east = glm::cross(glm::dvec3(0.0, 0.0, 1.0), up);
  if (!(glm::length(east) > 1e-9)) east = glm::dvec3(1.0, 0.0, 0.0);
  east = glm::normalize(east);
  return {east, up, glm::cross(east, up)};
}

bool level_shape(const Basis& basis, LevelShape& shape) {
  shape = {};
  if (basis.kind == BasisKind::cylinder) {
    const double radius = std::abs(basis.radius_m);
    shape.scale[0][0] = shape.scale[1][1] = 1.0 / radius;
    shape.centre_m = {0.0, -basis.radius_m, 0.0};
    shape.sign = basis.radius_m < 0 ? -1.0 : 1.0;
    return true;
  }
  if (!basis.is_ellipsoid()) return false;
  glm::dmat3 in_earth(1.0 / basis.radius_m);
  in_earth[2][2] = 1.0 / basis.polar_radius_m();
  shape.scale = basis.frame_from_earth * in_earth * glm::transpose(basis.frame_from_earth);
  shape.centre_m = to_frame(basis, glm::dvec3(0.0));
  return true;
}

bool geodetic_of(const Basis& basis, glm::dvec3 place, Geodetic& out) {
  return basis.is_ellipsoid() && earth_to_geodetic(basis, from_frame(basis, place), out);
}

glm::dvec3 place_of(const Basis& basis, const Geodetic& geodetic) {
  if (!basis.is_ellipsoid()) return glm::dvec3(0.0);
  return to_frame(basis, ellipsoid_place(basis, sine_and_cosine(geodetic.longitude_deg),
                                         sine_and_cosine(geodetic.latitude_deg), geodetic.altitude_m));
}

}  // namespace karst::core
