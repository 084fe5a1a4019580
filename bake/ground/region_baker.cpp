// SPDX-License-Identifier: MIT
#include "bake/ground/region_baker.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <unordered_map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/elevation/elevation_solid.h"
#include "bake/ground/ground_rows.h"
#include "terrain/base/check.h"
#include "terrain/base/lattice.h"
#include "terrain/measure/level_error.h"
#include "terrain/patch/displacement.h"
#include "terrain/regions/region_rim.h"
#include "terrain/surface/patch.h"

namespace karst::bake {
namespace {

// From a shape's reach to the region's sides: so far gradients and heights look.
constexpr int kMarginVoxels = 4;
constexpr int kMarginSamples = 4;  // of elevation around the region
// Voxels to the radius of the smallest shape, by default.
constexpr double kVoxelsARadius = 2;
// Distance of vertices by default, in samples.
constexpr double kSamplesPerVertex = 0.75;
// Voxels along a sample's sides in which it becomes the ground.
constexpr double kJoinVoxels = 3.5;
// Of the points of a surface that are compared with the ground: coarser ones are further from it.
constexpr int kMeasuredLevel = 3;
constexpr double kGroundPointVoxels = 0.5;  // between points of the ground that is replaced

double smallest_radius(const CarveShape& shape) {
  if (shape.kind != CarveShape::Kind::box) return shape.radius_m;
  return std::min({shape.half_m.x, shape.half_m.y, shape.half_m.z});
}

Box grown(const CarveShape& shape) {
  Box box = shape.bounds();
  box.min -= shape.blend_m;
  box.max += shape.blend_m;
  return box;
}

Box around_both(const Box& a, const Box& b) {
  return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

bool overlap(const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.max[axis] < b.min[axis] || b.max[axis] < a.min[axis]) return false;
  }
  return true;
}

// Points, by the unit cube that they lie in.
class PointCells {
 public:
  explicit PointCells(glm::ivec3 extent) : extent_(extent) {}

  void add(glm::dvec3 point) { cells_[key(cell_of(point))].push_back(point); }
  // Precondition: there is a point.
  double nearest(glm::dvec3 from) const {
    const glm::ivec3 middle = cell_of(from);
    double best = std::numeric_limits<double>::infinity();
    // What is in a shell of cells is no nearer than the shell before it is wide.
    for (int shell = 0; best > shell - 1; ++shell) {
      glm::ivec3 d;
      for (d.z = -shell; d.z <= shell; ++d.z) {
        for (d.y = -shell; d.y <= shell; ++d.y) {
          const bool inside = std::abs(d.z) < shell && std::abs(d.y) < shell;
          for (d.x = -shell; d.x <= shell; d.x += inside && shell > 0 ? 2 * shell : 1) {
            const auto found = cells_.find(key(middle + d));
            if (found == cells_.end()) continue;
            for (const glm::dvec3 point : found->second) best = std::min(best, glm::length(point - from));
          }
        }
      }
    }
    return best;
  }

 private:
  // Also of cells a little outside of the extent.
  std::int64_t key(glm::ivec3 cell) const {
    const std::int64_t wide = extent_.x + 1024, deep = extent_.z + 1024;
    return (std::int64_t{cell.y} * deep + cell.z) * wide + cell.x;
  }
  static glm::ivec3 cell_of(glm::dvec3 point) { return glm::ivec3(glm::floor(point)); }

