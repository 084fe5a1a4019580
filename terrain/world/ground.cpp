// SPDX-License-Identifier: MIT
#include "terrain/world/ground.h"

#include "terrain/base/check.h"

namespace karst::core {

void Ground::add_to(Budget& budget, const Config& config) {
  count_blocks<Blocks>(config, budget);
}

Status Ground::create(const Config& config, Arena& arena) {
  info_ = {};
  view_count_ = view_count(config);
  if (const Status status = take_blocks(config, arena, blocks_); !status.ok()) return status;
  tiles_.create(blocks_.tiles);
  pool_.create(blocks_.pool);
  for (std::size_t n = 0; n < view_count_; ++n) views_[n].create(blocks_.views[n]);
  return {};
}

void Ground::attach(const GroundInfo& info, const Tile& root, const TileSource& source) {
  KARST_ASSERT(info.exists() && view_count_ > 0);
  info_ = info;
  belt_counts_ = {};
  const NodeKey key{info.top_size(), 0, 0};
  tiles_.reset(source, tile_of(key), root);
  forget();
}

void Ground::forget() {
  pool_.reset();
  for (std::size_t n = 0; n < view_count_; ++n) views_[n].reset();
  for (Turn& turn : turns_) turn = {};
}

void Ground::begin_frame() {
  tiles_.begin_frame();
  pool_.begin_frame();
  for (Turn& turn : turns_) turn = {};
}

void Ground::select(std::size_t view, const GroundRequest& request) {
  KARST_ASSERT(exists() && view < view_count_);
  views_[view].select(info_, request, tiles_, pool_);
  turns_[view] = {0, true};
}

std::size_t Ground::add_belt(std::size_t view, BuildBelts belts) {
  KARST_ASSERT(exists() && view < view_count_);
  if ((views_[view].result().regions >> belts.region & 1u) == 0) return 0;
  belts.info = &info_;
  belts.view = &views_[view];
  belts.out = blocks_.belts[view].subspan(belt_counts_[view]);
  const std::size_t count = belts.run();
  belt_counts_[view] += count;
  return count;
}

bool Ground::next_node(NodeUpload& upload) {
  for (std::size_t v = 0; v < view_count_; ++v) {
    if (!turns_[v].selected) continue;
    const std::span<const DrawItem> items = views_[v].items();
    for (std::size_t& at = turns_[v].item; at < items.size(); ++at) {
      const GroundView::Node& node = views_[v].node_of(at);
      const int quadrant = node.key.quadrant();
      if (pool_.is_filled(node.parent_family, quadrant)) continue;
      const bool is_root = node.key.size == info_.top_size();
      MakeNode make;
      make.info = &info_;
      make.tile = node.tile;
      make.node = node.key;
      make.morphs = !is_root;
      make.out = vertices_;
      make.run();
      pool_.set_filled(node.parent_family, quadrant);
      upload.page = items[at].patch;
      upload.row = is_root ? 0 : node.parent_family + 1;
      upload.size = info_.page_size(node.key.size);
      upload.quadrant = quadrant;
      upload.key = node.key;
      upload.origin = node_origin(info_, node.tile->nodes[node_in_tile(node.key)], node.key);
      upload.vertices = vertices_;
      return true;
    }
  }
  return false;
}

}  // namespace karst::core
