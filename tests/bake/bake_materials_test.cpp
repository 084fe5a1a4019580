// SPDX-License-Identifier: MIT
// Materials, painted patches and lights on their way into a world file.
#include "bake/carve/cave_lights.h"
#include "bake/pipeline/bake.h"
#include "terrain/field/voxelize.h"
#include "tests/bake/bake_files.h"
#include "tests/bake/bake_jobs.h"
#include "tests/support/process.h"
#include "tests/support/tree_memory.h"
#include "tests/support/world_io.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace karst::bake {
using namespace core;
namespace {

class BakeMaterialsTest : public ::testing::Test {
 protected:
  // A slope of 30 x 20 samples, 10 m apart, from 100 m in the west to 245 m in the east.
  Bake job(const std::string& file = {}) const {
    std::vector<float> heights;
    for (int k = 0; k < 30 * 20; ++k) heights.push_back(100 + 5 * static_cast<float>(k % 30));
    folder_.write("slope.tif",
                  TiffBuilder(30, 20, 32, 3, std::string(bytes_of(heights))).pixel_scale(10, 10).bytes());
    Bake result;
    result.read.path = folder_.path("slope.tif");
    result.voxel_m = 20;
    result.level = 2;
    result.materials.side = 16;
    if (!file.empty()) result.materials.path = folder_.write("ground.json", file);
    return result;
  }
  static std::string error_of(const Bake& job) {
    Bake::Report report;
    std::vector<std::byte> file;
    return job.run(report, {}, file).text();
  }

  test::Folder folder_;
  Bake::Report report_;
};

// Borrows from the file all but the set.
WorldMaterials read(const std::vector<std::byte>& file) {
  WorldInfo info;
  EXPECT_TRUE(read_world_info(file, info).ok());
  return read_materials(file);
}

TEST_F(BakeMaterialsTest, AWorldHasMaterialsByDefault) {
  const std::vector<std::byte> file = world_of(job(), report_);
  const WorldMaterials materials = read(file);
  ASSERT_EQ(materials.set.count, 5u);
  const char* const names[] = {"rock", "grass", "sand", "strata", "ceiling"};
  for (std::size_t k = 0; k < 5; ++k) EXPECT_STREQ(materials.set.materials[k].name, names[k]);
  EXPECT_EQ(materials.set.side, 16u);
  EXPECT_EQ(materials.set.format, TextureFormat::etc2);
  EXPECT_TRUE(materials.overrides.empty());
  EXPECT_TRUE(materials.lights.empty());
  EXPECT_EQ(report_.materials.set.count, 5u);

  Bake plain = job();
  plain.materials.none = true;
  EXPECT_EQ(read(world_of(plain, report_)).set.count, 0u);
  // High mountains have snow.
  Bake high = job();
  high.read.z_scale = 10;
  high.voxel_m = 40;
  const WorldMaterials mountains = read(world_of(high, report_));
  ASSERT_EQ(mountains.set.count, 6u);
  EXPECT_STREQ(mountains.set.materials[4].name, "snow");
  EXPECT_GT(mountains.set.materials[4].height_low, 20);
}

TEST_F(BakeMaterialsTest, MetresBecomeVoxels) {
  const std::vector<std::byte> file =
      world_of(job(R"({"format": "rgba8", "materials": [{"name": "base", "sample": "rock"},
              {"name": "meadow", "sample": "grass", "elevation": [120, 200], "elevation_soft": 10, "cave": 1},
              {"name": "ice", "sample": "snow", "slope": [0.5, null]}],
              "lights": [{"position": [10, 150, -20], "radius": 60, "color": [1, 2, 3]}]})"),
               report_);
  const WorldMaterials materials = read(file);
  const WorldInfo& info = report_.info;
  ASSERT_EQ(materials.set.count, 3u);
  EXPECT_EQ(materials.set.format, TextureFormat::rgba8);
  const Material& meadow = materials.set.materials[1];
  EXPECT_FLOAT_EQ(meadow.height_low, static_cast<float>((120 - info.origin_m[1]) / 20));
  EXPECT_FLOAT_EQ(meadow.height_high, static_cast<float>((200 - info.origin_m[1]) / 20));
  EXPECT_FLOAT_EQ(meadow.height_soft, 0.5f);
  EXPECT_EQ(meadow.cave, 1);
  EXPECT_FLOAT_EQ(meadow.slope_low, 0.8f) << "the sample's own rule";
  EXPECT_FLOAT_EQ(materials.set.materials[2].slope_low, 0.5f);
  EXPECT_GT(materials.set.materials[2].slope_high, 1);
  ASSERT_EQ(materials.lights.size(), 1u);
  EXPECT_FLOAT_EQ(materials.lights[0].radius, 3);
  EXPECT_FLOAT_EQ(materials.lights[0].position.y, static_cast<float>((150 - info.origin_m[1]) / 20));
  EXPECT_EQ(materials.lights[0].colour, glm::vec3(1, 2, 3));
}

