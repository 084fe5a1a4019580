// SPDX-License-Identifier: MIT
// Elevation files of every kind that is read, and every way in which one can be wrong.
#include "bake/elevation/elevation.h"

#include "bake/rasters/ground_size.h"
#include "tests/bake/bake_files.h"
#include "tests/support/process.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace karst::bake {
namespace {

constexpr int kWidth = 5, kHeight = 4;

std::vector<float> ramp() {
  std::vector<float> values(kWidth * kHeight);
  std::iota(values.begin(), values.end(), 100.0f);
  return values;
}

template <class T>
std::string ramp_bytes() {
  const std::vector<float> values = ramp();
  return std::string(bytes_of(std::vector<T>(values.begin(), values.end())));
}

std::string float_bytes(float odd_one) {
  std::vector<float> values = ramp();
  values[7] = odd_one;
  return std::string(bytes_of(values));
}

class ElevationTest : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    return folder_.write(name, bytes);
  }
  // Expects one line that begins with the file and mentions the words.
  void expect_error(const ReadElevation& read, const std::string& words) {
    const std::string message = error_of(read);
    EXPECT_NE(message.find(words), std::string::npos) << "got: " << message;
    EXPECT_EQ(message.rfind(folder_.path(""), 0), 0u) << "got: " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  void expect_ramp(const Elevation& e) {
    ASSERT_EQ(e.width, kWidth);
    ASSERT_EQ(e.height, kHeight);
    EXPECT_EQ(e.heights_m, ramp());
    EXPECT_EQ(e.voids, 0u);
  }

  test::Folder folder_;
};

TEST_F(ElevationTest, ReadsTiffOfEveryType) {
  for (const char* type : {"int16", "uint16", "float"}) {
    SCOPED_TRACE(type);
    const std::string path = folder_.path(std::string(type) + ".tif");
    write_image(path, kWidth, kHeight, ramp(), type);
    expect_ramp(elevation_of(ReadElevation{.path = path, .pixel_size_m = 2}));
  }
}

TEST_F(ElevationTest, ReadsTiledTiff) {
  const int side = 70;
  std::vector<float> values(side * side);
  std::iota(values.begin(), values.end(), -2000.0f);
  const std::string path = folder_.path("tiled.tif");
  write_image(path, side, side, values, "int16", 32);
  EXPECT_EQ((elevation_of(ReadElevation{.path = path, .pixel_size_m = 2}).heights_m), values);
}

TEST_F(ElevationTest, ReadsPngAndExr) {
  write_image(folder_.path("a.png"), kWidth, kHeight, ramp(), "uint16");
  write_image(folder_.path("h.exr"), kWidth, kHeight, ramp(), "half");
  write_image(folder_.path("f.exr"), kWidth, kHeight, ramp(), "float");
  for (const char* name : {"a.png", "h.exr", "f.exr"}) {
    SCOPED_TRACE(name);
    expect_ramp(elevation_of(ReadElevation{.path = folder_.path(name), .pixel_size_m = 2}));
  }
}

TEST_F(ElevationTest, GeoTiffInMetres) {
  const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>())
                                       .pixel_scale(30, 25)
                                       .tie_point(376313, 3807917)
                                       .geo_keys({1024, 1, 3072, 32611, 3076, 9001})
                                       .bytes());
  const Elevation e = elevation_of(ReadElevation{.path = path});
  expect_ramp(e);
  EXPECT_EQ(e.spacing_x_m, 30);
  EXPECT_EQ(e.spacing_z_m, 25);
}

TEST_F(ElevationTest, GeoTiffInFeet) {
  const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>())
                                       .pixel_scale(10, 10)
                                       .tie_point(376313, 3807917)
                                       .geo_keys({1024, 1, 3072, 32611, 3076, 9002, 4099, 9002})
                                       .bytes());
  const Elevation e = elevation_of(ReadElevation{.path = path});
  EXPECT_DOUBLE_EQ(e.spacing_x_m, 3.048);
  EXPECT_FLOAT_EQ(e.heights_m[0], 30.48f);
}

TEST_F(ElevationTest, GeoTiffInDegrees) {
  const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>())
                                       .pixel_scale(0.001, 0.002)
                                       .tie_point(138, 60.004)
                                       .geo_keys({1024, 2, 2054, 9102})
                                       .bytes());
  const Elevation e = elevation_of(ReadElevation{.path = path});
  // At 60 degrees a degree is 55.80 km by 111.41 km (WGS84).
  EXPECT_NEAR(e.spacing_x_m, 55.800, 0.005);
  EXPECT_NEAR(e.spacing_z_m, 222.825, 0.01);
}

