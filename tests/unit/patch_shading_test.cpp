// SPDX-License-Identifier: MIT
#include "terrain/shading/patch_shading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include <glm/common.hpp>

#include "terrain/patch/octahedral.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

constexpr int kLevel = 3;

// A hall below a thin roof, with a mouth and a shaft, in hills.
test::TestWorld hall() {
  test::TestWorld world({40, 20, 36}, [](glm::ivec3 v) {
    const glm::dvec3 p = glm::dvec3(v) + 0.5;
    if (p.y > 12 + 2 * test::value_noise(2, glm::dvec3(p.x, 0, p.z) / 8.0)) return false;
    const glm::dvec3 d = (p - glm::dvec3(20, 5, 18)) / glm::dvec3(9, 4, 9);
    const bool mouth = v.z < 18 && std::abs(v.x - 20) < 3 && v.y >= 4 && v.y < 8;
    const bool shaft = v.x == 24 && v.z == 22 && v.y > 4;
    return d.x * d.x + d.y * d.y + d.z * d.z > 1 && !mouth && !shaft;
  });
  world.roughen(kLevel, 4, 1500);
  return world;
}

// As a texture of the cells looks it up.
float between_cells(const SkyVisibility& sky, glm::vec3 place) {
  const glm::vec3 p = place / sky.grid().cell_voxels() - 0.5f;
  const glm::ivec3 first(glm::floor(p));
  const glm::vec3 share = p - glm::vec3(first);
  float sum = 0;
  for (int o = 0; o < 8; ++o) {
    const glm::ivec3 corner(o & 1, o >> 1 & 1, o >> 2 & 1);
    const glm::vec3 w = glm::mix(1.0f - share, share, glm::vec3(corner));
    sum += w.x * w.y * w.z *
           static_cast<float>(sky.at(glm::clamp(first + corner, glm::ivec3(0), sky.grid().cells - 1)));
  }
  return sum / 255;
}

struct Shaded {
  explicit Shaded(const test::TestWorld& shape, std::size_t words) : world(shape), storage(words) {
    sky.create(storage);
    sky.build(world.octree(), world.extent());
    find.surface = world.surface();
    bounds = world.bounds();
    cones = world.shading_cones();
    out.resize(find.surface.patches.size());
    find.bounds = bounds;
    find.cones = cones;
    find.materials = &materials;
    find.sky = &sky;
    find.out = out;
  }

  const test::TestWorld& world;
  std::vector<std::uint64_t> storage;
  SkyVisibility sky;
  std::vector<PatchBounds> bounds;
  std::vector<NormalCone> cones;
  MaterialSet materials;
  std::vector<PatchShading> out;
  FindPatchShading find;
};

// What the shader computes at the vertices of patches that are no caves is no cave; of others at some.
void check_caves(std::size_t words, int cell_log2) {
  const test::TestWorld world = hall();
  Shaded shaded(world, words);
  ASSERT_EQ(shaded.sky.grid().cell_log2, cell_log2);
  shaded.find.run();
  int open = 0;
  int caves = 0;
  int dark = 0;
  for (PatchId p = 0; p < shaded.out.size(); ++p) {
    const bool cave = (shaded.out[p].needs & kShadeCave) != 0;
    const Volume& volume = world.surface().volume_of(p);
    const glm::vec3 origin(volume.corner[0], volume.corner[1], volume.corner[2]);
    float least = 1;
    for (const GpuVertex& v : world.vertices(p, kLevel)) {
      const glm::vec3 steps(v.position[0], v.position[1], v.position[2]);
      const glm::vec3 place = origin + steps / static_cast<float>(kStepsPerVoxel);
      const glm::vec3 normal = decode_octahedral(v.normal);
      least = std::min(least, between_cells(shaded.sky, place + normal * shaded.sky.grid().cell_voxels()));
    }
    ASSERT_TRUE(cave || least >= kCaveBegins) << p;
    open += !cave;
    caves += cave;
    dark += cave && least < kCaveBegins;
  }
  EXPECT_GT(open, 1000);
  EXPECT_GT(dark, 200);
  EXPECT_GT(dark, caves / 3) << "few are taken for caves in vain";
}

TEST(PatchShading, WhatIsNoCaveIsNowhereDark) {
  const glm::ivec3 extent(40, 20, 36);
  check_caves(SkyVisibility::word_count(extent), 0);
  check_caves(SkyVisibility::word_count(extent / 2), 1);
}

TEST(PatchShading, FieldsAreChecked) {
  const test::TestWorld world = hall();
  Shaded shaded(world, 20'000);
  EXPECT_TRUE(shaded.find.validate().ok());
  const auto wrong = [&](auto spoil) {
    FindPatchShading find = shaded.find;
    spoil(find);
    EXPECT_EQ(find.validate().code(), StatusCode::invalid_argument);
    return std::string(find.validate().field());
  };
  EXPECT_EQ(wrong([](FindPatchShading& f) { f.materials = nullptr; }), "materials");
  EXPECT_EQ(wrong([](FindPatchShading& f) { f.sky = nullptr; }), "sky");
  EXPECT_EQ(wrong([](FindPatchShading& f) { f.bounds = f.bounds.subspan(1); }), "bounds");
  EXPECT_EQ(wrong([](FindPatchShading& f) { f.cones = f.cones.subspan(1); }), "cones");
  EXPECT_EQ(wrong([](FindPatchShading& f) { f.out = f.out.subspan(1); }), "out");
}

}  // namespace
}  // namespace karst::core
