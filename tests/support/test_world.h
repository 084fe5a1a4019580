// SPDX-License-Identifier: MIT
// Small worlds for tests: random voxel fields, their surface, and heights that are a function of position
// alone, so that patches agree wherever they share a vertex.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "terrain/field/octree.h"
#include "terrain/file/world_writer.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

namespace karst::test {
using namespace core;

// A 64-bit mix (SplitMix64, Steele et al. 2014): test data must not depend on the standard library's
// generators.
std::uint64_t mix(std::uint64_t x);

struct Random {
  std::uint64_t state;
  std::uint64_t next() { return mix(state++); }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  int below(int n) { return static_cast<int>(next() % static_cast<std::uint64_t>(n)); }
};

// Smooth value noise in [-1, 1], wavelength 1.
double value_noise(std::uint64_t seed, glm::dvec3 p);

class TestWorld {
 public:
  // filled(voxel) is asked for every voxel of the extent; depth is the least that holds it.
  // mirrors: beyond the sides lies their mirror (VoxelReader).
  TestWorld(glm::ivec3 extent, const std::function<bool(glm::ivec3)>& filled, bool mirrors = false);

  // White noise of the given density, or smooth noise of the given wavelength in voxels (0 is white). With
  // `closed` the outermost voxels are empty, so the surface has no border.
  static TestWorld noise(std::uint64_t seed, glm::ivec3 extent, double density, double wavelength,
                         bool closed);

  // Gentle hills, 5 voxels high in the mean; enough for tests of programs. Without heights.
  static TestWorld hills(glm::ivec3 extent = {16, 12, 14});

  // Gives every patch heights at `level`: a hash of the undisplaced position, within +-amplitude steps.
  void roughen(int level, std::uint64_t seed, int amplitude);
  void set_heights(int level, const std::function<double(glm::dvec3 base_voxels)>& height_steps);

  const Octree& octree() const { return octree_; }
  Octree& octree() { return octree_; }
  glm::ivec3 extent() const { return extent_; }
  Surface surface() const { return {volumes_, patches_}; }
  Heights heights() const { return {level_, heights_}; }
  std::vector<Patch>& patches() { return patches_; }
  std::vector<std::int16_t>& height_samples() { return heights_; }
  // One block a patch, as FitHeights makes them.
  void set_samples(int level, std::vector<std::int16_t> samples) {
    level_ = level;
    heights_ = std::move(samples);
    for (PatchId p = 0; p < patches_.size(); ++p) patches_[p].height_block = p;
  }

  // Of its heights: LevelErrors::values.
  std::vector<std::uint16_t> level_errors() const;

  // Of its patches at their full level.
  std::vector<PatchBounds> bounds() const;
  std::vector<NormalCone> cones() const;
  std::vector<NormalCone> shading_cones() const;

  // The world as a .karst file: what WorldWriter makes of it. Without heights no patch has a block.
  core::WorldInfo info() const;
  std::vector<PatchKey> keys() const;
  std::vector<std::byte> file(const WorldMaterials& materials = WorldMaterials()) const;
  double voxel_size_m = 1;

  // Vertices of one patch in slot order.
  std::vector<GpuVertex> vertices(PatchId patch, int level) const;

 private:
  glm::ivec3 extent_;
  std::vector<std::byte> memory_;
  Octree octree_;
  std::vector<Volume> volumes_;
  std::vector<Patch> patches_;
  int level_ = kMaxLevel;
  std::vector<std::int16_t> heights_;
};

// Memory aligned for an arena.
class AlignedBytes {
 public:
  explicit AlignedBytes(std::size_t size);
  std::span<std::byte> bytes() const { return bytes_; }

 private:
  std::vector<std::byte> memory_;
  std::span<std::byte> bytes_;
};

// Working memory for GenerateVertices.
class TestScratch {
 public:
  TestScratch();
  PatchScratch* get() const { return scratch_; }

 private:
  AlignedBytes memory_;
  PatchScratch* scratch_;
};

}  // namespace karst::test