TEST(MetresPerDegree, MatchesPublishedLengths) {
  // WGS84, in kilometres to the metre, as printed in tables of the length of a degree.
  const struct {
    double latitude, x_km, y_km;
  } rows[] = {{0, 111.320, 110.574}, {15, 107.550, 110.649}, {-30, 96.486, 110.852},
              {45, 78.847, 111.132}, {60, 55.800, 111.412},  {75, 28.902, 111.618}};
  for (const auto& row : rows) {
    EXPECT_NEAR(metres_per_degree(row.latitude).x, 1000 * row.x_km, 0.6) << row.latitude;
    EXPECT_NEAR(metres_per_degree(row.latitude).y, 1000 * row.y_km, 0.6) << row.latitude;
  }
}

TEST_F(ElevationTest, PixelSizeOverridesTheFile) {
  const auto path = write(
      "a.tif", TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>()).pixel_scale(30, 25).bytes());
  const Elevation e = elevation_of(ReadElevation{.path = path, .pixel_size_m = 7});
  EXPECT_EQ(e.spacing_x_m, 7);
  EXPECT_EQ(e.spacing_z_m, 7);
}

TEST_F(ElevationTest, ScaleAndCrop) {
  write_image(folder_.path("a.tif"), kWidth, kHeight, ramp(), "int16");
  ReadElevation read{.path = folder_.path("a.tif"), .pixel_size_m = 1, .z_scale = 0.5, .crop = {1, 2, 3, 2}};
  const Elevation e = elevation_of(read);
  EXPECT_EQ(e.width, 3);
  EXPECT_EQ(e.height, 2);
  EXPECT_EQ(e.heights_m, (std::vector<float>{55.5f, 56, 56.5f, 58, 58.5f, 59}));
  for (const auto& wrong :
       {std::array{3, 0, 3, 2}, {0, 3, 2, 2}, {0, 0, 1, 2}, {-1, 0, 2, 2}, {2, 2, 0x7fffffff, 2}}) {
    std::copy(wrong.begin(), wrong.end(), read.crop);
    expect_error(read, "--crop");
  }
}

TEST_F(ElevationTest, VoidsFromTagsSrtmAndArguments) {
  std::vector<std::int16_t> values(kWidth * kHeight, 5);
  values[3] = 32767;
  values[4] = -32768;
  values[8] = -9999;
  const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 16, 2, std::string(bytes_of(values)))
                                       .pixel_scale(1, 1)
                                       .ascii(42113, "32767 ")
                                       .bytes());
  const Elevation e = elevation_of(ReadElevation{.path = path, .nodata = {-9999}});
  EXPECT_EQ(e.voids, 3u);
  for (const std::size_t k : {3u, 4u, 8u}) EXPECT_EQ(e.valid[k], 0);
  EXPECT_EQ(e.valid[0], 1);
}

TEST_F(ElevationTest, FloatNodataIsComparedAsFloat) {
  const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 32, 3, float_bytes(-3.4028235e38f))
                                       .pixel_scale(1, 1)
                                       .ascii(42113, "-3.40282346638529e+38")
                                       .bytes());
  EXPECT_EQ((elevation_of(ReadElevation{.path = path}).voids), 1u);
}

TEST_F(ElevationTest, NanAndInfinityAreVoids) {
  for (const float odd : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    const auto path =
        write("a.tif", TiffBuilder(kWidth, kHeight, 32, 3, float_bytes(odd)).pixel_scale(1, 1).bytes());
    const Elevation e = elevation_of(ReadElevation{.path = path});
    EXPECT_EQ(e.voids, 1u);
    EXPECT_EQ(e.valid[7], 0);
  }
}

TEST_F(ElevationTest, RefusesHeightsThatAreNone) {
  const auto path =
      write("a.tif", TiffBuilder(kWidth, kHeight, 32, 3, float_bytes(1e9f)).pixel_scale(1, 1).bytes());
  expect_error({.path = path}, "column 2, row 1");
  expect_error({.path = path, .nodata = {-1}, .crop = {0, 0, 5, 2}}, "--nodata");
}

TEST_F(ElevationTest, RefusesAllVoid) {
  const std::vector<std::int16_t> values(kWidth * kHeight, -32768);
  const auto path = write(
      "a.tif", TiffBuilder(kWidth, kHeight, 16, 2, std::string(bytes_of(values))).pixel_scale(1, 1).bytes());
  expect_error({.path = path}, "no sample is valid");
}

