// SPDX-License-Identifier: MIT
#include "bake/elevation/solid.h"

#include "terrain/base/lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <string>

namespace karst::bake {
using namespace core;
namespace {

// A side that is a whole number of voxels but for rounding counts as whole.
constexpr double kRoundingVoxels = 1e-6;
constexpr double kMostVoxels = 1 << kMaxDepth;
constexpr int kMostTries = 1'000;
constexpr double kTryStep = 1.01;

// Voxels of a grid around content, with the layers below it and the one above. Not yet whole numbers: they
// may be beyond all of them.
struct Needs {
  double x, y, z, bottom;

  Needs(const Box& content_m, double voxel_m) {
    const glm::dvec3 size = (content_m.max - content_m.min) / voxel_m;
    x = std::floor(size.x + kRoundingVoxels) + 1;
    z = std::floor(size.z + kRoundingVoxels) + 1;
    bottom = std::floor(content_m.min.y / voxel_m + kRoundingVoxels);
    y = std::ceil(content_m.max.y / voxel_m - kRoundingVoxels) - bottom + WorldGrid::kLayersBelow + 1;
  }
  // The axis that has too many; 0: none.
  char too_long() const {
    if (!(x <= kMostVoxels)) return 'x';
    if (!(z <= kMostVoxels)) return 'z';
    return y <= kMostVoxels - 1 ? 0 : 'y';  // the layer above is air
  }
  bool too_narrow() const { return x < 2 || z < 2; }
  bool fits() const { return too_long() == 0 && !too_narrow(); }
};

std::string number(double value, const char* format) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

// Of two or three digits, above voxel_m, and not much larger than need be.
std::string voxel_that_fits(const Box& content_m, double voxel_m) {
  const glm::dvec3 size = content_m.max - content_m.min;
  double tried = std::max(voxel_m, std::max({size.x, size.y, size.z}) / kMostVoxels);
  for (int k = 0; k < kMostTries; ++k, tried *= kTryStep) {
    const double unit = std::pow(10.0, std::floor(std::log10(tried)) - 1);
    std::string text = number(std::ceil(tried / unit) * unit, "%.6g");
    if (Needs(content_m, std::strtod(text.c_str(), nullptr)).too_long() == 0) return text;
  }
  return number(tried, "%.3g");
}

// Words that end an error: the first of these sizes that can be taken.
std::string advice(const Box& content_m, std::initializer_list<std::string> voxels) {
  for (const std::string& text : voxels) {
    if (Needs(content_m, std::strtod(text.c_str(), nullptr)).fits()) return "; try --voxel " + text;
  }
  return "; no size fits sides that differ so much: --crop takes a part of a DEM, --ground all of it";
}

}  // namespace

Error WorldGrid::around(const Box& content_m, double voxel_m, WorldGrid& grid) {
  const Needs needs(content_m, voxel_m);
  if (const char axis = needs.too_long(); axis != 0) {
    const double voxels = axis == 'x' ? needs.x : axis == 'z' ? needs.z : needs.y;
    return "--voxel: voxels of " + number(voxel_m, "%.6g") + " m are " + number(voxels, "%.0f") + " along " +
           axis + ", and the most is " + (axis == 'y' ? "511" : "512") +
           advice(content_m, {voxel_that_fits(content_m, voxel_m)});
  }
  grid = {};
  grid.voxel_m = voxel_m;
  if (needs.too_narrow()) {
    const double side = std::min(content_m.max.x - content_m.min.x, content_m.max.z - content_m.min.z);
    return "--voxel: a voxel of " + number(voxel_m, "%.6g") + " m is wider than the world" +
           advice(content_m, {number(0.5 * side, "%.3g"), number(0.99 * side, "%.6g")});
  }
  grid.extent = {static_cast<int>(needs.x), static_cast<int>(needs.y), static_cast<int>(needs.z)};
  const glm::dvec3 middle = 0.5 * (content_m.min + content_m.max);
  grid.origin_m = {middle.x - 0.5 * voxel_m * grid.extent.x, voxel_m * (needs.bottom - kLayersBelow),
                   middle.z - 0.5 * voxel_m * grid.extent.z};
  grid.depth = 1;
  while ((1 << grid.depth) < std::max({grid.extent.x, grid.extent.z, grid.extent.y + 1})) ++grid.depth;
  return {};
}

}  // namespace karst::bake
