// SPDX-License-Identifier: MIT
// Where the samples of a ground lie in space: on a
// plane, on the ellipsoid by longitude and latitude, on the six faces of a cube around it, on a cylinder, or
// where a caller's function says.
//
// A place is a function of (face, u, v, height), computed in double by plain operations, so that whoever
// computes it gets the same bits. It is in metres in the world's *frame*, which is right-handed: x east, y
// up, z south at its anchor, where its origin lies too; or, of a basis that is `centred`, with the origin in
// the ellipsoid's centre, y to the north pole and z to longitude 0.
//
// Faces. A cube's are laid out on one grid of samples, kCubeCells[0] x kCubeCells[1] cells of face_quads
// quads. Six of them are faces, a cross: four around the equator, from longitude -180 on, and the poles
// beside longitude 0. Cells around them hold copies of what adjoins, for measures and normals alone. Samples
// of an edge of two faces lie in the same place, to the bit. All others have one face, 0.
//
// Longitude and latitude are degrees on the ellipsoid (geodetic), heights metres above it.
#pragma once

#include <cstdint>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "karst/status.h"

namespace karst::core {

enum class BasisKind : std::uint8_t { plane, geographic, cube, cylinder, function };

inline constexpr double kWgs84RadiusM = 6'378'137.0;           // equatorial; EPSG ellipsoid 7030
inline constexpr double kWgs84Flattening = 1 / 298.257223563;  // of the polar one
inline constexpr int kCubeCells[2] = {6, 5};
inline constexpr int kCubeFaces = 6;
inline constexpr std::int32_t kMostFaceQuads = 1 << 19;

// A caller's basis. u, v: of a sample, first + step * index. Both must give the same bits for the same
// numbers, whoever asks, and up unit length.
struct BasisFunction {
  // Null, both: it is not lent yet, and nothing has a place.
  glm::dvec3 (*place)(const void* context, double u, double v, double height_m) = nullptr;
  glm::dvec3 (*up)(const void* context, double u, double v) = nullptr;
  // False: none is near. Null: queries by place are not answered.
  bool (*inverse)(const void* context, glm::dvec3 place_m, double& u, double& v, double& height_m) = nullptr;
  const void* context = nullptr;  // borrowed
  // Limits for any two places at height 0 whose samples differ by at most 1 along both axes: radians
  // between their ups, and metres that the middle of the chord is from the surface.
  double turn_rad = 0;
  double sagitta_m = 0;
};

// A number of a grid axis as places need it.
struct AxisPlace {
  double a = 0;  // sine, tangent, or the number itself
  double b = 0;  // cosine
};

struct GridPlace {
  double i = 0, k = 0;  // samples to the east and to the south of the first one
  double height_m = 0;
  int face = 0;
};

struct Geodetic {
  double longitude_deg = 0;  // -180..180
  double latitude_deg = 0;   // -90..90
  double altitude_m = 0;     // above the ellipsoid
};

struct Basis {
  BasisKind kind = BasisKind::plane;
  // Of sample (0, 0), and from one to the next, to the east and to the south. Geographic: degrees of
  // longitude and latitude, so that step[1] is below 0. Cylinder: metres along the circle at height 0 and
  // along the axis. Function: any. Cube: not used.
  double first[2] = {};
  double step[2] = {};
  // Equatorial, of the ellipsoid. Of the cylinder: up is outwards, or, where it is below 0, inwards.
  double radius_m = kWgs84RadiusM;
  double flattening = kWgs84Flattening;
  bool centred = false;
  double anchor_deg[2] = {};    // longitude and latitude of the frame's origin, at height 0
  std::int32_t face_quads = 0;  // of a cube, along an edge: a power of two, 4..kMostFaceQuads
  double height_unit_m = 1;     // metres of a unit of heights and of vertex_place()
  double base_m = 0;            // height of unit 0
  BasisFunction function;

  // --- Made by finish().
  glm::dmat3 frame_from_earth{1.0};  // axes; earth: x to longitude 0, z to the north pole
  glm::dvec3 anchor_m{0.0};          // earth's
  // Limits, as BasisFunction has them.
  double turn_rad = 0;
  double sagitta_m = 0;
  // Quads that bend by more are not drawn, however far away: what lies on the ground would be lost in them.
  double most_bend_m = 0;
  // Of longitudes and of a cylinder's circle, where a whole number of steps goes once around: how many. So
  // many samples on lies the same place, to the bit. Else 0.
  std::int64_t turn_quads = 0;

