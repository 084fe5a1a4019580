// SPDX-License-Identifier: MIT
#include "terrain/world/terrain_parts.h"

namespace karst::core {

Budget terrain_budget(const Config& config) {
  Budget budget;
  World::add_to(budget, config);
  Residency::add_to(budget, config);
  Ground::add_to(budget, config);
  Imagery::add_to(budget, config);
  Isosurface::add_to(budget, config);
  ShadowCasters::add_to(budget, config);
  for (std::uint32_t v = 0; v < config.max_views; ++v) ViewState::add_to(budget, config);
  return budget;
}

Status TerrainParts::create(const Config& config, std::span<std::byte> memory) {
  if (const Status status = config.validate(); !status.ok()) return status;
  const std::size_t needed = terrain_budget(config).cpu_bytes();
  if (needed > memory.size())
    return {StatusCode::limit_reached, "the memory given is smaller than the budget", "memory", needed};
  if (reinterpret_cast<std::uintptr_t>(memory.data()) % Arena::kAlignment != 0) {
    return {StatusCode::invalid_argument, "the memory given is not aligned to 64 bytes", "memory"};
  }
  arena = Arena(memory.first(needed));
  Status status = world.create(config, arena);
  if (status.ok()) status = residency.create(config, arena);
  if (status.ok()) status = ground.create(config, arena);
  if (status.ok()) status = imagery.create(config, arena);
  if (status.ok()) status = isosurface.create(config, arena);
  if (status.ok()) status = casters.create(config, arena);
  for (std::size_t v = 0; v < config.max_views && status.ok(); ++v) status = views[v].create(config, arena);
  KARST_ASSERT(!status.ok() || arena.used() == needed);
  arena.freeze();
  return status;
}

Status TerrainParts::load(const ByteSource& source) {
  return attach(world.load(source));
}

Status TerrainParts::load(const WorldReader& opened) {
  return attach(world.load(opened));
}

Status TerrainParts::attach(const Status& loaded) {
  ground.detach();
  imagery.detach();
  FieldRegion region;
  if (const int part = world.field_part(); part >= 0) {
    region.corner = world.field_corner();
    region.column = std::int64_t{kStepsPerVoxel} << world.ground().lattice_size;
  }
  isosurface.attach(world.field(), region);
  const Status attached = residency.attach(world);
  for (ViewState& view : views_of(world.config().max_views)) view.attach(world);
  return loaded.ok() ? attached : loaded;
}

}  // namespace karst::core
