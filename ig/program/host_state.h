// SPDX-License-Identifier: MIT
// All that a host has said, and what it is told: the state of the world for a frame, and the message that
// the frame sends. Nothing is allocated after the start.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "ig/answer/answers.h"
#include "ig/cigi/message_reader.h"
#include "ig/cigi/message_writer.h"
#include "ig/state/air.h"
#include "ig/state/entities.h"
#include "ig/state/views.h"

namespace karst::ig {

// What is asked for and not done; each is said once.
enum class Lack : std::uint8_t {
  version,
  malformed,
  database,
  view,
  group_or_view,
  half_angles,
  view_extras,
  entities,
  animation,
  collision,
  parts,
  components,
  moon_and_stars,
  weather,
  wind,
  requests,
  material,
  kCount
};

class HostState {
 public:
  using Say = std::function<void(const std::string& line)>;
  // Answers take this long a frame at most.
  static constexpr std::int64_t kAnswer_ns = 4'000'000;
  // And so many reads of the file: tiles of 64 samples a side.
  static constexpr std::uint32_t kAnswerReads = 32;

  HostState(int database, const ViewLayout& layout, glm::dvec3 half_box_m, Say say);

  // A datagram of the host. Anything may be in it.
  void take(std::span<const std::byte> datagram, const Earth& earth, std::int64_t arrived_ns);
  // Where everything is at a time. query: for what is on the ground.
  void advance(const Earth& earth, Query& query, std::int64_t now_ns);
  // The message of a frame: Start Of Frame, and answers. overframing, paging: as the packet has them.
  std::span<const std::byte> message(const Earth& earth, Query& query, std::int64_t now_ns, bool overframing,
                                     bool paging);

  const Entities& entities() const { return entities_; }
  Views& views() { return views_; }
  const HostAir& air() const { return air_; }
  glm::dvec3 half_box_m() const { return half_box_m_; }

  struct Counts {
    std::uint64_t requests = 0;
    std::uint64_t answers = 0;
  };
  const Counts& counts() const { return counts_; }
  const cigi::ReadCounts& read_counts() const { return reader_.counts(); }
  std::size_t waiting() const { return answers_.waiting(); }
  cigi::Version version() const { return version_; }
  cigi::IgMode mode() const { return mode_; }
  std::uint32_t host_frame() const { return host_frame_; }
  // When the newest message of the host that was taken since the last call came; 0: none was.
  std::int64_t take_arrival();

 private:
  void clear();
  void lack(Lack what, const char* text);
  void lack_where(bool lacks, Lack what, const char* text) {
    if (lacks) lack(what, text);
  }
  void take_packet(const cigi::IgControl& packet);
  void take_packet(const cigi::EntityControl& packet);
  void take_packet(const cigi::EntityPosition& packet);
  void take_packet(const cigi::RateControl& packet);
  void take_packet(const cigi::ComponentControl& packet);
  void take_packet(const cigi::CelestialSphereControl& packet);
  void take_packet(const cigi::AtmosphereControl& packet);
  void take_packet(const cigi::WeatherControl& packet);
  void take_packet(const cigi::ViewControl& packet);
  void take_packet(const cigi::ViewDefinition& packet);
  template <class Request>
  void take_request(const Request& packet);
  void take_packet(const cigi::HatHotRequest& packet) { take_request(packet); }
  void take_packet(const cigi::LosSegmentRequest& packet);
  void take_packet(const cigi::LosVectorRequest& packet);
  // What an IG says; a host's message has none.
  template <class Other>
  void take_packet(const Other&) {}

  int database_;
  bool database_is_other_ = false;  // the host wants one that is not here
  glm::dvec3 half_box_m_;
  Say say_;
  std::uint32_t said_ = 0;  // bits of Lack
  cigi::MessageReader reader_;
  cigi::Version version_{3, 3};
  cigi::Order order_ = cigi::Order::little;
  cigi::IgMode mode_ = cigi::IgMode::standby;
  std::uint32_t host_frame_ = 0;
  std::uint32_t frame_ = 0;
  const Earth* earth_ = nullptr;  // during take()
  std::int64_t arrived_ns_ = 0, newest_ns_ = 0;
  Counts counts_;
  Entities entities_;
  Views views_;
  HostAir air_;
  Answers answers_;
  std::vector<std::byte> out_;
};

}  // namespace karst::ig
