// SPDX-License-Identifier: MIT
#include "terrain/procedural/simplex_noise.h"

#include <cstring>

namespace karst::core {

using simd::Double2;
using simd::Float4;
using simd::Int4;
using simd::Long2;

namespace {

using Word4 = std::uint32_t __attribute__((vector_size(16)));

// From squares to triangles and back: (sqrt(3) - 1) / 2, (3 - sqrt(3)) / 6.
constexpr double kSkew = 0.36602540378443864676;
constexpr double kBack = 0.21132486540518711775;
constexpr float kBackFloat = static_cast<float>(kBack);
// The sum of kernels times unit gradients is 1 / 99.2 at most, and gradients are sqrt(2) long at most.
constexpr float kToOne = 70;

Long2 bits_of(Double2 v) {
  Long2 bits;
  std::memcpy(&bits, &v, sizeof bits);
  return bits;
}
Double2 of_bits(Long2 bits) {
  Double2 v;
  std::memcpy(&v, &bits, sizeof v);
  return v;
}

// The greatest whole number that is not above v; its low 32 bits as a word.
Double2 floor_of(Double2 v, Long2& word) {
  constexpr double kWhole = 6755399441055744.0;  // 1.5 x 2^52: sums are rounded to whole numbers
  Double2 whole = (v + kWhole) - kWhole;
  const Long2 is_above = whole > v;
  whole -= of_bits(is_above & bits_of(simd::splat(1.0)));
  word = bits_of(whole + kWhole);
  return whole;
}

Word4 low_words(Long2 a, Long2 b) {
  Word4 x, y;
  std::memcpy(&x, &a, sizeof x);
  std::memcpy(&y, &b, sizeof y);
  return __builtin_shufflevector(x, y, 0, 2, 4, 6);
}

// The finisher of a multiply-xorshift hash with the constants of C. Wellons, "Prospecting for hash functions"
// (2018), lowbias32.
Word4 mixed(Word4 x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}

// What the lattice point at a distance of (x, z) with that hash adds.
Float4 part(Word4 hash, Float4 x, Float4 z) {
  Int4 bits;
  std::memcpy(&bits, &hash, sizeof bits);
  const Float4 across = simd::to_float((bits << 16) >> 16), along = simd::to_float(bits >> 16);
  const Float4 near = simd::max(simd::splat(0.5f) - (x * x + z * z), simd::splat(0.0f));
  const Float4 square = near * near;
  return square * square * (across * x + along * z);
}

}  // namespace

Float4 to_float(const Places& p) {
#if defined(__SSE2__)
  return Float4(_mm_movelh_ps(_mm_cvtpd_ps(__m128d(p.first)), _mm_cvtpd_ps(__m128d(p.second))));
#else
  return Float4{static_cast<float>(p.first[0]), static_cast<float>(p.first[1]),
                static_cast<float>(p.second[0]), static_cast<float>(p.second[1])};
#endif
}

Float4 simplex_noise(const Places& x, const Places& z, std::uint32_t seed) {
  Long2 column[2], row[2];
  Places from_x, from_z;  // from the first corner
  const auto half = [&](Double2 a, Double2 b, int h, Double2& out_x, Double2& out_z) {
    const Double2 skew = (a + b) * kSkew;
    const Double2 i = floor_of(a + skew, column[h]), j = floor_of(b + skew, row[h]);
    const Double2 back = (i + j) * kBack;
    out_x = a - (i - back);
    out_z = b - (j - back);
  };
  half(x.first, z.first, 0, from_x.first, from_z.first);
  half(x.second, z.second, 1, from_x.second, from_z.second);
  const Float4 u = to_float(from_x), w = to_float(from_z);

  constexpr std::uint32_t kColumn = 0x9e3779b1u, kRow = 0x85ebca77u;
  const Word4 columns = low_words(column[0], column[1]) * kColumn;
  const Word4 rows = low_words(row[0], row[1]) * kRow;
  const std::uint32_t mark = seed * 0x27d4eb2fu;
  // Of the second corner: the one to the east, or to the south.
  const Int4 is_east = u > w;
  Word4 east;
  std::memcpy(&east, &is_east, sizeof east);
  const Float4 one = simd::splat(1.0f), none = simd::splat(0.0f);
  const Float4 step_x = simd::select(is_east, one, none), step_z = one - step_x;
  Float4 sum = part(mixed(columns ^ rows ^ mark), u, w);
  sum += part(mixed((columns + (east & kColumn)) ^ (rows + (~east & kRow)) ^ mark), u - step_x + kBackFloat,
              w - step_z + kBackFloat);
  sum += part(mixed((columns + kColumn) ^ (rows + kRow) ^ mark), u - 1.0f + 2 * kBackFloat,
              w - 1.0f + 2 * kBackFloat);
  return sum * (kToOne / 32768);
}

}  // namespace karst::core
