// SPDX-License-Identifier: MIT
#include "bake/pipeline/measure_fit.h"

#include "terrain/draw/index_batches.h"
#include "terrain/patch/displacement.h"
#include "terrain/patch/gpu_vertex.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace karst::bake {
using namespace core;
namespace {

// Points along one axis, at integer lattice positions.
struct Axis {
  double first = 0, step = 1;  // lattice steps
  std::int64_t count = 0;

  // [1, extent - 1] voxels in points about spacing apart, half of that from its ends.
  static Axis over(int extent, double spacing_steps) {
    Axis axis;
    const double length = (extent - 2) * double{kStepsPerVoxel};
    axis.count = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::floor(length / spacing_steps)));
    axis.step = length / static_cast<double>(axis.count);
    axis.first = kStepsPerVoxel + 0.5 * axis.step;
    return axis;
  }
  std::int64_t at(std::int64_t k) const { return std::llround(first + static_cast<double>(k) * step); }
  // Points that can lie in [low, high]; the range may be one too wide on either side. One point may be an
  // axis without a length, whose step is 0.
  std::int64_t from(std::int64_t low) const {
    return count == 1 ? 0 : inside(std::floor((static_cast<double>(low) - first) / step));
  }
  std::int64_t to(std::int64_t high) const {
    return count == 1 ? 0 : inside(std::ceil((static_cast<double>(high) - first) / step));
  }

 private:
  std::int64_t inside(double point) const {
    return static_cast<std::int64_t>(std::clamp(point, 0.0, static_cast<double>(count - 1)));
  }
};

struct Edge {
  std::int64_t x, z, dx, dz;
  bool takes_ties;

  Edge(glm::i64vec3 a, glm::i64vec3 b) : x(a.x), z(a.z), dx(b.x - a.x), dz(b.z - a.z) {
    // Of an edge's two directions exactly one takes the points on it.
    takes_ties = dz > 0 || (dz == 0 && dx > 0);
  }
  // Twice the area of the triangle (edge, point): positive on the inner side.
  std::int64_t value(std::int64_t px, std::int64_t pz) const { return dz * (px - x) - dx * (pz - z); }
  bool inside(std::int64_t v) const { return v > 0 || (v == 0 && takes_ties); }
};

class Raster {
 public:
  explicit Raster(const MeasureFit& job) : job_(job) {
    const double steps_per_m = kStepsPerVoxel / job.grid.voxel_m;
    double coarser = 1;
    for (;; coarser *= 2) {
      x_ = Axis::over(job.grid.extent.x, 0.5 * coarser * job.spacing_x_m * steps_per_m);
      z_ = Axis::over(job.grid.extent.z, 0.5 * coarser * job.spacing_z_m * steps_per_m);
      if (static_cast<std::size_t>(x_.count) * static_cast<std::size_t>(z_.count) <= MeasureFit::kMostPoints)
        break;
    }
    error_.assign(static_cast<std::size_t>(x_.count) * static_cast<std::size_t>(z_.count), kNotHit);
  }

  void triangle(glm::i64vec3 a, glm::i64vec3 b, glm::i64vec3 c) {
    const std::int64_t area = Edge(a, b).value(c.x, c.z);
    doubled_area_ += static_cast<double>(area);
    if (area <= 0) {
      const glm::dvec3 ab(b - a), ac(c - a);
      const glm::dvec3 normal = glm::cross(ab, ac);
      const bool is_point_or_line = normal.x == 0 && normal.y == 0 && normal.z == 0;
      const glm::dvec3 middle = to_m(glm::dvec3(a + b + c) / 3.0);
      if (!is_point_or_line && !excluded(middle.x, middle.z)) ++result_.folded;
      return;
    }
    const Edge edges[3] = {{b, c}, {c, a}, {a, b}};
    const std::int64_t last_z = z_.to(std::max({a.z, b.z, c.z}));
    const std::int64_t last_x = x_.to(std::max({a.x, b.x, c.x}));
    for (std::int64_t k = z_.from(std::min({a.z, b.z, c.z})); k <= last_z; ++k) {
      for (std::int64_t i = x_.from(std::min({a.x, b.x, c.x})); i <= last_x; ++i) {
        const std::int64_t x = x_.at(i), z = z_.at(k);
        const std::int64_t w[3] = {edges[0].value(x, z), edges[1].value(x, z), edges[2].value(x, z)};
        if (!edges[0].inside(w[0]) || !edges[1].inside(w[1]) || !edges[2].inside(w[2])) continue;
        const double y = (static_cast<double>(w[0]) * static_cast<double>(a.y) +
                          static_cast<double>(w[1]) * static_cast<double>(b.y) +
                          static_cast<double>(w[2]) * static_cast<double>(c.y)) /
                         static_cast<double>(area);
        hit(i, k, to_m({static_cast<double>(x), y, static_cast<double>(z)}));
      }
    }
  }

