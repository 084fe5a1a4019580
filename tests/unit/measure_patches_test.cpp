// SPDX-License-Identifier: MIT
// Measuring everything against the parts it is made of, and measuring what was touched against everything.
#include "terrain/measure/measure_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "tests/support/heap_count.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

constexpr int kLevel = 3;

struct Measures {
  std::vector<std::uint16_t> errors;
  std::vector<PatchBounds> bounds;
  std::vector<NormalCone> cones;
  std::vector<NormalCone> shading;
  std::vector<BorderErrors> borders;

  explicit Measures(std::size_t patches)
      : errors(patches * level_error_values(kLevel)),
        bounds(patches),
        cones(patches),
        shading(patches),
        borders(patches) {}

  MeasurePatches stage(const test::TestWorld& world, std::span<const PatchId> list = {}) {
    MeasurePatches measure{world.surface(), world.heights(), list, {}, {errors, bounds, cones, shading}};
    measure.borders = std::span(borders).first(measure.count());
    return measure;
  }
  bool operator==(const Measures& other) const {
    return errors == other.errors && cones == other.cones && shading == other.shading &&
           std::memcmp(bounds.data(), other.bounds.data(), bounds.size() * sizeof(PatchBounds)) == 0;
  }
};

// In ranges of `chunk`, the later ones first: the order does not matter.
void run(const MeasurePatches& measure, std::size_t chunk) {
  const test::TestScratch scratch;
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(kLevel)));
  const Status status = measure.validate();
  ASSERT_TRUE(status.ok()) << status.field();
  const std::size_t count = measure.count();
  const std::uint64_t before = test::heap_calls();
  for (std::size_t end = count; end > 0; end -= std::min(end, chunk))
    measure.measure(end - std::min(end, chunk), end, {scratch.get(), vertices});
  for (std::size_t first = 0; first < count; first += chunk)
    measure.join(first, std::min(first + chunk, count));
  EXPECT_EQ(test::heap_calls(), before);
}

test::TestWorld rough_world(std::uint64_t seed) {
  test::TestWorld world = test::TestWorld::noise(seed, {14, 10, 14}, 0.45, 4.0, false);
  world.roughen(kLevel, seed, 900);
  return world;
}

TEST(MeasurePatches, MeasuresWhatItsPartsMeasure) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const test::TestWorld world = rough_world(seed);
    Measures all(world.surface().patches.size());
    run(all.stage(world), 7);
    EXPECT_EQ(all.errors, world.level_errors());
    const std::vector<PatchBounds> bounds = world.bounds();
    EXPECT_EQ(std::memcmp(all.bounds.data(), bounds.data(), bounds.size() * sizeof(PatchBounds)), 0);
    EXPECT_EQ(all.cones, world.cones());
    EXPECT_EQ(all.shading, world.shading_cones());
  }
}

