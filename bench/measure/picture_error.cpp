// SPDX-License-Identifier: MIT
#include "bench/measure/picture_error.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "terrain/lod/morph.h"

namespace karst::bench {
using namespace core;
namespace {

// A depth of 24 bits: what is nearer to 1 than half a step is the clear value.
constexpr float kSky = 1.0f - 0.5f / 16777215.0f;

// Discs of a reference further than this from their own pixel are not looked for: an error of so many pixels
// is an outlier whatever its exact size.
constexpr int kMostRings = 64;

struct Projection {
  explicit Projection(const DepthPicture& picture)
      : width(picture.width),
        height(picture.height),
        clip(clip_from_lattice(picture.camera)),
        inverse(glm::inverse(clip)) {}

  // Lattice steps relative to the camera's voxel, of a pixel's centre.
  glm::dvec3 point(int x, int y, float depth) const {
    const glm::dvec4 ndc((x + 0.5) / width * 2 - 1, 1 - (y + 0.5) / height * 2, double{depth} * 2 - 1, 1);
    const glm::dvec4 p = inverse * ndc;
    return glm::dvec3(p) / p.w;
  }
  // Pixels between a point and the centre of the pixel that it was seen in.
  double pixels_from(int x, int y, glm::dvec3 point_steps) const {
    const glm::dvec4 q = clip * glm::dvec4(point_steps, 1.0);
    const double dx = (q.x / q.w * 0.5 + 0.5) * width - (x + 0.5);
    const double dy = (0.5 - q.y / q.w * 0.5) * height - (y + 0.5);
    return std::hypot(dx, dy);
  }

  int width, height;
  glm::dmat4 clip, inverse;
};

std::size_t index_of(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

struct Disc {
  glm::dvec3 centre{0.0};
  glm::dvec3 normal{0.0};
  double radius = -1;  // below 0: sky
};

// What the reference's pixels show, as discs.
class Discs {
 public:
  Discs(const Projection& projection, std::span<const float> depth)
      : width_(projection.width), height_(projection.height) {
    discs_.resize(depth.size());
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const std::size_t i = index_of(x, y, width_);
        if (depth[i] >= kSky) continue;
        discs_[i].centre = projection.point(x, y, depth[i]);
        discs_[i].radius = 0;
      }
    }
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) shape(x, y);
    }
  }

  const Disc& at(int x, int y) const { return discs_[index_of(x, y, width_)]; }

  // Distance from a point to the disc of a pixel; infinite for sky.
  double distance(int x, int y, glm::dvec3 point) const {
    const Disc& disc = at(x, y);
    if (disc.radius < 0) return std::numeric_limits<double>::infinity();
    const glm::dvec3 d = point - disc.centre;
    const double along = glm::dot(d, disc.normal);
    const double beside = std::sqrt(std::max(glm::dot(d, d) - along * along, 0.0)) - disc.radius;
    return std::hypot(along, std::max(beside, 0.0));
  }

 private:
  // The nearer of the two neighbours on an axis lies on the same piece of surface, if any does.
  glm::dvec3 step(int x, int y, int dx, int dy) const {
    const glm::dvec3 here = at(x, y).centre;
    glm::dvec3 best(0.0);
    for (const int sign : {1, -1}) {
      const int nx = x + sign * dx, ny = y + sign * dy;
      if (nx < 0 || ny < 0 || nx >= width_ || ny >= height_ || at(nx, ny).radius < 0) continue;
      const glm::dvec3 way = (at(nx, ny).centre - here) * static_cast<double>(sign);
      if (best == glm::dvec3(0.0) || glm::dot(way, way) < glm::dot(best, best)) best = way;
    }
    return best;
  }

  void shape(int x, int y) {
    Disc& disc = discs_[index_of(x, y, width_)];
    if (disc.radius < 0) return;
    const glm::dvec3 across = step(x, y, 1, 0);
    const glm::dvec3 down = step(x, y, 0, 1);
    const glm::dvec3 normal = glm::cross(across, down);
    const double length = glm::length(normal);
    if (length == 0) return;  // a pixel alone: a point
    disc.normal = normal / length;
    disc.radius = 0.5 * std::sqrt(glm::dot(across, across) + glm::dot(down, down));
  }

  int width_, height_;
  std::vector<Disc> discs_;
};

