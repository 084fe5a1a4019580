// SPDX-License-Identifier: MIT
// Apart from the edits themselves, so that programs that make none do not hold their code.
#include "terrain/base/storage_plan.h"
#include "terrain/edit/ground/edit_ground.h"

namespace karst::core {

void EditGround::add_to(Budget& budget, const Limits& limits) {
  Blocks blocks;
  blocks.each_block(limits, CountBlocks(budget));
}

Status EditGround::create(const Limits& limits, Arena& arena) {
  TakeBlocks take(arena);
  blocks_.each_block(limits, take);
  overlay_.create(blocks_.overlay);
  file_.create(blocks_.file);
  info_ = {};
  if (take.complete()) return {};
  return {StatusCode::limit_reached, "the memory given is smaller than the budget", "memory"};
}

void EditGround::attach(const GroundInfo& info, const Tile& root, const TileSource& file,
                        const TileReading& reading) {
  info_ = info;
  overlay_.reset(file, reading);
  growths_ = {};
  reserved_ = 0;
  trouble_ = {};
  waiting_ = 0;
  if (overlay_.capacity() > 0) file_.reset(tile_of({info.top_size(), 0, 0}), root, reading);
}

}  // namespace karst::core
