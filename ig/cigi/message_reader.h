// SPDX-License-Identifier: MIT
// Packets of a CIGI message, which is a datagram: its first packet says the version and the order of bytes.
//
//   MessageReader reader;
//   if (reader.open(datagram, Speaker::host)) {
//     while (reader.next(packet)) ...  // stop anywhere: the rest is dropped
//   }
//
// Bytes may be anything: no read leaves them, and a message of n bytes makes at most n / 8 + n / 48 packets
// in time that grows with n. Nothing is allocated; no exceptions.
#pragma once

#include "ig/cigi/packets.h"

#include <span>

namespace karst::cigi {

// Of all messages since the reader was made.
struct ReadCounts {
  std::uint64_t messages = 0;  // opened
  std::uint64_t packets = 0;  // of messages, that next() gave (one of Entity Control of 3.3, which gives two)
  std::uint64_t unknown = 0;  // skipped: packets that karst does not read
  std::uint64_t malformed = 0;  // skipped: a size that is not the packet's, a number that is not finite, a
                                // value that its field does not have, another version inside a message
  std::uint64_t cut = 0;       // messages whose rest was dropped: a size that ends outside of them or is none
  std::uint64_t rejected = 0;  // messages that do not begin as they must, or of a version that is not read
  std::uint64_t bytes = 0;     // of all messages, rejected ones too
  bool operator==(const ReadCounts&) const = default;
};

class MessageReader {
 public:
  // Begins with a message; it stays valid until next() was false. False: it is rejected; version() says what
  // it claims to be where major is not 0.
  [[nodiscard]] bool open(std::span<const std::byte> message, Speaker speaker);
  // The next packet that karst reads; false: there are no more.
  [[nodiscard]] bool next(Packet& packet);

  // Of the message that open() was last given.
  Version version() const { return version_; }
  Order order() const { return order_; }
  const ReadCounts& counts() const { return counts_; }

 private:
  std::span<const std::byte> rest_;
  std::span<const std::byte> second_;  // Entity Control of 3.3 whose position is to come
  Speaker speaker_ = Speaker::host;
  Version version_{0, 0};
  Order order_ = Order::little;
  ReadCounts counts_;
};

}  // namespace karst::cigi
