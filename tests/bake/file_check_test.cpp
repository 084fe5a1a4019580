// SPDX-License-Identifier: MIT
// Elevation whose header and samples do not agree, or leave open what they mean: read rightly, or told of.
#include "bake/elevation/elevation.h"
#include "tests/bake/bake_files.h"
#include "tests/support/process.h"

#include <gtest/gtest.h>

#include <functional>
#include <initializer_list>
#include <utility>

namespace karst::bake {
namespace {

constexpr int kWidth = 6, kHeight = 5;

class FileCheck : public ::testing::Test {
 protected:
  static std::vector<float> heights(const std::function<float(int, int)>& of) {
    std::vector<float> result;
    for (int k = 0; k < kWidth * kHeight; ++k) result.push_back(of(k % kWidth, k / kWidth));
    return result;
  }
  static float hill(int x, int z) { return static_cast<float>(600 + 10 * x + z); }

  ReadElevation tiff(const std::string& name, const std::vector<float>& samples,
                     const std::string& metadata = {},
                     const std::vector<std::uint16_t>& keys = {1024, 1, 3072, 32632}) const {
    TiffBuilder builder(kWidth, kHeight, 32, 3, std::string(bytes_of(samples)));
    builder.pixel_scale(30, 30).doubles(33922, {0, 0, 0, 500'000, 4'000'000, 0}).geo_keys(keys);
    if (!metadata.empty()) builder.ascii(42112, metadata);
    return {folder_.write(name, builder.bytes())};
  }
  ReadElevation text_grid(const std::string& body, const std::string& more = {}) const {
    return {folder_.write(
        "grid.asc", "ncols 3\nnrows 2\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\n" + more + body)};
  }
  ReadElevation esri(const std::string& more, int bytes_before = 0) const {
    std::vector<std::int16_t> samples(static_cast<std::size_t>(bytes_before) / 2);
    for (const float height : heights(hill)) samples.push_back(static_cast<std::int16_t>(height));
    folder_.write("e.hdr",
                  "NROWS 5\nNCOLS 6\nNBANDS 1\nNBITS 16\nPIXELTYPE SIGNEDINT\nULXMAP 500000\n"
                  "ULYMAP 4000000\nXDIM 30\nYDIM 30\n" +
                      more);
    return {folder_.write("e.bil", std::string(bytes_of(samples)))};
  }
  ReadElevation mosaic(const std::string& type, const std::string& part, const std::string& band = {},
                       const std::string& kind = "SimpleSource", const std::string& of_part = {}) const {
    return {folder_.write(
        "m.vrt",
        "<VRTDataset rasterXSize=\"6\" rasterYSize=\"5\"><SRS>EPSG:32632</SRS><GeoTransform>500000, "
        "30, 0, 4000000, 0, -30</GeoTransform><VRTRasterBand dataType=\"" +
            type + "\" band=\"1\">" + band + "<" + kind + "><SourceFilename relativeToVRT=\"1\">" + part +
            "</SourceFilename><SourceBand>1</SourceBand>" + of_part + "</" + kind +
            "></VRTRasterBand></VRTDataset>")};
  }
  static void expect_error(const ReadElevation& read, const std::string& words) {
    const std::string message = error_of(read);
    EXPECT_NE(message.find(words), std::string::npos) << "got: " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  static void expect_warning(const ReadElevation& read, const std::string& words) {
    const Elevation elevation = elevation_of(read);
    ASSERT_EQ(elevation.warnings.size(), 1u) << (elevation.warnings.empty() ? "" : elevation.warnings[1]);
    EXPECT_NE(elevation.warnings[0].find(words), std::string::npos) << elevation.warnings[0];
  }

  test::Folder folder_;
};

TEST_F(FileCheck, WordsAmongHeightsAreNoZeros) {
  EXPECT_EQ(elevation_of(text_grid("1 2 3\n4 5 6\n")).heights_m[5], 6);
  EXPECT_EQ(elevation_of(text_grid("1,5 2 3\n4e0 -5 +6\n")).heights_m[0], 1.5f);
  EXPECT_EQ(elevation_of(text_grid("1 -9999 3\n4 5 6\n", "NODATA_value -9999\n")).voids, 1u);
  EXPECT_EQ(elevation_of(text_grid("1 * 3\n4 5.5 6\n", "NODATA_value *\n")).voids, 1u);
  expect_error(text_grid("1 2 3\n4 abc 6\n"), "height 5: 'abc' is not a number");
  expect_error(text_grid("1 2 3\n4 5 --\n"), "height 6: '--' is not a number");
}

TEST_F(FileCheck, TextGridsHoldWhatTheirHeaderSays) {
  expect_error(text_grid("1 2 3\n4 5\n"), "holds 5 heights, and its header says 3 x 2");
  expect_error(text_grid("1 2 3 4\n5 6 7 8\n"), "holds 8 heights, and its header says 3 x 2");
}

TEST_F(FileCheck, EsrisByteOrderMustBeSaid) {
  EXPECT_EQ(elevation_of(esri("BYTEORDER I\n")).heights_m[1], 610);
  EXPECT_EQ(elevation_of(esri("byteorder LSBFIRST\n")).heights_m[1], 610);
  expect_error(esri(""), "byte order");
  expect_error(esri("BYTEORDER 0\n"), "byte order");
}

TEST_F(FileCheck, BytesThatNoHeaderKnowsAreTold) {
  EXPECT_TRUE(elevation_of(esri("BYTEORDER I\nSKIPBYTES 8\n", 8)).warnings.empty());
  expect_warning(esri("BYTEORDER I\nNODATA 0\n", 8), "its header says 60 bytes, and it has 68");
}

TEST_F(FileCheck, UnitsOfOldProjectionFilesAreTaken) {
  for (const auto& [unit, metres] : std::initializer_list<std::pair<const char*, double>>{
           {"FEET", 0.3048}, {"METERS", 1}, {"NO", 1}, {"100", 0.01}}) {
    folder_.write("grid.prj",
                  std::string("Projection    UTM\nZone          32\nDatum         WGS84\nZunits    "
                              "    ") +
                      unit + "\nUnits         METERS\nSpheroid      WGS84\nParameters\n");
    EXPECT_FLOAT_EQ(elevation_of(text_grid("1 2 3\n4 5 100\n")).heights_m[5],
                    static_cast<float>(100 * metres))
        << unit;
  }
  folder_.write("grid.prj",
                std::string("Projection    UTM\nZone 32\nDatum WGS84\nZunits CUBITS\nUnits METERS\n"));
  expect_error(text_grid("1 2 3\n4 5 100\n"), "their unit 'cubits' is not known");
}

TEST_F(FileCheck, DepthsAreHeightsBelowZero) {
  const ReadElevation read = tiff("depth.tif", heights(hill), {}, {1024, 1, 3072, 32632, 4096, 5715});
  expect_warning(read, "counts depths");
  EXPECT_EQ(elevation_of(read).heights_m[1], -610);
}

TEST_F(FileCheck, HalfFloatsAreRead) {
  const std::vector<std::uint16_t> halves(kWidth * kHeight, 0x6000);  // 512
  const ReadElevation read = {folder_.write(
      "half.tif",
      TiffBuilder(kWidth, kHeight, 16, 3, std::string(bytes_of(halves))).pixel_scale(30, 30).bytes())};
  EXPECT_EQ(elevation_of(read).heights_m[0], 512);
}

TEST_F(FileCheck, ExtremesFarFromAllOthersAreTold) {
  const auto with = [](float value) {
    return heights([=](int x, int z) { return x + z == 0 ? value : hill(x, z); });
  };
  for (const float value : {-12345.0f, -500.0f, 5000.0f, 0.0f, -9998.0f, 32767.0f})
    expect_warning(tiff("far.tif", with(value)), "may mark voids");
  for (const float value : {500.0f, 800.0f})
    EXPECT_TRUE(elevation_of(tiff("near.tif", with(value))).warnings.empty());
  // A plateau above the sea.
  const auto low = heights([](int x, int z) { return x + z == 0 ? 0 : hill(x, z) - 540; });
  EXPECT_TRUE(elevation_of(tiff("sea.tif", low)).warnings.empty());
}

TEST_F(FileCheck, HeightsThatAreNoMetresAreTold) {
  const auto steps = [](float step) {
    return heights([=](int x, int z) { return step * static_cast<float>(x + z); });
  };
  expect_warning(tiff("relief.tif", steps(9000)), "more relief than any planet has");
  expect_warning(tiff("shades.tif", steps(0.1f)), "shades of a picture");
  ReadElevation scaled = tiff("shades.tif", steps(0.1f));
  scaled.z_scale = 100;
  EXPECT_TRUE(elevation_of(scaled).warnings.empty());
  const std::string said =
      "<GDALMetadata><Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">m</Item></GDALMetadata>";
  EXPECT_TRUE(elevation_of(tiff("beach.tif", steps(0.1f), said)).warnings.empty());
}

TEST_F(FileCheck, WhatMayBeDegreesIsTold) {
  const auto samples = heights(hill);
  const auto at = [&](double west, double north, double step) {
    return ReadElevation{
        folder_.write("place.tif", TiffBuilder(kWidth, kHeight, 32, 3, std::string(bytes_of(samples)))
                                       .pixel_scale(step, step)
                                       .doubles(33922, {0, 0, 0, west, north, 0})
                                       .bytes())};
  };
  expect_warning(at(-30, 20, 1), "taken for metres");
  EXPECT_TRUE(elevation_of(at(500, 20, 1)).warnings.empty());
}

TEST_F(FileCheck, PartsOfMosaicsAreWhatTheMosaicSays) {
  tiff("part.tif", heights(hill));
  EXPECT_TRUE(elevation_of(mosaic("Float32", "part.tif")).warnings.empty());
  expect_error(mosaic("Int16", "part.tif"),
               "its part 'part.tif' has samples of Float32, which are cut to Int16");
  expect_error(mosaic("Float32", "part.tif", "<Scale>0.5</Scale>"), "another scale or offset");
  expect_error(mosaic("Float32", "part.tif", "<UnitType>ft</UnitType>"), "another unit of heights");
  const auto item = [](const char* name, const char* role, const char* value) {
    return std::string("<GDALMetadata><Item name=\"") + name + "\" sample=\"0\" role=\"" + role + "\">" +
           value + "</Item></GDALMetadata>";
  };
  tiff("part.tif", heights(hill), item("OFFSET", "offset", "-500"));
  expect_error(mosaic("Float32", "part.tif"), "another scale or offset");
  EXPECT_EQ(elevation_of(mosaic("Float32", "part.tif", "<Offset>-500</Offset>")).heights_m[0], 100);
  tiff("part.tif", heights(hill), item("UNITTYPE", "unittype", "ft"));
  expect_error(mosaic("Float32", "part.tif"), "another unit of heights");
  TiffBuilder builder(kWidth, kHeight, 32, 3, std::string(bytes_of(heights(hill))));
  builder.pixel_scale(30, 30)
      .doubles(33922, {0, 0, 0, 500'000, 4'000'000, 0})
      .geo_keys({1024, 1, 3072, 32632});
  folder_.write("part.tif", builder.ascii(42113, "610").bytes());
  expect_error(mosaic("Float32", "part.tif"), "has voids, which the VRT takes for heights");
  EXPECT_EQ(elevation_of(mosaic("Float32", "part.tif", "<NoDataValue>610</NoDataValue>")).voids, 1u);
}

}  // namespace
}  // namespace karst::bake
