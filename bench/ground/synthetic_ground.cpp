// SPDX-License-Identifier: MIT
#include "bench/ground/synthetic_ground.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "terrain/base/check.h"
#include "terrain/base/checksum.h"
#include "terrain/field/octree.h"
#include "terrain/file/world_writer.h"
#include "terrain/ground/measure_ground.h"
#include "tiles/encode_tile.h"

namespace karst::bench {
using namespace core;
namespace {

// Lattice steps from a sample to the next: 2^20 samples are below 2^31 steps.
constexpr double kSteps = 1024;

// Octaves: wavelengths of 4 to 2,048 samples, each with this part of its wavelength as amplitude.
constexpr int kFinestWave = 2, kCoarsestWave = 11;  // log2
constexpr double kSteepness = 0.015;

constexpr double wave(int octave) {
  return static_cast<double>(std::int64_t{1} << octave);
}
// kVertexStep.
constexpr double amplitude(int octave) {
  return kSteepness * wave(octave) * kSteps / kVertexStep;
}

// SplitMix64's finish (G. Steele and others, "Fast Splittable Pseudorandom Number Generators", 2014), of a
// corner's place; -1..1.
double random_at(std::int64_t x, std::int64_t z, int octave) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15u +
                    static_cast<std::uint64_t>(z) * 0xc2b2ae3d27d4eb4fu + static_cast<std::uint64_t>(octave);
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((h ^ (h >> 31)) >> 11) * 0x1p-52 - 1.0;
}

double smooth(double t) {
  return t * t * (3 - 2 * t);
}

// Bounds, kVertexStep; lengths in samples.
double deviation(double leg) {
  double sum = 0;
  for (int o = kFinestWave; o <= kCoarsestWave; ++o) {
    const double part = leg / wave(o);
    sum += amplitude(o) * std::min(2.0, 21.0 / 4.0 * part * part);
  }
  return sum;
}
double rise(double way) {
  double sum = 0;
  for (int o = kFinestWave; o <= kCoarsestWave; ++o) sum += amplitude(o) * std::min(2.0, 3 * way / wave(o));
  return sum;
}
constexpr double kRounding = 1;  // of heights, both ends of a difference

// One node's, as MeasureNodes takes them.
struct OneNode {
  std::int32_t low = 0, high = 0;
  float most = 0, tall = 0;
  std::array<std::uint16_t, kDemands> thresholds{};

  NodeRow row() {
    NodeRow out;
    out.low = {&low, 1};
    out.high = {&high, 1};
    for (std::span<float>& band : out.most) band = {&most, 1};
    for (std::span<float>& border : out.border) border = {&most, 1};
    out.tall = {&tall, 1};
    out.thresholds = thresholds;
    return out;
  }
};

}  // namespace

SyntheticGround::SyntheticGround(int log2_samples) {
  KARST_ASSERT(log2_samples >= kLeastLog2 && log2_samples <= kMostLog2);
  for (int axis = 0; axis < 2; ++axis) {
    info_.samples[axis] = (std::int64_t{1} << log2_samples) + 1;
    info_.steps[axis] = kSteps;
  }
  middle_ = std::int64_t{1} << (log2_samples - 1);
  double sum = kRounding;
  for (int o = kFinestWave; o <= kCoarsestWave; ++o) sum += amplitude(o);
  info_.high = static_cast<std::int32_t>(sum);
  info_.low = -info_.high;
  bound();
}

void SyntheticGround::bound() {
  OneNode finer;
  for (int size = 0; size <= kMostSize; ++size) {
    const auto at = static_cast<std::size_t>(size);
    const double leg = std::ldexp(1.0, size);
    // The full surface is itself made of pieces, of one sample.
    const double stray = size == 0 ? 0 : deviation(leg) + deviation(1) + kRounding;
    strays_[at] = static_cast<std::int32_t>(std::ceil(stray));
    OneNode own;
    own.low = 0;
    own.high = static_cast<std::int32_t>(std::ceil(rise(2 * kNodeQuads * leg) + 2 * stray + kRounding));
    if (size > 0) {
      // At any share of the way: what the children stray at home, and the way.
      const double way = deviation(leg) + kRounding;
      own.most = static_cast<float>((strays_[at - 1] + way) * kVertexStep);
      own.tall = static_cast<float>((rise(2 * leg) + 2 * way) * kVertexStep);
    }
    NodeRow row = own.row();
    NodeRow below = finer.row();
    MeasureNodes measure;
    measure.info = &info_;
    measure.size = size;
    measure.own = &row;
    measure.finer[0] = size > 0 ? &below : nullptr;
    measure.run();
    thresholds_[at] = own.thresholds;
    finer = own;
  }
}

