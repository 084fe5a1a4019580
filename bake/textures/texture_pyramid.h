// SPDX-License-Identifier: MIT
// From images of materials to the bytes of texture arrays: pyramids, quantised, compressed, in the layout of
// terrain/shading/materials.h.
//
// All is averaged: albedo in linear light, slopes of the height instead of normals, the square of GGX's alpha
// instead of roughness. The far array has no bumps and is as rough as the images say. Material::roughness is
// that of the texture seen from afar, where bumps are roughness too: alpha^2 grows by the variance of the
// slopes along s and t (Olano and Baker, "LEAN mapping", 2010, section 3; a GGX lobe of alpha stands for
// slopes of variance alpha^2 / 2 along each axis, as Beckmann's does).
//
// Four bits a channel are dithered by error diffusion, so that averages stay: R. Floyd and L. Steinberg, "An
// Adaptive Algorithm for Spatial Greyscale", 1976.
#pragma once

#include "bake/textures/material_image.h"
#include "terrain/shading/materials.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace karst::bake {
using namespace core;

// What storing changes, over the finest level of all layers of an array. Albedo and roughness lose nothing
// but by compression: infinite without it.
struct TextureLoss {
  double albedo_db = 0;       // PSNR of the sRGB codes
  double roughness_db = 0;    // PSNR
  double brightness_db = 0;   // PSNR, the average being the peak
  double height_db = 0;       // PSNR
  double normal_degrees = 0;  // root of the mean square of the angle
};

struct MakeTextures {
  std::span<const MaterialImage> images;  // one a material, each set.side texels a side
  int threads = 1;

  // In: count, side and format of set. Out: what its materials say of their textures: average, roughness,
  // tint, spans. Returns the texture data.
  std::vector<std::byte> run(MaterialSet& set, TextureLoss& loss) const;
};

}  // namespace karst::bake
