// SPDX-License-Identifier: MIT
// From elevation to a world whose ground is tiles, row by row, in memory that does not grow with the number
// of rows.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/ground/region_baker.h"
#include "bake/imagery/bake_imagery.h"
#include "bake/materials/bake_materials.h"
#include "bake/pipeline/bake.h"
#include "platform/base/error.h"
#include "terrain/file/world_file.h"

namespace karst::bake {

struct BakeGround {
  // What concerns the elevation, water, shapes, voxels of a region, materials and threads.
  const Bake& job;
  std::string output;  // of the world file; written whole or not at all
  ImageryOptions imagery = {};

  struct Report {
    int width = 0, height = 0;
    double spacing_x_m = 0, spacing_z_m = 0;
    std::uint64_t voids = 0;
    double lowest_m = 0, highest_m = 0;  // voids filled
    std::string source;
    std::vector<std::string> warnings;
    WorldInfo info;
    WorldGround ground;
    std::uint64_t tiles = 0;
    std::uint64_t bytes_tiles = 0;  // of them, without imagery
    std::uint64_t bytes = 0;        // of the file
    std::size_t sunk_samples = 0;   // by SinkSea
    int attempts = 1;               // the first one with the finest steps
    BakedMaterials materials;
    // Of each region; bytes: of the file.
    struct Region {
      glm::ivec3 extent{0};  // voxels
      std::uint64_t patches = 0, bytes = 0;
      std::uint64_t field_triangles = 0;  // of an isosurface at its finest; 0: there are patches
      std::uint32_t field_blocks = 0;     // that take samples
      double cell_m = 0;
      std::uint64_t misses = 0, folds_left = 0;
      double deviation_m = 0, seconds = 0;
    };
    std::vector<Region> regions;
    std::size_t shapes = 0, unmet = 0;                // unmet: of them, those that do not meet the ground
    BakeImagery::Report imagery;                      // of no files: there is none
    double seconds_materials = 0, seconds_tiles = 0;  // tiles: with reading
  };
  Error run(Report& report, const ReportProgress& progress) const;
};

std::string ground_report_text(const Bake& job, const BakeGround::Report& report, double seconds);
std::string ground_report_json(const BakeGround& job, const BakeGround::Report& report, double seconds);

}  // namespace karst::bake
