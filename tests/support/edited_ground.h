// SPDX-License-Identifier: MIT
// A ground in memory that is edited, and random edits of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/edit/ground/edit_ground.h"
#include "terrain/lod/morph.h"
#include "tests/support/memory_ground.h"

namespace karst::test {
using namespace core;

inline constexpr double kGroundStep = 8192;  // a voxel from sample to sample

// A ground in memory, and its samples as edits leave them, one by one.
class EditedGround {
 public:
  // height_of: other heights than rough hills.
  EditedGround(std::int64_t wide, std::int64_t deep, std::uint32_t tiles,
               const MemoryGround::Heights& height_of = {})
      : wide_(wide),
        samples_(make_samples(wide, deep, height_of)),
        file_(wide, deep, kGroundStep, kGroundStep, heights(samples_)),
        source_(file_) {
    Budget budget;
    EditGround::add_to(budget, {tiles, 0});
    memory_.resize(budget.cpu_bytes() + Arena::kAlignment);
    void* at = memory_.data();
    std::size_t room = memory_.size();
    std::align(Arena::kAlignment, budget.cpu_bytes(), at, room);
    Arena arena({static_cast<std::byte*>(at), budget.cpu_bytes()});
    EXPECT_TRUE(editor.create({tiles, 0}, arena).ok());
    EXPECT_EQ(arena.used(), budget.cpu_bytes());
    editor.attach(
        file_.info(), file_.tile(tile_of(file_.root())), source_.source(),
        {&file_, [](const void* context, NodeKey key, const TilePlace&, std::span<std::byte>, Tile& out) {
           out = static_cast<const MemoryGround*>(context)->tile(key);
           return Status();
         }});
  }

  const MemoryGround& file() const { return file_; }
  MemoryGround::Heights heights(const std::vector<std::int32_t>& of) const {
    return [&of, wide = wide_](std::int64_t i, std::int64_t k) {
      return of[static_cast<std::size_t>(k * wide + i)];
    };
  }
  const Tile& tile(NodeKey key) const {
    const EditedTile* const edited = editor.overlay().find(key);
    return edited != nullptr ? edited->tile : file_.tile(key);
  }
  // Of all samples, by the tiles of size 0.
  std::vector<std::int32_t> samples() const {
    std::vector<std::int32_t> all(samples_.size());
    const std::int64_t deep = static_cast<std::int64_t>(all.size()) / wide_;
    for (std::int64_t k = 0; k < deep; ++k) {
      for (std::int64_t i = 0; i < wide_; ++i) {
        const std::int64_t x = std::min(i / kTileQuads, (wide_ - 2) / kTileQuads);
        const std::int64_t z = std::min(k / kTileQuads, (deep - 2) / kTileQuads);
        all[static_cast<std::size_t>(k * wide_ + i)] =
            tile({0, static_cast<int>(x), static_cast<int>(z)})
                .height(static_cast<int>(i - x * kTileQuads), static_cast<int>(k - z * kTileQuads));
      }
    }
    return all;
  }

  void settle() {
    for (GroundChange change; !editor.is_settled();) editor.settle_some(change);
  }
  // Heights and measures of all tiles of all sizes, once they are measured.
  std::vector<std::byte> facts() {
    settle();
    std::vector<std::byte> all;
    const auto put = [&](const auto& value) {
      const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
      all.insert(all.end(), bytes, bytes + sizeof value);
    };
    const GroundInfo& info = file_.info();
    for (int size = 0; size <= info.top_size(); ++size) {
      for (int z = 0; z <= (nodes_along(info, 1, size) - 1) / kTileNodes; ++z) {
        for (int x = 0; x <= (nodes_along(info, 0, size) - 1) / kTileNodes; ++x) {
          const Tile& one = tile({size, x, z});
          put(one.heights);
          for (const NodeMeasure& node : one.nodes) {
            put(node.low);
            put(node.high);
            put(node.thresholds);
          }
        }
      }
    }
    return all;
  }

  EditGround editor;

