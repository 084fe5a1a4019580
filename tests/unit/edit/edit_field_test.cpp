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

#include "terrain/edit/field/edit_field.h"
#include "terrain/edit/undo_log.h"
#include "terrain/isosurface/extract_block.h"
#include "terrain/isosurface/measure_cells.h"
#include "tests/support/field_mesh.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::OwnField;

FieldInfo info_of(int bits, glm::ivec3 blocks = glm::ivec3(4)) {
  FieldInfo info = test::field_info(blocks, 0);
  info.sample_bits = bits;
  return info;
}

std::vector<int> all_of(const OwnField& own) {
  std::vector<int> out;
  const glm::ivec3 n = own.field.info().blocks * 16;
  for (int z = 0; z < n.z; ++z) {
    for (int y = 0; y < n.y; ++y) {
      for (int x = 0; x < n.x; ++x) out.push_back(own.at({x, y, z}));
    }
  }
  return out;
}

Edit ball(EditTool tool, glm::dvec3 place, double radius) {
  Edit edit;
  edit.tool = tool;
  edit.place = place;
  edit.radius = radius;
  return edit;
}

Status sculpt(OwnField& own, const Edit& edit, FieldChange& change) {
  return edit_field({&own.field, {}}, edit, nullptr, change);
}

// Of a log and of what goes with it.
struct Log {
  explicit Log(const OwnField& own, std::size_t bytes = 16 << 20)
      : memory(bytes / 8), kept_in(own.table.size()) {
    log.create(std::as_writable_bytes(std::span(memory)));
  }
  std::vector<std::uint64_t> memory;
  std::vector<std::uint32_t> kept_in;
  UndoLog log;
};

double value_of(int stored, int bits) {
  return (stored + 0.5) / (bits == 16 ? 16'384 : 64);  // cells, at a reach of 2
}

TEST(EditField, DabsAreWhatTheyMeanAtEverySample) {
  for (const int bits : {8, 16}) {
    OwnField own(info_of(bits), 64);
    FieldChange change;
    const glm::dvec3 place(30.3, 31.8, 29.1), hole(34.9, 30.2, 33.3), half(3.2, 9, 4.1);
    const glm::dvec3 a(20.2, 20.9, 41), b(44, 41.3, 22);
    ASSERT_TRUE(sculpt(own, ball(EditTool::fill, place, 9.5), change).ok());
    EXPECT_TRUE(change.changed);
    ASSERT_TRUE(sculpt(own, ball(EditTool::clear, hole, 6), change).ok());
    Edit box = ball(EditTool::fill, {50, 32, 32}, 0);
    box.shape = BrushShape::box;
    box.half = half;
    ASSERT_TRUE(sculpt(own, box, change).ok());
    Edit tunnel = ball(EditTool::clear, a, 2.5);
    tunnel.shape = BrushShape::capsule;
    tunnel.to = b;
    ASSERT_TRUE(sculpt(own, tunnel, change).ok());
    double most = 0;
    for (int z = 0; z < 64; ++z) {
      for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
          const glm::dvec3 p(x, y, z);
          double d = std::max(glm::length(p - place) - 9.5, 6 - glm::length(p - hole));
          const glm::dvec3 q = glm::abs(p - box.place) - half;
          const double outside = glm::length(glm::max(q, glm::dvec3(0)));
          d = std::min(d, outside > 0 ? outside : std::max({q.x, q.y, q.z}));
          const double t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
          d = std::max(d, 2.5 - glm::length(p - (a + t * (b - a))));
          const double off = std::abs(value_of(own.at({x, y, z}), bits) - std::clamp(d, -2.0, 2.0));
          most = std::max(most, off);
        }
      }
    }
    EXPECT_LE(most, bits == 16 ? 3.1e-5 : 0.0079);  // half a step
  }
}

