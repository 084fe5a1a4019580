// SPDX-License-Identifier: MIT
// Encoding of individual and differential blocks: two halves, left and right or top and bottom, each a colour
// plus one of four offsets along grey a texel.
//
// Along grey, an offset m of a colour changes a texel's error from C to C + W m^2 + 2 m D, where D is the
// weighted sum of the colour's differences to the texel and W the sum of weights: with C and |D| once, the
// errors of all tables cost a few operations each. Only where an offset would leave 0..255 is the error less,
// and looked up.
//
// The best colour lies near the line through the half's mean along grey, for all that offsets can do is move
// along grey. So the search runs along that line, for all tables, and then descends from the best places by
// single steps. In differential blocks the second colour lies near the first: where the best ones do not,
// each is tried with the other near it.
#include <array>
#include <cstdlib>

#include "etc2/etc2_blocks.h"

namespace karst::etc2 {
namespace {

// A colour of 4 or 5 bits a channel.
struct Levels {
  int of[kChannels] = {};

  int& operator[](int channel) { return of[channel]; }
  int operator[](int channel) const { return of[channel]; }
  bool operator==(const Levels&) const = default;
};

struct Box {
  Levels low, high;
};

struct HalfFit {
  Levels colour;
  int table = 0;
  int error = std::numeric_limits<int>::max();
};

// Moves of the descent.
constexpr int kMoves[8][kChannels] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0},
                                      {0, 0, 1}, {0, 0, -1}, {1, 1, 1}, {-1, -1, -1}};

// How far from the mean, in levels, a table's best colour is sought: were all offsets of one sign but one of
// eight, the mean would lie 3/4 of the largest from the colour.
int reach_of(int table, int bits) {
  return kModifiers[table][1] * 3 / 4 * ((1 << bits) - 1) / 255 + 1;
}

class Half {
 public:
  Half(const BlockTexels& texels, const ErrorRows& rows, bool flip, int half)
      : rows_(rows), vectors_{flip ? half : 2 * half, flip ? half + 2 : 2 * half + 1} {
    for (int k = 0; k < 2; ++k) {
      for (int lane = 0; lane < simd::kLanes; ++lane) {
        for (int c = 0; c < kChannels; ++c) {
          const int v = texels.rgba[lane_texel(vectors_[k], lane)][c];
          sum_[c] += v;
          weighted_[k][lane] += rows.weights[c] * v;
        }
      }
    }
    total_weight_ = rows.weights[0] + rows.weights[1] + rows.weights[2];
    int low = weighted_[0][0], high = low;
    for (const simd::Int4& values : weighted_) {
      for (int lane = 0; lane < simd::kLanes; ++lane) {
        low = std::min(low, values[lane]);
        high = std::max(high, values[lane]);
      }
    }
    // A table whose offsets are further apart than the texels has no use for a second one.
    while (tables_ < kTables && 2 * kModifiers[tables_][0] * total_weight_ <= high - low) ++tables_;
  }

  // The best colour of `bits` bits a channel within a box.
  HalfFit fit(int bits, const Box& box) const {
    HalfFit found[kTables];
    search_along_grey(bits, box, found);
    int best = std::numeric_limits<int>::max();
    for (const HalfFit& start : found) best = std::min(best, start.error);
    HalfFit result;
    for (HalfFit& start : found) {
      // One that is further behind hardly ever comes out first.
      if (start.error > std::int64_t{best} * 5 / 4) continue;
      start.error = error(start.colour, bits, start.table);
      descend(start, bits, box);
      if (start.error < result.error) result = start;
    }
    return result;
  }

  // Bits 0..15 and 16..31 of a block, of this half's texels.
  std::uint64_t indices(const HalfFit& fit, int bits) const {
    Paints paints;
    for (int i = 0; i < 4; ++i) {
      for (int c = 0; c < kChannels; ++c)
        paints.colour[i][c] = clamp_byte(extend(fit.colour[c], bits) + modifier(fit.table, i));
    }
    return paint_indices(rows_, paints, vectors_, 2);
  }

