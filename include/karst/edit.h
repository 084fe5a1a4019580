// SPDX-License-Identifier: MIT
// Edits: dig, fill, raise, smooth, between frames, in memory that the plan counts (Needs::edit_patches,
// Needs::edit_tiles, Needs::field_sample_blocks, Needs::undo_bytes). Voxels, samples of the ground or of the
// field of an isosurface change; all that follows from them
// (surface, levels of detail, errors, boxes, shadows, answers of queries) is as if the world had been baked
// so.
//
//   Editor* editor = nullptr;
//   world.take_editor(editor);
//   Edit dig;  dig.tool = EditTool::clear;  dig.place = hit.place;  dig.radius_m = 3;
//   EditResult changed;
//   editor->apply(dig, changed);   // changed.low .. high: for the host's physics
//   editor->start(dig, changed);   // or in parts, one a frame
//   if (editor->is_pending()) editor->advance(changed);
//   editor->undo(changed);
//   editor->save(sink);
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/export.h"
#include "karst/status.h"
#include "karst/types.h"

namespace karst {

enum class EditTool : std::uint8_t {
  clear,    // voxels: becomes air
  fill,     // voxels: becomes rock
  extrude,  // heights: out of the ground by strength_m (below 0: into it), with K's profile (K equation 5.1)
  smooth,   // heights: towards the mean of those around, by the share `amount`
  noise,    // heights: by simplex noise of the place in space, up to strength_m, of wave length wave_m
  flatten,  // heights: onto the plane through `place` with the normal `up`
  level,    // heights: to the elevation of `place`
  paint     // materials: by the share `amount`, over what is there; see `material`
};

enum class BrushShape : std::uint8_t {
  voxel,    // the one of octree_level that holds `place`; clear and fill
  box,      // centre `place`, half sides `half_m` along the world's axes
  sphere,   // around `place`
  capsule,  // around the segment from `place` to `to`
  cylinder  // upright, around `place`; of heights
};

inline constexpr std::uint8_t kNoMaterial = 255;  // takes paint away: the world's own rules decide again

struct Edit {
  EditTool tool = EditTool::clear;
  BrushShape shape = BrushShape::sphere;
  // Of BrushShape::voxel: from WorldInfo::octree_depth, one voxel, down; each level is twice as wide, up to
  // the whole of an octree.
  std::uint8_t octree_level = 0;
  // Of paint: a material's number in the world, or kNoMaterial. Paint lies in a map seen from above, of which
  // a texel is over a whole column: a brush paints what is below and above its place, too, but not what faces
  // down, nor caves. Four materials are painted at most.
  std::uint8_t material = 0;
  Vec3 place;  // in the simulator's frame, metres
  Vec3 to;
  Vec3 half_m{1, 1, 1};
  Vec3 up{0, 1, 0};
  double radius_m = 1;
  double strength_m = 1;
  double amount = 1;    // 0..1
  double hardness = 0;  // 0..1: the share of the radius within which the brush has its whole strength
  double wave_m = 4;
  std::uint32_t seed = 0;
};

struct EditResult {
  bool changed = false;                  // false: the world was so already
  Vec3 low, high;                        // box of all that changed, before and after
  std::uint32_t patches = 0, nodes = 0;  // that are made anew
  std::uint64_t version = 0;             // of the world, one more with each change
  // Of apply(): whether it can be taken back. Where undo_bytes has no room for what its step keeps, the edit
  // is made all the same, and neither that step nor any before it can be taken back.
  bool can_undo = false;
  bool pending = false;  // of start(): what it changes is to come, by advance()
};

struct UndoState {
  std::uint32_t undo_steps = 0;  // that can be taken back
  std::uint32_t redo_steps = 0;  // that were taken back and can be done again
  std::uint64_t lost_steps = 0;  // that were done and can't be taken back any more, for want of undo_bytes
  bool is_taking = false;        // a step is half way: the same call goes on with it
};

// Where bytes go, in order. write returns false where it cannot take them.
struct Sink {
  void* user = nullptr;
  bool (*write)(void* user, std::span<const std::byte> bytes) = nullptr;
};

// One a world. All calls are made by the renderer's thread, or by any where there is none, between frames and
// while no query of the world is asked.
class KARST_API Editor {
 public:
  Editor(const Editor&) = delete;
  Editor& operator=(const Editor&) = delete;

