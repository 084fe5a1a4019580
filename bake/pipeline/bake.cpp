// SPDX-License-Identifier: MIT
#include "bake/pipeline/bake.h"

#include "bake/base/parallel.h"
#include "bake/carve/carve.h"
#include "bake/elevation/elevation_solid.h"
#include "bake/samples/samples.h"
#include "bake/surroundings/sink_sea.h"
#include "bake/surroundings/trace_rim.h"
#include "bake/voxels/voxel_surface.h"
#include "platform/base/text.h"
#include "terrain/file/world_writer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <utility>

namespace karst::bake {
using namespace core;
namespace {

constexpr double kVoxelsAcross = 128;  // of the longer side, by default: as detailed as K's largest terrain
// Distance of vertices by default, in samples: above 1 the fit loses detail, below 1/2 heights are
// interpolated ones.
constexpr double kSamplesPerVertex = 0.75;
// rms of the fit, from where it is told, and from where there is no world.
constexpr double kWarnRmsVoxels = 0.1, kMostRmsVoxels = 1;
// Where the part that is fitted first misses by so much more than what is taken, the others need not be
// tried.
constexpr double kHopelessRmsVoxels = 2 * kMostRmsVoxels;
constexpr const char* kSmoother =
    "try a larger --voxel, --nodata V for voids, --z-scale for heights that are not metres";
constexpr double kNearHoleVoxels = 2;  // patches bend towards a hole's side within this distance

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// Two significant digits, so that the default voxel size is a number one can say.
double round_to_two_digits(double x) {
  const double unit = std::pow(10.0, std::floor(std::log10(x)) - 1);
  return std::round(x / unit) * unit;
}

class Baker {
 public:
  Baker(const Bake& job, Bake::Report& report, const ReportProgress& progress)
      : job_(job), report_(report), progress_(progress) {}

  Error run(std::vector<std::byte>& file) {
    Stopwatch watch;
    if (Error error = read(); !error.ok()) return error;
    report_.seconds_read = watch.lap();
    if (Error error = make_voxels(); !error.ok()) return error;
    report_.voxels_settled = surface_.settled();
    report_.filled_voxels = surface_.octree().count_filled();
    if (Error error = surface_.extract(level_, job_.level <= 0); !error.ok()) return error;
    report_.seconds_voxels = watch.lap();
    if (Error error = fit(); !error.ok()) return error;
    report_.seconds_fit = watch.lap();
    if (ground_ != nullptr) report_.fit = fit_measure().run();
    if (Error error = judge_fit(); !error.ok()) return error;
    report_.seconds_measure = watch.lap();
    Error error = write(file);
    report_.seconds_write = watch.lap();
    return error;
  }

 private:
  // The solid, the grid, and for an image the column tops.
  Error read() {
    bake_materials_.options = job_.materials;
    bake_materials_.threads = job_.threads;
    if (Error error = bake_materials_.load(); !error.ok()) return error;
    if (!job_.carve_path.empty()) {
      if (Error error = read_carve(job_.carve_path, shapes_); !error.ok()) return error;
    }
    report_.carve_shapes = shapes_.size();
    if (Error error = job_.sample.empty() ? read_image() : read_sample(); !error.ok()) return error;
    if (!shapes_.empty()) {
      carved_ = std::make_unique<CarvedSolid>(*base_, shapes_, grid_);
      if (Error error = carved_->build(most_carved()); !error.ok()) return error;
    }
    report_.quantisation_m = grid_.voxel_m * kVertexStep / kStepsPerVoxel;
    return {};
  }

  Error read_sample() {
    Sample sample = make_sample(job_.sample, job_.threads);
    if (sample.solid == nullptr) return "--sample: there is no sample " + quote(job_.sample);
    base_ = std::move(sample.solid);
    level_ = job_.level > 0 ? job_.level : sample.level;
    return choose_grid(sample.content_m, job_.voxel_m > 0 ? job_.voxel_m : sample.voxel_m);
  }

