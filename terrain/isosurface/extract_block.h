// SPDX-License-Identifier: MIT
// The surface of one block of 16^3 cells of a scalar field, at a level whose cells are 2^level samples wide:
// modified marching cubes within (L 3.2), transition cells on sides towards blocks of half the cells (L 4.3).
// Blocks of an octree close against each other, each inner edge once from each side with equal bits, where
// neighbours differ by one level at most and, of four blocks around an edge, finer ones are never just the
// two that are diagonal (those would touch themselves along the edge).
//
// A vertex lies where the finest data have the crossing of its edge, whatever the level (L 4.2.1), so that
// resolutions agree. Vertices near a side with transition cells make place for them: they go a fourth of a
// cell away from it, along their tangent plane (L 4.4), except those that a block sees which does not.
//
//   ExtractBlock<std::int8_t> extract;
//   extract.field = &field;  extract.corner = {32, 0, 64};  extract.level = 1;  extract.around = ...;
//   extract.vertices = ...;  extract.triangles = ...;
//   extract.run(room, result);
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/field/scalar_field.h"
#include "terrain/isosurface/edge_place.h"
#include "terrain/isosurface/field_materials.h"

namespace karst::core {

inline constexpr int kIsoMaxLevel = 8;

struct IsoVertex {
  std::int16_t place[3];    // from the block's corner, 1 / kIsoStepsPerCell of its level's cell
  std::uint16_t normal;     // octahedral.h, towards the air
  std::int16_t primary[3];  // where it would be without transition cells
  std::uint16_t material;   // code of the solid one of the finest two samples beside it (field_materials.h)

  friend bool operator==(const IsoVertex&, const IsoVertex&) = default;
};
static_assert(sizeof(IsoVertex) == 16);

// What lies in a place of the block's size beside it.
enum class IsoNeighbour : std::uint8_t {
  same,    // a block of the level, or nothing at all
  finer,   // blocks of the next finer level
  coarser  // a part of a block of the next coarser level
};

template <class Sample>
struct ExtractBlock {
  // Inputs, borrowed.
  const ScalarField<Sample>* field = nullptr;
  const FieldMaterials* materials = nullptr;  // of as many blocks; null: all vertices have 0
  glm::ivec3 corner{0};                       // samples; a multiple of 16 << level
  int level = 0;                              // 0..kIsoMaxLevel
  // (x + 1) + 3 (y + 1) + 9 (z + 1) for the place at (x, y, z), each -1..1.
  std::array<IsoNeighbour, 27> around{};
  // Of a field in a ground, the sides of its region that the block ends at: bit 0 west, 1 south, 2 east, 3
  // north. Vertices in them stay there, and beyond them the field goes on as it changes at them.
  unsigned sides = 0;

  // Outputs, borrowed.
  std::span<IsoVertex> vertices;
  std::span<std::uint16_t> triangles;  // three a triangle, counter-clockwise as seen from the air

  struct Result {
    std::uint32_t vertices = 0;
    std::uint32_t triangles = 0;
    std::uint32_t first_transition_triangle = 0;
  };
  struct Room;
  static std::size_t room_bytes();  // aligned to 16

  // invalid_argument naming the field. limit_reached ("vertices", "triangles", with what was asked for when
  // it ran out): the outputs hold nothing of use.
  Status run(std::span<std::byte> room, Result& result) const;
};

extern template struct ExtractBlock<std::int8_t>;
extern template struct ExtractBlock<std::int16_t>;

}  // namespace karst::core
