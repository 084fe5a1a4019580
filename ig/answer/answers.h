// SPDX-License-Identifier: MIT
// Heights (HAT/HOT) and lines of sight (LOS) that a host asks for, once or every few frames, answered by
// karst's queries. As many requests as there is room for wait their turn; nothing is allocated after the
// start.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "ig/cigi/message_writer.h"
#include "ig/state/entities.h"
#include "karst/query.h"

namespace karst::ig {

// What the answers are about.
struct Surroundings {
  const Earth* earth = nullptr;
  const Entities* entities = nullptr;  // placed for the frame
  Query* query = nullptr;
  glm::dvec3 half_box_m{0.0};  // of entities: along, across, down
};

class Answers {
 public:
  static constexpr std::size_t kMost = 8192;  // requests that wait or come again
  // What wants more of the file than a frame may read has its turn again; so often, and then its answer is
  // not valid.
  static constexpr int kMostTries = 32;

  Answers();
  void clear();

  // A request of the same kind and number that is waiting or comes again is forgotten. False: no room.
  bool take(const cigi::HatHotRequest& request, std::uint32_t frame);
  bool take(const cigi::LosSegmentRequest& request, std::uint32_t frame);
  bool take(const cigi::LosVectorRequest& request, std::uint32_t frame);

  // Answers what is due in this frame until the time or the writer's room is at its end; what is left is due
  // in the next. Those that have waited longest come first, of those the ones that lie close together one
  // after the other. One is tried whatever the time is. Returns how many were answered.
  std::size_t answer(const Surroundings& around, std::uint32_t frame, std::uint32_t host_frame,
                     std::int64_t until_ns, cigi::MessageWriter& writer);
  std::size_t waiting() const { return count_; }

 private:
  using Request = std::variant<cigi::HatHotRequest, cigi::LosSegmentRequest, cigi::LosVectorRequest>;
  struct Entry {
    Request request;
    std::uint32_t due = 0;    // frame
    std::uint8_t period = 0;  // 0: once
    std::uint8_t tries = 0;
    bool done = false;
  };
  static constexpr std::uint16_t kNone = 0xffff;

  bool take(const Request& request, bool los, std::uint16_t id, std::uint8_t period, std::uint32_t frame);
  std::size_t make_order(std::uint32_t frame);
  void drop_done();
  std::uint16_t& slot_of(const Request& request);

  std::vector<Entry> entries_;
  std::vector<std::uint16_t> slots_[2];  // by number: HAT/HOT, LOS
  std::size_t count_ = 0;
  std::vector<std::uint64_t> order_;  // of what is due
};

// The answers alone.
cigi::HatHotExtendedResponse find_height(const cigi::HatHotRequest& request, const Surroundings& around);
cigi::LosExtendedResponse find_sight(const cigi::LosSegmentRequest& request, const Surroundings& around);
cigi::LosExtendedResponse find_sight(const cigi::LosVectorRequest& request, const Surroundings& around);

}  // namespace karst::ig
