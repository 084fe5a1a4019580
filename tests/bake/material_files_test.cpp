// SPDX-License-Identifier: MIT
// Images of materials from files: colour, orientation, resizing that keeps tiles, and files that are none.
#include "bake/materials/material_files.h"

#include "tests/bake/bake_files.h"
#include "tests/support/process.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>

namespace karst::bake {
namespace {

void expect_near(glm::vec3 a, glm::vec3 b) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-5);
}

class MaterialFiles : public ::testing::Test {
 protected:
  // value(x, y, channel), y downwards, in 0..1.
  std::string write(const std::string& name, int width, int height, int channels,
                    const std::function<double(int, int, int)>& value,
                    const std::string& type = "uint8") const {
    // write_image hands integers on as they are.
    const double scale = type == "uint8" ? 255 : type == "uint16" ? 65'535 : 1;
    std::vector<float> samples;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < channels; ++c) samples.push_back(static_cast<float>(scale * value(x, y, c)));
      }
    }
    write_image(folder_.path(name), width, height, samples, type, 0, channels);
    return name;
  }
  MaterialSpec spec(const std::string& albedo) const {
    MaterialSpec result;
    result.name = "own";
    result.albedo = albedo;
    return result;
  }
  MaterialImage read(const MaterialSpec& spec, int side) const {
    MaterialImage image;
    TexelBudget budget;
    EXPECT_EQ(read_material_image(spec, folder_.path("."), side, budget, image).text(), "");
    return image;
  }
  std::string error_of(const MaterialSpec& spec) const {
    MaterialImage image;
    TexelBudget budget;
    return read_material_image(spec, folder_.path("."), 16, budget, image).text();
  }

  test::Folder folder_;
};

TEST_F(MaterialFiles, IntegersAreSrgbAndFloatsLinear) {
  const auto half = [](int, int, int) { return 188.0 / 255; };
  for (const char* type : {"uint8", "uint16"}) {
    const MaterialImage image = read(spec(write("a.tif", 16, 16, 3, half, type)), 16);
    for (const glm::vec3& albedo : image.albedo) EXPECT_NEAR(albedo.y, 0.503f, 0.001f);
    EXPECT_EQ(image.roughness[7], 0.85f);
    EXPECT_EQ(image.slope[7], glm::vec2(0));
  }
  const MaterialImage image = read(spec(write("a.tif", 16, 16, 1, half, "float")), 16);
  EXPECT_NEAR(image.albedo[9].z, 188.0f / 255, 1e-6f);
}

TEST_F(MaterialFiles, TheTopOfTheImageIsUp) {
  // Left half red, upper half green.
  const auto quarters = [](int x, int y, int c) { return c == 0 ? x < 8 : c == 1 ? y < 8 : 0; };
  const MaterialImage image = read(spec(write("q.png", 16, 16, 3, quarters)), 16);
  expect_near(image.albedo[image.at(2, 2)], glm::vec3(1, 0, 0));
  expect_near(image.albedo[image.at(2, 13)], glm::vec3(1, 1, 0));
  expect_near(image.albedo[image.at(13, 13)], glm::vec3(0, 1, 0));
}

// A wave that tiles is the same wave after resizing, up to the borders.
TEST_F(MaterialFiles, ResizingKeepsTiles) {
  constexpr double kTurn = 6.283185307179586;
  for (const auto& [width, height, side] :
       {std::array{48, 80, 16}, {100, 37, 64}, {24, 24, 64}, {512, 300, 32}}) {
    const auto wave = [&, w = width, h = height](int x, int y, int c) {
      const double s = (x + 0.5) / w, t = 1 - (y + 0.5) / h;
      return 0.5 + 0.4 * std::cos(kTurn * (c == 0 ? s : c == 1 ? t : s + t));
    };
    const MaterialImage image = read(spec(write("w.tif", width, height, 3, wave, "float")), side);
    double worst = 0;
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const double s = (i + 0.5) / side, t = (j + 0.5) / side;
        const glm::vec3 albedo = image.albedo[image.at(i, j)];
        worst = std::max(worst, std::abs(albedo.x - (0.5 + 0.4 * std::cos(kTurn * s))));
        worst = std::max(worst, std::abs(albedo.y - (0.5 + 0.4 * std::cos(kTurn * t))));
        worst = std::max(worst, std::abs(albedo.z - (0.5 + 0.4 * std::cos(kTurn * (s + t)))));
      }
    }
    EXPECT_LT(worst, 0.02) << width << " x " << height << " to " << side;
  }
}

