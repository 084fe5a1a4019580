// SPDX-License-Identifier: MIT
// Images of a material from files, through OpenImageIO: PNG, JPEG, TIFF and OpenEXR of any size, resized to
// the side of the texture. What tiles stays so.
#pragma once

#include "bake/base/child.h"
#include "bake/materials/material_json.h"
#include "bake/textures/material_image.h"
#include "platform/base/error.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace karst::bake {

inline constexpr int kMostImageSide = 8'192;  // texels
// Of all images of a material file: four a material and a blend map.
inline constexpr std::uint64_t kMostImageTexels =
    std::uint64_t{kMostImageSide} * kMostImageSide * (4 * core::kMostMaterials + 1);

// What read_material_image and read_blend_map have a child do.
extern const ChildTask kReadMaterialImage, kReadBlendMap;

// Texels that the images of a material file may be decoded to, all of them together; an image that is named
// twice is decoded twice. Flat images hold many texels in next to no bytes, and pictures of ground 1 to 10 a
// byte, so the more of these there are, the more of those may be.
class TexelBudget {
 public:
  static constexpr std::uint64_t kFreeTexels = 1u << 22;
  static constexpr std::uint64_t kTexelsAByte = 16;  // of all files, each counted once

  // allowed: texels that may be whatever the files' length; paths: of all images, those that are named twice
  // being there twice. What cannot be looked at has no length.
  explicit TexelBudget(std::span<const std::string> paths = {}, std::uint64_t allowed = 0);

  std::uint64_t left() const { return most_ - used_; }
  // Of an image that was read; at most left().
  void use(std::uint64_t texels);
  // What to allow so that all goes in if the images not yet read have so many texels each.
  std::uint64_t enough(std::uint64_t texels) const { return used_ + texels * (images_ - read_); }

 private:
  std::uint64_t most_ = kFreeTexels, used_ = 0;
  std::size_t images_ = 1, read_ = 0;
};

// path, which a material file in `folder` names, as this process finds it.
std::string path_in(const std::string& folder, const std::string& path);

// Paths are relative to `folder`. Albedo of integer samples is sRGB, of floats linear. Without a height
// image, the albedo's brightness is the height; without a normal image (OpenGL's way: green is up), normals
// are the height's. The error names the image's path.
Error read_material_image(const MaterialSpec& spec, const std::string& folder, int side, TexelBudget& budget,
                          MaterialImage& image);

// Weights from an image seen from above, its top in the north, values as they are in the file. It must have
// as many channels as wanted, 1 to 4; what is larger than kMostBlendSide is averaged to it. texels: 4
// channels, those that are not wanted too; map: width and depth alone.
Error read_blend_map(const std::string& path, std::size_t wanted, TexelBudget& budget, BlendMap& map,
                     std::vector<std::byte>& texels);

}  // namespace karst::bake
