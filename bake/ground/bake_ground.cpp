// SPDX-License-Identifier: MIT
#include "bake/ground/bake_ground.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "app/files/atomic_file.h"
#include "app/files/output_place.h"
#include "bake/features/feature_map.h"
#include "bake/ground/ground_basis.h"
#include "bake/ground/ground_pyramid.h"
#include "bake/ground/ground_rows.h"
#include "bake/ground/region_baker.h"
#include "bake/samples/sample_ground.h"
#include "platform/base/text.h"
#include "terrain/base/check.h"
#include "terrain/base/lattice.h"
#include "terrain/field/octree.h"
#include "terrain/file/world_writer.h"
#include "terrain/regions/region_rim.h"

namespace karst::bake {
namespace {

constexpr int kMostHalvings = 10;  // of the steps between samples
// What a float loses of a height that is whole in its unit.
constexpr double kFloatLoss = 2e-7;
constexpr int kProgressRows = 64;
// Of rows in memory: whatever the files' length, and for each of their bytes.
constexpr std::uint64_t kFreeBytes = 96u << 20;
constexpr std::uint64_t kBytesAByte = 64;
// Steps of heights that are told of: of all heights together, and of the way between samples.
constexpr double kMostOfRelief = 0.01, kMostOfSpacing = 0.05;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// From metres to kVertexStep.
class Scale {
 public:
  Scale(double vertex_m, double base_m, double unit_m) : vertex_m_(vertex_m), base_m_(base_m) {
    // Elevation in whole units that the lattice holds apart keeps them: its tiles take fewer bytes.
    if (unit_m >= vertex_m && std::fmod(base_m, unit_m) == 0) unit_m_ = unit_m;
    quantum_ = unit_m_ / vertex_m_;
  }
  double quantum() const { return quantum_; }

  double height(double height_m) const {
    const double from_base = height_m - base_m_;
    if (unit_m_ > 0) {
      const double count = std::round(from_base / unit_m_);
      if (std::abs(count * unit_m_ - from_base) <= kFloatLoss * std::abs(height_m))
        return std::floor(count * quantum_ + 0.5);
    }
    return std::floor(from_base / vertex_m_ + 0.5);
  }

 private:
  double vertex_m_;
  double base_m_;
  double unit_m_ = 0;
  double quantum_ = 0;
};

// What the file has of the patches of all regions, one behind the other.
struct Patches {
  std::vector<PatchKey> keys;
  std::vector<std::byte> mask;
  std::vector<std::int16_t> samples;
  VoxelSurface::Measures measures;

  void add(const RegionBaker::Region& region, std::uint32_t number) {
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(keys, region.surface.keys(number));
    append(samples, region.surface.heights().samples);
    append(measures.level_errors, region.measures.level_errors);
    append(measures.bounds, region.measures.bounds);
    append(measures.cones, region.measures.cones);
    append(measures.shading_cones, region.measures.shading_cones);
    mask.assign((keys.size() + 7) / 8, std::byte{0});
    for (std::size_t p = 0; p < keys.size(); ++p) mask[p / 8] |= std::byte{1} << (p % 8);
  }
  WorldPatches view() const {
    return {
        keys, mask, samples, measures.level_errors, measures.bounds, measures.cones, measures.shading_cones};
  }
};

class GroundBaker {
 public:
  GroundBaker(const BakeGround& job, BakeGround::Report& report, const ReportProgress& progress)
      : job_(job.job),
        output_(job.output),
        report_(report),
        progress_(progress),
        rows_(job_.read, job_.water_m),
        regions_(job_, progress),
        images_(job.imagery),
        imagery_(images_, job_.threads),
        water_m_(job_.water_m) {}

