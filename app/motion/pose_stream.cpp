// SPDX-License-Identifier: MIT
#include "app/motion/pose_stream.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "app/common/arguments.h"
#include "platform/base/clock.h"
#include "platform/base/log.h"

namespace karst::app {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr int kReportsASecond = 5;
constexpr std::size_t kLongestDatagram = 65'536;
// So that a flood of poses cannot keep frames from being drawn.
constexpr int kReadsADispatch = 256;

struct Address {
  sockaddr_storage storage{};
  socklen_t length = 0;
};

void set_ipv4(in_addr address, std::uint16_t port, Address& out) {
  sockaddr_in ipv4{};
  ipv4.sin_family = AF_INET;
  ipv4.sin_port = htons(port);
  ipv4.sin_addr = address;
  std::memcpy(&out.storage, &ipv4, sizeof ipv4);
  out.length = sizeof ipv4;
}

Error parse_udp(std::string_view text, Address& out) {
  const std::string what = "--poses " + std::string(text);
  text.remove_prefix(4);
  std::string host;
  const std::size_t colon = text.rfind(':');
  if (colon != std::string_view::npos) {
    host = text.substr(0, colon);
    text.remove_prefix(colon + 1);
  }
  std::int64_t port = 0;
  if (Error error = parse_integer(text, what + ": the port", 1, 65'535, port); !error.ok()) {
    return error;
  }
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    sockaddr_in6 ipv6{};
    ipv6.sin6_family = AF_INET6;
    ipv6.sin6_port = htons(static_cast<std::uint16_t>(port));
    if (inet_pton(AF_INET6, host.substr(1, host.size() - 2).c_str(), &ipv6.sin6_addr) != 1) {
      return what + ": not an IPv6 address";
    }
    std::memcpy(&out.storage, &ipv6, sizeof ipv6);
    out.length = sizeof ipv6;
    return {};
  }
  in_addr address{};
  address.s_addr = htonl(INADDR_LOOPBACK);  // whoever may move the camera is on this machine unless said so
  if (colon != std::string_view::npos && inet_pton(AF_INET, host.c_str(), &address) != 1) {
    return what + ": not an IPv4 address, nor [IPv6]";
  }
  set_ipv4(address, static_cast<std::uint16_t>(port), out);
  return {};
}

}  // namespace

Error check_pose_source(std::string_view text) {
  Address ignored;
  if (text == "-") return {};
  if (text.starts_with("udp:")) return parse_udp(text, ignored);
  return "--poses: '" + std::string(text) + "' is not -, udp:PORT or udp:ADDRESS:PORT";
}

bool PoseLines::feed(std::string_view bytes, std::int64_t now, CameraPlace& place) {
  bool any = false;
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    const std::string_view part = bytes.substr(0, end);
    if (part.size() > line_.size() - length_) {
      too_long_ = true;
    } else {
      std::copy(part.begin(), part.end(), line_.begin() + static_cast<std::ptrdiff_t>(length_));
      length_ += part.size();
    }
    if (end == std::string_view::npos) return any;
    bytes.remove_prefix(end + 1);
    any |= this->end(now, place);
  }
  return any;
}

bool PoseLines::end(std::int64_t now, CameraPlace& place) {
  const std::string_view line(line_.data(), length_);
  const bool too_long = too_long_;
  length_ = 0;
  too_long_ = false;
  if (!too_long) return take_line(line, now, place);
  complain(what_ + ": a line is longer than " + std::to_string(kLongestPoseLine) + " characters", now);
  return false;
}

bool PoseLines::take_line(std::string_view line, std::int64_t now, CameraPlace& place) {
  line = line.substr(0, line.find('#'));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  if (line.find_first_not_of(" \t") == std::string_view::npos) return false;
  CameraPlace taken;
  Error error = parse_camera_line(line, what_, taken);
  if (error.ok() && std::fabs(taken.pitch_deg) > 90)
    error = what_ + ": the pitch is not within -90..90 degrees";
  if (error.ok() && std::fabs(taken.yaw_deg) > 1e6)
    error = what_ + ": the yaw is not within -1e6..1e6 degrees";
  if (!error.ok()) {
    complain(error.text() + "; a line is X Y Z YAW PITCH", now);
    return false;
  }
  place = taken;
  ++poses_;
  return true;
}

void PoseLines::complain(const std::string& error, std::int64_t now) {
  ++malformed_;
  if (now - second_began_ >= kSecond) {
    second_began_ = now;
    reports_this_second_ = 0;
    if (unreported_ > 0 && report_) {
      report_(what_ + ": " + std::to_string(unreported_) + " more lines were ignored");
    }
    unreported_ = 0;
  }
  if (reports_this_second_ == kReportsASecond) {
    ++unreported_;
    return;
  }
  ++reports_this_second_;
  if (report_) report_(error);
}

PoseStream::~PoseStream() {
  if (fd_ > 2) close(fd_);
}

Error PoseStream::open(const std::string& source, PoseLines::Report report) {
  if (source == "-") {
    lines_ = PoseLines("standard input", std::move(report));
    // A copy, so that not waiting on it stays our own affair as far as the system allows.
    fd_ = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
    if (fd_ < 0) return errno_text("--poses: standard input", errno);
    fcntl(fd_, F_SETFL, fcntl(fd_, F_GETFL) | O_NONBLOCK);
    return {};
  }
  Address address;
  if (Error error = parse_udp(source, address); !error.ok()) return error;
  lines_ = PoseLines(source, std::move(report));
  datagrams_ = true;
  fd_ = socket(address.storage.ss_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd_ < 0 || bind(fd_, reinterpret_cast<const sockaddr*>(&address.storage), address.length) != 0) {
    return errno_text("--poses " + source, errno);
  }
  return {};
}

bool PoseStream::dispatch(CameraPlace& place) {
  static thread_local std::array<char, kLongestDatagram> buffer;
  bool any = false;
  for (int i = 0; fd_ >= 0 && i < kReadsADispatch; ++i) {
    const ssize_t got = read(fd_, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
    if (got > 0) any |= lines_.feed({buffer.data(), static_cast<std::size_t>(got)}, now_ns(), place);
    if (datagrams_ || got <= 0) any |= lines_.end(now_ns(), place);
    if (got < 0 && datagrams_) break;
    if (got <= 0 && !datagrams_) {  // the other program has ended: its last pose stays
      close(fd_);
      fd_ = -1;
    }
  }
  return any;
}

}  // namespace karst::app
