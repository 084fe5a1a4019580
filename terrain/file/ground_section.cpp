// SPDX-License-Identifier: MIT
#include "terrain/file/ground_section.h"

#include <algorithm>

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
    if (!(info.steps[axis] >= kLeastSampleSteps && info.steps[axis] <= kMostSampleSteps))
      return {"steps are outside 2..2048", kSteps + axis * 8};
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
