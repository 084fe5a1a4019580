// SPDX-License-Identifier: MIT
// Dabs on fields against what they mean at every sample; taken back and done again to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/isosurface/extract_block.h"
#include "terrain/isosurface/measure_cells.h"
#include "terrain/isosurface/sculpt_field.h"

namespace karst::core {
namespace {

struct OwnField {
  OwnField(int bits, std::uint32_t stored, glm::ivec3 blocks = glm::ivec3(4))
      : table(static_cast<std::size_t>(blocks.x * blocks.y * blocks.z)),
        samples(FieldBlocks::kBlockBytes * stored * static_cast<std::size_t>(bits / 8)) {
    field.create({table, samples});
    FieldInfo info;
    info.blocks = blocks;
    info.sample_bits = bits;
    info.stored = std::min(stored, static_cast<std::uint32_t>(table.size()));
    EXPECT_TRUE(field.reset(info).ok());
  }
  int at(glm::ivec3 s) const {
    return field.with([&](const auto& f) { return f.at(s); });
  }
  std::uint32_t free() const {
    return field.with([](const auto& f) { return f.free_blocks(); });
  }
  std::vector<int> all() const {
    std::vector<int> out;
    const glm::ivec3 n = field.info().blocks * 16;
    for (int z = 0; z < n.z; ++z) {
      for (int y = 0; y < n.y; ++y) {
        for (int x = 0; x < n.x; ++x) out.push_back(at({x, y, z}));
      }
    }
    return out;
  }
  std::vector<std::uint32_t> table;
  std::vector<std::byte> samples;
  FieldBlocks field;
};

double value_of(int stored, int bits) {
  return (stored + 0.5) / (bits == 16 ? 16'384 : 64);  // cells, at a reach of 2
}

TEST(SculptField, DabsAreWhatTheyMeanAtEverySample) {
  for (const int bits : {8, 16}) {
    OwnField own(bits, 64);
    FieldChange change;
    const glm::dvec3 ball(30.3, 31.8, 29.1), hole(34.9, 30.2, 33.3);
    ASSERT_TRUE(sculpt_field({FieldDab::Tool::add, ball, 9.5}, own.field, {}, change).ok());
    EXPECT_GT(change.kept_bytes, 0u);
    ASSERT_TRUE(sculpt_field({FieldDab::Tool::subtract, hole, 6}, own.field, {}, change).ok());
    double most = 0;
    for (int z = 0; z < 64; ++z) {
      for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
          const glm::dvec3 p(x, y, z);
          const double d = std::max(glm::length(p - ball) - 9.5, 6 - glm::length(p - hole));
          const double off = std::abs(value_of(own.at({x, y, z}), bits) - std::clamp(d, -2.0, 2.0));
          most = std::max(most, off);
        }
      }
    }
    EXPECT_LE(most, bits == 16 ? 3.1e-5 : 0.0079);  // half a step
  }
}

TEST(SculptField, ASlopeDrawsTheSurfaceToItsPlane) {
  OwnField own(16, 64);
  FieldChange change;
  ASSERT_TRUE(sculpt_field({FieldDab::Tool::add, {32, 8, 32}, 24}, own.field, {}, change).ok());
  FieldDab dab{FieldDab::Tool::slope, {32, 31, 32}, 8, 1, glm::normalize(glm::dvec3(1, 2, 0))};
  const std::vector<int> before = own.all();
  ASSERT_TRUE(sculpt_field(dab, own.field, {}, change).ok());
  // In the middle it is the plane, outside of the ball all is as it was.
  EXPECT_NEAR(value_of(own.at({32, 31, 32}), 16), 0, 1e-4);
  std::size_t n = 0;
  int changed = 0;
  for (int z = 0; z < 64; ++z) {
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x, ++n) {
        const bool inside = glm::length(glm::dvec3(x, y, z) - dab.place) < 8;
        changed += own.at({x, y, z}) != before[n];
        if (!inside) {
          EXPECT_EQ(own.at({x, y, z}), before[n]);
        }
      }
    }
  }
  EXPECT_GT(changed, 100);
  // Of no strength it changes nothing.
  const std::vector<int> sloped = own.all();
  dab.strength = 0;
  ASSERT_TRUE(sculpt_field(dab, own.field, {}, change).ok());
  EXPECT_EQ(own.all(), sloped);
}

TEST(SculptField, IsTakenBackAndDoneAgainToTheBit) {
  for (const int bits : {8, 16}) {
    std::mt19937 random(static_cast<unsigned>(bits));
    const auto next = [&](double low, double high) {
      return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
    };
    OwnField own(bits, 40);
    std::vector<std::vector<int>> states{own.all()};
    std::vector<std::vector<std::byte>> kept;
    std::vector<std::uint32_t> free{own.free()};
    int refused = 0;
    for (int n = 0; n < 60; ++n) {
      FieldDab dab;
      dab.tool = static_cast<FieldDab::Tool>(random() % 3);
      if (n == 0) dab.tool = FieldDab::Tool::add;
      dab.place = {next(-4, 68), next(-4, 68), next(-4, 68)};
      dab.radius = next(1, 20);
      dab.strength = next(0, 1);
      std::vector<std::byte> room(64 * (8 + 2 * FieldBlocks::kBlockBytes));
      FieldChange change;
      const Status status = sculpt_field(dab, own.field, room, change);
      if (!status.ok()) {
        EXPECT_STREQ(status.field(), "field_sample_blocks");
        EXPECT_EQ(own.all(), states.back());
        ++refused;
        continue;
      }
      room.resize(change.kept_bytes);
      kept.push_back(room);
      states.push_back(own.all());
      free.push_back(own.free());
    }
    EXPECT_GT(refused, 0);
    ASSERT_GT(kept.size(), 20u);
    FieldChange change;
    for (std::size_t n = kept.size(); n-- > 0;) {
      swap_field(own.field, kept[n], change);
      ASSERT_EQ(own.all(), states[n]) << n;
      ASSERT_EQ(own.free(), free[n]) << n;
    }
    for (std::size_t n = 0; n < kept.size(); ++n) {
      swap_field(own.field, kept[n], change);
      ASSERT_EQ(own.all(), states[n + 1]) << n;
      ASSERT_EQ(own.free(), free[n + 1]) << n;
    }
  }
}