TEST_F(ElevationTest, RefusesUnknownPixelSize) {
  write_image(folder_.path("a.tif"), kWidth, kHeight, ramp(), "int16");
  expect_error({.path = folder_.path("a.tif")}, "--pixel-size");
}

TEST_F(ElevationTest, RefusesAbsurdPixelScale) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double scale : {0.0, -30.0, 1e-9, 1e12, infinity, -infinity, std::nan("")}) {
    const auto path =
        write("a.tif",
              TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>()).pixel_scale(30, scale).bytes());
    expect_error({.path = path}, "pixel size");
  }
}

TEST_F(ElevationTest, RefusesGeographicThatCannotBeOnEarth) {
  const auto tiff = [&] {
    return TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>()).pixel_scale(1, 1);
  };
  const std::vector<std::uint16_t> degrees = {1024, 2, 2054, 9102};
  expect_error({.path = write("a.tif", tiff().geo_keys(degrees).bytes())}, "does not say where");
  expect_error({.path = write("b.tif", tiff().tie_point(0, 200).geo_keys(degrees).bytes())}, "latitude");
  // 20 radians.
  expect_error({.path = write("c.tif", tiff().tie_point(0, 20).geo_keys({1024, 2, 2054, 9101}).bytes())},
               "latitude");
  expect_error({.path = write("d.tif", tiff().geo_keys({1024, 1, 3076, 9999}).bytes())}, "--pixel-size");
  expect_error({.path = write("e.tif", tiff().geo_keys({1024, 1, 4099, 9999}).bytes())}, "--z-scale");
  expect_error({.path = write("f.tif", tiff().tie_point(0, 20).geo_keys({1024, 3, 2048, 4978}).bytes())},
               "geocentric");
}

TEST_F(ElevationTest, RefusesEightBitsUnlessAsked) {
  write_image(folder_.path("a.png"), kWidth, kHeight, ramp(), "uint8");
  write_image(folder_.path("a.tif"), kWidth, kHeight, ramp(), "uint8");
  for (const char* name : {"a.png", "a.tif"}) {
    ReadElevation read{.path = folder_.path(name), .pixel_size_m = 1};
    expect_error(read, "--allow-8bit");
    read.allow_8bit = true;
    expect_ramp(elevation_of(read));
  }
}

TEST_F(ElevationTest, ReadsSamplesOfEveryType) {
  const auto check = [&](int bits, int sample_format, const std::string& bytes, const char* kind) {
    SCOPED_TRACE(kind);
    const auto path =
        write("a.tif", TiffBuilder(kWidth, kHeight, bits, sample_format, bytes).pixel_scale(1, 1).bytes());
    const Elevation e = elevation_of(ReadElevation{.path = path});
    expect_ramp(e);
    EXPECT_EQ(e.source, std::string("GTiff ") + kind + ", no CRS: metres assumed");
  };
  check(64, 3, ramp_bytes<double>(), "Float64");
  check(32, 3, ramp_bytes<float>(), "Float32");
  check(32, 2, ramp_bytes<std::int32_t>(), "Int32");
  check(32, 1, ramp_bytes<std::uint32_t>(), "UInt32");
  check(16, 2, ramp_bytes<std::int16_t>(), "Int16");
  check(16, 1, ramp_bytes<std::uint16_t>(), "UInt16");
}

// 5 samples of 12 bits are 8 bytes a row.
TEST_F(ElevationTest, ReadsBitsThatAreNoBytes) {
  std::string rows;
  for (int k = 0; k < kHeight; ++k) {
    unsigned bits = 0, count = 0;
    for (int i = 0; i < kWidth; ++i) {
      bits = bits << 12 | static_cast<unsigned>(100 + k * kWidth + i);
      for (count += 12; count >= 8; count -= 8) rows += static_cast<char>(bits >> (count - 8) & 255);
    }
    rows += static_cast<char>(bits << (8 - count) & 255);
  }
  const auto tiff = [&](int bits, const std::string& bytes) {
    return write("a.tif", TiffBuilder(kWidth, kHeight, bits, 1, bytes).pixel_scale(1, 1).bytes());
  };
  expect_ramp(elevation_of(ReadElevation{.path = tiff(12, rows)}));
  expect_error({.path = tiff(4, std::string(3 * kHeight, '\1'))}, "--allow-8bit");
}

