// SPDX-License-Identifier: MIT
// The new octree is made beside the old one, its surface around the edit is extracted into working memory,
// and all is counted; only then anything is put in place, and from there on nothing fails.
#include "terrain/edit/shape/edit_shape.h"

#include <algorithm>
#include <cmath>

#include "terrain/base/check.h"
#include "terrain/edit/brush.h"
#include "terrain/edit/shape/edit_octree.h"
#include "terrain/edit/shape/new_heights.h"
#include "terrain/edit/shape/shape_undo.h"
#include "terrain/surface/bezier/extract_surface.h"
#include "terrain/surface/bezier/update_surface.h"

namespace karst::core {

Edit from_part(const Edit& edit, const WorldPart& part) {
  Edit own = edit;
  own.place -= glm::dvec3(part.corner);
  own.to -= glm::dvec3(part.corner);
  if (edit.octree_depth > 0 && part.octree != nullptr) {
    const int level = edit.octree_level - edit.octree_depth + part.octree->depth();
    own.octree_level = static_cast<std::uint8_t>(std::max(level, 0));
    own.octree_depth = 0;
  }
  return own;
}

namespace {

constexpr double kMostVoxels = 0x1p20;  // of lengths, so that all sums are finite
constexpr double kFarthest = 0x1p31;    // of places

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

bool is_within(glm::dvec3 v, double most) {
  return std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most;
}
bool inside(double v, double least, double most) {
  return v >= least && v <= most;
}

// Whether voxels of a region that may be changed lie in the shape's box.
bool reaches(const Edit& edit, const WorldPart& part) {
  const Edit own = from_part(edit, part);
  BrushBox box = brush_box(own);
  if (own.shape == BrushShape::voxel) {
    const double side = std::ldexp(1.0, part.octree->depth() - own.octree_level);
    box.low = glm::floor(own.place / side) * side;
    box.high = box.low + side;
  }
  const glm::dvec3 low(kSideVoxels, 1, kSideVoxels);
  const glm::dvec3 high(part.extent - glm::ivec3(kSideVoxels, 0, kSideVoxels));
  for (int axis = 0; axis < 3; ++axis) {
    // Centres alone count.
    if (box.high[axis] < low[axis] + 0.5 || box.low[axis] > high[axis] - 0.5) return false;
  }
  return true;
}

class ShapeEdit {
 public:
  // edit: from the part's corner.
  ShapeEdit(World& world, std::size_t part, const Edit& edit, std::size_t exact = MeasureQueue::kAll)
      : all_(world.edit(part)),
        room_(*all_.room),
        part_(static_cast<std::uint32_t>(part)),
        edit_(edit),
        level_(world.info().level),
        exact_(exact) {}

  // log: may be null.
  Status run(UndoLog* log, EditChange& change) {
    Octree& octree = *all_.octree;
    const Octree::Node old_root = octree.root();
    EditOctree::Result made;
    UpdateSurface update;
    if (const Status status = make(made, update); !status.ok() || made.root == old_root) return status;
    if (log != nullptr) {
      keep_shape_edit(all_, {edit_, made.low, made.high, part_}, old_root, update.list_lost(room_.changed),
                      level_, *log);
    }
    put(update, old_root, made, nullptr, change);
    return {};
  }

  Status try_out(bool& changes) {
    Octree& octree = *all_.octree;
    const Octree::Node old_root = octree.root();
    EditOctree::Result made;
    UpdateSurface update;
    const Status status = make(made, update);
    changes = status.ok() && made.root != old_root;
    octree.set_root(old_root);
    if (changes) EditOctree::release(octree, made.root, old_root);
    return status;
  }

  void take_back(UndoPart part, EditChange& change) {
    Octree& octree = *all_.octree;
    const VoxelEditCell edit = kept_edit(part);
    const Octree::Node old_root = octree.root();
    const EditOctree::Result made{restore_voxels(octree, part), edit.low, edit.high};
    octree.set_root(made.root);
    UpdateSurface update;
    const Status status = extract(made, update);
    KARST_ASSERT(status.ok());  // checked when the edit was made
    static_cast<void>(status);
    put(update, old_root, made, &part, change);
  }

 private:
  // The new octree beside the old one, and its surface in working memory. Nothing has changed after an error.
  Status make(EditOctree::Result& made, UpdateSurface& update) {
    Octree& octree = *all_.octree;
    // The surface has no top above the highest voxels in use.
    glm::ivec3 low(0), high = all_.extent - glm::ivec3(1, edit_.tool == EditTool::fill ? 2 : 1, 1);
    if (all_.mirrors) {
      low = glm::ivec3(kSideVoxels, 1, kSideVoxels);
      high -= glm::ivec3(kSideVoxels, 0, kSideVoxels);
    }
    const VoxelShape shape(edit_, octree.depth(), low, high);
    const EditOctree edit{&octree, &shape, edit_.tool == EditTool::fill};
    const Octree::Node old_root = octree.root();
    if (const Status status = edit.run(made); !status.ok()) return status;
    if (made.root == old_root) return {};
    octree.set_root(made.root);
    const Status status = extract(made, update);
    if (status.ok()) return {};
    octree.set_root(old_root);
    EditOctree::release(octree, made.root, old_root);
    return status;
  }

