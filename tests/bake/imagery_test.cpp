// SPDX-License-Identifier: MIT
// Images over a ground, from the file that GDAL reads to the tiles of a world: where each texel lies, what
// the tiles of all sizes have in common, and what is refused.
#include "bake/imagery/image_texels.h"
#include "etc2/etc2.h"
#include "terrain/base/checksum.h"
#include "terrain/file/world_reader.h"
#include "terrain/imagery/image_tile.h"
#include "tests/support/process.h"

#include <cpl_conv.h>
#include <gdal.h>
#include <gdal_frmts.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace karst::bake {
namespace {

// The DEM: samples of 30 m in UTM 11N, its north-west corner at kWest, kNorth.
constexpr int kWide = 101, kDeep = 81;
constexpr double kStep = 30, kWest = 500'000, kNorth = 3'800'000;
constexpr int kUtm = 32611, kDegrees = 4326;

using Colour = std::array<double, 3>;
using Picture = std::function<Colour(double x, double y)>;  // by coordinates

// Waves of 10 samples, steep enough that a tenth of a sample shows, and a long one. 0..255.
Colour waves(double x, double y) {
  const double i = (x - kWest) / kStep, k = (kNorth - y) / kStep;
  constexpr double kTurn = 6.283185307179586;
  return {128 + 100 * std::sin(kTurn * i / 10), 128 + 100 * std::sin(kTurn * k / 10),
          128 + 100 * std::cos(kTurn * (i + k) / 60)};
}

struct Shape {
  int width = 404, height = 324;  // pixels
  // GDAL's six numbers: 4 pixels a sample over all of the DEM.
  std::array<double, 6> place{kWest, kStep / 4, 0, kNorth, 0, -kStep / 4};
  int epsg = kUtm;  // 0: none
  bool placed = true;
  GDALDataType type = GDT_Byte;
  int bands = 3;
};

OGRSpatialReferenceH system_of(int epsg) {
  OGRSpatialReferenceH srs = OSRNewSpatialReference(nullptr);
  EXPECT_EQ(OSRImportFromEPSG(srs, epsg), OGRERR_NONE);
  OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
  return srs;
}

// picture: by coordinates of kUtm, whatever the image's system.
void write_image(const std::string& path, const Shape& shape, const Picture& picture) {
  GDALRegister_GTiff();
  GDALDatasetH file = GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), shape.width, shape.height,
                                 shape.bands, shape.type, nullptr);
  ASSERT_NE(file, nullptr);
  if (shape.placed) {
    std::array<double, 6> place = shape.place;
    EXPECT_EQ(GDALSetGeoTransform(file, place.data()), CE_None);
  }
  OGRCoordinateTransformationH way = nullptr;
  if (shape.epsg != 0) {
    OGRSpatialReferenceH own = system_of(shape.epsg), utm = system_of(kUtm);
    EXPECT_EQ(GDALSetSpatialRef(file, own), CE_None);
    way = OCTNewCoordinateTransformation(own, utm);
    OSRRelease(own);
    OSRRelease(utm);
  }
  std::vector<std::uint8_t> row(static_cast<std::size_t>(shape.width * shape.bands));
  for (int k = 0; k < shape.height; ++k) {
    for (int i = 0; i < shape.width; ++i) {
      const std::array<double, 6>& p = shape.place;
      double x = p[0] + p[1] * (i + 0.5) + p[2] * (k + 0.5);
      double y = p[3] + p[4] * (i + 0.5) + p[5] * (k + 0.5);
      if (way != nullptr && shape.epsg != kUtm) OCTTransform(way, 1, &x, &y, nullptr);
      const Colour colour = picture(x, y);
      for (int c = 0; c < shape.bands; ++c)
        row[static_cast<std::size_t>(i * shape.bands + c)] =
            static_cast<std::uint8_t>(std::lround(colour[static_cast<std::size_t>(c % 3)]));
    }
    EXPECT_EQ(GDALDatasetRasterIO(file, GF_Write, 0, k, shape.width, 1, row.data(), shape.width, 1, GDT_Byte,
                                  shape.bands, nullptr, shape.bands, shape.bands * shape.width, 1),
              CE_None);
  }
  if (way != nullptr) OCTDestroyCoordinateTransformation(way);
  GDALClose(file);
}