 private:
  // What a colour without offset leaves: C and |D| of this file's head. Floats hold these integers exactly.
  struct Unmoved {
    simd::Float4 error[2], slope[2];
  };
  Unmoved unmoved(const int (&base)[kChannels]) const {
    int sum = 0;
    for (int c = 0; c < kChannels; ++c) sum += rows_.weights[c] * base[c];
    Unmoved result;
    for (int k = 0; k < 2; ++k) {
      const int vector = vectors_[k];
      const simd::Int4 e =
          rows_.of[0][base[0]][vector] + rows_.of[1][base[1]][vector] + rows_.of[2][base[2]][vector];
      result.error[k] = simd::to_float(e);
      result.slope[k] = simd::abs(simd::to_float(simd::splat(sum) - weighted_[k]));
    }
    return result;
  }
  int moved_error(const Unmoved& from, int table) const {
    simd::Int4 sum{};
    const int small = kModifiers[table][0], large = kModifiers[table][1];
    const auto squares = [&](int m) { return simd::splat(static_cast<float>(total_weight_ * m * m)); };
    for (int k = 0; k < 2; ++k) {
      const simd::Float4 by_small = squares(small) - from.slope[k] * static_cast<float>(2 * small);
      const simd::Float4 by_large = squares(large) - from.slope[k] * static_cast<float>(2 * large);
      sum += simd::to_int(from.error[k] + simd::min(by_small, by_large));
    }
    return sum_of(sum);
  }

  int error(const Levels& colour, int bits, int table) const {
    int base[kChannels];
    for (int c = 0; c < kChannels; ++c) base[c] = extend(colour[c], bits);
    const auto [low, high] = std::minmax({base[0], base[1], base[2]});
    const int large = kModifiers[table][1];
    return low - large < 0 || high + large > 255 ? clamped_error(base, table)
                                                 : moved_error(unmoved(base), table);
  }
  int clamped_error(const int (&base)[kChannels], int table) const {
    simd::Int4 sum{};
    for (const int vector : vectors_) {
      simd::Int4 best = simd::splat(std::numeric_limits<int>::max());
      for (int i = 0; i < 4; ++i) {
        const int m = modifier(table, i);
        best = least(best, rows_.of[0][clamp_byte(base[0] + m)][vector] +
                               rows_.of[1][clamp_byte(base[1] + m)][vector] +
                               rows_.of[2][clamp_byte(base[2] + m)][vector]);
      }
      sum += best;
    }
    return sum_of(sum);
  }

  // For each table the best colour on the line; errors as if nothing were clamped.
  void search_along_grey(int bits, const Box& box, HalfFit (&found)[kTables]) const {
    const int most = (1 << bits) - 1;
    Levels mean;
    for (int c = 0; c < kChannels; ++c) mean[c] = (sum_[c] * most + 4 * 255) / (8 * 255);
    Levels last{{-1, -1, -1}};
    const int longest = reach_of(tables_ - 1, bits);
    for (int k = -longest; k <= longest; ++k) {
      Levels colour;
      int base[kChannels];
      for (int c = 0; c < kChannels; ++c) {
        colour[c] = std::clamp(mean[c] + k, box.low[c], box.high[c]);
        base[c] = extend(colour[c], bits);
      }
      if (colour == last) continue;
      last = colour;
      const Unmoved from = unmoved(base);
      for (int table = tables_ - 1; table >= 0; --table) {
        // In a box the line ends where the nearest colours are.
        if (reach_of(table, bits) < std::abs(k)) break;
        const int e = moved_error(from, table);
        if (e < found[table].error) found[table] = {colour, table, e};
      }
    }
  }

  void descend(HalfFit& at, int bits, const Box& box) const {
    for (bool moved = true; moved && at.error > 0;) {
      moved = false;
      for (const auto& move : kMoves) {
        Levels colour = at.colour;
        bool inside = true;
        for (int c = 0; c < kChannels; ++c) {
          colour[c] += move[c];
          inside = inside && colour[c] >= box.low[c] && colour[c] <= box.high[c];
        }
        if (!inside) continue;
        const int e = error(colour, bits, at.table);
        if (e >= at.error) continue;
        at.colour = colour;
        at.error = e;
        moved = true;
      }
    }
  }

  const ErrorRows& rows_;
  int vectors_[2];
  int sum_[kChannels] = {};
  int total_weight_ = 0;
  int tables_ = 2;               // the first so many are tried
  simd::Int4 weighted_[2] = {};  // sums of weight times value
};