// The later of two boxes wins; patches whose middle lies outside keep the rules.
TEST_F(BakeMaterialsTest, BoxesPaintPatches) {
  const std::vector<std::byte> file =
      world_of(job(R"({"paint": [{"center": [-70, 170, 0], "size": [150, 400, 400], "material": "sand"},
                        {"center": [-140, 170, 0], "size": [60, 400, 400], "material": "rock"}]})"),
               report_);
  const WorldMaterials materials = read(file);
  WorldInfo info;
  ASSERT_TRUE(read_world_info(file, info).ok());
  ASSERT_EQ(materials.overrides.size(), info.patches);
  std::size_t counts[4] = {};
  for (const std::uint8_t m : materials.overrides) ++counts[std::min<std::size_t>(m, 3)];
  EXPECT_EQ(counts[1] + counts[3], report_.materials.painted);
  EXPECT_EQ(counts[2], 0u);
  // The slope is even: shares of patches are shares of ground, 14 voxels from -140 m to 140 m.
  const double patches = info.patches;
  EXPECT_NEAR(static_cast<double>(counts[1]) / patches, 30.0 / 280, 0.06);
  EXPECT_NEAR(static_cast<double>(counts[3]) / patches, 115.0 / 280, 0.08);
  EXPECT_EQ(error_of(job(R"({"paint": [{"center": [0, 0, 0], "size": [1, 1, 1], "material": "lava"}]})"))
                .find(folder_.path("ground.json") + ": paint 0: material: there is no 'lava'"),
            0u);
}

// Powers of two of a voxel, here of 20 m.
TEST_F(BakeMaterialsTest, RepeatsAreStatedInMetres) {
  const auto repeat_log2 = [&](const char* text) {
    return read(world_of(job(text), report_)).set.repeat_log2;
  };
  EXPECT_EQ(repeat_log2("{}"), -3);  // 2.5 m for 2
  EXPECT_EQ(repeat_log2(R"({"repeat": 20})"), 0);
  EXPECT_EQ(repeat_log2(R"({"repeat": 27})"), 0);
  EXPECT_EQ(repeat_log2(R"({"repeat": 30})"), 1);
  EXPECT_EQ(repeat_log2(R"({"repeat": 100000})"), 5);
  EXPECT_EQ(repeat_log2(R"({"repeat": 0.00001})"), -16);
}

TEST_F(BakeMaterialsTest, OwnImagesAreUsed) {
  const std::vector<float> red = {0.25f, 0.0f, 0.0f};
  std::vector<float> samples;
  for (int k = 0; k < 9 * 9; ++k) samples.insert(samples.end(), red.begin(), red.end());
  write_image(folder_.path("red.tif"), 9, 9, samples, "float", 0, 3);
  const WorldMaterials materials =
      read(world_of(job(R"({"materials": [{"name": "red", "albedo": "red.tif"}]})"), report_));
  ASSERT_EQ(materials.set.count, 1u);
  EXPECT_NEAR(materials.set.materials[0].average[0], 0.25f, 0.01f);
  EXPECT_LT(materials.set.materials[0].average[1], 0.01f);
  const std::string error = error_of(job(R"({"materials": [{"name": "red", "albedo": "blue.tif"}]})"));
  EXPECT_EQ(error.find(folder_.path("ground.json") + ": material 0: "), 0u) << error;
  EXPECT_NE(error.find("blue.tif"), std::string::npos) << error;
}