// Twice as large and more in both directions: each texel is the mean of what it covers, whatever filters do.
TEST_F(MaterialFiles, LargeImagesAreAveraged) {
  const auto noise = [](int x, int y, int c) { return (x * 7 + y * 13 + x * y % 11 + c * 5) % 32 / 32.0; };
  for (const auto& [width, height] : {std::array{32, 32}, {64, 96}, {160, 32}}) {
    const MaterialImage image = read(spec(write("n.tif", width, height, 3, noise, "float")), 16);
    const int across = width / 16, down = height / 16;
    for (int j = 0; j < 16; ++j) {
      for (int i = 0; i < 16; ++i) {
        double sum = 0;
        for (int y = 0; y < down; ++y) {
          for (int x = 0; x < across; ++x) sum += noise(i * across + x, (15 - j) * down + y, 1);
        }
        ASSERT_NEAR(image.albedo[image.at(i, j)].y, sum / (across * down), 1e-5) << width << " x " << height;
      }
    }
  }
}

TEST_F(MaterialFiles, HeightNormalAndRoughnessAreTaken) {
  const auto grey = [](int, int, int) { return 0.5; };
  MaterialSpec own = spec(write("g.png", 8, 8, 3, grey));
  own.height = write("h.png", 16, 16, 1, [](int x, int, int) { return x < 8 ? 1.0 : 0.0; });
  own.normal = write(
      "n.tif", 4, 4, 3, [](int, int, int c) { return c == 0 ? 0.5 : 0.9; }, "float");
  own.roughness = write("r.png", 16, 16, 1, [](int, int, int) { return 0.2; });
  const MaterialImage image = read(own, 16);
  EXPECT_NEAR(image.height[image.at(3, 3)], 1, 0.01);
  EXPECT_NEAR(image.height[image.at(12, 3)], 0, 0.01);
  EXPECT_NEAR(image.slope[5].x, 0, 1e-5);
  EXPECT_NEAR(image.slope[5].y, -1, 1e-5);  // it faces up, so the height falls that way
  EXPECT_NEAR(image.roughness[5], 0.2, 0.001);

  // Without a normal image, the height's slope; without a height image, the albedo's brightness.
  own.normal = "";
  own.relief = 0.1;
  EXPECT_LT(read(own, 16).slope[image.at(8, 3)].x, -0.5f);
  own.height = "";
  own.albedo = write("b.png", 16, 16, 3, [](int, int y, int) { return y < 8 ? 0.9 : 0.3; });
  const MaterialImage derived = read(own, 16);
  EXPECT_NEAR(derived.height[derived.at(3, 12)], 1, 1e-5);
  EXPECT_NEAR(derived.height[derived.at(3, 3)], 0, 1e-5);
}

