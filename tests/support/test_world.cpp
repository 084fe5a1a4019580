// SPDX-License-Identifier: MIT
#include "tests/support/test_world.h"

#include <cmath>
#include <cstdlib>

#include "terrain/field/voxelize.h"
#include "terrain/measure/level_error.h"
#include "terrain/measure/shading_cone.h"
#include "terrain/patch/displacement.h"
#include "terrain/surface/bezier/extract_surface.h"

namespace karst::test {
using namespace core;
namespace {

// The first address in memory that is aligned for an arena.
std::span<std::byte> aligned(std::vector<std::byte>& memory) {
  const std::uintptr_t at = reinterpret_cast<std::uintptr_t>(memory.data());
  const std::size_t skip = (Arena::kAlignment - at % Arena::kAlignment) % Arena::kAlignment;
  return std::span(memory).subspan(skip);
}

void require(const Status& status) {
  if (!status.ok()) std::abort();
}

}  // namespace

std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

double value_noise(std::uint64_t seed, glm::dvec3 p) {
  const glm::dvec3 cell(std::floor(p.x), std::floor(p.y), std::floor(p.z));
  double value = 0;
  for (int o = 0; o < 8; ++o) {
    double weight = 1;
    std::uint64_t h = seed;
    for (int axis = 0; axis < 3; ++axis) {
      const int up = o >> axis & 1;
      const double f = p[axis] - cell[axis];
      const double s = f * f * (3 - 2 * f);
      weight *= up != 0 ? s : 1 - s;
      h = mix(h ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(cell[axis]) + up));
    }
    value += weight * (static_cast<double>(h >> 11) * 0x1p-52 - 1);
  }
  return value;
}

TestWorld::TestWorld(glm::ivec3 extent, const std::function<bool(glm::ivec3)>& filled, bool mirrors)
    : extent_(extent) {
  int depth = 1;
  while ((1 << depth) < extent.x || (1 << depth) < extent.z || (1 << depth) <= extent.y) ++depth;
  const std::uint32_t max_octets = (1u << (3 * depth)) / 7 + 8;
  memory_.resize(Octree::bytes_for(max_octets) + Arena::kAlignment);
  Arena arena(aligned(memory_));
  require(octree_.create(arena, depth, max_octets));
  const auto ask = [&filled](glm::ivec3 v, bool) { return filled(v); };
  VoxelizePredicate voxelize;
  voxelize.extent = extent;
  voxelize.filled = VoxelFunction(ask);
  require(voxelize.run(octree_));

  ExtractSurface extract;
  extract.octree = &octree_;
  extract.extent = extent;
  extract.mirrors = mirrors;
  ExtractSurface::Result counted;
  require(extract.count(counted));
  volumes_.resize(counted.volumes);
  patches_.resize(counted.patches);
  std::vector<std::uint32_t> scratch(ExtractSurface::scratch_size(counted.volumes));
  extract.volumes = volumes_;
  extract.patches = patches_;
  extract.scratch = scratch;
  ExtractSurface::Result made;
  require(extract.run(made));
}

TestWorld TestWorld::noise(std::uint64_t seed, glm::ivec3 extent, double density, double wavelength,
                           bool closed) {
  return TestWorld(extent, [=](glm::ivec3 v) {
    const bool rim =
        v.x == 0 || v.y == 0 || v.z == 0 || v.x == extent.x - 1 || v.y == extent.y - 1 || v.z == extent.z - 1;
    if (closed && rim) return false;
    if (wavelength > 0) return value_noise(seed, glm::dvec3(v) / wavelength) < 2 * density - 1;
    const std::uint64_t key = static_cast<std::uint64_t>(v.x + 1024 * (v.y + 1024 * v.z));
    return static_cast<double>(mix(seed ^ mix(key)) >> 11) * 0x1p-53 < density;
  });
}

TestWorld TestWorld::hills(glm::ivec3 extent) {
  return TestWorld(
      extent, [](glm::ivec3 v) { return v.y + 0.5 < 5 + 3 * value_noise(3, glm::dvec3(v.x, 0, v.z) / 6.0); });
}

void TestWorld::set_heights(int level, const std::function<double(glm::dvec3)>& height_steps) {
  level_ = level;
  const int side = patch_side(level);
  heights_.assign(patches_.size() * static_cast<std::size_t>(patch_vertices(level)), 0);
  for (PatchId p = 0; p < patches_.size(); ++p) {
    patches_[p].height_block = p;
    const glm::dvec3 corner = glm::dvec3(patch_origin(volumes_[patches_[p].volume])) / double{kStepsPerVoxel};
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const double h = height_steps(corner + base_point(surface(), level, p, i, j).position);
        const std::size_t at = static_cast<std::size_t>(p) * static_cast<std::size_t>(side * side) +
                               static_cast<std::size_t>(j * side + i);
        heights_[at] = static_cast<std::int16_t>(std::lround(h));
      }
    }
  }
}

