// SPDX-License-Identifier: MIT
// Writes a .karst file piece by piece into a sink, so that no second copy of a world is needed: sections go
// out as they lie in memory, and what is encoded goes through a small buffer. Everything is gone through
// twice, because the table in front of the sections holds their checksums.
//
//   WorldWriter writer{info, &octree, patches, materials};
//   if (const Status status = writer.run(ByteSink::to(append)); !status.ok()) ...
#pragma once

#include <cstdint>

#include "karst/status.h"
#include "terrain/field/octree.h"
#include "terrain/file/byte_source.h"
#include "terrain/file/world_file.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::core {

struct WorldWriter {
  // Inputs, borrowed.
  WorldInfo info;
  const Octree* octree = nullptr;
  WorldPatches patches;
  WorldMaterials materials = WorldMaterials();
  WorldGround ground = WorldGround();
  // Of the ground's regions, in their order; empty: octree alone.
  std::span<const Octree* const> octrees = {};
  const FieldBlocks* field = nullptr;  // null, or nothing in it: the world has none

  // invalid_argument: a field is out of range or contradicts another (the rules of reading). The octree's
  // nodes are checked by run() alone.
  Status validate() const;

  // Length of the file. Precondition: validate() is ok.
  std::uint64_t file_bytes() const;
  // Where the tiles begin: behind the head, whose length depends on which sections there are alone.
  // Precondition: there is a ground.
  std::uint64_t tiles_begin() const;

  // As validate(), and "octree" where it is not as info states: then nothing is written. limit_reached
  // ("sink") where the sink does not take the bytes: it holds part of the file then.
  // invalid_argument ("ground") where there is one.
  Status run(const ByteSink& sink) const;

  // The same of a world with a ground, whose tiles the caller writes, between the two: head takes what is
  // before tiles_begin(), tail what follows ground.tile_bytes later.
  Status run_around(const ByteSink& head, const ByteSink& tail) const;

 private:
  Status check_octrees() const;
  Status put_all(const ByteSink& head, const ByteSink& tail) const;
  std::uint64_t field_bytes() const;
};

}  // namespace karst::core