  Error run() {
    materials_.options = job_.materials;
    materials_.threads = job_.threads;
    if (Error error = materials_.load(); !error.ok()) return error;
    if (materials_.paints()) {
      return job_.materials.path +
             ": paint and blend_map are of patches, which a ground has none of; --no-ground has them";
    }
    if (Error error = regions_.load(); !error.ok()) return error;
    auto start = std::chrono::steady_clock::now();
    if (Error error = open_rows(); !error.ok()) return error;
    if (Error error = regions_.run(rows_); !error.ok()) return error;
    tell_of_regions();
    if (Error error = write_tiles(); !error.ok()) return error;
    report_.seconds_tiles = seconds_since(start);
    report_.bytes_tiles = report_.ground.tile_bytes;
    if (Error error = write_imagery(); !error.ok()) return error;
    start = std::chrono::steady_clock::now();
    if (Error error = write_head(); !error.ok()) return error;
    report_.seconds_materials = seconds_since(start);
    return file_.commit();
  }

 private:
  bool is_curved() const { return job_.basis.kind != BakeBasis::Kind::plane; }

  // What errors begin with.
  std::string input() const {
    if (!job_.features_path.empty()) return job_.features_path;
    return job_.sample.empty() ? job_.read.path : "--sample " + job_.sample;
  }

  Error open_rows() {
    if (!job_.features_path.empty()) return open_features();
    return job_.sample.empty() ? rows_.open() : open_sample();
  }

  Error open_features() {
    FeatureMap map;
    if (Error error = read_feature_map(job_.features_path, map); !error.ok()) return error;
    if (!water_m_) water_m_ = map.water_m;
    Elevation facts;
    facts.width = map.columns();
    facts.height = map.rows();
    facts.spacing_x_m = facts.spacing_z_m = map.spacing_m;
    facts.source = "features";
    rows_.make(std::move(facts), 0, job_.threads,
               [surface = std::make_shared<MapSurface>(map)](int first, int count, std::span<float> out) {
                 surface->rows(first, count, out);
               });
    return {};
  }

  Error open_sample() {
    sample_ = make_sample(job_.sample, job_.threads);
    if (sample_.solid == nullptr) return "--sample: there is no sample " + quote(job_.sample);
    const double voxel_m = job_.voxel_m > 0 ? job_.voxel_m : sample_.voxel_m;
    if (Error error = SampleGrid::around(sample_, voxel_m, sample_grid_); !error.ok()) return error;
    rows_.hold(sample_elevation(sample_, sample_grid_, job_.threads), kSampleUnitM);
    regions_.stand_on(sample_, sample_grid_);
    return {};
  }

  enum class Outcome : std::uint8_t { done, finer_is_too_steep, out_of_range };

  Error write_tiles() {
    int halvings = 0;
    double base_m = regions_.exists() ? regions_.origin_m().y : 0;
    for (;;) {
      if (Error error = choose_steps(halvings, base_m); !error.ok()) return error;
      if (Error error = check_memory(); !error.ok()) return error;
      if (Error error = outline(); !error.ok()) return error;
      if (Error error = open_imagery(); !error.ok()) return error;
      if (Error error = file_.open(output_); !error.ok()) return error;
      Outcome outcome = Outcome::done;
      double offending_m = 0;
      if (Error error = try_tiles(base_m, outcome, offending_m); !error.ok()) return error;
      if (outcome == Outcome::done) return {};
      ++report_.attempts;
      if (regions_.exists() || (regions_.has_lattice() && outcome == Outcome::finer_is_too_steep)) {
        return input() +
               ": too steep, or heights that differ too much, for voxels so fine; try a larger --voxel";
      }
      if (outcome == Outcome::out_of_range) {
        if (base_m != 0)
          return input() + ": heights differ too much for so fine samples; try a larger --pixel-size";
        base_m = std::round(offending_m);
      } else if (++halvings > kMostHalvings) {
        return input() +
               ": too steep for a ground: samples beside each other differ by more than three thousand times "
               "their spacing; try --nodata V for voids, --z-scale for heights that are not metres";
      }
    }
  }

