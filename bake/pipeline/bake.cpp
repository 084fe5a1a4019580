// SPDX-License-Identifier: MIT
#include "bake/pipeline/bake.h"

#include "bake/base/parallel.h"
#include "bake/carve/carve.h"
#include "bake/elevation/elevation_solid.h"
#include "bake/pipeline/repair_folds.h"
#include "bake/pipeline/settle_voxels.h"
#include "bake/samples/samples.h"
#include "bake/surroundings/sink_sea.h"
#include "bake/surroundings/trace_rim.h"
#include "platform/base/text.h"
#include "terrain/base/check.h"
#include "terrain/base/config.h"
#include "terrain/field/voxelize.h"
#include "terrain/file/world_writer.h"
#include "terrain/measure/measure_patches.h"
#include "terrain/patch/fit_heights.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/surface/bezier/extract_surface.h"

#include <algorithm>
#include <atomic>
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
constexpr std::size_t kMaxHeightBytes = 4ull << 30;  // of all patches: a host's memory
constexpr std::size_t kFitChunk = 32;                // patches a thread takes at a time
// rms of the fit, from where it is told, and from where there is no world.
constexpr double kWarnRmsVoxels = 0.1, kMostRmsVoxels = 1;
// One chunk in so many is fitted and measured before the others: where it misses by so much more than what is
// taken, the others need not be tried.
constexpr std::size_t kTriedChunks = 16;
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

Error failure(const Status& status, const char* stage) {
  if (status.ok()) return {};
  return std::string(stage) + ": " + status.field() + ": " + status.what();
}

// Two significant digits, so that the default voxel size is a number one can say.
double round_to_two_digits(double x) {
  const double unit = std::pow(10.0, std::floor(std::log10(x)) - 1);
  return std::round(x / unit) * unit;
}

// Pages of vertices that a patch takes on the GPU: the default level lets a GPU hold all of a world.
std::uint32_t pages_of(int level) {
  return (static_cast<std::uint32_t>(patch_vertices(level)) + kPageVertices - 1) / kPageVertices;
}

// The octree and the memory of its pool.
struct Voxels {
  std::unique_ptr<std::byte[]> memory;
  Octree octree;

  Error create(int depth, std::uint32_t max_octets) {
    // Uninitialised: pages are touched as octets are used.
    const std::size_t bytes = Octree::bytes_for(max_octets) + Arena::kAlignment;
    memory.reset(new std::byte[bytes]);
    void* aligned = memory.get();
    std::size_t space = bytes;
    std::align(Arena::kAlignment, bytes - Arena::kAlignment, aligned, space);
    Arena arena({static_cast<std::byte*>(aligned), bytes - Arena::kAlignment});
    octree = Octree();
    return failure(octree.create(arena, depth, max_octets), "octree");
  }
};

class Baker {
 public:
  Baker(const Bake& job, Bake::Report& report, const ReportProgress& progress)
      : job_(job), report_(report), progress_(progress) {}

  Error run(std::vector<std::byte>& file) {
    Stopwatch watch;
    if (Error error = read(); !error.ok()) return error;
    report_.seconds_read = watch.lap();
    if (Error error = make_voxels(); !error.ok()) return error;
    if (Error error = extract(); !error.ok()) return error;
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
    if (ground_ == nullptr) return fill_by(solid());
    tops_ = column_tops(*ground_, elevation_, grid_, job_.threads);
    if (carved_ != nullptr) {
      const ColumnSolid columns(tops_, grid_);
      CarvedSolid carved(columns, shapes_, grid_);
      if (Error error = carved.build(most_carved()); !error.ok()) return error;
      return fill_by(carved);
    }
    const VoxelizeHeights voxelize{grid_.extent, tops_};
    Error error = voxels_.create(grid_.depth, std::max(1u, voxelize.count_octets(grid_.depth)));
    return error.ok() ? failure(voxelize.run(voxels_.octree), "voxels") : error;
  }

  // Voxels whose centre is in the solid, settled. The topmost layer stays air.
  Error fill_by(const Solid& solid) {
    const glm::ivec3 extent = grid_.extent;
    const auto row = static_cast<std::size_t>(extent.x), slice = row * static_cast<std::size_t>(extent.y);
    std::vector<float> values(slice * static_cast<std::size_t>(extent.z), -1.0f);
    parallel_chunks(static_cast<std::size_t>(extent.z), 1, job_.threads,
                    [&](std::size_t z, std::size_t, int) {
                      for (std::size_t k = 0; k < slice - row; ++k) {
                        const glm::dvec3 corner(static_cast<double>(k % row), static_cast<double>(k / row),
                                                static_cast<double>(z));
                        values[z * slice + k] = static_cast<float>(solid.value_m(grid_.to_m(corner + 0.5)));
                      }
                    });
    report_.voxels_settled = SettleVoxels{extent, values}.run();
    const auto is_filled = [&](glm::ivec3 v, bool) {
      return values[static_cast<std::size_t>(v.z) * slice + static_cast<std::size_t>(v.y) * row +
                    static_cast<std::size_t>(v.x)] > 0;
    };
    const VoxelizePredicate voxelize{extent, VoxelFunction(is_filled)};
    const std::uint32_t full_tree = ((1u << (3 * grid_.depth)) - 1) / 7;
    for (std::uint32_t octets = std::min(1u << 16, full_tree);; octets = std::min(4 * octets, full_tree)) {
      if (Error error = voxels_.create(grid_.depth, octets); !error.ok()) return error;
      const Status status = voxelize.run(voxels_.octree);
      if (status.code() == StatusCode::limit_reached && octets < full_tree) continue;
      return failure(status, "voxels");
    }
  }

