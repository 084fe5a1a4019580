// SPDX-License-Identifier: MIT
// Datagrams between an IG and its host. Nothing waits, and nothing is allocated after open().
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/base/error.h"

namespace karst::ig {

struct UdpAddress {
  sockaddr_storage storage{};
  socklen_t length = 0;
};

// "PORT", which is on this machine, "ADDRESS:PORT" or "[IPV6]:PORT". what: how messages name it.
Error parse_address(std::string_view text, std::string_view what, UdpAddress& address);
bool is_loopback(const UdpAddress& address);

class UdpLink {
 public:
  // What one read() takes at most, so that no flood keeps frames from being drawn; one datagram it always
  // takes.
  static constexpr std::int64_t kRead_ns = 2'000'000;
  static constexpr std::size_t kReadBytes = 1 << 20;

  UdpLink() = default;
  UdpLink(const UdpLink&) = delete;
  UdpLink& operator=(const UdpLink&) = delete;
  ~UdpLink();

  Error open(const UdpAddress& listen, const UdpAddress& host);
  int fd() const { return fd_; }

  struct Counts {
    std::uint64_t datagrams = 0;  // of the host's address
    std::uint64_t foreign = 0;    // of others, which are not looked at
    std::uint64_t sent = 0;
    std::uint64_t unsent = 0;  // the system would not take them
  };
  // arrived_ns: when the system got it, on the clock of now_ns(); the bytes are valid during the call.
  using Take = std::function<void(std::span<const std::byte> datagram, std::int64_t arrived_ns)>;
  void read(const Take& take);
  // To the host. False: it was not taken; reason() says why.
  bool send(std::span<const std::byte> datagram);
  int reason() const { return reason_; }  // an errno
  const Counts& counts() const { return counts_; }

 private:
  bool is_host(const sockaddr_storage& from) const;

  int fd_ = -1;
  int reason_ = 0;
  UdpAddress host_;
  Counts counts_;
  std::vector<std::byte> buffer_;
};

}  // namespace karst::ig
