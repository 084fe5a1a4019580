// SPDX-License-Identifier: MIT
// From what is around a world to what shaders need of it in a frame.
#pragma once

#include <glm/vec3.hpp>

#include "renderer/input/shader_interface.h"
#include "terrain/shading/materials.h"
#include "terrain/shading/surroundings.h"
#include "terrain/view/camera.h"

namespace karst::core {

struct FrameSurroundings {
  Surroundings world;
  double voxel_size_m = 1;
  bool has_plain = false;         // at world.plain_level
  bool curved = false;            // water is level on a curved basis (FrameLevel)
  glm::vec3 plain_albedo{0.28f};  // linear
  double water_time_s = 0;        // waves move by it
};

// Albedo of level ground at a height in voxels under the open sky: what the materials that lie there have on
// average.
glm::vec3 level_ground(const MaterialSet& materials, float height);

void set_surroundings(const Camera& camera, const FrameSurroundings& surroundings, shader::FrameBlock& block);

}  // namespace karst::core