  Error choose_steps(int halvings, double base_m) {
    const Elevation& facts = rows_.facts();
    report_.width = rows_.width();
    report_.height = rows_.height();
    GroundInfo& ground = info_ = {};
    ground.samples[0] = rows_.width();
    ground.samples[1] = rows_.height();
    double spacing_m[2] = {facts.spacing_x_m, facts.spacing_z_m};
    if (is_curved()) {
      Error error = choose_basis(job_, facts, rows_.width(), rows_.height(), ground, spacing_m);
      if (!error.ok()) return error;
    } else {
      // Of the georeference.
      ground.basis.radius_m = facts.earth.radius_m;
      ground.basis.flattening = facts.earth.flattening;
    }
    report_.spacing_x_m = spacing_m[0];
    report_.spacing_z_m = spacing_m[1];
    const double longer = std::max(spacing_m[0], spacing_m[1]);
    const double step_m =
        regions_.has_lattice()
            ? regions_.voxel_m() / kStepsPerVoxel
            : longer / std::ldexp(is_curved() ? kMostCurvedSteps : kMostSampleSteps, -halvings);
    ground.steps[0] = spacing_m[0] / step_m;
    ground.steps[1] = spacing_m[1] / step_m;
    if (is_curved()) {
      // Rows near a pole may be as narrow as they like.
      for (double& steps : ground.steps) steps = std::max(steps, kLeastSampleSteps);
      ground.basis.height_unit_m = step_m * kVertexStep;
      ground.basis.base_m = base_m;
      if (const Status status = ground.basis.finish(); !status.ok())
        return Error(input() + ": the basis", status);
      if (ground.is_cube() && !has_cube_) {
        app::OutputPlace place;
        if (Error error = app::find_output(output_, place); !error.ok()) return error;
        cube_.folder = place.folder;
        cube_.threads = job_.threads;
        if (Error error = cube_.open(rows_, ground.basis, progress_); !error.ok()) return error;
        has_cube_ = true;
      }
    }
    if (std::min(ground.steps[0], ground.steps[1]) < kLeastSampleSteps) {
      if (halvings == 0) {
        return input() + ": samples are more than 1024 times as long as wide; gdalwarp makes others";
      }
      return input() +
             ": too steep for samples that are so much longer than wide; gdalwarp makes square ones";
    }
    WorldInfo& world = report_.info = {};
    world.voxel_size_m = step_m * kStepsPerVoxel;
    if (!is_curved()) {
      world.origin_m[0] = -0.5 * facts.spacing_x_m * (rows_.width() - 1);
      world.origin_m[1] = base_m;
      world.origin_m[2] = -0.5 * facts.spacing_z_m * (rows_.height() - 1);
    }
    world.extent = {2, 1, 2};
    world.depth = 1;
    world.level = 1;
    if (regions_.has_lattice()) {
      ground.steps[0] = ground.steps[1] = regions_.sample_steps();
      if (regions_.exists()) regions_.tell(world, ground);
      if (!regions_.exists()) regions_.tell_lattice(base_m, world, ground);
      if (!place_regions(ground))
        return input() + ": too many samples for voxels so fine; try a larger --voxel";
      if (Error error = check_rims(); !error.ok()) return error;
    }
    const std::string& path = job_.features_path.empty() ? job_.read.path : job_.features_path;
    const std::string name = job_.sample.empty() ? path.substr(path.find_last_of('/') + 1) : job_.sample;
    for (std::size_t k = 0; k < std::min(name.size(), kWorldNameBytes - 1); ++k)
      world.name[k] = name[k] >= ' ' && name[k] <= '~' ? name[k] : '_';
    materials_.grid.voxel_m = world.voxel_size_m;
    materials_.grid.origin_m = {world.origin_m[0], world.origin_m[1], world.origin_m[2]};
    materials_.grid.extent = world.extent;
    materials_.grid.depth = world.depth;
    return {};
  }