TEST(EditField, LengthsAreVoxelsWhereverTheFieldLies) {
  FieldInfo info = info_of(16);
  info.corner = {7, 3, 90};
  info.cell_log2 = 11;  // a fourth of a voxel
  OwnField own(info, 64), plain(info_of(16), 64);
  FieldChange change;
  ASSERT_TRUE(sculpt(plain, ball(EditTool::fill, {30, 26, 40}, 9), change).ok());
  const Edit edit = ball(EditTool::fill, glm::dvec3(7, 3, 90) + glm::dvec3(30, 26, 40) / 4.0, 9 / 4.0);
  EXPECT_TRUE(reaches_field(edit, info));
  EXPECT_FALSE(reaches_field(ball(EditTool::fill, {30, 26, 40}, 9), info));
  ASSERT_TRUE(sculpt(own, edit, change).ok());
  EXPECT_EQ(all_of(own), all_of(plain));
}

TEST(EditField, FlattenDrawsTheSurfaceToItsPlane) {
  OwnField own(info_of(16), 64);
  FieldChange change;
  ASSERT_TRUE(sculpt(own, ball(EditTool::fill, {32, 8, 32}, 24), change).ok());
  Edit dab = ball(EditTool::flatten, {32, 31, 32}, 8);
  dab.up = {1, 2, 0};
  dab.hardness = 0.5;
  const std::vector<int> before = all_of(own);
  ASSERT_TRUE(sculpt(own, dab, change).ok());
  // Where the brush is whole it is the plane, outside of the ball all is as it was.
  std::size_t n = 0;
  int changed = 0;
  for (int z = 0; z < 64; ++z) {
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x, ++n) {
        const glm::dvec3 from = glm::dvec3(x, y, z) - dab.place;
        const double away = glm::length(from);
        changed += own.at({x, y, z}) != before[n];
        if (away <= 4) {
          const double plane = glm::dot(from, glm::normalize(dab.up));
          ASSERT_NEAR(value_of(own.at({x, y, z}), 16), std::clamp(plane, -2.0, 2.0), 1e-4);
        }
        if (away >= 8) {
          ASSERT_EQ(own.at({x, y, z}), before[n]);
        }
      }
    }
  }
  EXPECT_GT(changed, 100);
  // Of no strength it changes nothing; level is the same with a level plane.
  const std::vector<int> sloped = all_of(own);
  dab.amount = 0;
  ASSERT_TRUE(sculpt(own, dab, change).ok());
  EXPECT_FALSE(change.changed);
  EXPECT_EQ(all_of(own), sloped);
  OwnField other(info_of(16), 64);
  ASSERT_TRUE(sculpt(other, ball(EditTool::fill, {32, 8, 32}, 24), change).ok());
  dab.amount = 1;
  dab.tool = EditTool::level;
  ASSERT_TRUE(sculpt(other, dab, change).ok());
  EXPECT_NEAR(value_of(other.at({35, 31, 32}), 16), 0, 1e-4);
  EXPECT_NEAR(value_of(other.at({35, 32, 32}), 16), 1, 1e-4);
}

// Of the samples around the surface: how far each is from the mean of its neighbours.
double roughness(const OwnField& own) {
  double sum = 0;
  for (int z = 1; z < 63; ++z) {
    for (int y = 1; y < 63; ++y) {
      for (int x = 1; x < 63; ++x) {
        const glm::ivec3 at(x, y, z);
        const double v = own.at(at);
        if (std::abs(v) > 16'000) continue;
        double mean = 0;
        for (int axis = 0; axis < 3; ++axis) {
          glm::ivec3 step(0);
          step[axis] = 1;
          mean += (own.at(at + step) + own.at(at - step)) / 6.0;
        }
        sum += (v - mean) * (v - mean);
      }
    }
  }
  return sum;
}

TEST(EditField, SmoothTakesBumpsAwayAndNothingElse) {
  OwnField own(info_of(16), 64);
  own.fill([](glm::dvec3 p) { return p.y - 32.3 + 2 * test::value_noise(5, p / 2.0); });
  const double rough = roughness(own);
  const std::vector<int> before = all_of(own);
  FieldChange change;
  const Edit dab = ball(EditTool::smooth, {31, 32, 33}, 40);
  for (int n = 0; n < 4; ++n) ASSERT_TRUE(sculpt(own, dab, change).ok());
  EXPECT_LT(roughness(own), 0.2 * rough);
  std::size_t n = 0;
  for (int z = 0; z < 64; ++z) {
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x, ++n) {
        if (glm::length(glm::dvec3(x, y, z) - dab.place) >= 40) {
          ASSERT_EQ(own.at({x, y, z}), before[n]);
        }
      }
    }
  }
  // A plane stays where it is, but for what distances lack that are cut off.
  own.fill([](glm::dvec3 p) { return p.y - 32.25; });
  const std::vector<int> plane = all_of(own);
  ASSERT_TRUE(sculpt(own, ball(EditTool::smooth, {31, 32, 33}, 8), change).ok());
  n = 0;
  for (int z = 0; z < 64; ++z) {
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x, ++n) {
        if (y == 32) {
          ASSERT_LE(std::abs(own.at({x, y, z}) - plane[n]), 163);  // 0.01 of a cell
        }
      }
    }
  }
}

