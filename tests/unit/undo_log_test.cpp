// SPDX-License-Identifier: MIT
#include "terrain/edit/undo_log.h"

#include <gtest/gtest.h>

#include <cstring>
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
  void exchange(UndoCell cell) {
    std::vector<std::byte>& there = cells[cell.key];
    ASSERT_EQ(there.size(), cell.bytes.size());
    std::swap_ranges(there.begin(), there.end(), cell.bytes.begin());
  }
  bool undo() {
    return log.undo([&](UndoCell cell) { exchange(cell); });
  }
  bool redo() {
    return log.redo([&](UndoCell cell) { exchange(cell); });
  }
};

TEST(UndoLog, ATenThousandStepsBackAndForth) {
  Random random{5};
  for (const std::size_t bytes : {std::size_t{256}, std::size_t{4096}, std::size_t{40'000}}) {
    Edited world(bytes);
    // A cell's length goes by its key, so that it stays.
    for (std::uint64_t key = 0; key < 30; ++key) world.cells[key] = random_bytes(random, key % 7 * 9);
    std::vector<Cells> states{world.cells};  // oldest first
    std::size_t now = 0;
    std::size_t undone_to_the_end = 0, refused = 0;
    for (int round = 0; round < 10'000; ++round) {
      // In turns more is done, and more taken back.
      const bool back = round / 100 % 2 == 1;
      const int what = random.below(10);
      if (what < (back ? 1 : 5)) {
        world.log.begin();
        const Cells before = world.cells;
        bool fits = true;
        const int count = random.below(6);
        for (int n = 0; fits && n < count; ++n) {
          const auto key = static_cast<std::uint64_t>(random.below(30));
          std::vector<std::byte>& cell = world.cells[key];
          if (world.log.holds(CellKind::paint, key)) continue;
          fits = world.log.add(CellKind::paint, key, cell).ok();
          if (fits) cell = random_bytes(random, cell.size());
        }
        if (!fits || random.below(8) == 0) {  // refused, or an edit that fails
          world.log.drop_cells(0);
          world.cells = before;
          refused += !fits;
        }
        const bool step = world.log.open_cells() > 0;
        const std::uint32_t steps = world.log.undo_steps();
        world.log.end();
        // Cells that were added and dropped have forgotten what could be taken again.
        if (world.log.redo_steps() == 0) states.resize(now + 1);
        if (step) {
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
    EXPECT_EQ(refused > 0, bytes == 256) << refused;
  }
}

TEST(UndoLog, AStepTooLargeIsRefusedWithWhatWouldDo) {
  Edited world(1024);
  world.log.begin();
  const std::vector<std::byte> cell(400);
  ASSERT_TRUE(world.log.add(CellKind::voxels, 1, cell).ok());
  ASSERT_TRUE(world.log.add(CellKind::voxels, 2, cell).ok());
  const Status status = world.log.add(CellKind::voxels, 3, cell);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "undo_bytes");
  EXPECT_EQ(status.value(), 2 * 3 * UndoLog::cell_bytes(400));
  EXPECT_EQ(world.log.open_cells(), 2u);
}

}  // namespace
}  // namespace karst::core
