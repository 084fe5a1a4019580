// SPDX-License-Identifier: MIT
// What edits a ground in memory that stays as it is.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/edit/ground/edit_ground.h"
#include "tests/support/memory_ground.h"
#include "tests/support/test_world.h"

namespace karst::test {

class GroundEditor {
 public:
  // from: outlives it.
  GroundEditor(const MemoryGround& from, std::uint32_t tiles) : file_(from), source_(from) {
    Budget budget;
    EditGround::add_to(budget, {tiles, 0});
    memory_ = AlignedBytes(static_cast<std::size_t>(budget.cpu_bytes()));
    Arena arena(memory_.bytes());
    EXPECT_TRUE(edits.create({tiles, 0}, arena).ok());
    edits.attach(
        from.info(), from.tile(tile_of(from.root())), source_.source(),
        {&from, [](const void* context, NodeKey key, const TilePlace&, std::span<std::byte>, Tile& out) {
           out = static_cast<const MemoryGround*>(context)->tile(key);
           return Status();
         }});
  }
  const Tile& tile(NodeKey key) const {
    const EditedTile* const edited = edits.overlay().find(key);
    return edited != nullptr ? edited->tile : file_.tile(key);
  }
  std::int32_t sample(std::int64_t i, std::int64_t k) {
    std::int32_t height = 0;
    EXPECT_TRUE(edits.height(i, k, height).ok());
    return height;
  }
  template <class Visit>
  void each_node(const Visit& visit) const {
    const GroundInfo& info = file_.info();
    for (int size = 0; size <= info.top_size(); ++size) {
      for (int z = 0; z < nodes_along(info, 1, size); ++z) {
        for (int x = 0; x < nodes_along(info, 0, size); ++x) visit(NodeKey{size, x, z});
      }
    }
  }
  const NodeMeasure& measure(NodeKey node) const { return tile(tile_of(node)).nodes[node_in_tile(node)]; }

  EditGround edits;

 private:
  const MemoryGround& file_;
  MemoryGround::Source source_;
  AlignedBytes memory_{0};
};

}  // namespace karst::test
