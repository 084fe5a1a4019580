// SPDX-License-Identifier: MIT
// Random edits, strokes, undo and redo: the world is always, to the bit, what it was at that step, and what
// its file loads. KARST_EDITS: how many of each; default 300.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "terrain/edit/undo/take_part.h"
#include "tests/support/edited_ground.h"
#include "tests/support/edited_world.h"
#include "tests/support/heap_count.h"
#include "tests/support/live_mesh.h"

namespace karst::core {
namespace {

using test::LoadedWorld;
using test::Random;
using test::TestWorld;

int edits_asked() {
  const char* const text = std::getenv("KARST_EDITS");
  return text != nullptr ? std::atoi(text) : 300;
}

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  return std::hash<std::string_view>()({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

// What is edited.
class Subject {
 public:
  virtual ~Subject() = default;
  // Of all that a file of it would hold; does what edits left for later.
  virtual std::uint64_t state() = 0;
  virtual Edit random_edit(Random& random) const = 0;
  virtual Status apply(const Edit& edit, UndoLog* log, bool& changed) = 0;
  virtual void take(UndoPart part, bool back) = 0;
  virtual void check_closed() const {}
  virtual void check_deeply() = 0;
};

class Voxels : public Subject {
 public:
  Voxels(std::uint64_t seed, std::uint32_t patches, std::uint32_t octets)
      : live_(rough(seed), patches, octets) {}
  std::uint64_t state() override {
    test::settle(live_.world);
    return hash_of(live_.save());
  }
  Edit random_edit(Random& random) const override {
    const glm::ivec3 extent = live_.world.info().extent;
    if (random.below(3) == 0) return test::random_heights_edit(random, extent);
    Edit edit = test::random_voxel_edit(random, extent, live_.world.octree().depth());
    if (random.below(12) == 0) edit.radius *= 4;
    return edit;
  }
  Status apply(const Edit& edit, UndoLog* log, bool& changed) override {
    EditChange change;
    const Status status = edits_voxels(edit.tool) ? edit_shape(live_.world, edit, log, change)
                                                  : edit_heights(live_.world, edit, log, change);
    changed = change.changed;
    return status;
  }
  void take(UndoPart part, bool back) override {
    take_part(live_.world, part, back, [](const EditChange& change) { EXPECT_TRUE(change.changed); });
  }
  void check_closed() const override { ASSERT_EQ(test::open_edges(live_.world), 0u); }
  void check_deeply() override { test::expect_as_loaded(live_); }

 private:
  // Also with blocks of heights that are all 0, and with patches that have materials of their own.
  static std::vector<std::byte> rough(std::uint64_t seed) {
    TestWorld world = TestWorld::noise(seed, {14, 11, 13}, 0.45, 5.0, false);
    world.set_heights(
        2, [&](glm::dvec3 at) { return at.x < 5 ? 0 : 2'000 * test::value_noise(seed, 1.7 * at); });
    MaterialSet set;
    set.count = 3;
    set.side = 16;
    for (std::uint32_t n = 0; n < set.count; ++n) {
      Material& one = set.materials[n];
      std::snprintf(one.name, sizeof one.name, "%u", n);
      for (float& channel : one.average) channel = 0.5f;
    }
    const std::vector<std::byte> textures(texture_bytes(set));
    std::vector<std::uint8_t> overrides(world.patches().size());
    Random random{seed};
    for (std::uint8_t& one : overrides) one = static_cast<std::uint8_t>(random.below(4));
    return world.file({set, textures, overrides, {}});
  }
  LoadedWorld live_;
};

class Ground : public Subject {
 public:
  explicit Ground(std::uint32_t tiles) : edited_(150, 129, tiles), random_(5) {}
  std::uint64_t state() override { return hash_of(edited_.facts()); }
  Edit random_edit(Random&) const override { return test::random_ground_edit(random_, 150, 129); }
  Status apply(const Edit& edit, UndoLog* log, bool& changed) override {
    GroundChange change;
    const Status status = edited_.editor.apply(edit, log, change);
    changed = change.changed;
    return status;
  }
  void take(UndoPart part, bool) override {
    GroundChange change;
    edited_.editor.exchange(part, change);
  }
  void check_deeply() override { test::expect_as_made(edited_, "deeply"); }

 private:
  test::EditedGround edited_;
  mutable std::mt19937 random_;
};

struct Counts {
  int edits = 0, changed = 0, refused = 0, strokes = 0, undone = 0, redone = 0, lost = 0, oldest = 0;
};

// One edit after the other, with all that may come between them.
class Play {
 public:
  Play(Subject& subject, std::size_t undo_bytes, std::uint64_t seed)
      : subject_(subject), random_{seed}, memory_(undo_bytes / 8), states_{subject.state()} {
    log_.create(std::as_writable_bytes(std::span(memory_)));
  }

  void run(int edits) {
    for (int round = 0; counts_.edits < edits; ++round) {
      // In turns more is done, and more taken back.
      const bool back = round / 40 % 2 == 1;
      const int what = random_.below(20);
      if (what < (back ? 4 : 12)) {
        step(random_.below(5) == 0 ? 2 + random_.below(5) : 1);
      } else if (what < (back ? 14 : 15)) {
        take(true);
      } else {
        take(false);
      }
      if (testing::Test::HasFatalFailure()) FAIL() << "round " << round;
      if (round % 10 == 0) subject_.check_closed();
      if (round % 50 == 0) subject_.check_deeply();
      if (testing::Test::HasFailure()) FAIL() << "round " << round;
    }
    while (log_.undo_steps() > 0 && !testing::Test::HasFailure()) take(true);
    subject_.check_deeply();
    while (log_.redo_steps() > 0 && !testing::Test::HasFailure()) take(false);
    subject_.check_deeply();
    std::printf(
        "%d edits, %d changed something, %d refused (max_octets %d, edit_patches %d); %d strokes; "
        "%d steps taken back, %d done again; %d too large, %llu forgotten\n",
        counts_.edits, counts_.changed, counts_.refused, refused_for("max_octets"),
        refused_for("edit_patches"), counts_.strokes, counts_.undone, counts_.redone, counts_.lost,
        static_cast<unsigned long long>(log_.lost_steps()));
  }
  const Counts& counts() const { return counts_; }
  int refused_for(const char* field) const {
    const auto found = refused_for_.find(field);
    return found == refused_for_.end() ? 0 : found->second;
  }
  std::uint64_t lost_steps() const { return log_.lost_steps(); }

 private:
  void step(int edits) {
    const std::uint64_t lost_before = log_.lost_steps();
    const std::uint32_t steps_before = log_.undo_steps();
    bool any = false;
    std::uint64_t state = states_[now_];
    log_.begin();
    for (int n = 0; n < edits; ++n) {
      Edit edit = subject_.random_edit(random_);
      if (random_.below(16) == 0) edit.place.y = std::numeric_limits<double>::quiet_NaN();
      bool changed = false;
      const std::uint64_t calls = test::heap_calls();
      const Status status = subject_.apply(edit, &log_, changed);
      ASSERT_EQ(test::heap_calls(), calls);
      ++counts_.edits;
      counts_.changed += changed;
      counts_.refused += !status.ok();
      if (!status.ok()) ++refused_for_[status.field()];
      ASSERT_TRUE(status.ok() || !changed);
      any = any || changed;
      if (changed) state = kUnknown;
      ASSERT_NO_FATAL_FAILURE(look(state));
    }
    const bool lost = log_.is_lost();
    log_.end();
    counts_.strokes += edits > 1;
    counts_.lost += lost;
    if (!any) {
      ASSERT_EQ(log_.undo_steps(), steps_before);
      ASSERT_EQ(log_.lost_steps(), lost_before);
      return;
    }
    ASSERT_EQ(log_.redo_steps(), 0u);
    if (lost) {
      ASSERT_EQ(log_.undo_steps(), 0u);
      ASSERT_EQ(log_.lost_steps(), lost_before + steps_before + 1);
      states_.assign(1, state);
      now_ = 0;
      return;
    }
    ASSERT_EQ(log_.undo_steps(), steps_before + 1 - (log_.lost_steps() - lost_before));
    states_.resize(now_ + 1);
    states_.push_back(state);
    ++now_;
  }

  void take(bool back) {
    const bool can = (back ? log_.undo_steps() : log_.redo_steps()) > 0;
    const auto each = [&](UndoPart part) { subject_.take(part, back); };
    const std::uint64_t calls = test::heap_calls();
    const bool taken = back ? log_.undo(each) : log_.redo(each);
    ASSERT_EQ(test::heap_calls(), calls);
    ASSERT_EQ(taken, can);
    if (!taken) return;
    now_ = back ? now_ - 1 : now_ + 1;
    ++(back ? counts_.undone : counts_.redone);
    ASSERT_NO_FATAL_FAILURE(look(states_[now_]));
    ASSERT_LE(log_.undo_steps(), now_);
    ASSERT_EQ(log_.redo_steps(), states_.size() - 1 - now_);
  }

  // Whether it is in a state. Not always, so that edits meet what others left for later. What is unknown so
  // far is known then.
  void look(std::uint64_t& state) {
    if (random_.below(2) == 0) return;
    const std::uint64_t now = subject_.state();
    ASSERT_TRUE(state == kUnknown || state == now);
    state = now;
  }

  static constexpr std::uint64_t kUnknown = 0;

  Subject& subject_;
  Random random_;
  std::vector<std::uint64_t> memory_;
  UndoLog log_;
  std::vector<std::uint64_t> states_;  // of steps, the oldest first
  std::size_t now_ = 0;
  Counts counts_;
  std::map<std::string, int> refused_for_;
};

TEST(Undo, VoxelsAreWhatTheyWere) {
  Voxels world(3, 2'000, 0);
  Play play(world, 1 << 20, 21);
  play.run(edits_asked());
  const int edits = play.counts().edits;
  EXPECT_GT(play.counts().changed, edits / 3);
  EXPECT_GT(play.counts().undone, edits / 5);
  EXPECT_GT(play.counts().redone, edits / 10);
}

// Pools that are full again and again: edits are refused, steps never.
TEST(Undo, VoxelsInTightPools) {
  Voxels world(4, 180, 24);
  Play play(world, 9 << 10, 22);
  play.run(edits_asked());
  const int edits = play.counts().edits;
  EXPECT_GT(play.refused_for("max_octets"), edits / 100);
  EXPECT_GT(play.refused_for("edit_patches"), edits / 50);
  EXPECT_GT(play.counts().undone, edits / 10);
  EXPECT_GT(play.counts().lost, edits / 200);
  EXPECT_GT(play.lost_steps(), static_cast<std::uint64_t>(edits) / 20);
}

TEST(Undo, GroundsAreWhatTheyWere) {
  Ground ground(64);
  Play play(ground, 1 << 20, 23);
  play.run(edits_asked());
  EXPECT_GT(play.counts().undone, play.counts().edits / 5);
  EXPECT_GT(play.counts().redone, play.counts().edits / 10);
}

}  // namespace
}  // namespace karst::core
