// SPDX-License-Identifier: MIT
#include "bake/imagery/cube_way.h"

#include <ogr_srs_api.h>

#include <cmath>
#include <cstring>

namespace karst::bake {
using namespace core;
namespace {

// GDAL's: texels of the window to pixels; the other way is not asked for.
int transform(void* of, int to_source, int count, double* x, double* y, double*, int* good) {
  const auto& way = *static_cast<const CubeWay*>(of);
  int all = TRUE;
  for (int n = 0; n < count; ++n) {
    good[n] = to_source != FALSE &&
              way.pixel_of(way.face, way.column + x[n] * way.texel, way.row + y[n] * way.texel, x[n], y[n]);
    if (good[n] == 0) {
      x[n] = y[n] = HUGE_VAL;
      all = FALSE;
    }
  }
  return all;
}

void keep(void*) {}

}  // namespace

void CubeWay::open(const Basis& cube, void* pixels_to_degrees, GDALDatasetH file) {
  basis = cube;
  inner = pixels_to_degrees;
  std::memcpy(head.abySignature, GDAL_GTI2_SIGNATURE, sizeof head.abySignature);
  head.pszClassName = "karst cube";
  head.pfnTransform = transform;
  head.pfnCleanup = keep;
  width_px = GDALGetRasterXSize(file);
  double to_geo[6];
  OGRSpatialReferenceH const system = GDALGetSpatialRef(file);
  const bool degrees = system != nullptr && OSRIsGeographic(system) != FALSE;
  if (degrees && GDALGetGeoTransform(file, to_geo) == CE_None && to_geo[1] > 0 && to_geo[2] == 0)
    turn_px = 360 / to_geo[1];
}

bool CubeWay::pixel_of(int of_face, double i, double k, double& x, double& y) const {
  const AxisPlace u = axis_place(basis, 0, of_face, i), v = axis_place(basis, 1, of_face, k);
  Geodetic at;
  if (!geodetic_of(basis, place_m(basis, of_face, u, v, 0), at)) return false;
  x = at.longitude_deg;
  y = at.latitude_deg;
  double z = 0;
  int good = 0;
  if (GDALGenImgProjTransform(inner, TRUE, 1, &x, &y, &z, &good) == FALSE || good == 0) return false;
  // Images may begin at another longitude than -180.
  if (turn_px > 0 && (x < 0 || x > width_px)) {
    const double moved = x - turn_px * std::floor(x / turn_px);
    if (moved <= width_px) x = moved;
  }
  return true;
}

bool CubeWay::sample_of(double x, double y, GridPlace& at) const {
  double z = 0;
  int good = 0;
  if (GDALGenImgProjTransform(inner, FALSE, 1, &x, &y, &z, &good) == FALSE || good == 0) return false;
  return std::abs(y) <= 90 && grid_of(basis, place_of(basis, {x, y, 0}), at);
}

}  // namespace karst::bake
