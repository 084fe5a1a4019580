// SPDX-License-Identifier: MIT
// Sculpting of a field in memory (L A.2): a dab adds or takes away a ball, or draws the surface towards a
// plane. Samples stay distances in cells, cut off at FieldInfo::reach_cells. What a dab changes is kept block
// by block, so that it can be taken back and done again, to the bit.
//
//   FieldDab dab{FieldDab::Tool::subtract, place, 4};
//   FieldChange change;
//   sculpt_field(dab, field, kept, change);       // blocks change.first..change.last are to be meshed anew
//   swap_field(field, kept.first(change.kept_bytes), change);  // taken back; once more: done again
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::core {

struct FieldDab {
  enum class Tool : std::uint8_t { add, subtract, slope };

  Tool tool = Tool::add;
  glm::dvec3 place{0};     // cells from sample (0, 0, 0)
  double radius = 4;       // cells, kLeast..kMost
  double strength = 1;     // of a slope, 0..1: how far towards the plane in its middle
  glm::dvec3 up{0, 1, 0};  // of a slope: of length 1, the plane's, which goes through place

  static constexpr double kLeast = 0.5;
  static constexpr double kMost = 64;
};

struct FieldChange {
  // Samples that may have changed, both ends included; first > last: none has.
  glm::ivec3 first{0};
  glm::ivec3 last{-1};
  std::size_t kept_bytes = 0;  // of the blocks that have changed, as they were

  bool any() const { return last.x >= first.x; }
};

// kept: room for the blocks as they were; empty: they are not kept. Precondition: field.exists().
// invalid_argument naming the dab's field; limit_reached ("field_sample_blocks", value: blocks that are
// missing; "kept", value: bytes that are needed). Nothing has changed then.
Status sculpt_field(const FieldDab& dab, FieldBlocks& field, std::span<std::byte> kept, FieldChange& change);

// Exchanges the blocks that sculpt_field() kept with those that are there. Precondition: the field is as it
// was after the dab, or before it; then it does not fail.
void swap_field(FieldBlocks& field, std::span<std::byte> kept, FieldChange& change);

}  // namespace karst::core
