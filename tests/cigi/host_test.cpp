// SPDX-License-Identifier: MIT
// The example host, which makes its bytes by itself: what it sends is what karst's writer would, and it
// understands what karst's writer answers. traffic/ has what it sent and received in a flight of a second
// over such an IG: `cigi_host --center 46.56,8.56 --rate 20 --seconds 1 --record FILE` with --version and
// --big.
#include "ig/cigi/message_reader.h"
#include "ig/cigi/message_writer.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

namespace karst::cigi {
namespace {

using Bytes = std::vector<std::byte>;

// The list of that name: strings in hexadecimal.
std::vector<Bytes> datagrams(const std::string& path, const std::string& list) {
  std::ifstream file(path);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  std::vector<Bytes> result;
  std::size_t at = text.find('"' + list + "\": [");
  if (at == std::string::npos) return result;
  const std::size_t end = text.find(']', at);
  for (at = text.find('[', at); (at = text.find('"', at)) < end; at = text.find('"', at) + 1) {
    Bytes bytes;
    for (++at; text[at] != '"'; at += 2) {
      bytes.push_back(static_cast<std::byte>(std::stoi(text.substr(at, 2), nullptr, 16)));
    }
    result.push_back(bytes);
  }
  return result;
}

// Read, written and the same again.
std::vector<Packet> read_again(const Bytes& bytes, Speaker speaker, MessageReader& reader) {
  std::vector<Packet> packets;
  Packet packet;
  if (!reader.open(bytes, speaker)) return packets;
  while (reader.next(packet)) packets.push_back(packet);
  Bytes buffer(bytes.size());
  MessageWriter writer(buffer, reader.version(), reader.order());
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const EntityControl* control = std::get_if<EntityControl>(&packets[i]);
    if (reader.version().major == 3 && control != nullptr) {
      EXPECT_TRUE(writer.write_entity(*control, std::get<EntityPosition>(packets[++i])));
    } else {
      EXPECT_TRUE(writer.write(packets[i]));
    }
  }
  EXPECT_EQ(Bytes(writer.bytes().begin(), writer.bytes().end()), bytes);
  return packets;
}

template <class T>
std::vector<T> all_of(const std::vector<Packet>& packets) {
  std::vector<T> result;
  for (const Packet& packet : packets) {
    if (const T* value = std::get_if<T>(&packet)) result.push_back(*value);
  }
  return result;
}

struct Traffic {
  const char* name;
  const char* arguments;
  Version version;
  Order order;
};
constexpr Traffic kTraffic[] = {{"v33_little", "--version 3.3", {3, 3}, Order::little},
                                {"v33_big", "--version 3.3 --big", {3, 3}, Order::big},
                                {"v40_little", "--version 4.0", {4, 0}, Order::little},
                                {"v40_big", "--version 4.0 --big", {4, 0}, Order::big}};

void check_sent(const std::vector<Bytes>& sent, const Traffic& traffic) {
  MessageReader reader;
  std::vector<Packet> packets;
  for (const Bytes& bytes : sent) {
    const std::vector<Packet> more = read_again(bytes, Speaker::host, reader);
    EXPECT_EQ(reader.version(), traffic.version);
    EXPECT_EQ(reader.order(), traffic.order);
    packets.insert(packets.end(), more.begin(), more.end());
  }
  const ReadCounts& counts = reader.counts();
  EXPECT_EQ(counts.messages, sent.size());
  EXPECT_EQ(counts.unknown + counts.malformed + counts.cut + counts.rejected, 0u);
  const auto controls = all_of<IgControl>(packets);
  ASSERT_EQ(controls.size(), sent.size());
  for (std::size_t i = 0; i < controls.size(); ++i) {
    EXPECT_EQ(controls[i].host_frame, i + 1);
    EXPECT_EQ(controls[i].mode, IgMode::operate);
    EXPECT_TRUE(controls[i].timestamp_valid);
    EXPECT_NEAR(controls[i].timestamp_10us, 5'000.0 * static_cast<double>(i), 1);
  }
  // A circle of 2 km in 3 km above 46.56, 8.56, from its north, eastwards.
  const auto positions = all_of<EntityPosition>(packets);
  ASSERT_EQ(positions.size(), sent.size());
  for (const EntityPosition& position : positions) {
    const double north_m = (position.latitude_deg_or_x_m - 46.56) * 111'320;
    const double east_m =
        (position.longitude_deg_or_y_m - 8.56) * 111'320 * std::cos(46.56 / 57.29577951308232);
    EXPECT_NEAR(std::hypot(north_m, east_m), 2'000, 0.001);
    EXPECT_EQ(position.altitude_m_or_z_m, 3'000);
    EXPECT_FALSE(position.attached);
  }
  EXPECT_EQ(positions[0].yaw_deg, 90);
  EXPECT_GT(positions.back().longitude_deg_or_y_m, positions.front().longitude_deg_or_y_m);
  for (const EntityControl& control : all_of<EntityControl>(packets)) {
    EXPECT_EQ(control.state, EntityState::active);
    EXPECT_EQ(control.alpha, 255);
  }
  const auto views = all_of<ViewDefinition>(packets);
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(views[0].left_deg, -30);
  EXPECT_EQ(views[0].right_deg, 30);
  EXPECT_EQ(views[0].top_deg, 20);
  EXPECT_EQ(views[0].bottom_deg, -20);
  EXPECT_EQ(views[0].far_m, 200'000);
  const auto view_controls = all_of<ViewControl>(packets);
  ASSERT_EQ(view_controls.size(), 1u);
  EXPECT_EQ(view_controls[0].pitch_deg, -10);
  const auto skies = all_of<CelestialSphereControl>(packets);
  ASSERT_EQ(skies.size(), 1u);
  EXPECT_EQ(skies[0].month(), 6u);
  EXPECT_EQ(skies[0].day(), 21u);
  EXPECT_EQ(skies[0].year(), 2024u);
  EXPECT_EQ(skies[0].hour, 12);
  ASSERT_EQ(all_of<AtmosphereControl>(packets).size(), 1u);
  EXPECT_EQ(all_of<AtmosphereControl>(packets)[0].visibility_m, 80'000);
  const auto heights = all_of<HatHotRequest>(packets);
  ASSERT_EQ(heights.size(), 1u);
  EXPECT_EQ(heights[0].id, 1);
  EXPECT_EQ(heights[0].type, HatHotType::extended);
  EXPECT_EQ(heights[0].system, CoordinateSystem::geodetic);
  EXPECT_EQ(heights[0].altitude_m_or_z_m, 3'000);
  const auto vectors = all_of<LosVectorRequest>(packets);
  ASSERT_EQ(vectors.size(), 1u);
  EXPECT_EQ(vectors[0].source, CoordinateSystem::entity);
  EXPECT_EQ(vectors[0].update_period, 10);
  EXPECT_EQ(vectors[0].elevation_deg, -20);
  EXPECT_EQ(vectors[0].maximum_range_m, 50'000);
  const auto segments = all_of<LosSegmentRequest>(packets);
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].destination_latitude_deg_or_x_m, 46.56);
  EXPECT_TRUE(segments[0].extended);
}

TEST(RecordedTraffic, IsReadAndWrittenAgain) {
  for (const Traffic& traffic : kTraffic) {
    SCOPED_TRACE(traffic.name);
    const std::string path = std::string(KARST_SOURCE_DIR "/tests/cigi/traffic/") + traffic.name + ".json";
    const std::vector<Bytes> sent = datagrams(path, "sent"), received = datagrams(path, "received");
    ASSERT_EQ(sent.size(), 20u);
    check_sent(sent, traffic);
    ASSERT_GE(received.size(), 10u);
    MessageReader reader;
    std::size_t answers = 0;
    for (const Bytes& bytes : received) answers += read_again(bytes, Speaker::ig, reader).size();
    EXPECT_GE(answers, received.size() + 4);  // Start of Frame each, HAT/HOT, LOS of the segment and two more
    EXPECT_EQ(reader.counts().malformed + reader.counts().unknown + reader.counts().cut, 0u);
  }
}

// An IG over a plain 1,000 m up, as far as the host's requests need one.
class PlainIg {
 public:
  PlainIg() : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in any = loopback(0);
    socklen_t size = sizeof any;
    bind(socket_, reinterpret_cast<sockaddr*>(&any), sizeof any);
    getsockname(socket_, reinterpret_cast<sockaddr*>(&any), &size);
    port_ = ntohs(any.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~PlainIg() {
    end_ = true;
    thread_.join();
    close(socket_);
  }
  PlainIg(const PlainIg&) = delete;
  PlainIg& operator=(const PlainIg&) = delete;

  int port() const { return port_; }

 private:
  static sockaddr_in loopback(int port) {
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    result.sin_port = htons(static_cast<std::uint16_t>(port));
    return result;
  }

  void serve() {
    std::array<std::byte, 2'048> in{}, out{};
    MessageReader reader;
    std::uint32_t ig_frame = 0;
    double altitude_m = 0;
    while (!end_) {
      pollfd readable{socket_, POLLIN, 0};
      if (poll(&readable, 1, 20) <= 0) continue;
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t got =
          recvfrom(socket_, in.data(), in.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
      if (got < 0 || !reader.open(std::span(in).first(static_cast<std::size_t>(got)), Speaker::host))
        continue;
      MessageWriter writer(out, reader.version(), reader.order());
      StartOfFrame frame;
      frame.mode = IgMode::operate;
      frame.ig_frame = ++ig_frame;
      Packet packet;
      std::vector<Packet> answers;
      while (reader.next(packet)) {
        if (const IgControl* control = std::get_if<IgControl>(&packet))
          frame.last_host_frame = control->host_frame;
        if (const EntityPosition* position = std::get_if<EntityPosition>(&packet)) {
          altitude_m = position->altitude_m_or_z_m;
        }
        if (const HatHotRequest* request = std::get_if<HatHotRequest>(&packet)) {
          HatHotExtendedResponse answer;
          answer.id = request->id;
          answer.valid = true;
          answer.hat_m = request->altitude_m_or_z_m - 1'000;
          answer.hot_m = 1'000;
          answer.normal_elevation_deg = 90;
          answers.push_back(answer);
        }
        if (const LosVectorRequest* request = std::get_if<LosVectorRequest>(&packet)) {
          vector_ = *request;
          asked_ = ig_frame;
        }
        if (const LosSegmentRequest* request = std::get_if<LosSegmentRequest>(&packet)) {
          LosExtendedResponse answer;
          answer.id = request->id;
          answer.responses = 1;
          answer.visible = true;
          answers.push_back(answer);
        }
      }
      if (asked_ != 0 && (ig_frame - asked_) % vector_.update_period == 0) {
        LosExtendedResponse answer;
        answer.id = vector_.id;
        answer.valid = answer.range_valid = true;
        answer.responses = 1;
        answer.range_m = (altitude_m - 1'000) / std::sin(-vector_.elevation_deg / 57.29577951308232f);
        answer.latitude_deg_or_x_m = 46.5;
        answer.longitude_deg_or_y_m = 8.5;
        answer.altitude_m_or_z_m = 1'000;
        answers.push_back(answer);
      }
      bool whole = writer.write(frame);
      for (const Packet& answer : answers) whole = whole && writer.write(answer);
      if (!whole) continue;
      sendto(socket_, writer.bytes().data(), writer.bytes().size(), 0, reinterpret_cast<sockaddr*>(&from),
             size);
    }
  }

  int socket_;
  int port_ = 0;
  LosVectorRequest vector_;
  std::uint32_t asked_ = 0;
  std::atomic<bool> end_ = false;
  std::thread thread_;
};

// KARST_RECORD_TRAFFIC=FOLDER keeps what is recorded.
TEST(CigiHost, FliesAndUnderstandsTheAnswers) {
  for (const Traffic& traffic : kTraffic) {
    SCOPED_TRACE(traffic.name);
    PlainIg ig;
    const char* folder = std::getenv("KARST_RECORD_TRAFFIC");
    const std::string record = (folder == nullptr ? testing::TempDir() : std::string(folder) + "/") +
                               traffic.name + (folder == nullptr ? "-" + std::to_string(getpid()) : "") +
                               ".json";
    const std::string command = std::string(KARST_CIGI_HOST_PATH " --ig 127.0.0.1:") +
                                std::to_string(ig.port()) +
                                " --listen 127.0.0.1:0"
                                " --center 46.56,8.56 --rate 20 --seconds 1 --record " +
                                record + " " + traffic.arguments + " 2>&1";
    std::FILE* pipe = popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::string said;
    std::array<char, 256> part{};
    while (std::fgets(part.data(), part.size(), pipe) != nullptr) said += part.data();
    EXPECT_EQ(pclose(pipe), 0) << said;
    EXPECT_NE(said.find("frame 1: HAT 2000.00 m, HOT 1000.00 m\n"), std::string::npos) << said;
    EXPECT_NE(said.find("frame 1: the centre is in sight\n"), std::string::npos) << said;
    const std::string ahead = ": ground ahead in 5847.61 m, at 46.500000, 8.500000, 1000.00 m\n";
    EXPECT_NE(said.find("frame 1" + ahead), std::string::npos) << said;
    EXPECT_NE(said.find("frame 11" + ahead), std::string::npos) << said;  // after the period, unasked
    EXPECT_NE(said.find("20 messages sent, 0 lost here; 20 frames of the IG, 0 datagrams not understood"),
              std::string::npos)
        << said;
    check_sent(datagrams(record, "sent"), traffic);
    EXPECT_EQ(datagrams(record, "received").size(), 20u);
    if (folder == nullptr) std::remove(record.c_str());
  }
}

TEST(CigiHost, SaysWhatIsWrong) {
  const auto says = [](const std::string& arguments) {
    std::FILE* pipe = popen((std::string(KARST_CIGI_HOST_PATH " ") + arguments + " 2>&1").c_str(), "r");
    std::string said;
    std::array<char, 256> part{};
    while (std::fgets(part.data(), part.size(), pipe) != nullptr) said += part.data();
    const int code = pclose(pipe);
    return std::to_string(WEXITSTATUS(code)) + " " + said;
  };
  EXPECT_EQ(says("--ig here"), "2 cigi_host: --ig: 'here' is not an address like 127.0.0.1:8004\n");
  EXPECT_EQ(says("--rate 0").substr(0, 30), "2 cigi_host: --rate: '0' is no");
  EXPECT_EQ(says("--version 2"), "2 cigi_host: --version 2: see --help\n");
  EXPECT_EQ(says("--help").substr(0, 18), "0 usage: cigi_host");
}

}  // namespace
}  // namespace karst::cigi