Box whole(int bits) {
  const int most = (1 << bits) - 1;
  return {{{0, 0, 0}}, {{most, most, most}}};
}

// Colours of 5 bits from `below` under to `above` over the given one.
Box around(const Levels& colour, int below, int above) {
  Box box;
  for (int c = 0; c < kChannels; ++c) {
    box.low[c] = std::max(colour[c] - below, 0);
    box.high[c] = std::min(colour[c] + above, 31);
  }
  return box;
}

// The second colour minus the first must fit in three bits with sign.
bool near(const Levels& first, const Levels& second) {
  for (int c = 0; c < kChannels; ++c) {
    const int d = second[c] - first[c];
    if (d < -4 || d > 3) return false;
  }
  return true;
}

using Fits = std::array<HalfFit, 2>;

std::int64_t total(const Fits& fits) {
  return std::int64_t{fits[0].error} + fits[1].error;
}

// The best two colours near each other; or any whose error is not below the limit, where none is likely to
// be.
Fits fit_near(const Half (&halves)[2], int limit) {
  const Fits best = {halves[0].fit(5, whole(5)), halves[1].fit(5, whole(5))};
  if (near(best[0].colour, best[1].colour) || total(best) >= limit) return best;
  const Fits first = {best[0], halves[1].fit(5, around(best[0].colour, 4, 3))};
  const Fits second = {halves[0].fit(5, around(best[1].colour, 3, 4)), best[1]};
  // Both give way: any two colours of a box of five levels a side are near.
  Levels middle;
  for (int c = 0; c < kChannels; ++c) middle[c] = (best[0].colour[c] + best[1].colour[c] + 1) / 2;
  const Box box = around(middle, 2, 1);
  Fits both = {halves[0].fit(5, box), halves[1].fit(5, box)};
  // Then each once more, as far from the other as may be.
  both[0] = halves[0].fit(5, around(both[1].colour, 3, 4));
  both[1] = halves[1].fit(5, around(both[0].colour, 4, 3));
  const Fits& one = total(first) <= total(second) ? first : second;
  return total(one) <= total(both) ? one : both;
}

std::uint64_t common_bits(const Fits& fits, bool flip) {
  return place(fits[0].table, 37) | place(fits[1].table, 34) | place(flip ? 1 : 0, kFlipBit);
}

}  // namespace

Encoded encode_individual(const BlockTexels& texels, const ErrorRows& rows) {
  Encoded best;
  for (const bool flip : {false, true}) {
    const Half halves[2] = {{texels, rows, flip, 0}, {texels, rows, flip, 1}};
    const Fits fits = {halves[0].fit(4, whole(4)), halves[1].fit(4, whole(4))};
    if (total(fits) >= best.error) continue;
    std::uint64_t bits = common_bits(fits, flip);
    for (int c = 0; c < kChannels; ++c) {
      bits |= place(fits[0].colour[c], 60 - 8 * c) | place(fits[1].colour[c], 56 - 8 * c);
    }
    bits |= halves[0].indices(fits[0], 4) | halves[1].indices(fits[1], 4);
    best = {bits, static_cast<int>(total(fits))};
  }
  return best;
}

Encoded encode_differential(const BlockTexels& texels, const ErrorRows& rows, int limit) {
  Encoded best;
  best.error = limit;
  for (const bool flip : {false, true}) {
    const Half halves[2] = {{texels, rows, flip, 0}, {texels, rows, flip, 1}};
    const Fits fits = fit_near(halves, best.error);
    if (total(fits) >= best.error) continue;
    std::uint64_t bits = common_bits(fits, flip) | place(1, kDifferentialBit);
    for (int c = 0; c < kChannels; ++c) {
      const int difference = fits[1].colour[c] - fits[0].colour[c];
      bits |= place(fits[0].colour[c], 59 - 8 * c) | place(difference & 7, 56 - 8 * c);
    }
    bits |= halves[0].indices(fits[0], 5) | halves[1].indices(fits[1], 5);
    best = {bits, static_cast<int>(total(fits))};
  }
  return best;
}

}  // namespace karst::etc2
