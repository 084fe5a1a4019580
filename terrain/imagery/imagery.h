// SPDX-License-Identifier: MIT
// The imagery of a world, for all eyes: what of it is on the GPU, and what each view needs of it.
//
//   each frame, after the ground's views are selected:
//     imagery.begin_frame();
//     while (imagery.poll(layer, arrival)) copy arrival.texels to the layer
//     for each view: imagery.select(view, ground.view(view), request);
//     imagery.ask();
//     for each view: for (size; (size = imagery.take_size(view, part)) >= 0;) copy the part of its table
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/storage_plan.h"
#include "terrain/imagery/image_cache.h"
#include "terrain/imagery/image_view.h"

namespace karst::core {

class Imagery {
 public:
  Imagery() = default;
  Imagery(const Imagery&) = delete;
  Imagery& operator=(const Imagery&) = delete;

  static void add_to(Budget& budget, const Config& config) { count_blocks<Blocks>(config, budget); }
  // Takes what add_to() counts. config is valid. limit_reached ("memory").
  Status create(const Config& config, Arena& arena);

  // Begins anew; the source is borrowed until the next attach(). Precondition: memory for a tile.
  void attach(const GroundInfo& ground, const ImageryInfo& imagery, const TilePlace& root,
              const ImageSource& source);
  // There is none.
  void detach() { info_ = {}; }
  bool exists() const { return info_.exists(); }
  const ImageryInfo& info() const { return info_; }
  // Forgets what is on the GPU.
  void forget();

  void begin_frame() { cache_.begin_frame(); }
  bool poll(std::int32_t& layer, ImageArrival& out) { return cache_.poll(layer, out); }
  bool wait() { return cache_.wait(); }
  void ask(bool all = true) { cache_.ask(all); }
  // Until what is asked for now will come.
  double frames_to_come() const { return cache_.frames_to_come(); }
  ImageCache& cache() { return cache_; }
  // Precondition: exists().
  void select(std::size_t view, const GroundView& ground, const ImageRequest& request) {
    views_[view].select(ground_, info_, ground, request, cache_);
  }
  // The next part of a view's table that the GPU lacks, after all that came was copied; -1: none.
  int take_size(std::size_t view, std::span<const std::uint16_t>& part) {
    views_[view].make_table(cache_);
    return views_[view].take_size(part);
  }
  const ImageView& view(std::size_t n) const { return views_[n]; }
  const TileSlots::Counts& counts() const { return cache_.counts(); }

 private:
  struct Blocks {
    ImageCache::Storage cache;
    std::array<ImageView::Storage, kMostViews> views;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      cache.each_block(config, visit);
      for (std::size_t n = 0; n < config.max_views; ++n) views[n].each_block(config, visit);
    }
  };

  GroundInfo ground_;
  ImageryInfo info_;
  Blocks blocks_;
  ImageCache cache_;
  std::array<ImageView, kMostViews> views_;
};

}  // namespace karst::core
