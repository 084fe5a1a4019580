// SPDX-License-Identifier: MIT
// The regions of a ground: where carved shapes meet it, and nowhere else, voxels stand in its place. Shapes
// whose regions would lie nearer to each other than a node share one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bake/carve/carve.h"
#include "bake/elevation/elevation.h"
#include "bake/pipeline/bake.h"
#include "bake/samples/sample_ground.h"
#include "bake/voxels/region_field.h"
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
  bool is_wanted() const { return !job_.carve_path.empty() || job_.can_be_dug || sample_ != nullptr; }
  // Instead of places where shapes meet the ground: a sample's, where its grid has them. Both outlive this.
  // rows are of its ground.
  void stand_on(const Sample& sample, const SampleGrid& grid) {
    sample_ = &sample;
    sample_grid_ = &grid;
  }
  // Chooses rectangles of nodes and the voxel, reads the elevation there, and makes voxels, their surfaces
  // and heights. rows: opened; of one spacing in x and z, else an error that says so.
  Error run(GroundRows& rows);

  struct Region {
    WorldGrid grid;  // origin in the world; the grids of all regions are parts of one
    int first_node[2] = {};
    VoxelSurface surface;
    VoxelSurface::Measures measures;
    RegionMeasure measure;
    std::uint64_t misses = 0, folds_left = 0;
    double deviation_m = 0;
    double seconds = 0;
    std::unique_ptr<RegionField> field;  // instead of patches

    // Of the world file: what it would be shorter without it, but for gaps between sections.
    std::uint64_t bytes() const;
  };
  // After run(). Whether the ground has a lattice of voxels, with regions or without.
  bool has_lattice() const { return sample_steps_ > 0; }
  double voxel_m() const;
  // exists(): some shape meets the ground, or there is a sample.
  bool exists() const { return !regions_.empty(); }
  const std::vector<Region>& regions() const { return regions_; }
  // Where the grids begin, in the world; without regions y is 0.
  const glm::dvec3& origin_m() const { return origin_m_; }
  // Lattice steps between samples.
  double sample_steps() const { return sample_steps_; }
  // Of a world without regions. base_m: what heights count from.
  void tell_lattice(double base_m, WorldInfo& world, GroundInfo& ground) const;
  // The regions' fields of a world, and of its ground.
  void tell(WorldInfo& world, GroundInfo& ground) const;

  std::size_t shapes() const { return shapes_.size(); }
  std::size_t unmet() const { return unmet_; }  // of them, those that do not meet the ground

 private:
  struct Rect {
    int low[2], high[2];  // samples, or nodes
  };

  // A region to be: shapes that hang together, and the nodes they take.
  struct Group {
    Box box;
    Rect nodes{};
  };

  Error take_elevation(GroundRows& rows, const Rect& samples, Elevation& out) const;
  Error choose(const GroundRows& rows, std::vector<Group> groups);
  Error choose_sample();
  void choose_lattice(const GroundRows& rows);
  Error find_nodes(const GroundRows& rows, Group& group) const;
  Error group_up(const GroundRows& rows, std::vector<Group>& groups) const;
  std::vector<Group> meeting(GroundRows& rows, double& radius_m, Error& error);
  Rect around(const Box& box, const GroundRows& rows, double margin_m) const;
  Error make_grids(GroundRows& rows);
  Error make(GroundRows& rows, Region& region, const Rect& nodes, int& level) const;
  Error make_field(const Solid& solid, const WorldGrid& local, const Elevation& piece, int level,
                   Region& region) const;
  static std::vector<glm::dvec3> points_of(const Region& region);
  void measure(const ElevationSurface& ground, const glm::dvec3& centre_m, Region& region) const;
  double node_m() const;
  int voxels_log2(double wanted_m) const;
  int default_level() const;
  int field_level(int level) const;

  const Bake& job_;
  const ReportProgress& progress_;
  const Sample* sample_ = nullptr;
  const SampleGrid* sample_grid_ = nullptr;
  std::vector<CarveShape> shapes_;
  std::size_t unmet_ = 0;
  std::vector<Group> groups_;  // by region
  std::vector<Region> regions_;
  glm::dvec3 origin_m_{0.0};
  int node_voxels_log2_ = 0;
  double sample_steps_ = 0;
  double spacing_m_ = 0;
};

}  // namespace karst::bake
