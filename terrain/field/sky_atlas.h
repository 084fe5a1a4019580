// SPDX-License-Identifier: MIT
// Sky visibility of several octrees, one texture: their grids lie one above the other.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/config.h"
#include "terrain/field/sky_visibility.h"

namespace karst::core {

// Where an octree lies: its low corner, voxels from the world's, and the voxels in use.
struct SkyBox {
  glm::ivec3 corner{0};
  glm::ivec3 extent{1};
};

struct SkyAtlas {
  static constexpr std::size_t kMostBytes = 1024 * 1024;  // of several grids

  struct Place {
    SkyBox box;
    SkyGrid grid;
    int first = 0;          // of its layers of cells, from below
    std::size_t words = 0;  // of storage that its SkyVisibility has

    // For another box, in cells so large that it finds room where this one has it.
    void take(const SkyBox& other);

    friend bool operator==(const Place& a, const Place& b) {
      return a.grid == b.grid && a.first == b.first && a.box.corner == b.box.corner;
    }
  };

  SkyAtlas() = default;
  // Of one octree, whose corner is the world's.
  SkyAtlas(const SkyGrid& grid) : cells(grid.cells) { places[0].grid = grid; }
  // The finest cells for which `words` of storage, a texture of any OpenGL ES 3.0 and kMostBytes have room.
  // Precondition: 1..kMostRegions boxes.
  static SkyAtlas of(std::span<const SkyBox> boxes, std::size_t words);
  // Words of storage that the finest cells take.
  static std::size_t word_count(std::span<const SkyBox> boxes);

  std::array<Place, kMostRegions> places{};
  std::size_t count = 1;
  glm::ivec3 cells{1};  // of all; y: one above the other

  friend bool operator==(const SkyAtlas&, const SkyAtlas&) = default;
};

}  // namespace karst::core