  // Checks the fields above and makes those below. invalid_argument naming the field.
  Status finish();

  bool is_curved() const { return kind != BasisKind::plane; }
  bool is_ellipsoid() const { return kind == BasisKind::geographic || kind == BasisKind::cube; }
  double polar_radius_m() const { return radius_m * (1.0 - flattening); }
  double height_m(double height) const { return base_m + height_unit_m * height; }
};

// The face that a cell of the cube's grid is, or -1.
int cube_face(int cell_x, int cell_z);
// The cell of a face.
void cube_cell(int face, int& cell_x, int& cell_z);

// Around a cube. u, v: on a face, from its middle, to the right and down, half to the edge; beyond one edge,
// by at most twice half, they are folded over it onto the face that adjoins, which is then the face. False:
// beyond two edges, where there is nothing.
bool fold_cube(std::int64_t half, int& face, std::int64_t& u, std::int64_t& v);

// The sample of a face that a sample of a cube's grid is, or is a copy of: in a cell beside faces what
// adjoins the nearest of them. Returns the face.
int cube_home(std::int64_t face_quads, std::int64_t& i, std::int64_t& k);

// Of the number of a sample, which may be a fraction and may lie beyond the face. Precondition: not a plane.
AxisPlace axis_place(const Basis& basis, int axis, int face, double index);
// Metres, and unit length.
glm::dvec3 place_m(const Basis& basis, int face, AxisPlace u, AxisPlace v, double height_m);
glm::dvec3 up_at(const Basis& basis, int face, AxisPlace u, AxisPlace v);
inline glm::dvec3 place_m(const Basis& basis, const GridPlace& at) {
  return place_m(basis, at.face, axis_place(basis, 0, at.face, at.i), axis_place(basis, 1, at.face, at.k),
                 at.height_m);
}
inline glm::dvec3 up_at(const Basis& basis, const GridPlace& at) {
  return up_at(basis, at.face, axis_place(basis, 0, at.face, at.i), axis_place(basis, 1, at.face, at.k));
}
// A vertex in units of height_unit_m, rounded once.
glm::i64vec3 vertex_place(const Basis& basis, int face, AxisPlace u, AxisPlace v, double height);

// Where a place lies on the grid: to the nearest of what several turns of a circle give, so it may lie beyond
// the samples. False: it has no such place (in the ellipsoid's centre, on the axis), or there is no inverse.
bool grid_of(const Basis& basis, glm::dvec3 place_m, GridPlace& at);
// Up at any place; the frame's y where it has none.
glm::dvec3 up_of(const Basis& basis, glm::dvec3 place_m);

// East, up and south at any place, as columns: at a pole of the ellipsoid any.
glm::dmat3 axes_of(const Basis& basis, glm::dvec3 place_m);

// Of an ellipsoid; a plane's and others' are not known: false, or the frame's origin.
bool geodetic_of(const Basis& basis, glm::dvec3 place_m, Geodetic& out);
glm::dvec3 place_of(const Basis& basis, const Geodetic& geodetic);

// What is level there, as a quadric: a place p has q = scale (p - centre_m); |q| is 1 at height 0, up is
// along the gradient of |q|, times sign, and so is the height, nearly: exactly on spheres and cylinders.
struct LevelShape {
  glm::dmat3 scale{0.0};  // 1/metres, symmetric
  glm::dvec3 centre_m{0.0};
  double sign = 1;  // -1: up is towards the centre
};
// Of a plane, or where a function says, there is none: false.
bool level_shape(const Basis& basis, LevelShape& shape);

// Metres that a surface through samples 2^size apart may be off the curved one, heights left out: E = sagitta
// 4^size; and radians that up turns over a quad.
inline double bend_m(const Basis& basis, int size) {
  const auto quad = static_cast<double>(std::int64_t{1} << size);
  return basis.sagitta_m * quad * quad;
}
inline double bend_rad(const Basis& basis, int size) {
  return basis.turn_rad * static_cast<double>(std::int64_t{1} << size);
}

}  // namespace karst::core