TEST_F(ElevationTest, ScaleAndOffsetOfSamplesAreTaken) {
  const auto heights = [&](const std::string& items, std::optional<double> z_scale) {
    const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 16, 1, ramp_bytes<std::uint16_t>())
                                         .pixel_scale(60, 60)
                                         .ascii(42112, "<GDALMetadata>" + items + "</GDALMetadata>")
                                         .ascii(42113, "103")
                                         .bytes());
    return elevation_of(ReadElevation{.path = path, .z_scale = z_scale});
  };
  const std::string scale = R"(<Item name="SCALE" sample="0" role="scale">0.05</Item>)";
  const std::string offset = R"(<Item name="OFFSET" sample="0" role="offset">-500</Item>)";
  EXPECT_FLOAT_EQ(heights(scale + offset, {}).heights_m[2], 102 * 0.05f - 500);
  EXPECT_FLOAT_EQ(heights(scale, {}).heights_m[2], 102 * 0.05f);
  EXPECT_FLOAT_EQ(heights(scale + offset, 2).heights_m[2], 2 * (102 * 0.05f - 500));
  EXPECT_EQ(heights(scale + offset, {}).valid[3], 0) << "nodata is of samples as they are in the file";
}

// A pixel of 60 m is 30 m of ground at 60 degrees: 111.32 km of equator a degree, and 55.80 km there.
TEST_F(ElevationTest, WebMercatorHasItsTrueSize) {
  const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>())
                                       .pixel_scale(60, 60)
                                       .tie_point(1'000'000, 8'399'738 + 120)
                                       .geo_keys({1024, 1, 3072, 3857, 3076, 9001})
                                       .bytes());
  const Elevation e = elevation_of(ReadElevation{.path = path});
  EXPECT_NEAR(e.spacing_x_m, 60 * 55.800 / 111.320, 0.01);
  EXPECT_NEAR(e.spacing_z_m, 60 * 111.412 / 222.640 * 1.0002, 0.02);  // half of a degree of latitude
  EXPECT_NE(e.source.find("true size"), std::string::npos) << e.source;
}

TEST_F(ElevationTest, EpsgsOwnDegreeIsOne) {
  const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>())
                                       .pixel_scale(0.001, 0.002)
                                       .tie_point(138, 60.004)
                                       .geo_keys({1024, 2, 2054, 9122})
                                       .bytes());
  EXPECT_NEAR(elevation_of(ReadElevation{.path = path}).spacing_x_m, 55.800, 0.005);
}

// A size on the command line turns no image.
TEST_F(ElevationTest, RowsAndColumnsAreTurnedToNorthAndWest) {
  const auto tiff = [&](std::vector<double> matrix) {
    matrix.resize(16);
    matrix[15] = 1;
    return write(
        "a.tif",
        TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>()).doubles(34264, matrix).bytes());
  };
  const std::vector<float> up = {115, 116, 117, 118, 119, 110, 111, 112, 113, 114,
                                 105, 106, 107, 108, 109, 100, 101, 102, 103, 104};
  std::vector<float> both = ramp();
  std::reverse(both.begin(), both.end());
  for (const double given : {0.0, 30.0}) {
    const auto heights = [&](double column, double row) {
      const Elevation e = elevation_of(
          ReadElevation{.path = tiff({column, 0, 0, 5000, 0, row, 0, 6000}), .pixel_size_m = given});
      EXPECT_EQ(e.spacing_x_m, 30);
      EXPECT_EQ(e.spacing_z_m, 30);
      return e.heights_m;
    };
    EXPECT_EQ(heights(30, -30), ramp());
    EXPECT_EQ(heights(30, 30), up);
    EXPECT_EQ(heights(-30, 30), both);
    expect_error({.path = tiff({0, 30, 0, 5000, 30, 0, 0, 6000}), .pixel_size_m = given}, "gdalwarp");
    expect_error({.path = tiff({30, 9, 0, 5000, 9, -30, 0, 6000}), .pixel_size_m = given}, "gdalwarp");
  }
  // Columns and rows of a crop are counted from the north-west.
  const ReadElevation crop{.path = tiff({30, 0, 0, 5000, 0, 30, 0, 6000}), .crop = {1, 0, 3, 2}};
  EXPECT_EQ(elevation_of(crop).heights_m, (std::vector<float>{116, 117, 118, 111, 112, 113}));
}

