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
constexpr std::size_t kCanBeDug = 56;
constexpr std::size_t kReserved = 60;
// Of the second part, from its start.
constexpr std::size_t kKind = 0;
constexpr std::size_t kFlags = 4;
constexpr std::size_t kFirst = 8;  // two
constexpr std::size_t kStep = 24;  // two
constexpr std::size_t kRadius = 40;
constexpr std::size_t kFlattening = 48;
constexpr std::size_t kAnchor = 56;  // two
constexpr std::size_t kBase = 72;
constexpr std::size_t kFaceQuads = 80;
constexpr std::size_t kProjection = 84;
constexpr std::size_t kEpsg = 88;
constexpr std::size_t kZero = 92;
constexpr std::size_t kOrigin = 96;  // two
constexpr std::size_t kPerM = 112;   // two
constexpr std::size_t kScale = 128;
constexpr std::size_t kLatitude = 136;
constexpr std::size_t kLongitude = 144;
constexpr std::size_t kFalseEast = 152;
constexpr std::size_t kFalseNorth = 160;
constexpr std::size_t kUnit = 168;
constexpr std::size_t kEarthReserved = 176;
constexpr std::uint32_t kCentred = 1;

Fault check_basis(const GroundInfo& info) {
  Basis basis = info.basis;
  if (!basis.finish().ok()) return {"the basis is none", kBytes + kKind};
  if (!info.is_cube()) return {};
  for (int axis = 0; axis < 2; ++axis) {
    if (info.samples[axis] != std::int64_t{kCubeCells[axis]} * basis.face_quads + 1)
      return {"samples are not those of a cube", kSamples};
  }
  return {};
}

Fault check_earth(const WorldGround& ground) {
  const Georeference& earth = ground.earth;
  if (earth.projection > MapProjection::other) return {"a projection of unknown kind", kBytes + kProjection};
  for (const double value : {earth.origin[0], earth.origin[1], earth.false_east_m, earth.false_north_m}) {
    if (!(std::abs(value) <= 1e12)) return {"coordinates are not within +-1e12", kBytes + kOrigin};
  }
  for (const double value : {earth.per_m[0], earth.per_m[1], earth.scale, earth.unit_m}) {
    if (!(value >= 1e-12 && value <= 1e12)) return {"a scale is not within 1e-12..1e12", kBytes + kPerM};
  }
  if (!(std::abs(earth.latitude_deg) <= 90 && std::abs(earth.longitude_deg) <= 540))
    return {"no longitude and latitude", kBytes + kLatitude};
  const Basis& basis = ground.info.basis;
  if (earth.exists() &&
      !(basis.radius_m >= 1 && basis.radius_m <= 1e9 && basis.flattening >= 0 && basis.flattening <= 0.1))
    return {"the ellipsoid is none", kBytes + kRadius};
  return {};
}

void load_earth(std::span<const std::byte> in, WorldGround& ground) {
  Basis& basis = ground.info.basis;
  Georeference& earth = ground.earth;
  basis.kind = static_cast<BasisKind>(std::min<std::uint32_t>(load<std::uint32_t>(in, kKind), 255));
  basis.centred = (load<std::uint32_t>(in, kFlags) & kCentred) != 0;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    basis.first[axis] = load<double>(in, kFirst + axis * 8);
    basis.step[axis] = load<double>(in, kStep + axis * 8);
    basis.anchor_deg[axis] = load<double>(in, kAnchor + axis * 8);
    earth.origin[axis] = load<double>(in, kOrigin + axis * 8);
    earth.per_m[axis] = load<double>(in, kPerM + axis * 8);
  }
  basis.radius_m = load<double>(in, kRadius);
  basis.flattening = load<double>(in, kFlattening);
  basis.base_m = load<double>(in, kBase);
  basis.face_quads = load<std::int32_t>(in, kFaceQuads);
  earth.projection =
      static_cast<MapProjection>(std::min<std::uint32_t>(load<std::uint32_t>(in, kProjection), 255));
  earth.epsg = load<std::uint32_t>(in, kEpsg);
  earth.scale = load<double>(in, kScale);
  earth.latitude_deg = load<double>(in, kLatitude);
  earth.longitude_deg = load<double>(in, kLongitude);
  earth.false_east_m = load<double>(in, kFalseEast);
  earth.false_north_m = load<double>(in, kFalseNorth);
  earth.unit_m = load<double>(in, kUnit);
  if (basis.kind != BasisKind::function) return;
  // In the file its limits alone.
  basis.function = {};
  basis.function.turn_rad = basis.anchor_deg[0];
  basis.function.sagitta_m = basis.anchor_deg[1];
  basis.anchor_deg[0] = basis.anchor_deg[1] = 0;
}

