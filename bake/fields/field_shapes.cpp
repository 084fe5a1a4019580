// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <memory>

#include <glm/geometric.hpp>

#include "bake/base/parallel.h"
#include "bake/fields/bake_field.h"
#include "bake/samples/noise.h"
#include "bake/samples/samples.h"
#include "platform/base/text.h"

namespace karst::bake {
namespace {

constexpr double kTurn = 6.283185307179586;

double sphere(glm::dvec3 p) {
  return glm::length(p) - 0.7;
}

double torus(glm::dvec3 p) {
  const double round = std::sqrt(p.x * p.x + p.z * p.z) - 0.6;
  return std::sqrt(round * round + p.y * p.y) - 0.25;
}

// sin x cos y + sin y cos z + sin z cos x, two periods, over the length of its gradient.
double gyroid(glm::dvec3 p) {
  const double k = kTurn;
  const double sx = std::sin(k * p.x), sy = std::sin(k * p.y), sz = std::sin(k * p.z);
  const double cx = std::cos(k * p.x), cy = std::cos(k * p.y), cz = std::cos(k * p.z);
  const glm::dvec3 slope(cx * cy - sz * sx, cy * cz - sx * sy, cz * cx - sy * sz);
  return (sx * cy + sy * cz + sz * cx) / (k * std::max(glm::length(slope), 0.2));
}

// Land with caves: noise over a slope that makes what is deep solid.
double rough(glm::dvec3 p) {
  return 0.7 * p.y + 0.5 * fbm(p * 2.5, 4, 7);
}

}  // namespace

Error fill_shape(const std::string& shape, glm::ivec3 size, double spacing_m, int threads, FieldGrid& grid) {
  grid = {};
  grid.size = size;
  grid.spacing_m = spacing_m > 0 ? spacing_m : 1;
  const auto row = static_cast<std::size_t>(size.x);
  const auto rows = static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
  grid.values.resize(row * rows);
  const auto fill = [&](const auto& value) {
    parallel_chunks(rows, 64, threads, [&](std::size_t first, std::size_t last, int) {
      for (std::size_t n = first; n < last; ++n) {
        const int y = static_cast<int>(n % static_cast<std::size_t>(size.y));
        const int z = static_cast<int>(n / static_cast<std::size_t>(size.y));
        for (int x = 0; x < size.x; ++x)
          grid.values[n * row + static_cast<std::size_t>(x)] = static_cast<float>(value(glm::dvec3(x, y, z)));
      }
    });
  };
  const struct {
    const char* name;
    double (*distance)(glm::dvec3 p);
  } shapes[] = {{"sphere", sphere}, {"torus", torus}, {"gyroid", gyroid}, {"noise", rough}};
  for (const auto& s : shapes) {
    if (s.name != shape) continue;
    // The shorter side is 2 long, from -1 to 1.
    const double half = 0.5 * (std::min({size.x, size.y, size.z}) - 1);
    const glm::dvec3 middle = 0.5 * glm::dvec3(size - 1);
    fill([&](glm::dvec3 at) { return s.distance((at - middle) / half) * half * grid.spacing_m; });
    return {};
  }
  const Sample sample = make_sample(shape, threads);
  if (sample.solid == nullptr) return "--field-shape: there is no shape " + quote(shape);
  const glm::dvec3 content = sample.content_m.max - sample.content_m.min;
  const glm::dvec3 cells(size - 1);
  if (spacing_m <= 0)
    grid.spacing_m = std::max({content.x / cells.x, content.y / cells.y, content.z / cells.z});
  const glm::dvec3 middle = 0.5 * (sample.content_m.min + sample.content_m.max);
  fill([&](glm::dvec3 at) { return -sample.solid->value_m(middle + (at - 0.5 * cells) * grid.spacing_m); });
  return {};
}

}  // namespace karst::bake