// Looks at rings of pixels around (x, y) until none further out could hold a nearer disc.
double nearest_disc(const Discs& discs, const Projection& projection, int x, int y, glm::dvec3 point,
                    double pixels_per_step) {
  double best = discs.distance(x, y, point);
  for (int ring = 1; ring <= kMostRings && ring - 1 < best * pixels_per_step; ++ring) {
    const int top = y - ring, bottom = y + ring;
    for (int ny = std::max(top, 0); ny <= std::min(bottom, projection.height - 1); ++ny) {
      const int stride = ny == top || ny == bottom ? 1 : 2 * ring;
      for (int nx = x - ring; nx <= x + ring; nx += stride) {
        if (nx >= 0 && nx < projection.width) best = std::min(best, discs.distance(nx, ny, point));
      }
    }
  }
  return best;
}

}  // namespace

ErrorSummary summarise_errors(std::vector<float>& px) {
  ErrorSummary result;
  result.pixels = px.size();
  if (px.empty()) return result;
  std::sort(px.begin(), px.end());
  double sum = 0, squares = 0;
  for (const float e : px) {
    sum += double{e};
    squares += double{e} * double{e};
  }
  const auto count = static_cast<double>(px.size());
  const auto part = [&](double share) {
    return double{px[std::min(px.size() - 1, static_cast<std::size_t>(share * count))]};
  };
  result.mean = sum / count;
  result.rms = std::sqrt(squares / count);
  result.p50 = part(0.5);
  result.p95 = part(0.95);
  result.p99 = part(0.99);
  result.p999 = part(0.999);
  result.max = double{px.back()};
  return result;
}

void errors_against_elevation(const DepthPicture& picture, const WorldFrame& frame, const ElevationGrid& grid,
                              std::vector<float>& px) {
  const Projection projection(picture);
  const double step_m = frame.voxel_size_m / kStepsPerVoxel;
  const glm::dvec3 base_m = frame.origin_m + glm::dvec3(picture.camera.voxel) * frame.voxel_size_m;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const float depth = picture.depth[index_of(x, y, picture.width)];
      if (depth >= kSky) continue;
      const glm::dvec3 p = projection.point(x, y, depth);
      const glm::dvec3 world_m = base_m + p * step_m;
      if (!grid.inside(world_m.x, world_m.z, 2.0)) continue;
      const auto [low_m, high_m] = grid.range(world_m.x, world_m.z);
      const double height = (std::clamp(world_m.y, low_m, high_m) - base_m.y) / step_m;
      px.push_back(static_cast<float>(projection.pixels_from(x, y, {p.x, height, p.z})));
    }
  }
}

void errors_against_picture(const DepthPicture& picture, std::span<const float> reference,
                            std::vector<float>& px) {
  const Projection projection(picture);
  const Discs drawn(projection, picture.depth);
  const Discs wanted(projection, reference);
  const ErrorScale scale = make_error_scale(picture.camera, picture.width, picture.height, 1.0);
  const LodEye eye = make_lod_eye(picture.camera, scale.least_cos2);
  const glm::vec3 fine = picture.camera.fine;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const std::size_t i = index_of(x, y, picture.width);
      const float nearer = std::min(picture.depth[i], reference[i]);
      if (nearer >= kSky) continue;
      const glm::dvec3 p = projection.point(x, y, nearer);
      const float apparent = apparent_distance(glm::vec3(p) - fine, eye.forward, eye.least_cos2);
      const double pixels_per_step = double{scale.pixels} / std::max(double{apparent}, 1.0);
      const Discs& other = picture.depth[i] <= reference[i] ? wanted : drawn;
      const double distance = nearest_disc(other, projection, x, y, p, pixels_per_step);
      px.push_back(static_cast<float>(std::min(distance * pixels_per_step, double{kMostRings})));
    }
  }
}

double mean_colour_difference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (i % 4 != 3) sum += static_cast<std::uint64_t>(std::abs(int{a[i]} - int{b[i]}));
  }
  return static_cast<double>(sum) / (static_cast<double>(a.size()) * 0.75);
}

}  // namespace karst::bench
