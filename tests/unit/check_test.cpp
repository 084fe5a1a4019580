// SPDX-License-Identifier: MIT
// Asserts stop the program where they are on, which they are here whatever the build type is.
#ifndef KARST_CHECKS
#define KARST_CHECKS
#endif
#include "terrain/base/check.h"

#include <gtest/gtest.h>

namespace karst::core {
namespace {

constexpr int half(int even) {
  KARST_ASSERT(even % 2 == 0);
  return even / 2;
}
static_assert(half(6) == 3, "usable in constant expressions");

TEST(CheckDeathTest, ABrokenPreconditionStopsTheProgram) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  volatile int odd = 7;
  EXPECT_EQ(half(odd + 1), 4);
  EXPECT_DEATH(half(odd), "");
}

}  // namespace
}  // namespace karst::core