TEST_F(ElevationTest, RefusesUnitsThatNobodySays) {
  const auto tiff = [&](std::vector<std::uint16_t> keys) {
    return TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>())
        .pixel_scale(30, 30)
        .geo_keys(keys)
        .bytes();
  };
  // California zone 3 is in feet; UTM in metres, whatever the zone; a system that nobody knows.
  const auto feet = write("f.tif", tiff({1024, 1, 3072, 2227, 4099, 9001}));
  EXPECT_NEAR(elevation_of(ReadElevation{.path = feet}).spacing_x_m, 30 * 1200.0 / 3937, 1e-9);
  EXPECT_EQ(elevation_of(ReadElevation{.path = feet, .pixel_size_m = 9}).spacing_x_m, 9);
  const auto utm = write("u.tif", tiff({1024, 1, 3072, 32611}));
  EXPECT_EQ(elevation_of(ReadElevation{.path = utm}).spacing_x_m, 30);
  const auto nobody = write("n.tif", tiff({1024, 1, 3072, 19999}));
  expect_error({.path = nobody}, "--pixel-size");
  EXPECT_EQ(elevation_of(ReadElevation{.path = nobody, .pixel_size_m = 9, .z_scale = 1}).spacing_x_m, 9);
  // A unit of a projection that has no name and no parameters.
  expect_error({.path = write("n.tif", tiff({1024, 1, 3072, 32767, 3076, 9002}))}, "--pixel-size");
  // NAVD88 in US survey feet, NAVD88 in metres, and a system that is not known.
  const auto height = [&](std::uint16_t system, std::optional<double> z_scale) {
    return elevation_of(ReadElevation{.path = write("v.tif", tiff({1024, 1, 3072, 32611, 4096, system})),
                                      .z_scale = z_scale})
        .heights_m[1];
  };
  EXPECT_NEAR(height(6360, {}), height(5703, {}) * 1200 / 3937, 1e-6);
  EXPECT_NEAR(height(8228, {}), height(5703, {}) * 0.3048, 1e-5);
  expect_error({.path = write("v.tif", tiff({1024, 1, 3072, 32611, 4096, 9999}))}, "--z-scale");
  EXPECT_NEAR(height(9999, 2), 2 * height(5703, {}), 1e-6);
}

// Heights that nothing says the unit of may be in the feet of the axes.
TEST_F(ElevationTest, FeetOfTheAxesAloneAreTold) {
  const auto warnings = [&](std::vector<std::uint16_t> keys, std::optional<double> z_scale) {
    const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>())
                                         .pixel_scale(30, 30)
                                         .tie_point(6'000'000, 2'000'000)
                                         .geo_keys(keys)
                                         .bytes());
    return elevation_of(ReadElevation{.path = path, .z_scale = z_scale}).warnings;
  };
  ASSERT_EQ(warnings({1024, 1, 3072, 2227}, {}).size(), 1u);
  EXPECT_NE(warnings({1024, 1, 3072, 2227}, {})[0].find("--z-scale 0.3048"), std::string::npos);
  EXPECT_TRUE(warnings({1024, 1, 3072, 2227}, 0.3048).empty());
  EXPECT_TRUE(warnings({1024, 1, 3072, 2227, 4096, 6360}, {}).empty());
  EXPECT_TRUE(warnings({1024, 1, 3072, 32611}, {}).empty());
}

TEST_F(ElevationTest, RefusesDegreesOfNoSystem) {
  const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>())
                                       .pixel_scale(0.0003, 0.0003)
                                       .tie_point(-122, 47)
                                       .bytes());
  expect_error({.path = path}, "degrees; give --pixel-size");
  expect_ramp(elevation_of(ReadElevation{.path = path, .pixel_size_m = 2}));
}

TEST_F(ElevationTest, ACropHasTheSizeOfItsOwnLatitude) {
  // Rows of a degree from 62 to 58 north; the crop's middle is at 61.
  const auto path = write("a.tif", TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>())
                                       .pixel_scale(1, 1)
                                       .tie_point(10, 62)
                                       .geo_keys({1024, 2, 2054, 9102})
                                       .bytes());
  EXPECT_NEAR(elevation_of(ReadElevation{.path = path}).spacing_x_m, metres_per_degree(60).x, 0.01);
  const Elevation crop = elevation_of(ReadElevation{.path = path, .crop = {0, 0, 5, 2}});
  EXPECT_NEAR(crop.spacing_x_m, metres_per_degree(61).x, 0.01);
  EXPECT_NEAR(crop.spacing_z_m, metres_per_degree(61).y, 0.01);
}

