// SPDX-License-Identifier: MIT
#include "terrain/edit/undo_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::Random;

// Cells of a world that is changed, and all its earlier states.
using Cells = std::map<std::uint64_t, std::vector<std::byte>>;

std::vector<std::byte> random_bytes(Random& random, std::size_t count) {
  std::vector<std::byte> bytes(count);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.below(256));
  return bytes;
}

struct Edited {
  std::vector<std::uint64_t> memory;
  UndoLog log;
  Cells cells;

  explicit Edited(std::size_t bytes) : memory(bytes / 8) {
    log.create(std::as_writable_bytes(std::span(memory)));
  }
  // Parts are exchanged as a whole; within them no cell is twice.
  void exchange(UndoPart part) {
    for (const UndoCell cell : part) {
      ASSERT_EQ(cell.kind, part.kind());
      std::vector<std::byte>& there = cells[cell.key];
      ASSERT_EQ(there.size(), cell.bytes.size());
      std::swap_ranges(there.begin(), there.end(), cell.bytes.begin());
    }
  }
  bool undo() {
    return log.undo([&](UndoPart part) { exchange(part); });
  }
  bool redo() {
    return log.redo([&](UndoPart part) { exchange(part); });
  }
};

constexpr CellKind kKinds[] = {CellKind::voxels, CellKind::paint};

TEST(UndoLog, ATenThousandStepsBackAndForth) {
  Random random{5};
  for (const std::size_t bytes : {std::size_t{256}, std::size_t{4096}, std::size_t{40'000}}) {
    Edited world(bytes);
    // A cell's length goes by its key, so that it stays.
    for (std::uint64_t key = 0; key < 30; ++key) world.cells[key] = random_bytes(random, key % 7 * 9);
    std::vector<Cells> states{world.cells};  // oldest first
    std::size_t now = 0;
    std::size_t undone_to_the_end = 0, lost = 0, parts = 0;
    for (int round = 0; round < 10'000; ++round) {
      // In turns more is done, and more taken back.
      const bool back = round / 100 % 2 == 1;
      const int what = random.below(10);
      if (what < (back ? 1 : 5)) {
        world.log.begin();
        const std::uint32_t steps = world.log.undo_steps();
        const std::uint64_t lost_before = world.log.lost_steps();
        std::vector<std::uint64_t> in_part;
        CellKind kind = CellKind::none;
        const int count = random.below(6);
        int added = 0;
        for (int n = 0; n < count; ++n) {
          if (n == 0 || random.below(3) == 0) {
            world.log.begin_part();
            EXPECT_EQ(world.log.open_part(), CellKind::none);
            kind = kKinds[random.below(2)];
            in_part.clear();
          }
          const auto key = static_cast<std::uint64_t>(random.below(30));
          if (std::ranges::find(in_part, key) != in_part.end()) continue;
          std::vector<std::byte>& cell = world.cells[key];
          const std::uint64_t number = world.log.part_number();
          world.log.add(kind, key, cell);
          ASSERT_EQ(world.log.open_part(), world.log.is_lost() ? CellKind::none : kind);
          if (!world.log.is_lost()) {
            EXPECT_EQ(world.log.part_number(), number + in_part.empty());
            parts += in_part.empty();
          }
          in_part.push_back(key);
          cell = random_bytes(random, cell.size());
          ++added;
        }
        const bool gone = world.log.is_lost();
        world.log.end();
        EXPECT_FALSE(world.log.is_lost());
        // Cells that were added have forgotten what could be taken again, also those of a step that is lost.
        if (added > 0) states.resize(now + 1);
        if (gone) {
          ASSERT_EQ(world.log.undo_steps(), 0u);
          ASSERT_EQ(world.log.lost_steps(), lost_before + steps + 1);
          states.assign(1, world.cells);
          now = 0;
          ++lost;
        } else if (added > 0) {
          ASSERT_LE(world.log.undo_steps(), steps + 1);
          states.push_back(world.cells);
          ++now;
        }
      } else if (what < (back ? 8 : 7)) {
        const bool can = world.log.undo_steps() > 0;
        ASSERT_EQ(world.undo(), can);
        if (can) --now;
        undone_to_the_end += !can;
      } else {
        const bool can = world.log.redo_steps() > 0;
        ASSERT_EQ(world.redo(), can);
        if (can) ++now;
      }
      ASSERT_EQ(world.cells, states[now]) << bytes << " bytes, round " << round;
      ASSERT_EQ(world.log.redo_steps(), states.size() - 1 - now);
      ASSERT_LE(world.log.undo_steps(), now);
    }
    EXPECT_GT(undone_to_the_end, bytes < 10'000 ? 100u : 0u);
    if (bytes < 10'000) {
      EXPECT_GT(world.log.lost_steps(), 100u);
    }
    EXPECT_EQ(lost > 0, bytes == 256) << lost;
    EXPECT_GT(parts, 2'000u);
  }
}

// It is lost with all before it; the next one is kept again. Half of the ring has room, wherever it begins.
TEST(UndoLog, AStepTooLargeIsLost) {
  Edited world(1024);
  const std::vector<std::byte> cell(400);
  const auto step = [&](int cells) {
    world.log.begin();
    for (std::uint64_t key = 0; key < static_cast<std::uint64_t>(cells); ++key)
      world.log.add(CellKind::voxels, key, cell);
    const bool lost = world.log.is_lost();
    world.log.end();
    return lost;
  };
  for (std::uint64_t key = 0; key < 3; ++key) world.cells[key] = cell;
  EXPECT_FALSE(step(1));
  EXPECT_FALSE(step(1));
  EXPECT_EQ(world.log.undo_steps(), 2u);
  EXPECT_TRUE(step(3));
  EXPECT_EQ(world.log.undo_steps(), 0u);
  EXPECT_EQ(world.log.lost_steps(), 3u);
  EXPECT_FALSE(world.undo());
  for (int n = 0; n < 7; ++n) {
    EXPECT_FALSE(step(1));
    EXPECT_TRUE(world.undo());
    EXPECT_TRUE(world.redo());
  }
  // Without memory nothing is kept, and nothing lost that could be.
  Edited none(0);
  EXPECT_FALSE(none.log.exists());
  EXPECT_FALSE(none.undo());
}

}  // namespace
}  // namespace karst::core
