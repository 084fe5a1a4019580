// SPDX-License-Identifier: MIT
// Grounds on curved bases for tests: shapes, and heights that fit over the edges of a cube's faces.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "tests/support/memory_ground.h"

namespace karst::test {

using namespace core;

inline std::uint64_t mix_bits(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ x >> 27) * 0x94d049bb133111ebull;
  return x ^ x >> 31;
}

inline double voxel_m(const GroundInfo& info) {
  return info.basis.height_unit_m / kVertexStep * kStepsPerVoxel;
}

// A cube around a planet of any size.
inline GroundInfo planet(std::int32_t quads, double radius_m) {
  GroundInfo info;
  info.samples[0] = kCubeCells[0] * quads + 1;
  info.samples[1] = kCubeCells[1] * quads + 1;
  const double spacing_m = radius_m * 1.5707963267948966 / quads;
  info.steps[0] = info.steps[1] = kMostCurvedSteps;
  info.basis.kind = BasisKind::cube;
  info.basis.centred = true;
  info.basis.radius_m = radius_m;
  info.basis.face_quads = quads;
  info.basis.height_unit_m = spacing_m / kMostCurvedSteps * kVertexStep;
  EXPECT_TRUE(info.basis.finish().ok());
  return info;
}

// Longitude and latitude of a part of the ellipsoid.
inline GroundInfo region(std::int64_t wide, std::int64_t deep, double west, double north, double step_deg) {
  GroundInfo info;
  info.samples[0] = wide;
  info.samples[1] = deep;
  auto& basis = info.basis;
  basis.kind = BasisKind::geographic;
  basis.first[0] = west;
  basis.first[1] = north;
  basis.step[0] = step_deg;
  basis.step[1] = -step_deg;
  basis.anchor_deg[0] = west + 0.5 * step_deg * double(wide - 1);
  basis.anchor_deg[1] = north - 0.5 * step_deg * double(deep - 1);
  const double south = north - step_deg * double(deep - 1);
  const double equator = north * south <= 0 ? 0.0 : std::min(std::abs(north), std::abs(south));
  const double degree_m = 111'694.4;  // of latitude at the poles
  const double x_m = degree_m * step_deg * std::cos(equator * 0.017453292519943295),
               z_m = degree_m * step_deg;
  basis.height_unit_m = z_m / kMostCurvedSteps * kVertexStep;
  info.steps[1] = kMostCurvedSteps;
  info.steps[0] = std::max(kMostCurvedSteps * x_m / z_m, kLeastSampleSteps);
  EXPECT_TRUE(basis.finish().ok());
  return info;
}

inline GroundInfo tube(std::int64_t wide, std::int64_t deep, double radius_m, double spacing_m) {
  GroundInfo info;
  info.samples[0] = wide;
  info.samples[1] = deep;
  info.steps[0] = info.steps[1] = kMostCurvedSteps;
  auto& basis = info.basis;
  basis.kind = BasisKind::cylinder;
  basis.radius_m = radius_m;
  basis.step[0] = basis.step[1] = spacing_m;
  basis.first[0] = -0.5 * spacing_m * double(wide - 1);
  basis.first[1] = -0.5 * spacing_m * double(deep - 1);
  basis.height_unit_m = spacing_m / kMostCurvedSteps * kVertexStep;
  EXPECT_TRUE(basis.finish().ok());
  return info;
}

// Noise by place, so that what two faces share has one height.
inline MemoryGround::Heights noise_over(const GroundInfo& info, double rough) {
  return [info, rough](std::int64_t i, std::int64_t k) {
    int face = 0;
    if (info.is_cube()) {
      face = cube_home(info.basis.face_quads, i, k);
    }
    const glm::i64vec3 place = vertex_place(info.basis, face, axis_place(info.basis, 0, face, double(i)),
                                            axis_place(info.basis, 1, face, double(k)), 0.0);
    std::uint64_t h = 1;
    for (const std::int64_t v : {place.x, place.y, place.z}) h = mix_bits(h + static_cast<std::uint64_t>(v));
    return static_cast<std::int32_t>(rough * (double(h >> 11) * 0x1p-52 - 1.0));
  };
}

}  // namespace karst::test
