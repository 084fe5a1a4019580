// SPDX-License-Identifier: MIT
// Small worlds that mutations start from: one of the least sections, one of all that a world of patches can
// have, and two with a ground and tiles that are none; the second one has imagery.
#pragma once

#include "terrain/base/checksum.h"
#include "terrain/file/world_writer.h"
#include "tests/support/world_bytes.h"

#include <vector>

namespace karst {

inline std::vector<std::byte> with_ground(const core::TestWorld& world, bool has_imagery = false) {
  core::WorldWriter writer{world.info, &world.memory.tree, world.patches(), world.materials()};
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

inline std::vector<std::vector<std::byte>> seed_worlds() {
  core::TestWorld full(2, 1, 12);
  full.add_materials(2, 16, core::TextureFormat::etc2, 1, 5);
  full.add_blend_map(5, 3, 6);
  return {core::TestWorld(2, 1, 12).bytes(), full.bytes(), with_ground(core::TestWorld(2, 1, 12)),
          with_ground(core::TestWorld(2, 1, 12), true)};
}

}  // namespace karst
