// SPDX-License-Identifier: MIT
// What a pass draws: one item a visible patch.
#pragma once

#include <cstdint>

#include "terrain/surface/surface.h"

namespace karst {

struct DrawItem {
  PatchId patch;
  std::uint8_t level;        // level of detail it is drawn at, 1..kMaxLevel
  std::uint8_t lower_edges;  // bit e: the neighbour across edge e is drawn one level lower
  std::uint16_t reserved = 0;
};

}  // namespace karst
