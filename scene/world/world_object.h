// SPDX-License-Identifier: MIT
// karst::World: the terrain's parts, its queries and the room for its renderer, in the caller's memory.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/edit.h"
#include "karst/world.h"
#include "scene/world/placement.h"
#include "scene/world/plan_layout.h"
#include "scene/world/query_object.h"
#include "scene/world/tile_reader.h"
#include "terrain/edit/edit.h"
#include "terrain/edit/field/edit_field.h"
#include "terrain/edit/field/paint_field.h"
#include "terrain/edit/ground/edit_ground.h"
#include "terrain/edit/paint/edit_paint.h"
#include "terrain/edit/regions/make_region.h"
#include "terrain/edit/regions/region_growth.h"
#include "terrain/edit/shape/edit_shape.h"
#include "terrain/edit/undo_log.h"
#include "terrain/world/terrain_parts.h"

namespace karst::core {

struct WorldObject;

// An edit of voxels that takes several calls. Where there was only ground, from when it is begun to when all
// see it; else boxes of its patches are left, which are loose.
struct PendingDig {
  enum class Stage : std::uint8_t { none, region, hole, hole_boxes, show, boxes };

  // Patches of an edit that get exact boxes at once; those whose boxes a call finds, and their vertices.
  static constexpr std::size_t kExact = 32;
  static constexpr std::uint32_t kFitted = 256, kFittedVertices = 120'000;

  Stage stage = Stage::none;
  core::Edit edit;
  MakeRegion make;
  bool spreads = false;      // start()'s
  bool alone = false;        // is a step of undo of its own
  bool ends_stroke = false;  // the stroke that it is in ended meanwhile
  // Of the hole: what it changed, from the region's corner, and patches that it touched.
  LatticeBox box{};
  std::uint32_t touched = 0;
  // Of boxes: of which part, and what its region's growth was before.
  std::size_t part = 0;
  RegionGrowth growth;
  // That advance() is still to tell of.
  EditResult untold;
};

// karst::Editor over the core's edits: places of the simulator's frame to voxels, and what follows from an
// edit beyond the core's world (editor_object.cpp).
struct EditorObject final : karst::Editor {
  explicit EditorObject(WorldObject& owner) : world(owner) {}
  ~EditorObject() = default;

  Status apply(const karst::Edit& edit, EditResult& result);
  // pending_dig.cpp
  Status start(const karst::Edit& edit, EditResult& result);
  bool is_pending() const { return dig.stage != PendingDig::Stage::none || dig.untold.changed; }
  void advance(EditResult& result);
  // Does what is pending, and the rest of a step that is half way.
  void finish();
  // undo_steps.cpp
  void begin_stroke();
  void end_stroke();
  Status take_step(bool back, double most_ms, EditResult& result);
  UndoState undo_state() const;
  Status save(const Sink& sink);

  // Does what edits left for later, for so many milliseconds or until all is done.
  void settle(double most_ms);
  bool is_settled() const;

  WorldObject& world;
  UndoLog log;
  std::uint64_t version = 0;        // one more with each change
  std::uint64_t sky_version = 0;    // one more with each change of the sky
  std::uint64_t shape_version = 0;  // the last one that changed more than paint
  bool ground_changed = false;
  std::uint32_t loose = 0;  // bit n: the columns of region n are still to be looked at
  ColumnsOfRegion columns;
  PaintChange unshown;  // paint that is not on the GPU yet
  PendingDig dig;
  std::atomic<bool> taken{false};

 private:
  core::Edit in_voxels(const karst::Edit& edit) const;
  Status begin(const karst::Edit& edit, bool spreads, EditResult& result);
  Status make(const core::Edit& edit, EditResult& result);
  Status begin_dig(const core::Edit& edit, EditResult& result);
  // True: all see the hole, and result tells of it.
  bool step_dig(EditResult& result);
  void dig_hole();
  void show_dig(EditResult& result);
  void fit_later(const EditChange& change);
  // Some of those of a part. True: all are exact.
  bool fit_boxes(std::size_t part);
  void grow_at_last();
  Status make_heights(const core::Edit& edit, UndoLog* kept, EditResult& result);
  bool is_of_field(const core::Edit& edit) const;
  void follow_paint(const PaintChange& change, EditResult& result);
  void follow_ground(const GroundChange& change, std::uint32_t nodes, EditResult& result);
  void follow_field(const FieldChange& change, EditResult& result);
  Status follow(const EditChange& change, EditResult& result);
  // Adds the box of two corners, voxels.
  void show_extent(const glm::dvec3& low_voxels, const glm::dvec3& high_voxels, EditResult& result) const;
  // regions: bit n is set where region n may be another now.
  Status take_part(UndoPart part, bool back, std::uint32_t& regions, EditResult& result);
  Status take_parts(bool back, double most_ms, EditResult& result);
};

struct WorldObject final : karst::World {
  WorldObject() = default;
  ~WorldObject() = default;

  Status load(const Plan& plan, const Source& source, std::span<std::byte> memory, Log log);
  // Memory for tiles that are read, and for edits.
  Status open_ground(std::span<std::byte> memory, std::span<std::byte> edits);
  TileReading ground_reading() const {
    return ground_edits != nullptr ? ground_edits->overlay().reading() : tiles.reading();
  }
  BlendSpan span() const { return layout.renderer.blend_span; }  // of the painted map
  // To queries: the world's parts and ground as they are.
  Status show_world(QueryObject& query) const;
  void show_box();  // in `shown`, that of the surface
  void say(Severity severity, const char* text) const {
    if (log.line != nullptr) log.line(log.user, severity, text);
  }

  Plan made_for;
  Source file;
  Log log;
  karst::WorldInfo shown;
  PlacementFrame placement;
  PlanLayout layout;
  TerrainParts terrain;
  TileReader tiles;
  EditGround* ground_edits = nullptr;  // null: the ground is not edited
  std::span<QueryObject> queries;
  EditorObject editor{*this};
  std::span<std::byte> renderer_room;  // of the renderer
  std::span<std::byte> staging;
  bool has_renderer = false;
};

}  // namespace karst::core
