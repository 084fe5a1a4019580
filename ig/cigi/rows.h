// SPDX-License-Identifier: MIT
// How rows of the tables are written: row(OFFSET OF THE MEMBER, byte in 3.x, byte in 4.0).
#pragma once

#include "ig/cigi/tables.h"

namespace karst::cigi::rows {

constexpr std::uint8_t kNo = kAbsent;

constexpr Field number(Kind kind, std::size_t member, std::uint8_t at3, std::uint8_t at4,
                       std::size_t valid_by = kNoMember) {
  Field field;
  field.member = static_cast<std::uint16_t>(member);
  field.kind = kind;
  field.places = {Place{at3, 0}, Place{at4, 0}};
  field.valid_by = static_cast<std::uint16_t>(valid_by);
  return field;
}
constexpr Field u8(std::size_t member, std::uint8_t at3, std::uint8_t at4) {
  return number(Kind::u8, member, at3, at4);
}
constexpr Field u8_to(std::uint8_t most, std::size_t member, std::uint8_t at3, std::uint8_t at4,
                      std::size_t valid_by) {
  Field field = number(Kind::u8, member, at3, at4, valid_by);
  field.most = most;
  return field;
}
constexpr Field s8(std::size_t member, std::uint8_t at3, std::uint8_t at4) {
  return number(Kind::s8, member, at3, at4);
}
constexpr Field u16(std::size_t member, std::uint8_t at3, std::uint8_t at4) {
  return number(Kind::u16, member, at3, at4);
}
constexpr Field u32(std::size_t member, std::uint8_t at3, std::uint8_t at4,
                    std::size_t valid_by = kNoMember) {
  return number(Kind::u32, member, at3, at4, valid_by);
}
constexpr Field f32(std::size_t member, std::uint8_t at3, std::uint8_t at4,
                    std::size_t valid_by = kNoMember) {
  return number(Kind::f32, member, at3, at4, valid_by);
}
constexpr Field f64(std::size_t member, std::uint8_t at3, std::uint8_t at4,
                    std::size_t valid_by = kNoMember) {
  return number(Kind::f64, member, at3, at4, valid_by);
}
// width bits, the lowest of them shift bits above the byte's lowest.
constexpr Field bits(std::uint8_t width, std::uint8_t most, std::size_t member, Place in3, Place in4) {
  Field field;
  field.member = static_cast<std::uint16_t>(member);
  field.kind = Kind::bits8;
  field.width = width;
  field.most = most;
  field.places = {in3, in4};
  return field;
}
constexpr Field bit(std::size_t member, Place in3, Place in4) {
  return bits(1, 1, member, in3, in4);
}
// A bit of a 16-bit number.
constexpr Field bit_of_16(std::size_t member, Place in3, Place in4) {
  Field field = bits(1, 1, member, in3, in4);
  field.kind = Kind::bits16;
  return field;
}

}  // namespace karst::cigi::rows
