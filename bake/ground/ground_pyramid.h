// SPDX-License-Identifier: MIT
// From rows of samples to the tiles of a ground, of all sizes, in one pass: of each size a few rows are in
// memory. A tile is written when what touches it is measured, after its children.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "terrain/file/world_file.h"
#include "terrain/ground/measure_ground.h"
#include "terrain/ground/tile.h"

namespace karst::bake {
using namespace core;

class GroundPyramid {
 public:
  // Takes the bytes of a tile, in the order in which they lie in TILE. False: it cannot.
  using Write = std::function<bool(std::span<const std::byte>)>;

  // info: samples, steps and regions. regions: of them. quantum: of heights, as TileEncoder has it.
  GroundPyramid(const GroundInfo& info, std::vector<RegionMeasure> regions, double quantum, int threads,
                Write write);
  GroundPyramid(const GroundPyramid&) = delete;
  GroundPyramid& operator=(const GroundPyramid&) = delete;
  ~GroundPyramid();

  // That it takes for rows, without what threads take.
  static std::uint64_t bytes_for(const GroundInfo& info);

  enum class Outcome : std::uint8_t {
    ok,
    too_steep,  // a node's heights are too far apart for its page: steps have to be longer
    unwritten,
  };
  // The next row of samples, info.samples[0] of them within +-kMostHeight, from the north on.
  Outcome push(std::span<const std::int32_t> samples);
  // After the last one: all is written.
  Outcome finish();

  // After finish(): heights, the root, the length of all tiles and their checksum.
  const WorldGround& ground() const { return ground_; }
  std::uint64_t tiles() const { return tiles_; }
  std::uint64_t tiles_of_size(int size) const;

 private:
  struct Level;
  Outcome go_on();
  bool measure_quads_of(int size);
  bool measure_nodes_of(int size);
  Outcome write_tiles_of(int size, bool& wrote);
  void fill_tile(NodeKey key, Tile& tile) const;

  WorldGround ground_;
  std::vector<RegionMeasure> regions_;
  double quantum_;
  int threads_;
  Write write_;
  std::vector<std::unique_ptr<Level>> levels_;
  std::int64_t rows_ = 0;  // of samples
  bool first_ = true;
  std::uint64_t tiles_ = 0;
  struct Workers;
  std::unique_ptr<Workers> workers_;
};

}  // namespace karst::bake
