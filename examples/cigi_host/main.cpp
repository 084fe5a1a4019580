// SPDX-License-Identifier: MIT
// A host of an image generator that speaks CIGI, karst-ig for one: it flies a circle and asks what lies below
// and ahead. Plain sockets; nothing of karst.
#include "message.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

constexpr char kHelp[] =
    R"(usage: cigi_host [OPTION...]

Flies a circle for an image generator (IG) that speaks CIGI, and prints what it answers: height above terrain
(HAT) and height of terrain (HOT) under the eye, the range straight ahead and down, and whether the circle's
centre is in sight.

  --ig ADDRESS:PORT      where the IG listens (127.0.0.1:8004)
  --listen ADDRESS:PORT  where its answers are to come (127.0.0.1:8005); port 0: any
  --center LAT,LON       degrees (46.5,8)
  --altitude M           above the ellipsoid (3000)
  --radius M             of the circle (2000)
  --speed M_S            (80)
  --seconds S            how long (10)
  --rate HZ              messages a second (60)
  --version 3.3|4.0      (3.3)
  --big                  numbers begin with their highest byte
  --record FILE          writes all datagrams, as JSON

examples:
  karst-ig alps.karst --listen 127.0.0.1:8004 --host 127.0.0.1:8005 &
  cigi_host --center 46.56,8.56 --altitude 3200 --seconds 60
  cigi_host --version 4.0 --record flight.json --seconds 1
)";

struct Options {
  sockaddr_in ig{}, listen{};
  Place center{46.5, 8.0, 3000};
  double radius_m = 2000, speed_m_s = 80, seconds = 10, rate_hz = 60;
  Dialect dialect;
  std::string record;
};

[[noreturn]] void fail(const std::string& line) {
  std::fprintf(stderr, "cigi_host: %s\n", line.c_str());
  std::exit(2);
}

double number(const std::string& name, const std::string& text, double least) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value) || value < least) {
    fail(name + ": '" + text + "' is not a number of " + std::to_string(least) + " or more");
  }
  return value;
}

sockaddr_in address(const std::string& name, const std::string& text) {
  const std::size_t colon = text.rfind(':');
  sockaddr_in result{};
  result.sin_family = AF_INET;
  if (colon == std::string::npos ||
      inet_pton(AF_INET, text.substr(0, colon).c_str(), &result.sin_addr) != 1) {
    fail(name + ": '" + text + "' is not an address like 127.0.0.1:8004");
  }
  result.sin_port = htons(static_cast<std::uint16_t>(number(name, text.substr(colon + 1), 0)));
  return result;
}

Options read_options(int count, char** words) {
  Options options;
  options.ig = address("--ig", "127.0.0.1:8004");
  options.listen = address("--listen", "127.0.0.1:8005");
  for (int i = 1; i < count; ++i) {
    const std::string name = words[i];
    if (name == "--help") {
      std::fputs(kHelp, stdout);
      std::exit(0);
    }
    if (name == "--big") {
      options.dialect.big = true;
      continue;
    }
    if (i + 1 == count) fail(name + ": see --help");
    const std::string value = words[++i];
    if (name == "--ig") {
      options.ig = address(name, value);
    } else if (name == "--listen") {
      options.listen = address(name, value);
    } else if (name == "--center") {
      const std::size_t comma = value.find(',');
      if (comma == std::string::npos) fail("--center: '" + value + "' is not LAT,LON");
      options.center.latitude_deg = number(name, value.substr(0, comma), -89);
      options.center.longitude_deg = number(name, value.substr(comma + 1), -180);
    } else if (name == "--altitude") {
      options.center.altitude_m = number(name, value, -1000);
    } else if (name == "--radius") {
      options.radius_m = number(name, value, 1);
    } else if (name == "--speed") {
      options.speed_m_s = number(name, value, 0);
    } else if (name == "--seconds") {
      options.seconds = number(name, value, 0);
    } else if (name == "--rate") {
      options.rate_hz = number(name, value, 1);
    } else if (name == "--record") {
      options.record = value;
    } else if (name == "--version" && (value == "3.3" || value == "4.0")) {
      options.dialect.major = value == "3.3" ? 3 : 4;
    } else {
      fail(name + " " + value + ": see --help");
    }
  }
  return options;
}

