// SPDX-License-Identifier: MIT
// karst view on a card made of nothing: the picture, the ways to show it, and everything that happens to a
// screen. The same in a real kernel is tests/kms.
#include <signal.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/view/fake_screen.h"

namespace karst::core {
namespace {

using test::FakeScreen;
using test::largest_difference;
using test::number_of;
using test::ScanOut;
using Words = std::vector<std::string>;

constexpr const char* kShowing = "showing on /dev/dri/card0 (fake) HDMI-A-1";

class Screen : public testing::Test {
 protected:
  void start(const Words& words = {}) {
    Words all{"--stats", screen_.folder().path("stats.json")};
    all.insert(all.end(), words.begin(), words.end());
    screen_.start(all);
  }
  // Starts it, and expects this to be said when the first picture is shown.
  void show(const Words& words, const std::string& how) {
    start(words);
    ASSERT_TRUE(screen_.wait_for(kShowing)) << screen_.messages();
    EXPECT_TRUE(screen_.wait_for(how, 1, 0)) << screen_.messages();
  }

  FakeScreen screen_;
};

// --- the picture

// Whoever can move stands on the ground at first; where nobody can, all of the world is shown.
TEST_F(Screen, BeginsOnTheGroundWhereKeysMoveIt) {
  const ScanOut all = screen_.rendered(320, 240);
  for (const char* mode : {"orbit", "none"}) {
    show({"--navigate", mode}, "");
    EXPECT_EQ(largest_difference(screen_.scan_out(), all), 0) << mode;
    screen_.stop();
  }
  show({"--navigate", "fly"}, "");
  const ScanOut flying = screen_.scan_out();
  screen_.stop();
  EXPECT_GT(largest_difference(flying, all), 30);
  show({"--navigate", "walk"}, "");
  EXPECT_EQ(largest_difference(screen_.scan_out(), flying), 0);
}

TEST_F(Screen, ShowsWhatRenderDraws) {
  const ScanOut expected = screen_.rendered(320, 240);
  struct Way {
    Words words;
    const char* how;
  };
  for (const Way& way :
       {Way{{}, "atomic with modifiers, 2 buffers"}, Way{{"--no-modifiers"}, "atomic without"},
        Way{{"--kms", "legacy"}, "legacy"}, Way{{"--buffers", "3"}, "3 buffers"}}) {
    screen_.set("card connected master atomic flips modifiers modes=320x240");
    show(way.words, way.how);
    EXPECT_EQ(largest_difference(screen_.scan_out(), expected), 0) << way.how;
    EXPECT_EQ(screen_.stop(), 0);
    EXPECT_NE(screen_.messages().find("fake: the console is back"), std::string::npos);
  }
}

// Turned pictures are drawn from the same vertices; only noise against banding knows its pixel.
TEST_F(Screen, TurnsByThePlaneWhereThatWorks) {
  const ScanOut upright = screen_.rendered(240, 320);
  screen_.set("card connected master atomic flips rotate modes=320x240");
  show({"--rotate", "90"}, "turned by the plane");
  EXPECT_EQ(largest_difference(screen_.scan_out(), upright), 0);
}

TEST_F(Screen, TurnsByTheProjectionElsewhere) {
  for (const int turns : {1, 2, 3}) {
    const bool side = turns != 2;
    const ScanOut upright = screen_.rendered(side ? 240 : 320, side ? 320 : 240);
    show({"--rotate", std::to_string(90 * turns)}, "turned by the projection");
    const ScanOut shown = screen_.scan_out();
    EXPECT_EQ(shown.width, 320);
    const ScanOut expected = test::turned_left(upright, turns);
    std::size_t apart = 0;
    for (std::size_t i = 0; i < shown.rgba.size() && shown.rgba.size() == expected.rgba.size(); ++i) {
      apart += std::abs(int{shown.rgba[i]} - int{expected.rgba[i]}) > 8 ? 1u : 0u;
    }
    EXPECT_EQ(shown.rgba.size(), expected.rgba.size());
    // Pixels on edges fall to either side.
    EXPECT_LT(static_cast<double>(apart), 0.01 * static_cast<double>(shown.rgba.size())) << 90 * turns;
    EXPECT_EQ(screen_.stop(), 0);
  }
}

TEST_F(Screen, SixteenBits) {
  screen_.set("card connected master atomic flips format565 modes=320x240");
  show({"--format", "rgb565"}, "atomic");
  EXPECT_LE(largest_difference(screen_.scan_out(), screen_.rendered(320, 240)), 8);
}

// --- modes and ways

TEST_F(Screen, Modes) {
  screen_.set("card connected master atomic flips modes=320x240,640x480,200x100");
  show({}, "320x240@60.00");
  screen_.stop();
  show({"--mode", "highest"}, "640x480@60.00");
  screen_.stop();
  show({"--mode", "200x100@60"}, "200x100@60.00");
  EXPECT_EQ(screen_.scan_out().width, 200);
  screen_.stop();
  start({"--mode", "200x100@50"});
  EXPECT_EQ(screen_.wait(), 1);
  EXPECT_NE(screen_.messages().find("no such mode; there are 320x240@60.00 640x480@60.00"),
            std::string::npos);
  show({"--mode", "1x1", "--mode-fallback"}, "320x240@60.00");
}

TEST_F(Screen, EachWayFallsBackToTheNext) {
  screen_.set("card connected master atomic flips modifiers modes=640x480,320x240 refuse=modifiers");
  show({}, "with modifiers: drmModeAddFB2: Invalid argument; trying the next way");
  EXPECT_TRUE(screen_.wait_for("640x480@60.00, atomic without modifiers", 1, 0));
  screen_.stop();
  screen_.set("card connected master atomic flips modes=640x480,320x240 refuse=640x480");
  show({}, "640x480@60.00, atomic without modifiers: TEST_ONLY commit: Numerical result out of range");
  EXPECT_TRUE(screen_.wait_for("HDMI-A-1 320x240@60.00, atomic", 1, 0));
  // A message about nothing does not make it try again.
  screen_.tell();
  EXPECT_FALSE(screen_.wait_for(kShowing, 2, 0.5)) << screen_.messages();
  screen_.stop();
  screen_.set("card connected master atomic flips modes=640x480 refuse=atomic");
  show({}, "640x480@60.00, legacy");
  screen_.stop();
  screen_.set("card connected master flips modes=640x480");
  show({}, "no atomic calls");
  EXPECT_TRUE(screen_.wait_for("640x480@60.00, legacy", 1, 0));
}

TEST_F(Screen, ListsOutputs) {
  const auto list = [&](const Words& more) {
    Words words{"view", "--list-outputs"};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_process(
        KARST_APP_PATH, words,
        {"LD_PRELOAD=" KARST_FAKE_KMS_PATH, "KARST_FAKE_STATE=" + screen_.folder().path("state")});
  };
  EXPECT_EQ(list({}).out, "/dev/dri/card0 fake HDMI-A-1 connected\n  320x240@60.00 preferred\n");
  EXPECT_NE(list({"--json"}).out.find("\"connector\": \"HDMI-A-1\""), std::string::npos);
  screen_.set("");
  EXPECT_EQ(list({}).code, 1);
}

// --- what happens to screens

TEST_F(Screen, WaitsForAMonitor) {
  screen_.set("");
  start();
  ASSERT_TRUE(screen_.wait_for("waiting for a monitor"));
  screen_.set("card master atomic flips modes=320x240");
  screen_.tell();
  ASSERT_TRUE(screen_.wait_for("no monitor (HDMI-A-1 disconnected)")) << screen_.messages();
  screen_.set("card connected master atomic flips modes=320x240");
  screen_.tell();
  EXPECT_TRUE(screen_.wait_for(kShowing, 1, 2)) << screen_.messages();
}

TEST_F(Screen, GivesUpWhenToldTo) {
  screen_.set("");
  start({"--wait", "0.3"});
  EXPECT_EQ(screen_.wait(3), 1);
  EXPECT_NE(screen_.messages().find("no display came within --wait"), std::string::npos);
}

// Random changes, each back within a second: the promise that tests/kms checks in a real kernel.
TEST_F(Screen, HundredCyclesOfPlugsAndMasters) {
  show({"--frames", "1000000"}, "320x240");
  std::mt19937 random(5);
  int unplugged = 0;
  double longest = 0;
  for (int cycle = 1; cycle <= 100; ++cycle) {
    const bool unplug = random() % 2 == 0;
    unplugged += unplug ? 1 : 0;
    screen_.set(unplug ? "card master atomic flips modes=320x240"
                       : "card connected atomic flips modes=320x240");
    if (unplug) screen_.tell();
    ASSERT_TRUE(unplug ? screen_.wait_for("the monitor is gone", unplugged, 2)
                       : screen_.wait_for(": Permission denied", cycle - unplugged, 2))
        << cycle << screen_.messages();
    screen_.set("card connected master atomic flips modes=320x240");
    const double start = test::seconds_now();
    if (unplug) screen_.tell();
    ASSERT_TRUE(screen_.wait_for("the picture is back", cycle, 2)) << cycle << screen_.messages();
    longest = std::max(longest, test::seconds_now() - start);
  }
  EXPECT_EQ(number_of(screen_.statistics(), "recoveries"), 101);  // the start is one
  EXPECT_LT(longest, 1.0);
  std::printf("%d times unplugged, %d times not master; longest %.3f s\n", unplugged, 100 - unplugged,
              longest);
  EXPECT_EQ(screen_.stop(), 0);
}

TEST_F(Screen, MasterLostAndRegained) {
  show({"--frames", "100000"}, "320x240");
  for (int cycle = 1; cycle <= 10; ++cycle) {
    screen_.set("card connected atomic flips modes=320x240");
    ASSERT_TRUE(screen_.wait_for(": Permission denied", cycle, 2)) << screen_.messages();
    screen_.set("card connected master atomic flips modes=320x240");
    ASSERT_TRUE(screen_.wait_for("the picture is back after", cycle, 1)) << screen_.messages();
  }
  EXPECT_EQ(screen_.stop(), 0);
}

TEST_F(Screen, AnotherModeIsAnotherPicture) {
  show({}, "320x240");
  screen_.set("card connected master atomic flips modes=200x100");
  screen_.tell();
  ASSERT_TRUE(screen_.wait_for("HDMI-A-1 200x100@60.00", 1, 2)) << screen_.messages();
  EXPECT_EQ(largest_difference(screen_.scan_out(), screen_.rendered(200, 100)), 0);
}

TEST_F(Screen, AnotherCardAfterAll) {
  show({"--frames", "100000"}, "320x240");
  screen_.set("");
  ASSERT_TRUE(screen_.wait_for("the card is gone", 1, 2)) << screen_.messages();
  screen_.set("card connected master atomic flips modes=320x240");
  EXPECT_TRUE(screen_.wait_for(kShowing, 2, 2)) << screen_.messages();
}

TEST_F(Screen, FlipsThatAreNeverToldCostATenthOfASecond) {
  screen_.set("card connected master atomic modes=320x240");
  show({"--frames", "5"}, "320x240");
  EXPECT_EQ(screen_.wait(5), 0);
  EXPECT_NE(screen_.messages().find("no word of a flip for 100 ms"), std::string::npos);
}

TEST_F(Screen, LostContextIsMadeAnew) {
  show({"--frames", "100000"}, "320x240");
  const ScanOut before = screen_.scan_out();
  screen_.set("card connected master atomic flips reset modes=320x240");
  ASSERT_TRUE(screen_.wait_for("the GL context is lost; making everything anew", 1, 2));
  screen_.set("card connected master atomic flips modes=320x240");
  ASSERT_TRUE(screen_.wait_for(kShowing, 2, 5)) << screen_.messages();
  EXPECT_EQ(largest_difference(screen_.scan_out(), before), 0);
  EXPECT_EQ(screen_.stop(), 0);
}

TEST_F(Screen, IdleDrawsNothingAndUsesNoTime) {
  show({}, "320x240");
  usleep(200'000);
  const std::string first = screen_.statistics();
  sleep(2);
  const std::string second = screen_.statistics();
  EXPECT_EQ(number_of(second, "frames"), number_of(first, "frames"));
  const double cpu = number_of(second, "cpu_s") - number_of(first, "cpu_s");
  EXPECT_LT(cpu, 0.02);
  std::printf("idle: %.2f %% CPU\n", cpu / 2 * 100);
}

TEST_F(Screen, ConsoleComesBackWhenKilled) {
  screen_.start({}, "", true);
  ASSERT_TRUE(screen_.wait_for(kShowing)) << screen_.messages();
  const std::string children = test::read_text("/proc/" + std::to_string(screen_.pid()) + "/task/" +
                                               std::to_string(screen_.pid()) + "/children");
  const pid_t child = std::atoi(children.c_str());
  ASSERT_GT(child, 0);
  kill(child, SIGKILL);
  EXPECT_EQ(screen_.wait(), 137);
  EXPECT_NE(screen_.messages().find("ended by signal 9; giving the console back"), std::string::npos);
  EXPECT_NE(screen_.messages().find("fake: the console is back"), std::string::npos);
}

// --- what fails

class Failures : public testing::TestWithParam<int> {};

// Each call that can fail does so once, at its every turn: karst view ends well or says why not, in time.
TEST_P(Failures, EveryCallAtEveryIndex) {
  if (GetParam() != EINVAL && std::getenv("KARST_ALL_ERRNOS") == nullptr) GTEST_SKIP() << "a long test";
  const std::string error = std::to_string(GetParam());
  const Words words{"--frames", "3", "--wait", "5", "--level", "1"};
  FakeScreen whole;
  whole.set("card connected master atomic flips modifiers modes=320x240,200x100");
  whole.start(words);
  ASSERT_EQ(whole.wait(), 0) << whole.messages();
  const long calls = whole.calls();
  ASSERT_GT(calls, 80);
  // Cleaning up, looking for something better, and what Mesa asks for itself: nobody misses anything.
  const Words silent{"drmModeRmFB",    "drmModeDestroyPropertyBlob", "drmModeGetConnectorCurrent",
                     "drmGetDevices2", "drmModeGetEncoder",          "drmModeGetPropertyBlob"};
  int failed = 0;
  for (long call = 1; call <= calls; ++call) {
    FakeScreen screen;
    screen.set("card connected master atomic flips modifiers modes=320x240,200x100");
    screen.start(words, std::to_string(call) + ":" + error);
    const int code = screen.wait(10);
    const std::string messages = screen.messages();
    EXPECT_TRUE(code == 0 || code == 1) << call << ": exit " << code << "\n" << messages;
    failed += code;
    const std::string name = test::read_text(screen.folder().path("calls"));
    const bool may_be_silent = std::any_of(silent.begin(), silent.end(), [&](const std::string& s) {
      return name.find(s) != std::string::npos;
    });
    std::string said = messages;
    for (const char* usual : {"fake: the console is back\n"}) {
      if (const std::size_t at = said.find(usual); at != std::string::npos)
        said.erase(at, std::strlen(usual));
    }
    const auto lines = std::count(said.begin(), said.end(), '\n');
    EXPECT_TRUE(lines > 2 || may_be_silent) << call << ": nothing said about it\n" << messages;
  }
  std::printf("%ld calls failed with errno %s: %d ends with a message, the rest went on\n", calls,
              error.c_str(), failed);
}

INSTANTIATE_TEST_SUITE_P(Errnos, Failures, testing::Values(EINVAL, ENODEV, EACCES, ENOMEM, EBUSY));

}  // namespace
}  // namespace karst::core