  Error read_image() {
    if (Error error = job_.read.run(elevation_); !error.ok()) return error;
    report_.width = elevation_.width;
    report_.height = elevation_.height;
    report_.spacing_x_m = elevation_.spacing_x_m;
    report_.spacing_z_m = elevation_.spacing_z_m;
    report_.void_share = static_cast<double>(elevation_.voids) / static_cast<double>(elevation_.samples());
    report_.source = elevation_.source;
    report_.warnings = elevation_.warnings;
    // Heights are filled in any case: near a hole the surface is fitted to them.
    const std::vector<std::uint8_t> known = elevation_.valid;
    const bool holes = job_.leave_holes && elevation_.voids > 0;
    fill_voids(elevation_);
    if (job_.water_m) report_.sunk_samples = SinkSea{*job_.water_m}.run(elevation_);
    if (holes) elevation_.valid = known;
    auto solid = std::make_unique<ElevationSolid>(elevation_, holes);
    ground_ = solid.get();
    base_ = std::move(solid);

    const auto [low, high] = std::minmax_element(elevation_.heights_m.begin(), elevation_.heights_m.end());
    report_.lowest_m = double{*low};
    report_.highest_m = double{*high};
    const ElevationSurface& surface = ground_->surface();
    const Box content = {{-surface.half_width_m(), double{*low}, -surface.half_height_m()},
                         {surface.half_width_m(), double{*high}, surface.half_height_m()}};
    const double spacing_m = std::min(elevation_.spacing_x_m, elevation_.spacing_z_m);
    double voxel_m = job_.voxel_m;
    if (voxel_m <= 0) {
      const glm::dvec3 size = content.max - content.min;
      voxel_m = round_to_two_digits(std::max({size.x, size.z, size.y / 2}) / kVoxelsAcross);
      // A small image need not be cut finer than its samples.
      voxel_m =
          std::max(voxel_m, std::min(round_to_two_digits(2 * spacing_m), 0.5 * std::min(size.x, size.z)));
    }
    level_ = job_.level;
    if (level_ <= 0) {
      const double wanted = std::log2(voxel_m / (kSamplesPerVertex * spacing_m));
      level_ = std::clamp(static_cast<int>(std::lround(wanted)), 1, kMaxLevel);
    }
    return choose_grid(content, voxel_m);
  }

  // For the content's height range, widened by the shapes over it.
  Error choose_grid(Box content, double voxel_m) {
    const Box plan = content;
    for (const CarveShape& shape : shapes_) {
      const Box box = shape.bounds();
      if (box.max.x < plan.min.x || box.min.x > plan.max.x || box.max.z < plan.min.z ||
          box.min.z > plan.max.z)
        continue;
      if (shape.fill) {
        content.max.y = std::max(content.max.y, box.max.y + shape.blend_m);
      } else {
        content.min.y = std::min(content.min.y, box.min.y - shape.blend_m);
      }
    }
    return WorldGrid::around(content, voxel_m, grid_);
  }

  std::size_t most_carved() const { return static_cast<std::size_t>(job_.max_carve); }
  const Solid& solid() const { return carved_ != nullptr ? static_cast<const Solid&>(*carved_) : *base_; }
  bool is_height_field() const { return ground_ != nullptr && carved_ == nullptr && !has_holes(); }
  bool has_holes() const { return job_.leave_holes && elevation_.voids > 0; }

  Error make_voxels() {
    surface_.create(grid_, job_.threads, false, progress_);
    if (ground_ == nullptr) return surface_.fill(solid());
    tops_ = column_tops(*ground_, elevation_, grid_, job_.threads);
    if (carved_ != nullptr) {
      const ColumnSolid columns(tops_, grid_);
      CarvedSolid carved(columns, shapes_, grid_);
      if (Error error = carved.build(most_carved()); !error.ok()) return error;
      return surface_.fill(carved);
    }
    return surface_.fill_below(tops_);
  }

