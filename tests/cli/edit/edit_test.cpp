// SPDX-License-Identifier: MIT
// karst edit as a user runs it: the same bytes for the same script, nothing where it fails, and a file that
// is the old world or the new one whenever it is killed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace karst {
namespace {

using test::ProcessResult;
using test::run_process;

constexpr const char* kDig =
    R"({"tool": "clear", "shape": "sphere", "place_m": [0, 20, 0], "radius_m": 70})"
    "\n"
    R"({"tool": "fill", "shape": "capsule", "place_m": [-99, 90, 40], "to_m": [99, 90, 40], "radius_m": 40})"
    "\n";

class KarstEdit : public testing::Test {
 protected:
  void SetUp() override { bake("2"); }
  void bake(const char* levels) {
    const ProcessResult made =
        run_process(KARST_BAKE_PATH, {"--sample", "hills", "--no-ground", "--voxel", "32", "--levels", levels,
                                      "--materials", "none", "--quiet", "-o", world()});
    ASSERT_EQ(made.code, 0) << made.err;
  }
  std::string world() const { return folder_.path("w.karst"); }
  ProcessResult edit(const std::string& script, const std::string& output) {
    folder_.write("s.json", script);
    return run_process(KARST_APP_PATH,
                       {"edit", world(), "--script", folder_.path("s.json"), "-o", folder_.path(output)});
  }
  std::string bytes(const std::string& name) const { return test::read_text(folder_.path(name)); }

  test::Folder folder_;
};

TEST_F(KarstEdit, NothingDoneIsTheSameFile) {
  const ProcessResult result = edit("[]", "same.karst");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(bytes("same.karst") == bytes("w.karst"));
}

TEST_F(KarstEdit, TheSameScriptMakesTheSameBytesAndAWholeWorld) {
  const ProcessResult result = edit(kDig, "a.karst");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("2 edits (0 changed nothing)"), std::string::npos) << result.out;
  EXPECT_FALSE(bytes("a.karst") == bytes("w.karst"));
  EXPECT_EQ(run_process(KARST_APP_PATH, {"info", folder_.path("a.karst")}).code, 0);
  ASSERT_EQ(edit(kDig, "b.karst").code, 0);
  EXPECT_TRUE(bytes("a.karst") == bytes("b.karst"));
  // In place; and saved again it stays what it is.
  ASSERT_EQ(edit(kDig, "w.karst").code, 0);
  EXPECT_TRUE(bytes("a.karst") == bytes("w.karst"));
  ASSERT_EQ(edit("[]", "c.karst").code, 0);
  EXPECT_TRUE(bytes("a.karst") == bytes("c.karst"));
}

// Heights of patches and paint: written, and undone to the same file.
TEST_F(KarstEdit, HeightsAndPaint) {
  const ProcessResult made =
      run_process(KARST_BAKE_PATH, {"--sample", "hills", "--no-ground", "--voxel", "32", "--levels", "2",
                                    "--quiet", "--material-side", "16", "-o", world()});
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string script =
      R"({"tool": "extrude", "place_m": [0, 40, 0], "radius_m": 90, "strength_m": 12}
{"tool": "paint", "place_m": [0, 0, 0], "radius_m": 60, "material": "sand", "joined": true}
)";
  const ProcessResult done = edit(script, "a.karst");
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_NE(done.out.find("2 edits (0 changed nothing)"), std::string::npos) << done.out;
  const ProcessResult info = run_process(KARST_APP_PATH, {"info", folder_.path("a.karst")});
  EXPECT_EQ(info.code, 0);
  EXPECT_NE(info.out.find("blend map      1024 x 1024 texels"), std::string::npos) << info.out;
  EXPECT_NE(info.out.find("sand"), std::string::npos) << info.out;
  ASSERT_EQ(edit(script + R"({"tool": "undo"})", "b.karst").code, 0);
  EXPECT_TRUE(bytes("b.karst") == bytes("w.karst"));
  const ProcessResult wrong =
      edit(R"({"tool": "paint", "place_m": [0, 0, 0], "material": "lava"})", "c.karst");
  EXPECT_EQ(wrong.code, 1);
  EXPECT_NE(wrong.err.find("edit 0: material: not one of the world's: none"), std::string::npos) << wrong.err;
}

