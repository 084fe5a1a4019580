// SPDX-License-Identifier: MIT
// What shading a patch needs beyond one material under the open sky (design 4.9). What it does not need is
// skipped, and would have changed no bit of a pixel: choosing and blending materials, and the noise between
// them, where one material covers the patch; caves and lamps, where the ground lies under the open sky and no
// lamp reaches. A frame is drawn by the program for what any of its patches needs; its vertices tell pixels
// what their own patch needs (page_table.h). So patches stay in the draw list's order, nearest first: sorted
// by program, half as many pixels again would be shaded for nothing.
//
// Pixels skip more on their own: gles_shaders/materials.glsl.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "terrain/measure/normal_cone.h"

namespace karst::core {

// Bits for what is needed.
enum Shading : std::uint8_t {
  kShadeBlend = 1,
  kShadeCave = 2,
  kShadeShadows = 4,  // of a frame: there are shadow maps
  kShadeLamps = 8,    // of a frame: there are lamps
  kShadeAll = 15,
};

// What a patch may need wherever it is seen from.
struct PatchShading {
  std::uint8_t needs = kShadeBlend | kShadeCave;
  std::uint8_t material = 0;  // of all of it, plus 1; 0: a pixel's rules decide

  friend bool operator==(const PatchShading&, const PatchShading&) = default;
};

// What is skipped; false: every patch is drawn as if it needed it.
struct ShadingSkips {
  bool material = true;
  bool cave = true;

  friend bool operator==(const ShadingSkips&, const ShadingSkips&) = default;
};

// Largest product of a unit vector within the cone with `direction`, which has unit length; 1 for no cone.
float most_along(const NormalCone& cone, glm::vec3 direction);

}  // namespace karst::core
