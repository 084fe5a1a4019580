// SPDX-License-Identifier: MIT
#include "bake/rasters/ground_size.h"

#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <string_view>
#include <utility>

namespace karst::bake {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMostLatitude = 89;    // degrees; nearer to a pole columns have no width to speak of
constexpr double kStretched = 0.01;     // UTM stays below 0.001: nominal metres are good enough there
constexpr double kTurned = 0.5;         // samples that a row may rise over its length
constexpr double kUneven = 0.1;         // sizes that differ by more within one image are told
constexpr double kFinestDegrees = 0.1;  // without a CRS, what is finer and fits on a globe looks like degrees

// Column and row to coordinates of the CRS, GDAL's six numbers.
using GeoTransform = std::array<double, 6>;

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

struct Point {
  double x, y;
};

Point place(const GeoTransform& t, double column, double row) {
  return {t[0] + column * t[1] + row * t[2], t[3] + column * t[4] + row * t[5]};
}

struct DestroySrs {
  void operator()(void* srs) const { OSRRelease(srs); }
};
using Srs = std::unique_ptr<void, DestroySrs>;

Ellipsoid ellipsoid_of(OGRSpatialReferenceH srs) {
  OGRErr wrong_axis = OGRERR_NONE, wrong_flattening = OGRERR_NONE;
  const double axis = OSRGetSemiMajor(srs, &wrong_axis);
  const double inverse = OSRGetInvFlattening(srs, &wrong_flattening);
  if (wrong_axis != OGRERR_NONE || wrong_flattening != OGRERR_NONE || !(axis > 0) || !(inverse >= 0))
    return {};
  return {axis, inverse == 0 ? 0 : 1 / inverse};
}

// Would the corners of a raster be on a globe, if they were in degrees?
bool fits_a_globe(GDALDatasetH file, const GeoTransform& t) {
  const double width = GDALGetRasterXSize(file), height = GDALGetRasterYSize(file);
  for (const auto& [column, row] : {std::pair{0.0, 0.0}, {width, height}}) {
    const Point p = place(t, column, row);
    if (!(std::abs(p.x) <= 361 && std::abs(p.y) <= 91)) return false;
  }
  return true;
}

// Does one without a CRS have steps that only degrees are made of?
bool looks_like_degrees(GDALDatasetH file, const GeoTransform& t) {
  return fits_a_globe(file, t) &&
         (std::abs(t[1]) < kFinestDegrees || std::abs(t[1]) * GDALGetRasterXSize(file) > 180);
}

// Warns where sizes at two ends of the image are far apart.
void check_evenness(double a, double b, GroundSize& size) {
  const double ratio = std::max(a, b) / std::max(1e-9, std::min(a, b));
  if (ratio <= 1 + kUneven) return;
  size.warnings.push_back(
      "a sample is " + (ratio < 100 ? number(std::round(100 * ratio) / 100) : std::string("100 and more")) +
      " times as wide on the ground at one end of the image as at the other, and drawn as wide as in the "
      "middle; --crop takes a part, gdalwarp -t_srs makes a projection for it");
}

class Sizing {
 public:
  Sizing(const GeoTransform& t, const Window& window, GroundSize& size)
      : t_(t), window_(window), size_(size) {}

  Error in_degrees(double degrees_per_unit, const Ellipsoid& ellipsoid) {
    const double latitude = middle().y * degrees_per_unit;
    if (!(std::abs(latitude) <= kMostLatitude)) {
      return "the latitude of its middle is " + number(latitude) +
             ", not within 89 degrees; use --pixel-size M";
    }
    const DegreeM degree = metres_per_degree(latitude, ellipsoid);
    size_.x_m = std::abs(t_[1]) * degrees_per_unit * degree.x;
    size_.z_m = std::abs(t_[5]) * degrees_per_unit * degree.y;
    const auto width_at = [&](double row) {
      const double y = place(t_, 0, row).y * degrees_per_unit;
      return metres_per_degree(std::clamp(y, -89.999, 89.999), ellipsoid).x;
    };
    check_evenness(width_at(window_.row), width_at(window_.row + window_.height), size_);
    return {};
  }

