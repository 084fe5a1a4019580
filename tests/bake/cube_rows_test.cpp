// SPDX-License-Identifier: MIT
// Elevation of a whole planet as the grid of a cube: what its heights are, in memory or in a file, and how
// large it may be.
#include "bake/ground/ground_basis.h"
#include "tests/support/process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace karst::bake {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

// By direction, so that it has no seam.
double height_at(double sin_longitude, double cos_longitude, double sin_latitude, double cos_latitude) {
  const double x = cos_latitude * cos_longitude, y = cos_latitude * sin_longitude, z = sin_latitude;
  return 1000 * (3 * x * y + 2 * y * z - z * z + x);
}

Elevation planet_of(int width, int height) {
  Elevation made;
  made.width = width;
  made.height = height;
  made.earth.kind = ElevationEarth::Kind::degrees;
  made.earth.step_x = 360.0 / width;
  made.earth.step_z = 180.0 / height;
  made.earth.west = -180 + 0.5 * made.earth.step_x;
  made.earth.north = 90 - 0.5 * made.earth.step_z;
  return made;
}

void fill(Elevation& made) {
  made.heights_m.resize(static_cast<std::size_t>(made.width) * static_cast<std::size_t>(made.height));
  std::vector<double> sines, cosines;
  for (int column = 0; column < made.width; ++column) {
    const double longitude = (made.earth.west + column * made.earth.step_x) * kDegree;
    sines.push_back(std::sin(longitude));
    cosines.push_back(std::cos(longitude));
  }
  for (int row = 0; row < made.height; ++row) {
    const double latitude = (made.earth.north - row * made.earth.step_z) * kDegree;
    const double s = std::sin(latitude), c = std::cos(latitude);
    for (int column = 0; column < made.width; ++column) {
      const auto n = static_cast<std::size_t>(column);
      made.heights_m[made.at(column, row)] = static_cast<float>(height_at(sines[n], cosines[n], s, c));
    }
  }
}

Basis cube_of(std::int32_t face_quads) {
  Basis basis;
  basis.kind = BasisKind::cube;
  basis.centred = true;
  basis.face_quads = face_quads;
  EXPECT_TRUE(basis.finish().ok());
  return basis;
}

std::vector<float> rows_of(const CubeRows& cube) {
  std::vector<float> all;
  cube.run([&](std::span<const float> row) {
    all.insert(all.end(), row.begin(), row.end());
    return true;
  });
  return all;
}

// The most that samples are off those heights, on faces and beside them.
double most_off(const std::vector<float>& rows, const Basis& basis) {
  const std::int64_t wide = kCubeCells[0] * std::int64_t{basis.face_quads} + 1;
  double most = 0;
  for (std::size_t n = 0; n < rows.size(); ++n) {
    std::int64_t i = static_cast<std::int64_t>(n) % wide, k = static_cast<std::int64_t>(n) / wide;
    const int face = cube_home(basis.face_quads, i, k);
    Geodetic at;
    if (!geodetic_of(basis, place_m(basis, {double(i), double(k), 0, face}), at)) return 1e9;
    const double longitude = at.longitude_deg * kDegree, latitude = at.latitude_deg * kDegree;
    const double height =
        height_at(std::sin(longitude), std::cos(longitude), std::sin(latitude), std::cos(latitude));
    most = std::max(most, std::abs(height - double{rows[n]}));
  }
  return most;
}

TEST(CubeRows, AreTheSameInMemoryAndInAFile) {
  const test::Folder folder;
  const ReadElevation settings;
  GroundRows rows(settings, std::nullopt);
  Elevation made = planet_of(724, 362);
  fill(made);
  rows.hold(std::move(made), 0);
  const Basis basis = cube_of(128);
  CubeRows held, filed;
  filed.threads = 3;
  filed.held_bytes = 0;
  filed.folder = folder.path("");
  std::uint64_t faces_done = 0;
  const auto progress = [&](const char* stage, std::uint64_t done, std::uint64_t all) {
    EXPECT_STREQ(stage, "faces");
    EXPECT_EQ(all, 6u * 129);
    EXPECT_GE(done, faces_done);
    faces_done = done;
  };
  ASSERT_TRUE(held.open(rows, basis, progress).ok());
  EXPECT_EQ(faces_done, 6u * 129);
  const Error error = filed.open(rows, basis, {});
  ASSERT_TRUE(error.ok()) << error.text();
  EXPECT_FALSE(held.is_in_file());
  EXPECT_TRUE(filed.is_in_file());
  const std::vector<float> all = rows_of(held);
  ASSERT_EQ(all.size(), (6u * 128 + 1) * (5 * 128 + 1));
  EXPECT_EQ(all, rows_of(filed));
  // Poles lie half a step beyond the last row, in each direction.
  EXPECT_LE(most_off(all, basis), 15.0);
  filed.folder = folder.path("none");
  const std::string text = filed.open(rows, basis, {}).text();
  EXPECT_NE(text.find("none: takes 2 MiB while elevation this large is laid on a cube, and cannot: No such"),
            std::string::npos)
      << text;
}

// More samples than 2^26, whatever holds them.
TEST(CubeRows, TakeAPlanetOfAnySize) {
  const test::Folder folder;
  const ReadElevation settings;
  GroundRows rows(settings, std::nullopt);
  const int wide = 11'648, deep = 5'824;
  static_assert(std::int64_t{wide} * deep > 1 << 26);
  {
    Elevation made = planet_of(wide, deep);
    fill(made);
    rows.hold(std::move(made), 0);
  }
  std::int32_t quads = 0;
  ASSERT_TRUE(CubeRows::face_quads(rows.facts(), wide, deep, "planet.tif", quads).ok());
  EXPECT_EQ(quads, 4096);
  CubeRows cube;
  cube.threads = 2;
  cube.held_bytes = 200u << 20;
  cube.folder = folder.path("");
  const Basis basis = cube_of(64);
  const Error error = cube.open(rows, basis, {});
  ASSERT_TRUE(error.ok()) << error.text();
  EXPECT_LE(most_off(rows_of(cube), basis), 1.0);
  // As many as faces may have, and no more, however fine the elevation is.
  Elevation finer = planet_of(86'400, 43'200);
  ASSERT_TRUE(CubeRows::face_quads(finer, 86'400, 43'200, "planet.tif", quads).ok());
  EXPECT_EQ(quads, 32'768);
  finer = planet_of(4'000'000, 2'000'000);
  ASSERT_TRUE(CubeRows::face_quads(finer, 4'000'000, 2'000'000, "planet.tif", quads).ok());
  EXPECT_EQ(quads, kMostFaceQuads);
}

}  // namespace
}  // namespace karst::bake
