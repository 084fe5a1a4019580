// SPDX-License-Identifier: MIT
#include "terrain/basis/georeference.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

namespace karst::core {
namespace {

Georeference utm(int zone) {
  Georeference earth;
  earth.projection = MapProjection::transverse_mercator;
  earth.scale = 0.9996;
  earth.longitude_deg = 6 * zone - 183;
  earth.false_east_m = 500'000;
  return earth;
}

// IOGP Guidance Note 7-2, Transverse Mercator: the worked example of OSGB 1936 / British National Grid, on
// Airy 1830.
TEST(Georeference, TransverseMercatorIsThatOfTheIogpExample) {
  Basis airy;
  airy.radius_m = 6'377'563.396;
  airy.flattening = 1 / 299.32496;
  Georeference grid;
  grid.projection = MapProjection::transverse_mercator;
  grid.scale = 0.9996012717;
  grid.latitude_deg = 49;
  grid.longitude_deg = -2;
  grid.false_east_m = 400'000;
  grid.false_north_m = -100'000;
  double east = 0, north = 0;
  mercator_from_geodetic(airy, grid, 0.5, 50.5, east, north);
  EXPECT_NEAR(east, 577'274.99, 0.01);
  EXPECT_NEAR(north, 69'740.50, 0.01);
  double longitude = 0, latitude = 0;
  geodetic_from_mercator(airy, grid, east, north, longitude, latitude);
  EXPECT_NEAR(longitude, 0.5, 1e-11);
  EXPECT_NEAR(latitude, 50.5, 1e-11);
}

TEST(Georeference, ProjectedPlacesComeBackWithinAMicrometre) {
  const Basis wgs84;
  double most = 0;
  for (int zone = 1; zone <= 60; ++zone) {
    const Georeference earth = utm(zone);
    for (double latitude = -80; latitude <= 84; latitude += 4) {
      for (double from_middle = -6; from_middle <= 6; from_middle += 1.5) {
        double east = 0, north = 0, back_east = 0, back_north = 0, longitude = 0, back = 0;
        mercator_from_geodetic(wgs84, earth, earth.longitude_deg + from_middle, latitude, east, north);
        geodetic_from_mercator(wgs84, earth, east, north, longitude, back);
        mercator_from_geodetic(wgs84, earth, longitude, back, back_east, back_north);
        most = std::max({most, std::abs(back_east - east), std::abs(back_north - north)});
        EXPECT_NEAR(back, latitude, 1e-10);
      }
    }
  }
  EXPECT_LT(most, 1e-6);
  std::printf("FIGURE UTM: round trips within %.2g m\n", most);
}

TEST(Georeference, APlaneKnowsItsCoordinates) {
  const Basis plane;
  Georeference earth = utm(11);
  earth.origin[0] = 400'000;
  earth.origin[1] = 3'800'000;
  glm::dvec3 projected, place;
  ASSERT_TRUE(to_projected(plane, earth, {100, 50, -200}, projected));
  EXPECT_EQ(projected, glm::dvec3(400'100, 3'800'200, 50));
  ASSERT_TRUE(from_projected(plane, earth, projected, place));
  EXPECT_EQ(place, glm::dvec3(100, 50, -200));
  Geodetic geodetic;
  ASSERT_TRUE(to_geodetic(plane, earth, {100, 50, -200}, geodetic));
  ASSERT_TRUE(from_geodetic(plane, earth, geodetic, place));
  EXPECT_NEAR(place.x, 100, 1e-6);
  EXPECT_NEAR(place.z, -200, 1e-6);
  EXPECT_EQ(geodetic.altitude_m, 50);
}

TEST(Georeference, WhatIsNotKnownIsNotAnswered) {
  const Basis plane;
  Georeference none, other;
  other.projection = MapProjection::other;
  glm::dvec3 out;
  Geodetic geodetic;
  EXPECT_FALSE(to_projected(plane, none, {}, out));
  EXPECT_FALSE(to_geodetic(plane, none, {}, geodetic));
  EXPECT_TRUE(to_projected(plane, other, {}, out));
  EXPECT_FALSE(to_geodetic(plane, other, {}, geodetic));
  EXPECT_FALSE(from_geodetic(plane, other, {}, out));
}

}  // namespace
}  // namespace karst::core
