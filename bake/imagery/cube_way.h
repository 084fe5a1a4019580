// SPDX-License-Identifier: MIT
// Between pixels of an image and samples of a cube's grid, as GDAL's warping wants it: through longitude and
// latitude. For warp_image.cpp alone.
#pragma once

#include <gdal_alg.h>

#include "terrain/basis/basis.h"

namespace karst::bake {

// Begins with what GDAL looks at.
struct CubeWay {
  GDALTransformerInfo head{};
  core::Basis basis;      // a cube, finished
  void* inner = nullptr;  // pixels of the image to degrees; borrowed
  double turn_px = 0;     // pixels of the image that go once around the planet; 0: it does not say
  double width_px = 0;
  // Of a window: its face, the place of its corner and its texels' side, samples of the grid.
  int face = 0;
  double column = 0, row = 0, texel = 1;

  // inner outlives it. file: the image.
  void open(const core::Basis& cube, void* pixels_to_degrees, GDALDatasetH file);

  // A sample's number, on a face or as far beyond it as its own grid goes on, to a pixel. False: it has none.
  bool pixel_of(int of_face, double i, double k, double& x, double& y) const;
  // A pixel to a place on the grid.
  bool sample_of(double x, double y, core::GridPlace& at) const;
};

}  // namespace karst::bake
