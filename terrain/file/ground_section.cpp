// SPDX-License-Identifier: MIT
#include "terrain/file/ground_section.h"

#include <algorithm>
#include <cmath>

#include "terrain/base/check.h"
#include "terrain/base/config.h"
#include "terrain/file/world_layout.h"

namespace karst::core::ground_section {

using world_layout::load;
using world_layout::store;

namespace {

constexpr std::size_t kSamples = 0;  // two
constexpr std::size_t kSteps = 16;   // two
constexpr std::size_t kLow = 32;
constexpr std::size_t kHigh = 36;
constexpr std::size_t kRootOffset = 40;
constexpr std::size_t kRootBytes = 48;
constexpr std::size_t kRootCrc = 52;
constexpr std::size_t kReserved = 56;  // 8
constexpr std::size_t kRegion = 64;    // its first node: two
constexpr std::size_t kRimEdges = 72;
constexpr std::size_t kRegionReserved = 76;

}  // namespace

Fault check(const WorldInfo& world, const WorldGround& ground) {
  const GroundInfo& info = ground.info;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (info.samples[axis] < 2 || info.samples[axis] > kMostSamples)
      return {"samples are outside 2..2^22 + 1", kSamples + axis * 8};
    // Written so that NaN fails.
    const double most = std::ldexp(kMostSampleSteps, info.lattice_size);
    if (!(info.steps[axis] >= kLeastSampleSteps && info.steps[axis] <= most))
      return {"steps are outside 2..2048, or with a region 2^19", kSteps + axis * 8};
  }
  if (info.low < -kMostHeight || info.low > info.high) return {"low is below -2^26 or above high", kLow};
  if (info.high > kMostHeight) return {"high is above 2^26", kHigh};
  if (!ground.root.exists() || ground.root.offset > ground.tile_bytes ||
      ground.root.bytes > ground.tile_bytes - ground.root.offset)
    return {"the root's tile does not lie in the tiles", kRootOffset};
  if (info.region.exists() != (world.patches > 0))
    return {"there are patches but no region, or the other way round", kRegion};
  GroundInfo placed = info;
  if (info.region.exists() &&
      !(place_region(placed, world.extent.x, world.extent.z, info.region.low[0], info.region.low[1]) &&
        placed.region == info.region && placed.corner[0] == info.corner[0] &&
        placed.corner[1] == info.corner[1]))
    return {"the voxels are no region of the ground", kRegion};
  if (info.region.exists() && (info.rim_edges == 0 || info.rim_edges > kMostRimEdges))
    return {"rim_edges are outside 1..16384", kRimEdges};
  return {};
}

Fault decode(std::span<const std::byte> section, const WorldInfo& world, std::uint64_t tile_bytes,
             WorldGround& ground) {
  KARST_ASSERT(section.size() == bytes_of(world));
  WorldGround read;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    read.info.samples[axis] = load<std::int64_t>(section, kSamples + axis * 8);
    read.info.steps[axis] = load<double>(section, kSteps + axis * 8);
  }
  read.info.low = load<std::int32_t>(section, kLow);
  read.info.high = load<std::int32_t>(section, kHigh);
  read.root.offset = load<std::uint64_t>(section, kRootOffset);
  read.root.bytes = load<std::uint32_t>(section, kRootBytes);
  read.root.crc = load<std::uint32_t>(section, kRootCrc);
  read.tile_bytes = tile_bytes;
  read.tile_crc = ground.tile_crc;
  if (!world_layout::all_zero(section.subspan(kReserved, 8))) return {"a reserved field is not 0", kReserved};
  if (world.patches > 0) {
    if (!world_layout::all_zero(section.subspan(kRegionReserved, 4)))
      return {"a reserved field is not 0", kRegionReserved};
    // Before samples and steps are known to be within their ranges.
    for (const std::int64_t samples : read.info.samples) {
      if (samples < 2 || samples > kMostSamples) return {"samples are outside 2..2^22 + 1", kSamples};
    }
    if (!place_region(read.info, world.extent.x, world.extent.z, load<std::int32_t>(section, kRegion),
                      load<std::int32_t>(section, kRegion + 4)))
      return {"the voxels are no region of the ground", kRegion};
    read.info.rim_edges = load<std::uint32_t>(section, kRimEdges);
  }
  const Fault fault = check(world, read);
  if (fault.what == nullptr) ground = read;
  return fault;
}

void encode(const WorldGround& ground, std::span<std::byte> out) {
  std::fill(out.begin(), out.end(), std::byte{0});
  for (std::size_t axis = 0; axis < 2; ++axis) {
    store(out, kSamples + axis * 8, ground.info.samples[axis]);
    store(out, kSteps + axis * 8, ground.info.steps[axis]);
  }
  store(out, kLow, ground.info.low);
  store(out, kHigh, ground.info.high);
  store(out, kRootOffset, ground.root.offset);
  store(out, kRootBytes, ground.root.bytes);
  store(out, kRootCrc, ground.root.crc);
  if (!ground.info.region.exists()) return;
  for (std::size_t axis = 0; axis < 2; ++axis) store(out, kRegion + axis * 4, ground.info.region.low[axis]);
  store(out, kRimEdges, ground.info.rim_edges);
}

}  // namespace karst::core::ground_section
