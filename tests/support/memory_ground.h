// SPDX-License-Identifier: MIT
// A ground in memory for tests: any heights, all its tiles, measures that keep (2) of ground_view.h, and a
// source of tiles that comes late and fails as often as a test wants.
#pragma once

#include <algorithm>
#include <cmath>
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

  // On a plane, that can be dug: four samples are 2^g voxels, steps 2^(11 + g).
  static MemoryGround to_dig(std::int64_t wide, std::int64_t deep, double steps, const Heights& heights);

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

// How far samples are from the triangles of a node, at most, in the unit of at(i, k), which has a height for
// any sample, also beyond the last ones. width, depth: samples of the ground.
template <class At>
double most_off_node(core::NodeKey node, std::int64_t width, std::int64_t depth, const At& at) {
  const std::int64_t unit = std::int64_t{1} << node.size;
  double most = 0;
  for (std::int64_t qz = 4 * std::int64_t{node.z}; qz < 4 * node.z + 4 && (qz + 1) * unit < depth; ++qz) {
    for (std::int64_t qx = 4 * std::int64_t{node.x}; qx < 4 * node.x + 4 && (qx + 1) * unit < width; ++qx) {
      const double a = at(qx * unit, qz * unit), b = at((qx + 1) * unit, qz * unit);
      const double c = at(qx * unit, (qz + 1) * unit), d = at((qx + 1) * unit, (qz + 1) * unit);
      for (std::int64_t k = 0; k <= unit; ++k) {
        for (std::int64_t i = 0; i <= unit; ++i) {
          const double u = static_cast<double>(i) / static_cast<double>(unit);
          const double v = static_cast<double>(k) / static_cast<double>(unit);
          double flat = 0;
          if (((qx + qz) & 1) == 0) {
            flat = u >= v ? a + u * (b - a) + v * (d - b) : a + v * (c - a) + u * (d - c);
          } else {
            flat = u + v <= 1 ? a + u * (b - a) + v * (c - a) : d + (1 - u) * (c - d) + (1 - v) * (b - d);
          }
          most = std::max(most, std::abs(at(qx * unit + i, qz * unit + k) - flat));
        }
      }
    }
  }
  return most;
}

}  // namespace karst::test
