// SPDX-License-Identifier: MIT
#include "bake/voxels/region_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include <glm/geometric.hpp>

#include "bake/base/parallel.h"
#include "terrain/blocks/isosurface.h"
#include "terrain/file/fields/field_section.h"

namespace karst::bake {
using namespace core;
namespace {

constexpr int kBlock = 16;
using Samples = std::array<std::int8_t, FieldBlocks::kBlockBytes>;

// Of a solid, at samples from the grid's first voxel's centre.
class Sampler {
 public:
  Sampler(const Solid& solid, const WorldGrid& grid, int cells_log2, double steepest)
      : solid_(solid),
        cell_m_(std::ldexp(grid.voxel_m, -cells_log2)),
        origin_m_(grid.origin_m + 0.5 * grid.voxel_m),
        steepest_(steepest) {}

  // Of a block and the samples around it; NaN: not asked for yet.
  struct Values {
    static constexpr int kSide = kBlock + 2;
    glm::ivec3 corner{0};
    std::array<double, std::size_t{kSide} * kSide * kSide> value;
  };

  // False: no sample tells a distance, and all are like `filling`.
  bool block(glm::ivec3 corner, Values& values, Samples& out, std::int8_t& filling) const {
    double value = 0;
    if (is_far(corner, kBlock, value)) {
      filling = value > 0 ? std::int8_t{-128} : std::int8_t{127};
      return false;
    }
    values.corner = corner;
    values.value.fill(std::numeric_limits<double>::quiet_NaN());
    constexpr int kHalf = kBlock / 2;
    for (int o = 0; o < 8; ++o) {
      const glm::ivec3 from = kHalf * glm::ivec3(o & 1, o >> 1 & 1, o >> 2);
      const bool far = is_far(corner + from, kHalf, value);
      for (int n = 0; n < kHalf * kHalf * kHalf; ++n) {
        const glm::ivec3 at = from + glm::ivec3(n % kHalf, n / kHalf % kHalf, n / kHalf / kHalf);
        const auto place = static_cast<std::size_t>(at.x + kBlock * (at.y + kBlock * at.z));
        out[place] = far ? (value > 0 ? std::int8_t{-128} : std::int8_t{127}) : sample(corner + at, values);
      }
    }
    filling = out[0];
    return (filling != -128 && filling != 127) ||
           std::any_of(out.begin(), out.end(), [&](std::int8_t s) { return s != filling; });
  }

 private:
  double value(glm::dvec3 at) const { return solid_.value_m(origin_m_ + cell_m_ * at); }

  // Whether nothing of a cube is within reach of the surface; value: at its middle.
  bool is_far(glm::ivec3 corner, int side, double& value_m) const {
    const double half = 0.5 * (side - 1);
    value_m = value(glm::dvec3(corner) + half);
    return std::abs(value_m) > steepest_ * cell_m_ * (half * std::sqrt(3.0) + RegionField::kReachCells + 1);
  }

  // A distance: the value over what it changes by over a length.
  std::int8_t sample(glm::ivec3 s, Values& values) const {
    double v = at(s, values);
    if (std::abs(v) < steepest_ * cell_m_ * RegionField::kReachCells) {
      glm::dvec3 slope;
      for (int axis = 0; axis < 3; ++axis) {
        glm::ivec3 step(0);
        step[axis] = 1;
        slope[axis] = (at(s + step, values) - at(s - step, values)) / (2 * cell_m_);
      }
      // Where surfaces meet, opposite slopes cancel.
      v /= std::max(glm::length(slope), 0.5);
    }
    const double scaled = std::floor(-v / cell_m_ * 128 / RegionField::kReachCells);
    return static_cast<std::int8_t>(std::clamp(scaled, -128.0, 127.0));
  }

  // Each is asked for once.
  double at(glm::ivec3 s, Values& values) const {
    const glm::ivec3 inside = s - values.corner + 1;
    double& known = values.value[static_cast<std::size_t>(
        inside.x + Values::kSide * (inside.y + Values::kSide * inside.z))];
    if (std::isnan(known)) known = value(glm::dvec3(s));
    return known;
  }