TEST(EditField, IsTakenBackAndDoneAgainToTheBit) {
  for (const int bits : {8, 16}) {
    std::mt19937 random(static_cast<unsigned>(bits));
    const auto next = [&](double low, double high) {
      return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
    };
    OwnField own(info_of(bits), 40);
    Log kept(own);
    std::vector<std::vector<int>> states{all_of(own)};
    std::vector<std::uint32_t> free{own.free()};
    int refused = 0, smoothed = 0;
    for (int n = 0; n < 60; ++n) {
      kept.log.begin();
      bool changed = false;
      const int dabs = n % 4 == 3 ? 5 : 1;
      for (int k = 0; k < dabs; ++k) {
        constexpr EditTool kTools[] = {EditTool::fill, EditTool::clear, EditTool::flatten, EditTool::smooth};
        Edit dab = ball(n == 0 ? EditTool::fill : kTools[random() % 4],
                        {next(-4, 68), next(-4, 68), next(-4, 68)}, next(1, 20));
        dab.amount = next(0, 1);
        FieldChange change;
        const std::vector<int> before = all_of(own);
        const Status status = edit_field({&own.field, kept.kept_in}, dab, &kept.log, change);
        if (!status.ok()) {
          EXPECT_STREQ(status.field(), "field_sample_blocks");
          EXPECT_FALSE(change.changed);
          ASSERT_EQ(all_of(own), before);
          ++refused;
        }
        ASSERT_EQ(change.changed, all_of(own) != before);
        changed = changed || change.changed;
        smoothed += change.changed && dab.tool == EditTool::smooth;
      }
      kept.log.end();
      if (!changed) continue;
      states.push_back(all_of(own));
      free.push_back(own.free());
    }
    EXPECT_GT(refused, 0);
    EXPECT_GT(smoothed, 3);
    ASSERT_GT(states.size(), 30u);
    ASSERT_EQ(kept.log.undo_steps(), states.size() - 1);
    FieldChange change;
    const auto take = [&](UndoPart part) { exchange_field(own.field, part, change); };
    for (int round = 0; round < 2; ++round) {
      for (std::size_t n = states.size() - 1; n-- > 0;) {
        ASSERT_TRUE(kept.log.undo(take));
        ASSERT_EQ(all_of(own), states[n]) << n;
        ASSERT_EQ(own.free(), free[n]) << n;
      }
      for (std::size_t n = 1; n < states.size(); ++n) {
        ASSERT_TRUE(kept.log.redo(take));
        ASSERT_EQ(all_of(own), states[n]) << n;
        ASSERT_EQ(own.free(), free[n]) << n;
      }
    }
  }
}

TEST(EditField, AStrokeKeepsEachBlockOnce) {
  OwnField own(info_of(8), 64);
  Log kept(own);
  FieldChange change;
  kept.log.begin();
  for (int n = 0; n < 50; ++n) {
    ASSERT_TRUE(edit_field({&own.field, kept.kept_in}, ball(EditTool::fill, {24 + 0.1 * n, 24, 24}, 3),
                           &kept.log, change)
                    .ok());
  }
  kept.log.end();
  std::size_t cells = 0, parts = 0;
  kept.log.undo([&](UndoPart part) {
    ++parts;
    for ([[maybe_unused]] const UndoCell cell : part) ++cells;
    exchange_field(own.field, part, change);
  });
  EXPECT_EQ(parts, 1u);
  EXPECT_LE(cells, 8u);
  EXPECT_EQ(own.free(), 64u);
}