  // That the regions' sides are what the ground meets, as whoever loads the world will find.
  Error check_rims() const {
    std::uint64_t edges_of_all = 0;
    for (std::size_t n = 0; n < info_.regions().size(); ++n) {
      const GroundRegion& region = info_.regions()[n];
      edges_of_all += region.rim_edges;
      if (region.is_field()) continue;
      std::vector<RegionRim::Edge> edges(region.rim_edges);
      std::vector<std::uint32_t> marks(region.rim_edges);
      RegionRim rim;
      rim.create({edges, marks});
      const Status status = rim.build(region, info_.lattice_size, regions_.regions()[n].surface.surface());
      if (!status.ok()) {
        return std::string("--carve: a region cannot be joined to the ground: ") + status.what() +
               "; try a smaller --voxel";
      }
    }
    if (edges_of_all <= kMostRimEdges) return {};
    return "--carve: the regions' borders have " + std::to_string(edges_of_all) + " edges, and the most is " +
           std::to_string(kMostRimEdges) + "; try a larger --voxel";
  }

  void tell_of_regions() {
    report_.shapes = regions_.shapes();
    report_.unmet = regions_.unmet();
    for (const RegionBaker::Region& region : regions_.regions()) {
      BakeGround::Report::Region told;
      told.extent = region.grid.extent;
      told.patches = region.surface.surface().patches.size();
      told.bytes = region.bytes();
      told.misses = region.misses;
      told.folds_left = region.folds_left;
      told.deviation_m = region.deviation_m;
      told.seconds = region.seconds;
      if (region.field != nullptr) {
        const FieldInfo& field = region.field->field().info();
        told.field_triangles = region.field->triangles();
        told.field_blocks = field.stored;
        told.cell_m = std::ldexp(region.grid.voxel_m, field.cell_log2 - kMostCellLog2);
      }
      report_.regions.push_back(told);
    }
  }

  // Some rows of all sizes are in memory. Of a file that is much shorter they are of one height, or made to
  // take memory.
  Error check_memory() const {
    const std::uint64_t bytes = GroundPyramid::bytes_for(info_);
    const std::uint64_t samples =
        static_cast<std::uint64_t>(info_.samples[0]) * static_cast<std::uint64_t>(info_.samples[1]);
    const bool is_allowed =
        job_.read.max_samples > 0 && samples <= static_cast<std::uint64_t>(job_.read.max_samples);
    if (!job_.features_path.empty() || is_allowed ||
        bytes <= std::max(kFreeBytes, kBytesAByte * rows_.file_bytes()))
      return {};
    return input() + ": rows of " + std::to_string(info_.samples[0]) + " samples take " +
           std::to_string(bytes >> 20) + " MiB of memory, and the file has " +
           std::to_string(rows_.file_bytes()) + " bytes; --crop takes a part, --max-samples " +
           std::to_string(samples) + " all of them";
  }

  // Which sections there will be.
  Error outline() {
    if (job_.sample.empty()) {
      materials_.heights = {0.0f, 1.0f};
    } else {
      // Rules are of the sample's own heights, whatever stands far away.
      materials_.sample = job_.sample;
      materials_.octree = &regions_.regions()[0].surface.octree();
      materials_.surface = regions_.regions()[0].surface.surface();
    }
    BakedMaterials outlined;
    if (Error error = materials_.outline(outlined); !error.ok()) return error;
    writer_ = WorldWriter{report_.info, nullptr, {}};
    writer_.materials = outlined.view();
    writer_.materials.surroundings = surroundings();
    writer_.ground.info = info_;
    writer_.ground.earth = earth();
    for (const RegionBaker::Region& region : regions_.regions()) {
      if (region.field != nullptr) writer_.field = &region.field->field();
    }
    return {};
  }

  Error open_imagery() {
    if (!images_.files.empty()) {
      const SamplePlace place = rows_.place();
      const GroundGrid grid{{info_.samples[0], info_.samples[1]},
                            place.known,
                            place.west,
                            place.north,
                            place.step_x,
                            place.step_z,
                            place.crs,
                            info_.is_cube() ? info_.basis.face_quads : 0,
                            info_.basis.radius_m,
                            info_.basis.flattening};
      if (Error error = imagery_.open(grid, info_, report_.imagery); !error.ok()) return error;
      writer_.ground.imagery = report_.imagery.info;
    }
    begin_ = writer_.tiles_begin();
    return {};
  }

