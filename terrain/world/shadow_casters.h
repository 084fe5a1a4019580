// SPDX-License-Identifier: MIT
// Casters of shadows, one for the frame: what a cascade wants (terrain/shadow/select_casters.h) is made
// resident wherever the views look. As long as the pool has room, maps depend neither on that nor on what was
// seen before.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/storage_plan.h"
#include "terrain/draw/draw_list.h"
#include "terrain/shadow/cascades.h"
#include "terrain/world/residency.h"
#include "terrain/world/view_state.h"

namespace karst::core {

// Of a shadow map, as what begins at a corner sees it, voxels from the world's. What floats lose of planes'
// offsets only makes more cast.
Frustum frustum_from(glm::ivec3 corner_voxels, const Frustum& frustum);

class ShadowCasters {
 public:
  struct Result {
    std::span<const DrawItem> items;       // valid until the next select()
    std::span<const std::uint8_t> levels;  // by patch, the same; 0: does not cast
    // Bit n: of part n something casts, and all that is in the box is held.
    std::uint32_t whole_parts = 0;
    std::uint64_t triangles = 0;
    // Patches in the cascade's box that are held coarser than they should cast, or not at all.
    std::uint32_t lacking = 0;
    std::uint64_t hash = 0;  // of the items and their thresholds: the same ones draw the same map
  };

  static void add_to(Budget& budget, const Config& config) { count_blocks<Blocks>(config, budget); }
  // Takes what add_to() counts. config is valid. limit_reached ("memory").
  Status create(const Config& config, Arena& arena);

  // After the frame's last Residency::select(). What casts into the cascade's map, no finer than what is
  // resident, with the settings and the threshold set of the view whose place the maps are around.
  // error_texels: SelectCasters. parts: bit n, of the world's part n; others cast nothing. limit_reached
  // ("max_draw_items") leaves a valid, shorter list.
  Status select(const World& world, Residency& residency, const ViewState& view, const Cascade& cascade,
                double error_texels, std::uint32_t parts, Result& result);
  // Makes vertices for a patch that the last select() lacked, holes first. False: none is left, or there is
  // no room now. status: errors of reading heights. Not after the next Residency::select().
  bool generate_next(Residency& residency, PatchUpload& upload, Status& status);

 private:
  struct Blocks {
    std::span<std::uint8_t> wanted;  // by patch
    std::span<std::uint8_t> levels;  // by patch
    std::span<DrawItem> items;
    std::span<std::uint32_t> lacking;  // one value a patch

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::draw_list, config.max_patches, wanted);
      visit(Consumer::draw_list, config.max_patches, levels);
      visit(Consumer::draw_list, config.max_draw_items, items);
      visit(Consumer::draw_list, config.max_patches, lacking);
    }
  };

  Blocks blocks_;
  std::uint32_t next_ = 0;  // of those that lack something
  std::uint32_t lacking_ = 0;
};

}  // namespace karst::core