TEST(SculptField, SaysWhatIsWrongAndChangesNothing) {
  OwnField own(8, 1);
  FieldChange change;
  const auto field_of = [&](FieldDab dab) {
    return std::string(sculpt_field(dab, own.field, {}, change).field());
  };
  FieldDab dab;
  dab.place = {32, 32, 32};
  EXPECT_EQ(field_of(dab), "field_sample_blocks");
  EXPECT_EQ(own.free(), 1u);
  dab.radius = 0;
  EXPECT_EQ(field_of(dab), "radius");
  dab.radius = std::nan("");
  EXPECT_EQ(field_of(dab), "radius");
  dab.radius = 2;
  dab.strength = 2;
  EXPECT_EQ(field_of(dab), "strength");
  dab.strength = 1;
  dab.up = {0, 2, 0};
  EXPECT_EQ(field_of(dab), "up");
  dab.up = {0, 1, 0};
  dab.place.y = std::nan("");
  EXPECT_EQ(field_of(dab), "place");
  dab.place = {8, 8, 8};
  std::byte little[100];
  const Status status = sculpt_field(dab, own.field, little, change);
  EXPECT_STREQ(status.field(), "kept");
  EXPECT_EQ(status.value(), 8 + 4096u);
  // Far from the field nothing happens.
  dab.place = {-500, 0, 0};
  EXPECT_TRUE(sculpt_field(dab, own.field, {}, change).ok());
  EXPECT_FALSE(change.any());
}

// Time of a dab of radius 4 with the meshes of all blocks that it reaches, for the record.
TEST(SculptField, ADabAndItsMeshes) {
  OwnField own(8, 512, glm::ivec3(8));
  FieldChange change;
  ASSERT_TRUE(sculpt_field({FieldDab::Tool::add, {64, 20, 64}, 44}, own.field, {}, change).ok());
  std::vector<std::byte> room(ExtractBlock<std::int8_t>::room_bytes() + 16);
  void* aligned = room.data();
  std::size_t space = room.size();
  std::align(16, ExtractBlock<std::int8_t>::room_bytes(), aligned, space);
  std::vector<IsoVertex> vertices(28'000);
  std::vector<std::uint16_t> indices(120'000);
  std::vector<std::byte> kept(64 * (8 + FieldBlocks::kBlockBytes));
  std::vector<double> sculpted_us, all_us, bounded_us;
  std::size_t blocks = 0, made = 0;
  std::array<float, 4> off{};  // by level; what is known grows with each dab
  for (int n = 0; n < 200; ++n) {
    FieldDab dab{FieldDab::Tool::subtract, {40.3 + 0.21 * n, 62.1, 60.7 + 0.1 * n}, 4};
    const auto start = std::chrono::steady_clock::now();
    ASSERT_TRUE(sculpt_field(dab, own.field, kept, change).ok());
    const auto middle = std::chrono::steady_clock::now();
    // Normals of the blocks beside look one sample over their sides.
    const glm::ivec3 low = glm::max(change.first - 2, glm::ivec3(0)) >> 4;
    const glm::ivec3 high = glm::min(change.last + 2, own.field.info().blocks * 16 - 1) >> 4;
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          ExtractBlock<std::int8_t> job;
          job.field = &own.field.bytes();
          job.corner = glm::ivec3(x, y, z) * 16;
          job.vertices = vertices;
          job.triangles = indices;
          ExtractBlock<std::int8_t>::Result result;
          ASSERT_TRUE(job.run({static_cast<std::byte*>(aligned), space}, result).ok());
          ++blocks;
          made += result.vertices;
        }
      }
    }
    const auto end = std::chrono::steady_clock::now();
    // How far coarser levels are off now, as blocks/block_tree.cpp asks for it.
    for (int level = 1; level <= 3; ++level) {
      MeasureCells<std::int8_t> cells;
      cells.field = &own.field.bytes();
      cells.level = level;
      float& known = off[static_cast<std::size_t>(level)];
      known = std::max(known, cells.run((change.first - 1) >> level, change.last >> level, known).most);
      EXPECT_GT(known, 0);
    }
    bounded_us.push_back(
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - end).count());
    sculpted_us.push_back(std::chrono::duration<double, std::micro>(middle - start).count());
    all_us.push_back(std::chrono::duration<double, std::micro>(end - start).count());
  }
  std::ranges::sort(sculpted_us);
  std::ranges::sort(all_us);
  std::ranges::sort(bounded_us);
  std::printf(
      "a dab of radius 4: %.1f us, with meshes %.1f us (median), %.1f us (least), and errors of levels %.1f "
      "us; "
      "%.1f blocks, %.0f vertices\n",
      sculpted_us[100], all_us[100], all_us[0], bounded_us[100], static_cast<double>(blocks) / 200,
      static_cast<double>(made) / 200);
  EXPECT_GT(made, 0u);
}

}  // namespace
}  // namespace karst::core
