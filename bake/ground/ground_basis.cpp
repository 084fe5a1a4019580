// SPDX-License-Identifier: MIT
#include "bake/ground/ground_basis.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "bake/base/parallel.h"
#include "bake/rasters/ground_size.h"

namespace karst::bake {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::size_t kRowsAtOnce = 64;  // of a face, a thread
constexpr double kWideDegrees = 60;  // from here on a frame is centred: east and up of a middle mean little

bool is_whole_turn(const Elevation& facts, int width) {
  return std::abs(facts.earth.step_x * width - 360.0) < 0.5 * facts.earth.step_x;
}

}  // namespace

Georeference plane_earth(const Elevation& facts, int width, int height) {
  const ElevationEarth& from = facts.earth;
  Georeference earth;
  switch (from.kind) {
    case ElevationEarth::Kind::none:
      return earth;
    case ElevationEarth::Kind::degrees:
      earth.projection = MapProjection::degrees;
      break;
    case ElevationEarth::Kind::transverse_mercator:
      earth.projection = MapProjection::transverse_mercator;
      break;
    case ElevationEarth::Kind::other:
      earth.projection = MapProjection::other;
      break;
  }
  earth.epsg = from.epsg;
  earth.origin[0] = from.west + 0.5 * from.step_x * (width - 1);
  earth.origin[1] = from.north - 0.5 * from.step_z * (height - 1);
  earth.per_m[0] = from.step_x / facts.spacing_x_m;
  earth.per_m[1] = from.step_z / facts.spacing_z_m;
  earth.scale = from.scale;
  earth.latitude_deg = from.latitude_deg;
  earth.longitude_deg = from.longitude_deg;
  earth.false_east_m = from.false_east_m;
  earth.false_north_m = from.false_north_m;
  earth.unit_m = from.unit_m;
  return earth;
}

Error choose_basis(const Bake& job, const Elevation& facts, int width, int height, GroundInfo& info,
                   double (&spacing_m)[2]) {
  const std::string& path = job.read.path;
  const ElevationEarth& earth = facts.earth;
  Basis& basis = info.basis;
  info.samples[0] = width;
  info.samples[1] = height;
  if (job.basis.kind == BakeBasis::Kind::function) {
    basis.kind = BasisKind::function;
    const int samples[2] = {width, height};
    spacing_m[0] = facts.spacing_x_m;
    spacing_m[1] = facts.spacing_z_m;
    for (int axis = 0; axis < 2; ++axis) {
      basis.step[axis] = spacing_m[axis];
      basis.first[axis] = -0.5 * spacing_m[axis] * (samples[axis] - 1);
    }
    // A quad's diagonal on a sphere of that radius.
    const double across_m = std::hypot(spacing_m[0], spacing_m[1]);
    basis.function.turn_rad = across_m / job.basis.radius_m;
    basis.function.sagitta_m = across_m * basis.function.turn_rad / 8;
    return {};
  }
  if (job.basis.kind == BakeBasis::Kind::cylinder) {
    basis.kind = BasisKind::cylinder;
    spacing_m[0] = facts.spacing_x_m;
    spacing_m[1] = facts.spacing_z_m;
    basis.step[0] = spacing_m[0];
    basis.step[1] = spacing_m[1];
    basis.first[0] = -0.5 * spacing_m[0] * (width - 1);
    basis.first[1] = -0.5 * spacing_m[1] * (height - 1);
    const double around_m = spacing_m[0] * (width - 1);
    if (job.basis.radius_m == 0) {
      // Behind the last column comes the first one.
      basis.radius_m = spacing_m[0] * width / (2 * std::numbers::pi);
      ++info.samples[0];
      return {};
    }
    basis.radius_m = job.basis.radius_m;
    if (around_m > 2 * std::numbers::pi * std::abs(basis.radius_m) * (1 + 1e-9)) {
      return path + ": is wider than once around a cylinder of that radius; --basis cylinder:" +
             std::to_string(std::ceil(around_m / (2 * std::numbers::pi))) + " is the least";
    }
    return {};
  }
  if (earth.kind != ElevationEarth::Kind::degrees) {
    return path + ": is not in degrees of longitude and latitude; " +
           (earth.kind == ElevationEarth::Kind::none
                ? "--crs EPSG:4326 --bounds W,S,E,N says where it lies"
                : "gdalwarp -t_srs EPSG:4326 makes it so, or use --basis plane");
  }
  basis.radius_m = earth.radius_m;
  basis.flattening = earth.flattening;
  const double last_latitude = earth.north - earth.step_z * (height - 1);
  if (!(std::abs(earth.north) <= 90 && std::abs(last_latitude) <= 90))
    return path + ": its latitudes go beyond a pole; --bounds W,S,E,N gives the right ones";
  if (job.basis.kind == BakeBasis::Kind::cube) {
    basis.kind = BasisKind::cube;
    basis.centred = true;
    if (Error error = CubeRows::face_quads(facts, width, height, path, basis.face_quads); !error.ok())
      return error;
    for (int axis = 0; axis < 2; ++axis)
      info.samples[axis] = std::int64_t{kCubeCells[axis]} * basis.face_quads + 1;
    spacing_m[0] = spacing_m[1] = 90 * kDegree * earth.radius_m / basis.face_quads;
    return {};
  }
  basis.kind = BasisKind::geographic;
  basis.first[0] = earth.west;
  basis.first[1] = earth.north;
  basis.step[0] = earth.step_x;
  basis.step[1] = -earth.step_z;
  basis.anchor_deg[0] = earth.west + 0.5 * earth.step_x * (width - 1);
  basis.anchor_deg[1] = 0.5 * (earth.north + last_latitude);
  basis.centred = std::max(earth.step_x * width, earth.step_z * height) > kWideDegrees;
  if (basis.centred) basis.anchor_deg[0] = basis.anchor_deg[1] = 0;
  // The widest row is the one nearest to the equator; degrees of latitude are longest at the poles.
  const double widest =
      earth.north * last_latitude <= 0 ? 0.0 : std::min(std::abs(earth.north), std::abs(last_latitude));
  const Ellipsoid ellipsoid{earth.radius_m, earth.flattening};
  spacing_m[0] = earth.step_x * metres_per_degree(widest, ellipsoid).x;
  spacing_m[1] = earth.step_z * earth.radius_m / (1 - earth.flattening) * kDegree;
  if (is_whole_turn(facts, width)) {
    // Behind the last column comes the first one.
    basis.step[0] = 360.0 / width;
    ++info.samples[0];
  } else if (is_whole_turn(facts, width - 1)) {
    basis.step[0] = 360.0 / (width - 1);
  }
  return {};
}

