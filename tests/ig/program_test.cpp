// SPDX-License-Identifier: MIT
// karst-ig as a process, driven over loopback by a host of the test's own.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <climits>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <glm/trigonometric.hpp>

#include "app/files/png_file.h"
#include "app/files/whole_file.h"
#include "ig/cigi/message_reader.h"
#include "ig/cigi/message_writer.h"
#include "ig/place/earth.h"
#include "platform/base/clock.h"
#include "tests/ig/test_ground.h"
#include "tests/support/process.h"

namespace karst::ig {
namespace {

using namespace cigi;
using test::Folder;
using test::ProcessResult;
using test::read_text;
using test::run_process;

constexpr int kWidth = 96, kHeight = 54;
constexpr double kLatitude = 46.25, kLongitude = 8.5, kAltitude_m = 300;
constexpr double kPatience_s = 60;  // the machine may be busy

double seconds_since(std::int64_t start) {
  return ms_between(start, now_ns()) / 1000;
}

app::PngPicture read_picture(const std::string& path) {
  app::WholeFile file;
  app::PngPicture picture;
  if (file.open(path, app::WholeFile::kMostBytes).ok())
    (void)app::decode_png(file.bytes(), 16'384, 1 << 28, picture);
  return picture;
}

// Pixels of which a channel differs by more than a few steps.
int pixels_apart(const app::PngPicture& a, const app::PngPicture& b) {
  if (a.width != b.width || a.height != b.height || a.rgba.empty()) return INT_MAX;
  int apart = 0;
  for (std::size_t n = 0; n < a.rgba.size(); n += 4) {
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(a.rgba[n + c] - b.rgba[n + c]));
    apart += most > 4 ? 1 : 0;
  }
  return apart;
}

class Host : public testing::Test {
 protected:
  Host() : buffer_(kMaxMessageBytes), writer_(buffer_, {3, 3}, Order::little) {
    world_ = folder_.write("world.karst", cave_ground_file());
    fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in own{};
    own.sin_family = AF_INET;
    own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof own);
    socklen_t length = sizeof own;
    getsockname(fd_, reinterpret_cast<sockaddr*>(&own), &length);
    port_ = ntohs(own.sin_port);
    // A port that is free now.
    const int other = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    ig_ = own;
    ig_.sin_port = 0;
    bind(other, reinterpret_cast<const sockaddr*>(&ig_), sizeof ig_);
    getsockname(other, reinterpret_cast<sockaddr*>(&ig_), &length);
    close(other);
  }
  ~Host() override {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    close(fd_);
  }

  void start(std::vector<std::string> more = {}) {
    std::vector<std::string> words{KARST_IG_PATH,
                                   world_,
                                   "--headless",
                                   "--anchor",
                                   "46.25,8.5,300",
                                   "--size",
                                   std::to_string(kWidth) + "x" + std::to_string(kHeight),
                                   "--listen",
                                   std::to_string(ntohs(ig_.sin_port)),
                                   "--host",
                                   std::to_string(port_),
                                   "--stats",
                                   folder_.path("stats.json"),
                                   "--picture",
                                   folder_.path("ig.png")};
    words.insert(words.end(), more.begin(), more.end());
    pid_ = fork();
    if (pid_ == 0) {
      const int said = open(folder_.path("said").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      dup2(said, STDERR_FILENO);
      std::vector<char*> raw;
      for (std::string& word : words) raw.push_back(word.data());
      raw.push_back(nullptr);
      execv(raw[0], raw.data());
      _exit(127);
    }
    ASSERT_GT(pid_, 0);
  }
  // SIGTERM to the end, seconds; below 0: it did not end well.
  double stop() {
    const std::int64_t asked = now_ns();
    kill(pid_, SIGTERM);
    int status = 0;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      if (seconds_since(asked) > kPatience_s) return -1;
      usleep(1000);
    }
    pid_ = 0;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? seconds_since(asked) : -1;
  }
  std::string said() const { return read_text(folder_.path("said")); }

