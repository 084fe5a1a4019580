// SPDX-License-Identifier: MIT
// Packets of the Common Image Generator Interface that a host sends and understands, field after field as the
// standards list them: CIGI 3.3 and 4.0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

struct Dialect {
  int major = 3;     // 3 for 3.3, 4 for 4.0
  bool big = false;  // order of bytes
};

struct Place {
  double latitude_deg = 0;
  double longitude_deg = 0;
  double altitude_m = 0;
};

// What a host says in a frame: a datagram.
class Message {
 public:
  explicit Message(Dialect dialect) : dialect_(dialect) {}

  void ig_control(std::uint32_t frame, std::uint32_t timestamp_10us, std::uint32_t last_ig_frame);
  void entity(std::uint16_t id, const Place& place, float yaw_deg, float pitch_deg, float roll_deg);
  void view_definition(std::uint16_t view, float near_m, float far_m, float half_width_deg,
                       float half_height_deg);
  void view_on_entity(std::uint16_t view, std::uint16_t entity, float pitch_deg);
  void celestial_sphere(unsigned hour, unsigned minute, std::uint32_t date_mmddyyyy);
  void visibility(float visibility_m);
  // Answered once, or every period frames.
  void hat_hot_extended(std::uint16_t id, const Place& place, unsigned period);
  // From an entity's reference point along a direction in its system.
  void los_vector(std::uint16_t id, std::uint16_t entity, float azimuth_deg, float elevation_deg,
                  float range_m, unsigned period);
  void los_segment(std::uint16_t id, const Place& from, const Place& to, unsigned period);

  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  bool old() const { return dialect_.major == 3; }
  void begin(unsigned id3, unsigned size3, unsigned id4, unsigned size4);
  void number(std::uint64_t value, int size);
  void u8(unsigned value) { number(value, 1); }
  void u16(unsigned value) { number(value, 2); }
  void u32(std::uint32_t value) { number(value, 4); }
  void f32(float value);
  void f64(double value);
  void place(const Place& place);

  Dialect dialect_;
  std::vector<std::uint8_t> bytes_;
};

// What an image generator answers, of one packet.
struct Answer {
  enum class What { start_of_frame, hat_hot, los } what = What::start_of_frame;
  std::uint32_t ig_frame = 0;         // start_of_frame
  std::uint32_t last_host_frame = 0;  //
  int mode = 0;                       //
  int database = 0;                   //
  std::uint16_t id = 0;               // of the request
  bool valid = false;
  bool visible = false;  // los, of a segment
  double hat_m = 0;      // hat_hot
  double hot_m = 0;      //
  double range_m = 0;    // los
  Place place;           //
};

// The answers in a datagram; false: it is none of that dialect.
bool read_answers(Dialect dialect, const std::uint8_t* bytes, std::size_t size, std::vector<Answer>& answers);
