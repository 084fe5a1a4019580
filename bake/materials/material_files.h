// SPDX-License-Identifier: MIT
// Images of a material from files, through OpenImageIO: PNG, JPEG, TIFF and OpenEXR of any size, resized to
// the side of the texture. What tiles stays so.
#pragma once

#include "bake/base/child.h"
#include "bake/materials/material_json.h"
#include "bake/textures/material_image.h"
#include "platform/base/error.h"

#include <string>

namespace karst::bake {

inline constexpr int kMostImageSide = 8'192;  // texels

// What read_material_image has a child do.
extern const ChildTask kReadMaterialImage;

// path, which a material file in `folder` names, as this process finds it.
std::string path_in(const std::string& folder, const std::string& path);

// Paths are relative to `folder`. Albedo of integer samples is sRGB, of floats linear. Without a height
// image, the albedo's brightness is the height; without a normal image (OpenGL's way: green is up), normals
// are the height's. The error names the image's path.
Error read_material_image(const MaterialSpec& spec, const std::string& folder, int side,
                          MaterialImage& image);

}  // namespace karst::bake
