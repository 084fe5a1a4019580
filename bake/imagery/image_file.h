// SPDX-License-Identifier: MIT
// One image over the ground, read in a child of this program: where it lies, and a part of it, warped to the
// grid of the ground's samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bake/base/child.h"
#include "platform/base/error.h"
#include "terrain/basis/basis.h"

namespace karst::bake {

// Where the ground's samples lie: the middle of sample (i, k) at (west + (i + 0.5) step_x, north - (k + 0.5)
// step_z) in units of crs.
struct GroundGrid {
  std::int64_t samples[2] = {};  // along x and z
  bool placed = false;           // west to step_z are known; else 0, 0, 1, 1
  double west = 0, north = 0, step_x = 1, step_z = 1;
  std::string crs;  // WKT; empty: none
  // Of a cube, whose grid the samples are then: its basis. Else 0.
  std::int32_t face_quads = 0;
  double radius_m = 0, flattening = 0;
};

struct ImageFacts {
  int width = 0, height = 0;  // pixels
  // What it covers at most, in samples of the ground from the middle of sample (0, 0); and its smallest
  // pixel's side.
  double low[2] = {}, high[2] = {};
  // Of a cube, by face; nothing of a face where low is above high.
  double face_low[core::kCubeFaces][2] = {}, face_high[core::kCubeFaces][2] = {};
  double pixel_samples = 0;
  bool is_opaque = false;         // no pixel of it is masked
  bool covers_all = false;        // all of the ground
  std::string kind;               // for reports: "GTiff, 3 bands"
  std::uint64_t block_bytes = 0;  // decoded: of a row of blocks
  std::vector<std::string> warnings;
};

// Texels of size t are 2^t / 60 samples wide; that of column and row 0 begins at the middle of sample (0, 0).
struct TexelWindow {
  int size = 0;
  int face = 0;  // of a cube; beyond it its own grid goes on
  std::int64_t column = 0, row = 0;
  int width = 0, height = 0;
};
inline constexpr std::int64_t kMostWindowTexels = 4 << 20;

// Both tell in one line what is wrong with the file, or with where it lies.
Error describe_image(const GroundGrid& ground, const std::string& path, ImageFacts& facts);
// rgba: 8 bits each, row by row; alpha is how much of a texel the image covers. facts: of the same file.
Error read_image_window(const GroundGrid& ground, const std::string& path, const ImageFacts& facts,
                        const TexelWindow& window, std::vector<std::byte>& rgba);

// The same without a child, by GDAL (warp_image.cpp).
Error describe_image_here(const GroundGrid& ground, const std::string& path, ImageFacts& facts);
Error read_image_window_here(const GroundGrid& ground, const std::string& path, const TexelWindow& window,
                             std::vector<std::byte>& rgba);

extern const ChildTask kDescribeImage, kReadImage;

}  // namespace karst::bake