TEST_F(MaterialFiles, MistakesNameTheFile) {
  EXPECT_NE(error_of(spec("missing.png")).find("missing.png"), std::string::npos);
  folder_.write("text.png", std::string("this is no image at all"));
  EXPECT_NE(error_of(spec("text.png")).find("text.png: not a PNG"), std::string::npos);
  EXPECT_NE(error_of(spec(".")).find("/."), std::string::npos);
  write("big.tif", 8'193, 1, 1, [](int, int, int) { return 0.0; });
  EXPECT_NE(error_of(spec("big.tif")).find("big.tif: size: 8193 x 1"), std::string::npos);
  write(
      "nan.tif", 4, 4, 3, [](int, int, int) { return std::nan(""); }, "float");
  EXPECT_NE(error_of(spec("nan.tif")).find("not a number"), std::string::npos);
}

// What a file states is held against what it can hold before anything is read.
TEST_F(MaterialFiles, WhatIsLargeForItsBytesIsRefused) {
  const std::string few(100, 'x');
  folder_.write("wide.tif", TiffBuilder(8'192, 8'192, 8, 1, few).bytes());
  EXPECT_NE(error_of(spec("wide.tif")).find("wide.tif: size: 8192 x 8192 texels in "), std::string::npos);
  EXPECT_NE(error_of(spec("wide.tif")).find("use a smaller image, or --max-texels 67108864"),
            std::string::npos);
  folder_.write("tile.tif", TiffBuilder(64, 64, 8, 1, few).shorts(322, {8'192}).shorts(323, {8'192}).bytes());
  EXPECT_NE(error_of(spec("tile.tif")).find("tile.tif: tiles: 8192 x 8192"), std::string::npos);
  write("five.tif", 4, 4, 5, [](int, int, int) { return 0.5; });
  EXPECT_NE(error_of(spec("five.tif")).find("five.tif: channels: 5"), std::string::npos);
  std::string scans("\xff\xd8\xff\xe0", 4);
  for (int k = 0; k < 65; ++k) scans += "\xff\xda";
  folder_.write("scans.jpg", scans);
  EXPECT_NE(error_of(spec("scans.jpg")).find("scans.jpg: 65 scans; the most is 64"), std::string::npos);
}

// All images of a material file share what may be decoded; each counts as often as it is named, and its file
// once, under whatever name.
TEST_F(MaterialFiles, TexelsAreCountedOverAllImages) {
  const std::string flat = write("flat.png", 1'024, 1'024, 1, [](int, int, int) { return 0.5; });
  const std::uint64_t texels = 1'024 * 1'024;
  MaterialSpec four = spec(flat);
  four.height = four.normal = four.roughness = flat;
  const std::string path = folder_.path(flat);
  ASSERT_LT(std::filesystem::file_size(path), texels / TexelBudget::kTexelsAByte / 4);
  ASSERT_EQ(TexelBudget::kFreeTexels, 4 * texels);
  const std::vector<std::string> paths(6, path);
  TexelBudget budget(paths);
  MaterialImage image;
  ASSERT_EQ(read_material_image(four, folder_.path("."), 16, budget, image).text(), "");
  const std::string fifth = read_material_image(four, folder_.path("."), 16, budget, image).text();
  EXPECT_NE(fifth.find("flat.png: size: 1024 x 1024 texels"), std::string::npos) << fifth;
  // The fifth and sixth have as many.
  EXPECT_NE(fifth.find("--max-texels 6291456"), std::string::npos) << fifth;
  BlendMap map;
  std::vector<std::byte> weights;
  EXPECT_NE(read_blend_map(path, 1, budget, map, weights).text().find("--max-texels 6291456"),
            std::string::npos);

  TexelBudget allowed(paths, 6 * texels);
  for (int k = 0; k < 5; ++k) ASSERT_EQ(read_blend_map(path, 1, allowed, map, weights).text(), "");
  EXPECT_EQ(map.width, 1'024u);
  EXPECT_EQ(weights.size(), std::size_t{texels} * core::kBlendTexelBytes);
  EXPECT_EQ(allowed.left(), texels);

  // Bytes of a file give texels once.
  folder_.write("long", std::string(100'000, 'x'));
  std::filesystem::create_hard_link(folder_.path("long"), folder_.path("same"));
  const std::vector<std::string> names = {folder_.path("long"), folder_.path("./long"), folder_.path("same"),
                                          folder_.path("missing")};
  EXPECT_EQ(TexelBudget(names).left(), TexelBudget::kFreeTexels + 100'000 * TexelBudget::kTexelsAByte);
}

TEST_F(MaterialFiles, EveryTruncationIsRefused) {
  const IgnoreLeaks ignore;
  for (const char* name : {"t.png", "t.tif", "t.exr"}) {
    write(
        name, 9, 7, 3, [](int x, int y, int c) { return 0.1 * ((x * 7 + y * 3 + c) % 10); },
        std::string(name) == "t.exr" ? "half" : "uint8");
    const std::string whole = test::read_text(folder_.path(name));
    EXPECT_EQ(error_of(spec(name)), "");
    for (std::size_t length = 0; length + 12 < whole.size(); length += 5) {
      folder_.write("cut", whole.substr(0, length));
      EXPECT_NE(error_of(spec("cut")), "") << name << " of " << length << " bytes";
    }
  }
}

}  // namespace
}  // namespace karst::bake