void store_earth(const WorldGround& ground, std::span<std::byte> out) {
  const Basis& basis = ground.info.basis;
  const Georeference& earth = ground.earth;
  store(out, kKind, static_cast<std::uint32_t>(basis.kind));
  store(out, kFlags, basis.centred ? kCentred : 0u);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    store(out, kFirst + axis * 8, basis.first[axis]);
    store(out, kStep + axis * 8, basis.step[axis]);
    const double limit = axis == 0 ? basis.function.turn_rad : basis.function.sagitta_m;
    store(out, kAnchor + axis * 8, basis.kind == BasisKind::function ? limit : basis.anchor_deg[axis]);
    store(out, kOrigin + axis * 8, earth.origin[axis]);
    store(out, kPerM + axis * 8, earth.per_m[axis]);
  }
  store(out, kRadius, basis.radius_m);
  store(out, kFlattening, basis.flattening);
  store(out, kBase, basis.base_m);
  store(out, kFaceQuads, basis.face_quads);
  store(out, kProjection, static_cast<std::uint32_t>(earth.projection));
  store(out, kEpsg, earth.epsg);
  store(out, kScale, earth.scale);
  store(out, kLatitude, earth.latitude_deg);
  store(out, kLongitude, earth.longitude_deg);
  store(out, kFalseEast, earth.false_east_m);
  store(out, kFalseNorth, earth.false_north_m);
  store(out, kUnit, earth.unit_m);
}
// In REGN.
constexpr std::size_t kFirstNode = 0;  // two
constexpr std::size_t kRimEdges = 8;
constexpr std::size_t kRegionReserved = 12;
// In REGN of several regions, each: its first node as above, and
constexpr std::size_t kEntryExtent = 8;  // three
constexpr std::size_t kEntryHeight = 20;
constexpr std::size_t kEntryDepth = 24;
constexpr std::size_t kEntryOctets = 28;
constexpr std::size_t kEntryVolumes = 32;
constexpr std::size_t kEntryPatches = 36;
constexpr std::size_t kEntryRimEdges = 40;
constexpr std::size_t kEntryReserved = 44;

// What the header states of the only one.
void tell_only_region(const WorldInfo& world, GroundRegion& region) {
  region.extent = world.extent;
  region.depth = world.depth;
  region.octets = world.octets;
  region.volumes = world.volumes;
  region.patches = world.patches;
}

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
  if (const Fault fault = check_basis(info); fault.what != nullptr) return fault;
  return check_earth(ground);
}

Fault decode(std::span<const std::byte> section, std::uint64_t tile_bytes, double voxel_m,
             WorldGround& ground) {
  KARST_ASSERT(section.size() == kBytes || section.size() == kMostBytes);
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
  const auto can_be_dug = load<std::uint32_t>(section, kCanBeDug);
  if (can_be_dug > 1) return {"is neither 0 nor 1", kCanBeDug};
  read.info.can_be_dug = can_be_dug == 1;
  if (!world_layout::all_zero(section.subspan(kReserved, kBytes - kReserved)))
    return {"a reserved field is not 0", kReserved};
  read.info.basis.height_unit_m = voxel_m / kStepsPerVoxel * kVertexStep;
  if (section.size() > kBytes) {
    const auto second = section.subspan(kBytes);
    if ((load<std::uint32_t>(second, kFlags) & ~kCentred) != 0) return {"a flag is unknown", kBytes + kFlags};
    if (load<std::uint32_t>(second, kZero) != 0 || !world_layout::all_zero(second.subspan(kEarthReserved)))
      return {"a reserved field is not 0", kBytes + kZero};
    load_earth(second, read);
    if (read.info.basis.kind > BasisKind::function) return {"a basis of unknown kind", kBytes + kKind};
    if (!has_earth(read)) return {"a basis and a georeference are missing", kBytes + kKind};
  }
  if (const Fault fault = check(read); fault.what != nullptr) return fault;
  const Status status = read.info.basis.finish();
  KARST_ASSERT(status.ok());
  ground = read;
  return {};
}

