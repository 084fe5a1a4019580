// SPDX-License-Identifier: MIT
// From a solid to voxels, their surface and its heights: what a world of voxels is made of, and the region of
// a ground.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bake/elevation/solid.h"
#include "platform/base/error.h"
#include "terrain/field/octree.h"
#include "terrain/file/world_file.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/patch/bounds.h"
#include "terrain/surface/patch.h"

namespace karst::bake {
using namespace core;

// Work of the whole bake, for progress bars: which stage, how much of it is done.
using ReportProgress = std::function<void(const char* stage, std::uint64_t done, std::uint64_t total)>;

// "stage: field: what" of a status that is not ok.
Error failure(const Status& status, const char* stage);

class VoxelSurface {
 public:
  // Before all else. progress outlives this.
  void create(const WorldGrid& grid, int threads, bool mirrors, const ReportProgress& progress) {
    grid_ = grid;
    threads_ = threads;
    mirrors_ = mirrors;  // what is beyond the sides: VoxelReader
    progress_ = &progress;
  }

  // Voxels, by one of these: below column tops (VoxelizeHeights), or where their centre is in the solid,
  // settled (SettleVoxels). The topmost layer stays air.
  Error fill_below(std::span<const float> tops);
  Error fill(const Solid& solid);
  std::uint64_t settled() const { return settled_; }

  // The surface. level: of the heights; may_lower: so far as a GPU holds all of it. The error names --voxel
  // or --levels where it is too large.
  Error extract(int level, bool may_lower);

  struct Fit {
    std::uint64_t vertices = 0, misses = 0;            // misses: no surface within reach of the vertex
    std::uint64_t folds_repaired = 0, folds_left = 0;  // triangles, in the sense of RepairFolds
  };
  // One chunk of patches in kTriedChunks, the first and so on, is fitted before the others; then judge(),
  // which may be empty, says whether these need be tried. Its error, if any.
  static constexpr std::size_t kFitChunk = 32;  // patches
  static constexpr std::size_t kTriedChunks = 16;
  using Judge = std::function<Error()>;
  Error fit(const Solid& solid, bool is_height_field, const Judge& judge, Fit& made);

  struct Measures {
    std::vector<std::uint16_t> level_errors;
    std::vector<PatchBounds> bounds;
    std::vector<NormalCone> cones, shading_cones;
  };
  Measures measure() const;

  const Octree& octree() const { return octree_; }
  Surface surface() const { return {volumes_, patches_}; }
  Heights heights() const { return {level_, heights_}; }
  // All of them have heights, in the order of keys.
  std::vector<PatchKey> keys(std::uint32_t region = 0) const;
  std::vector<std::byte> mask() const;
  // Its fields of a world, without a name.
  void tell(WorldInfo& info) const;

 private:
  Error make_octree(std::uint32_t max_octets);

  WorldGrid grid_;
  int threads_ = 1;
  bool mirrors_ = false;
  const ReportProgress* progress_ = nullptr;
  int level_ = 0;
  std::uint64_t settled_ = 0;
  std::unique_ptr<std::byte[]> memory_;  // of the octree's pool
  Octree octree_;
  std::vector<Volume> volumes_;
  std::vector<Patch> patches_;
  std::vector<std::int16_t> heights_;
};

}  // namespace karst::bake