  Georeference earth() const {
    if (!is_curved()) return plane_earth(rows_.facts(), rows_.width(), rows_.height());
    Georeference earth;
    earth.epsg = rows_.facts().earth.epsg;
    return earth;
  }

  // Behind the tiles of the ground.
  Error write_imagery() {
    if (images_.files.empty()) return {};
    Error unwritten;
    WorldGround& ground = report_.ground;
    const auto append = [&](std::span<const std::byte> bytes) {
      unwritten = file_.write(begin_ + ground.tile_bytes, bytes);
      return unwritten.ok();
    };
    if (Error error = imagery_.run(ground, append, progress_, report_.imagery); !error.ok()) return error;
    const std::vector<std::string>& more = report_.imagery.warnings;
    report_.warnings.insert(report_.warnings.end(), more.begin(), more.end());
    return unwritten;
  }

  Surroundings surroundings() const {
    Surroundings around;
    if (!water_m_) return around;
    around.flags = kHasWater;
    around.water_level =
        static_cast<float>((*water_m_ - report_.info.origin_m[1]) / report_.info.voxel_size_m);
    return around;
  }

  Error try_tiles(double base_m, Outcome& outcome, double& offending_m) {
    const double vertex_m = report_.info.voxel_size_m / kStepsPerVoxel * kVertexStep;
    const Scale scale(vertex_m, base_m, info_.is_cube() ? 0.0 : rows_.unit_m());
    Error unwritten;
    std::uint64_t end = 0;
    std::vector<RegionMeasure> measures;
    for (const RegionBaker::Region& region : regions_.regions()) measures.push_back(region.measure);
    GroundPyramid pyramid(info_, measures, scale.quantum(), job_.threads,
                          [&](std::span<const std::byte> bytes) {
                            unwritten = file_.write(begin_ + end, bytes);
                            end += bytes.size();
                            return unwritten.ok();
                          });
    std::vector<std::int32_t> row(static_cast<std::size_t>(info_.samples[0]));
    float lowest_m = std::numeric_limits<float>::infinity(), highest_m = -lowest_m;
    int count = 0;
    auto step = GroundPyramid::Outcome::ok;
    const auto take = [&](std::span<const float> heights_m) {
      for (std::size_t n = 0; n < row.size(); ++n) {
        // The last column of a ground that closes is its first one.
        if (n + 1 == row.size() && info_.closes()) {
          row[n] = row[0];
          break;
        }
        const double height = scale.height(double{heights_m[n]});
        if (!(std::abs(height) <= kMostHeight)) {
          outcome = Outcome::out_of_range;
          offending_m = double{heights_m[n]};
          return false;
        }
        row[n] = static_cast<std::int32_t>(height);
        lowest_m = std::min(lowest_m, heights_m[n]);
        highest_m = std::max(highest_m, heights_m[n]);
      }
      step = pyramid.push(row);
      if (++count % kProgressRows == 0 && progress_)
        progress_("tiles", static_cast<std::uint64_t>(count), static_cast<std::uint64_t>(info_.samples[1]));
      return step == GroundPyramid::Outcome::ok;
    };
    if (info_.is_cube()) {
      cube_.run(take);
    } else if (Error error = rows_.run(take); !error.ok()) {
      return error;
    }
    if (!unwritten.ok()) return unwritten;
    if (step == GroundPyramid::Outcome::too_steep) outcome = Outcome::finer_is_too_steep;
    if (outcome != Outcome::done) return {};
    pyramid.finish();
    report_.ground = pyramid.ground();
    report_.ground.earth = earth();
    report_.tiles = pyramid.tiles();
    report_.voids = rows_.voids();
    report_.sunk_samples = rows_.sunk_samples();
    report_.source = rows_.facts().source;
    report_.warnings = rows_.facts().warnings;
    if (job_.water_m && !rows_.is_held() && job_.features_path.empty()) {
      report_.warnings.push_back(input() + ": more than " + std::to_string(GroundRows::kMostHeld) +
                                 " samples: the bed of the sea stays as it is in the elevation");
    }
    report_.lowest_m = double{lowest_m};
    report_.highest_m = double{highest_m};
    warn_of_steps(vertex_m);
    return {};
  }