std::int32_t SyntheticGround::height(std::int64_t east, std::int64_t south) const {
  double sum = 0;
  for (int o = kFinestWave; o <= kCoarsestWave; ++o) {
    const std::int64_t x = east >> o, z = south >> o;
    const std::int64_t mask = (std::int64_t{1} << o) - 1;
    const double u = smooth(static_cast<double>(east & mask) / wave(o));
    const double v = smooth(static_cast<double>(south & mask) / wave(o));
    const double west_north = random_at(x, z, o), east_north = random_at(x + 1, z, o);
    const double west_south = random_at(x, z + 1, o), east_south = random_at(x + 1, z + 1, o);
    const double north = west_north + (east_north - west_north) * u;
    const double on_south = west_south + (east_south - west_south) * u;
    sum += amplitude(o) * (north + (on_south - north) * v);
  }
  return static_cast<std::int32_t>(std::floor(sum + 0.5));
}

void SyntheticGround::make_tile(NodeKey key, Tile& out) const {
  out = {};
  const auto sample = [&](int axis, std::int64_t index) {
    return sample_of(info_.samples[axis], key.size, index) - middle_;
  };
  std::int32_t* to = out.heights;
  for (int k = -kTileRim; k <= kTileQuads + kTileRim; ++k) {
    const std::int64_t south = sample(1, std::int64_t{key.z} * kTileQuads + k);
    for (int i = -kTileRim; i <= kTileQuads + kTileRim; ++i)
      *to++ = height(sample(0, std::int64_t{key.x} * kTileQuads + i), south);
  }
  const auto at = static_cast<std::size_t>(key.size);
  for (int n = 0; n < kTileMeasures; ++n) {
    const int i = n % kTileNodes, k = n / kTileNodes;
    if (!node_exists(info_, {key.size, key.x * kTileNodes + i, key.z * kTileNodes + k})) continue;
    NodeMeasure& measure = out.nodes[n];
    std::copy(thresholds_[at].begin(), thresholds_[at].end(), measure.thresholds);
    measure.low = measure.high = out.height(i * kNodeQuads, k * kNodeQuads);
    for (int v = 0; v < kNodeVertices; ++v) {
      const std::int32_t h = out.height(i * kNodeQuads + v % kNodeSide, k * kNodeQuads + v / kNodeSide);
      measure.low = std::min(measure.low, h);
      measure.high = std::max(measure.high, h);
    }
    measure.low = std::max(measure.low - strays_[at], info_.low);
    measure.high = std::min(measure.high + strays_[at], info_.high);
  }
  for (int quadrant = 0; quadrant < 4 && key.size > 0; ++quadrant) {
    const NodeKey child = key.child(quadrant);
    if (node_exists(info_, {child.size, child.x * kTileNodes, child.z * kTileNodes}))
      out.children[quadrant].bytes = 1;
  }
}

std::vector<std::byte> SyntheticGround::file() const {
  const auto tile = std::make_unique<Tile>();
  make_tile(root(), *tile);
  tiles::TileEncoder encoder;
  std::vector<std::byte> bytes;
  encoder.run(root(), info_, *tile, 1, bytes);
  // Children lie before their parents: in the first byte.
  std::vector<std::byte> all(1);
  all.insert(all.end(), bytes.begin(), bytes.end());

  WorldWriter writer;
  WorldInfo& info = writer.info;
  info.voxel_size_m = kSpacing_m / kSteps * kStepsPerVoxel;
  info.origin_m[0] = info.origin_m[2] = -kSpacing_m * static_cast<double>(middle_);
  info.extent = {2, 1, 2};
  info.depth = 1;
  info.level = 1;
  const std::string name = "synthetic ground";
  std::copy(name.begin(), name.end(), info.name);
  std::vector<std::byte> memory(Octree::bytes_for(1) + Arena::kAlignment);
  void* aligned = memory.data();
  std::size_t space = memory.size();
  std::align(Arena::kAlignment, Octree::bytes_for(1), aligned, space);
  Arena arena({static_cast<std::byte*>(aligned), space});
  Octree octree;
  Status status = octree.create(arena, info.depth, 1);
  writer.octree = &octree;
  writer.ground.info = info_;
  writer.ground.root = {1, static_cast<std::uint32_t>(bytes.size()), crc32c(bytes)};
  writer.ground.tile_bytes = all.size();
  writer.ground.tile_crc = crc32c(all);
  std::vector<std::byte> out, tail;
  const auto append_to = [](std::vector<std::byte>& to) {
    return [&to](std::span<const std::byte> piece) {
      to.insert(to.end(), piece.begin(), piece.end());
      return true;
    };
  };
  const auto to_head = append_to(out);
  const auto to_tail = append_to(tail);
  if (status.ok()) status = writer.run_around(ByteSink::to(to_head), ByteSink::to(to_tail));
  KARST_ASSERT(status.ok());
  out.insert(out.end(), all.begin(), all.end());
  out.insert(out.end(), tail.begin(), tail.end());
  return out;
}

}  // namespace karst::bench
