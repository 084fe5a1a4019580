// SPDX-License-Identifier: MIT
// Fields from the surface of a world's voxels, and from OpenVDB's files.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "bake/base/parallel.h"
#include "bake/fields/field_file.h"
#include "bake/fields/readers/field_vdb.h"
#include "bake/fields/readers/field_world.h"
#include "bake/samples/samples.h"
#include "tests/support/process.h"

namespace karst::bake {
namespace {

test::ProcessResult bake(const std::vector<std::string>& words) {
  return test::run_process(KARST_BAKE_PATH, words);
}

// Distances are those of the sample's own, as near as its patches are to it.
TEST(FieldSources, AWorldOfVoxelsBecomesAField) {
  const test::Folder folder;
  const std::string world = folder.path("arches.karst");
  ASSERT_EQ(bake({"--sample", "arches", "--no-ground", "--voxel", "6", "--materials", "none", "--quiet", "-o",
                  world})
                .code,
            0);
  FieldGrid grid, again;
  const Error error = read_world_surface(world, 0, 1, grid);
  ASSERT_TRUE(error.ok()) << error.text();
  ASSERT_TRUE(read_world_surface(world, 0, 3, again).ok());
  EXPECT_EQ(grid.values, again.values);
  const Sample sample = make_sample("arches", 1);
  std::size_t near = 0, wrong = 0;
  double sum = 0;
  std::mt19937 random(3);
  for (int n = 0; n < 400'000; ++n) {
    const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
    // Away from the sides, where the sample goes on.
    const int x = 8 + below(grid.size.x - 16), y = below(grid.size.y), z = 8 + below(grid.size.z - 16);
    const double value = double{grid.at(x, y, z)};
    if (std::abs(value) > 1.5 * grid.spacing_m) continue;
    const glm::dvec3 at = grid.low_m + grid.spacing_m * glm::dvec3(x, y, z);
    const double truth = -sample.solid->value_m(at);
    ++near;
    sum += std::abs(value - truth);
    wrong += (value < 0) != (truth < 0) && std::abs(truth) > grid.spacing_m ? 1u : 0u;
  }
  std::printf("FIGURE %zu samples near the surface, off by %.4f of a sample, %zu of the wrong sign\n", near,
              sum / static_cast<double>(near) / grid.spacing_m, wrong);
  ASSERT_GT(near, 1'000u);
  EXPECT_LT(sum / static_cast<double>(near), 0.3 * grid.spacing_m);
  EXPECT_LT(wrong, near / 200);

  const std::string field = folder.path("field.karst");
  const test::ProcessResult made = bake({"--field", world, "--quiet", "-o", field});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(bake({"--field", field, "-o", folder.path("x.karst")}).err.find("no voxels"), std::string::npos);
}

TEST(FieldSources, FilesOfOpenVdbAreReadWhereItIsThere) {
  EXPECT_TRUE(is_vdb(std::string_view(" BDV\0\0\0\0more", 12)));
  EXPECT_FALSE(is_vdb("NRRD0004"));
  const test::Folder folder;
  const std::string broken = folder.path("broken.vdb");
  std::ofstream(broken, std::ios::binary) << std::string(" BDV\0\0\0\0", 8) << "nothing";
  const test::ProcessResult refused = bake({"--field", broken, "-o", folder.path("x.karst")});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("OpenVDB"), std::string::npos) << refused.err;
  if (refused.err.find("built without") != std::string::npos) GTEST_SKIP() << "no libopenvdb-dev";
  const std::string packed = std::string(KARST_SOURCE_DIR) + "/tests/bake/files/ball.vdb.gz";
  ReadField read;
  read.path = folder.write("ball.vdb", test::run_process("/bin/gzip", {"-dc", packed}).out);
  FieldGrid grid;
  const Error error = read.run(grid);
  ASSERT_TRUE(error.ok()) << error.text();
  // A level set of radius 2, voxels of half a metre.
  EXPECT_DOUBLE_EQ(grid.spacing_m, 0.5);
  ASSERT_EQ(grid.size, glm::ivec3(grid.size.x));
  const float middle = grid.at(grid.size.x / 2, grid.size.y / 2, grid.size.z / 2);
  EXPECT_LT(middle, 0);
  double most = 0;
  const glm::dvec3 centre = 0.5 * glm::dvec3(grid.size - 1);
  for (int z = 0; z < grid.size.z; ++z) {
    for (int y = 0; y < grid.size.y; ++y) {
      for (int x = 0; x < grid.size.x; ++x) {
        const double distance = 0.5 * glm::length(glm::dvec3(x, y, z) - centre) - 2;
        if (std::abs(distance) < 0.9) most = std::max(most, std::abs(double{grid.at(x, y, z)} - distance));
      }
    }
  }
  EXPECT_LT(most, 0.05);
}

}  // namespace
}  // namespace karst::bake
