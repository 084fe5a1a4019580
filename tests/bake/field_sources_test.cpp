// SPDX-License-Identifier: MIT
// Fields from the surface of a world's voxels, and from OpenVDB's files.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "bake/fields/field_file.h"
#include "bake/fields/field_vdb.h"
#include "bake/fields/field_world.h"
#include "bake/samples/samples.h"
#include "tests/support/process.h"

namespace karst::bake {
namespace {

// A level set that OpenVDB made, of radius 2 with voxels of half a metre; gzip, base64.
constexpr const char* kBall =
    "H4sIAAAAAAACA+3dz2vbZhjA8TdzN29jizoYO2wHl0BPpqSe7UW2QzzG2EZhEMg2dppxUmU1OHGJ0+BeVsMghxxy3bls"
    "l+QwTEiC10DwIZf8BzvKx9x0NFnBe1/JT6T+SNIkrHTp9wPK89qVZOnRo8clVaVrX3z5g9JcPb2rAkM3nVTWuTmdunGz"
    "/OnsjUw2lbmRyzi5G6nZmVRq1s6W7cy0P6OeruhpulytfqzjdwuOU5qt1sqLpWwpU0qXvilXZ78yr83cvw5WX7g+5Mf+"
    "aBDf0NM7enpTTzPVcr3+lh7UFxcq8z+bt6vOklO9VncW39cvZitVpzQ9XWuU5soNs8CSM5OuvDdYWqan5qzMPzHnP/1+"
    "X6arMudMbe7uglOvV2rz4ceb9ZRnFitLzrWlcvWeU/9AZr/tVMv3ndslvW+3zVwlece88bV+4+3BzsYG0mZHh1JXmjqa"
    "ybz+UE+fmEQM/aJ+U3+ov9Tvqq3+VHs6sT9O+osPywfOOXOl6fuLTt3sSmV+8bOM+YS/71z3ZzvajaVaw6nqnbk3v/jE"
    "jD/Fgs35yLxZL9XLS3rjy/XSHX2AgiPmH8darWqOyZB5MV+ec8JUyGG2dPx+vjJbW5ibmilXnW/Ld4M1u8WzRfX58+PV"
    "Y6JXfDoG1dP0X/vp9vr9owkAAAAAAFx2TVIAAAAAAABwuTVJAU4oj47rB9f1/OB5PR07rtcz0YQGVxIBAAAAAPD6GCIF"
    "AAAAAAAAlx2/AsJJYnHLD5aV8EMiYe5JFLcSRRNNGD+6kogrigAAAAAAeFmapAAAAAAAAADn1yQFOAfX7fil43muawa9"
    "nh41Tex5bkepRsMMFFcRAQAAAADwkvGfwwAAAAAAAHAh/IIJ52JZ8ZiJiYRlmUGxqEd6MKEHVlyp8XEzGMz8ajztrMlR"
    "AwAAAAAAAAAAAADgv9ckBcDl5nq9XiMSO2ZgTn7X83p+F3BdL2gHHfe5a3gF7k/EZXMAAAAAAAAAAAAAALwU/BM9cNlZ"
    "ieLEeBCLJsbNQMeYlUiYqAdWwp8zFreOXUtwRVGTdAIAAAAAAAAAAAAA8H/XJAXAa8tu9Hqeq1RjEHsmdEz0PFc3B/3T"
    "BOW6nVNbBRcfAgAAAAAAAAAAAABwCXABAPAas8cniglLqfHxoh8nTIgrpUPCiimlf5qgLCseO/PKB09GGzwpTZ6cJk9S"
    "85+sFuuf5EEx4Qe9FX7QW6Gj2UITTYivFw7zB7n1wkFu3z7MTxVWco69kkuNrWUO8469ltkbXS8E704V9u3l7G5qJbec"
    "7SZHWusFx95NjbQaW2YNwTLyZ4f51Fg3eWtTtQ9ya5mRlmpnHslnyFpl6XCOfXtvtLGVeXRiUgY3eBrc8EluACU3hPJv"
    "EHVyUh73PD94nusH1+3oaC4CM9GEzlRhXe/yQc5s7L5t0vMwf5hXtknNVGE1vZZJja3kusm90bWM46dtvSB/uje6m1rO"
    "7ut0TW6MtLrJ5exKbnO7sTXS2k05tqxX1hHO02qr9q3NbjI1dpgf3tFJaI+01jIHOdmC8NOia4vOmXnU2Nob3bePy5xc"
    "0SZXuMkVb3IFnFwRd2z6dKofmKhTnzCDeFyPHpho0u9HPej3g3qR4x2kT9mr6W5Sjn5QLcF8Jn1KH/nJjc3tsCqkkqTq"
    "ZJ0rudX05EarPbwT1k1YbbKUVLBJXze5uT28I7UVrcewfqUmzRYflz45heWUllNcTnlpAcemT5++j03Up7NnBp2OHj02"
    "0ZzSftSDfl8qSY58UDF+jalucjWt7If5sBqkkmQpv1Lbm9uTG3ujSldhtFrCagurVJYz6x/eabUnN1bTK7loXUUrM1yD"
    "fG6wdcM7m9vdpGNLDUaXj25BuN2yd+qCz4qMSSeLROlw0vGkAx51xKigsqRCw1oMK01q6MU72It2xNM76/M7ctiz1QVv"
    "jheTnheJ0gulN0qvPOqdUVI/YW1Gqy9aUUGFnL2fnbVjnqUbn97Xn/weuOjVwzHpkZE46J1BL5XeKr322XTrtbSlIsMa"
    "Des2rGRTOWfvf2ftsGfp3qd9Dzz9vXHRv17FpKdG4qDXBr1XerH05mfS3TZ/yZPaDas5WuORyh9U0vm74fk78Hl7/gt/"
    "pxz7rfQvpPXowv8vAQA=";

test::ProcessResult bake(const std::vector<std::string>& words) {
  return test::run_process(KARST_BAKE_PATH, words);
}

// Distances are those of the sample's own, as near as its patches are to it.
TEST(FieldSources, AWorldOfVoxelsBecomesAField) {
  const test::Folder folder;
  const std::string world = folder.path("arches.karst");
  ASSERT_EQ(bake({"--sample", "arches", "--no-ground", "--voxel", "10", "--levels", "3", "--materials",
                  "none", "--quiet", "-o", world})
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
  ReadField read;
  const std::string packed = folder.write("ball", std::string(kBall));
  read.path = folder.write("ball.vdb",
                           test::run_process("/bin/sh", {"-c", "base64 -d \"$0\" | gzip -dc", packed}).out);
  FieldGrid grid;
  const Error error = read.run(grid);
  ASSERT_TRUE(error.ok()) << error.text();
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
