// SPDX-License-Identifier: MIT
#include "ig/cigi/tables.h"

#include "ig/cigi/rows.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

namespace karst::cigi {
namespace {

using namespace rows;

// clang-format off: a row a line.
constexpr Field kIgControl[] = {
    s8(offsetof(IgControl, database), 3, 5),
    bits(2, 2, offsetof(IgControl, mode), {4, 0}, {7, 0}),
    bit(offsetof(IgControl, timestamp_valid), {4, 2}, {7, 2}),
    bit(offsetof(IgControl, smoothing), {4, 3}, {7, 3}),
    bit(offsetof(IgControl, entity_type_substitution), {kNo, 0}, {6, 0}),
    u32(offsetof(IgControl, host_frame), 8, 8),
    u32(offsetof(IgControl, timestamp_10us), 12, 16),
    u32(offsetof(IgControl, last_ig_frame), 16, 12),
};
constexpr Field kEntityControl[] = {
    u16(offsetof(EntityControl, entity), 2, 6),
    bits(2, 2, offsetof(EntityControl, state), {4, 0}, {4, 0}),
    bit(offsetof(EntityControl, collision_detection), {4, 3}, {4, 2}),
    bit(offsetof(EntityControl, inherit_alpha), {4, 4}, {4, 3}),
    bit(offsetof(EntityControl, smoothing), {5, 4}, {4, 4}),
    u8(offsetof(EntityControl, alpha), 6, 5),
    u16(offsetof(EntityControl, type), 8, 10),
    bit(offsetof(EntityControl, extended_type), {kNo, 0}, {4, 5}),
    u8(offsetof(EntityControl, kind), kNo, 8),
    u8(offsetof(EntityControl, domain), kNo, 9),
    u8(offsetof(EntityControl, category), kNo, 12),
    u8(offsetof(EntityControl, subcategory), kNo, 13),
    u8(offsetof(EntityControl, specific), kNo, 14),
    u8(offsetof(EntityControl, extra), kNo, 15),
    bit(offsetof(EntityControl, animation_backward), {5, 0}, {kNo, 0}),
    bit(offsetof(EntityControl, animation_loop), {5, 1}, {kNo, 0}),
    bits(2, 3, offsetof(EntityControl, animation), {5, 2}, {kNo, 0}),
};
constexpr Field kEntityPosition[] = {
    u16(offsetof(EntityPosition, entity), 2, 6),
    bit(offsetof(EntityPosition, attached), {4, 2}, {4, 0}),
    bits(2, 2, offsetof(EntityPosition, clamp), {4, 5}, {4, 1}),
    u16(offsetof(EntityPosition, parent), 10, 8),
    f32(offsetof(EntityPosition, roll_deg), 12, 12),
    f32(offsetof(EntityPosition, pitch_deg), 16, 16),
    f32(offsetof(EntityPosition, yaw_deg), 20, 20),
    f64(offsetof(EntityPosition, latitude_deg_or_x_m), 24, 24),
    f64(offsetof(EntityPosition, longitude_deg_or_y_m), 32, 32),
    f64(offsetof(EntityPosition, altitude_m_or_z_m), 40, 40),
};
constexpr Field kRateControl[] = {
    u16(offsetof(RateControl, entity), 2, 4),
    u8(offsetof(RateControl, part), 4, 6),
    bit(offsetof(RateControl, of_part), {5, 0}, {7, 0}),
    bit(offsetof(RateControl, local), {5, 1}, {7, 1}),
    f32(offsetof(RateControl, x_m_s), 8, 8),
    f32(offsetof(RateControl, y_m_s), 12, 12),
    f32(offsetof(RateControl, z_m_s), 16, 16),
    f32(offsetof(RateControl, roll_deg_s), 20, 20),
    f32(offsetof(RateControl, pitch_deg_s), 24, 24),
    f32(offsetof(RateControl, yaw_deg_s), 28, 28),
};
constexpr Field kComponentControl[] = {
    u16(offsetof(ComponentControl, component), 2, 4),
    u16(offsetof(ComponentControl, instance), 4, 8),
    bits(6, 63, offsetof(ComponentControl, component_class), {6, 0}, {6, 0}),
    u8(offsetof(ComponentControl, state), 7, 7),
    u32(offsetof(ComponentControl, words), 8, 16),
    u32(offsetof(ComponentControl, words) + 4, 12, 20),
    u32(offsetof(ComponentControl, words) + 8, 16, 24),
    u32(offsetof(ComponentControl, words) + 12, 20, 28),
    u32(offsetof(ComponentControl, words) + 16, 24, 32),
    u32(offsetof(ComponentControl, words) + 20, 28, 36),
};
constexpr Field kCelestialSphereControl[] = {
    bit(offsetof(CelestialSphereControl, ephemeris), {4, 0}, {4, 0}),
    bit(offsetof(CelestialSphereControl, sun), {4, 1}, {4, 1}),
    bit(offsetof(CelestialSphereControl, moon), {4, 2}, {4, 2}),
    bit(offsetof(CelestialSphereControl, stars), {4, 3}, {4, 3}),
    bit(offsetof(CelestialSphereControl, date_time_valid), {4, 4}, {4, 4}),
    u8_to(23, offsetof(CelestialSphereControl, hour), 2, 6,
          offsetof(CelestialSphereControl, date_time_valid)),
    u8_to(59, offsetof(CelestialSphereControl, minute), 3, 7,
          offsetof(CelestialSphereControl, date_time_valid)),
    f32(offsetof(CelestialSphereControl, second), kNo, 8, offsetof(CelestialSphereControl, date_time_valid)),
    u32(offsetof(CelestialSphereControl, date_mmddyyyy), 8, 12,
        offsetof(CelestialSphereControl, date_time_valid)),
    f32(offsetof(CelestialSphereControl, star_intensity_percent), 12, 16),
};
constexpr Field kAtmosphereControl[] = {
    bit(offsetof(AtmosphereControl, model), {2, 0}, {4, 7}),
    bits(7, 127, offsetof(AtmosphereControl, humidity_percent), {3, 0}, {4, 0}),
    f32(offsetof(AtmosphereControl, air_temperature_c), 4, 8),
    f32(offsetof(AtmosphereControl, visibility_m), 8, 12),
    f32(offsetof(AtmosphereControl, horizontal_wind_m_s), 12, 16),
    f32(offsetof(AtmosphereControl, vertical_wind_m_s), 16, 20),
    f32(offsetof(AtmosphereControl, wind_direction_deg), 20, 24),
    f32(offsetof(AtmosphereControl, pressure_hpa), 24, 28),
};
constexpr Field kWeatherControl[] = {
    u16(offsetof(WeatherControl, entity_or_region), 2, 8),
    u8(offsetof(WeatherControl, layer), 4, 4),
    bit(offsetof(WeatherControl, enabled), {6, 0}, {6, 0}),
    bit(offsetof(WeatherControl, scud), {6, 1}, {6, 1}),
    bit(offsetof(WeatherControl, random_winds), {6, 2}, {6, 2}),
    bit(offsetof(WeatherControl, random_lightning), {6, 3}, {6, 3}),
    bit(offsetof(WeatherControl, top_scud), {kNo, 0}, {7, 5}),
    bits(4, 15, offsetof(WeatherControl, cloud_type), {6, 4}, {6, 4}),
    bits(2, 2, offsetof(WeatherControl, scope), {7, 0}, {7, 0}),
    bits(3, 5, offsetof(WeatherControl, severity), {7, 2}, {7, 2}),
    u8(offsetof(WeatherControl, humidity_percent), 5, 5),
    f32(offsetof(WeatherControl, air_temperature_c), 8, 12),
    f32(offsetof(WeatherControl, visibility_m), 12, 16),
    f32(offsetof(WeatherControl, scud_percent), 16, 20),
    f32(offsetof(WeatherControl, coverage_percent), 20, 24),
    f32(offsetof(WeatherControl, base_elevation_m), 24, 28),
    f32(offsetof(WeatherControl, thickness_m), 28, 32),
    f32(offsetof(WeatherControl, transition_m), 32, 36),
    f32(offsetof(WeatherControl, horizontal_wind_m_s), 36, 40),
    f32(offsetof(WeatherControl, vertical_wind_m_s), 40, 44),
    f32(offsetof(WeatherControl, wind_direction_deg), 44, 48),
    f32(offsetof(WeatherControl, pressure_hpa), 48, 52),
    f32(offsetof(WeatherControl, aerosol_g_m3), 52, 56),
    f32(offsetof(WeatherControl, top_scud_percent), kNo, 60),
    f32(offsetof(WeatherControl, top_transition_m), kNo, 64),
};
constexpr Field kViewControl[] = {
    u16(offsetof(ViewControl, view), 2, 6),
    u8(offsetof(ViewControl, group), 4, 4),
    u16(offsetof(ViewControl, entity), 6, 8),
    bit(offsetof(ViewControl, x_valid), {5, 0}, {5, 0}),
    bit(offsetof(ViewControl, y_valid), {5, 1}, {5, 1}),
    bit(offsetof(ViewControl, z_valid), {5, 2}, {5, 2}),
    bit(offsetof(ViewControl, roll_valid), {5, 3}, {5, 3}),
    bit(offsetof(ViewControl, pitch_valid), {5, 4}, {5, 4}),
    bit(offsetof(ViewControl, yaw_valid), {5, 5}, {5, 5}),
    f32(offsetof(ViewControl, x_m), 8, 12, offsetof(ViewControl, x_valid)),
    f32(offsetof(ViewControl, y_m), 12, 16, offsetof(ViewControl, y_valid)),
    f32(offsetof(ViewControl, z_m), 16, 20, offsetof(ViewControl, z_valid)),
    f32(offsetof(ViewControl, roll_deg), 20, 24, offsetof(ViewControl, roll_valid)),
    f32(offsetof(ViewControl, pitch_deg), 24, 28, offsetof(ViewControl, pitch_valid)),
    f32(offsetof(ViewControl, yaw_deg), 28, 32, offsetof(ViewControl, yaw_valid)),
};
constexpr Field kViewDefinition[] = {
    u16(offsetof(ViewDefinition, view), 2, 4),
    u8(offsetof(ViewDefinition, group), 4, 6),
    bit(offsetof(ViewDefinition, near_valid), {5, 0}, {7, 0}),
    bit(offsetof(ViewDefinition, far_valid), {5, 1}, {7, 1}),
    bit(offsetof(ViewDefinition, left_valid), {5, 2}, {7, 2}),
    bit(offsetof(ViewDefinition, right_valid), {5, 3}, {7, 3}),
    bit(offsetof(ViewDefinition, top_valid), {5, 4}, {7, 4}),
    bit(offsetof(ViewDefinition, bottom_valid), {5, 5}, {7, 5}),
    bits(2, 3, offsetof(ViewDefinition, mirror), {5, 6}, {7, 6}),
    bits(3, 7, offsetof(ViewDefinition, pixel_replication), {6, 0}, {8, 0}),
    bit(offsetof(ViewDefinition, parallel), {6, 3}, {8, 3}),
    bit(offsetof(ViewDefinition, reorder), {6, 4}, {8, 4}),
    bits(3, 7, offsetof(ViewDefinition, type), {6, 5}, {8, 5}),
    f32(offsetof(ViewDefinition, near_m), 8, 12, offsetof(ViewDefinition, near_valid)),
    f32(offsetof(ViewDefinition, far_m), 12, 16, offsetof(ViewDefinition, far_valid)),
    f32(offsetof(ViewDefinition, left_deg), 16, 20, offsetof(ViewDefinition, left_valid)),
    f32(offsetof(ViewDefinition, right_deg), 20, 24, offsetof(ViewDefinition, right_valid)),
    f32(offsetof(ViewDefinition, top_deg), 24, 28, offsetof(ViewDefinition, top_valid)),
    f32(offsetof(ViewDefinition, bottom_deg), 28, 32, offsetof(ViewDefinition, bottom_valid)),
};
constexpr Field kHatHotRequest[] = {
    u16(offsetof(HatHotRequest, id), 2, 4),
    bits(2, 2, offsetof(HatHotRequest, type), {4, 0}, {8, 0}),
    bit(offsetof(HatHotRequest, system), {4, 2}, {8, 2}),
    u8(offsetof(HatHotRequest, update_period), 5, 9),
    u16(offsetof(HatHotRequest, entity), 6, 6),
    f64(offsetof(HatHotRequest, latitude_deg_or_x_m), 8, 16),
    f64(offsetof(HatHotRequest, longitude_deg_or_y_m), 16, 24),
    f64(offsetof(HatHotRequest, altitude_m_or_z_m), 24, 32),
};
constexpr Field kLosSegmentRequest[] = {
    u16(offsetof(LosSegmentRequest, id), 2, 4),
    bit(offsetof(LosSegmentRequest, extended), {4, 0}, {8, 0}),
    bit(offsetof(LosSegmentRequest, source), {4, 1}, {8, 1}),
    bit(offsetof(LosSegmentRequest, destination), {4, 2}, {8, 2}),
    bit(offsetof(LosSegmentRequest, response), {4, 3}, {8, 3}),
    bit(offsetof(LosSegmentRequest, destination_entity_valid), {4, 4}, {8, 4}),
    u8(offsetof(LosSegmentRequest, alpha_threshold), 5, 9),
    u8(offsetof(LosSegmentRequest, update_period), 60, 12),
    u16(offsetof(LosSegmentRequest, entity), 6, 6),
    u16(offsetof(LosSegmentRequest, destination_entity), 62, 10),
    f64(offsetof(LosSegmentRequest, source_latitude_deg_or_x_m), 8, 16),
    f64(offsetof(LosSegmentRequest, source_longitude_deg_or_y_m), 16, 24),
    f64(offsetof(LosSegmentRequest, source_altitude_m_or_z_m), 24, 32),
    f64(offsetof(LosSegmentRequest, destination_latitude_deg_or_x_m), 32, 40),
    f64(offsetof(LosSegmentRequest, destination_longitude_deg_or_y_m), 40, 48),
    f64(offsetof(LosSegmentRequest, destination_altitude_m_or_z_m), 48, 56),
    u32(offsetof(LosSegmentRequest, material_mask), 56, 64),
};
constexpr Field kLosVectorRequest[] = {
    u16(offsetof(LosVectorRequest, id), 2, 4),
    bit(offsetof(LosVectorRequest, extended), {4, 0}, {8, 0}),
    bit(offsetof(LosVectorRequest, source), {4, 1}, {8, 1}),
    bit(offsetof(LosVectorRequest, response), {4, 2}, {8, 2}),
    u8(offsetof(LosVectorRequest, alpha_threshold), 5, 9),
    u8(offsetof(LosVectorRequest, update_period), 52, 10),
    u16(offsetof(LosVectorRequest, entity), 6, 6),
    f32(offsetof(LosVectorRequest, azimuth_deg), 8, 16),
    f32(offsetof(LosVectorRequest, elevation_deg), 12, 20),
    f32(offsetof(LosVectorRequest, minimum_range_m), 16, 24),
    f32(offsetof(LosVectorRequest, maximum_range_m), 20, 28),
    f64(offsetof(LosVectorRequest, source_latitude_deg_or_x_m), 24, 32),
    f64(offsetof(LosVectorRequest, source_longitude_deg_or_y_m), 32, 40),
    f64(offsetof(LosVectorRequest, source_altitude_m_or_z_m), 40, 48),
    u32(offsetof(LosVectorRequest, material_mask), 48, 56),
};
constexpr Field kStartOfFrame[] = {
    s8(offsetof(StartOfFrame, database), 3, 5),
    u8(offsetof(StartOfFrame, status), 4, kNo),
    bits(2, 3, offsetof(StartOfFrame, mode), {5, 0}, {7, 0}),
    bit(offsetof(StartOfFrame, timestamp_valid), {5, 2}, {7, 2}),
    bit(offsetof(StartOfFrame, own_earth_model), {5, 3}, {7, 3}),
    bit_of_16(offsetof(StartOfFrame, overframing), {kNo, 0}, {20, 8}),
    bit_of_16(offsetof(StartOfFrame, paging), {kNo, 0}, {20, 9}),
    bit_of_16(offsetof(StartOfFrame, too_much_variable_data), {kNo, 0}, {20, 10}),
    u32(offsetof(StartOfFrame, ig_frame), 8, 8),
    u32(offsetof(StartOfFrame, timestamp_10us), 12, 12),
    u32(offsetof(StartOfFrame, last_host_frame), 16, 16),
};
constexpr Field kHatHotResponse[] = {
    u16(offsetof(HatHotResponse, id), 2, 6),
    bit(offsetof(HatHotResponse, valid), {4, 0}, {4, 0}),
    bit(offsetof(HatHotResponse, type), {4, 1}, {4, 1}),
    bits(4, 15, offsetof(HatHotResponse, host_frame_low), {4, 4}, {4, 4}),
    f64(offsetof(HatHotResponse, height_m), 8, 8, offsetof(HatHotResponse, valid)),
};
constexpr Field kHatHotExtendedResponse[] = {
    u16(offsetof(HatHotExtendedResponse, id), 2, 6),
    bit(offsetof(HatHotExtendedResponse, valid), {4, 0}, {4, 0}),
    bits(4, 15, offsetof(HatHotExtendedResponse, host_frame_low), {4, 4}, {4, 4}),
    f64(offsetof(HatHotExtendedResponse, hat_m), 8, 8, offsetof(HatHotExtendedResponse, valid)),
    f64(offsetof(HatHotExtendedResponse, hot_m), 16, 16, offsetof(HatHotExtendedResponse, valid)),
    u32(offsetof(HatHotExtendedResponse, material), 24, 24, offsetof(HatHotExtendedResponse, valid)),
    f32(offsetof(HatHotExtendedResponse, normal_azimuth_deg), 28, 28,
        offsetof(HatHotExtendedResponse, valid)),
    f32(offsetof(HatHotExtendedResponse, normal_elevation_deg), 32, 32,
        offsetof(HatHotExtendedResponse, valid)),
};
constexpr Field kLosResponse[] = {
    u16(offsetof(LosResponse, id), 2, 4),
    bit(offsetof(LosResponse, valid), {4, 0}, {8, 0}),
    bit(offsetof(LosResponse, entity_valid), {4, 1}, {8, 1}),
    bit(offsetof(LosResponse, visible), {4, 2}, {8, 2}),
    bits(4, 15, offsetof(LosResponse, host_frame_low), {4, 4}, {8, 4}),
    u8(offsetof(LosResponse, responses), 5, 9),
    u16(offsetof(LosResponse, entity), 6, 6),
    f64(offsetof(LosResponse, range_m), 8, 16, offsetof(LosResponse, valid)),
};
constexpr Field kLosExtendedResponse[] = {
    u16(offsetof(LosExtendedResponse, id), 2, 4),
    bit(offsetof(LosExtendedResponse, valid), {4, 0}, {8, 0}),
    bit(offsetof(LosExtendedResponse, entity_valid), {4, 1}, {8, 1}),
    bit(offsetof(LosExtendedResponse, range_valid), {4, 2}, {8, 2}),
    bit(offsetof(LosExtendedResponse, visible), {4, 3}, {8, 3}),
    bits(4, 15, offsetof(LosExtendedResponse, host_frame_low), {4, 4}, {8, 4}),
    u8(offsetof(LosExtendedResponse, responses), 5, 9),
    u16(offsetof(LosExtendedResponse, entity), 6, 6),
    f64(offsetof(LosExtendedResponse, range_m), 8, 16, offsetof(LosExtendedResponse, range_valid)),
    f64(offsetof(LosExtendedResponse, latitude_deg_or_x_m), 16, 24, offsetof(LosExtendedResponse, valid)),
    f64(offsetof(LosExtendedResponse, longitude_deg_or_y_m), 24, 32, offsetof(LosExtendedResponse, valid)),
    f64(offsetof(LosExtendedResponse, altitude_m_or_z_m), 32, 40, offsetof(LosExtendedResponse, valid)),
    u8(offsetof(LosExtendedResponse, red), 40, 48),
    u8(offsetof(LosExtendedResponse, green), 41, 49),
    u8(offsetof(LosExtendedResponse, blue), 42, 50),
    u8(offsetof(LosExtendedResponse, alpha), 43, 51),
    u32(offsetof(LosExtendedResponse, material), 44, 52),
    f32(offsetof(LosExtendedResponse, normal_azimuth_deg), 48, 56, offsetof(LosExtendedResponse, valid)),
    f32(offsetof(LosExtendedResponse, normal_elevation_deg), 52, 60, offsetof(LosExtendedResponse, valid)),
};

constexpr Layout kLayouts[] = {
    {0, Speaker::host, {1, 0x00}, {24, 24}, kIgControl},
    {1, Speaker::host, {2, 0x25}, {48, 16}, kEntityControl},
    {2, Speaker::host, {2, 0x01}, {48, 48}, kEntityPosition},
    {3, Speaker::host, {8, 0x07}, {32, 32}, kRateControl},
    {4, Speaker::host, {4, 0x03}, {32, 40}, kComponentControl},
    {5, Speaker::host, {9, 0x08}, {16, 24}, kCelestialSphereControl},
    {6, Speaker::host, {10, 0x09}, {32, 32}, kAtmosphereControl},
    {7, Speaker::host, {12, 0x0b}, {56, 72}, kWeatherControl},
    {8, Speaker::host, {16, 0x0f}, {32, 40}, kViewControl},
    {9, Speaker::host, {21, 0x14}, {32, 40}, kViewDefinition},
    {10, Speaker::host, {24, 0x17}, {32, 40}, kHatHotRequest},
    {11, Speaker::host, {25, 0x18}, {64, 72}, kLosSegmentRequest},
    {12, Speaker::host, {26, 0x19}, {56, 64}, kLosVectorRequest},
    {13, Speaker::ig, {101, 0xffff}, {24, 24}, kStartOfFrame},
    {14, Speaker::ig, {102, 0x0fff}, {16, 16}, kHatHotResponse},
    {15, Speaker::ig, {103, 0x0ffe}, {40, 40}, kHatHotExtendedResponse},
    {16, Speaker::ig, {104, 0x0ffd}, {16, 24}, kLosResponse},
    {17, Speaker::ig, {105, 0x0ffc}, {56, 64}, kLosExtendedResponse},
    {4,
     Speaker::host,
     {5, 0x04},
     {16, 24},
     std::span<const Field>(kComponentControl).first(6),
     offsetof(ComponentControl, short_form)},
};
// clang-format on

template <std::size_t I>
void* emplace(Packet& packet) {
  return &packet.emplace<I>();
}
template <std::size_t I>
const void* address(const Packet& packet) {
  return std::get_if<I>(&packet);
}
using Emplace = void* (*)(Packet&);
using Address = const void* (*)(const Packet&);
template <std::size_t... I>
constexpr std::array<Emplace, sizeof...(I)> emplace_table(std::index_sequence<I...>) {
  return {emplace<I>...};
}
template <std::size_t... I>
constexpr std::array<Address, sizeof...(I)> address_table(std::index_sequence<I...>) {
  return {address<I>...};
}
using Alternatives = std::make_index_sequence<std::variant_size_v<Packet>>;
constexpr auto kEmplace = emplace_table(Alternatives());
constexpr auto kAddress = address_table(Alternatives());

constexpr std::size_t bytes_of(Kind kind) {
  switch (kind) {
    case Kind::u16:
    case Kind::bits16:
      return 2;
    case Kind::u32:
    case Kind::f32:
      return 4;
    case Kind::f64:
      return 8;
    default:
      return 1;
  }
}
constexpr bool is_bits(Kind kind) {
  return kind == Kind::bits8 || kind == Kind::bits16;
}

bool is_true(const void* object, std::uint16_t member) {
  bool value = false;
  std::memcpy(&value, static_cast<const std::byte*>(object) + member, sizeof value);
  return value;
}

// Numbers lie in memory in the machine's order, bits in one byte.
std::uint64_t load_member(const Field& field, const void* object) {
  const std::byte* at = static_cast<const std::byte*>(object) + field.member;
  constexpr Order kMachine = std::endian::native == std::endian::little ? Order::little : Order::big;
  return load(at, is_bits(field.kind) ? 1 : bytes_of(field.kind), kMachine);
}
void store_member(const Field& field, void* object, std::uint64_t value) {
  std::byte* at = static_cast<std::byte*>(object) + field.member;
  constexpr Order kMachine = std::endian::native == std::endian::little ? Order::little : Order::big;
  store(at, is_bits(field.kind) ? 1 : bytes_of(field.kind), kMachine, value);
}

bool is_finite(Kind kind, std::uint64_t value) {
  if (kind == Kind::f32) return std::isfinite(std::bit_cast<float>(static_cast<std::uint32_t>(value)));
  return kind != Kind::f64 || std::isfinite(std::bit_cast<double>(value));
}

}  // namespace

std::span<const Layout> layouts() {
  return kLayouts;
}

std::uint64_t load(const std::byte* at, std::size_t n, Order order) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t byte = order == Order::big ? i : n - 1 - i;
    value = value << 8 | std::to_integer<std::uint64_t>(at[byte]);
  }
  return value;
}

