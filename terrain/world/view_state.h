// SPDX-License-Identifier: MIT
// What one eye sees: levels of detail, what is drawn, what it lacks, what rock hid from it, from frame to
// frame. There are as many as Config::max_views; Residency::select() fills those of a frame, all together.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/check.h"
#include "terrain/base/storage_plan.h"
#include "terrain/cull/cull_view.h"
#include "terrain/cull/occlusion.h"
#include "terrain/draw/draw_list.h"
#include "terrain/lod/morph.h"
#include "terrain/lod/select_lod.h"
#include "terrain/lod/threshold_sets.h"
#include "terrain/resident/resident_pool.h"
#include "terrain/view/camera.h"
#include "terrain/world/world.h"

namespace karst::core {

// What a view of a frame asks for.
struct ViewRequest {
  const Camera* camera = nullptr;  // borrowed for the select()
  LodSettings lod;                 // max_level and resident_level are cut to the world's level
  // 2^-10..2^10. Where memory is short, a view of half the weight has twice the error.
  double weight = 1;
  int width_px = 1280;  // of the picture, 1..65536; what error_px is measured in
  int height_px = 720;
  bool frustum_culling = true;
  bool backface_culling = true;
  bool occlusion_culling = true;
  std::uint32_t occlusion_searches = 128;  // boxes a frame for which hiding rock is searched, 0.3 us each
  // Bit n: of part n nothing is chosen or listed, as if it were out of view.
  std::uint32_t skipped_parts = 0;
};

class ViewState {
 public:
  struct Selection {
    SelectLod::Result lod;  // bound_px: what holds for this view
    BuildDrawList::Result list;
    // Bit n: of part n all patches that are in view are listed.
    std::uint32_t whole_parts = 0;
    float error_scale = 1;  // error_px times this was aimed at
  };

  ViewState();
  ViewState(const ViewState&) = delete;
  ViewState& operator=(const ViewState&) = delete;

  // Of one view.
  static void add_to(Budget& budget, const Config& config) { count_blocks<Blocks>(config, budget); }
  // Takes what add_to() counts. config is valid. limit_reached ("memory").
  Status create(const Config& config, Arena& arena);
  // Forgets what it saw. world: loaded; of the config of create().
  void attach(const World& world);

  // --- Of the last select()
  const Selection& selection() const { return selection_; }
  // Valid until the next select(). Draw them with Residency::pages() and the rows of threshold_set().
  std::span<const DrawItem> items() const { return blocks_.items.first(selection_.list.drawn); }
  // Of patches in view and their neighbours, and of all without frustum_culling, as SelectLod leaves them.
  std::span<const std::uint8_t> levels() const { return blocks_.levels.first(patches_); }
  // In the order of SelectLod; after the frame's first generate_next() a heap.
  std::span<const LackingPatch> lacking() const { return blocks_.lacking.first(lacking_count_); }
  // Patches drawn coarser than they are wanted.
  std::span<const PatchId> cut() const { return blocks_.cut.first(selection_.lod.cut); }
  const LodSettings& settings() const { return lod_.settings; }  // with what the governor made of error_px
  const ErrorScale& error_scale() const { return lod_.scale; }
  const LodEye& eye() const { return eye_; }
  // As the octree of a part of the world has it.
  const LodEye& eye_of(std::size_t part) const { return eyes_[part]; }
  double wanted_error_px() const { return wanted_error_px_; }
  double weight() const { return weight_; }
  // Of Residency::thresholds(); -1 before the first select().
  int threshold_set() const { return threshold_set_; }

  // --- Steps of Residency::select(), in this order

  // invalid_argument naming the first field of the request that is out of its range. error_scale: error_px
  // times this is aimed at, at most kMostErrorPx. A view whose begin() failed lists nothing.
  Status begin(const World& world, const ViewRequest& request, double error_scale);
  ThresholdSets::Key threshold_key() const;
  void set_threshold_set(int set) { threshold_set_ = set; }
  // lods: of its set. resident: levels that are held, by patch. cuts: SelectLod's. scratch: one value a
  // patch. limit_reached ("max_draw_items") leaves a valid, shorter list.
  Status choose(const World& world, std::span<const PatchLod> lods, std::span<const std::uint8_t> resident,
                bool cuts, std::span<std::uint32_t> scratch);

  // --- What is lacking, most urgent first: holes before what is off by most pixels

  // Precondition of most_urgent() and pop_lacking(): order_lacking() was called since the last select().
  void order_lacking(const ResidentPool& pool);
  bool lacking_is_ordered() const { return lacking_is_heap_; }
  const LackingPatch* most_urgent() const {
    KARST_ASSERT(lacking_is_heap_ || lacking_count_ == 0);
    return lacking_count_ == 0 ? nullptr : blocks_.lacking.data();
  }
  // Takes the most urgent one out, and returns it.
  LackingPatch pop_lacking();
  void clear_lacking() { lacking_count_ = 0; }
  // All that the last choice lacked, what is held by now too.
  void restore_lacking();
  // Whether all that a choice without cuts lists and lacks is held by now.
  bool is_held(std::span<const std::uint8_t> resident) const;
  void set_complete() {
    selection_.lod.capped = selection_.lod.missing = 0;
    selection_.whole_parts = complete_parts_;
  }
  // Of a ground's regions, bit n for part n: lists those alone, and counts no lack nor bound of others whose
  // patches are all there: the ground stands for them.
  void keep_parts(std::uint32_t parts);
  // Lists nothing.
  void clear() {
    selection_ = {};
    lacking_count_ = 0;
  }

 private:
  struct Blocks {
    std::span<std::uint8_t> levels;  // by patch
    std::span<DrawItem> items;
    std::span<LackingPatch> lacking;
    std::span<PatchId> cut;  // one value a patch
    std::span<CulledEight> culled;
    std::span<std::uint16_t> hidden;  // Occlusion's entries

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::draw_list, config.max_patches, levels);
      visit(Consumer::draw_list, config.max_draw_items, items);
      visit(Consumer::residency, config.max_draw_items, lacking);
      visit(Consumer::draw_list, config.max_patches, cut);
      visit(Consumer::draw_list, PatchBoxes::count_for(config.max_patches), culled);
      visit(Consumer::occlusion, Occlusion::entry_count(config.max_patches), hidden);
    }
  };

  Status choose_part(const World& world, std::size_t n, std::span<const PatchLod> lods,
                     std::span<const std::uint8_t> resident, bool cuts, std::span<std::uint32_t> scratch);

  Blocks blocks_;
  Occlusion occlusion_;
  SelectLod lod_;  // settings and inputs of the last select()
  ViewRequest request_;
  Selection selection_;
  LodEye eye_;
  double wanted_error_px_ = 0;
  double weight_ = 1;
  std::uint32_t patches_ = 0;
  std::size_t lacking_count_ = 0;
  std::uint32_t complete_parts_ = 0;  // whole_parts, once what they lack is held
  std::uint32_t occluded_part_ = 0;   // that occlusion_ remembers boxes of
  std::array<LodEye, kMostRegions> eyes_;
  // What was chosen of each part, in the order of items().
  struct Chosen {
    std::size_t part = 0;
    SelectLod::Result lod;
    BuildDrawList::Result list;
  };
  std::array<Chosen, kMostRegions> chosen_;
  std::size_t chosen_count_ = 0;
  bool lacking_is_heap_ = false;
  int threshold_set_ = -1;
};

// Whether a is less urgent than b.
inline bool less_urgent(const LackingPatch& a, const LackingPatch& b) {
  return a.px != b.px ? a.px < b.px : a.patch > b.patch;
}

}  // namespace karst::core
