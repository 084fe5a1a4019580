// SPDX-License-Identifier: MIT
#include "scene/edit/dig_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>

#include "scene/edit/ground_edits.h"
#include "terrain/base/check.h"
#include "terrain/edit/brush.h"
#include "terrain/edit/shape/edit_shape.h"

namespace karst::core {
namespace {

// From a brush to the region's sides, whose outermost voxels stay, and beyond which gradients look.
constexpr double kAround = kSideVoxels + 1;
// Room that is left for what is dug deeper, or filled higher.
constexpr int kBelow = 16, kAbove = 8;

Status refuse(const char* what) {
  return {StatusCode::invalid_argument, what, "place"};
}

// How many voxels wide what an edit takes as a whole is.
std::int64_t side_of_voxel(const Edit& edit) {
  if (edit.shape != BrushShape::voxel) return 1;
  return std::int64_t{1} << std::max(edit.octree_depth - edit.octree_level, 0);
}

// Of voxels, of the lattice that a new region's octree has there: make_region_for() sees to that.
BrushBox box_of(const Edit& edit) {
  if (edit.shape != BrushShape::voxel) return brush_box(edit);
  const auto side = static_cast<double>(side_of_voxel(edit));
  const glm::dvec3 low = glm::floor(edit.place / side) * side;
  return {low, low + side};
}

double floor_to(double value, std::int64_t unit) {
  const auto of = static_cast<double>(unit);
  return std::floor(value / of) * of;
}

// side: the octree's corner is on a lattice of it.
bool find_nodes(const GroundInfo& info, const BrushBox& box, std::int64_t side, NodeRect& nodes) {
  const std::int64_t together = std::max<std::int64_t>(side >> info.lattice_size, 1);
  for (int axis = 0; axis < 2; ++axis) {
    const double node = std::ldexp(1.0, info.lattice_size);
    const double low = floor_to(std::floor((box.low[2 * axis] - 0.5 - kAround) / node), together);
    const double high = std::ceil((box.high[2 * axis] - 0.5 + kAround) / node);
    if (!(low >= 1 && high * kNodeQuads < static_cast<double>(info.samples[axis] - 1))) return false;
    nodes.low[axis] = static_cast<std::int32_t>(low);
    nodes.high[axis] = static_cast<std::int32_t>(high);
  }
  return true;
}

bool is_apart(const GroundInfo& info, const NodeRect& nodes) {
  return std::ranges::all_of(info.regions(), [&](const GroundRegion& other) {
    for (int axis = 0; axis < 2; ++axis) {
      if (nodes.high[axis] < other.nodes.low[axis] || other.nodes.high[axis] < nodes.low[axis]) return true;
    }
    return false;
  });
}

// Of the ground's samples in the nodes, voxels.
Status find_heights(EditGround& ground, const NodeRect& nodes, double& low, double& high) {
  low = std::numeric_limits<double>::infinity();
  high = -low;
  for (std::int64_t k = std::int64_t{nodes.low[1]} * kNodeQuads;
       k <= std::int64_t{nodes.high[1]} * kNodeQuads; ++k) {
    for (std::int64_t i = std::int64_t{nodes.low[0]} * kNodeQuads;
         i <= std::int64_t{nodes.high[0]} * kNodeQuads; ++i) {
      std::int32_t height = 0;
      if (const Status status = ground.height(i, k, height); !status.ok()) return status;
      const double voxels = double{kVertexStep} * height / kStepsPerVoxel;
      low = std::min(low, voxels);
      high = std::max(high, voxels);
    }
  }
  return {};
}

}  // namespace

bool wants_region(const World& world, const Edit& edit) {
  return world.ground().can_be_dug && regions_reached(edit, world) == 0;
}

Status begin_region_for(WorldObject& world, const Edit& edit, MakeRegion& made) {
  World& terrain = world.terrain.world;
  if (world.ground_edits == nullptr) {
    return {StatusCode::limit_reached, "there is no room for what a new region changes of the ground",
            "edit_tiles", 1};
  }
  EditGround& ground = *world.ground_edits;
  while (!ground.is_settled()) settle_ground(world);
  const GroundInfo& info = terrain.ground();
  const BrushBox box = box_of(edit);
  const std::int64_t side = side_of_voxel(edit);
  made = {};
  if (!find_nodes(info, box, side, made.nodes)) {
    return refuse(
        "too near to the ground's border: what is dug has four voxels and a node of ground around it; dig "
        "further inside");
  }
  if (!is_apart(info, made.nodes)) {
    return refuse(
        "too near to another region, which does not grow: dig within that one, or four voxels and a node "
        "away from it; a larger first hole makes a larger region");
  }
  // Before anything is read of it.
  const double columns = std::ldexp(made.nodes.high[0] - made.nodes.low[0], info.lattice_size) *
                         std::ldexp(made.nodes.high[1] - made.nodes.low[1], info.lattice_size);
  if (columns > static_cast<double>(terrain.config().region_patches)) {
    return {StatusCode::limit_reached, "the region that this would make is larger than there is room for",
            "region_patches", static_cast<std::uint64_t>(columns)};
  }
  double low = 0, high = 0;
  if (const Status status = find_heights(ground, made.nodes, low, high); !status.ok()) return status;
  if (edit.tool == EditTool::clear && box.low.y > high) return {};
  made.world = &terrain;
  made.ground = &ground;
  made.bottom = static_cast<std::int32_t>(floor_to(std::min(low, box.low.y) - kBelow, side));
  if (edit.tool == EditTool::fill) high = std::max(high, box.high.y);
  made.top = static_cast<std::int32_t>(std::ceil(high)) + kAbove;
  Status status = made.begin();
  bool changes = false;
  if (status.ok()) {
    status = try_part(terrain, terrain.spare().region, edit, changes);
    if (!changes) made.take_back();
  }
  // It has used what it lends.
  world.terrain.residency.take_scratch();
  if (!changes) made.world = nullptr;
  return status;
}

void show_region(WorldObject& world) {
  World& terrain = world.terrain.world;
  terrain.open_region();
  const std::size_t n = terrain.parts().size() - 1;
  const WorldPart& part = terrain.parts()[n];
  // All of it is apart from the ground by as much as surface and voxels are.
  const LatticeBox whole{glm::ivec3(0), part.extent * kStepsPerVoxel};
  if (terrain.is_paintable()) {
    const std::span<PatchId> all = world.terrain.residency.lend_list();
    std::size_t count = 0;
    for (PatchId own = 0; own < part.patches(); ++own) {
      if (!part.surface.is_free(own)) all[count++] = part.first + own;
    }
    static_cast<void>(mark_painted(terrain, world.span(), all.first(count)));
  }
  world.terrain.ground.set_regions(terrain.ground());
  static_cast<void>(grow_region(world, n, whole, nullptr));
  world.terrain.residency.follow_region(n);
  for (ViewState& view : world.terrain.views_of(terrain.config().max_views)) view.attach(terrain);
  for (QueryObject& query : world.queries) {
    const Status status = world.show_world(query);
    KARST_ASSERT(status.ok());  // as it was
    static_cast<void>(status);
  }
}

}  // namespace karst::core