  glm::ivec3 extent_;
  std::unordered_map<std::int64_t, std::vector<glm::dvec3>> cells_;
};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace

Error RegionBaker::load() {
  if (job_.carve_path.empty()) return {};
  return read_carve(job_.carve_path, shapes_);
}

// The samples of a box, with some around; within the ground.
RegionBaker::Rect RegionBaker::around(const Box& box, const GroundRows& rows, double margin_m) const {
  Rect rect{};
  const int count[2] = {rows.width(), rows.height()};
  for (int axis = 0; axis < 2; ++axis) {
    const double middle = 0.5 * (count[axis] - 1);
    const double low = (box.min[2 * axis] - margin_m) / spacing_m_ + middle;
    const double high = (box.max[2 * axis] + margin_m) / spacing_m_ + middle;
    const double last = count[axis] - 1;
    rect.low[axis] = static_cast<int>(std::floor(std::clamp(low, 0.0, last)));
    rect.high[axis] = static_cast<int>(std::ceil(std::clamp(high, 0.0, last)));
  }
  return rect;
}

// Samples low .. high, both included.
Error RegionBaker::take_elevation(GroundRows& rows, const Rect& samples, Elevation& out) const {
  out = {};
  out.width = samples.high[0] - samples.low[0] + 1;
  out.height = samples.high[1] - samples.low[1] + 1;
  out.spacing_x_m = out.spacing_z_m = spacing_m_;
  out.heights_m.reserve(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  int row = 0;
  const auto take = [&](std::span<const float> heights_m) {
    if (row >= samples.low[1] && row <= samples.high[1]) {
      const auto first = heights_m.begin() + samples.low[0];
      out.heights_m.insert(out.heights_m.end(), first, first + out.width);
    }
    return ++row <= samples.high[1];
  };
  if (Error error = rows.run(take); !error.ok()) return error;
  out.valid.assign(out.heights_m.size(), 1);
  return {};
}

// Groups of shapes that hang together, of which the ground's surface passes through one. radius_m: the
// smallest of them.
std::vector<RegionBaker::Group> RegionBaker::meeting(GroundRows& rows, double& radius_m, Error& error) {
  std::vector<std::size_t> group(shapes_.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  const auto root = [&](std::size_t n) {
    while (group[n] != n) n = group[n] = group[group[n]];
    return n;
  };
  for (std::size_t a = 0; a < shapes_.size(); ++a) {
    for (std::size_t b = a + 1; b < shapes_.size(); ++b) {
      if (overlap(grown(shapes_[a]), grown(shapes_[b]))) group[root(b)] = root(a);
    }
  }
  // The ground under each shape's box: least and greatest.
  struct Under {
    Rect rect;
    float low = std::numeric_limits<float>::infinity(), high = -std::numeric_limits<float>::infinity();
  };
  std::vector<Under> under;
  int last = 0;
  for (const CarveShape& shape : shapes_) {
    under.push_back({around(grown(shape), rows, 0)});
    last = std::max(last, under.back().rect.high[1]);
  }
  int row = 0;
  const auto take = [&](std::span<const float> heights_m) {
    for (Under& u : under) {
      if (row < u.rect.low[1] || row > u.rect.high[1]) continue;
      for (int i = u.rect.low[0]; i <= u.rect.high[0]; ++i) {
        u.low = std::min(u.low, heights_m[static_cast<std::size_t>(i)]);
        u.high = std::max(u.high, heights_m[static_cast<std::size_t>(i)]);
      }
    }
    return ++row <= last;
  };
  error = rows.run(take);
  if (!error.ok()) return {};
  std::vector<bool> meets(shapes_.size(), false);
  for (std::size_t n = 0; n < shapes_.size(); ++n) {
    const Box box = grown(shapes_[n]);
    if (box.min.y <= double{under[n].high} && box.max.y >= double{under[n].low}) meets[root(n)] = true;
  }
  std::vector<Group> found;
  std::vector<std::size_t> place(shapes_.size(), shapes_.size());  // by root: among those found
  unmet_ = 0;
  radius_m = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < shapes_.size(); ++n) {
    const std::size_t of = root(n);
    if (!meets[of]) {
      ++unmet_;
      continue;
    }
    radius_m = std::min(radius_m, smallest_radius(shapes_[n]));
    if (place[of] == shapes_.size()) {
      place[of] = found.size();
      found.push_back({grown(shapes_[n])});
    } else {
      found[place[of]].box = around_both(found[place[of]].box, grown(shapes_[n]));
    }
  }
  return found;
}

double RegionBaker::node_m() const {
  return kNodeQuads * spacing_m_;
}
double RegionBaker::voxel_m() const {
  return std::ldexp(node_m(), -node_voxels_log2_);
}
// Of a node's side: no larger than wanted where that can be.
int RegionBaker::voxels_log2(double wanted_m) const {
  return std::clamp(static_cast<int>(std::ceil(std::log2(node_m() / wanted_m) - 1e-6)), 0, kMostLatticeSize);
}

Error RegionBaker::find_nodes(const GroundRows& rows, Group& group) const {
  const int count[2] = {rows.width(), rows.height()};
  for (int axis = 0; axis < 2; ++axis) {
    const double middle = 0.5 * (count[axis] - 1) / kNodeQuads;
    const double margin_m = kMarginVoxels * voxel_m();
    const double low = std::floor((group.box.min[2 * axis] - margin_m) / node_m() + middle);
    const double high = std::ceil((group.box.max[2 * axis] + margin_m) / node_m() + middle);
    if (!(low >= 1 && high * kNodeQuads < count[axis] - 1)) {
      return "--carve: the shapes that meet the ground come nearer than " + number(2 * node_m()) +
             " m to its border; a region has ground all around it";
    }
    group.nodes.low[axis] = static_cast<int>(low);
    group.nodes.high[axis] = static_cast<int>(high);
    if (!job_.carves_field) continue;
    // Blocks end at the sides, coarser ones too.
    const int cells_log2 = node_voxels_log2_ + field_level(job_.level);
    const int unit = std::max(RegionField::kSideCells >> cells_log2, 1);
    int more = (unit - (group.nodes.high[axis] - group.nodes.low[axis]) % unit) % unit;
    for (bool low_end = true; more > 0; low_end = !low_end, --more) {
      const bool fits_low = group.nodes.low[axis] > 1;
      const bool fits_high = (group.nodes.high[axis] + 1) * kNodeQuads < count[axis] - 1;
      if (!fits_low && !fits_high) return "--carve-as field: the ground is too small for its region";
      if (fits_low && (low_end || !fits_high)) {
        --group.nodes.low[axis];
      } else {
        ++group.nodes.high[axis];
      }
    }
  }
  return {};
}

// Groups whose nodes lie nearer to each other than a node become one, and the nearest ones while there are
// too many.
Error RegionBaker::group_up(const GroundRows& rows, std::vector<Group>& groups) const {
  const auto gap = [](const Rect& a, const Rect& b) {
    int most = std::numeric_limits<int>::min();
    for (int axis = 0; axis < 2; ++axis)
      most = std::max({most, a.low[axis] - b.high[axis], b.low[axis] - a.high[axis]});
    return most;
  };
  for (Group& group : groups) {
    if (Error error = find_nodes(rows, group); !error.ok()) return error;
  }
  while (groups.size() > 1) {
    std::size_t first = 0, second = 1;
    for (std::size_t a = 0; a < groups.size(); ++a) {
      for (std::size_t b = a + 1; b < groups.size(); ++b) {
        if (gap(groups[a].nodes, groups[b].nodes) < gap(groups[first].nodes, groups[second].nodes)) {
          first = a;
          second = b;
        }
      }
    }
    if (gap(groups[first].nodes, groups[second].nodes) >= 1 && groups.size() <= kMostRegions) break;
    groups[first].box = around_both(groups[first].box, groups[second].box);
    groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(second));
    if (Error error = find_nodes(rows, groups[first]); !error.ok()) return error;
  }
  return {};
}

// The voxel, one for all, and the nodes that the shapes take.
Error RegionBaker::choose(const GroundRows& rows, std::vector<Group> groups) {
  for (;; --node_voxels_log2_) {
    groups_ = groups;
    if (Error error = group_up(rows, groups_); !error.ok()) return error;
    double widest_m = 0;
    bool fits = true;
    for (const Group& group : groups_) {
      for (int axis = 0; axis < 2; ++axis) {
        fits = fits && std::ldexp(group.nodes.high[axis] - group.nodes.low[axis], node_voxels_log2_) + 1 <=
                           (1 << kMaxDepth);
        widest_m = std::max(widest_m, group.box.max[2 * axis] - group.box.min[2 * axis]);
      }
    }
    if (fits) return {};
    // By default as fine as an octree holds.
    if (job_.voxel_m > 0 || node_voxels_log2_ == 0) {
      return "--carve: shapes that meet the ground and hang together are " + number(widest_m) +
             " m wide, and a region is 511 voxels of " + number(voxel_m()) + " m wide at most" +
             (node_voxels_log2_ > 0 ? "; use a larger --voxel"
                                    : "; carve places that are nearer to each other");
    }
  }
}

// The sample's voxels; shapes have to lie among them.
Error RegionBaker::choose_sample() {
  node_voxels_log2_ = sample_grid_->node_voxels_log2;
  const Box all = sample_grid_->rectangle_m();
  Group& group = groups_.emplace_back(Group{all});
  for (int axis = 0; axis < 2; ++axis) {
    group.nodes.low[axis] = sample_grid_->first_node[axis];
    group.nodes.high[axis] = group.nodes.low[axis] + sample_grid_->nodes[axis];
  }
  const double margin_m = kMarginVoxels * voxel_m();
  for (std::size_t n = 0; n < shapes_.size(); ++n) {
    const Box box = grown(shapes_[n]);
    if (box.min.x - margin_m >= all.min.x && box.max.x + margin_m <= all.max.x &&
        box.min.z - margin_m >= all.min.z && box.max.z + margin_m <= all.max.z)
      continue;
    return "--carve: shape " + std::to_string(n) + ": comes nearer than " + number(margin_m) +
           " m to the sides of the sample's voxels, which reach " + number(all.max.x) + " m in x and " +
           number(all.max.z) + " m in z from the middle; --no-ground has no such sides";
  }
  return {};
}

// Without regions: voxels as wide as asked, or as samples are apart.
void RegionBaker::choose_lattice(const GroundRows& rows) {
  const double wanted_m = job_.voxel_m > 0 ? job_.voxel_m : spacing_m_;
  node_voxels_log2_ = voxels_log2(wanted_m);
  sample_steps_ = std::ldexp(kMostSampleSteps, node_voxels_log2_);
  const int count[2] = {rows.width(), rows.height()};
  origin_m_ = glm::dvec3(0);
  for (int axis = 0; axis < 2; ++axis)
    origin_m_[2 * axis] = -0.5 * (count[axis] - 1) * spacing_m_ - 0.5 * voxel_m();
}

// Where they stand: each as deep as its shapes and its ground are.
Error RegionBaker::make_grids(GroundRows& rows) {
  const int count[2] = {rows.width(), rows.height()};
  std::vector<double> bottom_m, top_m;
  glm::dvec3 low_m(std::numeric_limits<double>::infinity());  // of all
  for (const Group& group : groups_) {
    Rect samples{};
    double side_m[2];
    for (int axis = 0; axis < 2; ++axis) {
      samples.low[axis] = std::max(group.nodes.low[axis] * kNodeQuads - kMarginSamples, 0);
      samples.high[axis] = std::min(group.nodes.high[axis] * kNodeQuads + kMarginSamples, count[axis] - 1);
      side_m[axis] = (group.nodes.low[axis] * kNodeQuads - 0.5 * (count[axis] - 1)) * spacing_m_;
      low_m[2 * axis] = std::min(low_m[2 * axis], side_m[axis]);
      if (job_.can_be_dug) low_m[2 * axis] = -0.5 * (count[axis] - 1) * spacing_m_;
    }
    Elevation piece;
    if (Error error = take_elevation(rows, samples, piece); !error.ok()) return error;
    const auto [lowest, highest] = std::minmax_element(piece.heights_m.begin(), piece.heights_m.end());
    bottom_m.push_back(double{*lowest});
    top_m.push_back(double{*highest});
    if (sample_ != nullptr) {
      bottom_m.back() = std::min(bottom_m.back(), sample_->content_m.min.y);
      top_m.back() = std::max(top_m.back(), sample_->content_m.max.y);
    }
    for (const CarveShape& shape : shapes_) {
      const Box box = grown(shape);
      if (box.max.x < side_m[0] || box.max.z < side_m[1] ||
          box.min.x > side_m[0] + (group.nodes.high[0] - group.nodes.low[0]) * node_m() ||
          box.min.z > side_m[1] + (group.nodes.high[1] - group.nodes.low[1]) * node_m())
        continue;
      if (shape.fill) {
        top_m.back() = std::max(top_m.back(), box.max.y);
      } else {
        bottom_m.back() = std::min(bottom_m.back(), box.min.y);
      }
    }
  }
  const double voxel = voxel_m();
  // At a whole unit of the elevation, whose tiles then take fewer bytes.
  const double unit_m = rows.unit_m() > 0 ? rows.unit_m() : voxel;
  const double lowest_m = *std::min_element(bottom_m.begin(), bottom_m.end());
  low_m.y = std::floor((lowest_m - WorldGrid::kLayersBelow * voxel) / unit_m) * unit_m;
  origin_m_ = {low_m.x - 0.5 * voxel, low_m.y, low_m.z - 0.5 * voxel};
  regions_.resize(groups_.size());
  for (std::size_t n = 0; n < groups_.size(); ++n) {
    const Rect& nodes = groups_[n].nodes;
    WorldGrid& grid = regions_[n].grid;
    // The lowest one begins where the world does.
    const double layers =
        bottom_m[n] == lowest_m ? 0 : std::floor((bottom_m[n] - low_m.y) / voxel - WorldGrid::kLayersBelow);
    grid.voxel_m = voxel;
    grid.origin_m.y = low_m.y + std::max(0.0, layers) * voxel;
    const double tall = std::ceil((top_m[n] - grid.origin_m.y) / voxel) + 1;
    if (!(tall < (1 << kMaxDepth))) {
      return "--voxel: voxels of " + number(voxel) + " m are " + number(tall) +
             " along y in the region, and the most is 511; use a larger one";
    }
    grid.extent = {((nodes.high[0] - nodes.low[0]) << node_voxels_log2_) + 1, static_cast<int>(tall),
                   ((nodes.high[1] - nodes.low[1]) << node_voxels_log2_) + 1};
    for (int axis = 0; axis < 2; ++axis) {
      regions_[n].first_node[axis] = nodes.low[axis];
      grid.origin_m[2 * axis] =
          (nodes.low[axis] * kNodeQuads - 0.5 * (count[axis] - 1)) * spacing_m_ - 0.5 * voxel;
    }
    grid.depth = 1;
    while ((1 << grid.depth) < std::max({grid.extent.x, grid.extent.z, grid.extent.y + 1})) ++grid.depth;
  }
  sample_steps_ = std::ldexp(kMostSampleSteps, node_voxels_log2_);
  return {};
}

// level: of the heights, at most; 0: what suits the samples. Out: what they have.
Error RegionBaker::make(GroundRows& rows, Region& region, const Rect& nodes, int& level) const {
  const auto start = std::chrono::steady_clock::now();
  const int count[2] = {rows.width(), rows.height()};
  Rect samples{};
  glm::dvec3 centre_m(0.0);  // of the piece of elevation, in the world
  for (int axis = 0; axis < 2; ++axis) {
    samples.low[axis] = std::max(nodes.low[axis] * kNodeQuads - kMarginSamples, 0);
    samples.high[axis] = std::min(nodes.high[axis] * kNodeQuads + kMarginSamples, count[axis] - 1);
    centre_m[2 * axis] =
        (0.5 * (samples.low[axis] + samples.high[axis]) - 0.5 * (count[axis] - 1)) * spacing_m_;
  }
  Elevation piece;
  if (Error error = take_elevation(rows, samples, piece); !error.ok()) return error;
  std::vector<CarveShape> shapes = shapes_;
  for (CarveShape& shape : shapes) {
    shape.centre_m -= centre_m;
    for (glm::dvec3& point : shape.points_m) point -= centre_m;
  }
  WorldGrid local = region.grid;
  local.origin_m -= centre_m;
  const ElevationSolid ground(piece, false);
  std::vector<float> tops;
  if (sample_ == nullptr) tops = column_tops(ground, piece, local, job_.threads);
  const ColumnSolid columns(tops, local);
  // A sample lies in the middle of its ground, as the piece does.
  std::optional<SampleInGround> joined;
  if (sample_ != nullptr)
    joined.emplace(*sample_->solid, ground.surface(), sample_grid_->rectangle_m(), kJoinVoxels * voxel_m());
  const Solid* const base = joined ? static_cast<const Solid*>(&*joined) : &ground;
  CarvedSolid voxels(joined ? *base : columns, shapes, local);
  CarvedSolid solid(*base, shapes, local);
  const auto most = static_cast<std::size_t>(job_.max_carve);
  if (Error error = voxels.build(most); !error.ok()) return error;
  if (Error error = solid.build(most); !error.ok()) return error;
  region.surface.create(local, job_.threads, true, progress_);
  if (Error error = region.surface.fill(voxels); !error.ok()) return error;
  if (job_.carves_field) {
    if (Error error = make_field(solid, local, piece, level, region); !error.ok()) return error;
    measure(ground.surface(), centre_m, region);
    region.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return {};
  }
  const bool is_given = level > 0;
  if (!is_given && sample_ != nullptr) {
    level = sample_->level;
  } else if (!is_given) {
    level = default_level();
  }
  if (Error error = region.surface.extract(level, !is_given); !error.ok()) return error;
  level = region.surface.heights().level;
  VoxelSurface::Fit fit;
  if (Error error = region.surface.fit(solid, false, {}, fit); !error.ok()) return error;
  region.misses = fit.misses;
  region.folds_left = fit.folds_left;
  region.measures = region.surface.measure();
  measure(ground.surface(), centre_m, region);
  region.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return {};
}

// Of cells a voxel.
int RegionBaker::field_level(int level) const {
  return std::min(level > 0 ? level : default_level(), kMostCellLog2 - kLeastCellLog2);
}

// Instead of patches; the voxels stay, of which the sky is seen.
Error RegionBaker::make_field(const Solid& solid, const WorldGrid& local, const Elevation& piece, int level,
                              Region& region) const {
  double steepest = 1;
  const auto width = static_cast<std::size_t>(piece.width);
  for (std::size_t n = 0; n + width + 1 < piece.heights_m.size(); ++n) {
    const double h = double{piece.heights_m[n]};
    const double x = (double{piece.heights_m[n + 1]} - h) / piece.spacing_x_m;
    const double z = (double{piece.heights_m[n + width]} - h) / piece.spacing_z_m;
    const double across = (double{piece.heights_m[n + width + 1]} - h) / piece.spacing_x_m;
    steepest = std::max({steepest, std::sqrt(1 + x * x + z * z), std::sqrt(1 + across * across)});
  }
  region.field = std::make_unique<RegionField>();
  // A half more: the bilinear surface is steeper within a quad than along its sides.
  return region.field->sample(solid, local, field_level(level), 1.5 * steepest, node_voxels_log2_,
                              job_.threads);
}

// Of its surface, voxels from its grid's corner.
std::vector<glm::dvec3> RegionBaker::points_of(const Region& region) {
  if (region.field != nullptr) return region.field->points();
  const Surface surface = region.surface.surface();
  const Heights heights = region.surface.heights();
  const int level = std::min(heights.level, kMeasuredLevel);
  std::vector<glm::ivec3> places(static_cast<std::size_t>(patch_vertices(level)));
  std::vector<glm::dvec3> points;
  for (PatchId p = 0; p < surface.patches.size(); ++p) {
    displaced_positions(surface, heights, level, p, places);
    const glm::dvec3 at = glm::dvec3(patch_origin(surface.volume_of(p)));
    for (const glm::ivec3 place : places) points.push_back((at + glm::dvec3(place)) / double{kStepsPerVoxel});
  }
  return points;
}

// How far what is seen of the region from outside is from the ground that stands for it: the ground from the
// nearest point of the region, so half of the width of a cave's mouth; and what stands above the ground from
// it. What lies below is seen through mouths alone. And the box of all.
void RegionBaker::measure(const ElevationSurface& ground, const glm::dvec3& centre_m, Region& region) const {
  const WorldGrid& grid = region.grid;
  const double step_m = grid.voxel_m / kStepsPerVoxel;
  const glm::dvec3 origin_m = grid.origin_m - centre_m;
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
  double most_m = 0;
  // Points of the surface by the voxel that they lie in.
  PointCells cells(grid.extent);
  for (const glm::dvec3 voxels : points_of(region)) {
    cells.add(voxels);
    const glm::dvec3 point_m = origin_m + grid.voxel_m * voxels;
    const double ground_m = ground.at(point_m.x, point_m.z);
    most_m = std::max(most_m, point_m.y - ground_m);
    low = glm::min(low, glm::min(point_m, glm::dvec3(point_m.x, ground_m, point_m.z)));
    high = glm::max(high, glm::max(point_m, glm::dvec3(point_m.x, ground_m, point_m.z)));
  }
  for (double z = 0.5; z <= grid.extent.z - 0.5; z += kGroundPointVoxels) {
    for (double x = 0.5; x <= grid.extent.x - 0.5; x += kGroundPointVoxels) {
      const double height_m = ground.at(origin_m.x + grid.voxel_m * x, origin_m.z + grid.voxel_m * z);
      const glm::dvec3 point(x, (height_m - origin_m.y) / grid.voxel_m, z);
      most_m = std::max(most_m, grid.voxel_m * cells.nearest(point));
    }
  }
  region.deviation_m = most_m;
  region.measure.error = most_m / step_m;
  region.measure.reach = glm::length(high - low + 2 * grid.voxel_m) / step_m;
}

std::uint64_t RegionBaker::Region::bytes() const {
  WorldInfo own;
  surface.tell(own);
  if (field != nullptr) return 2 * std::uint64_t{own.octets} + 1 + field->bytes();
  const std::uint64_t of_patch = sizeof(PatchKey) + level_error_values(own.level) * sizeof(std::uint16_t) +
                                 sizeof(PatchBounds) + 2 * sizeof(NormalCone) +
                                 static_cast<std::uint64_t>(patch_vertices(own.level)) * sizeof(std::int16_t);
  return 2 * std::uint64_t{own.octets} + 1 + own.patches * of_patch + (own.patches + 7) / 8 +
         (own.patches + kHeightGroup - 1) / kHeightGroup * sizeof(std::uint32_t);
}

int RegionBaker::default_level() const {
  const double vertex_m = std::min(kSamplesPerVertex * spacing_m_, 0.25 * voxel_m());
  return std::clamp(static_cast<int>(std::lround(std::log2(voxel_m() / vertex_m))), 1, kMaxLevel);
}

void RegionBaker::tell_lattice(double base_m, WorldInfo& world, GroundInfo& ground) const {
  world.level = job_.level > 0 ? job_.level : default_level();
  world.voxel_size_m = voxel_m();
  for (int axis = 0; axis < 3; ++axis) world.origin_m[axis] = origin_m_[axis];
  world.origin_m[1] = base_m;
  ground.can_be_dug = true;
}

void RegionBaker::tell(WorldInfo& world, GroundInfo& ground) const {
  world.regions = static_cast<std::uint32_t>(regions_.size());
  world.octets = world.volumes = world.patches = world.height_blocks = 0;
  world.extent = glm::ivec3(0);
  world.depth = 0;
  ground.region_count = static_cast<std::int32_t>(regions_.size());
  ground.can_be_dug = job_.can_be_dug;
  for (std::size_t n = 0; n < regions_.size(); ++n) {
    const Region& from = regions_[n];
    WorldInfo own;
    from.surface.tell(own);
    GroundRegion& to = ground.region_list[n] = {};
    for (int axis = 0; axis < 2; ++axis) to.nodes.low[axis] = from.first_node[axis];
    to.corner.y = static_cast<std::int32_t>(std::lround((from.grid.origin_m.y - origin_m_.y) / voxel_m()));
    to.extent = own.extent;
    to.depth = own.depth;
    to.octets = own.octets;
    to.volumes = own.volumes;
    to.patches = own.patches;
    to.rim_edges = from.field != nullptr ? from.field->rim_edges() : RegionRim::count(from.surface.surface());
    world.level = from.field != nullptr ? 1 : own.level;
    world.octets += own.octets;
    world.volumes += own.volumes;
    world.patches += own.patches;
    world.height_blocks += own.height_blocks;
    world.extent = glm::max(world.extent, own.extent);
    world.depth = std::max(world.depth, own.depth);
  }
  for (int axis = 0; axis < 3; ++axis) world.origin_m[axis] = origin_m_[axis];
  world.voxel_size_m = voxel_m();
}

Error RegionBaker::run(GroundRows& rows) {
  regions_.clear();
  if (!is_wanted()) return {};
  const Elevation& facts = rows.facts();
  if (facts.spacing_x_m != facts.spacing_z_m) {
    return job_.read.path + (job_.can_be_dug ? ": --dig" : ": --carve") +
           " needs samples that are as wide as long; they are " + number(facts.spacing_x_m) + " x " +
           number(facts.spacing_z_m) + " m: gdalwarp -tr makes others, or --pixel-size";
  }
  spacing_m_ = facts.spacing_x_m;
  Error error;
  if (sample_ != nullptr) {
    if (error = choose_sample(); !error.ok()) return error;
  } else {
    double radius_m = 0;
    const std::vector<Group> met = meeting(rows, radius_m, error);
    if (error.ok() && met.empty() && job_.can_be_dug) choose_lattice(rows);
    if (!error.ok() || met.empty()) return error;
    const double wanted_m = job_.voxel_m > 0 ? job_.voxel_m : radius_m / kVoxelsARadius;
    node_voxels_log2_ = voxels_log2(wanted_m);
    if (error = choose(rows, met); !error.ok()) return error;
  }
  if (job_.carves_field && groups_.size() > 1) {
    return "--carve-as field: the shapes lie in " + std::to_string(groups_.size()) +
           " places far from each other, and a world has one field; carve one of them, or leave it away";
  }
  if (error = make_grids(rows); !error.ok()) return error;
  // The first one's level is that of all.
  int level = job_.level;
  for (std::size_t n = 0; n < regions_.size(); ++n) {
    if (error = make(rows, regions_[n], groups_[n].nodes, level); !error.ok()) return error;
  }
  return {};
}

}  // namespace karst::bake
