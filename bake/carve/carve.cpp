// SPDX-License-Identifier: MIT
// Constructive solid geometry on distances: union is the maximum of "inside" values, subtraction the minimum
// with the negated shape; a blend replaces the kink by a parabola (Quilez, "Smooth minimum", 2013, quadratic
// form). Distances of the primitives: Quilez, "Distance functions", 2008.
#include "bake/carve/carve.h"

#include "bake/samples/noise.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace karst::bake {
namespace {

// Distances are right this far from a shape: FitHeights looks for crossings 1.5 voxels away.
constexpr double kReachVoxels = 2;

// Shapes summed over the columns they reach: 128 MiB. A thousand shapes as wide as the widest world fit.
constexpr std::size_t kMostColumnEntries = 1u << 24;
// Without being asked for: each costs some microseconds where its column is fitted.
constexpr std::size_t kFreeColumnEntries = 1u << 17;
constexpr std::size_t kFreeShapesAColumn = 4;

double box_distance(const CarveShape& box, glm::dvec3 p) {
  const glm::dvec3 q = glm::abs(p - box.centre_m) - (box.half_m - box.radius_m);
  const double outside = glm::length(glm::max(q, glm::dvec3(0.0)));
  return outside + std::min(std::max({q.x, q.y, q.z}), 0.0) - box.radius_m;
}

}  // namespace

Box CarveShape::bounds() const {
  if (kind == Kind::box) return {centre_m - half_m, centre_m + half_m};
  if (kind == Kind::sphere) return {centre_m - radius_m, centre_m + radius_m};
  Box box{points_m.front(), points_m.front()};
  for (const glm::dvec3& p : points_m) {
    box.min = glm::min(box.min, p);
    box.max = glm::max(box.max, p);
  }
  return {box.min - radius_m, box.max + radius_m};
}

CarvedSolid::CarvedSolid(const Solid& base, const std::vector<CarveShape>& shapes, const WorldGrid& grid)
    : base_(base),
      shapes_(shapes),
      grid_(grid),
      columns_(static_cast<std::size_t>(grid.extent.x) * static_cast<std::size_t>(grid.extent.z)) {}

Error CarvedSolid::build(std::size_t allowed) {
  std::size_t entries = 0;
  std::uint32_t shape = 0;
  const auto fits = [&](Piece piece, const Box& bounds) {
    shape = piece.shape;
    entries += columns_of(piece, bounds).count();
    return entries <= kMostColumnEntries;
  };
  if (!each_piece(fits)) {
    return "--carve: shape " + std::to_string(shape) +
           ": the shapes up to this one reach too many voxel columns together; carve with fewer or smaller "
           "ones";
  }
  if (entries > std::max(allowed, kFreeColumnEntries + kFreeShapesAColumn * columns_.size())) {
    return "--carve: the shapes reach " + std::to_string(entries) + " columns of voxels together, of " +
           std::to_string(columns_.size()) + "; carve with fewer or smaller ones, --max-carve " +
           std::to_string(entries) + " takes them";
  }
  each_piece([&](Piece piece, const Box& bounds) {
    const Columns reached = columns_of(piece, bounds);
    for (int z = reached.first_z; z <= reached.last_z; ++z) {
      for (int x = reached.first_x; x <= reached.last_x; ++x) {
        columns_[static_cast<std::size_t>(z) * static_cast<std::size_t>(grid_.extent.x) +
                 static_cast<std::size_t>(x)]
            .push_back(piece);
      }
    }
    return true;
  });
  return {};
}

// False where one visit was.
template <class Visit>
bool CarvedSolid::each_piece(const Visit& visit) const {
  for (std::uint32_t s = 0; s < shapes_.size(); ++s) {
    const CarveShape& shape = shapes_[s];
    if (shape.kind != CarveShape::Kind::capsule && !visit(Piece{s, 0}, shape.bounds())) return false;
    for (std::uint32_t k = 0; k + 1 < shape.points_m.size(); ++k) {
      const glm::dvec3 a = shape.points_m[k], b = shape.points_m[k + 1];
      const Box bounds{glm::min(a, b) - shape.radius_m, glm::max(a, b) + shape.radius_m};
      if (!visit(Piece{s, k}, bounds)) return false;
    }
  }
  return true;
}

CarvedSolid::Columns CarvedSolid::columns_of(Piece piece, const Box& bounds) const {
  const double reach_m = shapes_[piece.shape].blend_m + kReachVoxels * grid_.voxel_m;
  const glm::dvec3 low = (bounds.min - reach_m - grid_.origin_m) / grid_.voxel_m;
  const glm::dvec3 high = (bounds.max + reach_m - grid_.origin_m) / grid_.voxel_m;
  if (high.x < 0 || high.z < 0 || low.x > grid_.extent.x || low.z > grid_.extent.z) return {};
  const auto first = [](double v) { return static_cast<int>(std::floor(std::max(v, 0.0))); };
  const auto last = [](double v, int extent) {
    return static_cast<int>(std::floor(std::min(v, static_cast<double>(extent - 1))));
  };
  return {first(low.x), last(high.x, grid_.extent.x), first(low.z), last(high.z, grid_.extent.z)};
}

const std::vector<CarvedSolid::Piece>& CarvedSolid::column(double x_m, double z_m) const {
  const double x = std::floor((x_m - grid_.origin_m.x) / grid_.voxel_m);
  const double z = std::floor((z_m - grid_.origin_m.z) / grid_.voxel_m);
  const auto cx = static_cast<std::size_t>(std::clamp(x, 0.0, grid_.extent.x - 1.0));
  const auto cz = static_cast<std::size_t>(std::clamp(z, 0.0, grid_.extent.z - 1.0));
  return columns_[cz * static_cast<std::size_t>(grid_.extent.x) + cx];
}

double CarvedSolid::distance_m(Piece piece, glm::dvec3 p) const {
  const CarveShape& shape = shapes_[piece.shape];
  switch (shape.kind) {
    case CarveShape::Kind::box:
      return box_distance(shape, p);
    case CarveShape::Kind::sphere:
      return glm::length(p - shape.centre_m) - shape.radius_m;
    case CarveShape::Kind::capsule:
      break;
  }
  return segment_distance(shape.points_m[piece.segment], shape.points_m[piece.segment + 1], p) -
         shape.radius_m;
}

double CarvedSolid::value_m(glm::dvec3 position_m) const {
  double value = base_.value_m(position_m);
  const std::vector<Piece>& pieces = column(position_m.x, position_m.z);
  for (std::size_t k = 0; k < pieces.size();) {
    const std::uint32_t index = pieces[k].shape;
    double distance = std::numeric_limits<double>::infinity();
    for (; k < pieces.size() && pieces[k].shape == index; ++k) {
      distance = std::min(distance, distance_m(pieces[k], position_m));
    }
    const CarveShape& shape = shapes_[index];
    value = shape.fill ? smooth_max(value, -distance, shape.blend_m)
                       : -smooth_max(-value, -distance, shape.blend_m);
  }
  return value;
}

}  // namespace karst::bake
