// SPDX-License-Identifier: MIT
// Keys against their fields and the octree's order; the table against a map.
#include "terrain/surface/patch_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include "terrain/base/storage_plan.h"
#include "tests/support/heap_count.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

TEST(PatchKey, HoldsItsFields) {
  test::Random random{7};
  for (int round = 0; round < 2'000; ++round) {
    const auto at = [&] { return static_cast<std::uint32_t>(random.below(1024)); };
    const auto region = static_cast<std::uint32_t>(random.below(1 << 16));
    const std::uint32_t x = at(), y = at(), z = at();
    const auto c = static_cast<std::uint32_t>(random.below(8));
    const PatchKey key = PatchKey::make(region, x, y, z, c);
    EXPECT_EQ(key.region(), region);
    EXPECT_EQ(key.corner(), glm::ivec3(x, y, z));
    EXPECT_EQ(key.case_patch(), c);
    EXPECT_EQ(key.of_volume(), PatchKey::make(region, x, y, z, 0));
    EXPECT_EQ(key.bits() >> PatchKey::kBits, 0u);
    EXPECT_EQ(PatchKey::from_bits(key.bits()), key);
  }
}

// The order of docs/formats.md, and of extraction.
TEST(PatchKey, SortsAlongTheOctree) {
  EXPECT_LT(PatchKey::make(0, 1, 0, 0, 3), PatchKey::make(0, 0, 1, 0, 0));
  EXPECT_LT(PatchKey::make(0, 1, 1, 0, 0), PatchKey::make(0, 0, 0, 1, 0));
  EXPECT_LT(PatchKey::make(0, 1, 1, 1, 0), PatchKey::make(0, 2, 0, 0, 0));
  EXPECT_LT(PatchKey::make(0, 1023, 1023, 1023, 7), PatchKey::make(1, 0, 0, 0, 0));
  EXPECT_EQ(PatchKey::make(0, 1, 0, 0, 2).bits(), 8u + 2u);
  EXPECT_EQ(PatchKey::make(0, 0, 0, 2, 0).bits(), std::uint64_t{1} << 8);
  EXPECT_EQ(PatchKey::make(1, 0, 0, 0, 0).bits(), std::uint64_t{1} << 33);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const std::vector<PatchKey> keys = test::TestWorld::noise(seed, {18, 14, 20}, 0.4, 3.0, false).keys();
    ASSERT_GT(keys.size(), 100u);
    EXPECT_EQ(std::adjacent_find(keys.begin(), keys.end(), [](PatchKey a, PatchKey b) { return a >= b; }),
              keys.end());
  }
}

struct Table {
  explicit Table(std::uint32_t max_patches) {
    Config config;
    config.max_patches = max_patches;
    Budget budget;
    count_blocks<PatchTable::Blocks>(config, budget);
    memory = std::make_unique<test::AlignedBytes>(budget.cpu_bytes());
    Arena arena(memory->bytes());
    PatchTable::Blocks blocks;
    EXPECT_TRUE(take_blocks(config, arena, blocks).ok());
    EXPECT_EQ(arena.used(), budget.cpu_bytes());
    table.create(blocks);
  }

  std::unique_ptr<test::AlignedBytes> memory;
  PatchTable table;
};

TEST(PatchTable, EntriesAreAtMostTwoThirdsFull) {
  for (std::size_t patches = 0; patches < 5'000; ++patches) {
    const std::size_t entries = PatchTable::entry_count(patches);
    EXPECT_EQ(entries & (entries - 1), 0u);
    EXPECT_LE(patches * 3, entries * 2);
    EXPECT_TRUE(entries == 4 || patches * 3 > entries) << patches;
  }
}

TEST(PatchTable, HandsOutNumbersInOrder) {
  Table t(10);
  PatchTable& table = t.table;
  PatchId slot = 99;
  for (std::uint32_t i = 0; i < 10; ++i) {
    ASSERT_TRUE(table.take(PatchKey::make(0, i + 1, 1, 1, 0), slot).ok());
    EXPECT_EQ(slot, i);
  }
  slot = 99;
  const Status full = table.take(PatchKey::make(0, 50, 1, 1, 0), slot);
  EXPECT_EQ(full.code(), StatusCode::limit_reached);
  EXPECT_STREQ(full.field(), "max_patches");
  EXPECT_EQ(full.value(), 11u);
  EXPECT_EQ(slot, 99u);
  EXPECT_EQ(table.size(), 10u);
  EXPECT_EQ(table.find(PatchKey::make(0, 50, 1, 1, 0)), PatchTable::kNone);
  table.release(3);
  EXPECT_FALSE(table.is_used(3));
  EXPECT_EQ(table.find(PatchKey::make(0, 4, 1, 1, 0)), PatchTable::kNone);
  ASSERT_TRUE(table.take(PatchKey::make(0, 50, 1, 1, 0), slot).ok());
  EXPECT_EQ(slot, 3u);
  EXPECT_EQ(table.key(3), PatchKey::make(0, 50, 1, 1, 0));
  table.clear();
  EXPECT_EQ(table.size(), 0u);
  ASSERT_TRUE(table.take(PatchKey::make(0, 50, 1, 1, 0), slot).ok());
  EXPECT_EQ(slot, 0u);
}

// A hundred thousand takes and releases of clustered keys, a small table most of the time full.
TEST(PatchTable, IsAMap) {
  constexpr std::uint32_t kSlots = 300;
  Table t(kSlots);
  PatchTable& table = t.table;
  std::map<PatchKey, PatchId> model;
  test::Random random{11};
  for (int round = 0; round < 100'000; ++round) {
    const auto at = [&] { return static_cast<std::uint32_t>(1 + random.below(6)); };
    const PatchKey key = PatchKey::make(0, at(), at(), at(), static_cast<std::uint32_t>(random.below(4)));
    const auto known = model.find(key);
    const std::size_t before = test::heap_calls();
    const PatchId found = table.find(key);
    EXPECT_EQ(found, known == model.end() ? PatchTable::kNone : known->second);
    if (known != model.end()) {
      table.release(found);
      EXPECT_EQ(test::heap_calls(), before);
      model.erase(known);
    } else {
      PatchId slot = PatchTable::kNone;
      const Status status = table.take(key, slot);
      EXPECT_EQ(test::heap_calls(), before);
      ASSERT_EQ(status.ok(), model.size() < kSlots);
      if (!status.ok()) continue;
      ASSERT_LT(slot, kSlots);
      model[key] = slot;
    }
    ASSERT_EQ(table.size(), model.size());
    if (round % 1'000 != 0) continue;
    std::map<PatchKey, PatchId> listed;
    PatchId last = 0;
    table.for_each([&](PatchId slot, PatchKey k) {
      EXPECT_TRUE(listed.empty() || slot > last);
      last = slot;
      listed[k] = slot;
    });
    EXPECT_EQ(listed, model);
  }
  EXPECT_GT(model.size(), 200u);
}

}  // namespace
}  // namespace karst::core
