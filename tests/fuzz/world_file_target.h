// SPDX-License-Identifier: MIT
// Reads any bytes as a world file, all the way down, and traps where an accepted file breaks a promise of
// terrain/file/world_reader.h. Used by world_file_test.cpp and by libFuzzer (targets/world.cpp,
// sections.cpp).
#pragma once

#include "terrain/base/arena.h"
#include "terrain/isosurface/field_blocks.h"
#include "terrain/measure/level_error.h"
#include "terrain/patch/heights.h"
#include "tests/fuzz/run/seed_worlds.h"
#include "tests/support/world_io.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace karst::core {

enum class Reached { rejected, header, octree };

inline void promise(bool kept) {
  if (!kept) __builtin_trap();
}

// A failure says what failed, and where inside the file (or, for a file cut short, at its end).
inline void promise_stated(const Status& status, std::size_t file_bytes) {
  promise(std::strlen(status.what()) > 0 && std::strlen(status.field()) > 0);
  promise(status.code() != StatusCode::io);  // bytes in memory can be read
  const bool at_offset = status.code() == StatusCode::corrupt || status.code() == StatusCode::unsupported;
  promise(!at_offset || status.value() <= file_bytes);
}

// Every level of both arrays, layer by layer, is what the texture data holds there.
inline void fuzz_textures(std::span<const std::byte> file, const WorldReader& reader, bool accepted) {
  const MaterialSet& set = reader.materials();
  const WorldMaterials whole = accepted ? read_materials(file) : WorldMaterials();
  if (accepted) {
    promise(whole.set.count == set.count && whole.textures.size() == texture_bytes(set));
    promise(whole.lights.size() == reader.lights().size());
  }
  std::vector<std::byte> image;
  for (const TextureArray array : {TextureArray::far, TextureArray::near}) {
    for (int level = 0; level < texture_levels(set.side, array); ++level) {
      for (std::uint32_t layer = 0; layer < set.count; ++layer) {
        image.resize(texture_image_bytes(set.format, set.side, array, level));
        const Status status = reader.read_textures(array, level, layer, 1, image);
        if (!status.ok()) promise_stated(status, file.size());
        if (!accepted) continue;
        promise(status.ok());
        const auto there = whole.textures.subspan(texture_offset(set, array, level, layer), image.size());
        promise(std::equal(image.begin(), image.end(), there.begin()));
      }
    }
  }
}

// Piece by piece, every piece of a file that the whole check accepts reads the same; others fail in words.
inline void fuzz_world_reader(std::span<const std::byte> file, const WorldPatches* whole) {
  WorldReader reader;
  Status status = reader.open(ByteSource::of(file));
  promise(whole == nullptr || status.ok());
  if (!status.ok()) return promise_stated(status, file.size());
  const WorldInfo& info = reader.info();
  const auto check = [&](const Status& s) {
    promise(whole == nullptr || s.ok());
    if (!s.ok()) promise_stated(s, file.size());
    return s.ok();
  };
  std::vector<PatchKey> keys(info.patches);
  check(reader.read_keys(keys));
  std::vector<std::byte> mask((info.patches + 7) / 8);
  check(reader.read_mask(mask));
  std::vector<std::uint16_t> errors(info.patches * level_error_values(info.level));
  check(reader.read_level_errors(errors));
  std::vector<PatchBounds> bounds(info.patches);
  check(reader.read_bounds(bounds));
  std::vector<std::uint32_t> crcs(height_groups(info.height_blocks));
  if (!check(reader.read_height_crcs(crcs))) return;
  std::vector<std::int16_t> samples(info.height_blocks *
                                    static_cast<std::size_t>(patch_vertices(info.level)));
  const std::size_t group = std::size_t{kHeightGroup} * static_cast<std::size_t>(patch_vertices(info.level));
  for (std::uint32_t g = 0; g < crcs.size(); ++g) {
    const std::span<std::int16_t> rest = std::span(samples).subspan(g * group);
    check(reader.read_heights(g, crcs[g], rest.first(std::min(rest.size(), group))));
  }
  std::vector<std::uint8_t> overrides(info.patches);
  check(reader.read_overrides(overrides));
  fuzz_textures(file, reader, whole != nullptr);
  if (whole == nullptr) return;
  promise(std::equal(keys.begin(), keys.end(), whole->keys.begin(), whole->keys.end()));
  promise(std::equal(mask.begin(), mask.end(), whole->mask.begin(), whole->mask.end()));
  promise(std::equal(errors.begin(), errors.end(), whole->level_errors.begin(), whole->level_errors.end()));
  promise(std::equal(samples.begin(), samples.end(), whole->samples.begin(), whole->samples.end()));
}

// The field of a file that the whole check accepts, in memory of its own.
struct FuzzedField {
  std::vector<std::uint32_t> table;
  std::vector<std::byte> samples;
  std::vector<std::uint32_t> material_table;
  std::vector<std::uint8_t> materials;
  FieldBlocks blocks;