 private:
  static std::vector<std::int32_t> make_samples(std::int64_t wide, std::int64_t deep,
                                                const MemoryGround::Heights& height_of) {
    std::vector<std::int32_t> out;
    std::mt19937 random(7);
    for (std::int64_t k = 0; k < deep; ++k) {
      for (std::int64_t i = 0; i < wide; ++i) {
        if (height_of) {
          out.push_back(height_of(i, k));
          continue;
        }
        out.push_back(static_cast<std::int32_t>(9000 * std::sin(0.05 * static_cast<double>(i)) *
                                                std::cos(0.03 * static_cast<double>(k))) +
                      static_cast<std::int32_t>(random() % 600));
      }
    }
    return out;
  }

  std::int64_t wide_;
  std::vector<std::int32_t> samples_;
  MemoryGround file_;
  MemoryGround::Source source_;
  std::vector<std::byte> memory_;
};

inline Edit random_ground_edit(std::mt19937& random, double wide, double deep) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  constexpr EditTool kTools[] = {EditTool::extrude, EditTool::smooth, EditTool::noise, EditTool::flatten,
                                 EditTool::level};
  constexpr BrushShape kShapes[] = {BrushShape::sphere, BrushShape::cylinder, BrushShape::box,
                                    BrushShape::capsule};
  Edit edit;
  edit.tool = kTools[random() % 5];
  edit.shape = kShapes[random() % 4];
  edit.place = {between(-3, wide + 3), between(-2, 2), between(-3, deep + 3)};
  edit.to = edit.place + glm::dvec3(between(-9, 9), 0, between(-9, 9));
  edit.half = {between(1, 9), 4, between(1, 9)};
  edit.up = {between(-0.3, 0.3), 1, between(-0.3, 0.3)};
  edit.radius = between(1, 12);
  edit.strength = between(-1, 1);
  edit.amount = between(0, 1);
  edit.hardness = between(0, 1);
  edit.wave = between(2, 20);
  edit.seed = static_cast<std::uint32_t>(random());
  return edit;
}

// Heights and least and greatest ones of all sizes, thresholds of those that follow from samples alone; of
// coarser ones that none is less than what is made of the samples. Returns how many thresholds differ.
inline std::size_t expect_as_made(EditedGround& edited, const char* when) {
  edited.settle();
  const std::vector<std::int32_t> samples = edited.samples();
  const GroundInfo& info = edited.file().info();
  const MemoryGround made(info.samples[0], info.samples[1], info.steps[0], info.steps[1],
                          edited.heights(samples));
  EXPECT_EQ(edited.editor.info().low, made.info().low) << when;
  EXPECT_EQ(edited.editor.info().high, made.info().high) << when;
  std::size_t off = 0;
  for (int size = 0; size <= info.top_size(); ++size) {
    for (int z = 0; z <= (nodes_along(info, 1, size) - 1) / kTileNodes; ++z) {
      for (int x = 0; x <= (nodes_along(info, 0, size) - 1) / kTileNodes; ++x) {
        const Tile& own = edited.tile({size, x, z});
        const Tile& other = made.tile({size, x, z});
        EXPECT_EQ(std::memcmp(own.heights, other.heights, sizeof own.heights), 0)
            << when << ": heights of " << size << " " << x << " " << z;
        for (int n = 0; n < kTileMeasures; ++n) {
          EXPECT_EQ(own.nodes[n].low, other.nodes[n].low)
              << when << " " << size << " " << x << " " << z << " " << n;
          EXPECT_EQ(own.nodes[n].high, other.nodes[n].high) << when << " " << size;
          for (std::size_t d = 0; d < kDemands; ++d) {
            if (size <= kReferenceSizes) {
              EXPECT_EQ(own.nodes[n].thresholds[d], other.nodes[n].thresholds[d])
                  << when << ": node " << n << " of " << size << " " << x << " " << z;
            } else {
              off += own.nodes[n].thresholds[d] != other.nodes[n].thresholds[d] ? 1 : 0;
            }
          }
          if (testing::Test::HasFailure()) return off;
        }
      }
    }
  }
  return off;
}

}  // namespace karst::test