// A world, and the tiles of its imagery.
struct World {
  std::vector<std::byte> file;
  core::WorldReader reader;
  struct Tile {
    ImageChildren children;
    std::vector<std::byte> texels;  // both levels as the file has them
  };
  std::map<std::tuple<int, int, int>, Tile> tiles;

  void open(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    const std::vector<char> text{std::istreambuf_iterator<char>(in), {}};
    const auto bytes = std::as_bytes(std::span(text));
    file.assign(bytes.begin(), bytes.end());
    const Status status = reader.open(ByteSource::of(file));
    ASSERT_TRUE(status.ok()) << status.what();
    ASSERT_TRUE(reader.verify().ok());
    ASSERT_TRUE(reader.imagery().exists());
    walk({image_top_size(reader.ground()), 0, 0}, reader.root_image());
  }
  void walk(NodeKey key, const TilePlace& place) {
    std::vector<std::byte> bytes(place.bytes);
    ASSERT_TRUE(reader.read_tile(place, bytes).ok());
    Tile tile;
    const Status status =
        check_image_tile(reader.ground(), reader.imagery(), key, place, bytes, tile.children);
    ASSERT_TRUE(status.ok()) << status.what();
    tile.texels.assign(bytes.begin() + kImageHeadBytes, bytes.end());
    const ImageChildren children = tile.children;
    tiles[{key.size, key.x, key.z}] = std::move(tile);
    for (int q = 0; q < 4; ++q) {
      if (children.places[q].exists()) walk(key.child(q), children.places[q]);
    }
  }
  const Tile* find(int size, int x, int z) const {
    const auto at = tiles.find({size, x, z});
    return at == tiles.end() ? nullptr : &at->second;
  }
};

int texel(const std::vector<std::byte>& texels, int side, int x, int y, int channel) {
  return std::to_integer<int>(texels[static_cast<std::size_t>(4 * (y * side + x) + channel)]);
}

class ImageryOfAWorld : public testing::Test {
 protected:
  void SetUp() override {
    GDALRegister_GTiff();
    std::vector<std::int16_t> heights(kWide * kDeep);
    for (int n = 0; n < kWide * kDeep; ++n)
      heights[static_cast<std::size_t>(n)] = static_cast<std::int16_t>(500 + 40 * std::sin(n / 19.0));
    GDALDatasetH file = GDALCreate(GDALGetDriverByName("GTiff"), folder_.path("dem.tif").c_str(), kWide,
                                   kDeep, 1, GDT_Int16, nullptr);
    double place[6] = {kWest, kStep, 0, kNorth, 0, -kStep};
    GDALSetGeoTransform(file, place);
    OGRSpatialReferenceH srs = system_of(kUtm);
    GDALSetSpatialRef(file, srs);
    OSRRelease(srs);
    EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(file, 1), GF_Write, 0, 0, kWide, kDeep, heights.data(), kWide,
                           kDeep, GDT_Int16, 0, 0),
              CE_None);
    GDALClose(file);
  }
  test::ProcessResult bake(std::string images, std::vector<std::string> more = {}) {
    std::vector<std::string> words{folder_.path("dem.tif"), "--ground", "--materials",    "none", "--imagery",
                                   std::move(images),       "-o",       folder_.path("w")};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_process(KARST_BAKE_PATH, words);
  }
  void made(World& world, const std::string& images, std::vector<std::string> more = {}) {
    const test::ProcessResult result = bake(images, std::move(more));
    ASSERT_EQ(result.code, 0) << result.err;
    report_ = result.out;
    world.open(folder_.path("w"));
  }
  void refused(const std::string& images, const std::string& words) {
    const test::ProcessResult result = bake(images);
    EXPECT_EQ(result.code, 1);
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  }

  // Most that any covered texel of the least size is off the picture, over all of the DEM; and how many are
  // covered.
  double most_off(const World& world, const Picture& picture, int& covered) {
    const int size = world.reader.imagery().least_size;
    const double texel_samples = std::ldexp(1.0, size) / kTexelsPerSample;
    double most = 0;
    covered = 0;
    for (const auto& [key, tile] : world.tiles) {
      if (std::get<0>(key) != size) continue;
      for (int y = 0; y < kImageSide; ++y) {
        for (int x = 0; x < kImageSide; ++x) {
          // Samples from the middle of the first one.
          const double i = (std::get<1>(key) * kImageInside + x - kImageBorder + 0.5) * texel_samples;
          const double k = (std::get<2>(key) * kImageInside + y - kImageBorder + 0.5) * texel_samples;
          if (i < 0 || k < 0 || i > kWide - 1 || k > kDeep - 1) continue;
          if (texel(tile.texels, kImageSide, x, y, 3) < 255) continue;
          ++covered;
          const Colour expected = picture(kWest + (i + 0.5) * kStep, kNorth - (k + 0.5) * kStep);
          for (int c = 0; c < 3; ++c) {
            const double off =
                texel(tile.texels, kImageSide, x, y, c) - expected[static_cast<std::size_t>(c)];
            most = std::max(most, std::abs(off));
          }
        }
      }
    }
    return most;
  }

  test::Folder folder_;
  std::string report_;
};