// Heights around a point change; the patches that hold one, and those around them, are measured.
TEST(MeasurePatches, WhatWasTouchedIsEnough) {
  test::Random random{51};
  std::size_t measured = 0, neighbours_changed = 0;
  for (std::uint64_t seed = 0; seed < 16; ++seed) {
    test::TestWorld world = rough_world(seed);
    const std::size_t patches = world.surface().patches.size();
    Measures before(patches);
    run(before.stage(world), 1'000);
    const std::vector<std::int16_t> old = world.height_samples();
    const glm::dvec3 centre(2 + 10 * random.unit(), 2 + 6 * random.unit(), 2 + 10 * random.unit());
    world.set_heights(kLevel, [&](glm::dvec3 p) {
      const glm::dvec3 d = p - centre;
      const bool near = d.x * d.x + d.y * d.y + d.z * d.z < 1.5;
      return near ? 1'500 * test::value_noise(seed, p * 3.0) : 0.0;
    });
    std::vector<std::int16_t>& now = world.height_samples();
    const auto block = static_cast<std::size_t>(patch_vertices(kLevel));
    std::vector<PatchId> changed;
    for (PatchId p = 0; p < patches; ++p) {
      bool any = false;
      for (std::size_t i = p * block; i < (p + 1) * block; ++i) {
        any = any || now[i] != 0;
        now[i] = now[i] != 0 ? now[i] : old[i];
      }
      if (any) changed.push_back(p);
    }
    std::reverse(changed.begin(), changed.end());
    std::vector<PatchId> room(patches + 20);
    std::span<const PatchId> touched;
    ASSERT_TRUE(find_touched(world.surface(), changed, room, touched).ok());
    if (touched.empty()) continue;
    Measures all(patches);
    run(all.stage(world), 1'000);
    Measures some = before;
    run(some.stage(world, touched), 3);
    EXPECT_TRUE(some == all) << seed;
    measured += touched.size();
    for (const PatchId p : touched) {
      const bool itself = std::find(changed.begin(), changed.end(), p) != changed.end();
      const auto errors = [&](const Measures& m) { return std::span(m.errors).subspan(p * 4, 4); };
      const bool same = std::equal(errors(all).begin(), errors(all).end(), errors(before).begin()) &&
                        all.shading[p] == before.shading[p];
      neighbours_changed += !itself && !same ? 1u : 0u;
    }
  }
  // Without the neighbours the list would not be enough.
  EXPECT_GT(neighbours_changed, 10u);
  EXPECT_GT(measured, 100u);
}

TEST(MeasurePatches, FindTouchedNeedsRoom) {
  const test::TestWorld world = rough_world(2);
  const std::vector<PatchId> changed = {5, 1, 5};
  std::vector<PatchId> room(world.surface().patches.size() + 20);
  std::span<const PatchId> touched;
  ASSERT_TRUE(find_touched(world.surface(), changed, room, touched).ok());
  ASSERT_GT(touched.size(), 4u);
  EXPECT_TRUE(std::is_sorted(touched.begin(), touched.end()));
  EXPECT_EQ(std::adjacent_find(touched.begin(), touched.end()), touched.end());
  EXPECT_TRUE(std::binary_search(touched.begin(), touched.end(), PatchId{1}));
  const std::size_t needed = touched.size();
  const Status status = find_touched(world.surface(), changed, std::span(room).first(needed - 1), touched);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "room");
  EXPECT_TRUE(touched.empty());
}

TEST(MeasurePatches, RefusesWhatDoesNotFit) {
  test::TestWorld world = rough_world(3);
  const std::size_t patches = world.surface().patches.size();
  Measures m(patches);
  const auto field_of = [](const MeasurePatches& measure) { return std::string(measure.validate().field()); };
  MeasurePatches good = m.stage(world);
  ASSERT_TRUE(good.validate().ok());
  MeasurePatches bad = good;
  bad.heights.level = 0;
  EXPECT_EQ(field_of(bad), "heights");
  bad = good;
  bad.borders = bad.borders.first(1);
  EXPECT_EQ(field_of(bad), "borders");
  bad = good;
  bad.out.level_errors = bad.out.level_errors.first(1);
  EXPECT_EQ(field_of(bad), "level_errors");
  bad = good;
  bad.out.bounds = bad.out.bounds.first(1);
  EXPECT_EQ(field_of(bad), "bounds");
  bad = good;
  bad.out.cones = bad.out.cones.first(1);
  EXPECT_EQ(field_of(bad), "cones");
  bad = good;
  bad.out.shading_cones = bad.out.shading_cones.first(1);
  EXPECT_EQ(field_of(bad), "shading_cones");
  for (const std::vector<PatchId>& list :
       {std::vector<PatchId>{2, 1}, {1, 1}, {static_cast<PatchId>(patches)}}) {
    EXPECT_EQ(field_of(m.stage(world, list)), "list");
  }
  world.patches()[1].volume = kNoVolume;
  const std::vector<PatchId> free = {1};
  EXPECT_EQ(field_of(m.stage(world, free)), "list");
}

}  // namespace
}  // namespace karst::core