  void read(const WorldReader& reader) {
    const FieldInfo& info = reader.field();
    if (!info.exists()) return;
    table.resize(info.table_blocks());
    samples.resize(FieldBlocks::kBlockBytes * info.stored * static_cast<std::size_t>(info.sample_bits / 8));
    if (info.has_materials) material_table.resize(info.table_blocks());
    materials.resize(FieldBlocks::kBlockBytes * std::size_t{info.material_blocks});
    blocks.create({table, samples, material_table, materials});
    promise(reader.read_field(blocks).ok() && blocks.info() == info);
    promise(blocks.with([](const auto& f) { return f.free_blocks(); }) == 0);
    promise(blocks.materials().exists() == info.has_materials && blocks.materials().free_blocks() == 0);
  }
};

inline Reached fuzz_world_file(std::span<const std::byte> input) {
  constexpr std::uint32_t kPool =
      2048;  // octets; larger trees are refused, as on a board with a small budget
  alignas(Arena::kAlignment) static std::byte memory[kMostRegions][kPool * sizeof(Octree::Octet)];
  const std::vector<std::byte> file(input.begin(),
                                    input.end());  // exactly as long, so that overreads are seen
  WorldInfo info;
  Status status = read_world_info(file, info);
  if (!status.ok()) {
    promise_stated(status, file.size());
    fuzz_world_reader(file, nullptr);
    return Reached::rejected;
  }
  promise(validate_world_info(info).ok());

  const WorldPatches heights = read_patches(file);
  fuzz_world_reader(file, &heights);
  std::uint64_t set = 0;
  for (std::uint32_t p = 0; p < info.patches; ++p) {
    set += std::to_integer<unsigned>(heights.mask[p / 8]) >> p % 8 & 1u;
  }
  promise(set == info.height_blocks);
  promise(heights.samples.size() == set * static_cast<std::uint64_t>(patch_vertices(info.level)));
  for (const std::int16_t s : heights.samples) promise(s >= -kMaxHeight && s <= kMaxHeight);
  promise(heights.level_errors.size() == info.patches * level_error_values(info.level));
  promise(heights.keys.size() == info.patches && std::is_sorted(heights.keys.begin(), heights.keys.end()));
  promise(find_level_error_fault(info.level, heights.level_errors) == heights.level_errors.size());

  WorldReader reader;
  promise(reader.open(ByteSource::of(file)).ok());
  std::vector<Octree> trees(info.regions);
  for (std::size_t n = 0; n < trees.size(); ++n) {
    Arena arena{std::span<std::byte>(memory[n])};
    promise(trees[n].create(arena, 1, kPool).ok());
  }
  std::vector<std::byte> room(WorldReader::octree_room(info.octets, info.regions));
  status = reader.read_octrees(room, trees);
  std::uint32_t octets = 0;
  for (const Octree& tree : trees) octets += tree.octets_used();
  promise(octets == (status.ok() ? info.octets : 0));
  if (!status.ok()) {
    promise_stated(status, file.size());
    for (const Octree& tree : trees) promise(tree.root() == Octree::kEmpty);
    return Reached::header;
  }
  const std::span<const GroundRegion> regions = reader.ground().regions();
  promise(regions.size() == (reader.ground().exists() && info.patches > 0 ? info.regions : 0));
  std::vector<const Octree*> octrees;
  for (std::size_t n = 0; n < trees.size(); ++n) {
    const glm::ivec3 extent = info.regions > 1 ? regions[n].extent : info.extent;
    promise(trees[n].depth() == (info.regions > 1 ? regions[n].depth : info.depth));
    promise(trees[n].count_filled() <= static_cast<std::uint64_t>(extent.x) *
                                           static_cast<std::uint64_t>(extent.y) *
                                           static_cast<std::uint64_t>(extent.z));
    octrees.push_back(&trees[n]);
  }

  // What was accepted can be written, and read again.
  const WorldMaterials materials = read_materials(file);
  for (const std::uint8_t material : materials.overrides) {
    promise(material <= materials.set.count || material == kPaintedByMap);
  }
  WorldWriter writer{info, octrees[0], heights, materials};
  if (!regions.empty()) writer.octrees = octrees;
  FuzzedField field;
  field.read(reader);
  writer.field = &field.blocks;
  std::vector<std::byte> copy;
  if (reader.ground().exists()) {
    const std::span<const std::byte> tiles = section_of(file, "TILE");
    writer.ground = {reader.ground(), reader.earth(),   reader.root_tile(), tiles.size(),
                     crc32c(tiles),   reader.imagery(), reader.root_image()};
    copy = around_tiles(writer, tiles);
    promise(!copy.empty());
  } else {
    promise(write_world(writer, copy).ok() && writer.file_bytes() == copy.size());
  }
  const auto before = section_of(file, "FELD"), after = section_of(copy, "FELD");
  promise(std::equal(before.begin(), before.end(), after.begin(), after.end()));
  WorldInfo again;
  promise(read_world_info(copy, again).ok());
  promise(again.octets == info.octets && again.patches == info.patches && again.extent == info.extent);
  return Reached::octree;
}

}  // namespace karst::core