void TestWorld::roughen(int level, std::uint64_t seed, int amplitude) {
  set_heights(level, [=](glm::dvec3 p) {
    std::uint64_t h = seed;
    // Undisplaced points are multiples of 2^-25 voxel.
    for (int axis = 0; axis < 3; ++axis)
      h = mix(h ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(p[axis] * 0x1p25)));
    return (static_cast<double>(h >> 11) * 0x1p-52 - 1) * amplitude;
  });
}

WorldInfo TestWorld::info() const {
  core::WorldInfo info;
  info.voxel_size_m = voxel_size_m;
  info.extent = extent_;
  info.depth = octree_.depth();
  info.level = level_;
  info.octets = octree_.octets_used();
  info.volumes = static_cast<std::uint32_t>(volumes_.size());
  info.patches = static_cast<std::uint32_t>(patches_.size());
  info.height_blocks = heights_.empty() ? 0 : info.patches;
  return info;
}

std::vector<PatchKey> TestWorld::keys() const {
  std::vector<PatchKey> keys;
  for (PatchId p = 0; p < patches_.size(); ++p) keys.push_back(key_of(surface(), p));
  return keys;
}

std::vector<std::uint16_t> TestWorld::level_errors() const {
  std::vector<BorderErrors> borders(patches_.size());
  std::vector<std::uint16_t> values(patches_.size() * level_error_values(level_));
  const MeasureLevelErrors measure{surface(), heights(), borders, values};
  require(measure.validate());
  measure.measure(0, static_cast<PatchId>(patches_.size()));
  measure.join(0, static_cast<PatchId>(patches_.size()));
  return values;
}

std::vector<PatchBounds> TestWorld::bounds() const {
  const TestScratch scratch;
  GenerateVertices generate;
  generate.surface = surface();
  generate.heights = heights();
  generate.level = level_;
  generate.scratch = scratch.get();
  require(generate.validate());
  std::vector<PatchBounds> boxes;
  for (PatchId p = 0; p < patches_.size(); ++p) boxes.push_back(generate.bounds(p));
  return boxes;
}

std::vector<NormalCone> TestWorld::cones() const {
  std::vector<NormalCone> cones(patches_.size());
  const MeasureNormalCones measure{surface(), heights(), cones};
  require(measure.validate());
  measure.run(0, static_cast<PatchId>(patches_.size()));
  return cones;
}

std::vector<NormalCone> TestWorld::shading_cones() const {
  std::vector<NormalCone> cones;
  for (PatchId p = 0; p < patches_.size(); ++p) cones.push_back(measure_shading_cone(vertices(p, level_)));
  return cones;
}

std::vector<std::byte> TestWorld::file(const WorldMaterials& materials) const {
  const core::WorldInfo i = info();
  std::vector<std::byte> mask((i.patches + 7) / 8, std::byte{0});
  for (std::uint32_t p = 0; p < i.height_blocks; ++p) mask[p / 8] |= static_cast<std::byte>(1u << (p % 8));
  const std::vector<PatchKey> patch_keys = keys();
  const std::vector<std::uint16_t> errors = level_errors();
  const std::vector<PatchBounds> boxes = bounds();
  const std::vector<NormalCone> normals = cones();
  const std::vector<NormalCone> shading = shading_cones();
  std::vector<std::byte> out;
  const auto append = [&](std::span<const std::byte> bytes) {
    out.insert(out.end(), bytes.begin(), bytes.end());
    return true;
  };
  const WorldWriter writer{
      i, &octree_, {patch_keys, mask, heights_, errors, boxes, normals, shading}, materials};
  require(writer.run(ByteSink::to(append)));
  return out;
}

std::vector<GpuVertex> TestWorld::vertices(PatchId patch, int level) const {
  const TestScratch scratch;
  GenerateVertices generate;
  generate.surface = surface();
  generate.heights = heights();
  generate.level = level;
  generate.scratch = scratch.get();
  require(generate.validate());
  std::vector<GpuVertex> out(static_cast<std::size_t>(patch_vertices(level)));
  generate.run(patch, out, nullptr);
  return out;
}

AlignedBytes::AlignedBytes(std::size_t size)
    : memory_(size + Arena::kAlignment), bytes_(aligned(memory_).first(size)) {}

TestScratch::TestScratch() : memory_(patch_scratch_bytes()), scratch_(make_patch_scratch(memory_.bytes())) {}

}  // namespace karst::test
