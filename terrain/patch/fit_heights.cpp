// SPDX-License-Identifier: MIT
// The search goes out from the undisplaced point in both directions at once, so the first change of sign is
// the nearest crossing; it is then closed in by regula falsi with the Illinois rule (Dowell and Jarratt,
// 1971). Everything is a function of the vertex's position, so shared vertices need no sharing step.
#include "terrain/patch/fit_heights.h"

#include <algorithm>
#include <cmath>

#include "terrain/patch/displacement.h"

namespace karst::core {
namespace {

// Refinement ends when the bracket is a quarter of a lattice step.
constexpr double kToleranceVoxels = 0.25 / kStepsPerVoxel;
constexpr int kMaxRefinements = 60;

struct Ray {
  const SolidField* field;
  glm::dvec3 origin;
  glm::dvec3 direction;
  double at(double s) const { return field->value(field->context, origin + s * direction); }
};

// The crossing between a and b, where the field has different signs fa and fb.
double refine(const Ray& ray, double a, double fa, double b, double fb) {
  int side = 0;
  double s = b;
  for (int step = 0; step < kMaxRefinements && std::fabs(b - a) > kToleranceVoxels; ++step) {
    s = (fa * b - fb * a) / (fa - fb);
    const double fs = ray.at(s);
    if (fs == 0) return s;
    if ((fs > 0) == (fb > 0)) {
      b = s;
      fb = fs;
      if (side == -1) fa *= 0.5;
      side = -1;
    } else {
      a = s;
      fa = fs;
      if (side == 1) fb *= 0.5;
      side = 1;
    }
  }
  return s;
}

// Signed distance along the ray to the nearest crossing; found tells whether there is one within reach, else
// the place of the least |field| among the samples.
double nearest_crossing(const Ray& ray, double reach, double step, bool& found) {
  found = true;
  const double f0 = ray.at(0);
  if (f0 == 0) return 0;
  double best = 0;
  double least = std::fabs(f0);
  double f[2] = {f0, f0};  // at the ends of the searched interval, forwards first
  // The direction points out of the solid: from inside, forwards is the likelier way.
  const int first = f0 > 0 ? 0 : 1;
  for (double s = 0; s < reach;) {
    const double next = std::min(s + step, reach);
    for (int k = 0; k < 2; ++k) {
      const int way = k == 0 ? first : 1 - first;
      const double sign = way == 0 ? 1.0 : -1.0;
      const double value = ray.at(sign * next);
      if ((value > 0) != (f0 > 0)) return refine(ray, sign * s, f[way], sign * next, value);
      f[way] = value;
      if (std::fabs(value) < least) {
        least = std::fabs(value);
        best = sign * next;
      }
    }
    s = next;
  }
  found = false;
  return best;
}

}  // namespace

Status FitHeights::validate() const {
  if (field.value == nullptr) return {StatusCode::invalid_argument, "no field given", "field"};
  if (level < 1 || level > kMaxLevel) return {StatusCode::invalid_argument, "level is out of 1..6", "level"};
  if (!(search_voxels > 0 && search_voxels <= 3))
    return {StatusCode::invalid_argument, "search is out of (0, 3]", "search_voxels"};
  if (!(step_voxels > 0 && step_voxels <= 0.5))
    return {StatusCode::invalid_argument, "step is out of (0, 0.5]", "step_voxels"};
  if (heights.size() != surface.patches.size() * static_cast<std::size_t>(patch_vertices(level))) {
    return {StatusCode::invalid_argument, "heights do not have one block a patch", "heights"};
  }
  return {};
}

void FitHeights::run(PatchId first, PatchId last, Result& result) const {
  const int side = patch_side(level);
  for (PatchId patch = first; patch < last; ++patch) {
    const Volume& volume = surface.volume_of(patch);
    const glm::dvec3 corner(volume.corner[0], volume.corner[1], volume.corner[2]);
    std::int16_t* out = heights.data() + std::size_t{patch} * static_cast<std::size_t>(side * side);
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const BasePoint base = base_point(surface, level, patch, i, j);
        bool found = false;
        const Ray ray = {&field, corner + base.position, base.direction};
        const double s = nearest_crossing(ray, search_voxels, step_voxels, found);
        const double steps =
            std::clamp(std::round(s * kStepsPerVoxel), -double{kMaxHeight}, double{kMaxHeight});
        out[j * side + i] = static_cast<std::int16_t>(steps);
        ++result.vertices;
        result.misses += found ? 0 : 1;
      }
    }
  }
}

}  // namespace karst::core
