// SPDX-License-Identifier: MIT
// Where a surface goes through a cell of marching cubes, once around: its triangles, its outline on the
// cell's faces, and how far it is from flat (measure_cells.h). Places are cells, from the cell's lower
// corner.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "terrain/isosurface/cell_tables.h"

namespace karst::core {

inline constexpr float kUnknown = std::numeric_limits<float>::infinity();

inline float squared(glm::vec3 v) {
  return glm::dot(v, v);
}
// Of a point from a segment, squared.
float from_segment(glm::vec3 p, glm::vec3 a, glm::vec3 b);

struct CellTriangle {
  std::array<glm::vec3, 3> at;
  glm::vec3 normal{0.0f};  // as long as twice the area

  void find_normal() { normal = glm::cross(at[1] - at[0], at[2] - at[0]); }
  float distance2(glm::vec3 p) const;  // squared
};

// Where a surface goes through a cell, from its lower corner, cells; vertices are known by their edges.
struct Loop {
  std::array<CellTriangle, kMostCellTriangles> triangle;
  std::array<std::array<int, 3>, kMostCellTriangles> edge{};  // of the cell
  std::size_t triangles = 0;

  // How thick the convex hull is along the mean normal, and the outline; kUnknown where it has folds or is
  // not convex.
  float thickness = kUnknown;
  glm::vec3 mean{0.0f};
  float slope = 0;
  std::array<glm::vec3, 3 * kMostCellTriangles> outline;
  std::array<int, 3 * kMostCellTriangles> outline_edge{};
  std::size_t outlined = 0;
  float radius = 0;  // of a circle within the outline at most

  void measure();
  float distance2(glm::vec3 p) const {
    float least = kUnknown;
    for (std::size_t n = 0; n < triangles; ++n) least = std::min(least, triangle[n].distance2(p));
    return least;
  }

 private:
  bool has(int from, int to) const {
    for (std::size_t n = 0; n < triangles; ++n) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (edge[n][k] == from && edge[n][(k + 1) % 3] == to) return true;
      }
    }
    return false;
  }
  bool find_outline();
  float gap(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) const;
};

}  // namespace karst::core
