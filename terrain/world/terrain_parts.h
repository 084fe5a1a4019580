// SPDX-License-Identifier: MIT
// The parts that choose and make what is drawn, in one piece of memory of stated size: for whoever wants all
// of them. Exactly terrain_budget() bytes are taken in create(); from then on nothing is allocated.
//
//   Config config = World::config_for(info, info.level);          // or a board's limits
//   std::vector<std::byte> memory(terrain_budget(config).cpu_bytes() + alignment);
//   TerrainParts parts;
//   parts.create(config, memory);  parts.load(source);
//   parts.residency.begin_frame();  parts.residency.select(parts.views_of(2), requests);  ...
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/budget.h"
#include "terrain/base/check.h"
#include "terrain/base/config.h"
#include "terrain/blocks/isosurface.h"
#include "terrain/imagery/imagery.h"
#include "terrain/world/ground.h"
#include "terrain/world/residency.h"
#include "terrain/world/shadow_casters.h"
#include "terrain/world/view_state.h"
#include "terrain/world/world.h"

namespace karst::core {

// Exact bytes of the CPU side; the renderer adds its GPU terms. kUnbounded terms where they do not fit
// size_t.
Budget terrain_budget(const Config& config);

struct TerrainParts {
  // memory: borrowed for the parts' life, aligned to Arena::kAlignment, at least
  // terrain_budget(config).cpu_bytes(). Uses exactly that many. invalid_argument, limit_reached ("memory",
  // bytes needed).
  Status create(const Config& config, std::span<std::byte> memory);
  // World::load() and attaching the others to it. After a failure the world is empty.
  Status load(const ByteSource& source);
  Status load(const WorldReader& opened);
  Status load(std::span<const std::byte> file) { return load(ByteSource::of(file)); }

  // Precondition: count <= Config::max_views.
  std::span<ViewState> views_of(std::size_t count) {
    KARST_ASSERT(count <= world.config().max_views);
    return std::span(views).first(count);
  }

  // The others to the world, whatever became of it.
  Status attach(const Status& loaded);

  World world;
  Residency residency;
  Ground ground;          // nothing is attached to it by load(): whoever reads tiles does
  Imagery imagery;        // the same
  Isosurface isosurface;  // of world.field(), to be attached when its samples are there
  ShadowCasters casters;
  std::array<ViewState, kMostViews> views;  // those beyond Config::max_views have no memory
  Arena arena{{}};
};

}  // namespace karst::core
