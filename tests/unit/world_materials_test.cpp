// SPDX-License-Identifier: MIT
// Materials, their textures, overrides and lights in the world file, whole and piece by piece.
#include "terrain/shading/materials.h"

#include "terrain/file/world_reader.h"
#include "tests/support/loaded_parts.h"
#include "tests/support/test_world.h"
#include "tests/support/world_bytes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

namespace karst::core {
namespace {

using namespace world_offsets;

constexpr std::size_t kRecord = 16;  // of the first material, in MATL

TestWorld with_materials(std::uint32_t count, std::uint32_t side, TextureFormat format) {
  TestWorld world(4, 2, 6);
  world.add_materials(count, side, format, 3, 77);
  return world;
}

std::size_t start_of(std::span<const std::byte> file, const char* section) {
  return load_at<std::uint64_t>(file, entry_of(file, section) + kEntryOffset);
}

bool same_bytes(const auto& a, const auto& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
}

TEST(Materials, TextureLayoutIsTheDocumentedOne) {
  MaterialSet set;
  set.count = 3;
  set.side = 16;
  constexpr TextureArray kFar = TextureArray::far, kNear = TextureArray::near;
  EXPECT_EQ(texture_levels(16, kNear), 5);
  EXPECT_EQ(texture_levels(16, kFar), 4);
  EXPECT_EQ(texture_levels(1024, kNear), 11);
  EXPECT_EQ(texture_image_bytes(TextureFormat::rgba8, 16, kNear, 0), 1024u);
  EXPECT_EQ(texture_image_bytes(TextureFormat::rgba8, 16, kNear, 4), 4u);
  EXPECT_EQ(texture_image_bytes(TextureFormat::rgba8, 16, kFar, 0), 256u);
  EXPECT_EQ(texture_offset(set, kFar, 0, 2), 512u);
  EXPECT_EQ(texture_offset(set, kFar, 1, 0), 768u);
  EXPECT_EQ(texture_offset(set, kNear, 0, 0), 3u * 340);
  EXPECT_EQ(texture_offset(set, kNear, 2, 1), 3u * (340 + 1280) + 64);
  EXPECT_EQ(texture_bytes(set), 3u * (340 + 1364));
  set.format = TextureFormat::etc2;
  EXPECT_EQ(texture_format(set.format, kFar), TextureFormat::etc2);
  EXPECT_EQ(texture_format(set.format, kNear), TextureFormat::rgba4);
  EXPECT_EQ(texture_image_bytes(set.format, 16, kFar, 0), 64u);
  EXPECT_EQ(texture_image_bytes(set.format, 16, kFar, 3), 16u);
  EXPECT_EQ(texture_image_bytes(set.format, 16, kNear, 0), 512u);
  EXPECT_EQ(texture_image_bytes(set.format, 16, kNear, 4), 2u);
  EXPECT_EQ(texture_bytes(set), 3u * (64 + 3 * 16 + 682));
  EXPECT_EQ(texture_bytes(MaterialSet()), 0u);
}

TEST(Materials, WhatIsWrittenIsReadAgain) {
  for (const TextureFormat format : {TextureFormat::rgba8, TextureFormat::etc2}) {
    for (const std::uint32_t count : {1u, 5u, 8u}) {
      const TestWorld world = with_materials(count, count == 5 ? 64 : 16, format);
      const std::vector<std::byte> file = world.bytes();
      WorldInfo info;
      const Status status = read_world_info(file, info);
      ASSERT_TRUE(status.ok()) << status.what() << " " << status.field() << " " << status.value();
      const WorldMaterials read = read_materials(file);
      EXPECT_EQ(read.set.count, count);
      EXPECT_EQ(read.set.side, world.set.side);
      EXPECT_EQ(read.set.format, format);
      EXPECT_EQ(std::memcmp(read.set.materials, world.set.materials, count * sizeof(Material)), 0);
      EXPECT_TRUE(same_bytes(read.textures, world.textures));
      EXPECT_TRUE(same_bytes(read.overrides, world.overrides));
      EXPECT_TRUE(same_bytes(read.lights, world.lights));
      std::vector<std::byte> again;
      ASSERT_TRUE(write_world({info, &world.memory.tree, read_patches(file), read}, again).ok());
      EXPECT_EQ(again, file);
    }
  }
}

TEST(Materials, SectionsAreTheDocumentedOnes) {
  const TestWorld world = with_materials(2, 32, TextureFormat::rgba8);
  const std::vector<std::byte> file = world.bytes();
  ASSERT_EQ(load_at<std::uint32_t>(file, kSections), 13u);
  const char* const kinds[] = {"MATL", "MTEX", "MOVR", "LGTS"};
  const std::size_t bytes[] = {16 + 2 * 84 + 4 * (5 + 6) * 2, world.textures.size(), world.info.patches,
                               3 * 32};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t entry = kTable + (9 + i) * kEntry;
    EXPECT_EQ(std::memcmp(file.data() + entry, kinds[i], 4), 0);
    EXPECT_EQ(load_at<std::uint32_t>(file, entry + kEntryFlags), 0u);
    EXPECT_EQ(load_at<std::uint64_t>(file, entry + kEntryBytes), bytes[i]);
  }
  const std::size_t start = start_of(file, "MATL");
  EXPECT_EQ(load_at<std::uint32_t>(file, start), 2u);
  EXPECT_EQ(load_at<std::uint32_t>(file, start + 4), 32u);
  EXPECT_EQ(load_at<std::uint32_t>(file, start + 8), 0u);
  EXPECT_STREQ(reinterpret_cast<const char*>(file.data() + start + kRecord + 84), "mat 1");
  EXPECT_EQ(load_at<float>(file, start + kRecord + 16), world.set.materials[0].slope_low);
  EXPECT_EQ(load_at<float>(file, start + kRecord + 40), world.set.materials[0].cave);
  EXPECT_EQ(load_at<float>(file, start + kRecord + 48), world.set.materials[0].average[0]);
  EXPECT_EQ(load_at<float>(file, start + kRecord + 64), world.set.materials[0].tint[0]);
  EXPECT_EQ(load_at<float>(file, start + kRecord + 76), world.set.materials[0].brightness_span);
  EXPECT_EQ(load_at<float>(file, start + kRecord + 80), world.set.materials[0].slope_span);
  EXPECT_EQ(load_at<std::int32_t>(file, start + 12), -3);
  const std::size_t crcs = start + 16 + 2 * 84;
  EXPECT_EQ(load_at<std::uint32_t>(file, crcs + 4),
            crc32c(std::span(world.textures).subspan(16 * 16 * 4, 16 * 16 * 4)));
  EXPECT_EQ(load_at<std::uint32_t>(file, crcs + 4 * 11),
            crc32c(std::span(world.textures).subspan(2 * 1364 + 32 * 32 * 4, 32 * 32 * 4)));
}

TEST(Materials, EverySectionMayBeMissing) {
  const TestWorld full = with_materials(2, 16, TextureFormat::rgba8);
  const WorldMaterials none;
  WorldMaterials some = full.materials();
  some.overrides = {};
  WorldMaterials lights;
  lights.lights = full.lights;
  for (const WorldMaterials& materials : {none, some, lights}) {
    const WorldWriter writer{full.info, &full.memory.tree, full.patches(), materials};
    std::vector<std::byte> file;
    ASSERT_TRUE(write_world(writer, file).ok());
    EXPECT_EQ(writer.file_bytes(), file.size());
    WorldInfo info;
    ASSERT_TRUE(read_world_info(file, info).ok());
    const WorldMaterials read = read_materials(file);
    EXPECT_EQ(read.set.count, materials.set.count);
    EXPECT_EQ(read.lights.size(), materials.lights.size());
    EXPECT_TRUE(read.overrides.empty());
    WorldReader reader;
    ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
    EXPECT_FALSE(reader.has_overrides());
    std::vector<std::uint8_t> overrides(info.patches, 9);
    ASSERT_TRUE(reader.read_overrides(overrides).ok());
    for (const std::uint8_t material : overrides) EXPECT_EQ(material, 0);
  }
}

TEST(Materials, LayersAreReadOneByOneOrTogether) {
  const TestWorld world = with_materials(4, 32, TextureFormat::etc2);
  const std::vector<std::byte> file = world.bytes();
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  EXPECT_EQ(reader.materials().count, 4u);
  EXPECT_EQ(reader.lights().size(), 3u);
  for (const TextureArray array : {TextureArray::far, TextureArray::near}) {
    for (int level = 0; level < texture_levels(32, array); ++level) {
      const std::size_t image = texture_image_bytes(TextureFormat::etc2, 32, array, level);
      for (std::uint32_t first = 0; first < 4; ++first) {
        std::vector<std::byte> out((4 - first) * image);
        ASSERT_TRUE(reader.read_textures(array, level, first, 4 - first, out).ok());
        EXPECT_TRUE(same_bytes(
            out,
            std::span(world.textures).subspan(texture_offset(world.set, array, level, first), out.size())));
      }
    }
  }
  std::vector<std::byte> small(7);
  EXPECT_EQ(reader.read_textures(TextureArray::far, 0, 0, 1, small).code(), StatusCode::invalid_argument);
}

TEST(Materials, ADamagedLayerFailsAlone) {
  const TestWorld world = with_materials(3, 16, TextureFormat::rgba8);
  std::vector<std::byte> file = world.bytes();
  const std::size_t at = start_of(file, "MTEX") + texture_offset(world.set, TextureArray::near, 1, 2);
  file[at + 5] ^= std::byte{1};
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  std::vector<std::byte> out(2 * texture_image_bytes(TextureFormat::rgba8, 16, TextureArray::near, 1));
  EXPECT_TRUE(reader.read_textures(TextureArray::near, 1, 0, 2, out).ok());
  const Status status = reader.read_textures(TextureArray::near, 1, 1, 2, out);
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "textures");
  EXPECT_EQ(status.value(), at);
  WorldInfo info;
  EXPECT_STREQ(read_world_info(file, info).field(), "section crc");
  // With a checksum of the section that fits, the image's own finds it.
  store_at(file, entry_of(file, "MTEX") + kEntryCrc,
           crc32c(std::span(file).subspan(start_of(file, "MTEX"), world.textures.size())));
  const std::size_t header = kTable + 13 * kEntry;
  store_at(file, kHeaderCrc,
           crc32c(std::span(file).subspan(kHeaderCrc + 4, header - kHeaderCrc - 4),
                  crc32c(std::span(file).first(kHeaderCrc))));
  EXPECT_STREQ(read_world_info(file, info).field(), "textures");
  EXPECT_EQ(read_world_info(file, info).value(), at);
}

