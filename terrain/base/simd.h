// SPDX-License-Identifier: MIT
// Four lanes of float or int32, two of double, as compiler vector types: SSE2 or NEON where the target has
// them, plain scalar code elsewhere. Every operation is lane-wise IEEE arithmetic without contraction, so the
// bits are the same on all of them.
#pragma once

#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#else
#include <cmath>
#endif

namespace karst::core::simd {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));
using Short4 = std::int16_t __attribute__((vector_size(8)));
using Double2 = double __attribute__((vector_size(16)));
using Long2 = std::int64_t __attribute__((vector_size(16)));

inline constexpr int kLanes = 4;

inline Float4 splat(float v) {
  return Float4{v, v, v, v};
}
inline Int4 splat(std::int32_t v) {
  return Int4{v, v, v, v};
}

template <class Vector, class T>
inline Vector load(const T* p) {
  Vector v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
inline Float4 load(const float* p) {
  return load<Float4>(p);
}
inline Int4 load(const std::int32_t* p) {
  return load<Int4>(p);
}

inline void store(float* p, Float4 v) {
  std::memcpy(p, &v, sizeof v);
}
inline void store(std::int32_t* p, Int4 v) {
  std::memcpy(p, &v, sizeof v);
}
inline void store(void* p, Int4 v) {
  std::memcpy(p, &v, sizeof v);
}

// Towards zero. Precondition: |v| < 2^31.
inline Int4 to_int(Float4 v) {
  return __builtin_convertvector(v, Int4);
}
inline Int4 to_int(Short4 v) {
  return __builtin_convertvector(v, Int4);
}
inline Float4 to_float(Int4 v) {
  return __builtin_convertvector(v, Float4);
}

inline Float4 as_float(Int4 v) {
  Float4 r;
  std::memcpy(&r, &v, sizeof r);
  return r;
}
inline Int4 as_int(Float4 v) {
  Int4 r;
  std::memcpy(&r, &v, sizeof r);
  return r;
}

// mask lanes are 0 or -1.
inline Int4 select(Int4 mask, Int4 a, Int4 b) {
  return (mask & a) | (~mask & b);
}
inline Float4 select(Int4 mask, Float4 a, Float4 b) {
  return as_float(select(mask, as_int(a), as_int(b)));
}

inline Float4 abs(Float4 v) {
  return as_float(as_int(v) & 0x7fffffff);
}
inline Float4 copy_sign(Float4 magnitude, Float4 sign) {
  const Int4 bit = splat(std::int32_t{INT32_MIN});
  return as_float((as_int(magnitude) & ~bit) | (as_int(sign) & bit));
}
// a > b ? a : b, and a < b ? a : b.
inline Float4 max(Float4 a, Float4 b) {
#if defined(__SSE2__)
  return Float4(_mm_max_ps(__m128(a), __m128(b)));
#else
  return select(a > b, a, b);
#endif
}
inline Float4 min(Float4 a, Float4 b) {
#if defined(__SSE2__)
  return Float4(_mm_min_ps(__m128(a), __m128(b)));
#else
  return select(a < b, a, b);
#endif
}

// True when any lane of the mask is set.
inline bool any(Int4 mask) {
#if defined(__SSE2__)
  return _mm_movemask_ps(__m128(as_float(mask))) != 0;
#else
  return (mask[0] | mask[1] | mask[2] | mask[3]) != 0;
#endif
}

// Bit l: lane l of the mask is set.
inline unsigned lanes(Int4 mask) {
#if defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_ps(__m128(as_float(mask))));
#else
  return static_cast<unsigned>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

// Bit n: value n of sixteen is below 0.
inline std::uint32_t signs(const std::int8_t* sixteen) {
#if defined(__SSE2__)
  return static_cast<std::uint32_t>(_mm_movemask_epi8(load<__m128i>(sixteen)));
#else
  std::uint32_t bits = 0;
  for (int i = 0; i < 16; ++i) bits |= static_cast<std::uint32_t>(sixteen[i] < 0) << i;
  return bits;
#endif
}
inline std::uint32_t signs(const std::int16_t* sixteen) {
#if defined(__SSE2__)
  return static_cast<std::uint32_t>(
      _mm_movemask_epi8(_mm_packs_epi16(load<__m128i>(sixteen), load<__m128i>(sixteen + 8))));
#else
  std::uint32_t bits = 0;
  for (int i = 0; i < 16; ++i) bits |= static_cast<std::uint32_t>(sixteen[i] < 0) << i;
  return bits;
#endif
}

// How many of eight values, each within 0..0x7fff, are greater than v, which is, too.
inline int count_greater(const std::uint16_t* eight, std::int32_t v) {
#if defined(__SSE2__)
  const __m128i greater = _mm_cmpgt_epi16(load<__m128i>(eight), _mm_set1_epi16(static_cast<std::int16_t>(v)));
  const __m128i sums = _mm_sad_epu8(_mm_and_si128(greater, _mm_set1_epi16(1)), _mm_setzero_si128());
  return _mm_cvtsi128_si32(sums) + _mm_extract_epi16(sums, 4);
#else
  int count = 0;
  for (int i = 0; i < 8; ++i) count += eight[i] > v ? 1 : 0;
  return count;
#endif
}

// Correctly rounded on every target.
inline Float4 sqrt(Float4 v) {
#if defined(__SSE2__)
  return Float4(_mm_sqrt_ps(__m128(v)));
#elif defined(__aarch64__)
  return Float4(vsqrtq_f32(float32x4_t(v)));
#else
  return Float4{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
#endif
}

// --- Two doubles

inline Double2 splat(double v) {
  return Double2{v, v};
}
inline Double2 load(const double* p) {
  return load<Double2>(p);
}
inline void store(double* p, Double2 v) {
  std::memcpy(p, &v, sizeof v);
}
// Lanes 0 and 1.
inline Double2 to_double(Int4 v) {
#if defined(__SSE2__)
  return Double2(_mm_cvtepi32_pd(__m128i(v)));
#else
  return Double2{static_cast<double>(v[0]), static_cast<double>(v[1])};
#endif
}
// a > b ? a : b, and a < b ? a : b.
inline Double2 max(Double2 a, Double2 b) {
#if defined(__SSE2__)
  return Double2(_mm_max_pd(__m128d(a), __m128d(b)));
#else
  return Double2{a[0] > b[0] ? a[0] : b[0], a[1] > b[1] ? a[1] : b[1]};
#endif
}
inline Double2 min(Double2 a, Double2 b) {
#if defined(__SSE2__)
  return Double2(_mm_min_pd(__m128d(a), __m128d(b)));
#else
  return Double2{a[0] < b[0] ? a[0] : b[0], a[1] < b[1] ? a[1] : b[1]};
#endif
}
inline Double2 sqrt(Double2 v) {
#if defined(__SSE2__)
  return Double2(_mm_sqrt_pd(__m128d(v)));
#else
  return Double2{__builtin_sqrt(v[0]), __builtin_sqrt(v[1])};
#endif
}
inline bool any(Long2 mask) {
  return (mask[0] | mask[1]) != 0;
}
inline Double2 as_double(Long2 v) {
  Double2 r;
  std::memcpy(&r, &v, sizeof r);
  return r;
}
inline Long2 as_long(Double2 v) {
  Long2 r;
  std::memcpy(&r, &v, sizeof r);
  return r;
}
// mask lanes are 0 or -1.
inline Double2 select(Long2 mask, Double2 a, Double2 b) {
  return as_double((mask & as_long(a)) | (~mask & as_long(b)));
}
inline Double2 abs(Double2 v) {
  return as_double(as_long(v) & INT64_MAX);
}
// Precondition: |v| < 2^51.
inline Double2 floor(Double2 v) {
  constexpr double kUnits = 0x1.8p52;  // doubles there are whole numbers
  const Double2 nearest = (v + kUnits) - kUnits;
  const Long2 above = nearest > v;
  return nearest - select(above, splat(1.0), splat(0.0));
}

// Rows become columns.
inline void transpose(Int4& a, Int4& b, Int4& c, Int4& d) {
  const Int4 ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const Int4 ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Int4 cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Int4 cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  a = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
  c = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
  d = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
}

}  // namespace karst::core::simd
