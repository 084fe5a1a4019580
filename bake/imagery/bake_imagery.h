// SPDX-License-Identifier: MIT
// From images over the ground to the tiles of its imagery, of all sizes: the finest by warping the images to
// the ground's grid, coarser ones by halving, row by row, so that of each size a few rows are in memory.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bake/imagery/image_file.h"
#include "bake/imagery/image_texels.h"
#include "bake/pipeline/bake.h"
#include "platform/base/error.h"
#include "terrain/file/world_file.h"

namespace karst::bake {

struct ImageryOptions {
  std::vector<std::string> files;               // later ones over earlier ones; none: there is no imagery
  ImageFormat format = ImageFormat::etc2_rgba;  // etc2_rgba becomes etc2_rgb where images cover all; or rgba8
};

class BakeImagery {
 public:
  struct Report {
    ImageryInfo info;
    std::vector<ImageFacts> images;  // by file
    std::uint64_t tiles = 0;
    std::uint64_t bytes = 0;   // of them
    double texel_samples = 0;  // of the least size
    EncodingError error;       // of the finest tiles of each place
    std::vector<std::string> warnings;
    double seconds = 0;
  };
  // Takes the bytes of a tile, in the order in which they lie in TILE. False: it cannot.
  using Write = std::function<bool(std::span<const std::byte>)>;

  BakeImagery(const ImageryOptions& options, int threads) : options_(options), threads_(threads) {}

  // Looks at the images: what they are, and what of report is known before tiles are made.
  Error open(const GroundGrid& grid, const GroundInfo& ground, Report& report);
  // Makes all tiles; ground gets the imagery, its root, and its tile_bytes and tile_crc go on. What write()
  // cannot take ends it without an error.
  Error run(WorldGround& ground, const Write& write, const ReportProgress& progress, Report& report);

 private:
  struct Quarter;
  struct Level;
  struct Job;

  const ImageryOptions& options_;
  int threads_;
  GroundGrid grid_;
  ImageryInfo info_;
  std::vector<int> sizes_;  // of each image: whose texels are as fine as its pixels
};

}  // namespace karst::bake
