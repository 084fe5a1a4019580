// SPDX-License-Identifier: MIT
#include "tests/library/ground_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "terrain/base/checksum.h"
#include "terrain/file/world_writer.h"
#include "terrain/regions/region_rim.h"
#include "tests/support/tree_memory.h"
#include "tiles/encode_tile.h"

namespace karst::test {

using namespace core;

namespace {

// Image tiles by places of their texels, whatever their size, behind the tiles that there are. Returns the
// root's place.
TilePlace write_images(const MemoryGround& ground, const GroundImages& images, std::vector<std::byte>& all) {
  const std::function<TilePlace(NodeKey)> write = [&](NodeKey key) {
    ImageChildren children;
    for (int quadrant = 0; quadrant < 4 && key.size > images.least_size; ++quadrant) {
      const NodeKey child = key.child(quadrant);
      const double side = std::ldexp(double{kNodeQuads}, child.size);
      const bool is_there = !images.is_fine || child.size >= images.least_size + 2 ||
                            images.is_fine((child.x + 0.5) * side, (child.z + 0.5) * side);
      if (is_there && image_tile_exists(ground.info(), child)) children.places[quadrant] = write(child);
    }
    std::vector<std::byte> bytes(image_tile_bytes(ImageFormat::rgba8));
    std::memcpy(bytes.data(), children.places, sizeof children.places);
    std::size_t at = kImageHeadBytes;
    for (int level = 0; level < kImageLevels; ++level) {
      const double texel = std::ldexp(1.0, key.size + level) / kTexelsPerSample;
      const int inside = kImageInside >> level;
      const int border = kImageBorder >> level;
      for (int y = 0; y < kImageSide >> level; ++y) {
        for (int x = 0; x < kImageSide >> level; ++x, at += 4) {
          const auto colour = images.at((key.x * inside + x - border + 0.5) * texel,
                                        (key.z * inside + y - border + 0.5) * texel);
          std::memcpy(bytes.data() + at, colour.data(), 4);
        }
      }
    }
    const TilePlace place{all.size(), static_cast<std::uint32_t>(bytes.size()), crc32c(bytes)};
    all.insert(all.end(), bytes.begin(), bytes.end());
    return place;
  };
  return write({image_top_size(ground.info()), 0, 0});
}

// world: without ground; of its ground, whose region is placed, all but the tiles.
std::vector<std::byte> with_tiles(const MemoryGround& ground, WorldWriter writer,
                                  const GroundImages& images = {}) {
  tiles::TileEncoder encoder;
  std::vector<std::byte> all, bytes;
  // Children before their parents, which tell where they lie.
  const std::function<TilePlace(NodeKey)> write = [&](NodeKey key) {
    Tile tile = ground.tile(key);
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      if (tile.children[quadrant].exists()) tile.children[quadrant] = write(key.child(quadrant));
    }
    encoder.run(key, ground.info(), tile, 1, bytes);
    const TilePlace place{all.size(), static_cast<std::uint32_t>(bytes.size()), crc32c(bytes)};
    all.insert(all.end(), bytes.begin(), bytes.end());
    return place;
  };
  writer.ground.root = write(tile_of(ground.root()));
  if (images.at) {
    writer.ground.imagery = {ImageFormat::rgba8, images.least_size};
    writer.ground.image_root = write_images(ground, images, all);
  }
  writer.ground.tile_bytes = all.size();
  writer.ground.tile_crc = crc32c(all);
  std::vector<std::byte> out, tail;
  const auto into = [](std::vector<std::byte>& to) {
    return [&to](std::span<const std::byte> piece) {
      to.insert(to.end(), piece.begin(), piece.end());
      return true;
    };
  };
  const auto to_head = into(out), to_tail = into(tail);
  const Status status = writer.run_around(ByteSink::to(to_head), ByteSink::to(to_tail));
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  out.insert(out.end(), all.begin(), all.end());
  out.insert(out.end(), tail.begin(), tail.end());
  EXPECT_EQ(out.size(), writer.file_bytes());
  return out;
}

}  // namespace

std::vector<std::byte> ground_file(const MemoryGround& ground, double spacing_m, const GroundImages& images,
                                   const core::WorldMaterials& materials) {
  core::WorldInfo info;
  info.voxel_size_m = spacing_m / ground.info().steps[0] * kStepsPerVoxel;
  info.extent = {2, 1, 2};
  info.depth = 1;
  info.level = ground.info().can_be_dug ? 3 : 1;
  TreeMemory memory(1, 1);
  WorldWriter writer{info, &memory.tree, {}, materials};
  writer.ground.info = ground.info();
  return with_tiles(ground, writer, images);
}

