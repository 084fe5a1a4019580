// SPDX-License-Identifier: MIT
// What a thousand answers a frame take: of voxels, of a ground on a plane and of one on the ellipsoid.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include <gtest/gtest.h>

#include "ig/answer/answers.h"
#include "ig/cigi/message_reader.h"
#include "tests/ig/test_ground.h"
#include "tests/library/ground_file.h"
#include "tests/support/curved_ground.h"
#include "tests/support/heap_count.h"

namespace karst::ig {
namespace {

constexpr std::uint16_t kRequests = 1000;
constexpr std::uint32_t kFrames = 40;

// Of this thread, whatever else runs.
double thread_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

struct Area {
  Geodetic low, high;

  Geodetic at(TestRandom& random) const {
    const auto mix = [&](double a, double b) { return a + (b - a) * random.unit(); };
    return {mix(low.longitude_deg, high.longitude_deg), mix(low.latitude_deg, high.latitude_deg),
            mix(low.altitude_m, high.altitude_m)};
  }
};

class Thousand : public testing::Test {
 protected:
  // The least of what a frame took of the thread's own time. make: request n of a frame.
  template <class Make>
  double answered_ms(TestGround& ground, Make&& make) {
    std::vector<std::byte> buffer(cigi::kMaxMessageBytes);
    cigi::MessageWriter writer(buffer, {3, 3}, cigi::Order::little);
    Answers answers;
    const Entities entities;
    const Surroundings around{&ground.earth(), &entities, &ground.query(), {6, 5, 2}};
    double best_ms = 1e9;
    for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
      const std::uint64_t heap = test::heap_calls();
      for (std::uint16_t id = 0; id < kRequests; ++id) EXPECT_TRUE(answers.take(make(id), frame));
      writer.clear();
      EXPECT_TRUE(writer.write(cigi::StartOfFrame{}));
      const double start = thread_ms();
      const std::size_t answered = answers.answer(around, frame, 0, INT64_MAX, writer);
      best_ms = std::min(best_ms, thread_ms() - start);
      EXPECT_EQ(answered, std::size_t{kRequests});
      EXPECT_EQ(test::heap_calls(), heap);
    }
    return best_ms;
  }

  void expect_thousands(TestGround& ground, const Area& area, const char* name) {
    TestRandom random{11};
    const double heights_ms = answered_ms(ground, [&](std::uint16_t id) {
      const Geodetic at = area.at(random);
      cigi::HatHotRequest request;
      request.id = id;
      request.type = cigi::HatHotType::extended;
      request.latitude_deg_or_x_m = at.latitude_deg;
      request.longitude_deg_or_y_m = at.longitude_deg;
      request.altitude_m_or_z_m = at.altitude_m;
      return request;
    });
    const double sights_ms = answered_ms(ground, [&](std::uint16_t id) {
      const Geodetic at = area.at(random);
      cigi::LosVectorRequest request;
      request.id = id;
      request.extended = true;
      request.source_latitude_deg_or_x_m = at.latitude_deg;
      request.source_longitude_deg_or_y_m = at.longitude_deg;
      request.source_altitude_m_or_z_m = at.altitude_m;
      request.azimuth_deg = static_cast<float>(360 * random.unit() - 180);
      request.elevation_deg = static_cast<float>(-20 * random.unit());
      request.maximum_range_m = 2000;
      return request;
    });
    std::printf("1,000 of %s: heights %.3f ms, lines of sight %.3f ms\n", name, heights_ms, sights_ms);
  }
};

TEST_F(Thousand, OfVoxels) {
  TestGround ground;
  expect_thousands(ground, {ground.geodetic({1, 0.5, 1}), ground.geodetic({23, 13.5, 23})}, "voxels");
}

TEST_F(Thousand, OfAPlane) {
  TestGround ground(test::ground_file(test::rough_ground(), test::kRoughSpacing_m),
                    Geodetic{8.5, 46.25, 300});
  Area area;
  ground.earth().to_geodetic({500, -100, 3500}, area.low);
  ground.earth().to_geodetic({4500, 300, 500}, area.high);
  expect_thousands(ground, area, "a plane");
}

TEST_F(Thousand, OfTheEllipsoid) {
  const core::GroundInfo shape = test::region(600, 480, 8, 47, 1e-4);
  const test::MemoryGround heights(shape, [&](std::int64_t i, std::int64_t k) {
    const double x = static_cast<double>(i), z = static_cast<double>(k);
    return static_cast<std::int32_t>(
        (60 * std::sin(x * 0.05) * std::sin(z * 0.04) + 2 * std::sin(x * 1.3 + z)) /
        shape.basis.height_unit_m);
  });
  const double spacing_m = shape.basis.height_unit_m / core::kVertexStep * shape.steps[0];
  TestGround ground(test::ground_file(heights, spacing_m), std::nullopt);
  expect_thousands(ground, {{8.005, 46.96, -100}, {8.055, 46.995, 300}}, "the ellipsoid");
}

// What wants more tiles than a frame may read is not answered coarsely: it has its turn again.
TEST_F(Thousand, WhatCannotBeReadNowIsAnsweredLater) {
  TestGround ground(test::ground_file(test::rough_ground(), test::kRoughSpacing_m),
                    Geodetic{8.5, 46.25, 300});
  std::vector<std::byte> buffer(cigi::kMaxMessageBytes);
  cigi::MessageWriter writer(buffer, {3, 3}, cigi::Order::little);
  Answers answers;
  const Entities entities;
  const Surroundings around{&ground.earth(), &entities, &ground.query(), {6, 5, 2}};
  Geodetic at;
  ground.earth().to_geodetic({3000, 200, 2000}, at);
  cigi::HatHotRequest request;
  request.latitude_deg_or_x_m = at.latitude_deg;
  request.longitude_deg_or_y_m = at.longitude_deg;
  request.altitude_m_or_z_m = at.altitude_m;
  ASSERT_TRUE(answers.take(request, 0));
  std::uint32_t frame = 0;
  for (std::size_t answered = 0; answered == 0; ++frame) {
    ASSERT_LT(frame, 20u);
    writer.clear();
    ASSERT_TRUE(writer.write(cigi::StartOfFrame{}));
    ground.query().allow_reads(1);
    answered = answers.answer(around, frame, 0, INT64_MAX, writer);
  }
  EXPECT_GT(frame, 1u);
  cigi::MessageReader reader;
  ASSERT_TRUE(reader.open(writer.bytes(), cigi::Speaker::ig));
  bool found = false;
  for (cigi::Packet packet; reader.next(packet);) {
    const auto* const response = std::get_if<cigi::HatHotResponse>(&packet);
    if (response == nullptr) continue;
    found = response->valid;
    ground.query().allow_reads(0xffffffffu);
    EXPECT_EQ(response->height_m, find_height(request, around).hat_m);
  }
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace karst::ig