  Error fit() {
    const auto judge = [&]() -> Error {
      if (ground_ == nullptr || job_.accept_fit) return {};
      MeasureFit measure = fit_measure();
      measure.chunk = VoxelSurface::kFitChunk;
      measure.every = VoxelSurface::kTriedChunks;
      const double rms_m = measure.run().rms_m;
      return rms_m > kHopelessRmsVoxels * grid_.voxel_m ? refused_fit(rms_m) : Error();
    };
    VoxelSurface::Fit fitted;
    if (Error error = surface_.fit(solid(), is_height_field(), judge, fitted); !error.ok()) return error;
    report_.vertices = fitted.vertices;
    report_.misses = fitted.misses;
    report_.folds_repaired = fitted.folds_repaired;
    report_.folds_left = fitted.folds_left;
    return {};
  }

  // Columns within kNearHoleVoxels of a void sample.
  std::vector<std::uint8_t> columns_near_holes() const {
    std::vector<std::uint8_t> near(tops_.size(), 0);
    const ElevationSurface& surface = ground_->surface();
    for (int row = 0; row < elevation_.height; ++row) {
      for (int column = 0; column < elevation_.width; ++column) {
        if (elevation_.valid[elevation_.at(column, row)] != 0) continue;
        const double x_m = column * elevation_.spacing_x_m - surface.half_width_m();
        const double z_m = row * elevation_.spacing_z_m - surface.half_height_m();
        mark_columns((x_m - grid_.origin_m.x) / grid_.voxel_m, (z_m - grid_.origin_m.z) / grid_.voxel_m,
                     near);
      }
    }
    return near;
  }

  void mark_columns(double x, double z, std::vector<std::uint8_t>& near) const {
    const auto first = [](double v) {
      return std::max(0, static_cast<int>(std::floor(v - kNearHoleVoxels)));
    };
    const auto last = [](double v, int extent) {
      return std::min(extent - 1, static_cast<int>(std::floor(v + kNearHoleVoxels)));
    };
    for (int k = first(z); k <= last(z, grid_.extent.z); ++k) {
      for (int i = first(x); i <= last(x, grid_.extent.x); ++i) near[column_index(i, k)] = 1;
    }
  }

  std::size_t column_index(int x, int z) const {
    return static_cast<std::size_t>(z) * static_cast<std::size_t>(grid_.extent.x) +
           static_cast<std::size_t>(x);
  }

  MeasureFit fit_measure() {
    MeasureFit measure;
    measure.solid = ground_;
    measure.spacing_x_m = elevation_.spacing_x_m;
    measure.spacing_z_m = elevation_.spacing_z_m;
    measure.grid = grid_;
    measure.surface = surface_.surface();
    measure.heights = surface_.heights();
    std::vector<std::uint8_t> near_holes;
    if (has_holes()) near_holes = columns_near_holes();
    report_.fit_is_partial = has_holes() || carved_ != nullptr;
    if (report_.fit_is_partial) {
      measure.excluded = [this, near_holes = std::move(near_holes)](double x_m, double z_m) {
        if (carved_ != nullptr && carved_->touches(x_m, z_m)) return true;
        if (near_holes.empty()) return false;
        const double x = std::floor((x_m - grid_.origin_m.x) / grid_.voxel_m);
        const double z = std::floor((z_m - grid_.origin_m.z) / grid_.voxel_m);
        return near_holes[column_index(static_cast<int>(std::clamp(x, 0.0, grid_.extent.x - 1.0)),
                                       static_cast<int>(std::clamp(z, 0.0, grid_.extent.z - 1.0)))] != 0;
      };
    }
    return measure;
  }

  std::string missed_by(double rms_m) const {
    char line[128];
    std::snprintf(line, sizeof line, "the ground misses the elevation by %.3g m rms, %.2g voxels; ", rms_m,
                  rms_m / grid_.voxel_m);
    return line + std::string(kSmoother);
  }

  Error refused_fit(double rms_m) const {
    return job_.read.path + ": " + missed_by(rms_m) + ", --accept-fit writes it all the same";
  }

