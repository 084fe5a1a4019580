// SPDX-License-Identifier: MIT
// The triangles of a patch's levels (index_batches.cpp) with where morphing takes their vertices, for what is
// measured over all that can be drawn of a patch.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "terrain/base/lattice.h"
#include "terrain/patch/displacement.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// The vertices of a patch at its full level.
struct LevelGrid {
  glm::ivec3 position[patch_vertices(kMaxLevel) + 1];  // four values can be read at each
  int side;
  int level;

  LevelGrid(const Surface& surface, const Heights& heights, PatchId patch)
      : side(patch_side(heights.level)), level(heights.level) {
    displaced_positions(surface, heights, level, patch, position);
  }
  int index(glm::ivec2 v) const { return v.y * side + v.x; }
  glm::dvec3 at(glm::ivec2 v) const { return glm::dvec3(position[index(v)]); }
};

// A triangle of level m: stay keeps its place, border and centre are of level m. border lies on the side of
// a tile, centre in its middle. All in the grid of the full level.
struct LevelTriangle {
  glm::ivec2 stay, border, centre;
  glm::dvec3 border_target, centre_target;  // where morphing takes the two
  // Counter-clockwise: stay, border, centre; or border, stay, centre, where stay ends the tile's side.
  bool ends_side;
};

// Both triangles of a tile's side: stay[0], border, centre and stay[1], border, centre. The second one ends
// the side.
struct LevelSide {
  glm::ivec2 stay[2], border, centre;
  glm::dvec3 border_target, centre_target;
};

// Calls visit(side, edge) for all sides of tiles of level m; edge is the patch's edge that it lies on or -1.
template <class Visit>
void for_each_level_side(const LevelGrid& grid, int m, Visit visit) {
  // Around a tile's centre, as in index_batches.cpp: side e runs from corner 2e over its middle 2e + 1.
  constexpr glm::ivec2 kRing[8] = {{-1, -1}, {0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}};
  // As GenerateVertices rounds; exact, because vertices lie on even steps.
  const auto midpoint = [](glm::dvec3 a, glm::dvec3 b) { return 0.5 * (a + b); };
  const int size = 1 << (grid.level - m);
  const int tiles = patch_cells(m) / 2;
  for (int b = 0; b < tiles; ++b) {
    for (int a = 0; a < tiles; ++a) {
      const glm::ivec2 centre = glm::ivec2(2 * a + 1, 2 * b + 1) * size;
      const auto ring = [&](int r) { return centre + kRing[r & 7] * size; };
      // The diagonal of the coarser cell that is this tile alternates like the pattern.
      const int diagonal = (a + b) % 2 == 0 ? 0 : 2;
      const glm::dvec3 centre_target = midpoint(grid.at(ring(diagonal)), grid.at(ring(diagonal + 4)));
      const bool border[4] = {b == 0, a == tiles - 1, b == tiles - 1, a == 0};
      for (int e = 0; e < 4; ++e) {
        const glm::ivec2 first = ring(2 * e), last = ring(2 * e + 2);
        visit(LevelSide{{first, last},
                        ring(2 * e + 1),
                        centre,
                        midpoint(grid.at(first), grid.at(last)),
                        centre_target},
              border[e] ? e : -1);
      }
    }
  }
}

// Calls visit(triangle, edge) for all triangles of level m.
template <class Visit>
void for_each_level_triangle(const LevelGrid& grid, int m, Visit visit) {
  for_each_level_side(grid, m, [&](const LevelSide& side, int edge) {
    for (const bool last : {false, true}) {
      visit(LevelTriangle{side.stay[last ? 1 : 0], side.border, side.centre, side.border_target,
                          side.centre_target, last},
            edge);
    }
  });
}

}  // namespace karst::core
