// SPDX-License-Identifier: MIT
// A ground in memory for tests: any heights, all its tiles, measures that keep (2) of ground_view.h, and a
// source of tiles that comes late and fails as often as a test wants.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <tuple>
#include <vector>

#include "terrain/ground/ground.h"
#include "terrain/ground/measure_ground.h"
#include "terrain/ground/tile.h"
#include "terrain/paging/tile_source.h"

namespace karst::test {

// Voxels of an extent as a region, from node (x, z) on.
struct MemoryRegion {
  int extent_x = 0, extent_z = 0;
  int x = 0, z = 0;
  core::RegionMeasure measure = {};
  int extent_y = 511;
  int y = 0;  // of its corner
};

class MemoryGround {
 public:
  using Heights = std::function<std::int32_t(std::int64_t i, std::int64_t k)>;  // kVertexStep
  // Error of a node of size 1 and more, lattice steps, before (2) raises its threshold.
  using Errors = std::function<float(core::NodeKey)>;

  MemoryGround(std::int64_t wide, std::int64_t deep, double step_x, double step_z, const Heights& heights,
               const Errors& errors, const std::vector<MemoryRegion>& regions = {});
  // Of any basis: samples, steps and basis of shape.
  MemoryGround(const core::GroundInfo& shape, const Heights& heights, const Errors& errors);
  MemoryGround(const core::GroundInfo& shape, const Heights& heights);
  // With what measure_ground.h measures.
  MemoryGround(std::int64_t wide, std::int64_t deep, double step_x, double step_z, const Heights& heights,
               const std::vector<MemoryRegion>& regions = {});

  const core::GroundInfo& info() const { return info_; }
  core::NodeKey root() const { return {info_.top_size(), 0, 0}; }  // of a cube, in its tile
  const core::Tile& tile(core::NodeKey key) const;
  std::size_t tile_count() const { return tiles_.size(); }

  // Each poll brings one that was asked for with this chance, or fails with that one.
  struct Source {
    explicit Source(const MemoryGround& from) : ground(&from) { asked.reserve(most_under_way); }
    const MemoryGround* ground;
    double comes = 1;
    double fails = 0;
    std::size_t most_under_way = 4;
    std::mt19937 random{1};
    std::vector<core::NodeKey> asked{};
    std::uint64_t asks = 0;

    core::TileSource source();
  };

 private:
  using Key = std::tuple<int, int, int>;
  static Key key_of(core::NodeKey key) { return {key.size, key.x, key.z}; }
  void make_tiles(const Heights& heights, const std::vector<MemoryRegion>& regions);
  // Of a size.
  void for_each_node(int size, const std::function<void(core::NodeKey)>& take) const;
  void make_tile(core::NodeKey key, const Heights& heights);
  void measure(const Errors& errors);
  void measure(const Heights& heights);
  core::NodeMeasure* measure_of(core::NodeKey node);

  core::GroundInfo info_;
  std::vector<core::RegionMeasure> regions_;
  std::map<Key, core::Tile> tiles_;
};

}  // namespace karst::test
