// SPDX-License-Identifier: MIT
#include "terrain/ground/measure_ground.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "terrain/base/check.h"
#include "terrain/lod/morph.h"

namespace karst::core {
namespace {

constexpr double kSteepest = 1.1547005383792517;  // G: 2 / sqrt 3
constexpr double kSlack = 1.002;
constexpr double kKept = 1.0 - kMorphShare;
constexpr double kFloatSums = 1.0 + 1e-5;  // what sums of floats over all sizes lose at most

// A float of 12 bits that is not less.
float round_up(double value) {
  auto result = static_cast<float>(value);
  if (static_cast<double>(result) < value)
    result = std::nextafter(result, std::numeric_limits<float>::infinity());
  constexpr std::uint32_t kLow = 0xfff;
  return std::bit_cast<float>((std::bit_cast<std::uint32_t>(result) + kLow) & ~kLow);
}

bool is_power_of_two(double value) {
  int exponent = 0;
  return std::frexp(value, &exponent) == 0.5;
}

struct Reach {
  std::int32_t least, most;

  void take(std::int32_t value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

// What a child of a quad spans, in steps: a corner of the quad, two middles of edges and the centre, with
// their targets.
float tall_of(std::int32_t corner, const std::int32_t (&moved)[3], const std::int32_t (&targets)[3]) {
  Reach reach{2 * corner, 2 * corner};
  for (int n = 0; n < 3; ++n) {
    reach.take(2 * moved[n]);
    reach.take(targets[n]);
  }
  return static_cast<float>(reach.most - reach.least);
}

double length(double x, double y, double z) {
  return std::sqrt(x * x + y * y + z * z);
}

}  // namespace

void measure_quads(std::span<const std::int32_t> north, std::span<const std::int32_t> south,
                   const QuadRow& out) {
  const std::size_t quads = out.low.size();
  KARST_ASSERT(north.size() == quads + 1 && south.size() == quads + 1);
  for (std::size_t x = 0; x < quads; ++x) {
    out.low[x] = std::min(std::min(north[x], north[x + 1]), std::min(south[x], south[x + 1]));
    out.high[x] = std::max(std::max(north[x], north[x + 1]), std::max(south[x], south[x + 1]));
  }
  for (const auto* rows : {&out.below, &out.above}) {
    for (const std::span<float> row : *rows) std::fill(row.begin(), row.end(), 0.0f);
  }
  for (const std::span<float> row : out.border) std::fill(row.begin(), row.end(), 0.0f);
  std::fill(out.tall.begin(), out.tall.end(), 0.0f);
}

void repeat_quads(const QuadRow& above, const QuadRow& out) {
  std::copy(above.low.begin(), above.low.end(), out.low.begin());
  std::copy(above.high.begin(), above.high.end(), out.high.begin());
  for (const auto* rows : {&out.below, &out.above}) {
    for (const std::span<float> row : *rows) std::fill(row.begin(), row.end(), 0.0f);
  }
  for (const std::span<float> row : out.border) std::fill(row.begin(), row.end(), 0.0f);
  std::fill(out.tall.begin(), out.tall.end(), 0.0f);
}

void MeasureQuads::run() const {
  const auto wide = static_cast<std::size_t>(quads_along(*info, 0, size));
  const bool rows_end = ((k + 1) << size) > info->samples[1] - 1;
  const QuadRow& near = children[0];
  const QuadRow& far = children[1];
  for (std::size_t x = 0; x < wide; ++x) {
    const std::size_t west = 2 * x;
    const std::size_t east = 2 * x + 1;
    out.low[x] = std::min(std::min(near.low[west], near.low[east]), std::min(far.low[west], far.low[east]));
    out.high[x] =
        std::max(std::max(near.high[west], near.high[east]), std::max(far.high[west], far.high[east]));
    if (rows_end || static_cast<std::int64_t>(x + 1) << size > info->samples[0] - 1) {
      const float r = 2.0f * (static_cast<float>(out.high[x]) - static_cast<float>(out.low[x]));
      for (const std::size_t t : {0u, 1u}) {
        out.below[t][x] = -r;
        out.above[t][x] = r;
      }
      for (const std::span<float> row : out.border) row[x] = r;
      out.tall[x] = 2.0f * r;
      continue;
    }
    const std::int32_t* const n = heights[0].data() + west;
    const std::int32_t* const m = heights[1].data() + west;
    const std::int32_t* const s = heights[2].data() + west;
    const bool even = ((static_cast<std::int64_t>(x) + k) & 1) == 0;
    // Twice the targets, and so steps.
    const std::int32_t target[4] = {n[0] + s[0], s[0] + s[2], n[2] + s[2], n[0] + n[2]};
    const std::int32_t middle[4] = {m[0], s[1], m[2], n[1]};
    const std::int32_t centre_target = even ? n[0] + s[2] : n[2] + s[0];
    const float centre = static_cast<float>(2 * m[1] - centre_target);
    // I of the two children at each edge.
    const float low[4] = {std::min(near.below[1][west], far.below[0][west]),
                          std::min(far.below[1][west], far.below[1][east]),
                          std::min(near.below[1][east], far.below[0][east]),
                          std::min(near.below[0][west], near.below[0][east])};
    const float high[4] = {std::max(near.above[1][west], far.above[0][west]),
                           std::max(far.above[1][west], far.above[1][east]),
                           std::max(near.above[1][east], far.above[0][east]),
                           std::max(near.above[0][west], near.above[0][east])};
    float below[4];
    float above[4];
    for (std::size_t edge = 0; edge < 4; ++edge) {
      const float back = static_cast<float>(2 * middle[edge] - target[edge]);  // -way
      const float least = std::min(0.0f, back);
      const float most = std::max(0.0f, back);
      out.border[edge][x] = std::max(-(low[edge] + least), high[edge] + most);
      below[edge] = low[edge] + std::min(least, centre);
      above[edge] = high[edge] + std::max(most, centre);
    }
    const std::size_t with_north = even ? 2 : 0;  // the edge that triangle 0 has besides
    const std::size_t with_south = 2 - with_north;
    out.below[0][x] = std::min(below[3], below[with_north]);
    out.above[0][x] = std::max(above[3], above[with_north]);
    out.below[1][x] = std::min(below[1], below[with_south]);
    out.above[1][x] = std::max(above[1], above[with_south]);
    float tall = tall_of(n[0], {n[1], m[0], m[1]}, {target[3], target[0], centre_target});
    tall = std::max(tall, tall_of(n[2], {n[1], m[2], m[1]}, {target[3], target[2], centre_target}));
    tall = std::max(tall, tall_of(s[0], {s[1], m[0], m[1]}, {target[1], target[0], centre_target}));
    tall = std::max(tall, tall_of(s[2], {s[1], m[2], m[1]}, {target[1], target[2], centre_target}));
    out.tall[x] = tall + std::max(std::max(out.above[0][x], out.above[1][x]),
                                  -std::min(out.below[0][x], out.below[1][x]));
  }
  for (std::size_t x = wide; x < out.low.size(); ++x) {
    out.low[x] = out.low[wide - 1];
    out.high[x] = out.high[wide - 1];
    for (const std::size_t t : {0u, 1u}) out.below[t][x] = out.above[t][x] = 0;
    for (const std::span<float> row : out.border) row[x] = 0;
    out.tall[x] = 0;
  }
}

void gather_nodes(const GroundInfo& info, int size, std::int64_t k, const QuadRow& quads,
                  const NodeRow& out) {
  const auto wide = static_cast<std::size_t>(quads_along(info, 0, size));
  const bool first_row = k % kNodeQuads == 0;
  const bool last_row = k % kNodeQuads == kNodeQuads - 1 || k == quads_along(info, 1, size) - 1;
  if (first_row) {
    std::fill(out.low.begin(), out.low.end(), std::numeric_limits<std::int32_t>::max());
    std::fill(out.high.begin(), out.high.end(), std::numeric_limits<std::int32_t>::min());
    std::fill(out.full.begin(), out.full.end(), 0.0f);
    for (const std::span<float> row : out.border) std::fill(row.begin(), row.end(), 0.0f);
    std::fill(out.tall.begin(), out.tall.end(), 0.0f);
  }
  const auto raise = [](float& value, float other) { value = std::max(value, other); };
  for (std::size_t node = 0; node < out.low.size(); ++node) {
    const std::size_t begin = node * kNodeQuads;
    const std::size_t end = std::min(begin + kNodeQuads, wide);
    for (std::size_t x = begin; x < end; ++x) {
      out.low[node] = std::min(out.low[node], quads.low[x]);
      out.high[node] = std::max(out.high[node], quads.high[x]);
      if (size == 0) continue;
      for (const std::size_t t : {0u, 1u}) {
        raise(out.full[node], -quads.below[t][x]);
        raise(out.full[node], quads.above[t][x]);
      }
      if (last_row) raise(out.border[1][node], quads.border[1][x]);
      if (first_row) raise(out.border[3][node], quads.border[3][x]);
      raise(out.tall[node], quads.tall[x]);
    }
    raise(out.border[0][node], quads.border[0][begin]);
    raise(out.border[2][node], quads.border[2][end - 1]);
  }
}

void MeasureNodes::run() const {
  if (size == 0) {
    std::fill(own->error.begin(), own->error.end(), 0.0f);
    std::fill(own->chain.begin(), own->chain.end(), 0.0f);
    return;
  }
  const double unit = std::ldexp(1.0, size);
  const double half = unit / 2;
  const int axes = is_power_of_two(info->steps[0]) && is_power_of_two(info->steps[1]) ? 1 : 3;
  const double rounding = std::sqrt(static_cast<double>(axes)) * 2 * unit;
  const double quad[2] = {half * info->steps[0], half * info->steps[1]};
  const std::size_t nodes = own->low.size();
  for (std::size_t x = 0; x < nodes; ++x) {
    double error = double{own->full[x]};
    for (std::size_t edge = 0; edge < 4; ++edge)
      error = std::max(error, double{own->border[edge][x]} / kKept);
    const auto other_side = [&](const NodeRow* row, std::size_t at, std::size_t edge) {
      if (row != nullptr && at < nodes) error = std::max(error, double{row->border[edge][at]});
    };
    if (x > 0) other_side(own, x - 1, 2);
    other_side(own, x + 1, 0);
    other_side(north, x, 1);
    other_side(south, x, 3);
    error = error * kFloatSums + rounding;
    const double reach = length(quad[0], double{own->tall[x]} * kFloatSums, quad[1]) + 8 * unit;
    double chain = kSteepest * reach / kKept;
    for (const NodeRow* row : finer) {
      if (row == nullptr) continue;
      const std::size_t begin = 2 * x > 0 ? 2 * x - 1 : 0;
      const std::size_t end = std::min(2 * x + 3, row->low.size());
      for (std::size_t q = begin; q < end; ++q) {
        error = std::max(error, kSlack * double{row->error[q]} / kKept);
        const double tall = 2 * (static_cast<double>(row->high[q]) - row->low[q]) + 8 * half;
        const double rise =
            kSteepest * length(kNodeQuads * quad[0] + 4 * half, tall, kNodeQuads * quad[1] + 4 * half);
        chain = std::max(chain, (double{row->chain[q]} + rise) * kSlack / kKept + 8 * unit);
      }
    }
    own->error[x] = round_up(error);
    own->chain[x] = round_up(chain);
  }
}

}  // namespace karst::core