// One field broken at a time: both readers and the writer refuse it, and say where.
TEST(Materials, EveryFieldOutOfRangeIsNamed) {
  const TestWorld world = with_materials(2, 16, TextureFormat::rgba8);
  const std::vector<std::byte> file = world.bytes();
  const auto expect = [&](const char* section, std::size_t offset, auto value, const char* field,
                          const char* what) {
    std::vector<std::byte> damaged = file;
    const std::size_t at = start_of(file, section) + offset;
    store_at(damaged, at, value);
    fix_checksums(damaged);
    WorldInfo info;
    const Status whole = read_world_info(damaged, info);
    WorldReader reader;
    Status piece = reader.open(ByteSource::of(damaged));
    std::vector<std::uint8_t> overrides(world.info.patches);
    if (piece.ok()) piece = reader.read_overrides(overrides);
    for (const Status& status : {whole, piece}) {
      EXPECT_EQ(status.code(), StatusCode::corrupt) << what;
      EXPECT_STREQ(status.field(), field);
      EXPECT_NE(std::string(status.what()).find(what), std::string::npos) << status.what();
      EXPECT_GE(status.value(), start_of(file, section));
      EXPECT_LE(status.value(), at);
    }
  };
  for (const std::uint32_t bad : {0u, 9u, 0xffffffffu}) expect("MATL", 0, bad, "materials", "count");
  for (const std::uint32_t bad : {0u, 8u, 48u, 2048u, 0x80000000u})
    expect("MATL", 4, bad, "materials", "side");
  expect("MATL", 8, 2u, "materials", "format");
  for (const std::int32_t bad : {-17, 6, 1 << 30}) expect("MATL", 12, bad, "materials", "repeat_log2");
  expect("MATL", 4, 32u, "materials", "length");
  expect("MATL", 0, 1u, "materials", "length");
  expect("MATL", kRecord, char{0}, "materials", "name");
  expect("MATL", kRecord + 1, '\n', "materials", "name");
  expect("MATL", kRecord + 15, 'x', "materials", "name");
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const char* const fields[] = {"slope_low",   "slope_high",  "slope_soft", "height_low",
                                "height_high", "height_soft", "cave",       "fray"};
  for (std::size_t k = 0; k < 8; ++k) {
    for (const float bad : {kNan, kInfinity, -kInfinity, 2e6f, -2e6f})
      expect("MATL", kRecord + 16 + 4 * k, bad, "materials", fields[k]);
  }
  for (const std::size_t soft : {2u, 5u}) {
    for (const float bad : {0.0f, -1.0f}) expect("MATL", kRecord + 16 + 4 * soft, bad, "materials", "soft");
  }
  expect("MATL", kRecord + 16, 3.5f, "materials", "slope_low is above");
  expect("MATL", kRecord + 84 + 28, 9e5f, "materials", "");
  for (std::size_t c = 0; c < 3; ++c) {
    for (const float bad : {0.0f, -0.5f, 1.5f, kNan})
      expect("MATL", kRecord + 48 + 4 * c, bad, "materials", "average");
  }
  expect("MATL", kRecord + 60, 2.0f, "materials", "roughness");
  for (const float bad : {-0.1f, 65.0f, kNan}) {
    for (std::size_t c = 0; c < 3; ++c) expect("MATL", kRecord + 64 + 4 * c, bad, "materials", "tint");
    expect("MATL", kRecord + 76, bad, "materials", "brightness_span");
    expect("MATL", kRecord + 80, bad, "materials", "slope_span");
  }
  expect("MOVR", 3, std::uint8_t{3}, "overrides", "not there");
  expect("LGTS", 32, kNan, "lights", "position");
  for (const float bad : {0.0f, -1.0f, kInfinity}) expect("LGTS", 12, bad, "lights", "radius");
  for (const float bad : {-0.1f, kNan, kInfinity}) expect("LGTS", 20, bad, "lights", "colour");
  expect("LGTS", 28, 1.0f, "lights", "reserved");
}

