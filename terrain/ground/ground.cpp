// SPDX-License-Identifier: MIT
#include "terrain/ground/ground.h"

#include <cmath>

namespace karst::core {

std::int64_t sample_place(double steps, std::int64_t sample) {
  return static_cast<std::int64_t>(
      std::floor(steps * static_cast<double>(sample) * (1.0 / kVertexStep) + 0.5));
}

}  // namespace karst::core
