// SPDX-License-Identifier: MIT
// Levels of eight patches in a row, four at a time: the very values of
// level_at(lod, least_apparent_distance(lod, eye)), which are what the formulas mean (morph.h).
#pragma once

#include <cstdint>

#include "terrain/base/simd.h"
#include "terrain/lod/morph.h"

namespace karst::core {

class LevelLanes {
 public:
  static constexpr std::uint32_t kPatches = 8;

  explicit LevelLanes(const LodEye& eye) : eye_(eye) {}

  // lods: of count patches, 1..8; levels: as many.
  void run(const PatchLod* lods, std::uint32_t count, std::uint8_t* levels) const {
    if (count < kPatches) {
      for (std::uint32_t i = 0; i < count; ++i) {
        levels[i] = static_cast<std::uint8_t>(level_at(lods[i], least_apparent_distance(lods[i], eye_)));
      }
      return;
    }
    std::int32_t half[kPatches];
    simd::store(half, halves(lods));
    simd::store(half + simd::kLanes, halves(lods + simd::kLanes));
    // Entries 0 and 1 of the thresholds are 0, which is above nothing.
    for (std::uint32_t i = 0; i < kPatches; ++i) {
      levels[i] = static_cast<std::uint8_t>(1 + simd::count_greater(lods[i].threshold, half[i]));
    }
  }

 private:
  // Of four patches: the distance as a half, cut off, 0 where it is nearer than any threshold (level_at).
  simd::Int4 halves(const PatchLod* lods) const {
    simd::Float4 apparent = simd::splat(-eye_.least_cos2);
    if (!(eye_.least_cos2 < 0.0f)) {
      simd::Int4 rows[4];  // centre and reach
      for (int i = 0; i < simd::kLanes; ++i) rows[i] = simd::load<simd::Int4>(lods[i].centre);
      simd::transpose(rows[0], rows[1], rows[2], rows[3]);
      apparent = least_apparent(simd::as_float(rows[0]), simd::as_float(rows[1]), simd::as_float(rows[2]),
                                simd::as_float(rows[3]));
    }
    const simd::Float4 units = apparent * simd::splat(1.0f / kThresholdUnit);
    // Cut off first: lanes below 0, which the mask clears, would overflow.
    const simd::Int4 half = (simd::as_int(units) >> 13) - simd::splat(std::int32_t{112 << 10});
    return half & (units > simd::splat(0x1p-14f));
  }

  simd::Float4 least_apparent(simd::Float4 x, simd::Float4 y, simd::Float4 z, simd::Float4 reach) const {
    const simd::Float4 zero = simd::splat(0.0f);
    const simd::Float4 dx = x - simd::splat(eye_.eye.x);
    const simd::Float4 dy = y - simd::splat(eye_.eye.y);
    const simd::Float4 dz = z - simd::splat(eye_.eye.z);
    const simd::Float4 r2 = dx * dx + dy * dy + dz * dz;
    const simd::Float4 r = simd::sqrt(r2);
    const simd::Float4 ahead = simd::max(dx * simd::splat(eye_.forward.x) + dy * simd::splat(eye_.forward.y) +
                                             dz * simd::splat(eye_.forward.z),
                                         zero);
    const simd::Float4 seen = simd::max(ahead * ahead, simd::splat(eye_.least_cos2) * r2);
    // The root of the greater of r2 and 1 is the greater of the roots.
    const simd::Float4 apparent = seen / simd::max(r, simd::splat(1.0f));
    return apparent - r * simd::splat(0x1p-18f) - (reach + simd::splat(2.0f));
  }

  LodEye eye_;
};

}  // namespace karst::core
