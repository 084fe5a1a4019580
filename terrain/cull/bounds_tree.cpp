// SPDX-License-Identifier: MIT
// Building and refitting the tree, row by row from the patches up.
#include "terrain/cull/bounds_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>

namespace karst::core {
namespace {

constexpr LatticeBox nothing() {
  return {glm::ivec3(std::numeric_limits<std::int32_t>::max()),
          glm::ivec3(std::numeric_limits<std::int32_t>::min())};
}

LatticeBox join(const LatticeBox& a, const LatticeBox& b) {
  return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

Status check(const Surface& surface, std::span<const PatchBounds> bounds) {
  if (bounds.size() != surface.patches.size()) {
    return {StatusCode::invalid_argument, "must hold one box a patch", "bounds", bounds.size()};
  }
  return {};
}

}  // namespace

Status BoundsTree::build(const Surface& surface, std::span<const PatchBounds> bounds) {
  if (const Status status = check(surface, bounds); !status.ok()) return status;
  const std::size_t count = surface.patches.size();
  if (count > kMaxPatches || node_count(static_cast<std::uint32_t>(count)) > storage_.size()) {
    return {StatusCode::limit_reached, "the box hierarchy has no room for the patches", "max_patches", count};
  }
  patches_ = static_cast<std::uint32_t>(count);
  longest_diagonal_ = 0.0f;
  rows_ = 0;
  for (std::uint32_t in_row = patches_; in_row > 0;) {
    in_row = (in_row + kFanOut - 1) / kFanOut;
    begin_[rows_ + 1] = begin_[rows_] + in_row;
    ++rows_;
    if (in_row == 1) break;
  }
  if (patches_ > 0) refit(surface, bounds, 0, patches_ - 1);
  return {};
}

Status BoundsTree::update(const Surface& surface, std::span<const PatchBounds> bounds, PatchId first,
                          std::uint32_t count) {
  if (const Status status = check(surface, bounds); !status.ok()) return status;
  if (bounds.size() != patches_) {
    return {StatusCode::invalid_argument, "not the surface that the tree was built over", "surface",
            bounds.size()};
  }
  if (first > patches_ || count > patches_ - first) {
    return {StatusCode::invalid_argument, "range is outside the patches", "count", count};
  }
  if (count > 0) refit(surface, bounds, first, first + count - 1);
  return {};
}

void BoundsTree::fit_diagonal(std::span<const PatchBounds> bounds) {
  longest_diagonal_ = 0.0f;
  if (patches_ > 0) take_diagonals(bounds, 0, patches_ - 1);
}

// first, last: patches, the last included.
void BoundsTree::take_diagonals(std::span<const PatchBounds> bounds, std::uint32_t first,
                                std::uint32_t last) {
  float longest_squared = 0.0f;
  for (std::uint32_t id = first; id <= last; ++id) {
    const PatchBounds& b = bounds[id];
    float squared = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      const auto size = static_cast<float>(b.max[axis] - b.min[axis]);
      squared += size * size;
    }
    longest_squared = std::max(longest_squared, squared);
  }
  longest_diagonal_ = std::max(longest_diagonal_, std::sqrt(longest_squared) + 1.0f);
}

void BoundsTree::refit(const Surface& surface, std::span<const PatchBounds> bounds, std::uint32_t first,
                       std::uint32_t last) {
  take_diagonals(bounds, first, last);
  std::uint32_t below = patches_;  // entries in the row below
  for (int row = 0; row < rows_; ++row) {
    first >>= kFanOutLog2;
    last >>= kFanOutLog2;
    for (std::uint32_t n = first; n <= last; ++n) {
      LatticeBox box = nothing();
      const std::uint32_t end = std::min((n + 1) * kFanOut, below);
      for (std::uint32_t child = n * kFanOut; child < end; ++child) {
        const LatticeBox below_it = row == 0 ? patch_box(surface, bounds, child) : node(row - 1, child);
        if (!is_nowhere(below_it)) box = join(box, below_it);
      }
      if (box.min.x > box.max.x) box = {glm::ivec3(kNowhereSteps), glm::ivec3(kNowhereSteps)};
      storage_[begin_[row] + n] = box;
    }
    below = nodes(row);
  }
}

}  // namespace karst::core
