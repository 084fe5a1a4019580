// SPDX-License-Identifier: MIT
// What packets of the Common Image Generator Interface say, the same for CIGI 3.3 and 4.0: message_reader.h
// makes these of bytes, message_writer.h bytes of these, by the tables of tables.cpp.
//
// Sources: for 3.3 (the CIGI Interface Control Document) what Wireshark's dissector says of it; for 4.0
// (SISO-STD-013-2014) the CIGI Class Library 4.0 and the CIGI Host Emulator 4.0, which agree.
//
// Angles are degrees. Places are geodetic (latitude and longitude in degrees, positive north and east, on
// WGS 84, and altitude in metres above the ellipsoid) or offsets in metres in a body's system: x forward, y
// right, z down. Directions: azimuth clockwise from north or from the body's x, elevation and pitch up.
//
// What a version lacks has the value that is written here and is not sent.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>

namespace karst::cigi {

// Of a message. karst speaks 3.2 (whose packets are those of 3.3 here), 3.3 and 4.0.
struct Version {
  std::uint8_t major = 3;
  std::uint8_t minor = 3;
  bool operator==(const Version&) const = default;
};

// Of all numbers of a message. CIGI calls the swap of them byte swapping.
enum class Order : std::uint8_t { little, big };

// Who speaks: a message of a host begins with IgControl, one of an image generator (IG) with StartOfFrame.
enum class Speaker : std::uint8_t { host, ig };

enum class CoordinateSystem : std::uint8_t { geodetic, entity };

// --- host to IG

enum class IgMode : std::uint8_t { standby, operate, debug, offline };

// The first packet of a host's message.
struct IgControl {
  std::int8_t database = 0;               // 1..127: to be loaded; 0: as it is
  IgMode mode = IgMode::standby;          // standby, operate or debug
  bool timestamp_valid = false;           //
  bool smoothing = false;                 // entities' motion may be extrapolated
  bool entity_type_substitution = false;  // 4.0
  std::uint32_t host_frame = 0;           //
  std::uint32_t timestamp_10us = 0;       // ticks of 10 microseconds
  std::uint32_t last_ig_frame = 0;        // of the StartOfFrame that the host received last
  bool operator==(const IgControl&) const = default;
};

enum class EntityState : std::uint8_t { inactive, active, destroyed };
enum class AnimationState : std::uint8_t { stop, pause, play, resume };

// 3.3 says it in one packet with EntityPosition; the reader gives that as both, this one first.
struct EntityControl {
  std::uint16_t entity = 0;                         // 0: the host's own body
  EntityState state = EntityState::inactive;        //
  bool collision_detection = false;                 //
  bool inherit_alpha = false;                       //
  bool smoothing = false;                           // 3.3 and 4.0
  std::uint8_t alpha = 255;                         // 0: not to be seen
  std::uint16_t type = 0;                           // 4.0 with extended_type: the country
  bool extended_type = false;                       // 4.0: the seven numbers of a DIS entity type
  std::uint8_t kind = 0;                            // 4.0
  std::uint8_t domain = 0;                          // 4.0
  std::uint8_t category = 0;                        // 4.0
  std::uint8_t subcategory = 0;                     // 4.0
  std::uint8_t specific = 0;                        // 4.0
  std::uint8_t extra = 0;                           // 4.0
  bool animation_backward = false;                  // 3.3
  bool animation_loop = false;                      // 3.3
  AnimationState animation = AnimationState::stop;  // 3.3
  bool operator==(const EntityControl&) const = default;
};

enum class Clamp : std::uint8_t { none, altitude, altitude_and_attitude };

// Entity Position of 4.0.
struct EntityPosition {
  std::uint16_t entity = 0;   //
  bool attached = false;      // to the parent: the place is an offset in its system, and so are the angles
  Clamp clamp = Clamp::none;  // to the ground: altitude is above it, and roll and pitch follow it
  std::uint16_t parent = 0;   // where attached
  float roll_deg = 0;         // turned by yaw, then pitch, then roll
  float pitch_deg = 0;        //
  float yaw_deg = 0;          // 0: north, or the parent's x
  double latitude_deg_or_x_m = 0;
  double longitude_deg_or_y_m = 0;
  double altitude_m_or_z_m = 0;
  bool operator==(const EntityPosition&) const = default;
};

// Rate Control of 3.3, Velocity Control of 4.0: an entity moves on by itself between positions.
struct RateControl {
  std::uint16_t entity = 0;
  std::uint8_t part = 0;
  bool of_part = false;  // else of the entity
  bool local = false;    // x, y, z are the body's; else north, east and down, or the parent's
  float x_m_s = 0;
  float y_m_s = 0;
  float z_m_s = 0;
  float roll_deg_s = 0;
  float pitch_deg_s = 0;
  float yaw_deg_s = 0;
  bool operator==(const RateControl&) const = default;
};

// Component Control, and Short Component Control, which has two words.
struct ComponentControl {
  std::uint16_t component = 0;
  std::uint16_t instance = 0;        // of the class: an entity, a view...
  std::uint8_t component_class = 0;  // 0 entity, 1 view, 2 view group, ..., 13 system; at most 63
  std::uint8_t state = 0;
  bool short_form = false;
  std::array<std::uint32_t, 6> words{};  // their meaning is the component's; short_form: the last four are 0
  bool operator==(const ComponentControl&) const = default;
};

struct CelestialSphereControl {
  bool ephemeris = false;            // time goes on by itself
  bool sun = false;                  //
  bool moon = false;                 //
  bool stars = false;                //
  bool date_time_valid = false;      // else hour, minute, second and date are 0
  std::uint8_t hour = 0;             // taken as UTC, of which the sources say nothing
  std::uint8_t minute = 0;           //
  float second = 0;                  // 4.0
  std::uint32_t date_mmddyyyy = 0;   // month * 1,000,000 + day * 10,000 + year
  float star_intensity_percent = 0;  //
  bool operator==(const CelestialSphereControl&) const = default;