// Textures as large as a file asks for, up to a size; beyond it the command line must ask.
TEST_F(BakeMaterialsTest, LargeTexturesAreForTheCommandLine) {
  const auto file = [](const char* side, int count) {
    std::string text = std::string(R"({"side": )") + side + R"(, "materials": [)";
    for (int k = 0; k < count; ++k)
      text += (k > 0 ? ", " : "") + (R"({"name": "m)" + std::to_string(k)) + R"(", "sample": "snow"})";
    return text + "]}";
  };
  Bake good = job(file("256", 8));
  good.materials.side.reset();
  EXPECT_EQ(read(world_of(good, report_)).set.side, 256u);
  // The same picture for each, painted once.
  const auto& layers = report_.materials.set;
  for (std::uint32_t m = 1; m < layers.count; ++m)
    EXPECT_EQ(layers.materials[m].slope_span, layers.materials[0].slope_span);

  Bake large = job(file("512", 3));
  large.materials.side.reset();
  const std::string error = error_of(large);
  EXPECT_NE(error.find("ground.json: side: 512 x 512 texels of 3 materials"), std::string::npos) << error;
  EXPECT_NE(error.find("--material-side 512 allows them"), std::string::npos) << error;
  Bake defaults = job(R"({"side": 512})");
  defaults.materials.side.reset();
  EXPECT_NE(error_of(defaults).find("512 x 512 texels of 6 materials"), std::string::npos);
  large.materials.side = 512;
  EXPECT_EQ(read(world_of(large, report_)).set.side, 512u);
}

// Weights go where the image has them, and what is painted twice over is shared out.
TEST_F(BakeMaterialsTest, ABlendMapIsTakenFromAnImage) {
  // 4 x 2 texels: red in the north-west; red and green full beside it; nothing in the east; blue in the
  // south, which has no material.
  std::vector<float> samples(4 * 2 * 3, 0.0f);
  samples[0] = 1;
  samples[3] = samples[4] = 1;
  for (int x = 0; x < 4; ++x) samples[static_cast<std::size_t>((4 + x) * 3 + 2)] = 1;
  write_image(folder_.path("weights.tif"), 4, 2, samples, "float", 0, 3);
  const std::vector<std::byte> file =
      world_of(job(R"({"blend_map": {"image": "weights.tif", "materials": ["sand", "grass"]}})"), report_);
  const WorldMaterials materials = read(file);
  const BlendMap& map = materials.set.blend_map;
  ASSERT_EQ(map.width, 4u);
  ASSERT_EQ(map.depth, 2u);
  EXPECT_EQ(map.materials[0], 3);
  EXPECT_EQ(map.materials[1], 2);
  EXPECT_EQ(map.materials[2], 0);
  const std::uint8_t expected[] = {255, 0, 0, 0, 127, 127, 0, 0};
  ASSERT_EQ(materials.blend_map.size(), 32u);
  for (std::size_t k = 0; k < 32; ++k) {
    EXPECT_EQ(std::to_integer<int>(materials.blend_map[k]), k < 8 ? expected[k] : 0) << k;
  }
  // At this size the map's levels reach all of it.
  EXPECT_EQ(report_.materials.under_map, report_.info.patches);
  for (const std::uint8_t m : materials.overrides) EXPECT_EQ(m, kPaintedByMap);
}

// 400 x 400 texels over 14 voxels: patches under the painted third, and those that its blurred levels reach.
TEST_F(BakeMaterialsTest, PatchesUnderABlendMapAreMarkedAndNoOthers) {
  std::vector<float> samples(400 * 400, 0.0f);
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k] = k % 400 < 133 ? 1.0f : 0.0f;
  write_image(folder_.path("weights.tif"), 400, 400, samples, "float", 0, 1);
  const std::vector<std::byte> file =
      world_of(job(R"({"blend_map": {"image": "weights.tif", "materials": ["sand"]},
                 "paint": [{"center": [-70, 170, 0], "size": [20, 400, 400], "material": "rock"}]})"),
               report_);
  const WorldMaterials materials = read(file);
  EXPECT_EQ(materials.set.blend_map.width, 400u);
  EXPECT_GT(report_.materials.painted, 0u) << "boxes win";
  // Texels left of 133 are painted; levels of the map carry them up to 12 further, and one is for rounding.
  const WorldPatches patches = read_patches(file);
  ASSERT_EQ(materials.overrides.size(), patches.keys.size());
  std::size_t marked = 0, boxed = 0;
  for (std::size_t p = 0; p < patches.keys.size(); ++p) {
    const double west = patches.keys[p].corner().x + patches.bounds[p].min[0] / 8192.0;  // voxels
    const double texel = (west - 0.5) * 400 / (report_.info.extent.x - 1);
    const std::uint8_t override = materials.overrides[p];
    marked += override == kPaintedByMap;
    boxed += override == 1;
    if (texel < 133 + 12) {
      EXPECT_NE(override, 0) << texel;
    }
    if (texel > 133 + 15) {
      EXPECT_NE(override, kPaintedByMap) << texel;
    }
  }
  EXPECT_EQ(marked, report_.materials.under_map);
  EXPECT_EQ(boxed, report_.materials.painted);
}