  // --- messages
  void begin(IgMode mode = IgMode::operate) {
    writer_.clear();
    IgControl control;
    control.mode = mode;
    control.host_frame = ++frame_;
    control.database = database_;
    ASSERT_TRUE(writer_.write(control));
  }
  void add(const Packet& packet) { ASSERT_TRUE(writer_.write(packet)); }
  void add_entity(std::uint16_t id, Geodetic at, float yaw_deg, float pitch_deg, std::uint16_t type = 0,
                  std::uint8_t alpha = 255) {
    EntityControl control;
    control.entity = id;
    control.state = EntityState::active;
    control.type = type;
    control.alpha = alpha;
    EntityPosition position;
    position.entity = id;
    position.latitude_deg_or_x_m = at.latitude_deg;
    position.longitude_deg_or_y_m = at.longitude_deg;
    position.altitude_m_or_z_m = at.altitude_m;
    position.yaw_deg = yaw_deg;
    position.pitch_deg = pitch_deg;
    ASSERT_TRUE(writer_.write_entity(control, position));
  }
  void send() {
    const std::span<const std::byte> bytes = writer_.bytes();
    sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&ig_), sizeof ig_);
  }
  // Packets of the IG's messages until one is what is wanted; false: it does not come.
  bool receive(const std::function<bool(const Packet&)>& wanted) {
    std::vector<std::byte> message(65'536);
    const std::int64_t start = now_ns();
    bool found = false;
    while (!found && seconds_since(start) < kPatience_s) {
      pollfd ready{fd_, POLLIN, 0};
      if (poll(&ready, 1, 100) <= 0) continue;
      const ssize_t got = recv(fd_, message.data(), message.size(), 0);
      if (got < 0 || !reader_.open(std::span(message).first(static_cast<std::size_t>(got)), Speaker::ig))
        continue;
      Packet packet;
      while (reader_.next(packet)) found |= wanted(packet);
    }
    return found;
  }
  bool receive_frames(int count) {
    return receive(
        [&](const Packet& packet) { return std::holds_alternative<StartOfFrame>(packet) && --count <= 0; });
  }
  // Sends what was put together until the IG names it, and waits for pictures of it.
  bool show(int frames = 20) {
    send();
    const bool heard = receive([&](const Packet& packet) {
      const auto* const start = std::get_if<StartOfFrame>(&packet);
      if (start != nullptr && start->last_host_frame == frame_) return true;
      send();
      return false;
    });
    return heard && receive_frames(frames);
  }
  // As the anchor has it: metres to the east, up and to the south of the world's middle.
  static Geodetic geodetic(glm::dvec3 place_m) {
    const TestGround ground;
    Geodetic at;
    ground.earth().to_geodetic(place_m, at);
    return at;
  }
  app::PngPicture rendered(const std::string& camera, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"render", world_, "--camera", camera, "-o", folder_.path("render.png")};
    words.insert(words.end(), {"--size", std::to_string(kWidth) + "x" + std::to_string(kHeight)});
    for (const std::string& word : more) words.push_back(word);
    const ProcessResult result = run_process(KARST_APP_PATH, words);
    EXPECT_EQ(result.code, 0) << result.err;
    return read_picture(folder_.path("render.png"));
  }
  app::PngPicture picture() const { return read_picture(folder_.path("ig.png")); }

  Folder folder_;
  std::string world_;
  int fd_ = -1;
  std::uint16_t port_ = 0;
  sockaddr_in ig_{};
  pid_t pid_ = 0;
  std::uint32_t frame_ = 0;
  std::int8_t database_ = 1;
  std::vector<std::byte> buffer_;
  MessageWriter writer_;
  MessageReader reader_;
};

constexpr glm::dvec3 kEye{-30, 40, 35};  // metres of the world

// The same camera: yaw counts to the left there, and clockwise from north here.
TEST_F(Host, APictureIsThatOfKarstRender) {
  start();
  begin();
  add_entity(0, geodetic(kEye), 40, 0);
  ViewControl control;
  control.pitch_valid = true;
  control.pitch_deg = -30;
  add(control);
  ASSERT_TRUE(show()) << said();
  EXPECT_GE(stop(), 0) << said();
  const app::PngPicture same = rendered("-30,40,35,-40,-30");
  EXPECT_LE(pixels_apart(picture(), same), kWidth * kHeight / 200);
  EXPECT_GT(pixels_apart(picture(), rendered("-30,40,35,-20,-30")), kWidth * kHeight / 10);
}

// Half-angles, the sun and the visibility, against the options that say the same.
TEST_F(Host, ViewsAndAirAreAsTheHostSays) {
  start();
  begin();
  add_entity(3, geodetic(kEye), 40, -30);
  ViewControl control;
  control.entity = 3;
  control.yaw_valid = true;
  control.yaw_deg = 0;
  add(control);
  ViewDefinition definition;
  definition.left_valid = definition.right_valid = definition.top_valid = definition.bottom_valid = true;
  definition.top_deg = 20;
  definition.bottom_deg = -20;
  definition.right_deg =
      static_cast<float>(glm::degrees(std::atan(std::tan(glm::radians(20.0)) * kWidth / kHeight)));
  definition.left_deg = -definition.right_deg;
  add(definition);
  AtmosphereControl atmosphere;
  atmosphere.visibility_m = 40;
  add(atmosphere);
  ASSERT_TRUE(show()) << said();
  EXPECT_GE(stop(), 0) << said();
  // --haze says, in voxels, where 63 % of the light is haze, a visibility where 95 % is.
  const std::string haze = std::to_string(40 / kVoxel_m / std::log(20.0));
  const app::PngPicture same = rendered("-30,40,35,-40,-30", {"--fov", "40", "--haze", haze});
  EXPECT_LE(pixels_apart(picture(), same), kWidth * kHeight / 200);
  EXPECT_GT(pixels_apart(picture(), rendered("-30,40,35,-40,-30", {"--fov", "40"})), kWidth * kHeight / 20);
}

