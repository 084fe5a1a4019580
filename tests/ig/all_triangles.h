// SPDX-License-Identifier: MIT
// A small world as a file, and all its triangles, to ask one by one. Lengths are voxels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <glm/vec3.hpp>

namespace karst::ig {

// Hills with a cave through them, 24 x 14 x 24 voxels, and heights of level 3.
inline constexpr double kVoxel_m = 2;
std::vector<std::byte> cave_ground_file();

class AllTriangles {
 public:
  AllTriangles();
  AllTriangles(const AllTriangles&) = delete;
  AllTriangles& operator=(const AllTriangles&) = delete;
  ~AllTriangles();

  struct Crossing {
    bool found = false;
    double at = 0;           // height, or the way from the start
    glm::dvec3 normal{0.0};  // of unit length
  };
  std::vector<Crossing> column(double x, double z) const;  // from the top
  Crossing ray(glm::dvec3 from, glm::dvec3 to) const;

 private:
  struct Soup;
  std::unique_ptr<Soup> soup_;
};

// Numbers that are the same with every library.
struct TestRandom {
  std::uint64_t state;
  double unit();
};

}  // namespace karst::ig
