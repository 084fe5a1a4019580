// SPDX-License-Identifier: MIT
#include "terrain/file/ground_section.h"

#include <algorithm>

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
constexpr std::size_t kReserved = 56;
// In REGN.
constexpr std::size_t kFirstNode = 0;  // two
constexpr std::size_t kRimEdges = 8;
constexpr std::size_t kRegionReserved = 12;

// Of IMAG.
constexpr std::size_t kFormat = 0;
constexpr std::size_t kLeastSize = 4;
constexpr std::size_t kImageOffset = 8;
constexpr std::size_t kImageBytes = 16;
constexpr std::size_t kImageCrc = 20;
constexpr std::size_t kImageReserved = 24;

}  // namespace

Fault check(const WorldGround& ground) {
  const GroundInfo& info = ground.info;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (info.samples[axis] < 2 || info.samples[axis] > kMostSamples)
      return {"samples are outside 2..2^22 + 1", kSamples + axis * 8};
    // Written so that NaN fails.
    if (!(info.steps[axis] >= kLeastSampleSteps && info.steps[axis] <= kMostRegionSteps))
      return {"steps are outside 2..2048, or with a region 2^19", kSteps + axis * 8};
  }
  if (info.low < -kMostHeight || info.low > info.high) return {"low is below -2^26 or above high", kLow};
  if (info.high > kMostHeight) return {"high is above 2^26", kHigh};
  if (!ground.root.exists() || ground.root.offset > ground.tile_bytes ||
      ground.root.bytes > ground.tile_bytes - ground.root.offset)
    return {"the root's tile does not lie in the tiles", kRootOffset};
  return {};
}

Fault decode(std::span<const std::byte, kBytes> section, std::uint64_t tile_bytes, WorldGround& ground) {
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
  if (!world_layout::all_zero(section.subspan(kReserved))) return {"a reserved field is not 0", kReserved};
  const Fault fault = check(read);
  if (fault.what == nullptr) ground = read;
  return fault;
}

void encode(const WorldGround& ground, std::span<std::byte, kBytes> out) {
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
}

Fault check_region(const WorldInfo& world, const GroundInfo& ground) {
  if (!ground.region.exists()) {
    if (world.patches > 0) return {"there are patches, but no region for them", kFirstNode};
    const bool finer = ground.steps[0] > kMostSampleSteps || ground.steps[1] > kMostSampleSteps;
    return finer ? Fault{"steps are above 2048 without a region", kSteps} : Fault{};
  }
  if (world.patches == 0) return {"there is a region, but no patches", kFirstNode};
  GroundInfo placed = ground;
  if (!place_region(placed, world.extent.x, world.extent.z, ground.region.low[0], ground.region.low[1]) ||
      placed.region != ground.region || placed.corner[0] != ground.corner[0] ||
      placed.corner[1] != ground.corner[1])
    return {"the voxels are no region of the ground", kFirstNode};
  if (ground.rim_edges == 0 || ground.rim_edges > kMostRimEdges)
    return {"rim_edges are outside 1..16384", kRimEdges};
  return {};
}

Fault decode_region(std::span<const std::byte> section, const WorldInfo& world, GroundInfo& ground) {
  if (!section.empty()) {
    if (!world_layout::all_zero(section.subspan(kRegionReserved)))
      return {"a reserved field is not 0", kRegionReserved};
    if (!place_region(ground, world.extent.x, world.extent.z, load<std::int32_t>(section, kFirstNode),
                      load<std::int32_t>(section, kFirstNode + 4)))
      return {"the voxels are no region of the ground", kFirstNode};
    ground.rim_edges = load<std::uint32_t>(section, kRimEdges);
  }
  return check_region(world, ground);
}

void encode_region(const GroundInfo& ground, std::span<std::byte> out) {
  std::fill(out.begin(), out.end(), std::byte{0});
  for (std::size_t axis = 0; axis < 2; ++axis) store(out, kFirstNode + axis * 4, ground.region.low[axis]);
  store(out, kRimEdges, ground.rim_edges);
}

Fault check_imagery(const WorldGround& ground) {
  const ImageryInfo& imagery = ground.imagery;
  const TilePlace& root = ground.image_root;
  if (!imagery.exists() || static_cast<std::uint32_t>(imagery.format) >= kImageFormats)
    return {"the format is not known", kFormat};
  if (imagery.least_size < 0 || imagery.least_size > ground.info.top_size())
    return {"the least size is not one of the ground's", kLeastSize};
  if (root.bytes != image_tile_bytes(imagery.format) || root.offset > ground.tile_bytes ||
      root.bytes > ground.tile_bytes - root.offset)
    return {"the root's image tile does not lie in the tiles", kImageOffset};
  return {};
}

Fault decode_imagery(std::span<const std::byte, kImageryBytes> section, WorldGround& ground) {
  WorldGround read = ground;
  read.imagery.format = static_cast<ImageFormat>(load<std::uint32_t>(section, kFormat));
  read.imagery.least_size = load<std::int32_t>(section, kLeastSize);
  read.image_root.offset = load<std::uint64_t>(section, kImageOffset);
  read.image_root.bytes = load<std::uint32_t>(section, kImageBytes);
  read.image_root.crc = load<std::uint32_t>(section, kImageCrc);
  if (!world_layout::all_zero(section.subspan(kImageReserved)))
    return {"a reserved field is not 0", kImageReserved};
  const Fault fault = check_imagery(read);
  if (fault.what == nullptr) ground = read;
  return fault;
}

void encode_imagery(const WorldGround& ground, std::span<std::byte, kImageryBytes> out) {
  std::fill(out.begin(), out.end(), std::byte{0});
  store(out, kFormat, static_cast<std::uint32_t>(ground.imagery.format));
  store(out, kLeastSize, ground.imagery.least_size);
  store(out, kImageOffset, ground.image_root.offset);
  store(out, kImageBytes, ground.image_root.bytes);
  store(out, kImageCrc, ground.image_root.crc);
}

}  // namespace karst::core::ground_section