TEST_F(Host, SeveralViewsShareThePicture) {
  start({"--views", "1,2"});
  begin();
  add_entity(0, geodetic(kEye), 40, -30);
  for (const std::uint16_t view : std::initializer_list<std::uint16_t>{1, 2}) {
    ViewDefinition definition;
    definition.view = view;
    definition.group = 9;
    definition.mirror = view == 2 ? Mirror::horizontal : Mirror::none;
    add(definition);
  }
  ViewControl control;
  control.group = 9;
  add(control);
  ASSERT_TRUE(show()) << said();
  EXPECT_GE(stop(), 0) << said();
  const app::PngPicture both = picture();
  ASSERT_EQ(both.width, kWidth);
  int apart = 0, shown = 0;
  const auto at = [&](int x, int y, std::size_t c) {
    return int{both.rgba[static_cast<std::size_t>(y * kWidth + x) * 4 + c]};
  };
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) {
      int most = 0;
      for (std::size_t c = 0; c < 3; ++c)
        most = std::max(most, std::abs(at(x, y, c) - at(kWidth - 1 - x, y, c)));
      apart += most > 24 ? 1 : 0;
      shown += at(x, y, 0) != at(0, 0, 0) ? 1 : 0;
    }
  }
  EXPECT_GT(shown, kWidth * kHeight / 8);
  EXPECT_LE(apart, kWidth * kHeight / 50);
}

TEST_F(Host, EntitiesAreBoxesInThePicture) {
  start({"--box", "10,10,10"});
  begin();
  add_entity(0, geodetic(kEye), 0, 0);
  // 50 m ahead: north.
  add_entity(5, geodetic(kEye + glm::dvec3(0, 0, -50)), 0, 0, 7);
  ASSERT_TRUE(show()) << said();
  EXPECT_GE(stop(), 0) << said();
  const app::PngPicture with = picture();
  const app::PngPicture without = rendered("-30,40,35,0,0");
  ASSERT_EQ(with.width, without.width);
  // Its side: 10 m at 45 m.
  const double half = 5.0 / 45 / std::tan(glm::radians(30.0)) * (kHeight / 2.0);
  int inside = 0, outside = 0, total = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const std::size_t n = static_cast<std::size_t>(y * kWidth + x) * 4;
      int most = 0;
      for (std::size_t c = 0; c < 3; ++c)
        most = std::max(most, std::abs(with.rgba[n + c] - without.rgba[n + c]));
      const bool in = std::max(std::fabs(x + 0.5 - kWidth / 2.0), std::fabs(y + 0.5 - kHeight / 2.0)) < half;
      total += in ? 1 : 0;
      (in ? inside : outside) += most > 8 ? 1 : 0;
    }
  }
  EXPECT_GT(inside, total * 9 / 10);
  EXPECT_LT(outside, kWidth * kHeight / 100);
}

TEST_F(Host, AnswersInItsVersionAndOrder) {
  start();
  int asked = 0;
  for (const Version version : {Version{3, 3}, Version{4, 0}}) {
    for (const Order order : {Order::little, Order::big}) {
      writer_ = MessageWriter(buffer_, version, order);
      begin();
      HatHotRequest request;
      request.id = static_cast<std::uint16_t>(40 + asked);
      request.type = HatHotType::extended;
      const Geodetic at = geodetic({3, 60, 3});
      request.latitude_deg_or_x_m = at.latitude_deg;
      request.longitude_deg_or_y_m = at.longitude_deg;
      request.altitude_m_or_z_m = at.altitude_m;
      add(request);
      send();
      std::optional<HatHotExtendedResponse> found;
      bool named = false;
      ASSERT_TRUE(receive([&](const Packet& packet) {
        if (const auto* start = std::get_if<StartOfFrame>(&packet)) {
          named = start->last_host_frame == frame_ && start->database == 1 && start->mode == IgMode::operate;
          if (start->last_host_frame != frame_) send();
        }
        if (const auto* response = std::get_if<HatHotExtendedResponse>(&packet);
            response != nullptr && response->id == request.id) {
          found = *response;
        }
        return found.has_value();
      })) << said();
      EXPECT_TRUE(named);
      EXPECT_TRUE(reader_.version() == version && reader_.order() == order);
      TestGround ground;
      Hit hit;
      ASSERT_TRUE(ground.query().ground({3, 60, 3}, 0, Wait::for_file, hit));
      EXPECT_TRUE(found->valid);
      EXPECT_NEAR(found->hot_m, kAltitude_m + hit.place.y, 0.2);  // at the finest level, which is drawn
      EXPECT_NEAR(found->hat_m + found->hot_m, at.altitude_m, 1e-6);
      EXPECT_EQ(found->host_frame_low, frame_ & 15);
      ++asked;
    }
  }
  EXPECT_GE(stop(), 0) << said();
}

