// SPDX-License-Identifier: MIT
#include "terrain/basis/georeference.h"

#include <cmath>

namespace karst::core {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;
constexpr int kOrder = 4;

// Of an ellipsoid: the radius of the circle as long as its meridians, and the coefficients of the series.
struct Series {
  double radius_m;
  double to_plane[kOrder], to_ellipsoid[kOrder];
  double e;

  explicit Series(const Basis& ellipsoid) {
    const double f = ellipsoid.flattening;
    const double n = f / (2.0 - f), n2 = n * n, n3 = n2 * n, n4 = n3 * n;
    e = std::sqrt(f * (2.0 - f));
    radius_m = ellipsoid.radius_m / (1.0 + n) * (1.0 + n2 / 4 + n4 / 64);
    to_plane[0] = n / 2 - n2 * 2 / 3 + n3 * 5 / 16 + n4 * 41 / 180;
    to_plane[1] = n2 * 13 / 48 - n3 * 3 / 5 + n4 * 557 / 1440;
    to_plane[2] = n3 * 61 / 240 - n4 * 103 / 140;
    to_plane[3] = n4 * 49'561 / 161'280;
    to_ellipsoid[0] = n / 2 - n2 * 2 / 3 + n3 * 37 / 96 - n4 / 360;
    to_ellipsoid[1] = n2 / 48 + n3 / 15 - n4 * 437 / 1440;
    to_ellipsoid[2] = n3 * 17 / 480 - n4 * 37 / 840;
    to_ellipsoid[3] = n4 * 4397 / 161'280;
  }

  double meridian(double latitude_deg) const {
    double xi = 0, eta = 0;
    project(0.0, latitude_deg / kDegrees, xi, eta);
    return xi;
  }

  // Angles in radians; xi north, eta east, in radii.
  void project(double longitude, double latitude, double& xi, double& eta) const {
    const double s = std::sin(latitude);
    const double conformal = std::asinh(std::tan(latitude)) - e * std::atanh(e * s);
    const double beta = std::atan(std::sinh(conformal));
    const double eta_0 = std::atanh(std::cos(beta) * std::sin(longitude));
    // As asin(sin beta cosh eta), which loses digits near a pole and knows one half of the earth.
    const double xi_0 = std::atan2(std::sin(beta), std::cos(beta) * std::cos(longitude));
    xi = xi_0;
    eta = eta_0;
    for (int k = 0; k < kOrder; ++k) {
      const double turn = 2.0 * (k + 1);
      xi += to_plane[k] * std::sin(turn * xi_0) * std::cosh(turn * eta_0);
      eta += to_plane[k] * std::cos(turn * xi_0) * std::sinh(turn * eta_0);
    }
  }

  void unproject(double xi, double eta, double& longitude, double& latitude) const {
    double xi_0 = xi, eta_0 = eta;
    for (int k = 0; k < kOrder; ++k) {
      const double turn = 2.0 * (k + 1);
      xi_0 -= to_ellipsoid[k] * std::sin(turn * xi) * std::cosh(turn * eta);
      eta_0 -= to_ellipsoid[k] * std::cos(turn * xi) * std::sinh(turn * eta);
    }
    const double beta = std::asin(std::sin(xi_0) / std::cosh(eta_0));
    longitude = std::atan2(std::sinh(eta_0), std::cos(xi_0));
    const double conformal = std::asinh(std::tan(beta));
    double q = conformal;
    for (int n = 0; n < 8; ++n) q = conformal + e * std::atanh(e * std::tanh(q));
    latitude = std::atan(std::sinh(q));
  }
};

// Coordinates of a place on a plane.
void coordinates(const Georeference& earth, glm::dvec3 place_m, double& x, double& y) {
  x = earth.origin[0] + place_m.x * earth.per_m[0];
  y = earth.origin[1] - place_m.z * earth.per_m[1];
}
glm::dvec3 place(const Georeference& earth, double x, double y, double height_m) {
  return {(x - earth.origin[0]) / earth.per_m[0], height_m, (earth.origin[1] - y) / earth.per_m[1]};
}

}  // namespace

