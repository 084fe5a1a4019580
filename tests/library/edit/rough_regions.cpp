// SPDX-License-Identifier: MIT
#include "tests/library/edit/rough_regions.h"

#include <memory>

#include <glm/geometric.hpp>

#include "tests/support/test_world.h"

namespace karst::test {

double rough_regions_height(double x, double z) {
  return 10 + 2 * value_noise(5, glm::dvec3(x, 0, z) / 9.0);
}

namespace {

// Nodes of size 0 are two voxels wide.
struct Place {
  glm::ivec3 extent;
  int first[2];
  int height;  // of its corner
};
constexpr Place kPlaces[] = {
    {{15, 18, 13}, {9, 7}, 0}, {{13, 16, 17}, {20, 8}, 3}, {{17, 18, 13}, {40, 30}, 1}};

std::unique_ptr<TestWorld> voxels_of(const Place& place, std::uint64_t seed) {
  const glm::dvec3 corner(2 * (place.first[0] - kPlaces[0].first[0]), place.height,
                          2 * (place.first[1] - kPlaces[0].first[1]));
  auto world = std::make_unique<TestWorld>(
      place.extent,
      [=](glm::ivec3 v) {
        const glm::dvec3 at = corner + glm::dvec3(v) + 0.5;
        return at.y < rough_regions_height(at.x, at.z);
      },
      true);
  world->roughen(2, seed, 900);
  return world;
}

}  // namespace

MemoryGround rough_regions_ground(std::size_t count) {
  std::vector<MemoryRegion> places;
  for (std::size_t n = 0; n < count; ++n) {
    const Place& place = kPlaces[n];
    const double reach = core::kStepsPerVoxel * glm::length(glm::dvec3(place.extent));
    places.push_back({place.extent.x,
                      place.extent.z,
                      place.first[0],
                      place.first[1],
                      {kRegionError, reach},
                      place.extent.y,
                      place.height});
  }
  return MemoryGround(
      241, 201, 4096, 4096,
      [](std::int64_t i, std::int64_t k) {
        const double x = 0.5 + 0.5 * double(i) - 2 * kPlaces[0].first[0];
        const double z = 0.5 + 0.5 * double(k) - 2 * kPlaces[0].first[1];
        return static_cast<std::int32_t>(rough_regions_height(x, z) * core::kStepsPerVoxel /
                                         core::kVertexStep);
      },
      places);
}

std::vector<std::byte> rough_regions_file(std::size_t count, const core::WorldMaterials& materials) {
  std::vector<std::unique_ptr<TestWorld>> worlds;
  std::vector<const TestWorld*> regions;
  for (std::size_t n = 0; n < count; ++n) {
    worlds.push_back(voxels_of(kPlaces[n], 3 + n));
    regions.push_back(worlds.back().get());
  }
  return ground_file(rough_regions_ground(count), regions, {}, materials);
}

}  // namespace karst::test