void encode(const WorldGround& ground, std::span<std::byte> out) {
  KARST_ASSERT(out.size() == section_bytes(ground));
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
  store(out, kCanBeDug, std::uint32_t{ground.info.can_be_dug ? 1u : 0u});
  if (has_earth(ground)) store_earth(ground, out.subspan(kBytes));
}

namespace {

bool only_region_is_told(const GroundInfo& ground) {
  return ground.region_count == 1 && !ground.can_be_dug;
}

// Of each, against its octree's limits; and that they add up to what the header states.
Fault check_counts(const WorldInfo& world, const GroundInfo& ground) {
  std::uint64_t octets = 0, volumes = 0, patches = 0, rim_edges = 0;
  glm::ivec3 extent(0);
  std::int32_t depth = 0;
  for (std::size_t n = 0; n < ground.regions().size(); ++n) {
    const GroundRegion& region = ground.regions()[n];
    const std::size_t at = n * kRegionEntry;
    WorldInfo own;
    own.extent = region.extent;
    own.depth = region.depth;
    own.level = world.level;
    own.octets = region.octets;
    own.volumes = region.volumes;
    own.patches = region.patches;
    if (const Status status = validate_world_info(own); !status.ok()) return {status.what(), at};
    if (region.rim_edges == 0 || region.rim_edges > kMostRimEdges)
      return {"rim_edges are outside 1..262144",
              at + (only_region_is_told(ground) ? kRimEdges : kEntryRimEdges)};
    octets += region.octets;
    volumes += region.volumes;
    patches += region.patches;
    rim_edges += region.rim_edges;
    extent = glm::max(extent, region.extent);
    depth = std::max(depth, region.depth);
  }
  if (octets != world.octets || volumes != world.volumes || patches != world.patches ||
      extent != world.extent || depth != world.depth)
    return {"the regions are not those of the header", kFirstNode};
  if (rim_edges > kMostRimEdges) return {"rim_edges are outside 1..262144", kRimEdges};
  return {};
}

}  // namespace

Fault check_regions(const WorldInfo& world, const GroundInfo& ground) {
  if (ground.region_count == 0) {
    if (world.patches > 0) return {"there are patches, but no region for them", kFirstNode};
    if (ground.can_be_dug) {
      GroundInfo placed = ground;
      if (ground.basis.is_curved() || !place_regions(placed) || placed.corner[0] != ground.corner[0] ||
          placed.corner[1] != ground.corner[1])
        return {"its lattice is not one of voxels", kCanBeDug};
      return {};
    }
    const bool is_curved = ground.basis.is_curved();
    const bool finer =
        std::max(ground.steps[0], ground.steps[1]) > (is_curved ? kMostCurvedSteps : kMostSampleSteps);
    if (!finer) return {};
    return {is_curved ? "steps are above 8192" : "steps are above 2048 without a region", kSteps};
  }
  GroundInfo placed = ground;
  if (only_region_is_told(ground)) tell_only_region(world, placed.region_list[0]);
  bool same = ground.region_count == static_cast<std::int32_t>(world.regions) && place_regions(placed) &&
              placed.corner[0] == ground.corner[0] && placed.corner[1] == ground.corner[1];
  std::int32_t lowest = kMostRegionHeight;
  for (std::size_t n = 0; same && n < ground.regions().size(); ++n) {
    same = placed.regions()[n].nodes == ground.regions()[n].nodes &&
           placed.regions()[n].corner == ground.regions()[n].corner;
    lowest = std::min(lowest, ground.regions()[n].corner.y);
  }
  if (!same || (lowest != 0 && !ground.can_be_dug))
    return {"the voxels are no region of the ground", kFirstNode};
  return check_counts(world, placed);
}

