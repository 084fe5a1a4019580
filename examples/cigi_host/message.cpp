// SPDX-License-Identifier: MIT
#include "message.h"

#include <cstring>

namespace {

// 2 ^ 15: says by its order of bytes what that of all other numbers is.
constexpr unsigned kSwapMark = 0x8000;
constexpr float kAllAlpha = 255;

template <class Number>
Number read(Dialect dialect, const std::uint8_t* at) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < sizeof(Number); ++i) {
    bits = bits << 8 | at[dialect.big ? i : sizeof(Number) - 1 - i];
  }
  Number value = 0;
  if constexpr (sizeof(Number) == 8) {
    std::memcpy(&value, &bits, 8);
  } else {
    value = static_cast<Number>(bits);
  }
  return value;
}

}  // namespace

void Message::begin(unsigned id3, unsigned size3, unsigned id4, unsigned size4) {
  if (old()) {
    u8(id3);
    u8(size3);
  } else {
    u16(size4);
    u16(id4);
  }
}

void Message::number(std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) {
    const int byte = dialect_.big ? size - 1 - i : i;
    bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * byte)));
  }
}

void Message::f32(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  u32(bits);
}

void Message::f64(double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  number(bits, 8);
}

void Message::place(const Place& place) {
  f64(place.latitude_deg);
  f64(place.longitude_deg);
  f64(place.altitude_m);
}

void Message::ig_control(std::uint32_t frame, std::uint32_t timestamp_10us, std::uint32_t last_ig_frame) {
  constexpr unsigned kOperate = 1, kTimestampValid = 4;
  begin(1, 24, 0x0000, 24);
  u8(static_cast<unsigned>(dialect_.major));
  u8(0);  // the database that is loaded
  if (old()) {
    u8(3u << 4 | kTimestampValid | kOperate);  // 3: the minor version
    u8(0);
    u16(kSwapMark);
    u32(frame);
    u32(timestamp_10us);
    u32(last_ig_frame);
  } else {
    u8(0);
    u8(0u << 4 | kTimestampValid | kOperate);
    u32(frame);
    u32(last_ig_frame);
    u32(timestamp_10us);
  }
  u32(0);
}

void Message::entity(std::uint16_t id, const Place& where, float yaw_deg, float pitch_deg, float roll_deg) {
  constexpr unsigned kActive = 1;
  const auto alpha = static_cast<unsigned>(kAllAlpha);
  if (old()) {
    begin(2, 48, 0, 0);
    u16(id);
    u8(kActive);
    u8(0);
    u8(alpha);
    u8(0);
    u16(0);  // type
    u16(0);  // parent
  } else {
    begin(0, 0, 0x0025, 16);
    u8(kActive);
    u8(alpha);
    u16(id);
    u8(0);   // kind
    u8(0);   // domain
    u16(0);  // type
    u32(0);
    begin(0, 0, 0x0001, 48);
    u8(0);
    u8(0);
    u16(id);
    u16(0);  // parent
    u16(0);
  }
  f32(roll_deg);
  f32(pitch_deg);
  f32(yaw_deg);
  place(where);
}

void Message::view_definition(std::uint16_t view, float near_m, float far_m, float half_width_deg,
                              float half_height_deg) {
  constexpr unsigned kAllSixValid = 0x3f;
  begin(21, 32, 0x0014, 40);
  u16(view);
  u8(0);  // group
  u8(kAllSixValid);
  u8(0);
  u8(0);
  if (!old()) u16(0);
  f32(near_m);
  f32(far_m);
  f32(-half_width_deg);
  f32(half_width_deg);
  f32(half_height_deg);
  f32(-half_height_deg);
  if (!old()) u32(0);
}

void Message::view_on_entity(std::uint16_t view, std::uint16_t entity, float pitch_deg) {
  constexpr unsigned kAllSixValid = 0x3f;
  begin(16, 32, 0x000f, 40);
  if (old()) u16(view);
  u8(0);  // group
  u8(kAllSixValid);
  if (!old()) u16(view);
  u16(entity);
  if (!old()) u16(0);
  f32(0);
  f32(0);
  f32(0);
  f32(0);
  f32(pitch_deg);
  f32(0);
  if (!old()) u32(0);
}

void Message::celestial_sphere(unsigned hour, unsigned minute, std::uint32_t date_mmddyyyy) {
  constexpr unsigned kSun = 2, kDateTimeValid = 16;
  begin(9, 16, 0x0008, 24);
  if (old()) {
    u8(hour);
    u8(minute);
    u8(kSun | kDateTimeValid);
    u8(0);
    u16(0);
  } else {
    u8(kSun | kDateTimeValid);
    u8(0);
    u8(hour);
    u8(minute);
    f32(0);  // second
  }
  u32(date_mmddyyyy);
  f32(0);  // of stars
  if (!old()) u32(0);
}