TEST_F(Host, WhatIsNotHereIsSaidOnce) {
  start();
  database_ = 9;
  begin();
  ViewControl control;
  control.view = 77;
  add(control);
  add(ComponentControl{});
  ASSERT_TRUE(receive([&](const Packet& packet) {
    send();
    const auto* const start = std::get_if<StartOfFrame>(&packet);
    return start != nullptr && start->database == -128;
  })) << said();
  ASSERT_TRUE(receive_frames(3));
  EXPECT_GE(stop(), 0) << said();
  for (const char* line :
       {"a database of another number", "a view or a group that is not here", "Component Control"}) {
    const std::size_t first = said().find(line);
    EXPECT_NE(first, std::string::npos) << line;
    EXPECT_EQ(said().find(line, first + 1), std::string::npos) << line;
  }
}

TEST_F(Host, StandbyForgetsAll) {
  start();
  begin();
  add_entity(0, geodetic(kEye), 40, -30);
  ASSERT_TRUE(show(2)) << said();
  begin(IgMode::standby);
  ASSERT_TRUE(show(20)) << said();
  EXPECT_GE(stop(), 0) << said();
  EXPECT_NE(read_text(folder_.path("stats.json")).find("\"entities\": 0"), std::string::npos);
}

// Junk, empty datagrams, and messages full of requests, as fast as two threads can: frames go on, and the end
// is heard. How fast it answers is asked for on an idle machine: KARST_ANSWER_S.
TEST_F(Host, FramesGoOnUnderFloods) {
  const char* const given = std::getenv("KARST_ANSWER_S");
  const double answer_s = given == nullptr ? 20 : std::strtod(given, nullptr);
  start();
  begin();
  for (std::uint16_t n = 0; n < 900; ++n) {
    LosVectorRequest request;
    request.id = n;
    request.extended = true;
    request.maximum_range_m = 1e6f;
    request.elevation_deg = -20;
    request.azimuth_deg = static_cast<float>(n % 360);
    request.source_latitude_deg_or_x_m = kLatitude;
    request.source_longitude_deg_or_y_m = kLongitude;
    request.source_altitude_m_or_z_m = 400;
    add(request);
  }
  ASSERT_TRUE(receive_frames(2)) << said();
  std::vector<std::byte> junk(3000);
  TestRandom random{3};
  for (std::byte& byte : junk) byte = static_cast<std::byte>(static_cast<int>(random.unit() * 256));
  std::atomic<bool> over = false;
  const auto flood = [&](std::span<const std::byte> bytes) {
    while (!over)
      sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&ig_), sizeof ig_);
  };
  std::thread one(flood, std::span<const std::byte>(junk));
  std::thread two(flood, writer_.bytes());
  const bool went_on = receive_frames(20);
  const double ended = stop();
  over = true;
  one.join();
  two.join();
  EXPECT_TRUE(went_on) << said();
  EXPECT_TRUE(ended >= 0 && ended < answer_s) << ended << said();
  const std::string lines = said();
  EXPECT_LT(std::count(lines.begin(), lines.end(), '\n'), 20) << lines;
}

TEST_F(Host, CommandLinesThatAreWrongAreRefused) {
  const auto refused = [&](std::vector<std::string> words, int code, const std::string& part) {
    const ProcessResult result = run_process(KARST_IG_PATH, words);
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  };
  refused({}, 2, "which WORLD?");
  refused({world_, "--headless", "--listen", "0.0.0.0:8004"}, 2, "--remote");
  refused({world_, "--headless", "--host", "192.168.1.1:8004"}, 2, "--remote");
  refused({world_, "--headless", "--listen", "x"}, 2, "--listen");
  refused({world_, "--headless", "--views", "1,1"}, 2, "view 1 twice");
  refused({world_, "--headless", "--anchor", "91,0"}, 2, "latitude");
  refused({world_, "--headless"}, 1, "--anchor");
}

}  // namespace
}  // namespace karst::ig
