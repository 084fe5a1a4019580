// SPDX-License-Identifier: MIT
#include "bake/procedural/sample_materials.h"

#include "bake/procedural/sample_material_paint.h"

#include <algorithm>

#include "terrain/base/check.h"

namespace karst::bake {
namespace {

// Detail finer than a texel of a small image would be lost or alias: images are made larger, and averaged
// down.
constexpr int kLargestFinerMade = 512;
constexpr int kFiner = 16;

struct Entry {
  std::string_view name;
  void (*paint)(MaterialImage& image);
};
constexpr Entry kEntries[] = {{"grass", paint_grass}, {"rock", paint_rock}, {"strata", paint_strata},
                              {"sand", paint_sand},   {"snow", paint_snow}, {"ceiling", paint_ceiling}};

const Entry* find(std::string_view name) {
  return std::find_if(std::begin(kEntries), std::end(kEntries),
                      [&](const Entry& e) { return e.name == name; });
}

}  // namespace

bool is_sample_material(std::string_view name) {
  return find(name) != std::end(kEntries);
}

MaterialImage make_sample_material(std::string_view name, int side) {
  KARST_ASSERT(is_sample_material(name));
  KARST_ASSERT(side >= 16 && side <= 1024 && (side & (side - 1)) == 0);
  MaterialImage image(std::max(side, std::min(kFiner * side, kLargestFinerMade)));
  find(name)->paint(image);
  while (image.side > side) image = image.halved();
  return image;
}

}  // namespace karst::bake
