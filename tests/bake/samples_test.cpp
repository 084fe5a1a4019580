// SPDX-License-Identifier: MIT
// The procedural samples: the same bits everywhere, and about the shape that their descriptions promise.
#include "bake/samples/samples.h"

#include "bake/samples/noise.h"
#include "bake/voxels/settle_voxels.h"
#include "tests/bake/bake_jobs.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

namespace karst::bake {
namespace {

// FNV-1a (Fowler, Noll, Vo).
struct Hash {
  std::uint64_t value = 0xcbf29ce484222325u;
  void add(std::uint64_t bits) {
    for (int k = 0; k < 8; ++k) value = (value ^ (bits >> (8 * k) & 0xff)) * 0x100000001b3u;
  }
};

struct Voxels {
  WorldGrid grid;
  std::vector<float> values;

  explicit Voxels(const Sample& sample) : grid(grid_around(sample.content_m, sample.voxel_m)) {
    for (int z = 0; z < grid.extent.z; ++z) {
      for (int y = 0; y < grid.extent.y; ++y) {
        for (int x = 0; x < grid.extent.x; ++x) {
          const glm::dvec3 centre(x + 0.5, y + 0.5, z + 0.5);
          values.push_back(static_cast<float>(sample.solid->value_m(grid.to_m(centre))));
        }
      }
    }
    SettleVoxels{grid.extent, values}.run();
  }

  bool filled(int x, int y, int z) const {
    return values[static_cast<std::size_t>((z * grid.extent.y + y) * grid.extent.x + x)] > 0;
  }
  // Columns in which air lies below rock.
  int columns_with_overhang() const {
    int count = 0;
    for (int z = 0; z < grid.extent.z; ++z) {
      for (int x = 0; x < grid.extent.x; ++x) {
        bool air = false, over = false;
        for (int y = 0; y < grid.extent.y; ++y) {
          over = over || (air && filled(x, y, z));
          air = air || !filled(x, y, z);
        }
        count += over ? 1 : 0;
      }
    }
    return count;
  }
  std::uint64_t hash() const {
    Hash hash;
    for (const float v : values) hash.add(v > 0 ? 1 : 0);
    return hash.value;
  }
};

struct Expected {
  const char* name;
  std::uint64_t voxels, field;          // hashes
  int least_overhangs, most_overhangs;  // columns
};

void PrintTo(const Expected& e, std::ostream* out) {
  *out << e.name;
}

class SampleTest : public ::testing::TestWithParam<Expected> {};

void expect_continuous(const Sample& sample) {
  const Box box = sample.content_m;
  double last = 0;
  bool first = true;
  for (double x = box.min.x; x < box.max.x; x += 0.02) {
    const double value = sample.solid->value_m({x, 0.4 * (box.min.y + box.max.y), 0.3 * x});
    // Slopes of the solid's value stay below some 10 for a metre, grain included.
    if (!first) {
      ASSERT_NEAR(value, last, 0.3) << x;
    }
    first = false;
    last = value;
  }
}

// One test a sample: making its table takes most of the time.
TEST_P(SampleTest, IsTheSameBitsEverywhere) {
  const Expected& expected = GetParam();
  const Sample sample = make_sample(expected.name, 2);
  ASSERT_NE(sample.solid, nullptr);
  expect_continuous(sample);
  // Solid below, air above.
  const Box box = sample.content_m;
  for (const double x : {-100.0, 0.0, 77.0}) {
    EXPECT_GT(sample.solid->value_m({x, box.min.y - 3 * sample.voxel_m, 0.6 * x}), 0);
    EXPECT_LT(sample.solid->value_m({x, box.max.y + sample.voxel_m, 0.6 * x}), 0);
  }
  const Voxels voxels(sample);
  EXPECT_EQ(voxels.hash(), expected.voxels) << std::hex << "0x" << voxels.hash();
  EXPECT_GE(voxels.columns_with_overhang(), expected.least_overhangs);
  EXPECT_LE(voxels.columns_with_overhang(), expected.most_overhangs);

  // Along a skewed line through the world, where the grain is.
  Hash hash;
  const glm::dvec3 size = sample.content_m.max - sample.content_m.min;
  for (int k = 0; k < 20'000; ++k) {
    const double t = k / 20'000.0;
    const glm::dvec3 at(t, 7 * t - std::floor(7 * t), 61 * t - std::floor(61 * t));
    hash.add(std::bit_cast<std::uint64_t>(sample.solid->value_m(sample.content_m.min + at * size)));
  }
  EXPECT_EQ(hash.value, expected.field) << std::hex << "0x" << hash.value;
}

INSTANTIATE_TEST_SUITE_P(
    All, SampleTest,
    ::testing::Values(Expected{"canyon", 0xe0eeab22a4c94dc5, 0x6f73d16f3085a5, 20, 300},
                      Expected{"caves", 0x892d7aa9d87db444, 0xcc99cd3c5dd84b6a, 300, 2000},
                      Expected{"arches", 0xf39c90eead7e0f45, 0x67d9196bedaf68d0, 20, 300},
                      Expected{"hills", 0xac27980e5db4a044, 0xd1a13c3b9b20fd90, 0, 0}),
    [](const auto& p) { return std::string(p.param.name); });

TEST(Samples, DoNotDependOnThreads) {
  const Sample one = make_sample("hills", 1), four = make_sample("hills", 4);
  for (int k = 0; k < 500; ++k) {
    const glm::dvec3 p(k * 0.7 - 170, k % 120, 130 - k * 0.5);
    ASSERT_EQ(one.solid->value_m(p), four.solid->value_m(p));
  }
}

TEST(Samples, AreListedAndUnknownNamesAreNull) {
  EXPECT_EQ(sample_names().size(), 4u);
  for (const SampleName& name : sample_names()) EXPECT_FALSE(name.what.empty());
  EXPECT_EQ(make_sample("moon", 1).solid, nullptr);
}

TEST(Noise, StaysInRangeAndIsSmooth) {
  double least = 0, most = 0, last = noise(glm::dvec3(0, 0.3, 0.7), 5);
  for (int k = 1; k < 200'000; ++k) {
    const double value = noise(glm::dvec3(0.003 * k, 0.3 + 0.0007 * k, 0.7), 5);
    ASSERT_NEAR(value, last, 0.012);
    last = value;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  EXPECT_GT(least, -1.0);
  EXPECT_LT(most, 1.0);
  EXPECT_LT(least, -0.6);
  EXPECT_GT(most, 0.6);
  EXPECT_EQ(noise(glm::dvec2(3, -4), 9), 0);
  EXPECT_NE(noise(glm::dvec2(3.5, -4.2), 9), noise(glm::dvec2(3.5, -4.2), 10));
}

TEST(TabulatedSpace, FollowsASmoothFunction) {
  const auto function = [](glm::dvec3 p) { return 0.01 * p.x * p.x - 0.3 * p.y + 0.02 * p.x * p.z; };
  const TabulatedSpace table({{-20, -10, -20}, {20, 10, 20}}, 1, 2, function);
  // Cubic B-splines keep lines and raise a parabola by a sixth of its second difference.
  for (const glm::dvec3& p : {glm::dvec3(0), {3.3, -4.7, 12.1}, {-19.5, 9.5, -19.5}}) {
    EXPECT_NEAR(table.at(p), function(p) + 0.02 / 6, 1e-4);
  }
}

}  // namespace
}  // namespace karst::bake
