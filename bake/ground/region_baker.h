// SPDX-License-Identifier: MIT
// The region of a ground: where carved shapes meet it, and nowhere else, voxels stand in its place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bake/carve/carve.h"
#include "bake/elevation/elevation.h"
#include "bake/pipeline/bake.h"
#include "bake/samples/sample_ground.h"
#include "bake/voxels/voxel_surface.h"
#include "platform/base/error.h"
#include "terrain/ground/ground.h"
#include "terrain/ground/measure_ground.h"

namespace karst::bake {

class GroundRows;

class RegionBaker {
 public:
  // What concerns carving, voxels and threads; both outlive this.
  RegionBaker(const Bake& job, const ReportProgress& progress) : job_(job), progress_(progress) {}

  // Reads the shapes. An error names --carve and the shape.
  Error load();
  bool is_wanted() const { return !job_.carve_path.empty() || sample_ != nullptr; }
  // Instead of places where shapes meet the ground: a sample's, where its grid has them. Both outlive this.
  // rows are of its ground.
  void stand_on(const Sample& sample, const SampleGrid& grid) {
    sample_ = &sample;
    sample_grid_ = &grid;
  }
  // Chooses the rectangle of nodes and the voxel, reads the elevation there, and makes its voxels, surface
  // and heights. rows: opened; of one spacing in x and z, else an error that says so.
  Error run(GroundRows& rows);

  // After run(). exists(): some shape meets the ground.
  bool exists() const { return exists_; }
  const VoxelSurface& surface() const { return surface_; }
  const VoxelSurface::Measures& measures() const { return measures_; }
  const WorldGrid& grid() const { return grid_; }
  // Its first node, and lattice steps between samples.
  int first_node(int axis) const { return first_node_[axis]; }
  double sample_steps() const { return sample_steps_; }
  const RegionMeasure& measure() const { return measure_; }

  struct Report {
    std::size_t shapes = 0, unmet = 0;  // unmet: of them, those that do not meet the ground
    double size_m[3] = {};
    std::uint64_t misses = 0, folds_left = 0;
    double deviation_m = 0;
    double seconds = 0;
  };
  const Report& report() const { return report_; }

 private:
  struct Rect {
    int low[2], high[2];  // samples, or nodes
  };

  Error take_elevation(GroundRows& rows, const Rect& samples, Elevation& out) const;
  Error choose(GroundRows& rows, const std::vector<std::size_t>& meeting);
  Error choose_sample();
  std::vector<std::size_t> meeting(GroundRows& rows, Error& error) const;
  Rect around(const Box& box, const GroundRows& rows, double margin_m) const;
  Error make(GroundRows& rows);
  void measure(const ElevationSurface& ground);

  const Bake& job_;
  const ReportProgress& progress_;
  const Sample* sample_ = nullptr;
  const SampleGrid* sample_grid_ = nullptr;
  std::vector<CarveShape> shapes_;
  bool exists_ = false;
  WorldGrid grid_;  // origin in the world
  int first_node_[2] = {};
  int node_voxels_log2_ = 0;
  double sample_steps_ = 0;
  double spacing_m_ = 0;
  Rect nodes_{};
  glm::dvec3 piece_centre_m_{0.0};  // of the piece of elevation, in the world; y 0
  VoxelSurface surface_;
  VoxelSurface::Measures measures_;
  RegionMeasure measure_;
  Report report_;
};

}  // namespace karst::bake
