// SPDX-License-Identifier: MIT
#include "terrain/imagery/imagery.h"

#include "terrain/base/check.h"

namespace karst::core {

Status Imagery::create(const Config& config, Arena& arena) {
  info_ = {};
  if (const Status status = take_blocks(config, arena, blocks_); !status.ok()) return status;
  cache_.create(blocks_.cache);
  for (std::size_t n = 0; n < config.max_views; ++n) views_[n].create(blocks_.views[n]);
  return {};
}

void Imagery::attach(const GroundInfo& ground, const ImageryInfo& imagery, const TilePlace& root,
                     const ImageSource& source) {
  KARST_ASSERT(ground.exists() && imagery.exists());
  ground_ = ground;
  info_ = imagery;
  cache_.reset(source, {image_top_size(ground), 0, 0}, root);
  forget();
}

void Imagery::forget() {
  if (!exists()) return;
  cache_.forget();
  for (ImageView& view : views_) view.reset();
}

}  // namespace karst::core
