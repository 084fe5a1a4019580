// SPDX-License-Identifier: MIT
// Fields sculpted through the public headers: what queries, frames and saved files say of it; random edits,
// strokes, undo and redo, whose world is always, to the bit, what it was at that step and what its file
// loads. KARST_EDITS: how many of those; default 150.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/library/host.h"
#include "tests/support/field_mesh.h"
#include "tests/support/heap_count.h"

#include "scene/world/world_object.h"

namespace karst {
namespace {

using test::draw_frame;
using test::gyroid_cave;
using test::heap_calls;
using test::HostTest;
using test::HostWorld;
using test::largest_difference;
using test::looking;
using test::OwnField;
using test::Pixels;
using test::Random;
using test::saved_by;
using test::share_beyond;

constexpr int kWidth = 160, kHeight = 120;

core::FieldInfo info_of(int bits, int cell_log2 = core::kMostCellLog2) {
  core::FieldInfo info = test::field_info(glm::ivec3(4), 0);
  info.sample_bits = bits;
  info.cell_log2 = cell_log2;
  return info;
}

// A cave; cells of half a voxel where cell_log2 says so.
std::vector<std::byte> cave_file(int bits = 8, int cell_log2 = core::kMostCellLog2) {
  OwnField own(info_of(bits, cell_log2), 64);
  own.fill(gyroid_cave(glm::dvec3(32), 26, 30));
  return test::field_world_file(own.field);
}

Needs needs_of(std::uint32_t blocks, std::uint64_t undo_bytes = 4 << 20) {
  Needs needs;
  needs.queries = 2;
  needs.field_sample_blocks = blocks;
  needs.undo_bytes = undo_bytes;
  return needs;
}

Edit ball(EditTool tool, Vec3 place, double radius_m) {
  Edit edit;
  edit.tool = tool;
  edit.place = place;
  edit.radius_m = radius_m;
  return edit;
}

class Live {
 public:
  Live(const Needs& needs, std::vector<std::byte> file)
      : host(needs, {.axes = Axes::east_up_south}, std::move(file)) {
    EXPECT_TRUE(host.world->take_editor(editor).ok());
  }
  ~Live() {
    if (editor != nullptr) host.world->release(editor);
  }
  Live(const Live&) = delete;

