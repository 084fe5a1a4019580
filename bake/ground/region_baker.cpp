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
#include "terrain/patch/displacement.h"
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
constexpr double kGroundPointVoxels = 0.5;  // between points of the ground that is replaced
// Voxels along a sample's sides in which it becomes the ground.
constexpr double kJoinVoxels = 3.5;
// Of the points of a surface that are compared with the ground: coarser ones are further from it.
constexpr int kMeasuredLevel = 3;

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

// Shapes of which the ground's surface passes through one, and those that hang together with it.
std::vector<std::size_t> RegionBaker::meeting(GroundRows& rows, Error& error) const {
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
  std::vector<std::size_t> found;
  for (std::size_t n = 0; n < shapes_.size(); ++n) {
    if (meets[root(n)]) found.push_back(n);
  }
  return found;
}

// The voxel, and the nodes that the shapes take.
Error RegionBaker::choose(GroundRows& rows, const std::vector<std::size_t>& meeting) {
  Box box = grown(shapes_[meeting.front()]);
  double radius = std::numeric_limits<double>::infinity();
  for (const std::size_t n : meeting) {
    const Box other = grown(shapes_[n]);
    box.min = glm::min(box.min, other.min);
    box.max = glm::max(box.max, other.max);
    radius = std::min(radius, smallest_radius(shapes_[n]));
  }
  const double node_m = kNodeQuads * spacing_m_;
  const double wanted_m = job_.voxel_m > 0 ? job_.voxel_m : radius / kVoxelsARadius;
  const int least =
      std::clamp(static_cast<int>(std::ceil(std::log2(node_m / wanted_m) - 1e-6)), 0, kMostLatticeSize);
  for (node_voxels_log2_ = least;; --node_voxels_log2_) {
    const double voxel_m = std::ldexp(node_m, -node_voxels_log2_);
    const int count[2] = {rows.width(), rows.height()};
    bool fits = true;
    for (int axis = 0; axis < 2; ++axis) {
      const double middle = 0.5 * (count[axis] - 1) / kNodeQuads;
      const double margin_m = kMarginVoxels * voxel_m;
      const double low = std::floor((box.min[2 * axis] - margin_m) / node_m + middle);
      const double high = std::ceil((box.max[2 * axis] + margin_m) / node_m + middle);
      if (!(low >= 1 && high * kNodeQuads < count[axis] - 1)) {
        return "--carve: the shapes that meet the ground come nearer than " + number(2 * node_m) +
               " m to its border; a region has ground all around it";
      }
      nodes_.low[axis] = static_cast<int>(low);
      nodes_.high[axis] = static_cast<int>(high);
      fits = fits && std::ldexp(high - low, node_voxels_log2_) + 1 <= (1 << kMaxDepth);
    }
    if (fits) break;
    // By default as fine as an octree holds.
    if (job_.voxel_m > 0 || node_voxels_log2_ == 0) {
      return "--carve: the shapes that meet the ground lie " +
             number(std::max(box.max.x - box.min.x, box.max.z - box.min.z)) +
             " m apart, and a region is 511 voxels of " + number(voxel_m) +
             " m wide at most; carve places that are nearer to each other" +
             (node_voxels_log2_ > 0 ? ", or use a larger --voxel" : "");
    }
  }
  return {};
}

