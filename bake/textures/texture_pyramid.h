// SPDX-License-Identifier: MIT
// From images of materials to the bytes of texture arrays: pyramids, quantised, compressed, in the layout of
// terrain/shading/materials.h.
//
// Albedo and height are averaged, albedo in linear light. Normals are averaged as slopes; what a coarser
// level loses of their variance makes its roughness: alpha^2 grows by the variance of the slopes along s and
// t (Olano and Baker, "LEAN mapping", 2010, section 3; a GGX lobe of alpha stands for slopes of variance
// alpha^2 / 2 along each axis, as Beckmann's does).
#pragma once

#include "bake/textures/material_image.h"
#include "terrain/shading/materials.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace karst::bake {
using namespace core;

// What compression changes, over the finest level of all layers. Zeros and infinities without it.
struct TextureLoss {
  double albedo_db = 0;       // PSNR of the sRGB codes
  double height_db = 0;       // PSNR
  double roughness_db = 0;    // PSNR of r
  double normal_degrees = 0;  // root of the mean square of the angle
};

struct MakeTextures {
  std::span<const MaterialImage> images;  // one a material, each set.side texels a side
  int threads = 1;

  // In: count, side and format of set. Out: its averages. Returns the texture data.
  std::vector<std::byte> run(MaterialSet& set, TextureLoss& loss) const;
};

}  // namespace karst::bake