  // What leaves a world of so many patches within the limits.
  static std::string fewer(std::size_t patches) {
    int level = kMaxLevel;
    const auto bytes = [&] { return patches * static_cast<std::size_t>(patch_vertices(level)) * 2; };
    while (level > 0 && bytes() > kMaxHeightBytes) --level;
    return patches <= kMostPatches && level > 0 ? "try --levels " + std::to_string(level)
                                                : std::string("use a larger --voxel");
  }

  Error extract() {
    report_.filled_voxels = voxels_.octree.count_filled();
    ExtractSurface extract;
    extract.octree = &voxels_.octree;
    extract.extent = grid_.extent;
    ExtractSurface::Result counts;
    if (Error error = failure(extract.count(counts), "surface"); !error.ok()) return error;
    if (counts.patches == 0) return "the world has no surface: nothing, or everything, is filled";
    while (job_.level <= 0 && level_ > 1 && counts.patches > kMostPages / pages_of(level_)) --level_;
    const std::size_t samples = counts.patches * static_cast<std::size_t>(patch_vertices(level_));
    if (counts.patches > kMostPatches || samples * sizeof(std::int16_t) > kMaxHeightBytes) {
      return "--levels: " + std::to_string(counts.patches) + " patches at level " + std::to_string(level_) +
             " are more than a world holds, " + std::to_string(kMostPatches) + " and 4 GiB of heights; " +
             fewer(counts.patches);
    }
    volumes_.resize(counts.volumes);
    patches_.resize(counts.patches);
    std::vector<std::uint32_t> scratch(ExtractSurface::scratch_size(counts.volumes));
    extract.volumes = volumes_;
    extract.patches = patches_;
    extract.scratch = scratch;
    if (Error error = failure(extract.run(counts), "surface"); !error.ok()) return error;
    for (std::uint32_t p = 0; p < patches_.size(); ++p) patches_[p].height_block = p;
    heights_.resize(samples);
    return {};
  }

  struct FieldContext {
    const Solid* solid;
    const WorldGrid* grid;
  };
  static double field_value(const void* context, glm::dvec3 position) {
    const auto& c = *static_cast<const FieldContext*>(context);
    return c.solid->value_m(c.grid->to_m(position));
  }

  // Chunks of patches whose number is a multiple of kTriedChunks, or all others.
  void fit_chunks(const FitHeights& fit, bool tried) {
    std::vector<FitHeights::Result> results(static_cast<std::size_t>(job_.threads));
    const std::size_t count = patches_.size(), chunks = (count + kFitChunk - 1) / kFitChunk;
    parallel_chunks(chunks, 1, job_.threads, [&](std::size_t chunk, std::size_t, int worker) {
      if ((chunk % kTriedChunks == 0) != tried) return;
      const std::size_t first = chunk * kFitChunk, last = std::min(first + kFitChunk, count);
      fit.run(static_cast<PatchId>(first), static_cast<PatchId>(last),
              results[static_cast<std::size_t>(worker)]);
      const std::uint64_t now = fitted_ += last - first;
      if (worker == 0 && progress_) progress_("heights", now, count);
    });
    for (const FitHeights::Result& r : results) {
      report_.vertices += r.vertices;
      report_.misses += r.misses;
    }
  }

  Error fit() {
    const FieldContext context{&solid(), &grid_};
    FitHeights fit;
    fit.surface = {volumes_, patches_};
    fit.field = {field_value, &context};
    fit.level = level_;
    fit.heights = heights_;
    KARST_ASSERT(fit.validate().ok());
    fit_chunks(fit, true);
    if (ground_ != nullptr && !job_.accept_fit) {
      MeasureFit measure = fit_measure();
      measure.chunk = kFitChunk;
      measure.every = kTriedChunks;
      const double rms_m = measure.run().rms_m;
      if (rms_m > kHopelessRmsVoxels * grid_.voxel_m) return refused_fit(rms_m);
    }
    fit_chunks(fit, false);
    repair(fit);
    return {};
  }