// The sample's voxels; shapes have to lie among them.
Error RegionBaker::choose_sample() {
  node_voxels_log2_ = sample_grid_->node_voxels_log2;
  for (int axis = 0; axis < 2; ++axis) {
    nodes_.low[axis] = sample_grid_->first_node[axis];
    nodes_.high[axis] = nodes_.low[axis] + sample_grid_->nodes[axis];
  }
  const Box all = sample_grid_->rectangle_m();
  const double margin_m = kMarginVoxels * std::ldexp(kNodeQuads * spacing_m_, -node_voxels_log2_);
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

Error RegionBaker::make(GroundRows& rows) {
  const double node_m = kNodeQuads * spacing_m_;
  const double voxel_m = std::ldexp(node_m, -node_voxels_log2_);
  const int count[2] = {rows.width(), rows.height()};
  Rect samples{};
  double low_m[2];  // of the region's west and north border
  for (int axis = 0; axis < 2; ++axis) {
    first_node_[axis] = nodes_.low[axis];
    samples.low[axis] = std::max(nodes_.low[axis] * kNodeQuads - kMarginSamples, 0);
    samples.high[axis] = std::min(nodes_.high[axis] * kNodeQuads + kMarginSamples, count[axis] - 1);
    low_m[axis] = (nodes_.low[axis] * kNodeQuads - 0.5 * (count[axis] - 1)) * spacing_m_;
    piece_centre_m_[2 * axis] =
        (0.5 * (samples.low[axis] + samples.high[axis]) - 0.5 * (count[axis] - 1)) * spacing_m_;
  }
  Elevation piece;
  if (Error error = take_elevation(rows, samples, piece); !error.ok()) return error;
  const auto [lowest, highest] = std::minmax_element(piece.heights_m.begin(), piece.heights_m.end());
  double bottom_m = double{*lowest}, top_m = double{*highest};
  if (sample_ != nullptr) {
    bottom_m = std::min(bottom_m, sample_->content_m.min.y);
    top_m = std::max(top_m, sample_->content_m.max.y);
  }
  std::vector<CarveShape> shapes = shapes_;
  for (CarveShape& shape : shapes) {
    shape.centre_m -= piece_centre_m_;
    for (glm::dvec3& point : shape.points_m) point -= piece_centre_m_;
  }
  for (const CarveShape& shape : shapes_) {
    const Box box = grown(shape);
    if (box.max.x < low_m[0] || box.max.z < low_m[1] ||
        box.min.x > low_m[0] + (nodes_.high[0] - nodes_.low[0]) * node_m ||
        box.min.z > low_m[1] + (nodes_.high[1] - nodes_.low[1]) * node_m)
      continue;
    if (shape.fill) {
      top_m = std::max(top_m, box.max.y);
    } else {
      bottom_m = std::min(bottom_m, box.min.y);
    }
  }
  // At a whole unit of the elevation, whose tiles then take fewer bytes.
  const double unit_m = rows.unit_m() > 0 ? rows.unit_m() : voxel_m;
  const double origin_m = std::floor((bottom_m - WorldGrid::kLayersBelow * voxel_m) / unit_m) * unit_m;
  const double tall = std::ceil((top_m - origin_m) / voxel_m) + 1;
  if (!(tall < (1 << kMaxDepth))) {
    return "--voxel: voxels of " + number(voxel_m) + " m are " + number(tall) +
           " along y in the region, and the most is 511; use a larger one";
  }
  grid_ = {};
  grid_.voxel_m = voxel_m;
  grid_.origin_m = {low_m[0] - 0.5 * voxel_m, origin_m, low_m[1] - 0.5 * voxel_m};
  grid_.extent = {((nodes_.high[0] - nodes_.low[0]) << node_voxels_log2_) + 1, static_cast<int>(tall),
                  ((nodes_.high[1] - nodes_.low[1]) << node_voxels_log2_) + 1};
  grid_.depth = 1;
  while ((1 << grid_.depth) < std::max({grid_.extent.x, grid_.extent.z, grid_.extent.y + 1})) ++grid_.depth;
  sample_steps_ = std::ldexp(kMostSampleSteps, node_voxels_log2_);

  WorldGrid local = grid_;
  local.origin_m -= piece_centre_m_;
  const ElevationSolid ground(piece, false);
  std::vector<float> tops;
  if (sample_ == nullptr) tops = column_tops(ground, piece, local, job_.threads);
  const ColumnSolid columns(tops, local);
  std::optional<SampleInGround> joined;
  if (sample_ != nullptr)
    joined.emplace(*sample_->solid, ground.surface(), sample_grid_->rectangle_m(), kJoinVoxels * voxel_m);
  const Solid* const base = joined ? static_cast<const Solid*>(&*joined) : &ground;
  CarvedSolid voxels(joined ? *base : columns, shapes, local);
  CarvedSolid solid(*base, shapes, local);
  const auto most = static_cast<std::size_t>(job_.max_carve);
  if (Error error = voxels.build(most); !error.ok()) return error;
  if (Error error = solid.build(most); !error.ok()) return error;
  surface_.create(local, job_.threads, true, progress_);
  if (Error error = surface_.fill(voxels); !error.ok()) return error;
  int level = job_.level;
  if (level <= 0 && sample_ != nullptr) {
    level = sample_->level;
  } else if (level <= 0) {
    const double vertex_m = std::min(kSamplesPerVertex * spacing_m_, 0.25 * voxel_m);
    level = std::clamp(static_cast<int>(std::lround(std::log2(voxel_m / vertex_m))), 1, kMaxLevel);
  }
  if (Error error = surface_.extract(level, job_.level <= 0); !error.ok()) return error;
  VoxelSurface::Fit fit;
  if (Error error = surface_.fit(solid, false, {}, fit); !error.ok()) return error;
  report_.misses = fit.misses;
  report_.folds_left = fit.folds_left;
  measures_ = surface_.measure();
  measure(ground.surface());
  for (int axis = 0; axis < 3; ++axis) report_.size_m[axis] = grid_.extent[axis] * voxel_m;
  return {};
}

// How far what is seen of the region from outside is from the ground that stands for it: the ground from the
// nearest point of the region, so half of the width of a cave's mouth; and what stands above the ground from
// it. What lies below is seen through mouths alone. And the box of all.
void RegionBaker::measure(const ElevationSurface& ground) {
  const double step_m = grid_.voxel_m / kStepsPerVoxel;
  const glm::dvec3 origin_m = grid_.origin_m - piece_centre_m_;
  const Surface surface = surface_.surface();
  const Heights heights = surface_.heights();
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
  double most_m = 0;
  // Points of the surface by the voxel that they lie in.
  PointCells cells(grid_.extent);
  const int level = std::min(heights.level, kMeasuredLevel);
  std::vector<glm::ivec3> places(static_cast<std::size_t>(patch_vertices(level)));
  for (PatchId p = 0; p < surface.patches.size(); ++p) {
    displaced_positions(surface, heights, level, p, places);
    const glm::dvec3 at = glm::dvec3(patch_origin(surface.volume_of(p)));
    for (const glm::ivec3 place : places) {
      const glm::dvec3 voxels = (at + glm::dvec3(place)) / double{kStepsPerVoxel};
      cells.add(voxels);
      const glm::dvec3 point_m = origin_m + grid_.voxel_m * voxels;
      const double ground_m = ground.at(point_m.x, point_m.z);
      most_m = std::max(most_m, point_m.y - ground_m);
      low = glm::min(low, glm::min(point_m, glm::dvec3(point_m.x, ground_m, point_m.z)));
      high = glm::max(high, glm::max(point_m, glm::dvec3(point_m.x, ground_m, point_m.z)));
    }
  }
  for (double z = 0.5; z <= grid_.extent.z - 0.5; z += kGroundPointVoxels) {
    for (double x = 0.5; x <= grid_.extent.x - 0.5; x += kGroundPointVoxels) {
      const double height_m = ground.at(origin_m.x + grid_.voxel_m * x, origin_m.z + grid_.voxel_m * z);
      const glm::dvec3 point(x, (height_m - origin_m.y) / grid_.voxel_m, z);
      most_m = std::max(most_m, grid_.voxel_m * cells.nearest(point));
    }
  }
  report_.deviation_m = most_m;
  measure_.error = most_m / step_m;
  measure_.reach = glm::length(high - low + 2 * grid_.voxel_m) / step_m;
}

Error RegionBaker::run(GroundRows& rows) {
  exists_ = false;
  if (!is_wanted()) return {};
  const auto start = std::chrono::steady_clock::now();
  const Elevation& facts = rows.facts();
  if (facts.spacing_x_m != facts.spacing_z_m) {
    return job_.read.path + ": --carve needs samples that are as wide as long; they are " +
           number(facts.spacing_x_m) + " x " + number(facts.spacing_z_m) +
           " m: gdalwarp -tr makes others, or --pixel-size";
  }
  spacing_m_ = facts.spacing_x_m;
  report_.shapes = shapes_.size();
  Error error;
  if (sample_ != nullptr) {
    if (error = choose_sample(); !error.ok()) return error;
  } else {
    const std::vector<std::size_t> met = meeting(rows, error);
    if (!error.ok()) return error;
    report_.unmet = shapes_.size() - met.size();
    if (met.empty()) return {};
    if (error = choose(rows, met); !error.ok()) return error;
  }
  if (error = make(rows); !error.ok()) return error;
  exists_ = true;
  report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return {};
}

}  // namespace karst::bake