  // Heights are whole numbers of steps that samples far apart, or far above each other, make long.
  void warn_of_steps(double vertex_m) {
    const double relief_m = report_.highest_m - report_.lowest_m;
    const double spacing_m = std::max(report_.spacing_x_m, report_.spacing_z_m);
    const bool is_much_of_relief = relief_m > 0 && vertex_m > kMostOfRelief * relief_m;
    if (!is_much_of_relief && !(vertex_m > kMostOfSpacing * spacing_m)) return;
    char text[160];
    std::snprintf(text, sizeof text, ": heights are rounded to steps of %.3g m, where all lie within %.4g m",
                  vertex_m, relief_m);
    report_.warnings.push_back(
        input() + text +
        (is_much_of_relief ? "; worlds of voxels have finer ones: leave --ground away"
                           : " and neighbours are steep; try --nodata V for voids, --z-scale for heights "
                             "that are not metres"));
  }

  Error write_head() {
    const auto voxels = [&](std::int32_t height) {
      return static_cast<float>(height) * static_cast<float>(kVertexStep) /
             static_cast<float>(kStepsPerVoxel);
    };
    const GroundInfo& ground = report_.ground.info;
    // Of a curved basis heights count from its own.
    const auto base = static_cast<float>(ground.basis.base_m / report_.info.voxel_size_m);
    if (job_.sample.empty()) materials_.heights = {voxels(ground.low) + base, voxels(ground.high) + base};
    if (Error error = materials_.run(report_.materials); !error.ok()) return error;
    std::vector<std::byte> memory(Octree::bytes_for(1) + Arena::kAlignment);
    void* aligned = memory.data();
    std::size_t space = memory.size();
    std::align(Arena::kAlignment, Octree::bytes_for(1), aligned, space);
    Arena arena({static_cast<std::byte*>(aligned), space});
    Octree octree;
    Status status = octree.create(arena, 1, 1);
    writer_.octree = &octree;
    Patches patches;
    std::vector<const Octree*> octrees;
    for (const RegionBaker::Region& region : regions_.regions()) {
      patches.add(region, static_cast<std::uint32_t>(octrees.size()));
      octrees.push_back(&region.surface.octree());
    }
    writer_.octrees = octrees;
    writer_.patches = patches.view();
    writer_.materials = report_.materials.view();
    writer_.materials.surroundings = surroundings();
    writer_.ground = report_.ground;
    std::vector<std::byte> head, tail;
    const auto append_to = [](std::vector<std::byte>& all) {
      return [&all](std::span<const std::byte> bytes) {
        all.insert(all.end(), bytes.begin(), bytes.end());
        return true;
      };
    };
    const auto to_head = append_to(head);
    const auto to_tail = append_to(tail);
    if (status.ok()) status = writer_.run_around(ByteSink::to(to_head), ByteSink::to(to_tail));
    if (!status.ok()) return Error("world", status);
    KARST_ASSERT(head.size() == begin_);
    if (Error error = file_.write(begin_ + report_.ground.tile_bytes, tail); !error.ok()) return error;
    report_.bytes = writer_.file_bytes();
    return file_.write(0, head);
  }

  const Bake& job_;
  const std::string& output_;
  BakeGround::Report& report_;
  const ReportProgress& progress_;
  Sample sample_;
  SampleGrid sample_grid_;
  GroundRows rows_;
  CubeRows cube_;
  bool has_cube_ = false;
  RegionBaker regions_;
  BakeMaterials materials_;
  GroundInfo info_;
  WorldWriter writer_;
  std::uint64_t begin_ = 0;  // of tiles in the file
  const ImageryOptions& images_;
  BakeImagery imagery_;
  std::optional<double> water_m_;
  app::AtomicFile file_;
};

}  // namespace

Error BakeGround::run(Report& report, const ReportProgress& progress) const {
  report = Report();
  return GroundBaker(*this, report, progress).run();
}

}  // namespace karst::bake
