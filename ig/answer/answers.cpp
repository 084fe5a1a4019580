// SPDX-License-Identifier: MIT
#include "ig/answer/answers.h"

#include <algorithm>

#include "platform/base/clock.h"

namespace karst::ig {
namespace {

constexpr std::size_t kBetweenClocks = 16;  // answers

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

bool write_answer(const cigi::HatHotRequest& request, const Surroundings& around, std::uint8_t host_frame_low,
                  cigi::MessageWriter& writer) {
  cigi::HatHotExtendedResponse found = find_height(request, around);
  found.host_frame_low = host_frame_low;
  return request.type == cigi::HatHotType::extended ? writer.write(found)
                                                    : writer.write(plain(found, request.type));
}

template <class Los>
bool write_answer(const Los& request, const Surroundings& around, std::uint8_t host_frame_low,
                  cigi::MessageWriter& writer) {
  cigi::LosExtendedResponse found = find_sight(request, around);
  found.host_frame_low = host_frame_low;
  return request.extended ? writer.write(found) : writer.write(plain(found));
}

}  // namespace

Answers::Answers() : entries_(kMost) {
  for (std::vector<std::uint16_t>& slots : slots_) slots.assign(65'536, kNone);
}

void Answers::clear() {
  for (std::size_t n = 0; n < count_; ++n) slot_of(entries_[n].request) = kNone;
  count_ = next_ = 0;
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
  entries_[slot] = {request, frame, period, false};
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

std::size_t Answers::answer(const Surroundings& around, std::uint32_t frame, std::uint32_t host_frame,
                            std::int64_t until_ns, cigi::MessageWriter& writer) {
  const auto low = static_cast<std::uint8_t>(host_frame & 15);
  std::size_t answered = 0;
  std::size_t seen = 0;
  for (; seen < count_; ++seen) {
    Entry& entry = entries_[(next_ + seen) % count_];
    // Frames are counted round.
    if (static_cast<std::int32_t>(frame - entry.due) < 0) continue;
    if (writer.room() < cigi::kMaxPacketBytes) break;
    if (answered % kBetweenClocks == kBetweenClocks - 1 && now_ns() > until_ns) break;
    const bool written = std::visit(
        [&](const auto& request) { return write_answer(request, around, low, writer); }, entry.request);
    if (!written) break;
    ++answered;
    entry.done = entry.period == 0;
    entry.due = frame + entry.period;
  }
  next_ = count_ == 0 ? 0 : (next_ + seen) % count_;
  drop_done();
  return answered;
}

// The others keep their order, and their turn.
void Answers::drop_done() {
  std::size_t kept = 0;
  std::size_t next = 0;
  for (std::size_t n = 0; n < count_; ++n) {
    if (n == next_) next = kept;
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
  next_ = count_ == 0 ? 0 : next % count_;
}

}  // namespace karst::ig
