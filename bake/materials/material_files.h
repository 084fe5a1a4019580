// SPDX-License-Identifier: MIT
// Images of a material from files, through OpenImageIO: PNG, JPEG, TIFF and OpenEXR of any size, resized to
// the side of the texture. What tiles stays so.
#pragma once

#include "bake/base/child.h"
#include "bake/materials/material_json.h"
#include "bake/textures/material_image.h"
#include "platform/base/error.h"

#include <cstddef>
#include <string>
#include <vector>

namespace karst::bake {

inline constexpr int kMostImageSide = 8'192;  // texels

// What read_material_image and read_blend_map have a child do.
extern const ChildTask kReadMaterialImage, kReadBlendMap;

// path, which a material file in `folder` names, as this process finds it.
std::string path_in(const std::string& folder, const std::string& path);

// Paths are relative to `folder`. Albedo of integer samples is sRGB, of floats linear. Without a height
// image, the albedo's brightness is the height; without a normal image (OpenGL's way: green is up), normals
// are the height's. The error names the image's path.
Error read_material_image(const MaterialSpec& spec, const std::string& folder, int side,
                          MaterialImage& image);

// Weights from an image seen from above, its top in the north, values as they are in the file. It must have
// as many channels as wanted, 1 to 4; what is larger than kMostBlendSide is averaged to it. texels: 4
// channels, those that are not wanted too; map: width and depth alone.
Error read_blend_map(const std::string& path, std::size_t wanted, BlendMap& map,
                     std::vector<std::byte>& texels);

}  // namespace karst::bake
