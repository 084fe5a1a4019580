// SPDX-License-Identifier: MIT
#include "ig/answer/answers.h"

#include <algorithm>
#include <cmath>

#include "platform/base/clock.h"

namespace karst::ig {
namespace {

constexpr std::size_t kBetweenClocks = 4;  // answers

cigi::HatHotResponse plain(const cigi::HatHotExtendedResponse& found, cigi::HatHotType type) {
  cigi::HatHotResponse response;
  response.id = found.id;
  response.valid = found.valid;
  response.type = type;
  response.host_frame_low = found.host_frame_low;
  response.height_m = type == cigi::HatHotType::hat ? found.hat_m : found.hot_m;
  return response;
}

cigi::LosResponse plain(const cigi::LosExtendedResponse& found) {
  cigi::LosResponse response;
  response.id = found.id;
  response.valid = found.valid;
  response.entity_valid = found.entity_valid;
  response.visible = found.visible;
  response.host_frame_low = found.host_frame_low;
  response.responses = found.responses;
  response.entity = found.entity;
  response.range_m = found.range_m;
  return response;
}

enum class Written : std::uint8_t { yes, no_room, unread };

// last: it is answered, whatever could be read of the file.
Written write_answer(const cigi::HatHotRequest& request, const Surroundings& around,
                     std::uint8_t host_frame_low, bool last, cigi::MessageWriter& writer) {
  const std::uint64_t refused = around.query->refused_reads();
  cigi::HatHotExtendedResponse found = find_height(request, around);
  if (!last && around.query->refused_reads() != refused) return Written::unread;
  found.host_frame_low = host_frame_low;
  const bool written = request.type == cigi::HatHotType::extended ? writer.write(found)
                                                                  : writer.write(plain(found, request.type));
  return written ? Written::yes : Written::no_room;
}

template <class Los>
Written write_answer(const Los& request, const Surroundings& around, std::uint8_t host_frame_low, bool last,
                     cigi::MessageWriter& writer) {
  const std::uint64_t refused = around.query->refused_reads();
  cigi::LosExtendedResponse found = find_sight(request, around);
  if (!last && around.query->refused_reads() != refused) return Written::unread;
  found.host_frame_low = host_frame_low;
  const bool written = request.extended ? writer.write(found) : writer.write(plain(found));
  return written ? Written::yes : Written::no_room;
}

// A bit after each of 20.
std::uint64_t spread(std::uint32_t bits) {
  std::uint64_t out = bits;
  out = (out | out << 16) & 0x0000ffff0000ffffu;
  out = (out | out << 8) & 0x00ff00ff00ff00ffu;
  out = (out | out << 4) & 0x0f0f0f0f0f0f0f0fu;
  out = (out | out << 2) & 0x3333333333333333u;
  return (out | out << 1) & 0x5555555555555555u;
}

std::uint32_t twenty_bits(double turns) {
  constexpr double kMost = (1 << 20) - 1;
  return static_cast<std::uint32_t>(std::clamp((turns + 0.5) * kMost, 0.0, kMost));
}

// Numbers that are alike where places are: of latitude and longitude 20 bits each, one of each in turn.
std::uint64_t place_number(cigi::CoordinateSystem system, std::uint16_t entity, double x, double y) {
  if (system != cigi::CoordinateSystem::geodetic) return entity;
  return spread(twenty_bits(x / 180)) << 1 | spread(twenty_bits(std::remainder(y / 360, 1.0)));
}
std::uint64_t place_number(const cigi::HatHotRequest& r) {
  return place_number(r.system, r.entity, r.latitude_deg_or_x_m, r.longitude_deg_or_y_m);
}
std::uint64_t place_number(const cigi::LosSegmentRequest& r) {
  return place_number(r.source, r.entity, r.source_latitude_deg_or_x_m, r.source_longitude_deg_or_y_m);
}
std::uint64_t place_number(const cigi::LosVectorRequest& r) {
  return place_number(r.source, r.entity, r.source_latitude_deg_or_x_m, r.source_longitude_deg_or_y_m);
}

}  // namespace

Answers::Answers() : entries_(kMost), order_(kMost) {
  for (std::vector<std::uint16_t>& slots : slots_) slots.assign(65'536, kNone);
}

void Answers::clear() {
  for (std::size_t n = 0; n < count_; ++n) slot_of(entries_[n].request) = kNone;
  count_ = 0;
}

std::uint16_t& Answers::slot_of(const Request& request) {
  const bool los = !std::holds_alternative<cigi::HatHotRequest>(request);
  return slots_[los ? 1 : 0][std::visit([](const auto& one) { return one.id; }, request)];
}

bool Answers::take(const Request& request, bool los, std::uint16_t id, std::uint8_t period,
                   std::uint32_t frame) {
  std::uint16_t& slot = slots_[los ? 1 : 0][id];
  if (slot == kNone) {
    if (count_ == kMost) return false;
    slot = static_cast<std::uint16_t>(count_++);
  }
  entries_[slot] = {request, frame, period, 0, false};
  return true;
}

bool Answers::take(const cigi::HatHotRequest& request, std::uint32_t frame) {
  return take(request, false, request.id, request.update_period, frame);
}
bool Answers::take(const cigi::LosSegmentRequest& request, std::uint32_t frame) {
  return take(request, true, request.id, request.update_period, frame);
}
bool Answers::take(const cigi::LosVectorRequest& request, std::uint32_t frame) {
  return take(request, true, request.id, request.update_period, frame);
}

// From the top: how long it has waited, less of it being more; where it is; its entry.
std::size_t Answers::make_order(std::uint32_t frame) {
  static_assert(kMost <= 1 << 16);
  std::size_t due = 0;
  for (std::size_t n = 0; n < count_; ++n) {
    const Entry& entry = entries_[n];
    // Frames are counted round.
    const auto late = static_cast<std::int32_t>(frame - entry.due);
    if (late < 0) continue;
    const std::uint64_t place = std::visit([](const auto& one) { return place_number(one); }, entry.request);
    const auto wait = static_cast<std::uint64_t>(255 - std::min(late, 255));
    order_[due++] = wait << 56 | place << 16 | n;
  }
  std::sort(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(due));
  return due;
}

std::size_t Answers::answer(const Surroundings& around, std::uint32_t frame, std::uint32_t host_frame,
                            std::int64_t until_ns, cigi::MessageWriter& writer) {
  const auto low = static_cast<std::uint8_t>(host_frame & 15);
  const std::size_t due = make_order(frame);
  std::size_t answered = 0;
  for (std::size_t n = 0; n < due; ++n) {
    if (writer.room() < cigi::kMaxPacketBytes) break;
    if (n > 0 && n % kBetweenClocks == 0 && now_ns() > until_ns) break;
    Entry& entry = entries_[order_[n] & 0xffff];
    const bool last = entry.tries + 1 >= kMostTries;
    const Written written = std::visit(
        [&](const auto& request) { return write_answer(request, around, low, last, writer); }, entry.request);
    if (written == Written::no_room) break;
    if (written == Written::unread) {
      ++entry.tries;
      if (now_ns() > until_ns) break;
      continue;
    }
    ++answered;
    entry.done = entry.period == 0;
    entry.due = frame + entry.period;
    entry.tries = 0;
  }
  drop_done();
  return answered;
}

// The others keep their order.
void Answers::drop_done() {
  std::size_t kept = 0;
  for (std::size_t n = 0; n < count_; ++n) {
    if (entries_[n].done) {
      slot_of(entries_[n].request) = kNone;
      continue;
    }
    if (kept != n) {
      entries_[kept] = entries_[n];
      slot_of(entries_[kept].request) = static_cast<std::uint16_t>(kept);
    }
    ++kept;
  }
  count_ = kept;
}

}  // namespace karst::ig
