// SPDX-License-Identifier: MIT
// Encoding of EAC blocks: a base, a multiplier and one of 16 tables of eight modifiers.
// For each table, the multiplier that spans the texels' range and its neighbours; for each of those, the base
// that puts the range's ends on the table's, and bases near it.
#include <cstdlib>
#include <utility>

#include "etc2/etc2_blocks.h"

namespace karst::etc2 {
namespace {

// Eight texels in 16-bit lanes: differences of bytes fit, and their squares without a sign.
using Short8 = std::int16_t __attribute__((vector_size(16)));
using Unsigned8 = std::uint16_t __attribute__((vector_size(16)));

struct Alpha {
  int base = 0, multiplier = 0, table = 0;
  int error = std::numeric_limits<int>::max();
};

class AlphaSearch {
 public:
  explicit AlphaSearch(const BlockTexels& texels) {
    for (int p = 0; p < kTexels; ++p) {
      const int v = texels.rgba[p][3];
      texels_[p >> 3][p & 7] = static_cast<std::int16_t>(v);
      low_ = std::min(low_, v);
      high_ = std::max(high_, v);
    }
  }

  Alpha run() const {
    // Table 13 has a modifier of 0.
    if (low_ == high_) return {low_, 1, 13, 0};
    // Multipliers that span the range, about, and the base that puts the range's middle on the table's.
    Alpha starts[kStarts];
    for (int table = 0; table < kAlphaTables; ++table) {
      const int span = kAlphaModifiers[table][7] - kAlphaModifiers[table][3];
      const int fitting = (high_ - low_ + span / 2) / span;
      for (int multiplier = std::max(fitting - 1, 1); multiplier <= std::min(fitting + 1, 15); ++multiplier) {
        Alpha start{middle_base(multiplier, table), multiplier, table};
        start.error = error(start);
        if (start.error >= starts[kStarts - 1].error) continue;
        starts[kStarts - 1] = start;
        for (int k = kStarts - 1; k > 0 && starts[k].error < starts[k - 1].error; --k)
          std::swap(starts[k], starts[k - 1]);
      }
    }
    Alpha best = starts[0];
    for (const Alpha& start : starts) {
      if (start.error == std::numeric_limits<int>::max()) break;
      for (int k = -kReach; k <= kReach && best.error > 0; ++k) {
        Alpha moved = start;
        moved.base = clamp_byte(start.base + k);
        moved.error = error(moved);
        if (moved.error < best.error) best = moved;
      }
    }
    return best;
  }

  std::uint64_t indices(const Alpha& alpha) const {
    std::uint64_t bits = 0;
    for (int p = 0; p < kTexels; ++p) {
      int best = 0, least_distance = std::numeric_limits<int>::max();
      for (int i = 0; i < 8; ++i) {
        const int v = clamp_byte(alpha.base + alpha.multiplier * kAlphaModifiers[alpha.table][i]);
        const int distance = std::abs(v - texels_[p >> 3][p & 7]);
        if (distance >= least_distance) continue;
        least_distance = distance;
        best = i;
      }
      bits |= place(best, 45 - 3 * p);
    }
    return bits;
  }

 private:
  static constexpr int kStarts = 20;  // that are looked at closely; all 48 gain 0.04 dB
  static constexpr int kReach = 6;    // bases to either side of a start

  int middle_base(int multiplier, int table) const {
    const int ends = kAlphaModifiers[table][3] + kAlphaModifiers[table][7];
    return clamp_byte((low_ + high_ - multiplier * ends) / 2);
  }

  int error(const Alpha& alpha) const {
    Short8 nearest[2] = {};
    for (int i = 0; i < 8; ++i) {
      const auto v = static_cast<std::int16_t>(
          clamp_byte(alpha.base + alpha.multiplier * kAlphaModifiers[alpha.table][i]));
      for (int k = 0; k < 2; ++k) {
        const Short8 d = texels_[k] - v;
        const Short8 distance = d < -d ? -d : d;
        nearest[k] = i == 0 ? distance : (distance < nearest[k] ? distance : nearest[k]);
      }
    }
    // Squares have 16 bits; their low and high bytes are summed apart.
    Unsigned8 low{}, high{};
    for (const Short8& n : nearest) {
      const auto u = Unsigned8(n);
      low += (u * u) & 0xff;
      high += (u * u) >> 8;
    }
    int sum = 0;
    for (int lane = 0; lane < 8; ++lane) sum += low[lane] + 256 * high[lane];
    return sum;
  }

  Short8 texels_[2] = {};
  int low_ = 255, high_ = 0;
};

}  // namespace

Encoded encode_alpha(const BlockTexels& texels) {
  const AlphaSearch search(texels);
  const Alpha alpha = search.run();
  const std::uint64_t head = place(alpha.base, 56) | place(alpha.multiplier, 52) | place(alpha.table, 48);
  return {head | search.indices(alpha), alpha.error};
}

}  // namespace karst::etc2
