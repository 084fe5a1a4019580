// SPDX-License-Identifier: MIT
#include "terrain/resident/resident_pool.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/test_world.h"

namespace karst::core {
namespace {

struct PoolMemory {
  std::vector<std::uint32_t> first_page, row_of_patch, next_page;
  std::vector<std::uint8_t> levels;
  std::vector<std::uint64_t> free_pages;
  std::vector<PageTexel> texels;
  std::vector<ResidentPool::Row> rows;
  ResidentPool pool;

  PoolMemory(std::uint32_t patches, std::uint32_t pages, std::uint32_t max_rows)
      : first_page(patches),
        row_of_patch(patches),
        next_page(pages),
        levels(patches),
        free_pages((pages + 63) / 64),
        texels(pages),
        rows(max_rows) {
    pool.create({first_page, row_of_patch, levels, next_page, free_pages, texels, rows});
    pool.reset(patches, 2);
  }

  std::vector<std::uint32_t> chain(PatchId patch) const {
    std::vector<std::uint32_t> pages;
    for (std::uint32_t page = first_page[patch]; page != kNoPage; page = next_page[page])
      pages.push_back(page);
    return pages;
  }

  // Every page is in one chain, free or kept back; chains are as long as levels say; rows and patches agree.
  void check() const {
    std::vector<int> used(next_page.size());
    std::uint32_t in_chains = 0;
    std::uint32_t resident = 0;
    for (PatchId p = 0; p < levels.size(); ++p) {
      const std::vector<std::uint32_t> pages = chain(p);
      ASSERT_EQ(pages.size(), levels[p] == 0 ? 0 : slot_pages(levels[p]));
      for (const std::uint32_t page : pages) {
        ASSERT_EQ(used[page]++, 0);
        ASSERT_EQ(free_pages[page / 64] >> page % 64 & 1u, 0u);
      }
      in_chains += static_cast<std::uint32_t>(pages.size());
      ASSERT_EQ(levels[p] == 0, row_of_patch[p] == ResidentPool::kNoRow);
      if (levels[p] == 0) continue;
      ++resident;
      ASSERT_LT(row_of_patch[p], pool.row_end());
      ASSERT_TRUE(pool.row_at(row_of_patch[p]).used);
      ASSERT_EQ(pool.row_at(row_of_patch[p]).patch, p);
    }
    ASSERT_EQ(resident, pool.resident());
    ASSERT_EQ(in_chains + pool.free_pages() + pool.kept_back(), next_page.size());
  }
};

TEST(ResidentPool, RaisingAppendsPages) {
  PoolMemory memory(3, 60, 3);
  memory.pool.begin_frame();
  ASSERT_TRUE(memory.pool.raise(1, 2));
  const std::vector<std::uint32_t> coarse = memory.chain(1);
  ASSERT_EQ(coarse.size(), 1u);
  ASSERT_TRUE(memory.pool.raise(0, 3));
  ASSERT_TRUE(memory.pool.raise(1, 5));
  const std::vector<std::uint32_t> fine = memory.chain(1);
  ASSERT_EQ(fine.size(), 35u);
  EXPECT_EQ(fine[0], coarse[0]);
  EXPECT_FALSE(memory.pool.raise(1, 5));
  EXPECT_FALSE(memory.pool.raise(2, 5));  // 38 of 60 are taken
  EXPECT_EQ(memory.pool.level(2), 0);
  memory.check();
}

// The shortest stretch of free pages that is long enough, or else the longest ones.
TEST(ResidentPool, PagesFollowEachOtherWhereTheyCan) {
  PoolMemory memory(80, 80, 80);
  ResidentPool& pool = memory.pool;
  pool.begin_frame();
  for (PatchId p = 0; p < 70; ++p) ASSERT_TRUE(pool.raise(p, 2));
  for (int i = 0; i < 3; ++i) pool.begin_frame();
  // Free: 2, 10..12, 62..65 and 70..79.
  for (const PatchId p : {2u, 10u, 11u, 12u, 62u, 63u, 64u, 65u}) pool.lower(p, 0);
  using Pages = std::vector<std::uint32_t>;
  ASSERT_TRUE(pool.raise(71, 3));
  EXPECT_EQ(memory.chain(71), (Pages{10, 11, 12}));
  ASSERT_TRUE(pool.raise(72, 3));
  EXPECT_EQ(memory.chain(72), (Pages{62, 63, 64}));
  ASSERT_TRUE(pool.raise(73, 2));
  EXPECT_EQ(memory.chain(73), (Pages{2}));
  ASSERT_TRUE(pool.raise(74, 3));
  EXPECT_EQ(memory.chain(74), (Pages{70, 71, 72}));
  pool.lower(40, 0);
  ASSERT_TRUE(pool.raise(74, 4));
  EXPECT_EQ(memory.chain(74), (Pages{70, 71, 72, 73, 74, 75, 76, 77, 78, 79}));
  pool.lower(50, 0);
  pool.lower(51, 0);
  ASSERT_TRUE(pool.raise(75, 3));
  EXPECT_EQ(memory.chain(75), (Pages{50, 51, 40}));
  EXPECT_EQ(pool.free_pages(), 1u);
  memory.check();
}

// What follows a patch's last page goes before any other stretch, one that is as long as needed too.
TEST(ResidentPool, APatchGoesOnWhereItEnds) {
  PoolMemory memory(80, 80, 80);
  ResidentPool& pool = memory.pool;
  pool.begin_frame();
  for (PatchId p = 0; p < 70; ++p) ASSERT_TRUE(pool.raise(p, 2));
  for (int i = 0; i < 3; ++i) pool.begin_frame();
  // Free: 10, 11 and 70..79.
  pool.lower(10, 0);
  pool.lower(11, 0);
  ASSERT_TRUE(pool.raise(69, 3));
  EXPECT_EQ(memory.chain(69), (std::vector<std::uint32_t>{69, 70, 71}));
  ASSERT_TRUE(pool.raise(68, 3));
  EXPECT_EQ(memory.chain(68), (std::vector<std::uint32_t>{68, 10, 11}));
  memory.check();
}

// What a frame may still draw is not handed out before kFramesInFlight more frames have begun.
TEST(ResidentPool, PagesSeenLatelyAreKeptBack) {
  PoolMemory memory(2, 35, 2);
  ResidentPool& pool = memory.pool;
  pool.begin_frame();
  ASSERT_TRUE(pool.raise(0, 5));
  pool.see(0, 5);
  pool.lower(0, 0);
  EXPECT_EQ(pool.free_pages(), 0u);
  EXPECT_EQ(pool.kept_back(), 35u);
  EXPECT_FALSE(pool.raise(1, 2));
  pool.begin_frame();
  EXPECT_FALSE(pool.raise(1, 2));
  pool.begin_frame();
  EXPECT_TRUE(pool.raise(1, 5));
  memory.check();
  // Not seen for as long: free at once.
  pool.begin_frame();
  pool.begin_frame();
  pool.lower(1, 3);
  EXPECT_EQ(pool.free_pages(), 32u);
  EXPECT_EQ(pool.kept_back(), 0u);
  memory.check();
}

TEST(ResidentPool, TheLongestUnseenGivesWayAndWhatIsSeenDoesNot) {
  PoolMemory memory(5, 40, 5);  // four at level 4
  ResidentPool& pool = memory.pool;
  for (PatchId p = 0; p < 4; ++p) {
    pool.begin_frame();
    ASSERT_TRUE(pool.raise(p, 4));
  }
  for (int i = 0; i < 3; ++i) pool.begin_frame();
  pool.see(0, 4);
  pool.see(2, 4);
  EXPECT_TRUE(pool.make_room(4, 3));
  EXPECT_EQ(pool.level(0), 4);
  EXPECT_EQ(pool.level(1), 2);  // to the base level first
  EXPECT_EQ(pool.level(2), 4);
  EXPECT_EQ(pool.level(3), 4);
  EXPECT_TRUE(pool.raise(4, 4) || pool.make_room(4, 4));
  EXPECT_TRUE(pool.keeps_base());
  // With nothing unseen left, what is finer than the frame needs.
  pool.begin_frame();
  for (PatchId p = 0; p < 5; ++p) pool.see(p, 2);
  pool.see(0, 4);
  EXPECT_FALSE(pool.make_room(4, 5));
  EXPECT_EQ(pool.level(0), 4);
  EXPECT_EQ(pool.level(3), 2);
  memory.check();
}

TEST(ResidentPool, AFullTableOfRowsGivesOneUp) {
  PoolMemory memory(3, 100, 2);
  ResidentPool& pool = memory.pool;
  pool.begin_frame();
  ASSERT_TRUE(pool.raise(0, 2));
  ASSERT_TRUE(pool.raise(1, 2));
  EXPECT_FALSE(pool.raise(2, 2));
  for (int i = 0; i < 3; ++i) pool.begin_frame();
  pool.see(0, 2);
  EXPECT_TRUE(pool.make_room(2, 2));
  EXPECT_TRUE(pool.raise(2, 2));
  EXPECT_EQ(pool.level(1), 0);
  memory.check();
}

TEST(ResidentPool, RandomUseLosesNoPage) {
  test::Random random{1};
  for (int world = 0; world < 20; ++world) {
    const std::uint32_t patches = 1 + static_cast<std::uint32_t>(random.below(300));
    PoolMemory memory(patches, static_cast<std::uint32_t>(1 + random.below(2000)),
                      1 + static_cast<std::uint32_t>(random.below(static_cast<int>(patches))));
    for (int step = 0; step < 2000; ++step) {
      const auto patch = static_cast<PatchId>(random.below(static_cast<int>(patches)));
      const int level = 1 + random.below(kMaxLevel);
      switch (random.below(5)) {
        case 0:
          memory.pool.begin_frame();
          break;
        case 1:
          memory.pool.see(patch, level);
          break;
        case 2:
          memory.pool.lower(patch, level - 1);
          break;
        default:
          if (level > memory.pool.level(patch) && memory.pool.make_room(patch, level)) {
            ASSERT_TRUE(memory.pool.raise(patch, level));
          }
      }
      if (step % 50 == 0) memory.check();
    }
    memory.check();
  }
}

}  // namespace
}  // namespace karst::core
