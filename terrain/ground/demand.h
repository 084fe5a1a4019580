// SPDX-License-Identifier: MIT
// A node's threshold as a function of what a view demands, k = S / error_px + 1 (ErrorScale::steps_per_step).
// It is convex, since every term of it is a line in k; so it is kept at a few values of k, with lines between
// them: they are not below it, and what holds at both ends, (1) and (2) of ground_view.h, holds between them.
#pragma once

#include <array>
#include <cstdint>

namespace karst::core {

// The last share of a threshold's distance in which a node's vertices morph. A larger one moves them slower
// and takes more triangles: what is kept from size to size grows by 1 / (1 - sigma). At 0.3, that of patches,
// ground takes a fourth more triangles than at this, at 0.2 a twenty-fifth.
inline constexpr float kNodeMorphShare = 0.1f;

// At k = kLeastDemand * 2^n.
inline constexpr int kDemands = 12;
inline constexpr double kLeastDemand = 4;

constexpr double demand(int n) {
  return kLeastDemand * static_cast<double>(std::uint32_t{1} << n);
}

// Between which values a demand lies, for all nodes of a view: threshold = (1 - share) of n + share of n + 1,
// times factor. Below the least demand: that one; above the greatest in proportion, which keeps (1) and (2).
struct DemandPlace {
  int n = 0;
  double share = 0;
  double factor = 1;
};
inline DemandPlace place_of_demand(double k) {
  if (!(k > kLeastDemand)) return {};
  constexpr double kMost = demand(kDemands - 1);
  if (k >= kMost) return {kDemands - 2, 1.0, k / kMost};
  int n = 0;
  while (k >= demand(n + 1)) ++n;
  return {n, (k - demand(n)) / demand(n), 1.0};
}

}  // namespace karst::core