// A wave is 16 a pixel at most, so that a quarter of one is 4.
TEST_F(ImageryOfAWorld, HasEachTexelWhereTheImageHasIt) {
  write_image(folder_.path("i.tif"), {}, waves);
  World world;
  made(world, folder_.path("i.tif"), {"--image-format", "rgba8"});
  EXPECT_EQ(world.reader.imagery().format, ImageFormat::rgba8);
  // 4 pixels a sample, 60 / 2^4 = 3.75 texels.
  EXPECT_EQ(world.reader.imagery().least_size, 4);
  int covered = 0;
  EXPECT_LE(most_off(world, waves, covered), 3.0);
  EXPECT_GT(covered, 3 * kWide * 3 * kDeep);
}

// By longitude and latitude, all around: no texel beside the date line is left out, on either side of it.
TEST_F(ImageryOfAWorld, GoesOnceAroundAPlanet) {
  constexpr int kAround = 72;  // samples of 5 degrees
  constexpr double kStepDeg = 5;
  GDALDatasetH dem = GDALCreate(GDALGetDriverByName("GTiff"), folder_.path("dem.tif").c_str(), kAround,
                                kAround / 2, 1, GDT_Int16, nullptr);
  double place[6] = {-180, kStepDeg, 0, 90, 0, -kStepDeg};
  GDALSetGeoTransform(dem, place);
  OGRSpatialReferenceH srs = system_of(kDegrees);
  GDALSetSpatialRef(dem, srs);
  GDALClose(dem);
  // 16 pixels a sample, so that there are tiles of two sizes.
  constexpr int kFiner = 16, kPixels = kFiner * kAround;
  const auto picture = [](double longitude, double latitude) -> Colour {
    const double turn = longitude * 0.017453292519943295;
    return {128 + 100 * std::sin(turn), 128 + 100 * std::cos(turn), 128 + latitude};
  };
  GDALDatasetH image = GDALCreate(GDALGetDriverByName("GTiff"), folder_.path("i.tif").c_str(), kPixels,
                                  kPixels / 2, 3, GDT_Byte, nullptr);
  double image_place[6] = {-180, kStepDeg / kFiner, 0, 90, 0, -kStepDeg / kFiner};
  GDALSetGeoTransform(image, image_place);
  GDALSetSpatialRef(image, srs);
  OSRRelease(srs);
  std::vector<std::uint8_t> row(3 * kPixels);
  for (int k = 0; k < kPixels / 2; ++k) {
    for (int i = 0; i < kPixels; ++i) {
      const Colour colour = picture(-180 + (i + 0.5) * kStepDeg / kFiner, 90 - (k + 0.5) * kStepDeg / kFiner);
      for (std::size_t c = 0; c < 3; ++c)
        row[static_cast<std::size_t>(3 * i) + c] = static_cast<std::uint8_t>(std::lround(colour[c]));
    }
    EXPECT_EQ(GDALDatasetRasterIO(image, GF_Write, 0, k, kPixels, 1, row.data(), kPixels, 1, GDT_Byte, 3,
                                  nullptr, 3, 3 * kPixels, 1),
              CE_None);
  }
  GDALClose(image);

  World world;
  made(world, folder_.path("i.tif"), {"--basis", "geographic", "--image-format", "rgba8"});
  ASSERT_TRUE(world.reader.ground().closes());
  const int size = world.reader.imagery().least_size;
  const double texel_samples = std::ldexp(1.0, size) / kTexelsPerSample;
  int compared = 0;
  for (const auto& [key, tile] : world.tiles) {
    if (std::get<0>(key) != size) continue;
    for (int y = 0; y < kImageSide; ++y) {
      for (int x = 0; x < kImageSide; ++x) {
        const double i = (std::get<1>(key) * kImageInside + x - kImageBorder + 0.5) * texel_samples;
        const double k = (std::get<2>(key) * kImageInside + y - kImageBorder + 0.5) * texel_samples;
        // All that is drawn, and a border: columns 0 to 72, of which the last lies on the first.
        if (i < -0.1 || i > kAround + 0.1 || k < 0 || k > kAround / 2 - 1) continue;
        ASSERT_EQ(texel(tile.texels, kImageSide, x, y, 3), 255) << i << " " << k;
        const Colour expected = picture(-180 + (i + 0.5) * kStepDeg, 90 - (k + 0.5) * kStepDeg);
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(texel(tile.texels, kImageSide, x, y, c), expected[static_cast<std::size_t>(c)], 3)
              << i << " " << k;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 3 * kAround * 3 * kAround / 2);

  // On a cube every face has it, and at its edges nothing is left out either.
  World cube;
  made(cube, folder_.path("i.tif"), {"--basis", "cube", "--image-format", "rgba8"});
  const GroundInfo& info = cube.reader.ground();
  ASSERT_TRUE(info.is_cube());
  ASSERT_LT(cube.reader.imagery().least_size, info.top_size());
  const int finest = cube.reader.imagery().least_size;
  const double side = std::ldexp(1.0, finest) / kTexelsPerSample;
  std::array<int, kCubeFaces> faces{};
  for (const auto& [key, tile] : cube.tiles) {
    const auto [tile_size, tile_x, tile_z] = key;
    const int below = info.top_size() - tile_size;
    if (below < 0) continue;
    const int face = cube_face(tile_x >> below, tile_z >> below);
    ASSERT_GE(face, 0);
    for (int y = 0; y < kImageSide; ++y) {
      for (int x = 0; x < kImageSide; ++x) {
        ASSERT_EQ(texel(tile.texels, kImageSide, x, y, 3), 255) << tile_size << " " << x << " " << y;
        if (tile_size != finest) continue;
        const double i = (tile_x * kImageInside + x - kImageBorder + 0.5) * side;
        const double k = (tile_z * kImageInside + y - kImageBorder + 0.5) * side;
        Geodetic at;
        ASSERT_TRUE(geodetic_of(info.basis, place_m(info.basis, {i, k, 0, face}), at));
        // Beside the poles a texel has many longitudes.
        if (std::abs(at.latitude_deg) > 75) continue;
        const Colour expected = picture(at.longitude_deg, at.latitude_deg);
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(texel(tile.texels, kImageSide, x, y, c), expected[static_cast<std::size_t>(c)], 4)
              << at.longitude_deg << " " << at.latitude_deg;
        ++faces[static_cast<std::size_t>(face)];
      }
    }
  }
  for (const int count : faces) EXPECT_GT(count, 1'000);
}

TEST_F(ImageryOfAWorld, IsWarpedFromOtherSystemsOfCoordinates) {
  Shape shape;
  shape.epsg = kDegrees;
  shape.width = shape.height = 500;
  // 500 000, 3 800 000 is at 117 W, 34.34 N; the DEM reaches 3 km east and 2.4 km south of it.
  shape.place = {-117.001, 0.036 / 500, 0, 34.343, 0, -0.026 / 500};
  write_image(folder_.path("i.tif"), shape, waves);
  World world;
  made(world, folder_.path("i.tif"), {"--image-format", "rgba8"});
  int covered = 0;
  EXPECT_LE(most_off(world, waves, covered), 4.0);
  EXPECT_GT(covered, 3 * kWide * 3 * kDeep);
}

// Turned by 30 degrees, over a part: what it does not reach is not covered.
TEST_F(ImageryOfAWorld, LiesTurnedWhereTheImageDoes) {
  Shape shape;
  shape.width = 200;
  shape.height = 160;
  const double along = kStep / 4 * std::cos(0.5), across = kStep / 4 * std::sin(0.5);
  shape.place = {kWest + 900, along, across, kNorth - 500, across, -along};
  write_image(folder_.path("i.tif"), shape, waves);
  World world;
  made(world, folder_.path("i.tif"), {"--image-format", "rgba8"});
  int covered = 0;
  // At its rim a filter has pixels on one side alone: up to half a pixel.
  EXPECT_LE(most_off(world, waves, covered), 8.0);
  // 50 x 40 samples of 3.75^2 texels, less its rim; some lie in a tile and in another one's border.
  EXPECT_GT(covered, 25'000);
  EXPECT_LT(covered, 32'000);
}

TEST_F(ImageryOfAWorld, TilesAgreeWithTheirNeighboursAndParents) {
  Shape shape;  // 20 pixels a sample: 8 times as many tiles along as 2.5
  shape.width = 20 * kWide;
  shape.height = 20 * kDeep;
  shape.place[1] = kStep / 20;
  shape.place[5] = -kStep / 20;
  write_image(folder_.path("i.tif"), shape, waves);
  World world;
  made(world, folder_.path("i.tif"), {"--image-format", "rgba8"});
  int borders = 0, children = 0;
  for (const auto& [key, tile] : world.tiles) {
    const auto [size, x, z] = key;
    // The second level is half of the first.
    std::vector<std::byte> half(4 * kImageSide * kImageSide / 4);
    const std::size_t first = image_level_bytes(ImageFormat::rgba8, 0);
    halve_texels(std::span(tile.texels).first(first), kImageSide, half);
    const auto second = std::span(tile.texels).subspan(first);
    const bool inside = (x + 1) * (4 << size) < kWide - 1 && (z + 1) * (4 << size) < kDeep - 1;
    const bool amid = inside && x > 0 && z > 0;  // the image covers its border too
    if (amid) {
      EXPECT_TRUE(std::equal(second.begin(), second.end(), half.begin())) << size << ' ' << x << ' ' << z;
    }
    if (const World::Tile* east = world.find(size, x + 1, z); east != nullptr && inside) {
      ++borders;
      for (int y = kImageBorder; y < kImageSide - kImageBorder; ++y) {
        for (int i = 0; i < 2 * kImageBorder; ++i) {
          ASSERT_EQ(texel(tile.texels, kImageSide, kImageInside + i, y, 0),
                    texel(east->texels, kImageSide, i, y, 0))
              << size << ' ' << x << ' ' << z;
        }
      }
    }
    if (size == world.reader.ground().top_size() || !inside) continue;
    const World::Tile* const parent = world.find(size + 1, x >> 1, z >> 1);
    ASSERT_NE(parent, nullptr);
    ++children;
    constexpr int kHalf = kImageInside / 2;
    for (int y = 0; y < kHalf; ++y) {
      for (int i = 0; i < kHalf; ++i) {
        for (int c = 0; c < 4; ++c) {
          ASSERT_EQ(texel(parent->texels, kImageSide, kImageBorder + (x & 1) * kHalf + i,
                          kImageBorder + (z & 1) * kHalf + y, c),
                    texel(half, kImageSide / 2, kImageBorder / 2 + i, kImageBorder / 2 + y, c));
        }
      }
    }
  }
  EXPECT_GT(borders, 20);
  EXPECT_GT(children, 40);
}

// A finer image in a coarse one: tiles of its size are where it is, and it hides what is below it.
TEST_F(ImageryOfAWorld, HasSeveralResolutions) {
  Shape coarse;
  coarse.width = kWide;
  coarse.height = kDeep;
  coarse.place[1] = kStep;
  coarse.place[5] = -kStep;
  write_image(folder_.path("coarse.tif"), coarse, [](double, double) { return Colour{40, 90, 160}; });
  Shape fine;  // 16 pixels a sample over 12 x 12 samples
  fine.width = fine.height = 192;
  fine.place = {kWest + 40 * kStep, kStep / 16, 0, kNorth - 32 * kStep, 0, -kStep / 16};
  write_image(folder_.path("fine.tif"), fine, waves);
  World world;
  made(world, folder_.path("coarse.tif") + "," + folder_.path("fine.tif"), {"--image-format", "rgba8"});
  EXPECT_EQ(world.reader.imagery().least_size, 2);
  int finest = 0;
  for (const auto& [key, tile] : world.tiles) {
    if (std::get<0>(key) == 2) ++finest;
  }
  // A tile has 16 samples: the image lies over 40..52 x 32..44 samples, and no tile is far from it.
  EXPECT_GE(finest, 1);
  EXPECT_LE(finest, 9);
  const World::Tile* const over = world.find(2, 2, 2);
  ASSERT_NE(over, nullptr);
  // Sample (44.5, 36.5) is inside of it, (33, 33) is not.
  const int inside = kImageBorder + static_cast<int>((44.5 - 32) * 15);
  const int down = kImageBorder + static_cast<int>((36.5 - 32) * 15);
  const Colour expected = waves(kWest + 45 * kStep, kNorth - 37 * kStep);
  EXPECT_NEAR(texel(over->texels, kImageSide, inside, down, 0), expected[0], 8);
  EXPECT_EQ(texel(over->texels, kImageSide, kImageBorder + 15, kImageBorder + 15, 2), 160);
  // The other way round, the coarse one hides it.
  World hidden;
  made(hidden, folder_.path("fine.tif") + "," + folder_.path("coarse.tif"), {"--image-format", "rgba8"});
  const World::Tile* const under = hidden.find(2, 2, 2);
  ASSERT_NE(under, nullptr);
  EXPECT_EQ(texel(under->texels, kImageSide, inside, down, 2), 160);
}

TEST_F(ImageryOfAWorld, LosesWhatTheReportSays) {
  Shape shape;  // a little more than the DEM, so that a filter finds pixels everywhere
  shape.place[0] -= 5 * kStep / 4;
  shape.place[3] += 5 * kStep / 4;
  shape.width += 10;
  shape.height += 10;
  write_image(folder_.path("i.tif"), shape, waves);
  World plain, packed;
  made(plain, folder_.path("i.tif"), {"--image-format", "rgba8"});
  made(packed, folder_.path("i.tif"));
  EXPECT_EQ(packed.reader.imagery().format, ImageFormat::etc2_rgb);
  EncodingError error;
  for (const auto& [key, tile] : packed.tiles) {
    if (std::get<0>(key) != packed.reader.imagery().least_size) continue;
    const World::Tile* const source = plain.find(std::get<0>(key), std::get<1>(key), std::get<2>(key));
    ASSERT_NE(source, nullptr);
    // Blocks of colour alone, to which an opaque one of alpha is added.
    std::vector<std::uint8_t> blocks(etc2::etc2_bytes(kImageSide, kImageSide)),
        decoded(4 * kImageSide * kImageSide);
    for (std::size_t n = 0; n < blocks.size() / 16; ++n)
      std::memcpy(blocks.data() + 16 * n + 8, tile.texels.data() + 8 * n, 8);
    ASSERT_TRUE(etc2::decode_etc2(blocks, kImageSide, kImageSide, decoded).ok());
    for (int y = kImageBorder; y < kImageSide - kImageBorder; ++y) {
      for (int x = kImageBorder; x < kImageSide - kImageBorder; ++x) {
        if (texel(source->texels, kImageSide, x, y, 3) == 0) continue;
        for (int c = 0; c < 3; ++c) {
          const double off = texel(source->texels, kImageSide, x, y, c) -
                             decoded[static_cast<std::size_t>(4 * (y * kImageSide + x) + c)];
          error.squares += off * off;
        }
        error.values += 3;
      }
    }
  }
  char words[32];
  std::snprintf(words, sizeof words, "PSNR %.2f dB", error.psnr_db());
  EXPECT_NE(report_.find(words), std::string::npos) << words << '\n' << report_;
  EXPECT_GT(error.psnr_db(), 30);
  EXPECT_LT(error.psnr_db(), 60);
}

TEST_F(ImageryOfAWorld, IsTheSameWithAnyNumberOfThreads) {
  write_image(folder_.path("i.tif"), {}, waves);
  World one, three;
  made(one, folder_.path("i.tif"), {"--threads", "1"});
  made(three, folder_.path("i.tif"), {"--threads", "3"});
  EXPECT_EQ(one.file, three.file);
}

TEST_F(ImageryOfAWorld, WithoutAPlaceLiesOverAllOfTheDemIfItHasItsShape) {
  Shape shape;
  shape.placed = false;
  shape.epsg = 0;
  write_image(folder_.path("i.tif"), shape, waves);
  World world;
  made(world, folder_.path("i.tif"), {"--image-format", "rgba8"});
  int covered = 0;
  EXPECT_LE(most_off(world, waves, covered), 3.0);
  shape.width = 300;
  write_image(folder_.path("i.tif"), shape, waves);
  refused(folder_.path("i.tif"), "300 x 324 pixels have not the shape of 101 x 81 samples");
}

TEST_F(ImageryOfAWorld, RefusesWhatItCannotLay) {
  Shape shape;
  shape.epsg = 0;
  write_image(folder_.path("i.tif"), shape, waves);
  refused(folder_.path("i.tif"), "gdal_translate -a_srs gives it one");
  shape = {};
  shape.place[0] += 1e6;
  write_image(folder_.path("i.tif"), shape, waves);
  refused(folder_.path("i.tif"), "does not lie over the ground");
  shape = {};
  shape.type = GDT_UInt16;
  write_image(folder_.path("i.tif"), shape, waves);
  refused(folder_.path("i.tif"), "colours have 8 bits");
  std::ofstream(folder_.path("i.tif")) << "no image";
  refused(folder_.path("i.tif"), "not an image that karst-bake reads");
  refused(folder_.path("none.tif"), "none.tif");
  const test::ProcessResult result = test::run_process(
      KARST_BAKE_PATH,
      {folder_.path("dem.tif"), "--imagery", "i.tif", "--accept-fit", "-o", folder_.path("w")});
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("--accept-fit: only for a world of voxels"), std::string::npos) << result.err;
}

TEST_F(ImageryOfAWorld, DamagedTilesAreRefused) {
  write_image(folder_.path("i.tif"), {}, waves);
  World world;
  made(world, folder_.path("i.tif"));
  const core::WorldReader& reader = world.reader;
  const NodeKey root{reader.ground().top_size(), 0, 0};
  const auto check = [&](const std::function<void(std::vector<std::byte>&, TilePlace&)>& damage) {
    TilePlace place = reader.root_image();
    std::vector<std::byte> bytes(place.bytes);
    EXPECT_TRUE(reader.read_tile(place, bytes).ok());
    damage(bytes, place);
    ImageChildren children;
    return check_image_tile(reader.ground(), reader.imagery(), root, place, bytes, children);
  };
  const auto with_child = [&](TilePlace child, int quadrant) {
    return check([&](std::vector<std::byte>& bytes, TilePlace& place) {
      std::memcpy(bytes.data() + static_cast<std::size_t>(quadrant) * sizeof child, &child, sizeof child);
      place.crc = crc32c(bytes);
    });
  };
  const TilePlace root_place = reader.root_image();
  EXPECT_TRUE(check([](std::vector<std::byte>&, TilePlace&) {}).ok());
  EXPECT_EQ(check([](std::vector<std::byte>& bytes, TilePlace&) { bytes[200] ^= std::byte{1}; }).code(),
            StatusCode::corrupt);
  EXPECT_EQ(check([](std::vector<std::byte>& bytes, TilePlace&) { bytes.pop_back(); }).code(),
            StatusCode::corrupt);
  EXPECT_TRUE(with_child({0, root_place.bytes, 1}, 0).ok());
  // Itself, or what overlaps it: a chain without an end.
  EXPECT_EQ(with_child(root_place, 0).code(), StatusCode::corrupt);
  EXPECT_EQ(with_child({root_place.offset - root_place.bytes + 1, root_place.bytes, 1}, 0).code(),
            StatusCode::corrupt);
  EXPECT_EQ(with_child({0, root_place.bytes - 1, 1}, 0).code(), StatusCode::corrupt);
  EXPECT_EQ(with_child({0, 0, 1}, 0).code(), StatusCode::corrupt);
}

}  // namespace
}  // namespace karst::bake