void mercator_from_geodetic(const Basis& ellipsoid, const Georeference& projection, double longitude_deg,
                            double latitude_deg, double& east, double& north) {
  const Series series(ellipsoid);
  double xi = 0, eta = 0;
  const double from_middle = std::remainder(longitude_deg - projection.longitude_deg, 360.0);
  series.project(from_middle / kDegrees, latitude_deg / kDegrees, xi, eta);
  const double radius_m = projection.scale * series.radius_m;
  east = (projection.false_east_m + radius_m * eta) / projection.unit_m;
  north = (projection.false_north_m + radius_m * (xi - series.meridian(projection.latitude_deg))) /
          projection.unit_m;
}

void geodetic_from_mercator(const Basis& ellipsoid, const Georeference& projection, double east, double north,
                            double& longitude_deg, double& latitude_deg) {
  const Series series(ellipsoid);
  const double radius_m = projection.scale * series.radius_m;
  const double eta = (east * projection.unit_m - projection.false_east_m) / radius_m;
  const double xi = (north * projection.unit_m - projection.false_north_m) / radius_m +
                    series.meridian(projection.latitude_deg);
  double longitude = 0, latitude = 0;
  series.unproject(xi, eta, longitude, latitude);
  longitude_deg = std::remainder(longitude * kDegrees + projection.longitude_deg, 360.0);
  latitude_deg = latitude * kDegrees;
}

bool to_projected(const Basis& basis, const Georeference& earth, glm::dvec3 place_m, glm::dvec3& out) {
  if (basis.kind == BasisKind::cylinder) {
    GridPlace at;
    if (!grid_of(basis, place_m, at)) return false;
    out = {basis.first[0] + basis.step[0] * at.i, -(basis.first[1] + basis.step[1] * at.k), at.height_m};
    return true;
  }
  if (basis.is_curved() || !earth.exists()) return false;
  coordinates(earth, place_m, out.x, out.y);
  out.z = place_m.y;
  return true;
}

bool from_projected(const Basis& basis, const Georeference& earth, glm::dvec3 projected,
                    glm::dvec3& place_m) {
  if (basis.kind == BasisKind::cylinder) {
    place_m = core::place_m(basis, {(projected.x - basis.first[0]) / basis.step[0],
                                    (-projected.y - basis.first[1]) / basis.step[1], projected.z, 0});
    return true;
  }
  if (basis.is_curved() || !earth.exists()) return false;
  place_m = place(earth, projected.x, projected.y, projected.z);
  return true;
}

bool to_geodetic(const Basis& basis, const Georeference& earth, glm::dvec3 place_m, Geodetic& out) {
  if (basis.is_curved()) return geodetic_of(basis, place_m, out);
  double x = 0, y = 0;
  coordinates(earth, place_m, x, y);
  out.altitude_m = place_m.y;
  switch (earth.projection) {
    case MapProjection::degrees:
      out.longitude_deg = std::remainder(x, 360.0);
      out.latitude_deg = y;
      return true;
    case MapProjection::transverse_mercator:
      geodetic_from_mercator(basis, earth, x, y, out.longitude_deg, out.latitude_deg);
      return true;
    case MapProjection::none:
    case MapProjection::other:
      break;
  }
  return false;
}

bool from_geodetic(const Basis& basis, const Georeference& earth, const Geodetic& geodetic,
                   glm::dvec3& place_m) {
  if (basis.is_ellipsoid()) {
    place_m = place_of(basis, geodetic);
    return true;
  }
  if (basis.is_curved()) return false;
  double x = 0, y = 0;
  switch (earth.projection) {
    case MapProjection::degrees:
      // The turn nearest to the world's origin.
      x = earth.origin[0] + std::remainder(geodetic.longitude_deg - earth.origin[0], 360.0);
      y = geodetic.latitude_deg;
      break;
    case MapProjection::transverse_mercator:
      mercator_from_geodetic(basis, earth, geodetic.longitude_deg, geodetic.latitude_deg, x, y);
      break;
    case MapProjection::none:
    case MapProjection::other:
      return false;
  }
  place_m = place(earth, x, y, geodetic.altitude_m);
  return true;
}

}  // namespace karst::core
