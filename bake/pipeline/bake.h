// SPDX-License-Identifier: MIT
// From an elevation image or a sample to a world file: solid, voxels, surface, heights, file; and what came
// of it.
#pragma once

#include "bake/elevation/elevation.h"
#include "bake/materials/bake_materials.h"
#include "bake/pipeline/measure_fit.h"
#include "bake/voxels/voxel_surface.h"
#include "platform/base/error.h"
#include "terrain/file/world_file.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace karst::bake {
using namespace core;

// What a ground lies on (terrain/basis/basis.h).
struct BakeBasis {
  enum class Kind : std::uint8_t { plane, geographic, cube, cylinder, function };
  Kind kind = Kind::plane;
  // Of a cylinder, below 0 inside; 0: as wide as the DEM. Of a function the least radius of its curvature.
  double radius_m = 0;
};

struct Bake {
  // What: an elevation image (read.path), a sample by name, or features.
  ReadElevation read;
  std::string sample{};
  std::string features_path{};  // a land of features (bake/features/feature_map.h)
  bool accept_fit = false;      // a world that misses its elevation by more than a voxel is none, else
  bool leave_holes = false;     // voids of the image: left out of the world, else filled

  BakeBasis basis{};   // of a ground
  double voxel_m = 0;  // 0: the sample's, or so that about 128 voxels span the image
  int level = 0;       // of the heights; 0: the sample's, or vertices about 3/4 of a sample apart
  std::optional<double> water_m{};  // height of still water; none: the world has none
  std::string carve_path{};         // empty: nothing is carved
  bool carves_field = false;        // of a ground: an isosurface stands where shapes are, no patches
  bool can_be_dug = false;          // a ground: wherever edits dig, voxels of voxel_m may stand
  int max_carve = 0;  // columns that all shapes may reach together; CarvedSolid has what is free
  MaterialOptions materials{};
  int threads = 1;  // >= 1; the result does not depend on it

  struct Report {
    // The image; zeros for a sample.
    int width = 0, height = 0;
    double spacing_x_m = 0, spacing_z_m = 0;
    double void_share = 0;
    double lowest_m = 0, highest_m = 0;  // of the heights, voids filled
    std::vector<std::string> warnings;   // a line each, without a full stop
    std::string source;

    WorldInfo info;
    std::uint64_t filled_voxels = 0;
    std::uint64_t voxels_settled = 0;  // changed by SettleVoxels
    std::size_t carve_shapes = 0;
    Surroundings surroundings;
    std::size_t sunk_samples = 0;                      // of the image, by SinkSea
    std::uint64_t vertices = 0, misses = 0;            // misses: no surface within reach of the vertex
    std::uint64_t folds_repaired = 0, folds_left = 0;  // triangles, in the sense of RepairFolds
    double quantisation_m = 0;              // kVertexStep; coordinates are off by half of it at most
    std::optional<MeasureFit::Result> fit;  // of height fields: with an image
    bool fit_is_partial = false;            // holes and carved places are left out of fit
    BakedMaterials materials;
    double seconds_read = 0, seconds_voxels = 0, seconds_fit = 0, seconds_measure = 0;
    double seconds_write = 0;  // levels, materials, and the bytes of the file
  };

  // file: the bytes of the world file; nothing is written.
  Error run(Report& report, const ReportProgress& progress, std::vector<std::byte>& file) const;
};

}  // namespace karst::bake