TEST_F(KarstEdit, UndoAndRedoOfAScript) {
  ASSERT_EQ(edit(kDig, "a.karst").code, 0);
  const std::string undo = R"({"tool": "undo"})"
                           "\n",
                    redo = R"({"tool": "redo"})"
                           "\n";
  const std::string other = R"({"tool": "clear", "shape": "sphere", "place_m": [150, 30, 0], "radius_m": 60})"
                            "\n";
  const ProcessResult result = edit(std::string(kDig) + other + undo + undo + redo + redo + undo, "b.karst");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("3 edits (0 changed nothing), 3 taken back, 2 done again"), std::string::npos)
      << result.out;
  EXPECT_TRUE(bytes("a.karst") == bytes("b.karst"));
  ASSERT_EQ(edit(std::string(kDig) + undo + undo + undo + redo + redo + redo, "c.karst").code, 0);
  EXPECT_TRUE(bytes("a.karst") == bytes("c.karst"));
}

// Edits that are joined are taken back together; steps that find no room in the memory that a script begins
// with do in more.
TEST_F(KarstEdit, ManyStepsAreAllTakenBack) {
  bake("5");
  std::string script, undo;
  for (int n = 0; n < 12; ++n) {
    script += n % 2 == 0 ? R"({"tool": "clear")" : R"({"tool": "fill")";
    script += ", \"place_m\": [" + std::to_string(50 * (n / 2) - 150) + ", 30, 0], \"radius_m\": 100";
    script += n % 4 == 3 ? ", \"joined\": true}\n" : "}\n";
    if (n % 4 != 3) undo += "{\"tool\": \"undo\"}\n";
  }
  const ProcessResult result = edit(script + undo, "b.karst");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("12 edits (0 changed nothing), 9 taken back"), std::string::npos) << result.out;
  EXPECT_TRUE(bytes("b.karst") == bytes("w.karst"));
}

TEST_F(KarstEdit, FailuresSayWhatIsWrongAndWriteNothing) {
  const auto refused = [&](const std::string& script, const char* words, int code = 1) {
    const ProcessResult result = edit(script, "out.karst");
    EXPECT_EQ(result.code, code) << script;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  };
  refused(R"({"tool": "clear", "place_m": [0, 0, 0], "radius": 3})", "line 1: radius: unknown field");
  refused(R"({"tool": "clear", "shape": "voxel", "place_m": [0, 0, 0], "octree_level": 9})", "edit 0");
  refused(
      std::string(kDig) + R"({"tool": "clear", "shape": "voxel", "place_m": [0, 1, 0], "octree_level": 9})",
      "edit 2");
  refused("", "the file is empty");
  EXPECT_EQ(folder_.names(), (std::vector<std::string>{"s.json", "w.karst"}));
  const ProcessResult usage = run_process(KARST_APP_PATH, {"edit", world()});
  EXPECT_EQ(usage.code, 2);
  EXPECT_NE(usage.err.find("--script FILE is missing"), std::string::npos) << usage.err;
}

TEST_F(KarstEdit, KilledItLeavesTheOldWorldOrTheNewOne) {
  const std::string old = bytes("w.karst");
  ASSERT_EQ(edit(kDig, "new.karst").code, 0);
  const std::string made = bytes("new.karst");
  int olds = 0, news = 0;
  for (int n = 0; n < 40; ++n) {
    folder_.write("w.karst", old);
    char after[32];
    std::snprintf(after, sizeof after, "0.%03d", 2 + 3 * n);
    run_process("/usr/bin/timeout", {"-s", "KILL", after, KARST_APP_PATH, "edit", world(), "--script",
                                     folder_.path("s.json"), "-o", world()});
    const std::string now = bytes("w.karst");
    olds += now == old;
    news += now == made;
  }
  EXPECT_EQ(olds + news, 40);
  EXPECT_GT(olds, 0);
  // What a killed one left is gone after the next.
  ASSERT_EQ(edit(kDig, "last.karst").code, 0);
  for (const std::string& name : folder_.names()) EXPECT_EQ(name.find(".karst-"), std::string::npos) << name;
}

}  // namespace
}  // namespace karst