Error CubeRows::face_quads(const Elevation& facts, int width, int height, const std::string& path,
                           std::int32_t& quads) {
  const ElevationEarth& earth = facts.earth;
  const bool whole = is_whole_turn(facts, width) && earth.north + earth.step_z >= 90 - 1e-6 &&
                     earth.north - earth.step_z * height <= -90 + 1e-6;
  if (!whole) {
    return path + ": is not the whole planet, which a cube is; use --basis geographic for a part of it";
  }
  quads = 4;
  while (quads < kMostFaceQuads && 90.0 / quads > std::min(earth.step_x, earth.step_z) * 1.001) quads *= 2;
  return {};
}

float CubeRows::Source::at(double longitude_deg, double latitude_deg) const {
  double x = (longitude_deg - earth.west) / earth.step_x;
  x -= std::floor(x / width) * width;
  const double y = std::clamp((earth.north - latitude_deg) / earth.step_z, 0.0, height - 1.0);
  const int column = std::min(static_cast<int>(x), width - 1),
            row = std::min(static_cast<int>(y), height - 2);
  const double u = x - column, v = y - row;
  const auto height_at = [&](int i, int k) { return double{samples.at((column + i) % width, row + k)}; };
  const double north = height_at(0, 0) + u * (height_at(1, 0) - height_at(0, 0));
  const double south = height_at(0, 1) + u * (height_at(1, 1) - height_at(0, 1));
  return static_cast<float>(north + v * (south - north));
}

void CubeRows::fill_row(const Source& source, const Basis& basis, int face, std::int64_t k) {
  int x = 0, z = 0;
  cube_cell(face, x, z);
  const AxisPlace v = axis_place(basis, 1, face, static_cast<double>(z * quads_ + k));
  for (std::int64_t i = 0; i <= quads_; ++i) {
    const AxisPlace u = axis_place(basis, 0, face, static_cast<double>(x * quads_ + i));
    // Edges of two faces have the same bits, so the same height.
    Geodetic place;
    const bool known = geodetic_of(basis, place_m(basis, face, u, v, 0.0), place);
    faces_.set(i, face * (quads_ + 1) + k, known ? source.at(place.longitude_deg, place.latitude_deg) : 0.0f);
  }
}

Error CubeRows::open(GroundRows& rows, const Basis& basis, const ReportProgress& progress) {
  Source source;
  source.earth = rows.facts().earth;
  source.width = rows.width();
  source.height = rows.height();
  if (Error error = source.samples.open(source.width, source.height, held_bytes, folder); !error.ok())
    return error;
  std::int64_t row = 0;
  const auto keep = [&](std::span<const float> heights) {
    for (int n = 0; n < source.width; ++n) source.samples.set(n, row, heights[static_cast<std::size_t>(n)]);
    ++row;
    return true;
  };
  if (Error error = rows.run(keep); !error.ok()) return error;
  quads_ = basis.face_quads;
  const std::int64_t side = quads_ + 1;
  if (Error error = faces_.open(side, kCubeFaces * side, held_bytes, folder); !error.ok()) return error;
  std::atomic<std::int64_t> done = 0;
  parallel_chunks(static_cast<std::size_t>(kCubeFaces * side), kRowsAtOnce, threads,
                  [&](std::size_t first, std::size_t last, int worker) {
                    for (auto n = static_cast<std::int64_t>(first); n < static_cast<std::int64_t>(last); ++n)
                      fill_row(source, basis, static_cast<int>(n / side), n % side);
                    done += static_cast<std::int64_t>(last - first);
                    if (worker == 0 && progress) {
                      progress("faces", static_cast<std::uint64_t>(done),
                               static_cast<std::uint64_t>(kCubeFaces * side));
                    }
                  });
  return {};
}

void CubeRows::run(const GroundRows::Take& take) const {
  std::vector<float> row(static_cast<std::size_t>(kCubeCells[0] * quads_ + 1));
  for (std::int64_t k = 0; k <= kCubeCells[1] * quads_; ++k) {
    for (std::int64_t i = 0; i <= kCubeCells[0] * quads_; ++i) {
      std::int64_t home_i = i, home_k = k;
      const int face = cube_home(quads_, home_i, home_k);
      int x = 0, z = 0;
      cube_cell(face, x, z);
      row[static_cast<std::size_t>(i)] =
          faces_.at(home_i - x * quads_, face * (quads_ + 1) + home_k - z * quads_);
    }
    if (!take(row)) return;
  }
}

}  // namespace karst::bake