  // Voxels of worlds without a ground (clear, fill) and heights of their patches (extrude to level;
  // Needs::edit_patches); voxels of a ground's regions (clear, fill; Needs::edit_patches and edit_tiles); and
  // heights of grounds on planes (extrude to level; Needs::edit_tiles), together with those of patches in its
  // regions (edit_patches, too). Materials are painted over all of it, but for grounds on a curved basis and
  // patches that were baked with a material of their own (Needs::paint_width). The rest is refused.
  //
  // Where a ground can be dug (WorldInfo::can_be_dug), an edit of voxels where no region is makes one first,
  // of whole nodes around the brush (Needs::dig_regions, Needs::region_patches, and edit_tiles for what it
  // changes of the ground). "place": too near to the ground's border or to another region, four voxels and a
  // node of ground at least. The region stays when the edit is taken back, and looks as the ground then.
  //
  // Of a region's voxels the outermost stay: three at its sides, where the ground begins, and the lowest; so
  // its size bounds what can be dug. "place": the edit reaches no others of a region, or those of two;
  // unsupported ("ground"): it has no region to dig in, or is one that cannot be edited.
  //
  // Fields of isosurfaces: clear, fill, smooth, flatten and level, with boxes, spheres and capsules of 128
  // cells at most (half sides, radius; a capsule's ends 256 apart along each axis). An edit that reaches a
  // field's box changes nothing else. Room for samples is Needs::field_sample_blocks, which may be missing
  // where smooth would have needed none in the end.
  //
  // Heights of patches: a vertex moves along a direction of its own, out of the rock, where the brush reaches
  // its place in space. It stays within 3.4 voxels of the surface of its voxels, however far it is asked to
  // go; flatten and level move it the less the more its direction runs along the plane. In a region samples
  // of the ground, which stands for it from far away, move as well; near its sides extrude and noise lift
  // patches by as much as the ground beside them. invalid_argument names the field. limit_reached names the
  // field of Needs that is too small, or "max_octets", with what it would take. After an error nothing has
  // changed, to the bit.
  Status apply(const Edit& edit, EditResult& result) noexcept;

  // As apply(), but what takes longer than a frame has is only begun, and result.pending says so. All errors
  // come now. advance() does a part, counted, some 3 ms. Of an edit that makes a region nothing is there
  // until the last part, for frames and queries; then all of it is, and result is apply()'s. Frames with a
  // limit of time draw it some frames later: when they have made vertices of all of the region. Of a large
  // hole elsewhere all is there now, and result tells of a box that is a little too large; boxes of its
  // patches are found in parts, and a little more is drawn until then. Other edits, undo(), redo(),
  // begin_stroke() and save() do first what is pending; advance() then tells what it changed. A stroke that
  // ends meanwhile has it as its last edit; undo_state() does not count it yet.
  Status start(const Edit& edit, EditResult& result) noexcept;
  // Whether there is something for advance() to do or to tell.
  bool is_pending() const noexcept;
  // result.changed: it is there now. Nothing pending: it does nothing.
  void advance(EditResult& result) noexcept;

  // Edits between them are one step of undo; without, each edit is one. undo(), redo() and a second
  // begin_stroke() end it; a step that changed nothing is none.
  void begin_stroke() noexcept;
  void end_stroke() noexcept;

  // Takes the last step back, or does the last one that was taken back again: the world is then what it was
  // before, or after it, to the bit. An edit forgets what could be done again. Steps are kept in undo_bytes;
  // the oldest ones give way to new ones, and one that takes up to half of undo_bytes is kept for certain.
  // result.changed false: there is no such step, or all that it did was undone by itself. They need no more
  // room than the step's edits did and do not fail for want of any; errors of reading, as apply().
  Status undo(EditResult& result) noexcept;
  Status redo(EditResult& result) noexcept;
  // The same in pieces, of as many edits of the step as fit into most_ms, one at least: for long strokes,
  // between frames. Frames and queries see all of an edit or nothing of it. While UndoState::is_taking the
  // next call of the same kind goes on; the other one, edits, begin_stroke() and save() do the rest first,
  // and advance() then tells what that changed.
  Status undo(EditResult& result, double most_ms) noexcept;
  Status redo(EditResult& result, double most_ms) noexcept;
  UndoState undo_state() const noexcept;

  // The world as it is now as a .karst file. Its own file is read, and stays what it is. Errors of reading;
  // limit_reached ("sink").
  Status save(const Sink& sink) noexcept;

 protected:
  Editor() = default;
  ~Editor() = default;
};

}  // namespace karst
