// SPDX-License-Identifier: MIT
// karst view answers whatever comes: floods of datagrams, of lines and of signals, a program that hangs,
// paths out of reach.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/view/fake_screen.h"

namespace karst::test {
namespace {

// From SIGTERM to the end. Here it tells an answer from none, whatever else the machine does; long.answers
// asks for half a second, by KARST_ANSWER_S, on a machine that does nothing else.
double answer_s() {
  const char* const given = std::getenv("KARST_ANSWER_S");
  return given == nullptr ? 10 : std::strtod(given, nullptr);
}
constexpr useconds_t kFlood_us = 1'500'000;

// Calls `step` again and again until it is gone.
class Flood {
 public:
  template <class Step>
  explicit Flood(Step step)
      : thread_([this, step] {
          while (!over_) step();
        }) {}
  Flood(const Flood&) = delete;
  Flood& operator=(const Flood&) = delete;
  ~Flood() {
    over_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> over_{false};
  std::thread thread_;
};

std::vector<std::string> viewer(const FakeScreen& screen, std::vector<std::string> more) {
  more.insert(more.begin(), {"--headless", "--size", "64x36", "--stats", screen.folder().path("stats.json")});
  return more;
}

// Lets it flood for a while, then asks for the end; the flood goes on until then.
void expect_answer(FakeScreen& screen) {
  usleep(kFlood_us);
  const double asked = seconds_now();
  EXPECT_EQ(screen.stop(SIGTERM), 0) << screen.messages();
  EXPECT_LT(seconds_now() - asked, answer_s());
  const std::string said = screen.messages();
  EXPECT_LT(std::count(said.begin(), said.end(), '\n'), 50) << said.substr(0, 2000);
  EXPECT_GE(number_of(read_text(screen.folder().path("stats.json")), "frames"), 1);
}

void expect_answer_to_datagrams(const std::string& datagram, int port) {
  FakeScreen screen;
  screen.start(viewer(screen, {"--poses", "udp:" + std::to_string(port)}));
  ASSERT_TRUE(screen.listens() && !screen.statistics().empty()) << screen.messages();
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const auto send = [&] {
    sendto(fd, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  };
  {
    const Flood one(send);
    const Flood two(send);
    expect_answer(screen);
  }
  close(fd);
}

std::string repeated(const std::string& text, std::size_t bytes) {
  std::string result;
  while (result.size() + text.size() <= bytes) result += text;
  return result;
}

TEST(Loop, AnswersUnderFloodsOfDatagrams) {
  expect_answer_to_datagrams(repeated("a\n", 64'000), 45881);
  expect_answer_to_datagrams("", 45882);
  expect_answer_to_datagrams("0 30 0 10 -20\n", 45883);
  expect_answer_to_datagrams(repeated("0 30 0 10 -20\n", 60'000), 45884);
  expect_answer_to_datagrams("1e9 0 0 0 0\n", 45885);
  expect_answer_to_datagrams("1e9 ~2 0 0 0\n", 45886);
}

void expect_answer_to_lines(const std::string& lines) {
  int ends[2];
  ASSERT_EQ(pipe2(ends, O_CLOEXEC), 0);
  FakeScreen screen;
  screen.start(viewer(screen, {"--poses", "-"}), "", false, ends[0]);
  close(ends[0]);
  ASSERT_TRUE(screen.listens() && !screen.statistics().empty()) << screen.messages();
  fcntl(ends[1], F_SETFL, O_NONBLOCK);
  {
    const Flood flood([&] {
      if (write(ends[1], lines.data(), lines.size()) < 0) usleep(100);
    });
    expect_answer(screen);
  }
  close(ends[1]);
}

TEST(Loop, AnswersUnderFloodsOfLines) {
  signal(SIGPIPE, SIG_IGN);
  expect_answer_to_lines(repeated("a\n", 32'000));
  expect_answer_to_lines(repeated("\n", 32'000));
  expect_answer_to_lines(repeated("0 30 0 10 -20\n", 32'000));
  expect_answer_to_lines(std::string(32'000, '1'));
}

TEST(Loop, AnswersUnderFloodsOfSignals) {
  FakeScreen screen;
  screen.start(viewer(screen, {}));
  ASSERT_TRUE(screen.listens() && !screen.statistics().empty()) << screen.messages();
  const auto hang_up = [&] { screen.send(SIGHUP); };
  const Flood one(hang_up);
  const Flood two(hang_up);
  usleep(kFlood_us);
  const double asked = seconds_now();
  screen.send(SIGTERM);
  EXPECT_TRUE(screen.ends_within(answer_s())) << seconds_now() - asked;
}

// A world of tiles.
void make_ground(const FakeScreen& screen) {
  std::vector<std::int16_t> samples;
  for (int k = 0; k < 600 * 600; ++k) samples.push_back(static_cast<std::int16_t>(k % 600 / 3 + k % 7));
  const std::string dem = screen.folder().write("dem.bil", std::as_bytes(std::span(samples)));
  screen.folder().write("dem.hdr", std::string("ncols 600\nnrows 600\nnbits 16\npixeltype signedint\n"
                                               "byteorder I\n"));
  const ProcessResult baked = run_process(
      KARST_BAKE_PATH,
      {dem, "--ground", "--pixel-size", "10", "--material-side", "16", "-o", screen.world(), "--quiet"});
  ASSERT_EQ(baked.code, 0) << baked.err;
}

// Whatever it reads at that time: the world, tiles for the camera's height, or tiles for a frame.
TEST(Loop, AnswersWhileTheDiskIsSlow) {
  for (const char* read_ms : {"100", "30000"}) {
    for (const useconds_t after_us : {50'000u, 300'000u, 2'500'000u}) {
      FakeScreen screen;
      make_ground(screen);
      setenv("KARST_FAKE_READ_MS", read_ms, 1);
      screen.start(viewer(screen, {"--camera", "0,~2,0,0,-10"}));
      unsetenv("KARST_FAKE_READ_MS");
      ASSERT_TRUE(screen.listens());
      usleep(after_us);
      const double asked = seconds_now();
      EXPECT_EQ(screen.stop(SIGTERM), 0) << screen.messages();
      EXPECT_LT(seconds_now() - asked, answer_s()) << read_ms << " ms a read, after " << after_us << " us";
      EXPECT_EQ(screen.messages(), "");
    }
  }
}

// Checked before the first frame, as karst render does.
TEST(Loop, PathsOutOfReachAreRefusedAtTheStart) {
  FakeScreen screen;
  const std::string path = screen.folder().write("far.txt", "0 30 0 0 0\n1e9 0 0 0 0\n");
  screen.start(viewer(screen, {"--path", path, "--frames", "5"}));
  EXPECT_EQ(screen.wait(), 1);
  const std::string said = screen.messages();
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
  EXPECT_NE(said.find("far.txt: frame 1"), std::string::npos) << said;
}

TEST(Loop, CamerasOutOfReachAreRefusedAtTheStart) {
  FakeScreen screen;
  screen.start(viewer(screen, {"--camera", "1e9,0,0,0,0", "--frames", "5"}));
  EXPECT_EQ(screen.wait(), 1);
  EXPECT_NE(screen.messages().find("--camera: camera: more than 2^20 voxels"), std::string::npos)
      << screen.messages();
}

// What must not grow in months is counted, and is the same after everything was made anew.
TEST(Loop, DescriptorsAndObjectsAreCountedAndStay) {
  FakeScreen screen;
  screen.start({"--stats", screen.folder().path("stats.json")});
  ASSERT_TRUE(screen.wait_for("showing on")) << screen.messages();
  const std::string first = screen.statistics();
  EXPECT_GT(number_of(first, "descriptors"), 3);
  EXPECT_GT(number_of(first, "gl_objects"), 10);
  for (int n = 1; n <= 3; ++n) {
    screen.set("card connected master atomic flips modes=200x100");
    screen.tell();
    ASSERT_TRUE(screen.wait_for("HDMI-A-1 200x100@60.00", n)) << screen.messages();
    screen.set("card connected master atomic flips modes=320x240");
    screen.tell();
    ASSERT_TRUE(screen.wait_for("HDMI-A-1 320x240@60.00", n + 1)) << screen.messages();
  }
  const std::string last = screen.statistics();
  EXPECT_EQ(number_of(last, "descriptors"), number_of(first, "descriptors"));
  EXPECT_EQ(number_of(last, "gl_objects"), number_of(first, "gl_objects"));
  EXPECT_EQ(screen.stop(), 0);
}

// --- the supervisor

pid_t child_of(pid_t parent) {
  const std::string id = std::to_string(parent);
  const std::string children = read_text("/proc/" + id + "/task/" + id + "/children");
  return children.empty() ? -1 : std::stoi(children);
}

TEST(Supervisor, KillsAProgramThatDoesNotAnswer) {
  FakeScreen screen;
  screen.start({}, "", true);
  ASSERT_TRUE(screen.wait_for("showing on")) << screen.messages();
  const pid_t child = child_of(screen.pid());
  ASSERT_GT(child, 0);
  ASSERT_EQ(kill(child, SIGSTOP), 0);
  const double asked = seconds_now();
  EXPECT_EQ(screen.stop(SIGTERM), 128 + SIGKILL);
  EXPECT_GT(seconds_now() - asked, 2.5);
  EXPECT_LT(seconds_now() - asked, 5);
  EXPECT_NE(kill(child, 0), 0) << "it still runs";
}

TEST(Supervisor, FloodsOfSighupHideNoSigterm) {
  FakeScreen screen;
  screen.start({}, "", true);
  ASSERT_TRUE(screen.wait_for("showing on")) << screen.messages();
  const auto hang_up = [&] { screen.send(SIGHUP); };
  const Flood one(hang_up);
  const Flood two(hang_up);
  usleep(kFlood_us);
  screen.send(SIGTERM);
  EXPECT_TRUE(screen.ends_within(answer_s()));
}

// A parent that ignores SIGCHLD hands that down.
TEST(Supervisor, KnowsHowItsChildEndedWhereSigchldWasIgnored) {
  FakeScreen screen;
  signal(SIGCHLD, SIG_IGN);
  screen.start({}, "", true);
  signal(SIGCHLD, SIG_DFL);
  ASSERT_TRUE(screen.wait_for("showing on")) << screen.messages();
  const pid_t child = child_of(screen.pid());
  ASSERT_GT(child, 0);
  ASSERT_EQ(kill(child, SIGKILL), 0);
  EXPECT_EQ(screen.wait(), 128 + SIGKILL);
  EXPECT_NE(screen.messages().find("ended by signal 9"), std::string::npos) << screen.messages();
}

}  // namespace
}  // namespace karst::test