constexpr double kDegrees = 180 / 3.14159265358979323846;

// Where the circle is after so many seconds, clockwise from north, and where it heads. A degree of latitude
// is taken as 111,320 m.
Place on_circle(const Options& options, double seconds, float& yaw_deg) {
  const double angle = options.speed_m_s * seconds / options.radius_m;
  const double latitude_m = 111'320,
               longitude_m = latitude_m * std::cos(options.center.latitude_deg / kDegrees);
  yaw_deg = static_cast<float>(std::fmod(angle * kDegrees + 90, 360));
  return {options.center.latitude_deg + options.radius_m * std::cos(angle) / latitude_m,
          options.center.longitude_deg + options.radius_m * std::sin(angle) / longitude_m,
          options.center.altitude_m};
}

// All datagrams, {"sent": [...], "received": [...]}, in hexadecimal.
struct Recording {
  std::vector<std::vector<std::uint8_t>> sent, received;

  void write(const std::string& path) const {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (file == nullptr) fail("cannot write " + path);
    const auto list = [&](const char* name, const std::vector<std::vector<std::uint8_t>>& datagrams) {
      std::fprintf(file, "\"%s\": [", name);
      for (std::size_t i = 0; i < datagrams.size(); ++i) {
        std::fprintf(file, "%s\n\"", i == 0 ? "" : ",");
        for (const std::uint8_t byte : datagrams[i]) std::fprintf(file, "%02x", byte);
        std::fputc('"', file);
      }
      std::fputs("]", file);
    };
    std::fputs("{", file);
    list("sent", sent);
    std::fputs(",\n", file);
    list("received", received);
    std::fputs("}\n", file);
    if (std::fclose(file) != 0) fail("cannot write " + path);
  }
};

constexpr std::uint16_t kBelow = 1, kAhead = 2, kCenter = 3;

