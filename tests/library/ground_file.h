// SPDX-License-Identifier: MIT
// A world file that is a ground and nothing else.
#pragma once

#include <cstddef>
#include <vector>

#include "tests/support/memory_ground.h"

namespace karst::test {

// spacing_m: from one sample to the next, along x. The north-west sample lies at (0, 0, 0) where its height
// is 0.
std::vector<std::byte> ground_file(const MemoryGround& ground, double spacing_m);

// Ridges and valleys up to 60 m over 600 x 480 samples of 10 m, rough by up to a metre.
MemoryGround::Heights rough_heights();
MemoryGround rough_ground();
inline constexpr double kRoughSpacing_m = 10;

}  // namespace karst::test