void store(std::byte* at, std::size_t n, Order order, std::uint64_t value) {
  for (std::size_t i = 0; i < n; ++i) {
    at[order == Order::little ? i : n - 1 - i] = static_cast<std::byte>(value >> (8 * i) & 0xff);
  }
}

bool decode(const Layout& layout, Column column, Order order, const std::byte* bytes, Packet& packet) {
  void* const object = kEmplace[layout.alternative](packet);
  for (const Field& field : layout.fields) {
    const Place place = field.places[column];
    if (place.at == kAbsent) continue;
    if (field.valid_by != kNoMember && !is_true(object, field.valid_by)) continue;  // stays 0
    std::uint64_t value = load(bytes + place.at, bytes_of(field.kind), order);
    if (is_bits(field.kind)) value = value >> place.shift & ((1u << field.width) - 1);
    if (is_bits(field.kind) || field.kind == Kind::u8) {
      if (value > field.most) return false;
    } else if (!is_finite(field.kind, value)) {
      return false;
    }
    store_member(field, object, value);
  }
  if (layout.sets != kNoMember) {
    const bool value = true;
    std::memcpy(static_cast<std::byte*>(object) + layout.sets, &value, sizeof value);
  }
  return true;
}

void encode(const Layout& layout, Column column, Order order, const Packet& packet, std::byte* bytes) {
  const std::size_t size = layout.sizes[column];
  std::memset(bytes, 0, size);
  if (column == kColumn3) {
    store(bytes, 1, order, layout.ids[column]);
    store(bytes + 1, 1, order, size);
  } else {
    store(bytes, 2, order, size);
    store(bytes + 2, 2, order, layout.ids[column]);
  }
  const void* const object = kAddress[layout.alternative](packet);
  for (const Field& field : layout.fields) {
    const Place place = field.places[column];
    if (place.at == kAbsent) continue;
    std::byte* const at = bytes + place.at;
    const std::size_t n = bytes_of(field.kind);
    std::uint64_t value = load_member(field, object);
    if (is_bits(field.kind)) {
      value = load(at, n, order) | (value & ((1u << field.width) - 1)) << place.shift;
    }
    store(at, n, order, value);
  }
}

}  // namespace karst::cigi
