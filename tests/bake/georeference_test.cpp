// SPDX-License-Identifier: MIT
// What files say of where they lie, against what GDAL makes of the same coordinates.
#include "bake/ground/ground_basis.h"
#include "tests/bake/bake_files.h"

#include <gdal.h>
#include <gdal_frmts.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

namespace karst::bake {
namespace {

constexpr int kWide = 5, kDeep = 4;

struct Release {
  void operator()(void* srs) const { OSRRelease(srs); }
};
using Srs = std::unique_ptr<void, Release>;

Srs srs_of(int epsg) {
  Srs srs(OSRNewSpatialReference(nullptr));
  EXPECT_EQ(OSRImportFromEPSG(srs.get(), epsg), OGRERR_NONE);
  OSRSetAxisMappingStrategy(srs.get(), OAMS_TRADITIONAL_GIS_ORDER);
  return srs;
}

// epsg 0: without a coordinate reference system or a place.
void write_tiff(const std::string& path, int epsg, double west, double north, double step) {
  GDALRegister_GTiff();
  const GDALDatasetH file =
      GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), kWide, kDeep, 1, GDT_Int16, nullptr);
  ASSERT_NE(file, nullptr);
  if (epsg != 0) {
    double place[6] = {west, step, 0, north, 0, -step};
    EXPECT_EQ(GDALSetGeoTransform(file, place), CE_None);
    EXPECT_EQ(GDALSetSpatialRef(file, srs_of(epsg).get()), CE_None);
  }
  std::vector<std::int16_t> heights(kWide * kDeep, 100);
  EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(file, 1), GF_Write, 0, 0, kWide, kDeep, heights.data(), kWide,
                         kDeep, GDT_Int16, 0, 0),
            CE_None);
  GDALClose(file);
}

struct Case {
  const char* name;
  int epsg;
  double west, north, step;
  double pixel_m = 0;  // for those whose size is not told
};

TEST(Georeference, PlacesAreThoseOfGdal) {
  const Case cases[] = {{"UTM 11N", 32611, 380'000, 3'800'000, 30},
                        {"UTM 33S", 32733, 210'000, 6'200'000, 10},
                        {"UTM 60N, high", 32660, 480'000, 9'000'000, 100},
                        {"UTM 32N of ETRS89, far from its middle", 25832, 900'000, 5'400'000, 20},
                        {"British National Grid", 27700, 577'000, 69'000, 50},
                        {"Gauss-Krueger 4", 31468, 4'468'000, 5'333'000, 25}};
  for (const Case& c : cases) {
    const std::string path = testing::TempDir() + "georeference.tif";
    write_tiff(path, c.epsg, c.west, c.north, c.step);
    ReadElevation read;
    read.path = path;
    Elevation facts;
    const Error error = read.run(facts);
    ASSERT_TRUE(error.ok()) << error.text();
    const Georeference earth = plane_earth(facts, kWide, kDeep);
    ASSERT_EQ(earth.projection, MapProjection::transverse_mercator) << c.name;
    EXPECT_EQ(earth.epsg, static_cast<std::uint32_t>(c.epsg));
    Basis plane;
    plane.radius_m = facts.earth.radius_m;
    plane.flattening = facts.earth.flattening;
    const Srs srs = srs_of(c.epsg);
    const Srs globe(OSRCloneGeogCS(srs.get()));
    OSRSetAxisMappingStrategy(globe.get(), OAMS_TRADITIONAL_GIS_ORDER);
    const OGRCoordinateTransformationH to_globe = OCTNewCoordinateTransformation(srs.get(), globe.get());
    ASSERT_NE(to_globe, nullptr);
    double most_m = 0;
    for (int k = 0; k < kDeep; ++k) {
      for (int i = 0; i < kWide; ++i) {
        // Middles of samples, from the world's middle.
        const glm::dvec3 place((i - 0.5 * (kWide - 1)) * c.step, 0, (k - 0.5 * (kDeep - 1)) * c.step);
        double x = c.west + (i + 0.5) * c.step, y = c.north - (k + 0.5) * c.step;
        glm::dvec3 projected;
        ASSERT_TRUE(to_projected(plane, earth, place, projected));
        EXPECT_NEAR(projected.x, x, 1e-6);
        EXPECT_NEAR(projected.y, y, 1e-6);
        ASSERT_NE(OCTTransform(to_globe, 1, &x, &y, nullptr), 0);
        Geodetic own;
        ASSERT_TRUE(to_geodetic(plane, earth, place, own));
        most_m = std::max({most_m, std::abs(own.latitude_deg - y) * 111'000,
                           std::abs(own.longitude_deg - x) * 111'000 * std::cos(y * 0.0174532925)});
        glm::dvec3 back;
        ASSERT_TRUE(from_geodetic(plane, earth, {x, y, 0}, back));
        EXPECT_NEAR(back.x, place.x, 1e-3);
        EXPECT_NEAR(back.z, place.z, 1e-3);
      }
    }
    OCTDestroyCoordinateTransformation(to_globe);
    EXPECT_LT(most_m, 1e-3) << c.name;
    std::printf("FIGURE %s: off GDAL by %.2g m\n", c.name, most_m);
  }
}

TEST(Georeference, OtherProjectionsKnowTheirCoordinatesAlone) {
  const std::string path = testing::TempDir() + "georeference_mercator.tif";
  write_tiff(path, 3857, 1'000'000, 6'000'000, 100);
  ReadElevation read;
  read.path = path;
  Elevation facts;
  ASSERT_TRUE(read.run(facts).ok());
  const Georeference earth = plane_earth(facts, kWide, kDeep);
  EXPECT_EQ(earth.projection, MapProjection::other);
  // A sample's true size is less than its coordinates say.
  glm::dvec3 projected;
  ASSERT_TRUE(to_projected(Basis(), earth, {facts.spacing_x_m, 7, 0}, projected));
  EXPECT_NEAR(projected.x, 1'000'000 + 3.5 * 100, 1e-6);
  EXPECT_EQ(projected.z, 7);
}

TEST(Georeference, BoundsAndCrsPlaceFilesThatHaveNone) {
  const std::string path = testing::TempDir() + "georeference_none.tif";
  write_tiff(path, 0, 0, 0, 1);
  ReadElevation read;
  read.path = path;
  read.crs = "EPSG:4326";
  read.bounds = {7, 46, 7.5, 46.4};
  Elevation facts;
  const Error error = read.run(facts);
  ASSERT_TRUE(error.ok()) << error.text();
  EXPECT_EQ(facts.earth.kind, ElevationEarth::Kind::degrees);
  EXPECT_NEAR(facts.earth.west, 7.05, 1e-12);
  EXPECT_NEAR(facts.earth.north, 46.35, 1e-12);
  EXPECT_NEAR(facts.earth.step_x, 0.1, 1e-12);
  EXPECT_NEAR(facts.earth.step_z, 0.1, 1e-12);
  EXPECT_NEAR(facts.spacing_z_m, 11'115, 5);
  read.bounds = {7, 46.4, 7.5, 46};
  EXPECT_NE(read.run(facts).text().find("--bounds: west, south, east and north"), std::string::npos);
  read.bounds = {7, 46, 7.5, 46.4};
  read.crs = "EPSG:1";
  EXPECT_NE(read.run(facts).text().find("not known to PROJ"), std::string::npos);
}

}  // namespace
}  // namespace karst::bake