std::vector<std::byte> ground_file(const MemoryGround& ground, const TestWorld& voxels,
                                   const GroundImages& images) {
  const TestWorld* const one = &voxels;
  return ground_file(ground, {&one, 1}, images);
}

std::vector<std::byte> ground_file(const MemoryGround& ground, std::span<const TestWorld* const> regions,
                                   const GroundImages& images, const core::WorldMaterials& materials) {
  core::WorldInfo info = regions[0]->info();
  info.extent = glm::ivec3(0);
  info.regions = static_cast<std::uint32_t>(regions.size());
  info.depth = 0;
  info.octets = info.volumes = info.patches = info.height_blocks = 0;
  GroundInfo placed = ground.info();
  std::vector<PatchKey> keys;
  std::vector<std::int16_t> samples;
  std::vector<std::uint16_t> errors;
  std::vector<PatchBounds> boxes;
  std::vector<NormalCone> cones, shading;
  std::vector<const Octree*> octrees;
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  for (const TestWorld* const voxels : regions) {
    const core::WorldInfo own = voxels->info();
    EXPECT_EQ(own.patches, own.height_blocks);
    GroundRegion& region = placed.region_list[octrees.size()];
    region.extent = own.extent;
    region.depth = own.depth;
    region.octets = own.octets;
    region.volumes = own.volumes;
    region.patches = own.patches;
    region.rim_edges = RegionRim::count(voxels->surface());
    for (const PatchKey key : voxels->keys())
      keys.push_back(PatchKey::make(static_cast<std::uint32_t>(octrees.size()),
                                    static_cast<std::uint32_t>(key.corner().x),
                                    static_cast<std::uint32_t>(key.corner().y),
                                    static_cast<std::uint32_t>(key.corner().z), key.case_patch()));
    append(samples, voxels->heights().samples);
    append(errors, voxels->level_errors());
    append(boxes, voxels->bounds());
    append(cones, voxels->cones());
    append(shading, voxels->shading_cones());
    octrees.push_back(&voxels->octree());
    info.extent = glm::max(info.extent, own.extent);
    info.depth = std::max(info.depth, own.depth);
    info.octets += own.octets;
    info.volumes += own.volumes;
    info.patches += own.patches;
    info.height_blocks += own.height_blocks;
  }
  std::vector<std::byte> mask((info.patches + 7) / 8, std::byte{0});
  for (std::uint32_t p = 0; p < info.patches; ++p) mask[p / 8] |= static_cast<std::byte>(1u << (p % 8));
  WorldWriter writer{info, octrees[0], {keys, mask, samples, errors, boxes, cones, shading}, materials};
  if (octrees.size() > 1) writer.octrees = octrees;
  writer.ground.info = placed;
  return with_tiles(ground, writer, images);
}

std::vector<std::byte> ground_file(const MemoryGround& ground, const TestWorld& voxels,
                                   const FieldBlocks& field, std::uint32_t rim_edges) {
  core::WorldInfo info = voxels.info();
  info.level = 1;
  info.volumes = info.patches = info.height_blocks = 0;
  WorldWriter writer;
  writer.info = info;
  writer.octree = &voxels.octree();
  writer.field = &field;
  writer.ground.info = ground.info();
  GroundRegion& region = writer.ground.info.region_list[0];
  region.extent = info.extent;
  region.depth = info.depth;
  region.octets = info.octets;
  region.rim_edges = rim_edges;
  return with_tiles(ground, writer);
}

MemoryGround::Heights rough_heights() {
  return [](std::int64_t i, std::int64_t k) {
    const double x = double(i), z = double(k);
    const double ridges = std::sin(0.05 * x + 0.4 * std::sin(0.021 * z)) * std::cos(0.043 * z + 0.01 * x);
    const auto grain = static_cast<double>((static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15u ^
                                            static_cast<std::uint64_t>(k) * 0xc2b2ae3d27d4eb4fu) >>
                                           54);
    // 1024 kVertexStep are a spacing.
    return static_cast<std::int32_t>((30 * (1 + ridges) + grain / 1024) * 1024 / kRoughSpacing_m);
  };
}

MemoryGround rough_ground() {
  return MemoryGround(600, 480, 2048, 2048, rough_heights());
}

}  // namespace karst::test
