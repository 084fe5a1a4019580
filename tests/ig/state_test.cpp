// SPDX-License-Identifier: MIT
// What a host says: places, the sun, entities, views, air.
#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include "ig/link/udp_link.h"
#include "ig/place/sun_place.h"
#include "ig/state/air.h"
#include "ig/state/views.h"
#include "tests/ig/test_ground.h"

namespace karst::ig {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

void expect_near(glm::dvec3 a, glm::dvec3 b, double within) {
  EXPECT_LT(glm::length(a - b), within)
      << a.x << " " << a.y << " " << a.z << " and " << b.x << " " << b.y << " " << b.z;
}

TEST(Addresses, AreOfThisMachineUnlessTheySayOtherwise) {
  UdpAddress address;
  EXPECT_TRUE(parse_address("8004", "--listen", address).ok() && is_loopback(address));
  EXPECT_TRUE(parse_address("127.3.4.5:8004", "--listen", address).ok() && is_loopback(address));
  EXPECT_TRUE(parse_address("[::1]:8004", "--listen", address).ok() && is_loopback(address));
  EXPECT_TRUE(parse_address("0.0.0.0:8004", "--listen", address).ok() && !is_loopback(address));
  EXPECT_TRUE(parse_address("[::]:8004", "--listen", address).ok() && !is_loopback(address));
  for (const char* bad : {"", "0", "65536", "a:1", "1.2.3:4", "[1]:3", "8004:", "1.2.3.4"})
    EXPECT_FALSE(parse_address(bad, "--listen", address).ok()) << bad;
}

TEST(Layouts, AreRowsOfViews) {
  ViewLayout layout;
  ASSERT_TRUE(parse_view_layout("4,5/6", "--views", layout).ok());
  EXPECT_EQ(layout.count, 3u);
  EXPECT_EQ(layout.rows, 2);
  EXPECT_EQ(layout.ids[2], 6);
  EXPECT_EQ(layout.columns[0], 2);
  EXPECT_EQ(layout.columns[2], 1);
  EXPECT_EQ(layout.row[2], 1);
  for (const char* bad : {"", ",", "1,", "1,1", "1/", "70000", "0,1,2,3/4,5,6,7,8"})
    EXPECT_FALSE(parse_view_layout(bad, "--views", layout).ok()) << bad;
}

// Meeus, "Astronomical Algorithms", example 25.a: 13 October 1992, 0 h TD: right ascension 198.38 degrees,
// declination -7.785; and, of example 7.a, a day's number.
TEST(SunPlaces, AgreeWithTheLiterature) {
  EXPECT_EQ(days_of(2000, 1, 1, 43'200), 0);
  EXPECT_EQ(days_of(1957, 10, 4, 0.81 * 86'400) + 2'451'545, 2'436'116.31);
  const double days = days_of(1992, 10, 13, 0);
  EXPECT_EQ(days, 2'448'908.5 - 2'451'545);
  // At the pole the elevation is the declination.
  EXPECT_NEAR(sun_place(days, 90, 0).elevation_deg, -7.785, 0.01);
  // Greenwich's sidereal time (20.5 degrees then) less the right ascension is the hour angle.
  const double sidereal = std::remainder(280.46061837 + 360.98564736629 * days, 360.0);
  const SunPlace equator = sun_place(days, 0, 198.38 - sidereal);
  EXPECT_NEAR(equator.elevation_deg, 90 - 7.785, 0.02);
  EXPECT_NEAR(equator.azimuth_deg, 180, 0.1);
  // Before noon it stands in the east.
  EXPECT_LT(sun_place(days_of(2026, 6, 21, 8 * 3600), 46, 8).azimuth_deg, 180);
  EXPECT_GT(sun_place(days_of(2026, 6, 21, 16 * 3600), 46, 8).azimuth_deg, 180);
}

TEST(Attitudes, TurnYawThenPitchThenRoll) {
  const glm::dmat3 ned(1.0);
  expect_near(turned(ned, 90, 0, 0)[0], {0, 1, 0}, 1e-15);   // faces east
  expect_near(turned(ned, 0, 90, 0)[0], {0, 0, -1}, 1e-15);  // faces up
  expect_near(turned(ned, 0, 0, 90)[1], {0, 0, 1}, 1e-15);   // right wing down
  const glm::dmat3 all = turned(ned, 90, 30, 0);
  expect_near(all[0], {0, std::cos(glm::radians(30.0)), -0.5}, 1e-15);
  EXPECT_NEAR(glm::determinant(turned(ned, 10, 20, 30)), 1, 1e-12);
}

class State : public testing::Test {
 protected:
  void add(std::uint16_t id, glm::dvec3 voxels, float yaw_deg = 0, std::int64_t now = 0) {
    const Geodetic at = ground_.geodetic(voxels);
    cigi::EntityPosition position;
    position.entity = id;
    position.yaw_deg = yaw_deg;
    position.latitude_deg_or_x_m = at.latitude_deg;
    position.longitude_deg_or_y_m = at.longitude_deg;
    position.altitude_m_or_z_m = at.altitude_m;
    control(id, cigi::EntityState::active);
    ASSERT_TRUE(entities_.take(position, now));
  }
  void attach(std::uint16_t id, std::uint16_t parent, glm::dvec3 offset) {
    cigi::EntityPosition position;
    position.entity = id;
    position.attached = true;
    position.parent = parent;
    position.latitude_deg_or_x_m = offset.x;
    position.longitude_deg_or_y_m = offset.y;
    position.altitude_m_or_z_m = offset.z;
    control(id, cigi::EntityState::active);
    ASSERT_TRUE(entities_.take(position, 0));
  }
  void control(std::uint16_t id, cigi::EntityState state) {
    cigi::EntityControl packet;
    packet.entity = id;
    packet.type = 3;
    packet.state = state;
    ASSERT_TRUE(entities_.take(packet));
  }
  void advance(std::int64_t now) { entities_.advance(ground_.earth(), ground_.query(), now); }

  TestGround ground_;
  Entities entities_;
};

TEST_F(State, PlacesGoToTheEarthAndBack) {
  for (const glm::dvec3 at : {glm::dvec3(0, 0, 0), glm::dvec3(24, 14, 3), glm::dvec3(-500, 90, 700)}) {
    glm::dvec3 back;
    ASSERT_TRUE(ground_.earth().to_world(ground_.geodetic(at), back));
    expect_near(back, ground_.place_of(at), 1e-6);
  }
  // A minute of latitude is a nautical mile, nearly; the world's middle is the anchor.
  glm::dvec3 middle, north, east;
  ASSERT_TRUE(ground_.earth().to_world({8.5, 46.25, 300}, middle));
  expect_near(middle, {0, 0, 0}, 1e-9);
  ASSERT_TRUE(ground_.earth().to_world({8.5, 46.25 + 1.0 / 60, 300}, north));
  EXPECT_NEAR(-north.z, 1852.5, 1.5);
  ASSERT_TRUE(ground_.earth().to_world({8.5 + 1.0 / 60, 46.25, 300}, east));
  EXPECT_NEAR(east.x, 1855.32 * std::cos(glm::radians(46.25)), 3);
}

TEST_F(State, EntitiesMoveAndCarryOthers) {
  add(1, {12, 20, 12}, 90);
  attach(2, 1, {10, 3, -1});
  attach(3, 2, {1, 0, 0});
  advance(0);
  const glm::dvec3 first = ground_.place_of({12, 20, 12});
  expect_near(entities_.find(1)->body.place, first, 1e-6);
  // Forward is east, right is south, down is down.
  expect_near(entities_.find(2)->body.place, first + glm::dvec3(10, 1, 3), 1e-6);
  expect_near(entities_.find(3)->body.place, first + glm::dvec3(11, 1, 3), 1e-6);
  EXPECT_TRUE(entities_.find(3)->is_seen);
  cigi::RateControl rate;
  rate.entity = 1;
  rate.local = true;
  rate.x_m_s = 20;
  rate.yaw_deg_s = 10;
  entities_.take(rate, ground_.earth(), kSecond);
  advance(3 * kSecond);
  expect_near(entities_.find(1)->body.place, first + glm::dvec3(40, 0, 0), 1e-5);
  expect_near(entities_.find(1)->body.axes[0],
              {std::sin(glm::radians(110.0)), 0, -std::cos(glm::radians(110.0))}, 1e-6);
  // Another rate goes on from there: 40 m/s to the north, from 3 s on.
  rate = {};
  rate.entity = 1;
  rate.x_m_s = 40;
  entities_.take(rate, ground_.earth(), 3 * kSecond);
  advance(4 * kSecond);
  expect_near(entities_.find(1)->body.place, first + glm::dvec3(40, 0, -40), 1e-4);
  // A new position begins anew.
  add(1, {12, 20, 12}, 0, 10 * kSecond);
  advance(10 * kSecond);
  expect_near(entities_.find(1)->body.place, first, 1e-6);
}

TEST_F(State, WhatIsDestroyedTakesWhatItCarriesWithIt) {
  add(1, {12, 20, 12});
  attach(2, 1, {});
  attach(3, 2, {});
  add(4, {3, 20, 3});
  control(1, cigi::EntityState::destroyed);
  EXPECT_EQ(entities_.all().size(), 1u);
  EXPECT_EQ(entities_.find(3), nullptr);
  ASSERT_NE(entities_.find(4), nullptr);
  // Rings and missing parents are nowhere, and no end is waited for.
  attach(5, 6, {});
  attach(6, 5, {});
  attach(7, 7, {});
  attach(8, 99, {});
  advance(0);
  for (const std::uint16_t id : std::initializer_list<std::uint16_t>{5, 6, 7, 8})
    EXPECT_FALSE(entities_.find(id)->is_placed) << id;
  EXPECT_TRUE(entities_.find(4)->is_placed);
  // Long chains end.
  for (std::uint16_t id = 100; id < 200; ++id) attach(id, static_cast<std::uint16_t>(id + 1), {});
  add(200, {12, 20, 12});
  advance(1);
  EXPECT_FALSE(entities_.find(100)->is_placed && entities_.find(100)->visit == 0);
}

TEST_F(State, AThousandEntitiesAndNoMore) {
  for (std::size_t id = 1; id <= Entities::kMost; ++id) {
    cigi::EntityControl packet;
    packet.entity = static_cast<std::uint16_t>(id);
    ASSERT_TRUE(entities_.take(packet));
  }
  cigi::EntityControl packet;
  packet.entity = 60'000;
  EXPECT_FALSE(entities_.take(packet));
  control(5, cigi::EntityState::destroyed);
  EXPECT_TRUE(entities_.take(packet));
}

TEST_F(State, ClampedEntitiesStandOnTheGround) {
  const Geodetic at = ground_.geodetic({5, 60, 5});
  cigi::EntityPosition position;
  position.entity = 1;
  position.clamp = cigi::Clamp::altitude_and_attitude;
  position.latitude_deg_or_x_m = at.latitude_deg;
  position.longitude_deg_or_y_m = at.longitude_deg;
  position.altitude_m_or_z_m = 1.5;
  control(1, cigi::EntityState::active);
  ASSERT_TRUE(entities_.take(position, 0));
  advance(0);
  const glm::dvec3 place = ground_.place_of({5, 60, 5});
  Hit hit;
  ASSERT_TRUE(ground_.query().ground({place.x, place.y, place.z}, 0, Wait::for_file, hit));
  const Body& body = entities_.find(1)->body;
  EXPECT_NEAR(body.place.y, hit.place.y + 1.5, 1e-6);
  expect_near(-body.axes[2], {hit.normal.x, hit.normal.y, hit.normal.z}, 1e-6);
  EXPECT_NEAR(glm::determinant(body.axes), 1, 1e-9);
}

TEST_F(State, HazeIsOfTheThickestAirThatTheEyeIsIn) {
  HostAir air;
  Sun sun;
  const glm::dvec3 eye = ground_.place_of({12, 20, 12});
  Geodetic here = ground_.geodetic({12, 20, 12});
  air.light(ground_.earth(), eye, 0, sun);
  EXPECT_EQ(sun.visibility_m, 0);
  cigi::AtmosphereControl atmosphere;
  atmosphere.visibility_m = 9000;
  air.take(atmosphere);
  cigi::WeatherControl fog;
  fog.enabled = true;
  fog.visibility_m = 200;
  fog.base_elevation_m = static_cast<float>(here.altitude_m - 10);
  fog.thickness_m = 5;
  EXPECT_TRUE(air.take(fog));
  air.light(ground_.earth(), eye, 0, sun);
  EXPECT_EQ(sun.visibility_m, 9000);
  fog.thickness_m = 50;
  EXPECT_TRUE(air.take(fog));
  air.light(ground_.earth(), eye, 0, sun);
  EXPECT_EQ(sun.visibility_m, 200);
  fog.layer = 2;  // a cloud
  EXPECT_FALSE(air.take(fog));
}

TEST_F(State, TheSunStandsWhereTheDateSays) {
  HostAir air;
  cigi::CelestialSphereControl sphere;
  sphere.sun = sphere.date_time_valid = sphere.ephemeris = true;
  sphere.hour = 9;
  sphere.date_mmddyyyy = 6'212'026;
  air.take(sphere, 0);
  const glm::dvec3 eye = ground_.place_of({12, 20, 12});
  const Geodetic here = ground_.geodetic({12, 20, 12});
  for (const int hours : {0, 2}) {
    Sun sun;
    air.light(ground_.earth(), eye, hours * 3600 * kSecond, sun);
    const SunPlace place =
        sun_place(days_of(2026, 6, 21, (9 + hours) * 3600.0), here.latitude_deg, here.longitude_deg);
    EXPECT_NEAR(glm::degrees(std::asin(sun.towards.y)), place.elevation_deg, 1e-6);
    EXPECT_NEAR(glm::degrees(std::atan2(sun.towards.x, -sun.towards.z)),
                std::remainder(place.azimuth_deg, 360.0), 1e-6);
  }
}

}  // namespace
}  // namespace karst::ig