  const Solid& solid_;
  double cell_m_;
  glm::dvec3 origin_m_;
  double steepest_;
};

}  // namespace

Error RegionField::sample(const Solid& solid, const WorldGrid& grid, int cells_log2, double steepest,
                          int column_log2, int threads) {
  FieldInfo info;
  info.cell_log2 = kMostCellLog2 - cells_log2;
  info.in_region = true;
  info.reach_cells = static_cast<float>(kReachCells);
  for (int axis = 0; axis < 3; ++axis) {
    const int cells = (grid.extent[axis] - (axis == 1 ? 0 : 1)) << cells_log2;
    info.blocks[axis] = (cells + kBlock - 1) / kBlock + (axis == 1 ? 0 : 1);
  }
  const std::size_t count = info.table_blocks();
  std::vector<std::unique_ptr<Samples>> made(count);
  std::vector<std::int8_t> fillings(count);
  const Sampler sampler(solid, grid, cells_log2, steepest);
  const auto place_of = [&](std::size_t n) {
    const auto b = static_cast<int>(n);
    return glm::ivec3(b % info.blocks.x, b / info.blocks.x % info.blocks.y,
                      b / info.blocks.x / info.blocks.y);
  };
  parallel_chunks(count, 16, threads, [&](std::size_t first, std::size_t last, int) {
    auto room = std::make_unique<Samples>();
    const auto values = std::make_unique<Sampler::Values>();
    for (std::size_t n = first; n < last; ++n) {
      if (!sampler.block(place_of(n) * kBlock, *values, *room, fillings[n])) continue;
      made[n] = std::move(room);
      room = std::make_unique<Samples>();
    }
  });
  info.stored = static_cast<std::uint32_t>(
      std::count_if(made.begin(), made.end(), [](const auto& m) { return m != nullptr; }));
  table_.resize(count);
  samples_.resize(std::size_t{info.stored} * FieldBlocks::kBlockBytes);
  field_.create({table_, samples_});
  if (const Status status = field_.reset(info); !status.ok()) return Error("--carve-as field", status);
  for (std::size_t n = 0; n < count; ++n) {
    if (made[n] == nullptr) {
      field_.bytes().fill(place_of(n), fillings[n]);
      continue;
    }
    std::ranges::copy(*made[n], field_.bytes().open(place_of(n)).begin());
    made[n].reset();
  }
  return mesh(column_log2);
}

// All of it at its finest, as whoever draws it makes it.
Error RegionField::mesh(int column_log2) {
  Config config;
  config.field_blocks = static_cast<std::uint32_t>(table_.size());
  config.field_sample_blocks = field_.info().stored;
  config.field_meshes = 4 * config.field_sample_blocks + 64;
  config.rim_edges = kMostRimEdges;
  for (std::uint32_t pages = 64 * config.field_sample_blocks + 4'096;; pages *= 2) {
    config.field_vertex_pages = config.field_index_pages = pages;
    Budget budget;
    Isosurface::add_to(budget, config);
    std::vector<std::byte> memory(budget.cpu_bytes() + Arena::kAlignment);
    void* at = memory.data();
    std::size_t room = memory.size();
    std::align(Arena::kAlignment, budget.cpu_bytes(), at, room);
    Arena arena({static_cast<std::byte*>(at), budget.cpu_bytes()});
    Isosurface isosurface;
    if (const Status status = isosurface.create(config, arena); !status.ok())
      return Error("--carve-as field", status);
    isosurface.attach(field_, {glm::ivec3(0), std::int64_t{kStepsPerVoxel} << column_log2});
    BlockEye eye;
    eye.steps_per_step = std::numeric_limits<float>::infinity();
    isosurface.begin_frame();
    isosurface.choose(std::span(&eye, 1));
    points_.clear();
    MeshUpload upload;
    Status status;
    while (isosurface.make_next(upload, status)) {
      const double step = std::ldexp(1.0, upload.size) / kStepsPerVoxel;
      for (const GpuVertex& v : upload.vertices) {
        points_.push_back(std::ldexp(1.0, upload.size) * glm::dvec3(upload.origin) +
                          step * glm::dvec3(v.position[0], v.position[1], v.position[2]));
      }
    }
    if (!status.ok()) return Error("--carve-as field", status);
    if (isosurface.error_scale() > 1) continue;
    if (isosurface.drawn().empty()) return "--carve-as field: nothing, or everything, is filled";
    triangles_ = isosurface.list(0, nullptr).triangles;
    rim_edges_ = isosurface.rim().count();
    if (isosurface.rim().exists()) return {};
    return "--carve-as field: a region cannot be joined to the ground: its sides are not one line; try a "
           "smaller --voxel";
  }
}

std::uint64_t RegionField::bytes() const {
  return field_section::section_bytes(field_section::info_of(field_));
}

}  // namespace karst::bake