TestWorld with_blend_map() {
  TestWorld world = with_materials(3, 16, TextureFormat::rgba8);
  world.add_blend_map(6, 5, 8);
  return world;
}

TEST(BlendMaps, WhatIsWrittenIsReadAgainSomeRowsAtATime) {
  const TestWorld world = with_blend_map();
  const std::vector<std::byte> file = world.bytes();
  WorldInfo info;
  ASSERT_TRUE(read_world_info(file, info).ok());
  const WorldMaterials read = read_materials(file);
  std::vector<std::byte> again;
  ASSERT_TRUE(write_world({info, &world.memory.tree, read_patches(file), read}, again).ok());
  EXPECT_EQ(again, file);
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  const BlendMap& map = reader.materials().blend_map;
  EXPECT_EQ(map.width, 6u);
  EXPECT_EQ(map.depth, 5u);
  for (int channel = 0; channel < 4; ++channel)
    EXPECT_EQ(map.materials[channel], channel < 3 ? channel + 1 : 0);
  for (std::uint32_t first = 0; first < 5; ++first) {
    std::vector<std::byte> rows((5 - first) * 6 * 4);
    ASSERT_TRUE(reader.read_blend_rows(first, 5 - first, rows).ok());
    EXPECT_TRUE(same_bytes(rows, std::span(world.blend_map).subspan(first * 6 * 4)));
  }
  std::vector<std::byte> small(7);
  EXPECT_EQ(reader.read_blend_rows(0, 1, small).code(), StatusCode::invalid_argument);
}

