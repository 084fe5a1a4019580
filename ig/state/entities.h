// SPDX-License-Identifier: MIT
// Entities of a host: what it last said of each, and where they are at a time. The number of them is fixed at
// the start; nothing is allocated later.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ig/cigi/packets.h"
#include "ig/place/earth.h"
#include "karst/query.h"

namespace karst::ig {

struct Entity {
  std::uint16_t id = 0;
  cigi::EntityControl control;
  cigi::EntityPosition position;  // at `since`
  cigi::RateControl rate;
  bool has_position = false;
  bool has_rate = false;
  std::int64_t since_ns = 0;
  // What it stood on when the ground was last asked.
  bool has_ground = false;
  double ground_altitude_m = 0;
  glm::dvec3 ground_normal{0.0};

  // Of the time that advance() was last called for.
  Body body;
  bool is_placed = false;  // body is known
  bool is_seen = false;    // active, placed, of a type that is drawn, and so are all that it is attached to
  float alpha = 1;
  std::uint32_t visit = 0;
};

class Entities {
 public:
  static constexpr std::size_t kMost = 1024;
  static constexpr int kMostParents = 16;  // above one another
  // The ground is asked for this long a frame, and of as many reads of the file; the others' turn is in the
  // next: until then they stay as high as the ground was under them.
  static constexpr std::int64_t kGround_ns = 2'000'000;
  static constexpr std::uint32_t kGroundReads = 8;

  Entities();
  void clear();

  // False: there is no room for another entity.
  bool take(const cigi::EntityControl& control);
  bool take(const cigi::EntityPosition& position, std::int64_t now_ns);
  // Of parts: nothing. Of entities that the host has not told of: nothing.
  void take(const cigi::RateControl& rate, const Earth& earth, std::int64_t now_ns);

  // Places of all. query: of the ground, for those that are clamped to it.
  void advance(const Earth& earth, Query& query, std::int64_t now_ns);

  const Entity* find(std::uint16_t id) const;
  std::span<const Entity> all() const { return {entities_.data(), count_}; }
  std::size_t grounds_asked() const { return grounds_; }  // by the last advance()

 private:
  static constexpr std::uint16_t kNone = 0xffff;

  Entity* own(std::uint16_t id);
  Entity* find_or_add(std::uint16_t id);
  void remove(std::uint16_t id);
  void place(Entity& entity, const Earth& earth, Query& query, std::int64_t now_ns, int parents);
  bool find_ground(Entity& entity, const Earth& earth, Query& query, glm::dvec3 place);

  std::vector<Entity> entities_;
  std::vector<std::uint16_t> slots_;  // by id
  std::size_t count_ = 0;
  std::uint32_t visit_ = 0;
  std::size_t turn_ = 0;           // whose ground is asked first
  std::int64_t ground_until_ = 0;  // of advance()
  std::size_t grounds_ = 0;        // that it has asked
};

}  // namespace karst::ig
