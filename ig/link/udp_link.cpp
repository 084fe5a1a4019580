// SPDX-License-Identifier: MIT
#include "ig/link/udp_link.h"

#include <arpa/inet.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "app/common/arguments.h"
#include "platform/base/clock.h"
#include "platform/base/log.h"
#include "platform/base/text.h"

namespace karst::ig {
namespace {

constexpr std::size_t kLongestDatagram = 65'536;
constexpr int kReceiveBytes = 4 << 20;  // that the system keeps, where it allows as many

std::int64_t real_now_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

Error parse_address(std::string_view text, std::string_view what, UdpAddress& address) {
  const std::string name(what);
  address = {};
  const std::size_t colon = text.rfind(':');
  std::string host = colon == std::string_view::npos ? "127.0.0.1" : std::string(text.substr(0, colon));
  std::int64_t port = 0;
  const std::string_view port_text = colon == std::string_view::npos ? text : text.substr(colon + 1);
  if (Error error = app::parse_integer(port_text, name + ": the port", 1, 65'535, port); !error.ok())
    return error;
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    sockaddr_in6 ipv6{};
    ipv6.sin6_family = AF_INET6;
    ipv6.sin6_port = htons(static_cast<std::uint16_t>(port));
    if (inet_pton(AF_INET6, host.substr(1, host.size() - 2).c_str(), &ipv6.sin6_addr) != 1)
      return name + ": " + quote(host) + " is not an IPv6 address";
    std::memcpy(&address.storage, &ipv6, sizeof ipv6);
    address.length = sizeof ipv6;
    return {};
  }
  sockaddr_in ipv4{};
  ipv4.sin_family = AF_INET;
  ipv4.sin_port = htons(static_cast<std::uint16_t>(port));
  if (inet_pton(AF_INET, host.c_str(), &ipv4.sin_addr) != 1)
    return name + ": " + quote(host) + " is not an IPv4 address, nor [IPv6]";
  std::memcpy(&address.storage, &ipv4, sizeof ipv4);
  address.length = sizeof ipv4;
  return {};
}

bool is_loopback(const UdpAddress& address) {
  if (address.storage.ss_family == AF_INET6) {
    sockaddr_in6 ipv6{};
    std::memcpy(&ipv6, &address.storage, sizeof ipv6);
    return IN6_IS_ADDR_LOOPBACK(&ipv6.sin6_addr) != 0;
  }
  sockaddr_in ipv4{};
  std::memcpy(&ipv4, &address.storage, sizeof ipv4);
  return (ntohl(ipv4.sin_addr.s_addr) >> 24) == 127;
}

UdpLink::~UdpLink() {
  if (fd_ >= 0) close(fd_);
}

Error UdpLink::open(const UdpAddress& listen, const UdpAddress& host) {
  if (listen.storage.ss_family != host.storage.ss_family)
    return "--listen and --host: one is an IPv4 and the other an IPv6 address";
  host_ = host;
  buffer_.resize(kLongestDatagram);
  fd_ = socket(listen.storage.ss_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd_ < 0) return errno_text("--listen", errno);
  const int on = 1;
  setsockopt(fd_, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &kReceiveBytes, sizeof kReceiveBytes);
  setsockopt(fd_, SOL_SOCKET, SO_SNDBUF, &kReceiveBytes, sizeof kReceiveBytes);
  if (bind(fd_, reinterpret_cast<const sockaddr*>(&listen.storage), listen.length) != 0)
    return errno_text("--listen", errno);
  return {};
}

// By its address alone: hosts send from any port.
bool UdpLink::is_host(const sockaddr_storage& from) const {
  if (from.ss_family != host_.storage.ss_family) return false;
  if (from.ss_family == AF_INET6) {
    sockaddr_in6 one{}, other{};
    std::memcpy(&one, &from, sizeof one);
    std::memcpy(&other, &host_.storage, sizeof other);
    return std::memcmp(&one.sin6_addr, &other.sin6_addr, sizeof one.sin6_addr) == 0;
  }
  sockaddr_in one{}, other{};
  std::memcpy(&one, &from, sizeof one);
  std::memcpy(&other, &host_.storage, sizeof other);
  return one.sin_addr.s_addr == other.sin_addr.s_addr;
}

void UdpLink::read(const Take& take) {
  const std::int64_t began = now_ns();
  const std::int64_t real_less_own = real_now_ns() - began;
  for (std::size_t bytes = 0; bytes < kReadBytes;) {
    sockaddr_storage from{};
    alignas(cmsghdr) char control[CMSG_SPACE(sizeof(timespec))];
    iovec piece{buffer_.data(), buffer_.size()};
    msghdr message{};
    message.msg_name = &from;
    message.msg_namelen = sizeof from;
    message.msg_iov = &piece;
    message.msg_iovlen = 1;
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    const ssize_t got = recvmsg(fd_, &message, 0);
    // A host that is not there yet is told of here, too (ECONNREFUSED).
    if (got < 0 && (errno == EINTR || errno == ECONNREFUSED)) {
      bytes += 64;
      continue;
    }
    if (got < 0) return;
    std::int64_t arrived = now_ns();
    for (cmsghdr* head = CMSG_FIRSTHDR(&message); head != nullptr; head = CMSG_NXTHDR(&message, head)) {
      if (head->cmsg_level != SOL_SOCKET || head->cmsg_type != SCM_TIMESTAMPNS) continue;
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(head), sizeof stamp);
      arrived = std::int64_t{stamp.tv_sec} * 1'000'000'000 + stamp.tv_nsec - real_less_own;
    }
    bytes += static_cast<std::size_t>(got) + 64;  // empty ones cost something, too
    if (is_host(from)) {
      ++counts_.datagrams;
      take(std::span(buffer_).first(static_cast<std::size_t>(got)), arrived);
    } else {
      ++counts_.foreign;
    }
    if (now_ns() - began > kRead_ns) return;
  }
}

bool UdpLink::send(std::span<const std::byte> datagram) {
  const ssize_t put = sendto(fd_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                             reinterpret_cast<const sockaddr*>(&host_.storage), host_.length);
  // An earlier datagram found nobody; this one may.
  const bool refused = put < 0 && errno == ECONNREFUSED;
  reason_ = put < 0 ? errno : 0;
  ++(put < 0 ? counts_.unsent : counts_.sent);
  return put >= 0 || refused;
}

}  // namespace karst::ig
