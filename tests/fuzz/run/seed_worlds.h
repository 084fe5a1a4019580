// SPDX-License-Identifier: MIT
// Small worlds that mutations start from: one of the least sections, one of all that a world of patches can
// have, two with a ground and tiles that are none, the second one with imagery; then a ground with a region
// of patches, and one with two; then two with the field of an isosurface, one with materials.
#pragma once

#include "terrain/base/checksum.h"
#include "terrain/file/world_writer.h"
#include "terrain/isosurface/field_blocks.h"
#include "tests/support/world_bytes.h"

#include <algorithm>
#include <initializer_list>
#include <vector>

namespace karst {

// The bytes of a world with a ground, whose tiles these are.
inline std::vector<std::byte> around_tiles(const core::WorldWriter& writer,
                                           std::span<const std::byte> tiles) {
  std::vector<std::byte> file, tail;
  const auto to_file = [&](std::span<const std::byte> bytes) {
    file.insert(file.end(), bytes.begin(), bytes.end());
    return true;
  };
  const auto to_tail = [&](std::span<const std::byte> bytes) {
    tail.insert(tail.end(), bytes.begin(), bytes.end());
    return true;
  };
  if (!writer.run_around(core::ByteSink::to(to_file), core::ByteSink::to(to_tail)).ok()) return {};
  file.insert(file.end(), tiles.begin(), tiles.end());
  file.insert(file.end(), tail.begin(), tail.end());
  return file;
}

// Where the tiles would lie, a hundred bytes of them.
inline std::vector<std::byte> with_ground(core::WorldWriter writer, bool has_imagery = false) {
  core::GroundInfo& info = writer.ground.info;
  info.samples[0] = 150;
  info.samples[1] = 100;
  info.steps[0] = info.steps[1] = 2048;
  const std::size_t image = has_imagery ? core::image_tile_bytes(core::ImageFormat::etc2_rgb) : 0;
  const std::vector<std::byte> tiles(100 + image, std::byte{7});
  writer.ground.root = {40, 60, core::crc32c(std::span(tiles).subspan(40, 60))};
  if (has_imagery) {
    writer.ground.imagery = {core::ImageFormat::etc2_rgb, 1};
    writer.ground.image_root = {100, static_cast<std::uint32_t>(image),
                                core::crc32c(std::span(tiles).subspan(100))};
  }
  writer.ground.tile_bytes = tiles.size();
  writer.ground.tile_crc = core::crc32c(tiles);
  if (info.region_count > 0 && !core::place_regions(info)) return {};
  return around_tiles(writer, tiles);
}

// Each world a region of one ground.
inline std::vector<std::byte> with_regions(std::initializer_list<const core::TestWorld*> worlds) {
  core::WorldWriter writer;
  core::WorldInfo& info = writer.info = (*worlds.begin())->info;
  info.octets = info.volumes = info.patches = info.height_blocks = 0;
  info.regions = static_cast<std::uint32_t>(worlds.size());
  std::vector<const core::Octree*> octrees;
  core::TestWorld all(2, 1, 14);
  all.keys.clear();
  all.mask.clear();
  all.samples.clear();
  all.errors.clear();
  all.bounds.clear();
  all.cones.clear();
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  for (const core::TestWorld* const one : worlds) {
    const core::TestWorld& world = *one;
    const auto number = static_cast<std::uint32_t>(octrees.size());
    octrees.push_back(&world.memory.tree);
    for (const core::PatchKey key : world.keys) {
      const glm::uvec3 at(key.corner());
      all.keys.push_back(core::PatchKey::make(number, at.x, at.y, at.z, key.case_patch()));
    }
    all.mask.resize((all.keys.size() + 7) / 8);
    for (std::uint32_t p = 0; p < world.info.patches; ++p) {
      const std::uint32_t to = info.patches + p;
      if ((world.mask[p / 8] >> p % 8 & std::byte{1}) != std::byte{0})
        all.mask[to / 8] |= std::byte{1} << to % 8;
    }
    append(all.samples, world.samples);
    append(all.errors, world.errors);
    append(all.bounds, world.bounds);
    append(all.cones, world.cones);
    info.octets += world.info.octets;
    info.volumes += world.info.volumes;
    info.patches += world.info.patches;
    info.height_blocks += world.info.height_blocks;
    info.extent = glm::max(info.extent, world.info.extent);
    info.depth = std::max(info.depth, world.info.depth);
    core::GroundInfo& ground = writer.ground.info;
    core::GroundRegion& region = ground.region_list[static_cast<std::size_t>(ground.region_count++)];
    region.nodes.low[0] = 5 + 10 * static_cast<int>(number);
    region.nodes.low[1] = 6;
    region.extent = world.info.extent;
    region.depth = world.info.depth;
    region.octets = world.info.octets;
    region.volumes = world.info.volumes;
    region.patches = world.info.patches;
    region.rim_edges = 20 + number;
  }
  writer.patches = all.patches();
  writer.octree = octrees[0];
  writer.octrees = octrees;
  return with_ground(writer);
}

// A world of patches with the field of an isosurface: air, a block of samples, stone.
// has_materials: of which one block has several, one one, and one is by rules.
inline std::vector<std::byte> with_field(core::WorldWriter writer, bool has_materials = false) {
  std::vector<std::uint32_t> table(3), material_table(has_materials ? 3 : 0);
  std::vector<std::byte> samples(core::FieldBlocks::kBlockBytes);
  std::vector<std::uint8_t> materials(has_materials ? core::FieldBlocks::kBlockBytes : 0);
  core::FieldBlocks field;
  field.create({table, samples, material_table, materials});
  core::FieldInfo info;
  info.blocks = {3, 1, 1};
  info.stored = 1;
  if (!field.reset(info).ok()) return {};
  int n = 0;
  for (std::int8_t& sample : field.bytes().open({1, 0, 0}))
    sample = static_cast<std::int8_t>(n++ * 37 % 251 - 125);
  field.bytes().fill({2, 0, 0}, core::ScalarField<std::int8_t>::kSolid);
  if (has_materials) {
    for (std::uint8_t& code : field.materials().open({1, 0, 0})) code = static_cast<std::uint8_t>(n++ % 3);
    field.materials().fill({2, 0, 0}, core::code_of({1, 2, 3}));
  }
  writer.field = &field;
  std::vector<std::byte> file;
  const auto append = [&](std::span<const std::byte> bytes) {
    file.insert(file.end(), bytes.begin(), bytes.end());
    return true;
  };
  return writer.run(core::ByteSink::to(append)).ok() ? file : std::vector<std::byte>();
}

inline std::vector<std::vector<std::byte>> seed_worlds() {
  core::TestWorld full(2, 1, 12);
  full.add_materials(2, 16, core::TextureFormat::etc2, 1, 5);
  full.add_blend_map(5, 3, 6);
  const core::TestWorld plain(2, 1, 12);
  const core::WorldWriter ground{plain.info, &plain.memory.tree, plain.patches(), plain.materials()};
  const core::WorldWriter painted{full.info, &full.memory.tree, full.patches(), full.materials()};
  const core::TestWorld region(2, 1, 14), another(3, 1, 15);
  return {core::TestWorld(2, 1, 12).bytes(),
          full.bytes(),
          with_ground(ground),
          with_ground(ground, true),
          with_regions({&region}),
          with_regions({&region, &another}),
          with_field(ground),
          with_field(painted, true)};
}

}  // namespace karst
