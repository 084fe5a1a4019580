// SPDX-License-Identifier: MIT
// Queries on the procedural samples against all their triangles, one by one.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/support/loaded_parts.h"
#include "tests/support/process.h"
#include "tests/support/query_world.h"

namespace karst::core {
namespace {

using test::Random;
using test::TestQuery;
using test::TriangleSoup;

constexpr double kStep = 1.0 / kStepsPerVoxel;  // voxels

class QueryOnSample : public testing::TestWithParam<const char*> {};

TEST_P(QueryOnSample, MeetsTheTrianglesOfItsLevel) {
  const test::Folder folder;
  const std::string path = folder.path("sample.karst");
  const test::ProcessResult baked = test::run_process(
      KARST_BAKE_PATH,
      {"--sample", GetParam(), "--no-ground", "--levels", "3", "--materials", "none", "--quiet", "-o", path});
  ASSERT_EQ(baked.code, 0) << baked.err;
  const std::string text = test::read_text(path);
  const auto file = std::as_bytes(std::span(text));
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  const Config config = World::config_for(reader.info(), 3);
  test::LoadedParts parts(config);
  ASSERT_TRUE(parts.load(file).ok());
  QueryWorld world;
  world.surface = parts.world.surface();
  world.bounds = parts.world.bounds();
  world.tree = &parts.world.tree();
  world.heights = parts.world.heights();
  world.height_blocks = parts.world.info().height_blocks;
  TestQuery query(world, 3, 128);
  const TriangleSoup soup(parts.world.surface(), parts.world.heights(), 3);

  const LatticeBox box = parts.world.box();
  const glm::dvec3 low = glm::dvec3(box.min) * kStep;
  const glm::dvec3 size = glm::dvec3(box.max - box.min) * kStep;
  Random random{17};
  const auto place = [&] {
    const double x = random.unit();
    const double y = random.unit();
    return low + size * glm::dvec3(x, y, random.unit());
  };
  int met = 0;
  std::size_t deepest = 0;
  for (int n = 0; n < 60; ++n) {
    const glm::dvec3 from = place();
    const glm::dvec3 to = place();
    QueryHit hit;
    const TriangleSoup::Crossing crossing = soup.ray(from, to);
    ASSERT_EQ(query->ray(from, to, Wait::for_file, hit), crossing.triangle != nullptr) << n;
    if (crossing.triangle != nullptr) {
      ++met;
      EXPECT_NEAR(hit.distance, crossing.at, kStep);
      EXPECT_LT(test::triangle_distance(hit.place, *crossing.triangle), kStep);
      EXPECT_LT(glm::length(hit.normal - crossing.triangle->normal()), 1e-9);
    }
    std::vector<QueryHit> column(64);
    const auto crossings = soup.column(from.x, from.z);
    ASSERT_EQ(query->column(from, Wait::for_file, column), crossings.size()) << n;
    for (std::size_t k = 0; k < crossings.size(); ++k) EXPECT_NEAR(column[k].place.y, crossings[k].at, kStep);
    deepest = std::max(deepest, crossings.size());
    const auto under = std::find_if(crossings.begin(), crossings.end(), [&](const TriangleSoup::Crossing& c) {
      return c.at <= from.y + 0.5 && c.triangle->normal().y > 0;
    });
    ASSERT_EQ(query->ground(from, 0.5, Wait::for_file, hit), under != crossings.end());
    if (hit.found()) {
      EXPECT_NEAR(hit.place.y, under->at, kStep);
    }
    ASSERT_EQ(query->inside(from, Wait::for_file), soup.winding(from) > 0);
    // Every tenth: a moving sphere costs brute force a search for each triangle.
    if (n % 10 != 0) continue;
    const glm::dvec3 end = from + 0.05 * (to - from);
    const TriangleSoup::Crossing contact = soup.sphere(from, end, 0.2);
    ASSERT_EQ(query->sphere(from, end, 0.2, Wait::for_file, hit), contact.triangle != nullptr) << n;
    if (hit.found()) {
      EXPECT_NEAR(hit.distance, contact.at, kStep);
    }
  }
  EXPECT_GT(met, 20);
  std::printf("%s: %u patches, columns of up to %zu surfaces\n", GetParam(), parts.world.patch_count(),
              deepest);
}

INSTANTIATE_TEST_SUITE_P(Samples, QueryOnSample, testing::Values("canyon", "caves", "arches", "hills"),
                         [](const auto& sample) { return std::string(sample.param); });

}  // namespace
}  // namespace karst::core