TEST_F(BakeMaterialsTest, WrongBlendMapsAreNamed) {
  write_image(folder_.path("grey.png"), 3, 3, std::vector<float>(9, 0.5f), "uint8", 0, 1);
  const auto error = [&](const std::string& map) {
    const std::string text = error_of(job(R"({"blend_map": )" + map + "}"));
    const std::string place = folder_.path("ground.json") + ": blend_map: ";
    EXPECT_EQ(text.find(place), 0u) << text;
    return text.substr(std::min(text.size(), place.size()));
  };
  EXPECT_EQ(error(R"({"image": "grey.png", "materials": ["lava"]})"), "materials: there is no 'lava'");
  EXPECT_EQ(error(R"({"image": "grey.png", "materials": ["sand", "sand"]})"),
            "materials: not names of materials, each once");
  EXPECT_EQ(error(R"({"image": "grey.png", "materials": ["sand", 3]})"),
            "materials: not names of materials, each once");
  EXPECT_EQ(error(R"({"image": "grey.png", "materials": []})"),
            "materials: an empty list; name the material of each channel");
  EXPECT_NE(error(R"({"image": "none.png", "materials": ["sand"]})").find("none.png"), std::string::npos);
  EXPECT_NE(error(R"({"image": "grey.png", "materials": ["sand", "rock"]})").find("has 1 channel"),
            std::string::npos);
}

// Two halls under a hill: a light in each, the larger hall's first, in the air and under rock.
TEST(CaveLights, StandWhereTheAirIsWidest) {
  const glm::ivec3 extent(32, 20, 16);
  const auto hall = [](glm::ivec3 v, glm::vec3 centre, float radius) {
    const glm::vec3 off = glm::vec3(v) - centre;
    return off.x * off.x + off.y * off.y + off.z * off.z < radius * radius;
  };
  const auto solid = [&](glm::ivec3 v, bool) {
    return v.y < 16 && !hall(v, {8, 8, 8}, 4.3f) && !hall(v, {24, 8, 8}, 3.2f);
  };
  TreeMemory memory(5);
  ASSERT_TRUE(VoxelizePredicate({extent, VoxelFunction(solid)}).run(memory.tree).ok());
  const std::vector<PointLight> lights = PlaceCaveLights{&memory.tree, extent}.run();
  ASSERT_EQ(lights.size(), 2u);
  EXPECT_EQ(lights[0].position, glm::vec3(8.5f, 8.5f, 8.5f));
  EXPECT_EQ(lights[1].position, glm::vec3(24.5f, 8.5f, 8.5f));
  PlaceCaveLights one{&memory.tree, extent};
  one.most = 1;
  EXPECT_EQ(one.run().size(), 1u);
}

}  // namespace
}  // namespace karst::bake
