// SPDX-License-Identifier: MIT
// While it runs, a patch is new whose height_block is kUnmade; its block holds what is known so far.
#include "terrain/edit/shape/new_heights.h"

#include <algorithm>
#include <cstring>

#include "terrain/base/check.h"
#include "terrain/base/simd.h"
#include "terrain/patch/corner_fan.h"
#include "terrain/patch/displacement.h"

namespace karst::core {
namespace {

constexpr std::uint32_t kUnmade = kNoHeights - 1;

// Rounds over the corners between new patches.
constexpr int kRounds = 8;

struct GridPlace {
  int i, j;
};

GridPlace corner_place(int corner, int n) {
  return {corner == 1 || corner == 2 ? n : 0, corner >= 2 ? n : 0};
}

// To the nearest integer, halves away from 0. count > 0.
std::int32_t divide(std::int64_t sum, std::int64_t count) {
  const std::int64_t half = count / 2;
  return static_cast<std::int32_t>((sum < 0 ? sum - half : sum + half) / count);
}

// A sum over n^2, to the nearest, halves away from 0, within kMaxHeight.
std::int16_t blended(std::int32_t sum, int level) {
  const std::int32_t size = ((sum < 0 ? -sum : sum) + (1 << (2 * level - 1))) >> (2 * level);
  return static_cast<std::int16_t>(std::clamp(sum < 0 ? -size : size, -kMaxHeight, kMaxHeight));
}

simd::Short4 blended(simd::Int4 sum, int level) {
  const simd::Int4 sign = sum >> 31;
  const simd::Int4 size = ((sum ^ sign) - sign + simd::splat(1 << (2 * level - 1))) >> (2 * level);
  const simd::Int4 most = simd::select(size > kMaxHeight, simd::splat(kMaxHeight), size);
  return __builtin_convertvector((most ^ sign) - sign, simd::Short4);
}

}  // namespace

template <class Visit>
void NewHeights::for_each_new(const Visit& visit) const {
  for (const PatchChange& change : changes) {
    if (is_new(change)) visit(change.slot);
  }
}

std::int16_t NewHeights::at(PatchId patch, int i, int j) const {
  if (patches[patch].height_block == kNoHeights) return 0;
  return block(patch)[static_cast<std::size_t>(j * patch_side(level) + i)];
}

void NewHeights::set(PatchId patch, int i, int j, std::int32_t height) const {
  block(patch)[static_cast<std::size_t>(j * patch_side(level) + i)] =
      static_cast<std::int16_t>(std::clamp(height, -kMaxHeight, kMaxHeight));
}

void NewHeights::run() const {
  for_each_new([&](PatchId patch) {
    patches[patch].height_block = kUnmade;
    std::ranges::fill(block(patch), std::int16_t{0});
  });
  find_corners();
  for_each_new([&](PatchId patch) { fill_borders(patch); });
  for_each_new([&](PatchId patch) { fill_inside(patch); });
  for_each_new([&](PatchId patch) {
    const std::span<const std::int16_t> own = block(patch);
    const bool flat = std::ranges::all_of(own, [](std::int16_t h) { return h == 0; });
    patches[patch].height_block = flat ? kNoHeights : first_block + patch;
  });
}

// What old patches have there first; then the others, again and again.
void NewHeights::find_corners() const {
  const int n = patch_cells(level);
  for_each_new([&](PatchId patch) {
    for (int corner = 0; corner < 4; ++corner) {
      PatchCorner fan[kMaxCornerFan];
      const int count = corner_fan(patches, {patch, corner}, fan);
      for (int f = 0; f < count; ++f) {
        if (patches[fan[f].patch].height_block == kUnmade) continue;
        const GridPlace theirs = corner_place(fan[f].corner, n), own = corner_place(corner, n);
        set(patch, own.i, own.j, at(fan[f].patch, theirs.i, theirs.j));
        break;
      }
    }
  });
  bool moves = true;
  for (int round = 0; round < kRounds && moves; ++round) {
    moves = false;
    for_each_new([&](PatchId patch) {
      for (int corner = 0; corner < (patches[patch].collapsed != 0 ? 3 : 4); ++corner)
        moves = smooth_corner(patch, corner) || moves;
    });
  }
}

// Whether it is another now.
bool NewHeights::smooth_corner(PatchId patch, int corner) const {
  const int n = patch_cells(level);
  PatchCorner fan[kMaxCornerFan];
  const int count = corner_fan(patches, {patch, corner}, fan);
  std::int64_t sum = 0;
  for (int f = 0; f < count; ++f) {
    if (patches[fan[f].patch].height_block != kUnmade) return false;  // it is given
    // The corners beside it; of one patch that two edges lead to, twice.
    const bool three = patches[fan[f].patch].collapsed != 0;
    const int before = three && fan[f].corner == 0 ? 2 : (fan[f].corner + 3) & 3;
    for (const int beside : {(fan[f].corner + 1) & 3, before}) {
      const GridPlace place = corner_place(beside, n);
      sum += at(fan[f].patch, place.i, place.j);
    }
  }
  const std::int32_t mean = divide(sum, 2 * count);
  // All copies of a corner are alike.
  const GridPlace own = corner_place(corner, n);
  if (at(patch, own.i, own.j) == mean) return false;
  for (int f = 0; f < count; ++f) {
    const GridPlace place = corner_place(fan[f].corner, n);
    set(fan[f].patch, place.i, place.j, mean);
    if (patches[fan[f].patch].collapsed != 0 && fan[f].corner == 0) set(fan[f].patch, 0, n, mean);
  }
  return true;
}

void NewHeights::fill_borders(PatchId patch) const {
  const int n = patch_cells(level);
  const Patch& own = patches[patch];
  for (int e = 0; e < 4; ++e) {
    const GridLine mine = GridLine::along_edge(e, 0, level, false);
    const PatchEdge other = own.neighbour[e];
    const bool is_given = other.exists() && patches[other.patch()].height_block != kUnmade;
    const GridLine theirs =
        other.exists() ? GridLine::along_edge(other.edge(), 0, level, true) : GridLine{0, 0, 0, 0};
    const std::int32_t first = at(patch, mine.i0, mine.j0);
    const std::int32_t last = at(patch, mine.i0 + n * mine.di, mine.j0 + n * mine.dj);
    for (int t = 1; t < n; ++t) {
      const std::int32_t height =
          is_given ? at(other.patch(), theirs.i0 + t * theirs.di, theirs.j0 + t * theirs.dj)
                   : divide(std::int64_t{first} * (n - t) + std::int64_t{last} * t, n);
      set(patch, mine.i0 + t * mine.di, mine.j0 + t * mine.dj, height);
    }
  }
}

// n^2 times the sum of both ruled surfaces less the bilinear one; n is a power of two, and all of it less
// than 2^31. Along a row the surface between the left and the right border and the bilinear one are linear,
// so one sum has both; the one between bottom and top is linear along each column.
void NewHeights::fill_inside(PatchId patch) const {
  static_assert(std::int64_t{6} * kMaxHeight * patch_cells(kMaxLevel) * patch_cells(kMaxLevel) < INT32_MAX);
  const std::int32_t n = patch_cells(level);
  const int side = patch_side(level);
  const std::span<std::int16_t> own = block(patch);
  const std::int16_t* const bottom = own.data();
  const std::int16_t* const top = bottom + n * side;
  // Of row 1 and from row to row; columns before n in fours.
  std::int32_t along[patch_cells(kMaxLevel)], rise[patch_cells(kMaxLevel)];
  for (std::int32_t i = 0; i < n; ++i) {
    rise[i] = n * (top[i] - bottom[i]);
    along[i] = n * n * bottom[i] + rise[i];
  }
  for (std::int32_t j = 1; j < n; ++j) {
    std::int16_t* const row = own.data() + j * side;
    const std::int32_t left = row[0], right = row[n];
    const std::int32_t low = bottom[0] * (n - j) + top[0] * j, high = bottom[n] * (n - j) + top[n] * j;
    const std::int32_t first = n * (n * left - low);
    const std::int32_t step = n * (right - left) - (high - low);
    if (n < simd::kLanes) {
      row[1] = blended(first + step + along[1], level);
      along[1] += rise[1];
      continue;
    }
    simd::Int4 across = first + step * simd::Int4{0, 1, 2, 3};
    for (std::int32_t i = 0; i < n; i += simd::kLanes, across += simd::kLanes * step) {
      const simd::Int4 up = simd::load(along + i);
      const simd::Short4 four = blended(across + up, level);
      std::memcpy(row + i, &four, sizeof four);  // column 0 gets what it has
      simd::store(along + i, up + simd::load(rise + i));
    }
  }
}

}  // namespace karst::core