  Error in_units(double metres) {
    size_.x_m = std::abs(t_[1]) * metres;
    size_.z_m = std::abs(t_[5]) * metres;
    for (const double size : {size_.x_m, size_.z_m}) {
      if (!(size >= kMinSpacingM && size <= kMaxSpacingM))
        return "pixel size: " + number(size) + " m is not in 0.0001 to 1000000 m";
    }
    return {};
  }

  // After in_units: what the projection makes of it. A projection that PROJ cannot undo there is an error.
  Error undo_projection(OGRSpatialReferenceH srs) {
    const Srs projected(OSRClone(srs)), globe(OSRCloneGeogCS(srs));
    if (projected == nullptr || globe == nullptr) return {};
    OSRSetAxisMappingStrategy(projected.get(), OAMS_TRADITIONAL_GIS_ORDER);
    OSRSetAxisMappingStrategy(globe.get(), OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<void, void (*)(OGRCoordinateTransformationH)> to_globe(
        OCTNewCoordinateTransformation(projected.get(), globe.get()), OCTDestroyCoordinateTransformation);
    if (to_globe == nullptr) return "its projection is not known to PROJ; use --pixel-size M";
    const double degrees = OSRGetAngularUnits(globe.get(), nullptr) / kDegree;
    const Ellipsoid ellipsoid = ellipsoid_of(srs);
    // Metres of ground that one sample is wide and high around a place of the raster.
    const auto ground = [&](double column, double row, Point& m, double& latitude) {
      const Point ends[4] = {place(t_, column - 0.5, row), place(t_, column + 0.5, row),
                             place(t_, column, row - 0.5), place(t_, column, row + 0.5)};
      double x[4], y[4];
      for (int k = 0; k < 4; ++k) x[k] = ends[k].x, y[k] = ends[k].y;
      if (OCTTransform(to_globe.get(), 4, x, y, nullptr) == 0) return false;
      latitude = 0.25 * (y[0] + y[1] + y[2] + y[3]) * degrees;
      if (!(std::abs(latitude) < 89.99)) return false;
      const DegreeM degree = metres_per_degree(latitude, ellipsoid);
      const auto distance = [&](int a, int b) {
        const double dx = std::remainder((x[b] - x[a]) * degrees, 360.0) * degree.x;
        return std::hypot(dx, (y[b] - y[a]) * degrees * degree.y);
      };
      m = {distance(0, 1), distance(2, 3)};
      return m.x > 0 && m.y > 0;
    };
    const double column = window_.column + 0.5 * window_.width, row = window_.row + 0.5 * window_.height;
    Point m{};
    double latitude = 0;
    if (!ground(column, row, m, latitude)) {
      return "its middle is nowhere on the globe in its projection; use --pixel-size M";
    }
    Point north{}, south{};
    double ignored = 0;
    if (ground(column, window_.row, north, ignored) &&
        ground(column, window_.row + window_.height, south, ignored)) {
      check_evenness(north.x, south.x, size_);
    }
    if (std::abs(m.x / size_.x_m - 1) <= kStretched && std::abs(m.y / size_.z_m - 1) <= kStretched) return {};
    size_.note = "true size at latitude " + number(std::round(latitude * 100) / 100);
    size_.x_m = m.x;
    size_.z_m = m.y;
    return {};
  }

 private:
  Point middle() const {
    return place(t_, window_.column + 0.5 * window_.width, window_.row + 0.5 * window_.height);
  }

  const GeoTransform& t_;
  const Window& window_;
  GroundSize& size_;
};

}  // namespace

DegreeM metres_per_degree(double latitude_deg, const Ellipsoid& ellipsoid) {
  const double eccentricity2 = ellipsoid.flattening * (2 - ellipsoid.flattening);
  const double s = std::sin(latitude_deg * kDegree);
  const double w = std::sqrt(1 - eccentricity2 * s * s);
  const double prime_vertical_m = ellipsoid.equatorial_radius_m / w;
  const double meridian_m = ellipsoid.equatorial_radius_m * (1 - eccentricity2) / (w * w * w);
  return {prime_vertical_m * std::cos(latitude_deg * kDegree) * kDegree, meridian_m * kDegree};
}

Error Placement::read(GDALDatasetH file) {
  GeoTransform& t = to_crs;
  const GeoTransform none{0, 1, 0, 0, 0, 1};
  placed = GDALGetGeoTransform(file, t.data()) == CE_None && t != none;
  const bool one_is_none = (t[1] == 0 || t[5] == 0) && t[2] == 0 && t[4] == 0;
  if (one_is_none || !std::isfinite(t[1]) || !std::isfinite(t[5])) {
    placed = false;
    t = none;
  }
  // A GeoTIFF with a pixel scale and no tie point: GDAL fills the scale in and calls it no transform.
  sized = placed || t[5] < 0;
  if (!placed) return {};
  const double width = GDALGetRasterXSize(file), height = GDALGetRasterYSize(file);
  const bool straight = std::abs(t[4]) * width <= kTurned * std::abs(t[5]) &&
                        std::abs(t[2]) * height <= kTurned * std::abs(t[1]);
  if (!straight) {
    return "the image is rotated: its rows do not run from west to east; gdalwarp IN OUT makes one that is "
           "not";
  }
  t[2] = t[4] = 0;
  rows_from_south = t[5] > 0;
  columns_from_east = t[1] < 0;
  if (rows_from_south) t[3] += height * std::exchange(t[5], -t[5]);
  if (columns_from_east) t[0] += width * std::exchange(t[1], -t[1]);
  return {};
}

Error Placement::set_bounds(GDALDatasetH file, const std::array<double, 4>& bounds) {
  const auto [west, south, east, north] = bounds;
  if (!(east > west && north > south))
    return "--bounds: west, south, east and north are wanted, in this order";
  to_crs = {west, (east - west) / GDALGetRasterXSize(file),  0, north,
            0,    (south - north) / GDALGetRasterYSize(file)};
  placed = sized = true;
  return {};
}

ElevationEarth earth_of(OGRSpatialReferenceH srs, const Placement& placement) {
  ElevationEarth earth;
  if (srs == nullptr || !placement.placed) return earth;
  const std::array<double, 6>& t = placement.to_crs;
  earth.west = t[0] + 0.5 * t[1];
  earth.north = t[3] + 0.5 * t[5];
  earth.step_x = t[1];
  earth.step_z = -t[5];
  const Ellipsoid ellipsoid = ellipsoid_of(srs);
  earth.radius_m = ellipsoid.equatorial_radius_m;
  earth.flattening = ellipsoid.flattening;
  const char* const authority = OSRGetAuthorityName(srs, nullptr);
  const char* const code = OSRGetAuthorityCode(srs, nullptr);
  if (authority != nullptr && code != nullptr && std::string_view(authority) == "EPSG")
    earth.epsg = static_cast<std::uint32_t>(std::max(0, std::atoi(code)));
  // Longitudes count from Greenwich.
  const double meridian_deg = OSRGetPrimeMeridian(srs, nullptr);
  if (OSRIsGeographic(srs) != 0) {
    const double degrees = OSRGetAngularUnits(srs, nullptr) / kDegree;
    earth.kind = ElevationEarth::Kind::degrees;
    for (double* value : {&earth.west, &earth.north, &earth.step_x, &earth.step_z}) *value *= degrees;
    earth.west += meridian_deg;
    return earth;
  }
  if (OSRIsProjected(srs) == 0) return earth;
  earth.kind = ElevationEarth::Kind::other;
  earth.unit_m = OSRGetLinearUnits(srs, nullptr);
  const char* const projection = OSRGetAttrValue(srs, "PROJECTION", 0);
  if (projection == nullptr || std::string_view(projection) != SRS_PT_TRANSVERSE_MERCATOR) return earth;
  const auto number_of = [&](const char* name, double unknown) {
    return OSRGetNormProjParm(srs, name, unknown, nullptr);
  };
  earth.kind = ElevationEarth::Kind::transverse_mercator;
  earth.scale = number_of(SRS_PP_SCALE_FACTOR, 1);
  earth.latitude_deg = number_of(SRS_PP_LATITUDE_OF_ORIGIN, 0);
  earth.longitude_deg = number_of(SRS_PP_CENTRAL_MERIDIAN, 0) + meridian_deg;
  earth.false_east_m = number_of(SRS_PP_FALSE_EASTING, 0);
  earth.false_north_m = number_of(SRS_PP_FALSE_NORTHING, 0);
  return earth;
}

Error GroundSize::read(GDALDatasetH file, OGRSpatialReferenceH srs, const Placement& placement,
                       const Window& window, double given_m) {
  char* name = nullptr;
  const double metres = srs == nullptr ? 0 : OSRGetLinearUnits(srs, &name);
  in_feet = srs != nullptr && OSRIsGeographic(srs) == 0 && metres > 0.3 && metres < 0.31;
  if (given_m > 0) {
    x_m = z_m = given_m;
    return {};
  }
  const GeoTransform& t = placement.to_crs;
  const bool placed = placement.placed;
  if (!placement.sized) {
    return GDALGetGCPCount(file) > 0
               ? "pixel size: the file has ground control points only; gdalwarp IN OUT makes a grid of it, "
                 "or "
                 "give --pixel-size M"
               : "pixel size: the file does not say how large a sample is; give --pixel-size M";
  }
  Sizing sizing(t, window, *this);
  const GDALDriverH driver = GDALGetDatasetDriver(file);
  const std::string_view kind = driver == nullptr ? "" : GDALGetDriverShortName(driver);
  if (srs == nullptr) {
    const bool is_esri = kind == "EHdr";
    if (placed && looks_like_degrees(file, t)) {
      // ESRI's headers of GTOPO30 and SRTM come without a .prj and mean degrees.
      if (!is_esri) {
        return "pixel size: " + number(std::abs(t[1])) + " x " + number(std::abs(t[5])) +
               " of no coordinate reference system, which looks like degrees; give --pixel-size M in metres, "
               "or "
               "gdal_translate -a_srs EPSG:4326";
      }
      note = "no CRS: degrees assumed";
      return sizing.in_degrees(1, {});
    }
    note = "no CRS: metres assumed";
    if (placed && fits_a_globe(file, t)) {
      warnings.push_back("no coordinate reference system: samples of " + number(std::abs(t[1])) + " x " +
                         number(std::abs(t[5])) +
                         " are taken for metres; if they are degrees, gdal_translate -a_srs EPSG:4326");
    }
    return sizing.in_units(1);
  }
  if (OSRIsGeocentric(srs) != 0) return "geocentric coordinates are no map; use --pixel-size M";
  if (OSRIsGeographic(srs) != 0) {
    if (!placed) return "pixel size: it is in degrees and the file does not say where; use --pixel-size M";
    note = "geographic";
    return sizing.in_degrees(OSRGetAngularUnits(srs, nullptr) / kDegree, ellipsoid_of(srs));
  }
  const std::string_view unit = name == nullptr ? "" : name;
  // GDAL 3.6 takes a GeoTIFF's projection that has neither a code nor parameters for metres, whatever its
  // unit.
  const bool unsure = kind == "GTiff" && OSRIsLocal(srs) != 0 && metres == 1;
  if (unsure || !(metres > 0) || unit == "unknown" || unit == "unnamed") {
    return "pixel size: its coordinate reference system is not known, and so its unit; give --pixel-size M, "
           "or "
           "gdal_translate -a_srs EPSG:CODE";
  }
  if (Error error = sizing.in_units(metres); !error.ok()) return error;
  if (OSRIsProjected(srs) == 0 || !placed) return {};
  return sizing.undo_projection(srs);
}

}  // namespace karst::bake
