// SPDX-License-Identifier: MIT
// An edit in the core's words (karst/edit.h says what each means): places and lengths in voxels from the
// world's corner, x to the east, y up, z to the south. All arithmetic with them is in double, each operation
// a plain IEEE one, so that the same edit gives the same bits anywhere.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

namespace karst::core {

enum class EditTool : std::uint8_t { clear, fill, extrude, smooth, noise, flatten, level, paint };
inline constexpr int kEditTools = 8;
enum class BrushShape : std::uint8_t { voxel, box, sphere, capsule, cylinder };
inline constexpr int kBrushShapes = 5;

constexpr bool edits_voxels(EditTool tool) {
  return tool == EditTool::clear || tool == EditTool::fill;
}

constexpr bool edits_heights(EditTool tool) {
  return tool >= EditTool::extrude && tool <= EditTool::level;
}

struct Edit {
  EditTool tool = EditTool::clear;
  BrushShape shape = BrushShape::sphere;
  std::uint8_t octree_level = 0;
  // Of the octree that octree_level counts voxels of, which are as large in all parts of a world (and the
  // whole of an octree that is smaller); 0: of the part's own.
  std::uint8_t octree_depth = 0;
  std::uint8_t material = 0;
  glm::dvec3 place{0};
  glm::dvec3 to{0};
  glm::dvec3 half{1};
  glm::dvec3 up{0, 1, 0};
  double radius = 1;
  double strength = 1;
  double amount = 1;
  double hardness = 0;
  double wave = 4;
  std::uint32_t seed = 0;
};

}  // namespace karst::core