  const core::FieldBlocks& field() const {
    return static_cast<core::WorldObject&>(*host.world).terrain.world.field();
  }
  // A number of all that is saved.
  std::uint64_t state() const {
    const std::vector<std::byte> bytes = saved_by(*editor);
    return std::hash<std::string_view>()({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }

  HostWorld host;
  Editor* editor = nullptr;
};

TEST(FieldEdits, AHoleIsDugMetTakenBackAndSaved) {
  for (const int bits : {8, 16}) {
    Live live(needs_of(64), cave_file(bits));
    Query* query = nullptr;
    ASSERT_TRUE(live.host.world->take_query(query).ok());
    const Vec3 from{32, 90, 32}, to{32, -10, 32};
    Hit before, hit;
    ASSERT_TRUE(query->ray(from, to, Wait::never, before));
    EXPECT_GT(before.level, 0);
    const std::vector<std::byte> old = saved_by(*live.editor);
    EditResult result;
    ASSERT_TRUE(live.editor->apply(ball(EditTool::clear, before.place, 4), result).ok());
    EXPECT_TRUE(result.changed && result.can_undo);
    EXPECT_EQ(result.version, 1u);
    EXPECT_LE(result.low.y, before.place.y - 4);
    EXPECT_GE(result.high.y, before.place.y + 4);
    EXPECT_GE(result.low.y, before.place.y - 9);
    ASSERT_TRUE(query->ray(from, to, Wait::never, hit));
    // From above the cave's ceiling is met first.
    EXPECT_NEAR(hit.place.y, before.place.y + 4, 0.1);
    const Vec3 within{before.place.x, before.place.y + 2, before.place.z};
    EXPECT_FALSE(query->inside(within, Wait::never));
    Voxel voxel;
    EXPECT_FALSE(query->pick(from, to, 1, voxel));
    const std::vector<std::byte> dug = saved_by(*live.editor);
    EXPECT_NE(dug, old);
    // The same dab again changes nothing.
    ASSERT_TRUE(live.editor->apply(ball(EditTool::clear, before.place, 4), result).ok());
    EXPECT_FALSE(result.changed);
    Live again(needs_of(8), dug);
    EXPECT_EQ(saved_by(*again.editor), dug);
    ASSERT_TRUE(live.editor->undo(result).ok());
    EXPECT_TRUE(result.changed);
    EXPECT_EQ(saved_by(*live.editor), old);
    Hit back;
    ASSERT_TRUE(query->ray(from, to, Wait::never, back));
    EXPECT_EQ(back.place.y, before.place.y);
    ASSERT_TRUE(live.editor->redo(result).ok());
    EXPECT_EQ(saved_by(*live.editor), dug);
    live.host.world->release(query);
  }
}

TEST(FieldEdits, ErrorsNameTheFieldAndChangeNothing) {
  OwnField own(info_of(8), 64);
  own.fill(test::ball(glm::dvec3(32), 12));
  Live live(needs_of(2), test::field_world_file(own.field));
  const std::vector<std::byte> old = saved_by(*live.editor);
  EditResult result;
  const auto field_of = [&](const Edit& edit) {
    const Status status = live.editor->apply(edit, result);
    EXPECT_FALSE(status.ok());
    EXPECT_FALSE(result.changed);
    return std::string(status.ok() ? "" : status.field());
  };
  const Vec3 middle{32, 32, 32};
  EXPECT_EQ(field_of(ball(EditTool::clear, middle, std::nan(""))), "radius_m");
  EXPECT_EQ(field_of(ball(EditTool::clear, middle, 1e9)), "radius_m");
  EXPECT_EQ(field_of(ball(EditTool::clear, {32, HUGE_VAL, 32}, 2)), "place");
  EXPECT_EQ(field_of(ball(EditTool::extrude, middle, 2)), "tool");
  Edit voxel = ball(EditTool::clear, middle, 2);
  voxel.shape = BrushShape::voxel;
  EXPECT_EQ(field_of(voxel), "shape");
  // More than there is room for: all around the ball of rock is air without samples.
  Edit fill = ball(EditTool::fill, {32, 56, 32}, 0);
  fill.shape = BrushShape::box;
  fill.half_m = {25, 4, 25};
  EXPECT_EQ(field_of(fill), "field_sample_blocks");
  EXPECT_EQ(saved_by(*live.editor), old);
  EXPECT_EQ(live.editor->undo_state().undo_steps, 0u);
}

TEST(FieldEdits, WithoutRoomThereIsNoEditor) {
  HostWorld host(Needs(), {}, cave_file());
  Editor* editor = nullptr;
  EXPECT_EQ(host.world->take_editor(editor).code(), StatusCode::invalid_argument);
}

TEST(FieldEdits, QueriesOfOtherThreadsAnswerAsOne) {
  Live live(needs_of(64), cave_file());
  std::vector<std::vector<Hit>> answers(2);
  const auto ask = [&](std::size_t n) {
    Query* query = nullptr;
    ASSERT_TRUE(live.host.world->take_query(query).ok());
    Random random{7};
    for (int k = 0; k < 2'000; ++k) {
      const auto at = [&] { return Vec3{64 * random.unit(), 64 * random.unit(), 64 * random.unit()}; };
      Hit hit;
      const Vec3 from = at(), to = at();
      if (query->ray(from, to, Wait::never, hit)) answers[n].push_back(hit);
    }
    live.host.world->release(query);
  };
  std::thread other(ask, 0);
  ask(1);
  other.join();
  ASSERT_GT(answers[0].size(), 500u);
  ASSERT_EQ(answers[0].size(), answers[1].size());
  for (std::size_t n = 0; n < answers[0].size(); ++n) EXPECT_EQ(answers[0][n].place.x, answers[1][n].place.x);
}

// --- Frames

class FieldEditFrames : public HostTest {
 protected:
  FieldEditFrames() : HostTest(kWidth, kHeight) {}
};

TEST_F(FieldEditFrames, ATunnelShowsAtOnceAndIsClosed) {
  Needs needs = needs_of(64);
  open(needs, {.axes = Axes::east_up_south}, {}, cave_file());
  Editor* editor = nullptr;
  Query* query = nullptr;
  ASSERT_TRUE(host_->world->take_editor(editor).ok());
  ASSERT_TRUE(host_->world->take_query(query).ok());
  // Where rock is all around, a room is dug and looked at from within.
  const Vec3 middle{18.4, 40.9, 25};
  Edit dig = ball(EditTool::clear, middle, 5);
  dig.shape = BrushShape::capsule;
  dig.to = {26, 35, 31};
  EditResult result;
  ASSERT_TRUE(editor->apply(dig, result).ok());
  ASSERT_TRUE(result.changed);
  std::size_t seen = 0;
  for (int n = 0; n < 12; ++n) {
    const double turn = 0.5236 * n;
    const Vec3 target{middle.x + std::cos(turn), middle.y + 0.3 * std::sin(2 * turn),
                      middle.z + std::sin(turn)};
    ViewState view = looking(*host_->world, middle, target, kWidth, kHeight);
    set_perspective(view, 75, 0.05, 1000);
    view.error_px = n % 3 == 0 ? 0.5 : 4;
    FrameResult frame;
    const std::size_t beyond = holes(view, 0, frame);
    EXPECT_TRUE(frame.complete);
    // Only where a ray leaves through the cave's mouths, too.
    Hit hit;
    std::size_t free = 0;
    for (int k = 0; k < 400; ++k) {
      const double x = ((k % 20 + 0.5) / 10 - 1) * std::tan(0.6545) * kWidth / kHeight;
      const double y = ((k / 20 + 0.5) / 10 - 1) * std::tan(0.6545);
      const glm::dvec3 ahead =
          glm::normalize(glm::dvec3(target.x - middle.x, target.y - middle.y, target.z - middle.z));
      const glm::dvec3 right = glm::normalize(glm::cross(ahead, glm::dvec3(0, 1, 0)));
      const glm::dvec3 way = 200.0 * (ahead + x * right + y * glm::cross(right, ahead));
      free += !query->ray(middle, {middle.x + way.x, middle.y + way.y, middle.z + way.z}, Wait::never, hit);
    }
    EXPECT_NEAR(static_cast<double>(beyond) / (kWidth * kHeight), static_cast<double>(free) / 400, 0.02) << n;
    seen += beyond == 0;
  }
  EXPECT_GT(seen, 2u);
  host_->world->release(query);
  host_->world->release(editor);
}

TEST_F(FieldEditFrames, APictureIsThatOfItsFileAndOfWhatWasBefore) {
  open(needs_of(64), {.axes = Axes::east_up_south}, {}, cave_file());
  Editor* editor = nullptr;
  ASSERT_TRUE(host_->world->take_editor(editor).ok());
  const auto picture = [&] {
    ViewState view = looking(*host_->world, {70, 75, 90}, {32, 32, 32}, kWidth, kHeight);
    set_perspective(view, 60, 0.1, 1000);
    view.error_px = 1;
    draw_frame(*renderer_, picture_, {view});
    return picture_.read();
  };
  const Pixels before = picture();
  EditResult result;
  ASSERT_TRUE(editor->apply(ball(EditTool::clear, {44, 46, 50}, 9), result).ok());
  ASSERT_TRUE(editor->apply(ball(EditTool::smooth, {34, 50, 44}, 8), result).ok());
  Edit flat = ball(EditTool::flatten, {50, 40, 40}, 7);
  flat.up = {1, 0.5, 0};
  ASSERT_TRUE(editor->apply(flat, result).ok());
  const Pixels after = picture();
  EXPECT_GT(share_beyond(before, after, 4), 0.02);
  const std::vector<std::byte> file = saved_by(*editor);
  for (int n = 0; n < 3; ++n) ASSERT_TRUE(editor->undo(result).ok());
  EXPECT_EQ(largest_difference(before, picture()), 0);
  host_->world->release(editor);
  open(needs_of(64), {.axes = Axes::east_up_south}, {}, file);
  EXPECT_EQ(largest_difference(after, picture()), 0);
}

// --- Random edits

int edits_asked() {
  const char* const text = std::getenv("KARST_EDITS");
  return text != nullptr ? std::atoi(text) : 150;
}

Edit random_edit(Random& random, double side_m) {
  constexpr EditTool kTools[] = {EditTool::clear, EditTool::fill, EditTool::flatten, EditTool::smooth,
                                 EditTool::level};
  constexpr BrushShape kShapes[] = {BrushShape::sphere, BrushShape::box, BrushShape::capsule};
  const auto place = [&] {
    return Vec3{(1.2 * random.unit() - 0.1) * side_m, (1.2 * random.unit() - 0.1) * side_m,
                (1.2 * random.unit() - 0.1) * side_m};
  };
  Edit edit = ball(kTools[random.below(5)], place(), (0.01 + 0.1 * random.unit()) * side_m);
  edit.shape = kShapes[random.below(3)];
  edit.to = {edit.place.x + side_m * (0.4 * random.unit() - 0.2), edit.place.y,
             edit.place.z + side_m * (0.4 * random.unit() - 0.2)};
  edit.half_m = {edit.radius_m, 0.5 * edit.radius_m, 1.5 * edit.radius_m};
  edit.up = {random.unit() - 0.5, 1, random.unit() - 0.5};
  edit.amount = random.unit();
  edit.hardness = 0.9 * random.unit();
  switch (random.below(40)) {
    case 0:
      edit.place.y = std::nan("");
      break;
    case 1:
      edit.radius_m = edit.half_m.x = 1e6;
      break;
    case 2:
      edit.radius_m = edit.half_m.x = 0.4 * side_m;  // takes more samples than there is room for
      break;
    default:
      break;
  }
  return edit;
}

struct Play {
  int bits, cell_log2;
};

class AllKindsOfField : public testing::TestWithParam<Play> {};

TEST_P(AllKindsOfField, IsAlwaysWhatItWasAtThatStepAndWhatItsFileLoads) {
  const int asked = edits_asked();
  const Play& play = GetParam();
  Live live(needs_of(8, 1 << 20), cave_file(play.bits, play.cell_log2));
  const double side_m = live.host.world->info().field_cell_m * 64;
  Random random{static_cast<std::uint64_t>(play.bits)};
  std::vector<std::uint64_t> done{live.state()}, undone;
  std::uint64_t heap = 0;
  int edits = 0, changed = 0, refused = 0, taken = 0, again = 0, reloaded = 0;
  EditResult result;
  const auto look = [&] {
    ASSERT_EQ(test::open_edges(live.field()), 0u);
    const std::vector<std::byte> file = saved_by(*live.editor);
    Live loaded(needs_of(8), file);
    ASSERT_EQ(saved_by(*loaded.editor), file);
    ++reloaded;
  };
  for (int round = 0; edits < asked; ++round) {
    if (random.below(4) != 0) {
      const int dabs = random.below(5) == 0 ? 2 + random.below(6) : 1;
      if (dabs > 1) live.editor->begin_stroke();
      bool any = false;
      for (int n = 0; n < dabs; ++n) {
        const Edit edit = random_edit(random, side_m);
        const std::uint64_t calls = heap_calls();
        const Status status = live.editor->apply(edit, result);
        heap += heap_calls() - calls;
        refused += !status.ok();
        changed += result.changed;
        any = any || result.changed;
        ++edits;
      }
      if (dabs > 1) live.editor->end_stroke();
      const std::uint64_t now = live.state();
      if (dabs == 1) {
        ASSERT_EQ(any, now != done.back()) << round;
      }
      if (any) {
        done.push_back(now);
        undone.clear();
      } else {
        ASSERT_EQ(now, done.back()) << round;
      }
    } else {
      const bool back = random.below(3) != 0;
      const UndoState state = live.editor->undo_state();
      const std::uint64_t calls = heap_calls();
      ASSERT_TRUE((back ? live.editor->undo(result) : live.editor->redo(result)).ok());
      heap += heap_calls() - calls;
      if (back && state.undo_steps > 0) {
        ++taken;
        undone.push_back(done.back());
        done.pop_back();
      } else if (!back && state.redo_steps > 0) {
        ++again;
        done.push_back(undone.back());
        undone.pop_back();
      }
      ASSERT_EQ(live.state(), done.back()) << round;
    }
    if (round % 50 == 0) look();
    if (HasFatalFailure()) return;
  }
  while (live.editor->undo_state().undo_steps > 0) {
    ASSERT_TRUE(live.editor->undo(result).ok());
    undone.push_back(done.back());
    done.pop_back();
    ASSERT_EQ(live.state(), done.back());
  }
  look();
  while (live.editor->undo_state().redo_steps > 0) {
    ASSERT_TRUE(live.editor->redo(result).ok());
    ASSERT_EQ(live.state(), undone.back());
    undone.pop_back();
  }
  look();
  EXPECT_EQ(heap, 0u);
  EXPECT_GT(changed, asked / 4);
  EXPECT_GT(refused, 0);
  EXPECT_GT(taken, asked / 20);
  EXPECT_GT(again, 0);
  std::printf(
      "%d bits: %d edits, %d changed something, %d were refused; %d steps taken back, %d done again, "
      "%llu forgotten; %d reloaded and closed\n",
      play.bits, edits, changed, refused, taken, again,
      static_cast<unsigned long long>(live.editor->undo_state().lost_steps), reloaded);
}

INSTANTIATE_TEST_SUITE_P(Fields, AllKindsOfField,
                         testing::Values(Play{8, core::kMostCellLog2}, Play{16, core::kMostCellLog2 - 1}),
                         [](const auto& test) { return std::to_string(test.param.bits) + "Bits"; });

}  // namespace
}  // namespace karst
