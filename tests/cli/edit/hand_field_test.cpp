// SPDX-License-Identifier: MIT
// Fields edited by hand and by scripts: the same keys, the same journal, the same bytes.
#include <gtest/gtest.h>
#include <linux/input-event-codes.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "app/editor/hand_editor.h"
#include "tests/cli/edit/hand_world.h"
#include "tests/support/field_mesh.h"
#include "tests/support/process.h"

namespace karst::app {
namespace {

using test::ProcessResult;
using test::run_process;

// 64 samples a side, half a metre apart: rock up to some 16 m.
std::vector<std::byte> field_file() {
  core::FieldInfo info = test::field_info(glm::ivec3(4), 0);
  info.cell_log2 = core::kMostCellLog2 - 1;
  test::OwnField own(info, 64);
  own.fill([](glm::dvec3 p) { return p.y - 32 - 3 * std::sin(0.1 * p.x) * std::cos(0.12 * p.z); });
  return test::field_world_file(own.field);
}

class HandField : public testing::Test {
 protected:
  void SetUp() override { folder_.write("w.karst", field_file()); }
  std::string path() const { return folder_.path("w.karst"); }
  std::string bytes(const char* name) const { return test::read_text(folder_.path(name)); }
  test::Folder folder_;
};

TEST_F(HandField, KeysDigSmoothAndTakeBack) {
  EditSession session;
  ASSERT_EQ(session.open({path(), folder_.path("out.karst")}).text(), "");
  HandWorld world(path());
  ASSERT_EQ(session.begin(*world.world).text(), "");
  HandEditor hand(*world.world, *world.query, session);
  ViewState view;
  view.width_px = 640;
  view.height_px = 360;
  view.eye = {16, 28, 30};
  ASSERT_TRUE(look_at(view, {16, 16, 14}, {0, 1, 0}));
  set_perspective(view, 60, 0.1, 200);
  std::int64_t now = 1'000'000'000;
  const auto frames = [&](int count) {
    for (int n = 0; n < count; ++n) hand.frame(view, 0, now += 16'666'667);
  };
  const auto tap = [&](unsigned code) {
    for (const bool pressed : {true, false}) {
      InputEvent event;
      event.kind = InputEvent::Kind::key;
      event.code = code;
      event.pressed = pressed;
      hand.handle(event, [](const InputEvent&) {});
    }
    frames(1);
  };
  const auto rock = [&](const glm::dvec3& p) { return world.query->inside({p.x, p.y, p.z}, Wait::for_file); };
  frames(1);
  // The brush's size is told in cells of the field.
  EXPECT_DOUBLE_EQ(hand.brush().radius_m(), 1.5);
  const Aimed at = Aim(*world.world, *world.query).at(hand.brush(), view, 0, {0.5, 0.5});
  ASSERT_TRUE(at.found);
  const glm::dvec3 within = at.place - 0.7 * at.normal;
  ASSERT_TRUE(rock(within));
  tap(KEY_SPACE);
  frames(10);
  EXPECT_FALSE(rock(within)) << hand.message();
  EXPECT_EQ(session.undo_steps(), 1u);
  tap(KEY_Z);
  EXPECT_TRUE(rock(within));
  tap(KEY_Y);
  EXPECT_FALSE(rock(within));
  // Those tools and shapes alone that a field has.
  std::set<Tool> tools;
  for (int n = 0; n < 2 * kTools; ++n) {
    tap(KEY_T);
    tools.insert(hand.brush().tool());
  }
  EXPECT_EQ(tools,
            (std::set<Tool>{Tool::dig, Tool::fill, Tool::smooth, Tool::flatten, Tool::level, Tool::paint}));
  std::set<HandShape> shapes;
  for (int n = 0; n < 4; ++n) {
    tap(KEY_B);
    shapes.insert(hand.brush().shape());
  }
  EXPECT_EQ(shapes, (std::set<HandShape>{HandShape::sphere, HandShape::box}));
  while (hand.brush().tool() != Tool::smooth) tap(KEY_T);
  tap(KEY_SPACE);
  frames(10);
  EXPECT_EQ(session.undo_steps(), 2u) << hand.message();
  OverlayMesh mesh;
  mesh.start(view, 0);
  hand.draw(mesh);
  EXPECT_GE(mesh.lines({}).size(), 64u * 6);
  hand.end();
  session.end();
}

TEST_F(HandField, WhatWasNotSavedIsDoneAgainAndTheJournalIsAScript) {
  const auto save = [&](EditSession& session) { ASSERT_EQ(session.save().text(), ""); };
  const EditSession::Files files{path(), folder_.path("out.karst")};
  const std::vector<Edit> edits = {ball(16, 16, 16, 3), ball(20, 17, 18, 2, EditTool::fill),
                                   ball(17, 16, 15, 4, EditTool::smooth)};
  const auto apply = [&](EditSession& session) {
    for (const Edit& edit : edits) {
      session.begin_stroke();
      EditResult result;
      ASSERT_EQ(session.apply(edit, result).text(), "");
      ASSERT_TRUE(result.changed);
      ASSERT_EQ(session.end_stroke().text(), "");
    }
  };
  {
    EditSession session;
    ASSERT_EQ(session.open(files).text(), "");
    HandWorld world(session.base());
    ASSERT_EQ(session.begin(*world.world).text(), "");
    apply(session);
    session.end();  // as a crash leaves it
  }
  const std::string journal = path() + ".journal";
  ASSERT_TRUE(std::filesystem::exists(journal));
  std::filesystem::copy_file(journal, folder_.path("script.json"));
  {
    EditSession session;
    ASSERT_EQ(session.open(files).text(), "");
    HandWorld world(session.base());
    ASSERT_EQ(session.begin(*world.world).text(), "");
    EXPECT_EQ(session.found(), edits.size());
    save(session);
    session.end();
  }
  EXPECT_FALSE(std::filesystem::exists(journal));
  const std::string saved = bytes("out.karst");
  EXPECT_NE(saved, bytes("w.karst"));
  const ProcessResult result =
      run_process(KARST_APP_PATH,
                  {"edit", path(), "--script", folder_.path("script.json"), "-o", folder_.path("by.karst")});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(bytes("by.karst") == saved);
}

TEST_F(HandField, ScriptsTakeMoreRoomWhereTheyNeedItAndSayWhatIsWrong) {
  const auto edit = [&](const std::string& script) {
    folder_.write("s.json", script);
    return run_process(KARST_APP_PATH,
                       {"edit", path(), "--script", folder_.path("s.json"), "-o", folder_.path("d.karst")});
  };
  const ProcessResult made = run_process(
      KARST_BAKE_PATH, {"--field-shape", "sphere", "--field-size", "321,321,321", "--quiet", "-o", path()});
  ASSERT_EQ(made.code, 0) << made.err;
  // More blocks than a script is given at first.
  std::string script;
  for (int n = 0; n < 10; ++n) {
    script += R"({"tool": "fill", "shape": "box", "place_m": [)" + std::to_string(-140 + 31 * n) +
              R"(, 10, 0], "half_m": [1, 8, 120]})" + "\n";
    script += R"({"tool": "fill", "shape": "box", "place_m": [)" + std::to_string(-140 + 31 * n) +
              R"(, 300, 0], "half_m": [1, 8, 120]})" + "\n";
  }
  const ProcessResult result = edit(script + "{\"tool\": \"undo\"}\n");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("20 edits"), std::string::npos) << result.out;
  std::filesystem::remove(folder_.path("d.karst"));
  const ProcessResult wrong = edit(R"({"tool": "extrude", "place_m": [0, 0, 0], "radius_m": 3})");
  EXPECT_EQ(wrong.code, 1);
  EXPECT_NE(wrong.err.find("clear, fill, smooth, flatten and level"), std::string::npos) << wrong.err;
  const ProcessResult large = edit(R"({"tool": "fill", "place_m": [0, 0, 0], "radius_m": 500})");
  EXPECT_EQ(large.code, 1);
  EXPECT_NE(large.err.find("128 cells"), std::string::npos) << large.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.path("d.karst")));
}

}  // namespace
}  // namespace karst::app
