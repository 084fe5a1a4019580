// SPDX-License-Identifier: MIT
// Board profiles: the built-in ones are sound, and wrong ones are told where they are wrong.
#include "boards/board_profile.h"

#include <algorithm>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/process.h"
#include "tests/view/fake_screen.h"

namespace karst {
namespace {

std::string text_of(const std::string& name) {
  for (const BoardText& board : board_texts()) {
    if (board.name == name) return board.text;
  }
  return {};
}

std::string with(const std::string& key, const std::string& line) {
  std::string text = text_of("tiny");
  const std::size_t at = text.find("\n" + key + " =") + 1;
  return text.replace(at, text.find('\n', at) + 1 - at, line);
}

TEST(Board, AllThatArePromisedAreThereAndSound) {
  std::set<std::string> names;
  for (const BoardText& board : board_texts()) {
    BoardProfile profile;
    EXPECT_EQ(find_board(board.name, profile).text(), "");
    EXPECT_EQ(profile.name, board.name);
    names.insert(board.name);
  }
  for (const char* name : {"host-llvmpipe", "raspberry-pi-4", "raspberry-pi-5", "imx8mq", "rk3399", "rk3588",
                           "am625", "stm32mp25", "qemu-virt", "tiny"}) {
    EXPECT_TRUE(names.count(name) == 1) << name;
  }
}

TEST(Board, WrongProfilesAreTold) {
  const auto error = [](const std::string& text) {
    BoardProfile profile;
    return parse_board(text, "x.board", profile).text();
  };
  EXPECT_EQ(error(text_of("tiny")), "");
  EXPECT_EQ(error("\xEF\xBB\xBF" + text_of("tiny")), "") << "a byte order mark";
  EXPECT_NE(error(""), "");
  EXPECT_EQ(error(with("level", "")), "x.board: level is missing");
  EXPECT_NE(error(with("level", "level = 7  # more\n")).find("level is not 1..6"), std::string::npos);
  EXPECT_NE(error(with("level", "level = 2\n")).find("level has no reason"), std::string::npos);
  EXPECT_NE(error(with("level", "levle = 2  # x\n")).find("unknown key 'levle'"), std::string::npos);
  EXPECT_NE(error(with("level", "level = 2  # a\nlevel = 2  # b\n")).find("given twice"), std::string::npos);
  for (const char* wrong :
       {"gpu_mib = 0.1 # x\n", "gpu_mib = 1e9 # x\n", "gpu_mib = nan # x\n", "gpu_mib = 3MiB # x\n"}) {
    EXPECT_NE(error(with("gpu_mib", wrong)).find("gpu_mib is not"), std::string::npos) << wrong;
  }
  for (const char* wrong : {"size = 320 # x\n", "size = 1x1 # x\n", "size = 320x240x2 # x\n"}) {
    EXPECT_NE(error(with("size", wrong)).find("size is not"), std::string::npos) << wrong;
  }
  for (const char* wrong :
       {"cascades = 4x1024 # x\n", "cascades = 1x1000 # x\n", "cascades = 2 # x\n", "cascades = 1x256 # x\n",
        "cascades = 1x4096 # x\n", "cascades = 3x1e123 # x\n"}) {
    EXPECT_NE(error(with("cascades", wrong)).find("cascades is not"), std::string::npos) << wrong;
  }
  BoardProfile profile;
  EXPECT_NE(find_board("pdp-11", profile).text().find("'pdp-11' is not one of am625, "), std::string::npos);
}

// What the renderer would refuse is no profile: budget and view agree.
TEST(Board, ShadowMapsAreThoseThatTheRendererTakes) {
  for (const char* right : {"cascades = 1x512 # x\n", "cascades = 3x2048 # x\n", "cascades = 2x1040 # x\n"}) {
    BoardProfile profile;
    EXPECT_EQ(parse_board(with("cascades", right), "x.board", profile).text(), "") << right;
  }
}

class BoardProgram : public testing::Test {
 protected:
  test::ProcessResult run(std::vector<std::string> words) { return test::run_process(KARST_APP_PATH, words); }
  test::FakeScreen screen_;  // for its world
};

TEST_F(BoardProgram, BudgetChecksEveryConsumer) {
  for (const BoardText& board : board_texts()) {
    EXPECT_EQ(run({"budget", screen_.world(), "--board", board.name}).code, 0) << board.name;
    EXPECT_EQ(run({"budget", "--board", board.name}).code, 0) << board.name;
  }
  const test::ProcessResult text = run({"budget", screen_.world(), "--board", "tiny"});
  for (const char* consumer : {"octets", "vertices", "targets", "scan_out", "cascades", "CPU:", "GPU:"}) {
    EXPECT_NE(text.out.find(consumer), std::string::npos) << consumer;
  }
  EXPECT_NE(run({"budget", "--board", "tiny", "--json"}).out.find("\"fits\": true"), std::string::npos);
}

TEST_F(BoardProgram, BudgetFailsWhereItDoesNotFit) {
  const std::string file =
      screen_.folder().write("mine.board", with("gpu_mib", "gpu_mib = 1  # too little\n"));
  const test::ProcessResult result = run({"budget", screen_.world(), "--board", file});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.out.find("DOES NOT FIT"), std::string::npos);
  EXPECT_NE(result.err.find("does not fit"), std::string::npos);
  EXPECT_EQ(run({"budget", "--board", "pdp-11"}).code, 2);
}

TEST_F(BoardProgram, RenderDrawsAsTheBoardWould) {
  const std::string picture = screen_.folder().path("board.png");
  const test::ProcessResult result =
      run({"render", screen_.world(), "-o", picture, "--board", "tiny", "--stats", "-"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("320"), std::string::npos);
  EXPECT_LE(test::number_of(result.out, "gpu_budget"), 3.0 * (1 << 20));
}

}  // namespace
}  // namespace karst