TEST_F(ElevationTest, RefusesTilesThatTheFileCannotHold) {
  const auto path = write("a.tif", TiffBuilder(4096, 4096, 32, 3, ramp_bytes<float>())
                                       .compressed()
                                       .shorts(322, {4096})
                                       .shorts(323, {4096})
                                       .shorts(324, {8})
                                       .shorts(325, {80})
                                       .pixel_scale(1, 1)
                                       .bytes());
  expect_error({.path = path}, "blocks: one is 4096 x 4096");
}

TEST_F(ElevationTest, BandsAreChosenByTheUser) {
  std::vector<float> samples;
  for (int k = 0; k < kWidth * kHeight; ++k) {
    for (const int band : {0, 500, 900}) samples.push_back(static_cast<float>(100 + band + k));
  }
  const std::string path = folder_.path("a.png");
  write_image(path, kWidth, kHeight, samples, "uint16", 0, 3);
  expect_error({.path = path, .pixel_size_m = 1}, "bands: 3; --band N");
  EXPECT_EQ(elevation_of(ReadElevation{.path = path, .pixel_size_m = 1, .band = 2}).heights_m[3], 603);
  EXPECT_EQ(elevation_of(ReadElevation{.path = path, .pixel_size_m = 1, .band = 3}).heights_m[3], 1003);
  expect_error({.path = path, .pixel_size_m = 1, .band = 4}, "--band: the raster has 3");
  write_image(folder_.path("a.exr"), kWidth, kHeight, samples, "half", 0, 3);
  expect_error({.path = folder_.path("a.exr"), .pixel_size_m = 1}, "bands");
}

