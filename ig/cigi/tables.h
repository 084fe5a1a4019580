// SPDX-License-Identifier: MIT
// Where the fields of packets lie in bytes: a row a field, for 3.x and 4.0; and what reads and writes by
// rows.
#pragma once

#include "ig/cigi/packets.h"

#include <span>

namespace karst::cigi {

enum class Kind : std::uint8_t { u8, s8, u16, u32, f32, f64, bits8, bits16 };

// No place in a version's packet.
constexpr std::uint8_t kAbsent = 0xff;
// No member.
constexpr std::uint16_t kNoMember = 0xffff;
// The columns of the tables.
enum Column : std::uint8_t { kColumn3, kColumn4 };

struct Place {
  std::uint8_t at = kAbsent;  // byte of the packet
  std::uint8_t shift = 0;     // of bits: the lowest
};

struct Field {
  std::uint16_t member = 0;  // offset in the struct; of bits a bool, an enumeration or an 8-bit number
  Kind kind = Kind::u8;
  std::uint8_t width = 8;              // of bits
  std::uint8_t most = 0xff;            // of bits and u8: what is above is malformed
  std::array<Place, 2> places{};       // by Column
  std::uint16_t valid_by = kNoMember;  // a bool in a row before this one; where it is false the field is 0
};

struct Layout {
  std::size_t alternative = 0;  // of Packet
  Speaker speaker = Speaker::host;
  std::array<std::uint16_t, 2> ids{};
  std::array<std::uint8_t, 2> sizes{};  // bytes; 0: the version has no such packet
  std::span<const Field> fields;
  std::uint16_t sets = kNoMember;  // a bool that this packet makes true
};

// All packets that karst reads and writes.
std::span<const Layout> layouts();

// Of IgControl and StartOfFrame, bytes of the packet where the version stands: the minor one in the upper
// four bits. In 3.x kSwapAt has the number kSwapMark.
struct Head {
  std::array<std::uint8_t, 2> major_at{};
  std::array<std::uint8_t, 2> minor_at{};
};
constexpr Head kIgControlHead{{2, 4}, {4, 7}};
constexpr Head kStartOfFrameHead{{2, 4}, {5, 7}};
constexpr std::size_t kHeadBytes = 24;
constexpr std::size_t kSwapAt = 6;
constexpr std::uint16_t kSwapMark = 0x8000;

constexpr std::size_t header_bytes(Column column) {
  return column == kColumn3 ? 2 : 4;
}
constexpr Column column_of(Version version) {
  return version.major >= 4 ? kColumn4 : kColumn3;
}
constexpr bool is_spoken(Version version) {
  return (version.major == 3 && (version.minor == 2 || version.minor == 3)) ||
         (version.major == 4 && version.minor == 0);
}

// at must have n bytes; n is 1, 2, 4 or 8.
std::uint64_t load(const std::byte* at, std::size_t n, Order order);
void store(std::byte* at, std::size_t n, Order order, std::uint64_t value);

// bytes: layout.sizes[column] of them. False: malformed, and the packet is anything.
bool decode(const Layout& layout, Column column, Order order, const std::byte* bytes, Packet& packet);
// layout.alternative must be the packet's. What no field is in is 0.
void encode(const Layout& layout, Column column, Order order, const Packet& packet, std::byte* bytes);

}  // namespace karst::cigi
