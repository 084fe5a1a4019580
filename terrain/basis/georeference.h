// SPDX-License-Identifier: MIT
// Where a world lies on the earth: from places of its frame to longitude, latitude and altitude, to numbers
// of a projected coordinate reference system, and back. On an ellipsoid (basis.h) that follows from the
// basis. A world on a plane knows the coordinates of its origin; what they mean is known where they are
// degrees or a transverse Mercator projection's (all UTM zones are).
#pragma once

#include <cstdint>

#include "terrain/basis/basis.h"

namespace karst::core {

enum class MapProjection : std::uint8_t {
  none,                 // nothing is known of where a plane lies
  degrees,              // its coordinates are longitude and latitude
  transverse_mercator,  // they are a projection's that is known here
  other                 // they are some projection's: not known is where on the ellipsoid
};

struct Georeference {
  MapProjection projection = MapProjection::none;
  std::uint32_t epsg = 0;  // code of the coordinate reference system; 0: not known
  // Coordinates of the frame's origin, and how much they change a metre to the east and to the north.
  double origin[2] = {};
  double per_m[2] = {1, 1};
  // Of the transverse Mercator projection; metres and degrees. The ellipsoid is the basis's.
  double scale = 1;
  double latitude_deg = 0, longitude_deg = 0;  // of its origin
  double false_east_m = 0, false_north_m = 0;
  double unit_m = 1;  // of its coordinates

  bool exists() const { return projection != MapProjection::none; }
};

// Altitudes are metres, as heights of the world are. False: not known. Places are metres in the frame; a
// plane's frame is its world's own metres.
bool to_geodetic(const Basis& basis, const Georeference& earth, glm::dvec3 place_m, Geodetic& out);
bool from_geodetic(const Basis& basis, const Georeference& earth, const Geodetic& geodetic,
                   glm::dvec3& place_m);

// Coordinates of a plane's reference system: x to the east, y to the north, z the height in metres; of a
// cylinder metres along its circle and against its axis. False: it has none.
bool to_projected(const Basis& basis, const Georeference& earth, glm::dvec3 place_m, glm::dvec3& out);
bool from_projected(const Basis& basis, const Georeference& earth, glm::dvec3 projected, glm::dvec3& place_m);

// L. Krueger's series, to the fourth order of the third flattening: within 0.1 mm up to 30 degrees from the
// central meridian. IOGP, Guidance Note 7-2, "Transverse Mercator (JHS formulas)". east, north: in unit_m.
void mercator_from_geodetic(const Basis& ellipsoid, const Georeference& projection, double longitude_deg,
                            double latitude_deg, double& east, double& north);
void geodetic_from_mercator(const Basis& ellipsoid, const Georeference& projection, double east, double north,
                            double& longitude_deg, double& latitude_deg);

}  // namespace karst::core
