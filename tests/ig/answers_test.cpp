// SPDX-License-Identifier: MIT
// Heights and lines of sight that a host is answered, against all triangles one by one in double.
#include <gtest/gtest.h>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "ig/answer/answers.h"
#include "ig/cigi/message_reader.h"
#include "tests/ig/test_ground.h"

namespace karst::ig {
namespace {

constexpr double kStep = 1.0 / 8192;  // voxels a lattice step

class AnswersTest : public testing::Test {
 protected:
  Surroundings around() { return {&ground_.earth(), &entities_, &ground_.query(), {6, 5, 2}}; }
  static constexpr double voxel() { return kVoxel_m; }
  glm::dvec3 random_place() {
    return {1 + 22 * random_.unit(), 0.5 + 13 * random_.unit(), 1 + 22 * random_.unit()};
  }
  cigi::HatHotRequest height_request(glm::dvec3 voxels) const {
    const Geodetic at = ground_.geodetic(voxels);
    cigi::HatHotRequest request;
    request.type = cigi::HatHotType::extended;
    request.latitude_deg_or_x_m = at.latitude_deg;
    request.longitude_deg_or_y_m = at.longitude_deg;
    request.altitude_m_or_z_m = at.altitude_m;
    return request;
  }

  TestGround ground_;
  AllTriangles soup_;
  Entities entities_;
  TestRandom random_{11};
};

// The highest surface below the point that faces up; where there is none, the lowest above it.
TEST_F(AnswersTest, HeightsAreThoseOfAllTriangles) {
  int caves = 0;
  int under = 0;
  for (int n = 0; n < 400; ++n) {
    const glm::dvec3 at = random_place();
    const AllTriangles::Crossing* found = nullptr;
    const std::vector<AllTriangles::Crossing> column = soup_.column(at.x, at.z);
    for (const AllTriangles::Crossing& crossing : column) {  // from the top
      if (crossing.normal.y <= 0) continue;
      if (found == nullptr || found->at > at.y) found = &crossing;
    }
    const cigi::HatHotExtendedResponse response = find_height(height_request(at), around());
    ASSERT_EQ(response.valid, found != nullptr) << at.x << " " << at.y << " " << at.z;
    if (found == nullptr) continue;
    if (found != &column[0] && found->at <= at.y) ++caves;
    if (found->at > at.y) ++under;
    EXPECT_NEAR(response.hat_m, (at.y - found->at) * voxel(), kStep * voxel());
    const double hot = ground_.geodetic({at.x, found->at, at.z}).altitude_m;
    EXPECT_NEAR(response.hot_m, hot, kStep * voxel());
    EXPECT_NEAR(response.normal_elevation_deg, glm::degrees(std::asin(found->normal.y)), 0.01);
  }
  EXPECT_GT(caves, 10);
  EXPECT_GT(under, 0);
}

TEST_F(AnswersTest, SegmentsAndVectorsMeetWhatAllTrianglesSay) {
  int hits = 0;
  int free = 0;
  for (int n = 0; n < 60; ++n) {
    const glm::dvec3 from = random_place(), to = random_place();
    const AllTriangles::Crossing met = soup_.ray(from, to);
    const Geodetic one = ground_.geodetic(from), other = ground_.geodetic(to);
    cigi::LosSegmentRequest segment;
    segment.source_latitude_deg_or_x_m = one.latitude_deg;
    segment.source_longitude_deg_or_y_m = one.longitude_deg;
    segment.source_altitude_m_or_z_m = one.altitude_m;
    segment.destination_latitude_deg_or_x_m = other.latitude_deg;
    segment.destination_longitude_deg_or_y_m = other.longitude_deg;
    segment.destination_altitude_m_or_z_m = other.altitude_m;
    const cigi::LosExtendedResponse sight = find_sight(segment, around());
    ASSERT_EQ(sight.valid, met.found);
    EXPECT_EQ(sight.visible, !met.found);
    // The same as a vector from one end: with angles of 32 bits, so that grazing ones differ.
    const glm::dvec3 way = glm::normalize(to - from);
    cigi::LosVectorRequest vector;
    vector.source_latitude_deg_or_x_m = one.latitude_deg;
    vector.source_longitude_deg_or_y_m = one.longitude_deg;
    vector.source_altitude_m_or_z_m = one.altitude_m;
    vector.azimuth_deg = static_cast<float>(glm::degrees(std::atan2(way.x, -way.z)));
    vector.elevation_deg = static_cast<float>(glm::degrees(std::asin(way.y)));
    vector.maximum_range_m = static_cast<float>(glm::length(to - from) * voxel());
    const double azimuth = glm::radians(double{vector.azimuth_deg});
    const double elevation = glm::radians(double{vector.elevation_deg});
    const glm::dvec3 rounded(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                             -std::cos(azimuth) * std::cos(elevation));
    const AllTriangles::Crossing along =
        soup_.ray(from, from + rounded * (double{vector.maximum_range_m} / voxel()));
    const cigi::LosExtendedResponse seen = find_sight(vector, around());
    ASSERT_EQ(seen.valid, along.found);
    if (seen.valid) {
      EXPECT_NEAR(seen.range_m, along.at * voxel(), kStep * voxel());
    }
    if (!met.found) {
      ++free;
      continue;
    }
    ++hits;
    EXPECT_NEAR(sight.range_m, met.at * voxel(), kStep * voxel());
    const Geodetic place = ground_.geodetic(from + way * met.at);
    EXPECT_NEAR(sight.altitude_m_or_z_m, place.altitude_m, kStep * voxel());
    EXPECT_NEAR(sight.latitude_deg_or_x_m, place.latitude_deg, kStep * voxel() / 111'000);
  }
  EXPECT_GT(hits, 10);
  EXPECT_GT(free, 10);
}

TEST_F(AnswersTest, EntitiesAreMetUnlessTheSightBeginsAtThem) {
  const Geodetic at = ground_.geodetic({12, 40, 12});
  cigi::EntityControl control;
  control.entity = 7;
  control.type = 1;
  control.state = cigi::EntityState::active;
  cigi::EntityPosition position;
  position.entity = 7;
  position.latitude_deg_or_x_m = at.latitude_deg;
  position.longitude_deg_or_y_m = at.longitude_deg;
  position.altitude_m_or_z_m = at.altitude_m;
  position.yaw_deg = 90;  // its length lies from west to east
  ASSERT_TRUE(entities_.take(control) && entities_.take(position, 0));
  entities_.advance(ground_.earth(), ground_.query(), 0);
  const Geodetic source = ground_.geodetic({12, 40, 62});  // 100 m to the south
  cigi::LosVectorRequest request;
  request.extended = true;
  request.source_latitude_deg_or_x_m = source.latitude_deg;
  request.source_longitude_deg_or_y_m = source.longitude_deg;
  request.source_altitude_m_or_z_m = source.altitude_m;
  request.maximum_range_m = 500;
  request.response = cigi::CoordinateSystem::entity;
  cigi::LosExtendedResponse seen = find_sight(request, around());
  ASSERT_TRUE(seen.valid && seen.entity_valid);
  EXPECT_EQ(seen.entity, 7);
  EXPECT_NEAR(seen.range_m, 95, 1e-6);
  EXPECT_NEAR(seen.longitude_deg_or_y_m, 5, 1e-6);  // its right side
  EXPECT_NEAR(std::fabs(seen.normal_azimuth_deg), 180, 1e-4);
  // Through it, from its own middle.
  request.source = cigi::CoordinateSystem::entity;
  request.entity = 7;
  request.source_latitude_deg_or_x_m = request.source_longitude_deg_or_y_m =
      request.source_altitude_m_or_z_m = 0;
  EXPECT_FALSE(find_sight(request, around()).valid);
  // Straight down along its own z: the ground.
  request.elevation_deg = -90;
  seen = find_sight(request, around());
  EXPECT_TRUE(seen.valid);
  EXPECT_FALSE(seen.entity_valid);
}

// What is not extended says of the same answer what was asked for.
TEST_F(AnswersTest, PlainAnswersAreThoseOfExtendedOnes) {
  std::vector<std::byte> buffer(cigi::kMaxMessageBytes);
  cigi::MessageWriter writer(buffer, {3, 3}, cigi::Order::little);
  Answers answers;
  cigi::HatHotRequest height = height_request({12, 12, 12});
  const cigi::HatHotExtendedResponse found = find_height(height, around());
  ASSERT_TRUE(found.valid);
  ASSERT_GT(std::fabs(found.hat_m - found.hot_m), 1);
  for (const cigi::HatHotType type : {cigi::HatHotType::hat, cigi::HatHotType::hot}) {
    height.type = type;
    height.id = static_cast<std::uint16_t>(type);
    ASSERT_TRUE(answers.take(height, 1));
  }
  cigi::LosVectorRequest sight;
  sight.id = 9;
  sight.source_latitude_deg_or_x_m = height.latitude_deg_or_x_m;
  sight.source_longitude_deg_or_y_m = height.longitude_deg_or_y_m;
  sight.source_altitude_m_or_z_m = height.altitude_m_or_z_m;
  sight.elevation_deg = -90;
  sight.maximum_range_m = 500;
  const cigi::LosExtendedResponse seen = find_sight(sight, around());
  ASSERT_TRUE(seen.valid);
  ASSERT_TRUE(answers.take(sight, 1));
  ASSERT_TRUE(writer.write(cigi::StartOfFrame{}));
  EXPECT_EQ(answers.answer(around(), 1, 0x25, INT64_MAX, writer), 3u);
  cigi::MessageReader reader;
  ASSERT_TRUE(reader.open(writer.bytes(), cigi::Speaker::ig));
  int count = 0;
  for (cigi::Packet packet; reader.next(packet);) {
    if (const auto* height_m = std::get_if<cigi::HatHotResponse>(&packet)) {
      const bool hat = height_m->type == cigi::HatHotType::hat;
      EXPECT_EQ(height_m->height_m, hat ? found.hat_m : found.hot_m);
      EXPECT_EQ(height_m->id, static_cast<std::uint16_t>(height_m->type));
      EXPECT_TRUE(height_m->valid);
      ++count;
    } else if (const auto* range = std::get_if<cigi::LosResponse>(&packet)) {
      EXPECT_EQ(range->id, 9);
      EXPECT_EQ(range->range_m, seen.range_m);
      EXPECT_EQ(range->visible, seen.visible);
      ++count;
    }
  }
  EXPECT_EQ(count, 3);
}

TEST_F(AnswersTest, PeriodicRequestsComeAgainAndAllHaveTheirTurn) {
  std::vector<std::byte> buffer(cigi::kMaxMessageBytes);
  cigi::MessageWriter writer(buffer, {3, 3}, cigi::Order::little);
  Answers answers;
  cigi::HatHotRequest request = height_request({12, 12, 12});
  request.update_period = 3;
  request.id = 1;
  ASSERT_TRUE(answers.take(request, 10));
  request.update_period = 0;
  for (std::uint16_t id = 2; id < 1202; ++id) {
    request.id = id;
    ASSERT_TRUE(answers.take(request, 10));
  }
  std::vector<int> seen(1202, 0);
  std::vector<std::uint32_t> first;
  for (std::uint32_t frame = 10; frame < 20; ++frame) {
    writer.clear();
    ASSERT_TRUE(writer.write(cigi::StartOfFrame{}));
    // No time is left from the first on: 16 a frame, or all.
    const std::int64_t until = frame < 14 ? 0 : INT64_MAX;
    answers.answer(around(), frame, 0x25, until, writer);
    cigi::MessageReader reader;
    ASSERT_TRUE(reader.open(writer.bytes(), cigi::Speaker::ig));
    cigi::Packet packet;
    while (reader.next(packet)) {
      if (const auto* found = std::get_if<cigi::HatHotExtendedResponse>(&packet)) {
        ++seen[found->id];
        EXPECT_EQ(found->host_frame_low, 5);
        if (found->id == 1) first.push_back(frame);
      }
    }
  }
  for (std::uint16_t id = 2; id < 1202; ++id) ASSERT_EQ(seen[id], 1) << id;
  EXPECT_EQ(first.front(), 10u);
  EXPECT_GE(first.size(), 2u);
  EXPECT_EQ(answers.waiting(), 1u);
  request.id = 1;  // once now, and then no more
  ASSERT_TRUE(answers.take(request, 20));
  writer.clear();
  ASSERT_TRUE(writer.write(cigi::StartOfFrame{}));
  EXPECT_EQ(answers.answer(around(), 20, 0, INT64_MAX, writer), 1u);
  EXPECT_EQ(answers.waiting(), 0u);
}

}  // namespace
}  // namespace karst::ig
