// SPDX-License-Identifier: MIT
#include "terrain/file/ground_section.h"

#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace karst::core {
namespace {

constexpr std::uint64_t kTileBytes = 1000;
constexpr double kVoxelM = 120;

WorldGround plane() {
  WorldGround ground;
  ground.info.samples[0] = 100;
  ground.info.samples[1] = 50;
  ground.info.steps[0] = 1024;
  ground.info.steps[1] = 2048;
  ground.info.low = -5;
  ground.info.high = 700;
  ground.root = {0, 100, 7};
  ground.tile_bytes = kTileBytes;
  return ground;
}
WorldGround geographic() {
  WorldGround ground = plane();
  Basis& basis = ground.info.basis;
  basis.kind = BasisKind::geographic;
  basis.first[0] = 7;
  basis.first[1] = 48;
  basis.step[0] = 0.001;
  basis.step[1] = -0.001;
  basis.anchor_deg[0] = 7.05;
  basis.anchor_deg[1] = 47.975;
  basis.base_m = 12;
  ground.earth.epsg = 4326;
  return ground;
}
WorldGround cube() {
  WorldGround ground = plane();
  ground.info.basis.kind = BasisKind::cube;
  ground.info.basis.centred = true;
  ground.info.basis.face_quads = 64;
  for (int axis = 0; axis < 2; ++axis) ground.info.samples[axis] = kCubeCells[axis] * 64 + 1;
  return ground;
}
WorldGround cylinder() {
  WorldGround ground = plane();
  ground.info.basis.kind = BasisKind::cylinder;
  ground.info.basis.radius_m = -800;
  ground.info.basis.step[0] = ground.info.basis.step[1] = 15;
  return ground;
}
WorldGround projected() {
  WorldGround ground = plane();
  Georeference& earth = ground.earth;
  earth.projection = MapProjection::transverse_mercator;
  earth.epsg = 32611;
  earth.origin[0] = 400'000;
  earth.origin[1] = 3'800'000;
  earth.scale = 0.9996;
  earth.longitude_deg = -117;
  earth.false_east_m = 500'000;
  return ground;
}

std::vector<std::byte> bytes_of(const WorldGround& ground) {
  std::vector<std::byte> bytes(ground_section::section_bytes(ground));
  ground_section::encode(ground, bytes);
  return bytes;
}

TEST(GroundSection, WhatIsWrittenIsRead) {
  EXPECT_EQ(bytes_of(plane()).size(), ground_section::kBytes);
  for (const WorldGround& ground : {plane(), geographic(), cube(), cylinder(), projected()}) {
    ASSERT_EQ(ground_section::check(ground).what, nullptr) << ground_section::check(ground).what;
    const std::vector<std::byte> bytes = bytes_of(ground);
    WorldGround read;
    const auto fault = ground_section::decode(bytes, kTileBytes, kVoxelM, read);
    ASSERT_EQ(fault.what, nullptr) << fault.what;
    EXPECT_EQ(read.info.basis.kind, ground.info.basis.kind);
    EXPECT_EQ(read.info.basis.height_unit_m, kVoxelM / kStepsPerVoxel * kVertexStep);
    EXPECT_EQ(read.earth.epsg, ground.earth.epsg);
    EXPECT_EQ(bytes_of(read), bytes);
    // finish() was called.
    if (ground.info.basis.is_curved()) {
      EXPECT_GT(read.info.basis.sagitta_m, 0);
    }
  }
}

// A field broken at a time.
TEST(GroundSection, RefusesWhatIsOutOfRange) {
  const auto fault_of = [](WorldGround ground, auto change) {
    change(ground);
    const char* const what = ground_section::check(ground).what;
    return std::string(what == nullptr ? "" : what);
  };
  EXPECT_EQ(fault_of(geographic(), [](WorldGround& g) { g.info.basis.step[0] = 0; }), "the basis is none");
  EXPECT_EQ(fault_of(geographic(), [](WorldGround& g) { g.info.basis.first[1] = NAN; }), "the basis is none");
  EXPECT_EQ(fault_of(cube(), [](WorldGround& g) { g.info.basis.face_quads = 60; }), "the basis is none");
  EXPECT_EQ(fault_of(cube(), [](WorldGround& g) { --g.info.samples[0]; }), "samples are not those of a cube");
  EXPECT_EQ(fault_of(cylinder(), [](WorldGround& g) { g.info.basis.radius_m = 0; }), "the basis is none");
  EXPECT_EQ(fault_of(plane(), [](WorldGround& g) { g.info.basis.kind = BasisKind::function; }),
            "the basis is none");
  EXPECT_EQ(fault_of(projected(), [](WorldGround& g) { g.earth.per_m[1] = 0; }),
            "a scale is not within 1e-12..1e12");
  EXPECT_EQ(fault_of(projected(), [](WorldGround& g) { g.earth.origin[0] = NAN; }),
            "coordinates are not within +-1e12");
  EXPECT_EQ(fault_of(projected(), [](WorldGround& g) { g.earth.latitude_deg = 91; }),
            "no longitude and latitude");
  EXPECT_EQ(fault_of(projected(), [](WorldGround& g) { g.info.basis.flattening = 0.5; }),
            "the ellipsoid is none");
}

TEST(GroundSection, RefusesBytesThatMeanNothing) {
  const auto fault_at = [](const WorldGround& ground, std::size_t offset, std::uint32_t word) {
    std::vector<std::byte> bytes = bytes_of(ground);
    std::memcpy(bytes.data() + offset, &word, sizeof word);
    WorldGround read = plane();
    const auto fault = ground_section::decode(bytes, kTileBytes, kVoxelM, read);
    EXPECT_EQ(read.info.samples[0], 100);  // untouched
    return std::string(fault.what == nullptr ? "" : fault.what);
  };
  EXPECT_EQ(fault_at(geographic(), 64, 5), "a basis of unknown kind");
  EXPECT_EQ(fault_at(geographic(), 64, 260), "a basis of unknown kind");
  EXPECT_EQ(fault_at(geographic(), 68, 2), "a flag is unknown");
  EXPECT_EQ(fault_at(geographic(), 156, 1), "a reserved field is not 0");
  EXPECT_EQ(fault_at(geographic(), 252, 1), "a reserved field is not 0");
  EXPECT_EQ(fault_at(projected(), 148, 9), "a projection of unknown kind");
  EXPECT_EQ(fault_at(projected(), 148, 0), "a basis and a georeference are missing");
}

WorldGround with_imagery() {
  WorldGround ground = plane();
  ground.imagery = {ImageFormat::etc2_rgba, 2};
  ground.tile_bytes = 1'000 + image_tile_bytes(ImageFormat::etc2_rgba);
  ground.image_root = {1'000, static_cast<std::uint32_t>(image_tile_bytes(ImageFormat::etc2_rgba)), 99};
  return ground;
}
using ImageryBytes = std::array<std::byte, ground_section::kImageryBytes>;
ImageryBytes imagery_bytes(const WorldGround& ground) {
  ImageryBytes bytes;
  ground_section::encode_imagery(ground, bytes);
  return bytes;
}

TEST(ImagerySection, WhatIsWrittenIsRead) {
  for (const ImageFormat format : {ImageFormat::etc2_rgb, ImageFormat::etc2_rgba, ImageFormat::rgba8}) {
    WorldGround ground = with_imagery();
    ground.imagery.format = format;
    ground.image_root.bytes = static_cast<std::uint32_t>(image_tile_bytes(format));
    ground.tile_bytes = ground.image_root.offset + ground.image_root.bytes;
    WorldGround read = ground;
    read.imagery = {};
    read.image_root = {};
    ASSERT_EQ(ground_section::decode_imagery(imagery_bytes(ground), read).what, nullptr);
    EXPECT_EQ(read.imagery, ground.imagery);
    EXPECT_EQ(read.image_root, ground.image_root);
  }
}

// A field broken at a time, in what is written and in bytes that are read.
TEST(ImagerySection, RefusesWhatIsOutOfRange) {
  const auto fault_of = [](auto change) {
    WorldGround ground = with_imagery();
    change(ground);
    const char* const what = ground_section::check_imagery(ground).what;
    WorldGround read = ground;
    read.imagery = {};
    const auto fault = ground_section::decode_imagery(imagery_bytes(ground), read);
    EXPECT_STREQ(fault.what, what);
    EXPECT_FALSE(read.imagery.exists());  // untouched
    return std::string(what == nullptr ? "" : what);
  };
  EXPECT_EQ(ground_section::check_imagery(with_imagery()).what, nullptr);
  EXPECT_EQ(fault_of([](WorldGround& g) { g.imagery.format = ImageFormat{kImageFormats}; }),
            "the format is not known");
  EXPECT_EQ(fault_of([](WorldGround& g) { g.imagery.format = ImageFormat::none; }),
            "the format is not known");
  EXPECT_EQ(fault_of([](WorldGround& g) { g.imagery.least_size = -1; }),
            "the least size is not one of the ground's");
  EXPECT_EQ(fault_of([](WorldGround& g) { g.imagery.least_size = g.info.top_size() + 1; }),
            "the least size is not one of the ground's");
  const char outside[] = "the root's image tile does not lie in the tiles";
  EXPECT_EQ(fault_of([](WorldGround& g) { ++g.image_root.offset; }), outside);
  EXPECT_EQ(fault_of([](WorldGround& g) { g.image_root.offset = ~std::uint64_t{0} - 5; }), outside);
  EXPECT_EQ(fault_of([](WorldGround& g) { --g.image_root.bytes; }), outside);
  EXPECT_EQ(fault_of([](WorldGround& g) { g.tile_bytes = 0; }), outside);
  ImageryBytes bytes = imagery_bytes(with_imagery());
  bytes[31] = std::byte{1};
  WorldGround read = plane();
  EXPECT_STREQ(ground_section::decode_imagery(bytes, read).what, "a reserved field is not 0");
}

}  // namespace
}  // namespace karst::core
