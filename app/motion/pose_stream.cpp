// SPDX-License-Identifier: MIT
#include "app/motion/pose_stream.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "app/common/arguments.h"
#include "platform/base/clock.h"
#include "platform/base/log.h"
#include "platform/base/text.h"

namespace karst::app {
namespace {

constexpr std::size_t kLongestDatagram = 65'536;
// So that a flood cannot keep frames from being drawn nor signals from being answered: what one dispatch
// takes at most. One datagram is always taken, and a piece of lines costs less than the time says.
constexpr std::int64_t kDispatch_ns = 2'000'000;
constexpr std::size_t kDispatchBytes = 1 << 20;
constexpr std::size_t kPiece = 4096;  // bytes of lines read at once

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
  return "--poses: " + quote(text) + " is not -, udp:PORT or udp:ADDRESS:PORT";
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
  ++malformed_;
  if (messages_ != nullptr && messages_->may_say(now, Messages::About::others)) {
    messages_->print(what_ + ": a line is longer than " + std::to_string(kLongestPoseLine) + " characters");
  }
  return false;
}

bool PoseLines::datagram(std::string_view bytes, std::int64_t now, CameraPlace& place) {
  const std::size_t last = bytes.find_last_not_of(" \t\r\n");
  if (last == std::string_view::npos) return false;
  bytes = bytes.substr(0, last + 1);
  const std::size_t before = bytes.rfind('\n');
  if (before != std::string_view::npos) bytes.remove_prefix(before + 1);
  length_ = std::min(bytes.size(), line_.size());
  too_long_ = bytes.size() > line_.size();
  std::copy_n(bytes.begin(), length_, line_.begin());
  return end(now, place);
}

bool PoseLines::take_line(std::string_view line, std::int64_t now, CameraPlace& place) {
  line = line.substr(0, line.find('#'));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  if (line.find_first_not_of(" \t") == std::string_view::npos) return false;
  CameraPlace taken;
  if (!read_camera_line(line, taken) || std::fabs(taken.pitch_deg) > 90 || std::fabs(taken.yaw_deg) > 1e6) {
    complain(line, now);
    return false;
  }
  place = taken;
  ++poses_;
  return true;
}

// Words are put together for what is printed alone: a flood is mostly not.
void PoseLines::complain(std::string_view line, std::int64_t now) {
  ++malformed_;
  if (messages_ == nullptr || !messages_->may_say(now, Messages::About::others)) return;
  CameraPlace ignored;
  Error error = parse_camera_line(line, what_, ignored);
  if (error.ok()) {
    error = what_ + (std::fabs(ignored.pitch_deg) > 90 ? ": the pitch is not within -90..90 degrees"
                                                       : ": the yaw is not within -1e6..1e6 degrees");
  }
  messages_->print(error.text() + "; a line is X Y Z YAW PITCH");
}

PoseStream::~PoseStream() {
  if (fd_ > 2) close(fd_);
}

Error PoseStream::open(const std::string& source, Messages& messages) {
  if (source == "-") {
    lines_ = PoseLines("standard input", &messages);
    // Opened anew where that can be done (pipes, terminals): not waiting is a flag of what is open, and that
    // of a shell's terminal must not change, whatever ends this program.
    struct stat status {};
    if (fstat(STDIN_FILENO, &status) != 0) return errno_text("--poses: standard input", errno);
    if (S_ISFIFO(status.st_mode) || S_ISCHR(status.st_mode)) {
      fd_ = ::open("/proc/self/fd/0", O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    }
    if (fd_ < 0) fd_ = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
    if (fd_ < 0) return errno_text("--poses: standard input", errno);
    return {};
  }
  Address address;
  if (Error error = parse_udp(source, address); !error.ok()) return error;
  lines_ = PoseLines(source, &messages);
  datagrams_ = true;
  fd_ = socket(address.storage.ss_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd_ < 0 || bind(fd_, reinterpret_cast<const sockaddr*>(&address.storage), address.length) != 0) {
    return errno_text("--poses " + source, errno);
  }
  return {};
}

std::ptrdiff_t PoseStream::read_some(char* out, std::size_t room) const {
  pollfd ready{fd_, POLLIN, 0};
  for (;;) {
    // Asked first: standard input that could not be opened anew would wait.
    if (poll(&ready, 1, 0) <= 0) return -1;
    const ssize_t got = read(fd_, out, room);
    if (got >= 0) return got;
    if (errno == EINTR) continue;
    return errno == EAGAIN || errno == EWOULDBLOCK || datagrams_ ? -1 : 0;
  }
}

bool PoseStream::dispatch(CameraPlace& place) {
  static thread_local std::array<char, kLongestDatagram> buffer;
  bool any = false;
  const std::int64_t began = now_ns();
  std::int64_t now = began;
  for (std::size_t bytes = 0; fd_ >= 0 && bytes < kDispatchBytes && now - began < kDispatch_ns;
       now = now_ns()) {
    const std::ptrdiff_t got = read_some(buffer.data(), datagrams_ ? buffer.size() : kPiece);
    if (got < 0) break;
    const std::string_view piece(buffer.data(), static_cast<std::size_t>(got));
    bytes += piece.size();
    if (datagrams_) {
      any |= lines_.datagram(piece, now, place);
    } else if (got > 0) {
      any |= lines_.feed(piece, now, place);
    } else {  // the other program has ended: its last pose stays
      any |= lines_.end(now, place);
      close(fd_);
      fd_ = -1;
    }
  }
  return any;
}

}  // namespace karst::app
