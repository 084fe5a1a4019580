// SPDX-License-Identifier: MIT
#include "tests/ig/all_triangles.h"

#include <glm/geometric.hpp>

#include "tests/support/query_world.h"

namespace karst::ig {
namespace {

constexpr int kLevel = 3;

test::TestWorld cave_ground() {
  test::TestWorld world({24, 14, 24}, [](glm::ivec3 v) {
    const bool cave = v.y >= 2 && v.y <= 4 && v.z >= 9 && v.z <= 14;
    return v.y == 0 || (v.y < 8.0 + 3.0 * test::value_noise(5, glm::dvec3(v.x, 0, v.z) / 6.0) && !cave);
  });
  world.set_heights(kLevel, [](glm::dvec3 p) { return 1500.0 * test::value_noise(6, 2.0 * p); });
  world.voxel_size_m = kVoxel_m;
  return world;
}

}  // namespace

std::vector<std::byte> cave_ground_file() {
  return cave_ground().file();
}

struct AllTriangles::Soup {
  test::TestWorld world = cave_ground();
  test::TriangleSoup soup{world, kLevel};
};

AllTriangles::AllTriangles() : soup_(std::make_unique<Soup>()) {}
AllTriangles::~AllTriangles() = default;

std::vector<AllTriangles::Crossing> AllTriangles::column(double x, double z) const {
  std::vector<Crossing> crossings;
  for (const test::TriangleSoup::Crossing& one : soup_->soup.column(x, z))
    crossings.push_back({true, one.at, glm::normalize(one.triangle->normal())});
  return crossings;
}

AllTriangles::Crossing AllTriangles::ray(glm::dvec3 from, glm::dvec3 to) const {
  const test::TriangleSoup::Crossing met = soup_->soup.ray(from, to);
  if (met.triangle == nullptr) return {};
  return {true, met.at, glm::normalize(met.triangle->normal())};
}

double TestRandom::unit() {
  test::Random random{state};
  const double value = random.unit();
  state = random.state;
  return value;
}

}  // namespace karst::ig
