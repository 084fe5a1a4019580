// SPDX-License-Identifier: MIT
#include "ig/program/host_state.h"

#include <bit>
#include <utility>
#include <variant>

#include "platform/base/clock.h"

namespace karst::ig {

static_assert(static_cast<int>(Lack::kCount) <= 32);

HostState::HostState(int database, const ViewLayout& layout, glm::dvec3 half_box_m, Say say)
    : database_(database),
      half_box_m_(half_box_m),
      say_(std::move(say)),
      order_(std::endian::native == std::endian::little ? cigi::Order::little : cigi::Order::big),
      views_(layout),
      out_(cigi::kMaxMessageBytes) {}

void HostState::clear() {
  entities_.clear();
  views_.clear();
  air_.clear();
  answers_.clear();
}

void HostState::lack(Lack what, const char* text) {
  const std::uint32_t bit = std::uint32_t{1} << static_cast<unsigned>(what);
  if ((said_ & bit) != 0) return;
  said_ |= bit;
  say_(text);
}

void HostState::take(std::span<const std::byte> datagram, const Earth& earth, std::int64_t arrived_ns) {
  const cigi::ReadCounts before = reader_.counts();
  if (!reader_.open(datagram, cigi::Speaker::host)) {
    lack(Lack::version, "a datagram is no message of a host of CIGI 3.2, 3.3 or 4.0, and others like it");
    return;
  }
  version_ = reader_.version();
  order_ = reader_.order();
  earth_ = &earth;
  arrived_ns_ = newest_ns_ = arrived_ns;
  cigi::Packet packet;
  while (reader_.next(packet)) std::visit([&](const auto& one) { take_packet(one); }, packet);
  const cigi::ReadCounts& after = reader_.counts();
  lack_where(after.malformed != before.malformed || after.cut != before.cut, Lack::malformed,
             "a message of the host has malformed packets, which are skipped");
}

std::int64_t HostState::take_arrival() {
  return std::exchange(newest_ns_, 0);
}

void HostState::advance(const Earth& earth, Query& query, std::int64_t now_ns) {
  entities_.advance(earth, query, now_ns);
}

std::span<const std::byte> HostState::message(const Earth& earth, Query& query, std::int64_t now_ns,
                                              bool overframing, bool paging) {
  cigi::MessageWriter writer(out_, version_, order_);
  cigi::StartOfFrame start;
  start.database = static_cast<std::int8_t>(database_is_other_ ? -128 : database_);
  start.mode = mode_;
  start.timestamp_valid = true;
  start.overframing = overframing;
  start.paging = paging;
  start.ig_frame = frame_;
  start.timestamp_10us = static_cast<std::uint32_t>(now_ns / 10'000);
  start.last_host_frame = host_frame_;
  if (!writer.write(start)) return {};
  const Surroundings around{&earth, &entities_, &query, half_box_m_};
  query.allow_reads(kAnswerReads);
  counts_.answers += answers_.answer(around, frame_, host_frame_, karst::now_ns() + kAnswer_ns, writer);
  ++frame_;
  return writer.bytes();
}

// --- packets

void HostState::take_packet(const cigi::IgControl& packet) {
  host_frame_ = packet.host_frame;
  if (packet.database != 0) {
    database_is_other_ = packet.database != database_;
    lack_where(database_is_other_, Lack::database,
               "the host wants a database of another number; --database says which this world is");
  }
  const cigi::IgMode mode = packet.mode == cigi::IgMode::offline ? cigi::IgMode::standby : packet.mode;
  if (mode == cigi::IgMode::standby && mode_ != cigi::IgMode::standby) clear();
  mode_ = mode;
}

void HostState::take_packet(const cigi::EntityControl& packet) {
  lack_where(!entities_.take(packet), Lack::entities, "more than 1,024 entities: others are not drawn");
  lack_where(packet.collision_detection, Lack::collision, "collisions of entities are not told");
  lack_where(packet.animation != cigi::AnimationState::stop, Lack::animation,
             "entities are boxes: no motion");
}

void HostState::take_packet(const cigi::EntityPosition& packet) {
  lack_where(!entities_.take(packet, arrived_ns_), Lack::entities,
             "more than 1,024 entities: others are not drawn");
}

void HostState::take_packet(const cigi::RateControl& packet) {
  entities_.take(packet, *earth_, arrived_ns_);
  lack_where(packet.of_part, Lack::parts, "entities are boxes without parts: these do not move");
}

void HostState::take_packet(const cigi::ComponentControl&) {
  lack(Lack::components, "Component Control changes nothing here");
}

void HostState::take_packet(const cigi::CelestialSphereControl& packet) {
  air_.take(packet, arrived_ns_);
  lack_where(packet.stars, Lack::moon_and_stars, "stars are not drawn");
}

void HostState::take_packet(const cigi::AtmosphereControl& packet) {
  air_.take(packet);
  lack_where(packet.model, Lack::wind, "of Atmosphere Control the visibility is drawn, and nothing else");
}

void HostState::take_packet(const cigi::WeatherControl& packet) {
  lack_where(!air_.take(packet), Lack::weather,
             "of Weather Control the visibility of global layers is drawn: no clouds, no regions");
}

void HostState::take_packet(const cigi::ViewControl& packet) {
  lack_where(!views_.take(packet), Lack::view,
             "View Control names a view or a group that is not here; --views says which are");
}

void HostState::take_packet(const cigi::ViewDefinition& packet) {
  bool bad = false;
  lack_where(!views_.take(packet, bad), Lack::group_or_view,
             "View Definition names a view that is not here; --views says which are");
  lack_where(bad, Lack::half_angles,
             "View Definition has half-angles or distances that make no picture; the view stays as it was");
  lack_where(packet.pixel_replication != 0 || packet.reorder, Lack::view_extras,
             "pixels are not replicated, and views not laid over each other");
}

template <class Request>
void HostState::take_request(const Request& packet) {
  ++counts_.requests;
  lack_where(!answers_.take(packet, frame_), Lack::requests,
             "more than 8,192 requests wait or come again: others are not answered");
}

void HostState::take_packet(const cigi::LosSegmentRequest& packet) {
  take_request(packet);
  lack_where(packet.extended, Lack::material, "answers tell no material codes");
}

void HostState::take_packet(const cigi::LosVectorRequest& packet) {
  take_request(packet);
  lack_where(packet.extended, Lack::material, "answers tell no material codes");
}

}  // namespace karst::ig