  // Counts first. Nothing of the world but its octree has changed. There is room to take it back, too.
  Status extract(const EditOctree::Result& made, UpdateSurface& update) {
    const CornerBox box = corners_touched(made.low, made.high);
    ExtractSurface extract;
    extract.octree = all_.octree;
    extract.extent = all_.extent;
    extract.mirrors = all_.mirrors;
    extract.low = box.low;
    extract.high = box.high;
    ExtractSurface::Result count;
    if (const Status status = extract.count(count); !status.ok()) return status;
    if (count.patches > room_.patches.size()) return too_small(count.patches);
    // All that shares a corner with them lies a corner further at most.
    ExtractSurface around = extract;
    around.low -= 1;
    around.high += 1;
    ExtractSurface::Result all;
    if (const Status status = around.count(all); !status.ok()) return status;
    if (all.patches >= room_.touched.size()) return too_small(all.patches / World::EditRoom::kTouched + 1);
    extract.volumes = room_.volumes;
    extract.patches = room_.patches;
    extract.scratch = room_.table;
    ExtractSurface::Result fresh;
    if (const Status status = extract.run(fresh); !status.ok()) return too_small(count.patches);
    update.fresh = {room_.volumes.first(fresh.volumes), room_.patches.first(fresh.patches)};
    update.box = box;
    update.slots = all_.slots;
    update.changes = room_.changes;
    std::uint32_t before = 0;
    if (const Status status = update.check(before); !status.ok()) return too_small(status.value());
    if (before > room_.patches.size()) return too_small(before);
    // Around the box all stays as it is.
    const std::uint32_t all_before = all.patches - count.patches + before;
    if (all_before >= room_.touched.size()) return too_small(all_before / World::EditRoom::kTouched + 1);
    return {};
  }

  // From here on nothing fails. part: that is taken back; null: patches that are new get new heights.
  void put(const UpdateSurface& update, Octree::Node old_root, const EditOctree::Result& made,
           const UndoPart* part, EditChange& change) {
    EditOctree::release(*all_.octree, old_root, made.root);
    UpdateSurface::Result updated;
    const Status status = update.run(updated);
    KARST_ASSERT(status.ok());
    static_cast<void>(status);
    change.changed = true;
    change.box = {made.low * kStepsPerVoxel, (made.high + 1) * kStepsPerVoxel};
    follow(updated, part, change);
  }

  static Status too_small(std::uint64_t patches) {
    return {StatusCode::limit_reached, "the edit changes more patches than there is room for", "edit_patches",
            patches};
  }

  void make_heights(std::span<const PatchChange> changes) {
    NewHeights heights;
    heights.surface = all_.surface;
    heights.changes = changes;
    heights.level = level_;
    heights.patches = all_.patches;
    heights.first_block = all_.first;
    heights.heights = all_.heights;
    heights.run();
  }

  void follow(const UpdateSurface::Result& updated, const UndoPart* part, EditChange& change) {
    const std::span<const PatchChange> changes = room_.changes.first(updated.changes);
    if (part == nullptr) make_heights(changes);
    FollowChange follow(all_, level_, change);
    std::size_t vanished = 0, changed = updated.vanished;
    for (const PatchChange& one : changes) {
      if (one.kind == PatchChange::vanished) {
        join(change.box, follow.box_before(one.slot));
        follow.forget(one.slot);
        if (all_.surface.is_free(one.slot)) room_.changed[vanished++] = one.slot;
      } else {
        room_.changed[changed++] = one.slot;
        if (one.kind == PatchChange::appeared && !all_.overrides.empty()) all_.overrides[one.slot] = 0;
      }
    }
    if (part != nullptr) restore_patches(all_, level_, *part);
    std::sort(room_.changed.begin(), room_.changed.begin() + static_cast<std::ptrdiff_t>(vanished));
    follow.run(room_.changed.subspan(updated.vanished, changed - updated.vanished),
               room_.changed.first(vanished), {}, true, exact_);
  }