  MeasureFit::Result finish() {
    std::vector<float> errors;
    double squares = 0;
    for (std::int64_t k = 0; k < z_.count; ++k) {
      for (std::int64_t i = 0; i < x_.count; ++i) {
        const float e = error_[index(i, k)];
        const glm::dvec3 p = to_m({static_cast<double>(x_.at(i)), 0, static_cast<double>(z_.at(k))});
        if (excluded(p.x, p.z)) continue;
        if (e == kNotHit) {
          ++result_.holes;
          continue;
        }
        errors.push_back(e);
        squares += double{e} * double{e};
      }
    }
    result_.points = errors.size();
    if (!errors.empty()) {
      result_.rms_m = std::sqrt(squares / static_cast<double>(errors.size()));
      const auto rank = static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(errors.size() - 1));
      std::nth_element(errors.begin(), errors.begin() + rank, errors.end());
      result_.p999_m = double{errors[static_cast<std::size_t>(rank)]};
      result_.max_m = double{*std::max_element(errors.begin() + rank, errors.end())};
    }
    const glm::dvec3 content(job_.grid.extent - 1);
    result_.covered_area = 0.5 * doubled_area_ / (content.x * content.z * kStepsPerVoxel * kStepsPerVoxel);
    result_.point_spacing_m = std::max(x_.step, z_.step) * job_.grid.voxel_m / kStepsPerVoxel;
    return result_;
  }

 private:
  static constexpr float kNotHit = -1.0f;

  std::size_t index(std::int64_t i, std::int64_t k) const {
    return static_cast<std::size_t>(k * x_.count + i);
  }
  glm::dvec3 to_m(glm::dvec3 steps) const { return job_.grid.to_m(steps / double{kStepsPerVoxel}); }
  bool excluded(double x_m, double z_m) const { return job_.excluded && job_.excluded(x_m, z_m); }

  // Where several triangles cover a point, the worst counts.
  void hit(std::int64_t i, std::int64_t k, glm::dvec3 p) {
    const double distance = std::abs(p.y - job_.solid->elevation_m(p.x, p.z));
    float& e = error_[index(i, k)];
    e = std::max(e, static_cast<float>(distance));
  }

  const MeasureFit& job_;
  Axis x_, z_;
  std::vector<float> error_;
  double doubled_area_ = 0;  // lattice steps squared
  MeasureFit::Result result_;
};

}  // namespace

MeasureFit::Result MeasureFit::run() const {
  const int level = heights.level;
  std::vector<std::uint16_t> indices(index_count(level)),
      grid_of(static_cast<std::size_t>(patch_vertices(level)));
  // The level is valid and the spans are long enough: neither can fail.
  (void)build_index_tables(level, indices).ok();
  (void)build_grid_order(level, grid_of).ok();
  std::vector<glm::ivec3> positions(grid_of.size());
  Raster raster(*this);
  for (PatchId patch = 0; patch < surface.patches.size(); ++patch) {
    if (patch / chunk % every != 0) continue;
    displaced_positions(surface, heights, level, patch, positions);
    const glm::i64vec3 origin(patch_origin(surface.volume_of(patch)));
    const auto vertex = [&](std::uint32_t index) {
      return origin + glm::i64vec3(positions[grid_of[indices[index]]]);
    };
    IndexRange ranges[kMaxIndexRanges];
    const unsigned skipped = surface.patches[patch].collapsed != 0 ? 8u : 0u;
    const int count = index_ranges(level, 0, skipped, ranges);
    for (int r = 0; r < count; ++r) {
      for (std::uint32_t k = ranges[r].first; k < ranges[r].first + ranges[r].count; k += 3) {
        raster.triangle(vertex(k), vertex(k + 1), vertex(k + 2));
      }
    }
  }
  return raster.finish();
}

}  // namespace karst::bake