TEST(BlendMaps, ADamagedRowFailsAlone) {
  const TestWorld world = with_blend_map();
  std::vector<std::byte> file = world.bytes();
  const std::size_t row_3 = start_of(file, "BMAP") + 16 + 5 * 4 + 3 * 6 * 4;
  file[row_3 + 2] ^= std::byte{1};
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  std::vector<std::byte> rows(2 * 6 * 4);
  EXPECT_TRUE(reader.read_blend_rows(1, 2, rows).ok());
  const Status status = reader.read_blend_rows(2, 2, rows);
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "blend map");
  EXPECT_EQ(status.value(), row_3);
  WorldInfo info;
  EXPECT_EQ(read_world_info(file, info).code(), StatusCode::corrupt);
  fix_checksums(file);  // of the section: the row's own is left
  EXPECT_STREQ(read_world_info(file, info).field(), "blend map");
}

TEST(BlendMaps, EveryFieldOutOfRangeIsNamed) {
  const std::vector<std::byte> file = with_blend_map().bytes();
  const auto what_of = [&](std::size_t offset, auto value) {
    std::vector<std::byte> damaged = file;
    store_at(damaged, start_of(file, "BMAP") + offset, value);
    fix_checksums(damaged);
    WorldReader reader;
    const Status status = reader.open(ByteSource::of(damaged));
    EXPECT_EQ(status.code(), StatusCode::corrupt);
    EXPECT_STREQ(status.field(), "blend map");
    EXPECT_EQ(reader.materials().count, 0u);
    return std::string(status.what());
  };
  for (const std::uint32_t bad : {0u, 1025u, 0xffffffffu}) {
    EXPECT_EQ(what_of(0, bad), "width is outside 1..1024");
    EXPECT_EQ(what_of(4, bad), "depth is outside 1..1024");
  }
  EXPECT_EQ(what_of(0, 7u), "the section's length does not fit its texels");
  EXPECT_EQ(what_of(8, std::uint8_t{4}), "a channel has a material that is not there");
  EXPECT_EQ(what_of(9, std::uint8_t{1}), "two channels have the same material");
  EXPECT_EQ(what_of(12, 1u), "a reserved field is not 0");
}