  std::uint32_t month() const { return date_mmddyyyy / 1'000'000; }
  std::uint32_t day() const { return date_mmddyyyy / 10'000 % 100; }
  std::uint32_t year() const { return date_mmddyyyy % 10'000; }
};

// Of the whole world.
struct AtmosphereControl {
  bool model = false;  // the IG may use a model of the atmosphere
  std::uint8_t humidity_percent = 0;
  float air_temperature_c = 0;
  float visibility_m = 0;
  float horizontal_wind_m_s = 0;
  float vertical_wind_m_s = 0;
  float wind_direction_deg = 0;  // from where it blows
  float pressure_hpa = 0;
  bool operator==(const AtmosphereControl&) const = default;
};

enum class WeatherScope : std::uint8_t { global, regional, entity };

struct WeatherControl {
  std::uint16_t entity_or_region = 0;
  std::uint8_t layer = 0;  // 0 ground fog, 1 cloud layer 1, 2 cloud layer 2, 3 cloud layer 3, 4 rain,
  bool enabled = false;    // 5 snow, 6 sleet, 7 hail, 8 sand, 9 dust, and a host's own
  bool scud = false;
  bool random_winds = false;
  bool random_lightning = false;
  bool top_scud = false;        // 4.0
  std::uint8_t cloud_type = 0;  // at most 15
  WeatherScope scope = WeatherScope::global;
  std::uint8_t severity = 0;  // at most 5
  std::uint8_t humidity_percent = 0;
  float air_temperature_c = 0;
  float visibility_m = 0;
  float scud_percent = 0;
  float coverage_percent = 0;
  float base_elevation_m = 0;
  float thickness_m = 0;
  float transition_m = 0;
  float horizontal_wind_m_s = 0;
  float vertical_wind_m_s = 0;
  float wind_direction_deg = 0;
  float pressure_hpa = 0;
  float aerosol_g_m3 = 0;
  float top_scud_percent = 0;  // 4.0
  float top_transition_m = 0;  // 4.0
  bool operator==(const WeatherControl&) const = default;
};

// Where a view, or all views of a group, are on an entity. What is not valid is 0 and stays as it was.
struct ViewControl {
  std::uint16_t view = 0;    // where group is 0
  std::uint8_t group = 0;    // 1..255: of all its views
  std::uint16_t entity = 0;  // that it is on
  bool x_valid = false;
  bool y_valid = false;
  bool z_valid = false;
  bool roll_valid = false;
  bool pitch_valid = false;
  bool yaw_valid = false;
  float x_m = 0;  // from the entity's reference point, in its system
  float y_m = 0;
  float z_m = 0;
  float roll_deg = 0;
  float pitch_deg = 0;
  float yaw_deg = 0;
  bool operator==(const ViewControl&) const = default;
};

enum class Mirror : std::uint8_t { none, horizontal, vertical, both };

// What a view shows. What is not valid is 0 and stays as it was.
struct ViewDefinition {
  std::uint16_t view = 0;
  std::uint8_t group = 0;  // that the view belongs to; 0: none
  bool near_valid = false;
  bool far_valid = false;
  bool left_valid = false;
  bool right_valid = false;
  bool top_valid = false;
  bool bottom_valid = false;
  Mirror mirror = Mirror::none;
  std::uint8_t pixel_replication = 0;  // 0 none, 1 1x2, 2 2x1, 3 2x2; 4..7 the IG's own
  bool parallel = false;               // projection; else perspective
  bool reorder = false;                // the view is drawn last, over others
  std::uint8_t type = 0;               // at most 7, the IG's own
  float near_m = 0;
  float far_m = 0;
  float left_deg = 0;   // half-angles from the view's axis: left and bottom are below 0 as a
  float right_deg = 0;  // rule, any left < right and bottom < top may come
  float top_deg = 0;
  float bottom_deg = 0;
  bool operator==(const ViewDefinition&) const = default;
};

enum class HatHotType : std::uint8_t { hat, hot, extended };

// HAT: height of a point above terrain; HOT: height of the terrain above or below the ellipsoid.
struct HatHotRequest {
  std::uint16_t id = 0;
  HatHotType type = HatHotType::hat;
  CoordinateSystem system = CoordinateSystem::geodetic;
  std::uint8_t update_period = 0;  // frames between answers; 0: one answer
  std::uint16_t entity = 0;        // whose system
  double latitude_deg_or_x_m = 0;
  double longitude_deg_or_y_m = 0;
  double altitude_m_or_z_m = 0;
  bool operator==(const HatHotRequest&) const = default;
};

// What lies between two points.
struct LosSegmentRequest {
  std::uint16_t id = 0;
  bool extended = false;  // the answer
  CoordinateSystem source = CoordinateSystem::geodetic;
  CoordinateSystem destination = CoordinateSystem::geodetic;
  CoordinateSystem response = CoordinateSystem::geodetic;
  bool destination_entity_valid = false;  // else the destination is in the system of the source's entity
  std::uint8_t alpha_threshold = 0;       // surfaces below it are not hit
  std::uint8_t update_period = 0;         // as of HatHotRequest
  std::uint16_t entity = 0;               // of the source
  std::uint16_t destination_entity = 0;
  double source_latitude_deg_or_x_m = 0;
  double source_longitude_deg_or_y_m = 0;
  double source_altitude_m_or_z_m = 0;
  double destination_latitude_deg_or_x_m = 0;
  double destination_longitude_deg_or_y_m = 0;
  double destination_altitude_m_or_z_m = 0;
  std::uint32_t material_mask = 0;
  bool operator==(const LosSegmentRequest&) const = default;
};

// What lies along a direction.
struct LosVectorRequest {
  std::uint16_t id = 0;
  bool extended = false;
  CoordinateSystem source = CoordinateSystem::geodetic;
  CoordinateSystem response = CoordinateSystem::geodetic;
  std::uint8_t alpha_threshold = 0;
  std::uint8_t update_period = 0;
  std::uint16_t entity = 0;
  float azimuth_deg = 0;
  float elevation_deg = 0;
  float minimum_range_m = 0;
  float maximum_range_m = 0;
  double source_latitude_deg_or_x_m = 0;
  double source_longitude_deg_or_y_m = 0;
  double source_altitude_m_or_z_m = 0;
  std::uint32_t material_mask = 0;
  bool operator==(const LosVectorRequest&) const = default;
};

// --- IG to host. What is not valid is read as 0.

// The first packet of an IG's message, once a frame.
struct StartOfFrame {
  std::int8_t database = 0;  // loaded; negative: being loaded, -128: it cannot be
  std::uint8_t status = 0;   // 3.3: 0 normal operation, else the IG's own
  IgMode mode = IgMode::standby;
  bool timestamp_valid = false;
  bool own_earth_model = false;         // a host's Earth Reference Model is in use, else WGS 84
  bool overframing = false;             // 4.0: frames take too long
  bool paging = false;                  // 4.0: data is being loaded
  bool too_much_variable_data = false;  // 4.0
  std::uint32_t ig_frame = 0;
  std::uint32_t timestamp_10us = 0;
  std::uint32_t last_host_frame = 0;  // of the IgControl that the IG received last
  bool operator==(const StartOfFrame&) const = default;
};

struct HatHotResponse {
  std::uint16_t id = 0;
  bool valid = false;                 // there is ground, and the request can be answered
  HatHotType type = HatHotType::hat;  // hat or hot
  std::uint8_t host_frame_low = 0;    // the last 4 bits of the host's frame that the answer is of
  double height_m = 0;
  bool operator==(const HatHotResponse&) const = default;
};

struct HatHotExtendedResponse {
  std::uint16_t id = 0;
  bool valid = false;
  std::uint8_t host_frame_low = 0;
  double hat_m = 0;
  double hot_m = 0;
  std::uint32_t material = 0;
  float normal_azimuth_deg = 0;
  float normal_elevation_deg = 0;
  bool operator==(const HatHotExtendedResponse&) const = default;
};

struct LosResponse {
  std::uint16_t id = 0;
  bool valid = false;         // something was hit
  bool entity_valid = false;  // it is an entity
  bool visible = false;       // of a segment: nothing hides its destination
  std::uint8_t host_frame_low = 0;
  std::uint8_t responses = 0;  // to this request in this frame
  std::uint16_t entity = 0;
  double range_m = 0;
  bool operator==(const LosResponse&) const = default;
};

struct LosExtendedResponse {
  std::uint16_t id = 0;
  bool valid = false;
  bool entity_valid = false;  // the place is an offset in that entity's system
  bool range_valid = false;
  bool visible = false;
  std::uint8_t host_frame_low = 0;
  std::uint8_t responses = 0;
  std::uint16_t entity = 0;
  double range_m = 0;
  double latitude_deg_or_x_m = 0;
  double longitude_deg_or_y_m = 0;
  double altitude_m_or_z_m = 0;
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  std::uint8_t alpha = 0;
  std::uint32_t material = 0;
  float normal_azimuth_deg = 0;
  float normal_elevation_deg = 0;
  bool operator==(const LosExtendedResponse&) const = default;
};

using Packet = std::variant<IgControl, EntityControl, EntityPosition, RateControl, ComponentControl,
                            CelestialSphereControl, AtmosphereControl, WeatherControl, ViewControl,
                            ViewDefinition, HatHotRequest, LosSegmentRequest, LosVectorRequest, StartOfFrame,
                            HatHotResponse, HatHotExtendedResponse, LosResponse, LosExtendedResponse>;

}  // namespace karst::cigi
