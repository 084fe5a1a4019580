// SPDX-License-Identifier: MIT
#include "scene/edit/ground_edits.h"

#include <algorithm>
#include <bit>

#include "terrain/edit/patch/edit_heights.h"
#include "terrain/edit/regions/region_growth.h"
#include "terrain/edit/shape/edit_shape.h"

namespace karst::core {

Status edit_ground(WorldObject& world, const Edit& edit, UndoLog* log, GroundChange& change,
                   std::uint32_t& nodes) {
  change = {};
  nodes = 0;
  if (world.ground_edits == nullptr)
    return {StatusCode::limit_reached, "there is no room for edits of the ground", "edit_tiles", 1};
  if (const Status status = world.ground_edits->apply(edit, log, change, world.terrain.world.is_editable());
      !status.ok())
    return status;
  nodes = show_ground_change(world, change);
  return {};
}

Status reserve_region(WorldObject& world, const Edit& edit) {
  const World& terrain = world.terrain.world;
  std::size_t part = 0;
  if (const Status status = part_of_edit(edit, terrain, part); !status.ok()) return status;
  if (world.ground_edits == nullptr) {
    return {StatusCode::limit_reached, "there is no room for what edits of a region change of the ground",
            "edit_tiles", 1};
  }
  return world.ground_edits->reserve_region(part);
}

Status plan_heights(WorldObject& world, const Edit& edit, std::uint32_t& regions) {
  regions = 0;
  World& terrain = world.terrain.world;
  if (terrain.ground().region_count == 0 || !terrain.is_editable() || world.ground_edits == nullptr)
    return {};
  EditGround& edits = *world.ground_edits;
  if (const Status status = edits.check(edit); !status.ok()) return status;
  std::uint32_t reached = edits.regions_reached(edit);
  for (std::size_t n = 0; n < terrain.parts().size(); ++n) {
    std::size_t patches = 0;
    if (const Status status = try_heights(terrain, n, edit, patches); !status.ok()) return status;
    if (patches > 0) regions |= 1u << n;
  }
  reached |= regions;
  for (std::size_t n = 0; n < terrain.parts().size(); ++n) {
    if ((reached >> n & 1u) == 0) continue;
    if (const Status status = edits.reserve_region(n); !status.ok()) return status;
  }
  return {};
}

LatticeBox box_in_region(const WorldObject& world, std::size_t region, const GroundChange& change) {
  const GroundInfo& info = world.ground_edits->info();
  const GridRect beneath = samples_of(info.regions()[region]);
  const glm::ivec3 corner = world.terrain.world.parts()[region].corner * kStepsPerVoxel;
  LatticeBox box{};
  for (int axis = 0; axis < 2; ++axis) {
    const auto at = [&](std::int64_t sample) {
      return static_cast<std::int32_t>(sample_place(info, axis, sample) * kVertexStep) - corner[2 * axis];
    };
    box.min[2 * axis] = at(std::max(change.samples.low[axis] - 1, beneath.low[axis]));
    box.max[2 * axis] = at(std::min(change.samples.high[axis] + 1, beneath.high[axis]));
  }
  box.min.y = kVertexStep * change.least - corner.y;
  box.max.y = kVertexStep * change.greatest - corner.y;
  return box;
}

void settle_ground(WorldObject& world) {
  GroundChange change;
  world.ground_edits->settle_some(change);
  world.ground_edits->show_measures(change, world.terrain.ground);
}

namespace {

bool set_growth(WorldObject& world, std::size_t region, const RegionGrowth& growth, UndoLog* log) {
  GroundChange grown;
  world.ground_edits->grow_region(region, growth, log, grown);
  show_ground_change(world, grown);
  return grown.changed;
}

// Its columns are looked at anew.
bool set_loose(WorldObject& world, std::size_t region, const RegionGrowth& growth, UndoLog* log) {
  EditorObject& editor = world.editor;
  const std::uint32_t bit = 1u << region;
  editor.loose = growth.exists() ? editor.loose | bit : editor.loose & ~bit;
  if (editor.columns.region == region) editor.columns = {};
  return set_growth(world, region, growth, log);
}

}  // namespace

bool grow_region(WorldObject& world, std::size_t region, const LatticeBox& box, UndoLog* log) {
  return set_loose(world, region,
                   FindRegionGrowth{&world.terrain.world, world.ground_edits, region, box}.run(), log);
}

bool measure_region(WorldObject& world, std::size_t region) {
  RegionGrowth growth = world.ground_edits->growth(region);
  growth.now = FindRegionGrowth{&world.terrain.world, world.ground_edits, region, {}}.now(growth);
  return set_loose(world, region, growth, nullptr);
}

bool measure_columns(WorldObject& world) {
  std::uint32_t& loose = world.editor.loose;
  ColumnsOfRegion& columns = world.editor.columns;
  const auto region = static_cast<std::size_t>(std::countr_zero(loose));
  if (columns.region != region) columns = {};
  columns.region = region;
  const FindRegionGrowth find{&world.terrain.world, world.ground_edits, region, {}};
  if (!find.step(columns)) return false;
  const RegionGrowth growth = find.run(columns);
  columns = {};
  loose &= loose - 1;
  return set_growth(world, region, growth, nullptr);
}

void show_belt(WorldObject& world, std::size_t region) {
  const GroundRegion& of = world.terrain.world.find_belt(region);
  world.terrain.ground.set_belt(region, of.belt_low, of.belt_high);
}

std::uint32_t show_ground_change(WorldObject& world, const GroundChange& change) {
  if (!change.changed) return 0;
  const EditGround& edits = *world.ground_edits;
  const GroundInfo& info = edits.info();
  world.terrain.world.set_ground_heights(info.low, info.high);
  for (QueryObject& query : world.queries) {
    query.asked.set_ground_heights(info.low, info.high);
    for (const EditedTile& tile : edits.overlay().tiles()) {
      if (tile.stamp == change.stamp) query.asked.forget_tile(tile.key);
    }
  }
  return edits.show(change, world.terrain.ground);
}

}  // namespace karst::core