Fault decode_regions(std::span<const std::byte> section, const WorldInfo& world, GroundInfo& ground) {
  if (section.empty()) {
    GroundInfo read = ground;
    if (read.can_be_dug && !place_regions(read)) return {"its lattice is not one of voxels", kCanBeDug};
    const Fault fault = check_regions(world, read);
    if (fault.what == nullptr) ground = read;
    return fault;
  }
  GroundInfo read = ground;
  read.region_count = static_cast<std::int32_t>(world.regions);
  if (only_region_is_told(read)) {
    if (!world_layout::all_zero(section.subspan(kRegionReserved)))
      return {"a reserved field is not 0", kRegionReserved};
    GroundRegion& region = read.region_list[0] = {};
    for (std::size_t axis = 0; axis < 2; ++axis)
      region.nodes.low[axis] = load<std::int32_t>(section, kFirstNode + axis * 4);
    region.rim_edges = load<std::uint32_t>(section, kRimEdges);
    tell_only_region(world, region);
  }
  for (std::size_t n = 0; !only_region_is_told(read) && n < world.regions; ++n) {
    const auto entry = section.subspan(n * kRegionEntry, kRegionEntry);
    if (!world_layout::all_zero(entry.subspan(kEntryReserved)))
      return {"a reserved field is not 0", n * kRegionEntry + kEntryReserved};
    GroundRegion& region = read.region_list[n] = {};
    for (std::size_t axis = 0; axis < 2; ++axis)
      region.nodes.low[axis] = load<std::int32_t>(entry, kFirstNode + axis * 4);
    for (std::size_t axis = 0; axis < 3; ++axis)
      region.extent[static_cast<int>(axis)] = load<std::int32_t>(entry, kEntryExtent + axis * 4);
    region.corner.y = load<std::int32_t>(entry, kEntryHeight);
    region.depth = load<std::int32_t>(entry, kEntryDepth);
    region.octets = load<std::uint32_t>(entry, kEntryOctets);
    region.volumes = load<std::uint32_t>(entry, kEntryVolumes);
    region.patches = load<std::uint32_t>(entry, kEntryPatches);
    region.rim_edges = load<std::uint32_t>(entry, kEntryRimEdges);
    // Before anything is added up.
    if (region.extent.x < 2 || region.extent.z < 2 || region.extent.y < 1)
      return {"extent does not fit the octree", n * kRegionEntry + kEntryExtent};
  }
  if (!place_regions(read)) return {"the voxels are no region of the ground", kFirstNode};
  const Fault fault = check_regions(world, read);
  if (fault.what == nullptr) ground = read;
  return fault;
}

void encode_regions(const GroundInfo& ground, std::span<std::byte> out) {
  std::fill(out.begin(), out.end(), std::byte{0});
  if (only_region_is_told(ground)) {
    const GroundRegion& region = ground.regions()[0];
    for (std::size_t axis = 0; axis < 2; ++axis) store(out, kFirstNode + axis * 4, region.nodes.low[axis]);
    store(out, kRimEdges, region.rim_edges);
    return;
  }
  for (std::size_t n = 0; n < ground.regions().size(); ++n) {
    const GroundRegion& region = ground.regions()[n];
    const auto entry = out.subspan(n * kRegionEntry, kRegionEntry);
    for (std::size_t axis = 0; axis < 2; ++axis) store(entry, kFirstNode + axis * 4, region.nodes.low[axis]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      store(entry, kEntryExtent + axis * 4, region.extent[static_cast<int>(axis)]);
    store(entry, kEntryHeight, region.corner.y);
    store(entry, kEntryDepth, region.depth);
    store(entry, kEntryOctets, region.octets);
    store(entry, kEntryVolumes, region.volumes);
    store(entry, kEntryPatches, region.patches);
    store(entry, kEntryRimEdges, region.rim_edges);
  }
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
