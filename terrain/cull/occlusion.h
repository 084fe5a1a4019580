// SPDX-License-Identifier: MIT
// Which boxes are hidden by rock (occluders.h), found a few a frame and remembered: a box that was hidden is
// asked about the same layer of cells again, one that was not is searched for again ever more rarely, and a
// frame that found little lets the next one search little, from where it stopped on. After a second with
// nothing hidden, most frames do not ask at all. So a frame's work is bounded, and next to nothing where
// nothing is hidden; what is not found costs time alone.
//
// Nothing is hidden in parallel views, whose rays have no common eye, nor where a corner of the near plane is
// not in front of the eye.
//
// Same frames in the same order give the same answers: nothing depends on time.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/cull/bounds_tree.h"
#include "terrain/cull/occluders.h"
#include "terrain/cull/patch_boxes.h"
#include "terrain/view/camera.h"

namespace karst::core {

class Occlusion {
 public:
  // Entries for so many patches: one a patch, then one a node of their tree.
  static constexpr std::uint32_t entry_count(std::uint32_t patches) {
    return patches + BoundsTree::node_count(patches);
  }
  // Rows of the tree that are asked about, from the lowest: nodes of 8 and of 64 patches. Above them boxes
  // are too large for any rock.
  static constexpr int kRows = 2;

  // Lends memory for entry_count(patches) entries, borrowed for the object's life.
  void create(std::span<std::uint16_t> storage, std::uint32_t patches) {
    entries_ = storage.first(entry_count(patches));
    first_node_ = patches;
    reset();
  }

  // Forgets everything: for another surface.
  void reset();

  // Starts a frame. searches: the most boxes that are searched for rock in it, about a microsecond each. All
  // borrowed until the frame's last question; tree, surface and bounds are those that occluders were built
  // with.
  void begin(const Occluders& occluders, const Octree& octree, const BoundsTree& tree, const Surface& surface,
             std::span<const PatchBounds> bounds, const Camera& camera, std::uint32_t searches);
  // Hides nothing until the next begin().
  void end() { active_ = false; }
  bool active() const { return active_; }

  // Whether nothing that is drawn inside the box of a node of kRows can be seen from the frame's eye. False
  // where that is not known. Boxes are asked about in the tree's order, each once a frame.
  bool hides_node(const BoundsTree& tree, int row, std::uint32_t n) {
    const std::uint32_t entry = first_node_ + tree.node_index(row, n);
    const std::uint16_t state = entries_[entry];
    if ((state & kHidden) == 0 && !is_due(entry, tree.first_patch(row, n), state)) return false;
    return ask(entry, tree.first_patch(row, n), state, tree.node(row, n));
  }
  // The same of patches 8 n + p, for the bits p of a mask: those that are hidden.
  std::uint8_t hides_patches(const PatchBoxes& boxes, std::uint32_t n, std::uint8_t mask);

  std::uint32_t searched() const { return searched_; }  // in this frame

 private:
  // An entry: kHidden | axis << kAxisShift | layer, or how rarely the box is searched for, 0 is always, and
  // kWoken where that is due whatever its turn.
  static constexpr std::uint16_t kHidden = 0x8000;
  static constexpr std::uint16_t kWoken = 0x4000;
  static constexpr int kAxisShift = 13;
  static constexpr std::uint16_t kLayerMask = (1u << kAxisShift) - 1;
  static constexpr std::uint16_t kRarest = 5;  // one frame in 32
  static_assert((1 << kMaxDepth) <= kLayerMask + 1);

  // first: patch of the box.
  bool is_due(std::uint32_t entry, PatchId first, std::uint16_t state) const {
    if (searched_ >= allowed_) return false;
    if ((state & kWoken) != 0) return true;
    if (first < turn_) return false;
    // A hash of the two, so that every frame asks about another sample of the boxes.
    std::uint32_t mixed = (entry + frame_ * 0x85ebca6bu) * 0x9e3779b1u;
    mixed = (mixed ^ mixed >> 15) * 0x85ebca6bu;
    return state == 0 || mixed >> (32 - state) == 0;
  }
  bool ask(std::uint32_t entry, PatchId first, std::uint16_t state, const LatticeBox& box);
  void wake_siblings(std::uint32_t entry);

  std::span<std::uint16_t> entries_;
  std::uint32_t first_node_ = 0;
  const Occluders* occluders_ = nullptr;
  glm::vec3 eye_{0.0f};  // in cells
  float reach_ = 0;      // in cells; boxes further away are not hidden
  float near_ = 0;       // in cells; nothing beyond this from the eye is in front of the near plane
  bool outside_ = false;
  bool active_ = false;
  std::uint32_t frame_ = 0;
  std::uint32_t allowed_ = 0;  // searches
  std::uint32_t searched_ = 0;
  std::uint32_t found_ = 0;
  std::uint32_t hidden_ = 0;  // boxes
  std::uint32_t quiet_ = 0;   // active frames in a row with nothing hidden
  PatchId turn_ = 0;          // boxes of earlier patches had their turn
  PatchId next_turn_ = 0;     // of the next frame
  bool fresh_ = true;         // nothing was asked since reset()
};

}  // namespace karst::core