  void repair(const FitHeights& fit) {
    RepairFolds repair;
    repair.surface = fit.surface;
    repair.level = level_;
    repair.heights = heights_;
    repair.height_field = is_height_field();
    KARST_ASSERT(repair.validate().ok());
    const RepairFolds::Result folds = repair.run();
    report_.folds_repaired = folds.folded_before - std::min(folds.folded_before, folds.folded_after);
    report_.folds_left = folds.folded_after;
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
    measure.surface = {volumes_, patches_};
    measure.heights = {level_, heights_};
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

  struct Measures {
    std::vector<std::uint16_t> level_errors;
    std::vector<PatchBounds> bounds;
    std::vector<NormalCone> cones, shading_cones;
  };

  // Of one thread.
  struct MeasureRoom {
    std::vector<std::byte> memory;
    std::vector<GpuVertex> vertices;
    PatchScratch* scratch = nullptr;

    explicit MeasureRoom(int level)
        : memory(patch_scratch_bytes() + Arena::kAlignment),
          vertices(static_cast<std::size_t>(patch_vertices(level))) {
      const auto at = reinterpret_cast<std::uintptr_t>(memory.data());
      const std::size_t skip = (Arena::kAlignment - at % Arena::kAlignment) % Arena::kAlignment;
      scratch = make_patch_scratch(std::span(memory).subspan(skip));
    }
  };

  Measures measure_patches() const {
    const std::size_t count = patches_.size();
    Measures made{std::vector<std::uint16_t>(count * level_error_values(level_)),
                  std::vector<PatchBounds>(count), std::vector<NormalCone>(count),
                  std::vector<NormalCone>(count)};
    std::vector<BorderErrors> borders(count);
    MeasurePatches measure;
    measure.surface = {volumes_, patches_};
    measure.heights = {level_, heights_};
    measure.borders = borders;
    measure.out = {made.level_errors, made.bounds, made.cones, made.shading_cones};
    KARST_ASSERT(measure.validate().ok());
    std::vector<std::unique_ptr<MeasureRoom>> rooms;
    for (int t = 0; t < job_.threads; ++t) rooms.push_back(std::make_unique<MeasureRoom>(level_));
    parallel_chunks(count, kFitChunk, job_.threads, [&](std::size_t first, std::size_t last, int worker) {
      const std::unique_ptr<MeasureRoom>& room = rooms[static_cast<std::size_t>(worker)];
      measure.measure(first, last, {room->scratch, room->vertices});
    });
    parallel_chunks(count, kFitChunk, job_.threads,
                    [&](std::size_t first, std::size_t last, int) { measure.join(first, last); });
    return made;
  }

  Error write(std::vector<std::byte>& file) {
    WorldInfo& info = report_.info;
    info.voxel_size_m = grid_.voxel_m;
    for (int k = 0; k < 3; ++k) info.origin_m[k] = grid_.origin_m[k];
    info.extent = grid_.extent;
    info.depth = grid_.depth;
    info.level = level_;
    info.octets = voxels_.octree.octets_used();
    info.volumes = static_cast<std::uint32_t>(volumes_.size());
    info.patches = info.height_blocks = static_cast<std::uint32_t>(patches_.size());
    set_name(job_.sample.empty() ? job_.read.path.substr(job_.read.path.find_last_of('/') + 1) : job_.sample);
    if (Error error = failure(validate_world_info(info), "world"); !error.ok()) return error;

    std::vector<std::byte> mask((patches_.size() + 7) / 8, std::byte{0});
    for (std::size_t p = 0; p < patches_.size(); ++p) mask[p / 8] |= std::byte{1} << (p % 8);
    const Measures measures = measure_patches();
    std::vector<PatchKey> keys;
    for (PatchId p = 0; p < patches_.size(); ++p) keys.push_back(key_of(Surface{volumes_, patches_}, p));
    if (Error error = bake_materials(measures.bounds); !error.ok()) return error;
    const std::vector<glm::ivec3> rim = surround();
    WorldMaterials materials = report_.materials.view();
    materials.surroundings = report_.surroundings;
    materials.rim = rim;
    const WorldWriter writer{info,
                             &voxels_.octree,
                             {keys, mask, heights_, measures.level_errors, measures.bounds, measures.cones,
                              measures.shading_cones},
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
    std::vector<glm::ivec3> rim = trace_rim({volumes_, patches_}, {level_, heights_}, grid_.extent);
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
    bake.octree = &voxels_.octree;
    bake.surface = {volumes_, patches_};
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
  Voxels voxels_;
  std::vector<Volume> volumes_;
  std::vector<Patch> patches_;
  std::vector<std::int16_t> heights_;
  std::atomic<std::uint64_t> fitted_ = 0;  // patches, for progress
};

}  // namespace

Error Bake::run(Report& report, const ReportProgress& progress, std::vector<std::byte>& file) const {
  report = Report();
  return Baker(*this, report, progress).run(file);
}

}  // namespace karst::bake
