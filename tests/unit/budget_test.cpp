// SPDX-License-Identifier: MIT
// Budget: terms are kept apart, sums saturate, and CPU terms agree with what an arena counts.
#include "terrain/base/budget.h"

#include <gtest/gtest.h>

#include <span>
#include <vector>

namespace karst::core {
namespace {

TEST(BudgetTest, StartsEmptyWithEveryConsumerNamed) {
  const Budget budget;
  EXPECT_EQ(budget.cpu_bytes(), 0u);
  EXPECT_EQ(budget.gpu_bytes(), 0u);
  ASSERT_EQ(budget.terms().size(), kConsumerCount + kGpuConsumerCount);
  for (std::size_t i = 0; i < budget.terms().size(); ++i) {
    const Budget::Term& term = budget.terms()[i];
    EXPECT_EQ(term.gpu, i >= kConsumerCount);
    EXPECT_STREQ(term.name, term.gpu ? kGpuConsumerNames[i - kConsumerCount] : kConsumerNames[i]);
    EXPECT_EQ(term.bytes, 0u);
  }
}

TEST(BudgetTest, AddsUpByConsumerAndByMemory) {
  Budget budget;
  budget.add(Consumer::octets, 100);
  budget.add(Consumer::octets, 28);
  budget.add(Consumer::scratch, 64);
  budget.add(GpuConsumer::vertices, 1000);
  budget.add(GpuConsumer::g_buffer, 7);
  EXPECT_EQ(budget.bytes(Consumer::octets), 128u);
  EXPECT_EQ(budget.bytes(Consumer::scratch), 64u);
  EXPECT_EQ(budget.bytes(Consumer::volumes), 0u);
  EXPECT_EQ(budget.bytes(GpuConsumer::vertices), 1000u);
  EXPECT_EQ(budget.cpu_bytes(), 192u);
  EXPECT_EQ(budget.gpu_bytes(), 1007u);
}

TEST(BudgetTest, SumsSaturate) {
  Budget budget;
  budget.add(Consumer::patches, Budget::kUnbounded - 10);
  budget.add(Consumer::patches, 11);
  EXPECT_EQ(budget.bytes(Consumer::patches), Budget::kUnbounded);
  budget.add(Consumer::volumes, 1);
  EXPECT_EQ(budget.cpu_bytes(), Budget::kUnbounded);
  EXPECT_EQ(budget.gpu_bytes(), 0u);
  budget.add(GpuConsumer::vertices, Arena::bytes_for<std::uint64_t>(Budget::kUnbounded));
  EXPECT_EQ(budget.gpu_bytes(), Budget::kUnbounded);
}

TEST(BudgetTest, AgreesWithTheArenaToTheByte) {
  Budget budget;
  budget.add(Consumer::octets, Arena::bytes_for<std::uint32_t>(17));
  budget.add(Consumer::heights, Arena::bytes_for<std::int16_t>(1089));
  budget.add(Consumer::heights, Arena::bytes_for<std::int16_t>(1));

  // Over-allocated, so that an aligned start can be found inside.
  std::vector<std::byte> memory(budget.cpu_bytes() + Arena::kAlignment);
  const auto address = reinterpret_cast<std::uintptr_t>(memory.data());
  const std::size_t skip = (Arena::kAlignment - address % Arena::kAlignment) % Arena::kAlignment;
  const std::span<std::byte> aligned = std::span<std::byte>(memory).subspan(skip, budget.cpu_bytes());
  Arena arena(aligned);
  EXPECT_EQ(arena.allocate<std::uint32_t>(Consumer::octets, 17).size(), 17u);
  EXPECT_EQ(arena.allocate<std::int16_t>(Consumer::heights, 1089).size(), 1089u);
  EXPECT_EQ(arena.allocate<std::int16_t>(Consumer::heights, 1).size(), 1u);

  EXPECT_EQ(arena.used(), arena.capacity());
  for (std::size_t i = 0; i < kConsumerCount; ++i) {
    const auto consumer = static_cast<Consumer>(i);
    EXPECT_EQ(arena.used(consumer), budget.bytes(consumer)) << kConsumerNames[i];
  }
  EXPECT_TRUE(arena.allocate<char>(Consumer::scratch, 1).empty());
}

}  // namespace
}  // namespace karst::core
