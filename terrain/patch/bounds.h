// SPDX-License-Identifier: MIT
// The box of a patch's displaced vertices at its full level, in lattice steps from the patch's origin. 12
// bytes.
#pragma once

#include <cstdint>

namespace karst::core {

struct PatchBounds {
  std::int16_t min[3] = {0, 0, 0};
  std::int16_t max[3] = {0, 0, 0};
};

}  // namespace karst::core