TEST(EditField, SaysWhatIsWrongAndChangesNothing) {
  OwnField own(info_of(8), 1);
  FieldChange change;
  const std::vector<int> before = all_of(own);
  const auto field_of = [&](const Edit& edit) {
    const Status status = sculpt(own, edit, change);
    EXPECT_FALSE(status.ok());
    EXPECT_FALSE(change.changed);
    return std::string(status.ok() ? "" : status.field());
  };
  const double nan = std::nan("");
  Edit dab = ball(EditTool::fill, {32, 32, 32}, 4);
  EXPECT_EQ(field_of(dab), "field_sample_blocks");
  EXPECT_EQ(sculpt(own, dab, change).value(), 7u);
  EXPECT_EQ(own.free(), 1u);
  for (const double radius : {0.0, -1.0, nan, 129.0, 1e300}) {
    EXPECT_EQ(field_of(ball(EditTool::fill, {32, 32, 32}, radius)), "radius_m");
  }
  for (const double at : {nan, 1e300, -HUGE_VAL}) {
    EXPECT_EQ(field_of(ball(EditTool::fill, {32, at, 32}, 4)), "place");
    EXPECT_FALSE(reaches_field(ball(EditTool::fill, {32, at, 32}, 4), own.field.info()));
  }
  Edit bad = dab;
  bad.amount = 2;
  EXPECT_EQ(field_of(bad), "amount");
  bad = dab;
  bad.hardness = nan;
  EXPECT_EQ(field_of(bad), "hardness");
  bad = dab;
  bad.tool = EditTool::flatten;
  bad.up = {0, 0, 0};
  EXPECT_EQ(field_of(bad), "up");
  bad = dab;
  bad.tool = EditTool::extrude;
  EXPECT_EQ(field_of(bad), "tool");
  bad = dab;
  bad.shape = BrushShape::cylinder;
  EXPECT_EQ(field_of(bad), "shape");
  bad.shape = BrushShape::box;
  bad.half = {1, nan, 1};
  EXPECT_EQ(field_of(bad), "half_m");
  bad.shape = BrushShape::capsule;
  bad.to = {32, 1e9, 32};
  EXPECT_EQ(field_of(bad), "to");
  EXPECT_EQ(all_of(own), before);
  // Far from the field nothing happens.
  EXPECT_TRUE(sculpt(own, ball(EditTool::fill, {-500, 0, 0}, 4), change).ok());
  EXPECT_FALSE(change.changed);
}

// Time of a dab of radius 4 with the meshes of all blocks that it reaches, for the record.
TEST(EditField, ADabAndItsMeshes) {
  OwnField own(info_of(8, glm::ivec3(8)), 512);
  Log kept(own);
  FieldChange change;
  ASSERT_TRUE(sculpt(own, ball(EditTool::fill, {64, 20, 64}, 44), change).ok());
  std::vector<std::byte> room(ExtractBlock<std::int8_t>::room_bytes() + 16);
  void* aligned = room.data();
  std::size_t space = room.size();
  std::align(16, ExtractBlock<std::int8_t>::room_bytes(), aligned, space);
  std::vector<IsoVertex> vertices(28'000);
  std::vector<std::uint16_t> indices(120'000);
  std::vector<double> sculpted_us, all_us, bounded_us;
  std::array<float, 4> off{};  // by level; what is known grows with each dab
  std::size_t blocks = 0, made = 0;
  for (int n = 0; n < 200; ++n) {
    const Edit dab = ball(EditTool::clear, {40.3 + 0.21 * n, 62.1, 60.7 + 0.1 * n}, 4);
    const auto start = std::chrono::steady_clock::now();
    kept.log.begin();
    ASSERT_TRUE(edit_field({&own.field, kept.kept_in}, dab, &kept.log, change).ok());
    kept.log.end();
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
      "us; %.1f blocks, %.0f vertices\n",
      sculpted_us[100], all_us[100], all_us[0], bounded_us[100], static_cast<double>(blocks) / 200,
      static_cast<double>(made) / 200);
  EXPECT_GT(made, 0u);
  for (std::size_t level = 1; level < off.size(); ++level) EXPECT_GT(off[level], 0) << level;
}

}  // namespace
}  // namespace karst::core
