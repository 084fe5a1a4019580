// SPDX-License-Identifier: MIT
// A CIGI message, packet by packet, in memory of the caller.
//
//   MessageWriter writer(buffer, {3, 3}, Order::little);
//   writer.write(StartOfFrame{...}) && writer.write(HatHotResponse{...});
//   send(writer.bytes());
//   writer.clear();
//
// Nothing is allocated; no exceptions.
#pragma once

#include "ig/cigi/packets.h"

#include <span>

namespace karst::cigi {

// The most that a UDP datagram over IPv4 carries, in bytes.
constexpr std::size_t kMaxMessageBytes = 65'507;
// The most that a packet of this folder has, in bytes of any version.
constexpr std::size_t kMaxPacketBytes = 72;

class MessageWriter {
 public:
  // buffer: borrowed, and stays as long as the writer. version: 3.2, 3.3 or 4.0.
  MessageWriter(std::span<std::byte> buffer, Version version, Order order)
      : buffer_(buffer), version_(version), order_(order) {}

  // Appends a packet. False, and nothing was written: there is no room for it; the message does not begin
  // with IgControl or StartOfFrame; or it is EntityControl or EntityPosition in 3.x (write_entity). Bits that
  // a field does not have are cut off.
  [[nodiscard]] bool write(const Packet& packet);
  // Both, of one entity: one packet in 3.x, two in 4.0.
  [[nodiscard]] bool write_entity(const EntityControl& control, const EntityPosition& position);

  // The message so far: whole packets.
  std::span<const std::byte> bytes() const { return buffer_.first(size_); }
  void clear() { size_ = 0; }
  // What is free of the buffer.
  std::size_t room() const { return buffer_.size() - size_; }

 private:
  std::span<std::byte> buffer_;
  std::size_t size_ = 0;
  Version version_;
  Order order_;
};

}  // namespace karst::cigi
