// SPDX-License-Identifier: MIT
// Lands of features: their files, and grounds that are baked of them.
#include "bake/features/feature_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "bake/ground/bake_ground.h"
#include "tests/support/process.h"

namespace karst::bake {
namespace {

constexpr const char* kValley = R"({
  "size": [600, 400], "spacing": 2, "seed": 9, "water": 12.5,
  "noise": {"height": 30, "amplitude": 8, "wavelength": 300, "persistence": 0.45, "octaves": 6},
  "features": [
    {"feature": "river", "width": 12, "depth": 2, "valley": 50,
     "points": [[-290, 20, 12.5], [-50, -30, 12.5], [290, 40, 12.5]]},
    {"feature": "mountain", "center": [100, -120], "radius": 90, "height": 70, "peakiness": 0.75},
    {"feature": "hill", "center": [-150, 120], "radius": 80, "height": -15},
    {"feature": "dunes", "center": [150, 130], "radius": 70, "height": 5, "wavelength": 20, "towards": [3, 4]}
  ]})";

std::string refused(const std::string& text) {
  FeatureMap map;
  return parse_feature_map(text, "land.json", map).text();
}
FeatureMap valley() {
  FeatureMap map;
  EXPECT_EQ(parse_feature_map(kValley, "land.json", map).text(), "");
  return map;
}

TEST(FeatureMap, IsWhatTheFileSays) {
  const FeatureMap map = valley();
  EXPECT_EQ(map.columns(), 301);
  EXPECT_EQ(map.rows(), 201);
  EXPECT_EQ(map.seed, 9u);
  EXPECT_EQ(map.water_m, 12.5);
  EXPECT_EQ(map.noise.octaves, 6);
  ASSERT_EQ(map.features.size(), 4u);
  EXPECT_EQ(map.features[0].points.size(), 3u);
  EXPECT_EQ(map.features[0].feature.valley_m, 50);
  EXPECT_EQ(map.features[1].feature.peakiness, 0.75);
  EXPECT_EQ(map.features[2].feature.height_m, -15);
  EXPECT_DOUBLE_EQ(map.features[3].feature.towards.y, 0.8);
}

TEST(FeatureMap, ReadsBackWhatItWrites) {
  const std::string text = feature_map_text(valley());
  FeatureMap again;
  ASSERT_EQ(parse_feature_map(text, "land.json", again).text(), "");
  EXPECT_EQ(feature_map_text(again), text);
}

TEST(FeatureMap, ErrorsNameTheFeatureAndTheField) {
  EXPECT_EQ(refused("[]"), "land.json: not an object");
  EXPECT_NE(refused(R"({"sizes": 3})").find("sizes"), std::string::npos);
  EXPECT_NE(refused(R"({"size": [100]})").find("size: not two numbers"), std::string::npos);
  EXPECT_NE(refused(R"({"size": [1e7, 10]})").find("size"), std::string::npos);
  EXPECT_NE(refused(R"({"size": [10, 10], "spacing": 5})").find("spacing: the ground has less than 5"),
            std::string::npos);
  EXPECT_NE(refused(R"({"noise": {"octaves": 2.5}})").find("noise: octaves: not a whole number"),
            std::string::npos);
  EXPECT_NE(refused(R"({"noise": {"octaves": 13}})").find("octaves"), std::string::npos);
  const auto feature = [](const std::string& text) { return refused("{\"features\": [" + text + "]}"); };
  EXPECT_NE(feature(R"({"feature": "vulcano"})").find("feature 0: feature"), std::string::npos);
  EXPECT_NE(feature(R"({"feature": "hill", "center": [0, 0], "radius": 0, "height": 3})").find("radius"),
            std::string::npos);
  EXPECT_NE(feature(R"({"feature": "hill", "center": [0], "radius": 9, "height": 3})").find("center"),
            std::string::npos);
  EXPECT_NE(feature(R"({"feature": "hill", "center": [0, 0], "radius": 9, "height": 3, "peakiness": 1})")
                .find("peak"),
            std::string::npos);
  EXPECT_NE(feature(R"({"feature": "river", "width": 1, "depth": 1, "valley": 1, "points": [[0, 0, 0]]})")
                .find("points: fewer than two"),
            std::string::npos);
  EXPECT_NE(feature(R"({"feature": "dunes", "center": [0, 0], "radius": 9, "height": 3, "wavelength": 2,
                        "towards": [0, 0]})")
                .find("towards: 0, 0 is no direction"),
            std::string::npos);
}

// Row by row, in chunks of any size, by any number of threads; and the bed lies below its water.
TEST(FeatureMap, RowsAreTheSameHoweverTheyAreMade) {
  const FeatureMap map = valley();
  const MapSurface surface(map);
  const auto wide = static_cast<std::size_t>(map.columns()), high = static_cast<std::size_t>(map.rows());
  std::vector<float> all(wide * high), row(wide);
  surface.rows(0, map.rows(), all);
  for (std::size_t n = 0; n < high; ++n) {
    surface.rows(static_cast<int>(n), 1, row);
    ASSERT_TRUE(std::equal(row.begin(), row.end(), all.begin() + static_cast<std::ptrdiff_t>(n * wide))) << n;
  }
  // Its middle point, (-50, -30).
  const double bed = double{all[85 * wide + 125]};
  EXPECT_NEAR(bed, 10.5, 0.05);
  EXPECT_GT(*std::max_element(all.begin(), all.end()), 80);
}

TEST(FeatureMap, BecomesAGround) {
  const test::Folder folder;
  const std::string json = folder.write("land.json", kValley);
  std::string files[2];
  for (int n = 0; n < 2; ++n) {
    Bake job;
    job.features_path = json;
    job.materials.none = true;
    job.threads = 1 + 2 * n;
    const std::string out = folder.path("land" + std::to_string(n) + ".karst");
    BakeGround::Report report;
    ASSERT_EQ((BakeGround{job, out}.run(report, {}).text()), "");
    EXPECT_EQ(report.width, 301);
    EXPECT_EQ(report.source, "features");
    EXPECT_NEAR(report.lowest_m, 10.5, 0.5);
    EXPECT_GT(report.highest_m, 80);
    std::ostringstream bytes;
    bytes << std::ifstream(out, std::ios::binary).rdbuf();
    files[n] = bytes.str();
  }
  EXPECT_TRUE(files[0] == files[1]);
  EXPECT_GT(files[0].size(), 10'000u);
}

}  // namespace
}  // namespace karst::bake