void Message::visibility(float visibility_m) {
  begin(10, 32, 0x0009, 32);
  if (old()) {
    u8(0);
    u8(30);  // per cent of humidity
  } else {
    u8(30);
    u8(0);
    u16(0);
  }
  f32(15);  // degrees Celsius
  f32(visibility_m);
  f32(0);
  f32(0);
  f32(0);
  f32(1013.25f);
  if (old()) u32(0);
}

void Message::hat_hot_extended(std::uint16_t id, const Place& where, unsigned period) {
  constexpr unsigned kExtended = 2;
  begin(24, 32, 0x0017, 40);
  u16(id);
  if (old()) {
    u8(kExtended);
    u8(period);
    u16(0);  // entity
  } else {
    u16(0);
    u8(kExtended);
    u8(period);
    u16(0);
    u32(0);
  }
  place(where);
}

void Message::los_vector(std::uint16_t id, std::uint16_t entity, float azimuth_deg, float elevation_deg,
                         float range_m, unsigned period) {
  constexpr unsigned kExtended = 1, kSourceIsOffset = 2;
  begin(26, 56, 0x0019, 64);
  u16(id);
  if (old()) {
    u8(kExtended | kSourceIsOffset);
    u8(0);  // alpha threshold
    u16(entity);
  } else {
    u16(entity);
    u8(kExtended | kSourceIsOffset);
    u8(0);
    u8(period);
    u8(0);
    u32(0);
  }
  f32(azimuth_deg);
  f32(elevation_deg);
  f32(0);
  f32(range_m);
  place({});
  u32(0xffffffff);  // all materials
  if (old()) u8(period), u8(0), u16(0);
  if (!old()) u32(0);
}

void Message::los_segment(std::uint16_t id, const Place& from, const Place& to, unsigned period) {
  constexpr unsigned kExtended = 1;
  begin(25, 64, 0x0018, 72);
  u16(id);
  if (old()) {
    u8(kExtended);
    u8(0);
    u16(0);
  } else {
    u16(0);
    u8(kExtended);
    u8(0);
    u16(0);  // entity of the destination
    u8(period);
    u8(0);
    u16(0);
  }
  place(from);
  place(to);
  u32(0xffffffff);
  if (old()) {
    u8(period);
    u8(0);
    u16(0);
  } else {
    u32(0);
  }
}

bool read_answers(Dialect dialect, const std::uint8_t* bytes, std::size_t size,
                  std::vector<Answer>& answers) {
  const bool old = dialect.major == 3;
  const std::size_t header = old ? 2 : 4;
  // The first packet must be Start of Frame of the same version and order.
  if (size < 24 || bytes[old ? 2 : 4] != dialect.major) return false;
  if (old && (bytes[0] != 101 || read<std::uint16_t>(dialect, bytes + 6) != kSwapMark)) return false;
  if (!old &&
      (read<std::uint16_t>(dialect, bytes) != 24 || read<std::uint16_t>(dialect, bytes + 2) != 0xffff)) {
    return false;
  }
  for (std::size_t at = 0; size - at >= header;) {
    const std::uint8_t* packet = bytes + at;
    const unsigned length = old ? packet[1] : read<std::uint16_t>(dialect, packet);
    const unsigned id = old ? packet[0] : read<std::uint16_t>(dialect, packet + 2);
    if (length < 8 || length > size - at) break;
    at += length;
    Answer answer;
    if (id == (old ? 101u : 0xffffu) && length == 24) {
      answer.what = Answer::What::start_of_frame;
      answer.database = static_cast<std::int8_t>(packet[old ? 3 : 5]);
      answer.mode = packet[old ? 5 : 7] & 3;
      answer.ig_frame = read<std::uint32_t>(dialect, packet + 8);
      answer.last_host_frame = read<std::uint32_t>(dialect, packet + 16);
    } else if (id == (old ? 103u : 0x0ffeu) && length == 40) {  // HAT/HOT Extended Response
      answer.what = Answer::What::hat_hot;
      answer.id = read<std::uint16_t>(dialect, packet + (old ? 2 : 6));
      answer.valid = (packet[4] & 1) != 0;
      answer.hat_m = read<double>(dialect, packet + 8);
      answer.hot_m = read<double>(dialect, packet + 16);
    } else if (id == (old ? 105u : 0x0ffcu) && length == (old ? 56u : 64u)) {  // LOS Extended Response
      const std::uint8_t flags = packet[old ? 4 : 8];
      const std::uint8_t* numbers = packet + (old ? 8 : 16);
      answer.what = Answer::What::los;
      answer.id = read<std::uint16_t>(dialect, packet + (old ? 2 : 4));
      answer.valid = (flags & 1) != 0;
      answer.visible = (flags & 8) != 0;
      answer.range_m = read<double>(dialect, numbers);
      answer.place = {read<double>(dialect, numbers + 8), read<double>(dialect, numbers + 16),
                      read<double>(dialect, numbers + 24)};
    } else {
      continue;
    }
    answers.push_back(answer);
  }
  return true;
}
