// SPDX-License-Identifier: MIT
// From needs and a file's head to limits, bytes, and where in World::create()'s memory everything lies. One
// function makes it, for planning and for creating, so that the two cannot differ.
#pragma once

#include <cstddef>
#include <cstdint>

#include "karst/plan.h"
#include "karst/world.h"
#include "renderer/input/settings.h"
#include "terrain/base/budget.h"
#include "terrain/base/config.h"
#include "terrain/edit/ground/edit_ground.h"
#include "terrain/file/byte_source.h"
#include "terrain/file/world_file.h"
#include "terrain/file/world_reader.h"
#include "terrain/query/query.h"

namespace karst::core {

// The source must outlive what it returns.
ByteSource byte_source(const Source& source);

struct PlanLayout {
  Config config;
  RendererSettings renderer;  // what GL's part takes; without GlOptions
  Budget budget;
  Query::Limits query_limits;
  EditGround::Limits edit_limits;
  bool holds_all_heights = false;

  // Of the memory, in this order, each of whole cache lines.
  std::size_t objects_bytes = 0;  // WorldObject, the renderer and the queries themselves
  std::size_t staging_bytes = 0;  // of a texture on its way to the GPU
  std::size_t terrain_bytes = 0;
  std::size_t reading_bytes = 0;  // of tiles of the ground
  std::size_t edit_bytes = 0;     // of edits of the ground
  std::size_t undo_bytes = 0;     // of steps of edits
  std::size_t query_bytes = 0;    // of one query; there are needs.queries

  std::uint64_t cpu_bytes() const;
};

// What of a file decides the limits.
struct PlannedWorld {
  WorldInfo info;
  MaterialSet materials;  // count 0: none
  GroundInfo ground;      // does not exist: none
  ImageryInfo imagery;    // the same
  FieldInfo field;        // the same

  static PlannedWorld of(const WorldReader& reader) {
    return {reader.info(), reader.materials(), reader.ground(), reader.imagery(), reader.field()};
  }
};
// invalid_argument naming the field of needs.
Status lay_out(const PlannedWorld& world, const Needs& needs, PlanLayout& layout);

// Of the object that a renderer lives in (scene/frame).
std::size_t renderer_object_bytes();

// Of WorldObject, a renderer and so many queries (world_object.cpp).
std::size_t objects_bytes(std::uint32_t queries);

// What the public header says of a world.
karst::WorldInfo public_info(const WorldReader& reader);

// Readers in heads, without their sources. read_from(): false where the head holds none.
void store_reader(const WorldReader& reader, Head& head);
bool read_from(const Head& head, WorldReader& reader);

}  // namespace karst::core
