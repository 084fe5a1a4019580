// SPDX-License-Identifier: MIT
// Poses from other programs: pieces of lines, nonsense, floods.
#include "app/motion/pose_stream.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/view/fake_screen.h"

namespace karst::app {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

struct Lines {
  std::vector<std::string> reports;
  Messages messages{[this](const std::string& line) { reports.push_back(line); }};
  PoseLines lines{"poses", &messages};
  CameraPlace place;
};

TEST(PoseLines, PiecesMakeLinesAndTheLastCounts) {
  Lines l;
  EXPECT_FALSE(l.lines.feed("1 2 3 ", 0, l.place));
  EXPECT_TRUE(l.lines.feed("4 5\n6 7 8 9 10\n11 ", 0, l.place));
  EXPECT_EQ(l.place.position_m, glm::dvec3(6, 7, 8));
  EXPECT_EQ(l.place.yaw_deg, 9);
  EXPECT_TRUE(l.lines.feed("12 13 14 15  # a comment\r\n", 0, l.place));
  EXPECT_EQ(l.place.pitch_deg, 15);
  EXPECT_EQ(l.lines.poses(), 3u);
  EXPECT_TRUE(l.reports.empty());
}

TEST(PoseLines, NonsenseIsReportedAndIgnored) {
  Lines l;
  std::int64_t now = 0;
  for (const char* bad : {"1 2 3 4\n", "1 2 3 4 5 6\n", "a b c d e\n", "1 2 3 4 nan\n", "1 2 3 4 91\n",
                          "1 2 3 1e7 0\n", "inf 2 3 4 5\n"}) {
    EXPECT_FALSE(l.lines.feed(bad, now += kSecond, l.place)) << bad;  // a second apart: all are reported
  }
  EXPECT_EQ(l.lines.malformed(), 7u);
  EXPECT_EQ(l.reports.size(), 7u);
  EXPECT_NE(l.reports[0].find("a line is X Y Z YAW PITCH"), std::string::npos);
  EXPECT_FALSE(l.lines.feed("\n  \n# nothing\n", 0, l.place));
  EXPECT_EQ(l.lines.malformed(), 7u);
}

TEST(PoseLines, ReportsAreABurstAndThenFiveASecond) {
  Lines l;
  for (int i = 0; i < 10'000; ++i) l.lines.feed("nonsense\n", kSecond + i, l.place);
  EXPECT_EQ(l.reports.size(), static_cast<std::size_t>(Messages::kBurstOfOthers));
  l.reports.clear();
  for (int i = 0; i < 1000; ++i) l.lines.feed("nonsense\n", 2 * kSecond + i, l.place);
  ASSERT_EQ(l.reports.size(), 6u);
  EXPECT_EQ(l.reports[0], std::to_string(10'000 - Messages::kBurstOfOthers) + " more lines were left out");
  EXPECT_EQ(l.lines.malformed(), 11'000u);
}

// Junk of others hides nothing of what the program says itself, which has an end too.
TEST(Messages, JunkHidesNothing) {
  Lines l;
  for (int i = 0; i < 1000; ++i) l.lines.feed("nonsense\n", kSecond, l.place);
  l.reports.clear();
  l.messages.say("the monitor is gone", kSecond);
  ASSERT_EQ(l.reports.size(), 2u);
  EXPECT_EQ(l.reports[1], "the monitor is gone");
  for (int i = 0; i < 1000; ++i) l.messages.say("again", kSecond);
  EXPECT_EQ(l.reports.size(), std::size_t{Messages::kBurst - Messages::kBurstOfOthers} + 1);
}

// What is older than the last line of a datagram is not looked at: a flood of them costs its last lines.
TEST(PoseLines, TheLastLineOfADatagramCounts) {
  Lines l;
  EXPECT_TRUE(l.lines.datagram("junk\nmore junk\n1 2 3 4 5\n 6 7 8 9 10 \r\n\n \n", 0, l.place));
  EXPECT_EQ(l.place.position_m, glm::dvec3(6, 7, 8));
  EXPECT_EQ(l.lines.poses(), 1u);
  EXPECT_EQ(l.lines.malformed(), 0u);
  EXPECT_FALSE(l.lines.datagram("1 2 3 4 5\njunk", 0, l.place));
  EXPECT_FALSE(l.lines.datagram("", 0, l.place));
  EXPECT_FALSE(l.lines.datagram("\n\n\n", 0, l.place));
  EXPECT_FALSE(l.lines.datagram(std::string(600, '1'), 0, l.place));
  EXPECT_EQ(l.lines.malformed(), 2u);
}

TEST(PoseLines, LongLinesCostNothing) {
  Lines l;
  const std::string piece(300, '1');
  for (int i = 0; i < 1000; ++i) l.lines.feed(piece, 0, l.place);
  EXPECT_TRUE(l.lines.feed("\n1 2 3 4 5\n", 0, l.place));
  EXPECT_EQ(l.lines.malformed(), 1u);
}

TEST(PoseStream, SourcesAreChecked) {
  for (const char* good : {"-", "udp:4000", "udp:0.0.0.0:4000", "udp:[::1]:4000"}) {
    EXPECT_EQ(check_pose_source(good).text(), "") << good;
  }
  for (const char* bad : {"", "4000", "tcp:4000", "udp:", "udp:0", "udp:65536", "udp:host:1", "udp:[x]:1"}) {
    EXPECT_NE(check_pose_source(bad).text(), "") << bad;
  }
}

// What a shell's terminal or pipe is must be the same when the program is gone, however it ended.
TEST(PoseStream, FlagsOfStandardInputStay) {
  int ends[2];
  ASSERT_EQ(pipe2(ends, O_CLOEXEC), 0);
  const int before = dup(STDIN_FILENO);
  ASSERT_EQ(dup2(ends[0], STDIN_FILENO), STDIN_FILENO);
  Lines l;
  {
    PoseStream stream;
    ASSERT_TRUE(stream.open("-", l.messages).ok());
    EXPECT_EQ(fcntl(ends[0], F_GETFL) & O_NONBLOCK, 0);
    CameraPlace place;
    EXPECT_FALSE(stream.dispatch(place));  // and does not wait
    ASSERT_EQ(write(ends[1], "1 2 3 4 5\n", 10), 10);
    EXPECT_TRUE(stream.dispatch(place));
    EXPECT_EQ(place.pitch_deg, 5);
    close(ends[1]);
    EXPECT_FALSE(stream.dispatch(place));
    EXPECT_EQ(stream.fd(), -1);
  }
  dup2(before, STDIN_FILENO);
  close(before);
  close(ends[0]);
}

// A datagram of a line moves the camera; the port is open on this machine only.
TEST(PoseStream, DatagramsMoveTheView) {
  test::FakeScreen screen;
  screen.start({"--poses", "udp:45871", "--stats", screen.folder().path("stats.json")});
  ASSERT_TRUE(screen.wait_for("showing on")) << screen.messages();
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(45871);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const auto send = [&](const std::string& text) {
    return sendto(fd, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  };
  EXPECT_GT(send("rubbish"), 0);
  EXPECT_GT(send("5 9 4 30 -10"), 0);
  close(fd);
  ASSERT_TRUE(screen.wait_for("udp:45871", 1)) << screen.messages();
  std::string statistics;
  for (int i = 0; i < 50 && test::number_of(statistics, "frames") < 2; ++i) {
    usleep(50'000);
    statistics = screen.statistics();
  }
  EXPECT_EQ(test::number_of(statistics, "taken"), 1);
  EXPECT_EQ(test::number_of(statistics, "malformed"), 1);
  usleep(500'000);  // what is drawn coarsely first becomes complete
  EXPECT_EQ(
      test::largest_difference(screen.scan_out(), screen.rendered(320, 240, {"--camera", "5,9,4,30,-10"})),
      0);
  const std::string listening = test::read_text("/proc/net/udp");
  EXPECT_NE(listening.find("0100007F:B32F"), std::string::npos);  // 127.0.0.1:45871
}

}  // namespace
}  // namespace karst::app