class Host {
 public:
  explicit Host(const Options& options) : options_(options), socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    const auto* here = reinterpret_cast<const sockaddr*>(&options_.listen);
    if (socket_ < 0 || bind(socket_, here, sizeof options_.listen) != 0) {
      fail(std::string("cannot listen: ") + std::strerror(errno) + "; --listen says where");
    }
  }
  ~Host() { close(socket_); }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  int run() {
    start_ = Clock::now();
    const auto frames = static_cast<std::uint32_t>(options_.seconds * options_.rate_hz);
    sent_at_.resize(frames + 1);
    for (std::uint32_t frame = 1; frame <= frames; ++frame) {
      send(frame);
      receive_until(start_ + seconds(frame / options_.rate_hz));
    }
    receive_until(Clock::now() + seconds(0.2));  // what is under way
    print_result(frames);
    if (!options_.record.empty()) recording_.write(options_.record);
    return ig_frames_ == 0 ? 1 : 0;
  }

 private:
  static Clock::duration seconds(double value) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(value));
  }

  void send(std::uint32_t frame) {
    const double time_s = (frame - 1) / options_.rate_hz;
    float yaw_deg = 0;
    const Place eye = on_circle(options_, time_s, yaw_deg);
    Message message(options_.dialect);
    message.ig_control(frame, static_cast<std::uint32_t>(time_s * 1e5), last_ig_frame_);
    message.entity(0, eye, yaw_deg, 0, 0);
    if (frame % 60 == 1) {  // an IG that starts later learns it too
      message.view_definition(0, 1, 200'000, 30, 20);
      message.view_on_entity(0, 0, -10);
      message.celestial_sphere(12, 0, 6'21'2024);
      message.visibility(80'000);
    }
    const auto second = static_cast<std::uint32_t>(options_.rate_hz);
    if (frame % second == 1 || second == 1) {
      message.hat_hot_extended(kBelow, eye, 0);
      message.los_segment(kCenter, eye, options_.center, 0);
    }
    // Every half second, by the IG itself.
    if (frame == 1) message.los_vector(kAhead, 0, 0, -20, 50'000, std::clamp(second / 2, 1u, 255u));
    const std::vector<std::uint8_t>& bytes = message.bytes();
    sent_at_[frame] = Clock::now();
    const auto* there = reinterpret_cast<const sockaddr*>(&options_.ig);
    if (sendto(socket_, bytes.data(), bytes.size(), 0, there, sizeof options_.ig) < 0) ++not_sent_;
    if (!options_.record.empty()) recording_.sent.push_back(bytes);
  }

  void receive_until(Clock::time_point end) {
    std::array<std::uint8_t, 65536> buffer;
    for (;;) {
      const auto left_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(end - Clock::now()).count();
      if (left_ns <= 0) return;
      pollfd readable{socket_, POLLIN, 0};
      const timespec wait{left_ns / 1'000'000'000, left_ns % 1'000'000'000};
      if (ppoll(&readable, 1, &wait, nullptr) <= 0) continue;
      const ssize_t size = recv(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (size < 0) continue;
      std::vector<Answer> answers;
      if (!read_answers(options_.dialect, buffer.data(), static_cast<std::size_t>(size), answers)) {
        ++not_understood_;
        continue;
      }
      if (!options_.record.empty()) {
        recording_.received.emplace_back(buffer.begin(), buffer.begin() + size);
      }
      for (const Answer& answer : answers) take(answer);
    }
  }

  void take(const Answer& answer) {
    switch (answer.what) {
      case Answer::What::start_of_frame:
        ++ig_frames_;
        last_ig_frame_ = answer.ig_frame;
        if (answer.last_host_frame > 0 && answer.last_host_frame < sent_at_.size() &&
            answer.last_host_frame != answered_) {
          answered_ = answer.last_host_frame;
          const std::chrono::duration<double, std::milli> passed = Clock::now() - sent_at_[answered_];
          round_trips_ms_.push_back(passed.count());
        }
        break;
      case Answer::What::hat_hot:
        if (answer.valid) {
          std::printf("frame %u: HAT %.2f m, HOT %.2f m\n", answered_, answer.hat_m, answer.hot_m);
        } else {
          std::printf("frame %u: no ground below\n", answered_);
        }
        break;
      case Answer::What::los:
        if (answer.id == kCenter) {
          std::printf("frame %u: the centre is %s\n", answered_, answer.visible ? "in sight" : "hidden");
        } else if (answer.valid) {
          std::printf("frame %u: ground ahead in %.2f m, at %.6f, %.6f, %.2f m\n", answered_, answer.range_m,
                      answer.place.latitude_deg, answer.place.longitude_deg, answer.place.altitude_m);
        } else {
          std::printf("frame %u: no ground ahead\n", answered_);
        }
        break;
    }
  }

  void print_result(std::uint32_t frames) {
    std::printf("%u messages sent, %zu lost here; %u frames of the IG, %u datagrams not understood\n", frames,
                not_sent_, ig_frames_, not_understood_);
    if (ig_frames_ == 0) std::printf("nobody answered: is an IG there, and is --listen its host?\n");
    if (round_trips_ms_.empty()) return;
    std::sort(round_trips_ms_.begin(), round_trips_ms_.end());
    std::printf("from a message to the Start of Frame that names it: median %.2f ms, worst %.2f ms\n",
                round_trips_ms_[round_trips_ms_.size() / 2], round_trips_ms_.back());
  }

  const Options options_;
  int socket_;
  Clock::time_point start_;
  std::vector<Clock::time_point> sent_at_;  // by frame
  std::vector<double> round_trips_ms_;
  Recording recording_;
  std::uint32_t last_ig_frame_ = 0, answered_ = 0, ig_frames_ = 0, not_understood_ = 0;
  std::size_t not_sent_ = 0;
};

}  // namespace

int main(int count, char** words) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  return Host(read_options(count, words)).run();
}