TEST_F(ElevationTest, RefusesHostileSizes) {
  const std::string pixels = ramp_bytes<std::int16_t>();
  const std::uint32_t two31 = 0x80000000u;
  for (const auto& [width, height] : {std::pair{two31, two31},
                                      {two31, 1u},
                                      {2u, two31},
                                      {0xffffffffu, 0xffffffffu},
                                      {0u, 0u},
                                      {1u, 5u},
                                      {40'000u, 10u},
                                      {32'768u, 32'768u},
                                      {0x7fffffffu, 2u}}) {
    SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
    const auto path = write("a.tif", TiffBuilder(width, height, 16, 2, pixels).pixel_scale(1, 1).bytes());
    EXPECT_NE(error_of({.path = path}), "");
  }
}

TEST_F(ElevationTest, RefusesHostilePngAndExrSizes) {
  const IgnoreLeaks libraries_leak;
  // Width and height of a PNG are big-endian at byte 16; its header's checksum is then wrong, which is an
  // error too.
  write_image(folder_.path("a.png"), kWidth, kHeight, ramp(), "uint16");
  std::string png = test::read_text(folder_.path("a.png"));
  png.replace(16, 8, std::string("\x7f\xff\xff\xff\x7f\xff\xff\xff", 8));
  EXPECT_NE(error_of({.path = write("b.png", png), .pixel_size_m = 1}), "");

  write_image(folder_.path("a.exr"), kWidth, kHeight, ramp(), "float");
  const std::string exr = test::read_text(folder_.path("a.exr"));
  const std::size_t box = exr.find("box2i", exr.find("dataWindow")) + 6 + 4;
  for (const std::string& corner : {std::string("\xff\xff\xff\x7f\xff\xff\xff\x7f", 8),
                                    std::string("\x00\x00\x10\x00\x00\x00\x10\x00", 8),
                                    std::string("\xff\xff\xff\xff\xff\xff\xff\xff", 8)}) {
    std::string hostile = exr;
    hostile.replace(box + 8, 8, corner);
    EXPECT_NE(error_of({.path = write("b.exr", hostile), .pixel_size_m = 1}), "");
  }
}

TEST_F(ElevationTest, RefusesEveryTruncation) {
  const IgnoreLeaks libraries_leak;
  write_image(folder_.path("a.tif"), kWidth, kHeight, ramp(), "int16");
  write_image(folder_.path("a.png"), kWidth, kHeight, ramp(), "uint16");
  write_image(folder_.path("a.exr"), kWidth, kHeight, ramp(), "half");
  for (const char* name : {"a.tif", "a.png", "a.exr"}) {
    const std::string whole = test::read_text(folder_.path(name));
    // The last chunk of a PNG (12 bytes, IEND) holds no pixel: without it the image is still complete.
    const std::size_t end = std::string(name) == "a.png" ? whole.size() - 12 - 4 : whole.size();
    for (std::size_t size = 0; size < end; size += 3) {
      SCOPED_TRACE(std::string(name) + " cut to " + std::to_string(size) + " of " +
                   std::to_string(whole.size()));
      EXPECT_NE(
          error_of({.path = write(std::string("cut_") + name, whole.substr(0, size)), .pixel_size_m = 1}),
          "");
    }
  }
}

TEST_F(ElevationTest, RefusesLostTags) {
  // All pixels are there, but the values of the tags behind them are cut off.
  const std::string whole = TiffBuilder(kWidth, kHeight, 16, 2, ramp_bytes<std::int16_t>())
                                .pixel_scale(30, 30)
                                .ascii(42113, "-9999" + std::string(50, ' '))
                                .bytes();
  for (const std::size_t lost : {1u, 20u, 57u, 70u}) {
    expect_error({.path = write("cut.tif", whole.substr(0, whole.size() - lost))}, "truncated");
  }
}

TEST_F(ElevationTest, SurvivesFlippedBytes) {
  const IgnoreLeaks libraries_leak;
  write_image(folder_.path("a.tif"), kWidth, kHeight, ramp(), "int16");
  write_image(folder_.path("a.png"), kWidth, kHeight, ramp(), "uint16");
  write_image(folder_.path("a.exr"), kWidth, kHeight, ramp(), "half");
  std::uint32_t state = 1;
  for (const char* name : {"a.tif", "a.png", "a.exr"}) {
    const std::string whole = test::read_text(folder_.path(name));
    for (int k = 0; k < 200; ++k) {
      std::string damaged = whole;
      for (int n = 0; n < 1 + k % 3; ++n) {
        state = state * 1664525u + 1013904223u;
        damaged[(state >> 8) % damaged.size()] = static_cast<char>(state >> 24);
      }
      (void)error_of(
          {.path = write(std::string("odd_") + name, damaged), .pixel_size_m = 1});  // must not crash
    }
  }
}

TEST_F(ElevationTest, RefusesWhatIsNotElevation) {
  expect_error({.path = folder_.path("missing.tif")}, "No such file");
  expect_error({.path = write("text.tif", "hello, this is no image")}, "not a raster");
  expect_error({.path = write("empty.tif", "")}, "empty");
  expect_error({.path = folder_.path("")}, "Is a directory");
  const std::string closed = write("closed.tif", ramp_bytes<float>());
  ASSERT_EQ(chmod(closed.c_str(), 0), 0);
  if (access(closed.c_str(), R_OK) != 0) expect_error({.path = closed}, "Permission denied");
}

class EnviTest : public ElevationTest {
 protected:
  std::string write_envi(const std::string& header, const std::string& bytes) {
    write("dem.hdr", header);
    return write("dem.bil", bytes);
  }
  static std::string header(const std::string& type, const std::string& more = "") {
    return "ENVI\ndescription = {\n  made for a test }\nsamples = 5\nlines   = 4\nbands   = 1\nheader offset "
           "= 0\n"
           "file type = ENVI Standard\ndata type = " +
           type +
           "\ninterleave = bil\nbyte order = 0\n"
           "map info = {UTM, 1.000, 1.000, 376313.6, 3807917.8, 30.0, 20.0, 11, North, WGS-84, "
           "units=Meters}\n" +
           more;
  }
};

TEST_F(EnviTest, ReadsEveryType) {
  const auto read = [&](const std::string& type, const std::string& bytes) {
    const Elevation e =
        elevation_of(ReadElevation{.path = write_envi(header(type), bytes), .allow_8bit = true});
    expect_ramp(e);
    EXPECT_EQ(e.spacing_x_m, 30);
    EXPECT_EQ(e.spacing_z_m, 20);
  };
  read("1", ramp_bytes<std::uint8_t>());
  read("2", ramp_bytes<std::int16_t>());
  read("4", ramp_bytes<float>());
  read("12", ramp_bytes<std::uint16_t>());
}

TEST_F(EnviTest, BigEndianOffsetNodataAndTheOtherHeaderName) {
  std::string bytes = ramp_bytes<std::int16_t>();
  for (std::size_t k = 0; k < bytes.size(); k += 2) std::swap(bytes[k], bytes[k + 1]);
  std::string text = header("2", "data ignore value = 103\n");
  text.replace(text.find("byte order = 0"), 14, "byte order = 1");
  text.replace(text.find("header offset = 0"), 17, "header offset = 3");
  write("other.raw.hdr", text);
  const Elevation e = elevation_of(ReadElevation{.path = write("other.raw", "abc" + bytes)});
  EXPECT_EQ(e.voids, 1u);
  EXPECT_EQ(e.valid[3], 0);
  EXPECT_EQ(e.heights_m[4], 104);
}

TEST_F(EnviTest, Degrees) {
  std::string text = header("2");
  const std::size_t at = text.find("map info");
  text.replace(at, text.find('\n', at) - at,
               "map info = {Geographic Lat/Lon, 1, 1, 138, 60.004, 0.001, 0.002, WGS-84, units=Degrees}");
  const Elevation e = elevation_of(ReadElevation{.path = write_envi(text, ramp_bytes<std::int16_t>())});
  EXPECT_NEAR(e.spacing_x_m, 55.800, 0.005);
  EXPECT_NEAR(e.spacing_z_m, 222.825, 0.01);
}

TEST_F(EnviTest, RefusesBadHeaders) {
  const std::string good = header("2");
  const auto expect = [&](const std::string& from, const std::string& to, const std::string& words) {
    SCOPED_TRACE(to);
    std::string text = good;
    ASSERT_NE(text.find(from), std::string::npos);
    text.replace(text.find(from), from.size(), to);
    expect_error({.path = write_envi(text, ramp_bytes<std::int16_t>())}, words);
  };
  expect("ENVI\n", "ENVY\n", "not a raster");
  expect("samples = 5", "samples = 2147483648", "dimensions");
  expect("samples = 5", "samples = -5", "dimensions");
  expect("samples = 5", "samples = 99999999999999999999", "dimensions");
  expect("samples = 5\n", "", "dimensions");
  expect("lines   = 4", "lines = 0", "dimensions");
  expect("samples = 5\nlines   = 4", "samples = 32768\nlines = 32768", "too small");
  expect("lines   = 4", "lines = 5", "truncated");
  expect("bands   = 1", "bands = 3", "bands");
  expect("data type = 2", "data type = 6", "sample type");
  expect("data type = 2", "data type = 1", "--allow-8bit");
  expect("byte order = 0", "byte order = 2", "byte order");
  expect("byte order = 0\n", "", "byte order");
  expect("header offset = 0", "header offset = 4294967296", "header offset");
  expect("30.0, 20.0", "0, 20.0", "pixel size");
  expect("30.0, 20.0", "nan, 20.0", "pixel size");
  expect("30.0, 20.0", "1e300, 20.0", "pixel size");
  expect("30.0, 20.0", "a, 20.0", "pixel size");
  expect("units=Meters", "units=Cubits", "units");
  expect("byte order = 0", "byte order", "byte order");
}

// With one band, all orders of samples are the same bytes, and a word twice says the same twice.
TEST_F(EnviTest, WhatMakesNoDifferenceIsRead) {
  for (const auto& [from, to] : {std::pair{"interleave = bil", "interleave = zip"},
                                 {"samples = 5", "samples = 5\nsamples = 5"},
                                 {"units=Meters}", "units=Feet}"}}) {
    std::string text = header("2");
    text.replace(text.find(from), std::string(from).size(), to);
    const Elevation e = elevation_of(ReadElevation{.path = write_envi(text, ramp_bytes<std::int16_t>())});
    expect_ramp(e);
    EXPECT_NEAR(e.spacing_x_m, std::string(to) == "units=Feet}" ? 30 * 0.3048 : 30, 1e-9);
  }
}

TEST_F(EnviTest, EsrisHeadersAreRead) {
  const std::string esri =
      "BYTEORDER I\nLAYOUT BIL\nNROWS 4\nNCOLS 5\nNBANDS 1\nNBITS 16\nPIXELTYPE SIGNEDINT\n"
      "ULXMAP 35.4\nULYMAP 60.0\nXDIM 0.001\nYDIM 0.002\nNODATA 103\n";
  const std::string path = write_envi(esri, ramp_bytes<std::int16_t>());
  const Elevation e = elevation_of(ReadElevation{.path = path});
  EXPECT_EQ(e.voids, 1u);
  EXPECT_EQ(e.heights_m[4], 104);
  EXPECT_NEAR(e.spacing_x_m, 55.800, 0.01);
  EXPECT_NE(e.source.find("degrees assumed"), std::string::npos) << e.source;
  write_envi(esri, ramp_bytes<std::int16_t>().substr(0, 36));
  expect_error({.path = path}, "truncated");
}

}  // namespace
}  // namespace karst::bake