TEST(BlendMaps, TheWriterRefusesWhatTheReaderWould) {
  const TestWorld world = with_blend_map();
  const auto refused = [&](const WorldMaterials& materials) {
    std::vector<std::byte> out;
    const Status status = write_world({world.info, &world.memory.tree, world.patches(), materials}, out);
    EXPECT_STREQ(status.field(), "blend_map");
    return status.code() == StatusCode::invalid_argument && out.empty();
  };
  WorldMaterials bad = world.materials();
  bad.blend_map = bad.blend_map.first(9);
  EXPECT_TRUE(refused(bad));
  bad = world.materials();
  bad.set.blend_map.materials[0] = 4;
  EXPECT_TRUE(refused(bad));
  bad = world.materials();
  bad.set.blend_map.width = 0;
  EXPECT_TRUE(refused(bad));
}

TEST(Materials, TheWriterRefusesWhatTheReaderWould) {
  const TestWorld world = with_materials(2, 16, TextureFormat::rgba8);
  const auto field_of = [&](const WorldMaterials& materials) {
    std::vector<std::byte> out;
    const Status status = write_world({world.info, &world.memory.tree, world.patches(), materials}, out);
    EXPECT_EQ(status.code(), StatusCode::invalid_argument);
    EXPECT_TRUE(out.empty());
    return std::string(status.field());
  };
  WorldMaterials bad = world.materials();
  bad.set.side = 17;
  EXPECT_EQ(field_of(bad), "materials");
  bad = world.materials();
  bad.set.count = 9;
  EXPECT_EQ(field_of(bad), "materials");
  bad = world.materials();
  bad.set.materials[1].name[0] = 0;
  EXPECT_EQ(field_of(bad), "materials");
  bad = world.materials();
  bad.textures = bad.textures.first(9);
  EXPECT_EQ(field_of(bad), "textures");
  bad = world.materials();
  bad.overrides = bad.overrides.first(9);
  EXPECT_EQ(field_of(bad), "overrides");
  bad = world.materials();
  std::vector<std::uint8_t> overrides = world.overrides;
  overrides[2] = 3;
  bad.overrides = overrides;
  EXPECT_EQ(field_of(bad), "overrides");
  bad = WorldMaterials();
  bad.overrides = world.overrides;
  EXPECT_EQ(field_of(bad), "overrides");
  bad = world.materials();
  const std::vector<PointLight> many(17);
  bad.lights = many;
  EXPECT_EQ(field_of(bad), "lights");
}