  World::Editable all_;
  const World::EditRoom& room_;
  std::uint32_t part_;
  const Edit& edit_;
  int level_;
  std::size_t exact_;
};

}  // namespace

Status check_edit(const Edit& edit, const World& world) {
  const GroundInfo& ground = world.ground();
  if (ground.exists() && ground.region_count == 0 && !ground.can_be_dug) {
    return {StatusCode::unsupported,
            "a ground is dug in its regions, and it has none: karst-bake --carve or --dig", "ground"};
  }
  if (ground.can_be_dug && ground.region_count == 0 && !world.is_editable())
    return {StatusCode::limit_reached, "there is no room for a region to dig in", "dig_regions", 1};
  if (!world.is_editable())
    return refuse("it was planned without room for edits, or is one that cannot be edited", "world");
  if (static_cast<int>(edit.tool) >= kEditTools) return refuse("not a tool", "tool");
  if (static_cast<int>(edit.shape) >= kBrushShapes) return refuse("not a shape", "shape");
  if (edits_voxels(edit.tool) && edit.shape == BrushShape::cylinder)
    return refuse("cylinders are for heights alone", "shape");
  int depth = edit.octree_depth;
  for (const WorldPart& part : world.parts()) depth = std::max(depth, part.octree->depth());
  if (edit.octree_level > depth) return refuse("finer than the octree", "octree_level");
  if (!is_within(edit.place, kFarthest)) return refuse("not finite, or too far away", "place");
  if (!is_within(edit.to, kFarthest)) return refuse("not finite, or too far away", "to");
  if (!is_within(edit.half, kMostVoxels) || !(edit.half.x >= 0 && edit.half.y >= 0 && edit.half.z >= 0))
    return refuse("not lengths, or too large", "half_m");
  if (!inside(edit.radius, 0, kMostVoxels)) return refuse("not a length, or too large", "radius_m");
  if (!inside(edit.strength, -kMostVoxels, kMostVoxels))
    return refuse("not finite, or too large", "strength_m");
  if (!inside(edit.amount, 0, 1)) return refuse("not within 0..1", "amount");
  if (!inside(edit.hardness, 0, 1)) return refuse("not within 0..1", "hardness");
  if (!inside(edit.wave, 0x1p-10, kMostVoxels)) return refuse("not a length, or too large", "wave_m");
  if (!is_within(edit.up, kMostVoxels)) return refuse("not finite, or too large", "up");
  return {};
}

std::size_t regions_reached(const Edit& edit, const World& world) {
  return static_cast<std::size_t>(
      std::ranges::count_if(world.parts(), [&](const WorldPart& part) { return reaches(edit, part); }));
}

Status part_of_edit(const Edit& edit, const World& world, std::size_t& part) {
  part = 0;
  if (!world.ground().exists()) return {};
  std::size_t found = 0;
  for (std::size_t n = 0; n < world.parts().size(); ++n) {
    const WorldPart& own = world.parts()[n];
    if (!reaches(edit, own)) continue;
    part = n;
    ++found;
  }
  if (found == 0)
    return refuse("a ground is dug in its regions, and none has voxels there that may change", "place");
  if (found > 1) return refuse("the edit reaches two regions at once", "place");
  if (part < world.ground().regions().size() && world.ground().regions()[part].is_field())
    return {StatusCode::unsupported, "an isosurface stands there, which has no voxels to edit", "place"};
  const WorldPart& own = world.parts()[part];
  if (edit.shape == BrushShape::voxel && from_part(edit, own).octree_level > own.octree->depth())
    return refuse("finer than the octree of the region", "octree_level");
  return {};
}

Status edit_shape(World& world, const Edit& edit, UndoLog* log, EditChange& change) {
  change = {};
  if (const Status status = check_edit(edit, world); !status.ok()) return status;
  KARST_ASSERT(edits_voxels(edit.tool));
  std::size_t part = 0;
  if (const Status status = part_of_edit(edit, world, part); !status.ok()) return status;
  return edit_part(world, part, edit, log, change);
}

Status edit_part(World& world, std::size_t part, const Edit& edit, UndoLog* log, EditChange& change,
                 std::size_t exact) {
  change = {};
  change.part = part;
  return ShapeEdit(world, part, from_part(edit, world.part(part)), exact).run(log, change);
}

Status try_part(World& world, std::size_t part, const Edit& edit, bool& changes) {
  changes = false;
  if (!reaches(edit, world.part(part)))
    return refuse("a ground is dug in its regions, and none has voxels there that may change", "place");
  return ShapeEdit(world, part, from_part(edit, world.part(part))).try_out(changes);
}

void undo_shape(World& world, UndoPart part, EditChange& change) {
  change = {};
  const VoxelEditCell kept = kept_edit(part);
  change.part = kept.part;
  ShapeEdit(world, change.part, kept.edit).take_back(part, change);
}

void redo_shape(World& world, UndoPart part, EditChange& change) {
  change = {};
  const VoxelEditCell kept = kept_edit(part);
  change.part = kept.part;
  const Status status = ShapeEdit(world, change.part, kept.edit).run(nullptr, change);
  KARST_ASSERT(status.ok());
  static_cast<void>(status);
}

}  // namespace karst::core