  // Tells where the ground is not that of the image.
  Error judge_fit() {
    if (report_.folds_left > 0) {
      report_.warnings.push_back(std::to_string(report_.folds_left) + " folded triangles are left; " +
                                 kSmoother);
    }
    if (!report_.fit) return {};
    const double rms_voxels = report_.fit->rms_m / grid_.voxel_m;
    if (rms_voxels <= kWarnRmsVoxels) return {};
    if (rms_voxels > kMostRmsVoxels && !job_.accept_fit) return refused_fit(report_.fit->rms_m);
    report_.warnings.push_back(missed_by(report_.fit->rms_m));
    return {};
  }

  Error write(std::vector<std::byte>& file) {
    WorldInfo& info = report_.info;
    surface_.tell(info);
    set_name(job_.sample.empty() ? job_.read.path.substr(job_.read.path.find_last_of('/') + 1) : job_.sample);
    if (Error error = failure(validate_world_info(info), "world"); !error.ok()) return error;

    const std::vector<std::byte> mask = surface_.mask();
    const VoxelSurface::Measures measures = surface_.measure();
    const std::vector<PatchKey> keys = surface_.keys();
    if (Error error = bake_materials(measures.bounds); !error.ok()) return error;
    const std::vector<glm::ivec3> rim = surround();
    WorldMaterials materials = report_.materials.view();
    materials.surroundings = report_.surroundings;
    materials.rim = rim;
    const WorldWriter writer{info,
                             &surface_.octree(),
                             {keys, mask, surface_.heights().samples, measures.level_errors, measures.bounds,
                              measures.cones, measures.shading_cones},
                             materials};
    file.clear();
    file.reserve(static_cast<std::size_t>(writer.file_bytes()));
    const auto append = [&](std::span<const std::byte> bytes) {
      file.insert(file.end(), bytes.begin(), bytes.end());
      return true;
    };
    return failure(writer.run(ByteSink::to(append)), "world");
  }

  // Returns the rim.
  std::vector<glm::ivec3> surround() {
    Surroundings& around = report_.surroundings;
    if (job_.water_m) {
      around.flags |= kHasWater;
      around.water_level = static_cast<float>((*job_.water_m - grid_.origin_m.y) / grid_.voxel_m);
    }
    std::vector<glm::ivec3> rim = trace_rim(surface_.surface(), surface_.heights(), grid_.extent);
    around.rim_points = static_cast<std::uint32_t>(rim.size());
    const auto lower = [](glm::ivec3 a, glm::ivec3 b) { return a.y < b.y; };
    const auto lowest = std::min_element(rim.begin(), rim.end(), lower);
    if (lowest != rim.end())
      around.plain_level = static_cast<float>(lowest->y) / static_cast<float>(kStepsPerVoxel);
    return rim;
  }

  Error bake_materials(std::span<const PatchBounds> boxes) {
    BakeMaterials& bake = bake_materials_;
    bake.sample = job_.sample;
    bake.grid = grid_;
    bake.octree = &surface_.octree();
    bake.surface = surface_.surface();
    bake.bounds = boxes;
    return bake.run(report_.materials);
  }

  void set_name(const std::string& name) {
    const std::size_t count = std::min(name.size(), kWorldNameBytes - 1);
    for (std::size_t k = 0; k < count; ++k)
      report_.info.name[k] = name[k] >= ' ' && name[k] <= '~' ? name[k] : '_';
  }

  const Bake& job_;
  Bake::Report& report_;
  const ReportProgress& progress_;

  BakeMaterials bake_materials_;
  Elevation elevation_;
  std::vector<CarveShape> shapes_;
  std::unique_ptr<Solid> base_;             // the image's surface or the sample
  const ElevationSolid* ground_ = nullptr;  // base_, where it is an image's
  std::unique_ptr<CarvedSolid> carved_;     // base_ with shapes_, where there are any
  WorldGrid grid_;
  int level_ = 0;
  std::vector<float> tops_;
  VoxelSurface surface_;
};

}  // namespace

Error Bake::run(Report& report, const ReportProgress& progress, std::vector<std::byte>& file) const {
  report = Report();
  return Baker(*this, report, progress).run(file);
}

}  // namespace karst::bake