// Sections that need each other.
TEST(Materials, ASectionThatIsMissingIsNamed) {
  const TestWorld world = with_materials(2, 16, TextureFormat::rgba8);
  const std::vector<std::byte> file = world.bytes();
  const auto without = [&](const char* section) {
    std::vector<std::byte> damaged = file;
    std::memcpy(damaged.data() + entry_of(file, section), "XTRA", 4);
    fix_checksums(damaged);
    WorldInfo info;
    return read_world_info(damaged, info);
  };
  EXPECT_STREQ(without("MATL").field(), "materials");
  EXPECT_STREQ(without("MTEX").field(), "textures");
  EXPECT_TRUE(without("MOVR").ok());
  EXPECT_TRUE(without("LGTS").ok());
  TestWorld painted = with_materials(2, 16, TextureFormat::rgba8);
  painted.add_blend_map(3, 3, 8);
  std::vector<std::byte> alone = painted.bytes();
  for (const char* section : {"MATL", "MTEX", "MOVR"})
    std::memcpy(alone.data() + entry_of(alone, section), "XTRA", 4);
  fix_checksums(alone);
  WorldInfo info;
  EXPECT_STREQ(read_world_info(alone, info).field(), "materials");
}

TEST(Materials, AWorldHandsThemOut) {
  const test::TestWorld shape =
      test::TestWorld({8, 6, 8}, [](glm::ivec3 v) { return v.y < 2 + (v.x + v.z) % 2; });
  const WorldInfo info = shape.info();
  MaterialSet set;
  set.count = 2;
  set.side = 16;
  std::strcpy(set.materials[0].name, "one");
  std::strcpy(set.materials[1].name, "two");
  std::vector<std::byte> textures(texture_bytes(set), std::byte{7});
  std::vector<std::uint8_t> overrides(info.patches, 0);
  overrides[3] = 2;
  const PointLight light{{1, 2, 3}, 4, {1, 1, 1}};
  const std::vector<std::byte> plain = shape.file();
  WorldMaterials materials{set, textures, overrides, std::span(&light, 1)};
  std::vector<std::byte> file;
  ASSERT_TRUE(write_world({info, &shape.octree(), read_patches(plain), materials}, file).ok());

  const Config config = World::config_for(info, info.level);
  test::LoadedParts parts(config);
  World& world = parts.world;
  EXPECT_EQ(world.materials().count, 0u);
  const Status status = world.load(file);
  ASSERT_TRUE(status.ok()) << status.what() << " " << status.field();
  EXPECT_EQ(world.materials().count, 2u);
  EXPECT_STREQ(world.materials().materials[1].name, "two");
  ASSERT_EQ(world.lights().size(), 1u);
  EXPECT_EQ(world.lights()[0].radius, 4);
  EXPECT_TRUE(same_bytes(world.material_overrides(), overrides));
  std::vector<std::byte> out(2 * texture_image_bytes(set.format, set.side, TextureArray::near, 0));
  ASSERT_TRUE(world.read_textures(TextureArray::near, 0, 0, 2, out).ok());
  EXPECT_EQ(out[9], std::byte{7});

  // Loading a world without any leaves none.
  ASSERT_TRUE(world.load(plain).ok());
  EXPECT_EQ(world.materials().count, 0u);
  EXPECT_TRUE(world.lights().empty());
  EXPECT_TRUE(world.material_overrides().empty());
  ASSERT_FALSE(world.load(std::span(file).first(100)).ok());
  EXPECT_EQ(world.materials().count, 0u);
}

}  // namespace
}  // namespace karst::core
