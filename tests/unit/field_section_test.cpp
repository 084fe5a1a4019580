// SPDX-License-Identifier: MIT
// Fields of isosurfaces in world files: written, read, saved, and refused where they are damaged.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/base/checksum.h"
#include "terrain/file/fields/field_section.h"
#include "terrain/file/world_reader.h"
#include "terrain/file/world_writer.h"

namespace karst::core {
namespace {

struct OwnField {
  // codes: blocks of materials; less than 0: there is no room for any.
  explicit OwnField(std::size_t blocks, std::size_t samples, int codes = -1)
      : table(blocks), bytes(samples * FieldBlocks::kBlockBytes) {
    if (codes >= 0) {
      material_table.resize(blocks);
      materials.resize(static_cast<std::size_t>(codes) * FieldBlocks::kBlockBytes);
    }
    field.create({table, bytes, material_table, materials});
  }
  // Two blocks of several materials, and one of one.
  void fill_materials() {
    for (int n = 0; n < 4096; ++n) {
      field.materials().open({0, 0, 0})[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(n % 225);
      field.materials().open({2, 1, 0})[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(n / 1024);
    }
    field.materials().fill({1, 1, 1}, 100);
  }
  // A ball in the lower left, air elsewhere, and a block of stone.
  void fill(int bits) {
    FieldInfo info;
    info.corner = {3, 0, 5};
    info.cell_log2 = 12;
    info.blocks = {3, 2, 2};
    info.sample_bits = bits;
    info.stored = 12;
    info.reach_cells = 3;
    ASSERT_TRUE(field.reset(info).ok());
    if (bits == 16) {
      fill_samples(field.words(), 32'768.0 / 3);
    } else {
      fill_samples(field.bytes(), 128.0 / 3);
    }
  }
  template <class Field>
  void fill_samples(Field& samples, double scale) {
    for (int z = 0; z < 32; ++z) {
      for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 48; ++x) {
          const double d = glm::length(glm::dvec3(x, y, z) - glm::dvec3(6.3, 5.1, 5.7)) - 4.2;
          const double value = std::floor(glm::clamp(d * scale, double{Field::kSolid}, double{Field::kAir}));
          const glm::ivec3 at(x, y, z);
          samples.open(at >> 4)[Field::offset(at & 15)] =
              static_cast<std::remove_cvref_t<decltype(samples.open(at >> 4)[0])>>(value);
        }
      }
    }
    for (int n = 0; n < 12; ++n) samples.close({n % 3, n / 3 % 2, n / 6});
    samples.fill({2, 1, 1}, Field::kSolid);
  }

  std::vector<std::uint32_t> table;
  std::vector<std::byte> bytes;
  std::vector<std::uint32_t> material_table;
  std::vector<std::uint8_t> materials;
  FieldBlocks field;
};

std::vector<std::byte> encoded(const FieldBlocks& field) {
  std::vector<std::byte> out;
  const auto append = [&](std::span<const std::byte> piece) {
    out.insert(out.end(), piece.begin(), piece.end());
    return true;
  };
  const ByteSink sink = ByteSink::to(append);
  EXPECT_TRUE(field_section::encode(field, sink.context, sink.write).ok());
  return out;
}

int sample(const FieldBlocks& field, glm::ivec3 at) {
  return field.with([&](const auto& f) { return f.at(at); });
}

void expect_equal(const FieldBlocks& a, const FieldBlocks& b) {
  const glm::ivec3 size = a.info().blocks * 16;
  int differ = 0;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) differ += sample(a, {x, y, z}) != sample(b, {x, y, z});
    }
  }
  EXPECT_EQ(differ, 0);
}

// A file with a field and no voxels.
std::vector<std::byte> file_of(const FieldBlocks& field) {
  std::vector<Octree::Octet> octets(8);
  Octree tree;
  EXPECT_TRUE(tree.create(octets, 5).ok());
  WorldWriter writer;
  writer.info.extent = {32, 31, 32};
  writer.info.depth = 5;
  writer.info.level = 1;
  writer.octree = &tree;
  writer.field = &field;
  std::vector<std::byte> out;
  const auto append = [&](std::span<const std::byte> piece) {
    out.insert(out.end(), piece.begin(), piece.end());
    return true;
  };
  const Status status = writer.run(ByteSink::to(append));
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  EXPECT_EQ(out.size(), writer.file_bytes());
  return out;
}

TEST(FieldSection, IsReadAsItWasWritten) {
  for (const int bits : {8, 16}) {
    OwnField own(12, 24), read(12, 4);
    own.fill(bits);
    const std::vector<std::byte> section = encoded(own.field);
    const FieldInfo info = field_section::info_of(own.field);
    // The ball's block and no other: the rest is air, or the stone.
    EXPECT_EQ(info.stored, 1u);
    EXPECT_EQ(section.size(), 64 + 12 + 4096u * static_cast<unsigned>(bits / 8));

    const std::vector<std::byte> file = file_of(own.field);
    WorldReader reader;
    ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
    EXPECT_TRUE(reader.verify().ok());
    EXPECT_EQ(reader.field(), info);
    ASSERT_TRUE(reader.read_field(read.field).ok());
    expect_equal(own.field, read.field);
    EXPECT_EQ(sample(read.field, {40, 20, 20}), bits == 16 ? -32768 : -128);
    EXPECT_EQ(encoded(read.field), section);
  }
}

TEST(FieldSection, NeedsRoom) {
  OwnField own(12, 24), small(12, 0), narrow(11, 4);
  own.fill(8);
  const std::vector<std::byte> file = file_of(own.field);
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  EXPECT_STREQ(reader.read_field(small.field).field(), "field_sample_blocks");
  EXPECT_STREQ(reader.read_field(narrow.field).field(), "field_blocks");
  EXPECT_FALSE(narrow.field.exists());
}

// What feeding all of a section, in pieces of a length, comes to.
field_section::Fault fault_of(const std::vector<std::byte>& section, std::size_t piece, FieldBlocks* out,
                              std::uint32_t materials = 8) {
  FieldInfo info;
  const auto all = std::span(section);
  field_section::Fault fault = field_section::decode_header(all.first(64), info);
  if (fault.what != nullptr) return fault;
  if (out != nullptr) {
    EXPECT_TRUE(out->reset(info).ok());
  }
  field_section::Decode decode(info, materials, out);
  for (std::size_t at = 64; at < all.size() && fault.what == nullptr; at += piece)
    fault = decode.feed(all.subspan(at, std::min(piece, all.size() - at)));
  return fault.what == nullptr ? decode.finish() : fault;
}

TEST(FieldSection, ComesInPiecesOfAnyLength) {
  OwnField own(12, 24), read(12, 4);
  own.fill(16);
  const std::vector<std::byte> section = encoded(own.field);
  for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, std::size_t{4096}, section.size()}) {
    EXPECT_EQ(fault_of(section, piece, &read.field).what, nullptr);
    expect_equal(own.field, read.field);
    EXPECT_EQ(fault_of(section, piece, nullptr).what, nullptr);
  }
}

TEST(FieldSection, RefusesWhatContradictsItself) {
  OwnField own(12, 24);
  own.fill(8);
  const std::vector<std::byte> good = encoded(own.field);
  const auto with = [&](std::size_t at, std::int32_t value, std::size_t bytes) {
    std::vector<std::byte> bad = good;
    std::memcpy(bad.data() + at, &value, bytes);
    return bad;
  };
  const struct {
    std::vector<std::byte> section;
    std::uint64_t offset;
  } cases[] = {{with(0, -1, 4), 0},            // corner
               {with(12, 0, 4), 12},           // blocks
               {with(12, 4096, 4), 12},        // wider than a world
               {with(24, 9, 4), 24},           // cell_log2
               {with(28, 12, 4), 28},          // sample_bits
               {with(32, 13, 4), 32},          // stored: more than there are
               {with(32, 2, 4), 64 + 11},      // stored: more than the kinds have
               {with(32, 0, 4), 64 + 0},       // stored: fewer
               {with(36, -1, 4), 36},          // reach_cells: NaN
               {with(40, 2, 4), 40},           // has_materials: neither 0 nor 1
               {with(44, 1, 4), 44},           // material_blocks, without has_materials
               {with(60, 1, 4), 48},           // reserved
               {with(64 + 5, 3, 1), 64 + 5},   // a block of no kind
               {with(64 + 5, 2, 1), 64 + 5}};  // one block of samples more
  for (const auto& c : cases) {
    const auto fault = fault_of(c.section, c.section.size(), nullptr);
    EXPECT_NE(fault.what, nullptr) << c.offset;
    EXPECT_EQ(fault.offset, c.offset) << (fault.what == nullptr ? "" : fault.what);
  }
  // A block of samples that is all air, though its kind says otherwise.
  std::vector<std::byte> alike = good;
  std::fill(alike.begin() + 76, alike.end(), std::byte{127});
  EXPECT_EQ(fault_of(alike, alike.size(), nullptr).offset, 76u);
  std::vector<std::byte> cut = good;
  cut.pop_back();
  EXPECT_STREQ(fault_of(cut, cut.size(), nullptr).what, "the samples end early");
  std::vector<std::byte> more = good;
  more.push_back(std::byte{0});
  EXPECT_STREQ(fault_of(more, more.size(), nullptr).what, "bytes follow the last block");
}

int different_codes(const FieldBlocks& a, const FieldBlocks& b) {
  const glm::ivec3 size = a.info().blocks * 16;
  int differ = 0;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) differ += a.materials().at({x, y, z}) != b.materials().at({x, y, z});
    }
  }
  return differ;
}

TEST(FieldSection, HoldsMaterials) {
  for (const int bits : {8, 16}) {
    OwnField own(12, 24, 3), read(12, 4, 2), none(12, 4), few(12, 4, 1);
    own.fill(bits);
    const std::vector<std::byte> without = encoded(own.field);
    EXPECT_FALSE(field_section::info_of(own.field).has_materials);  // all is by rules
    own.fill_materials();
    const std::vector<std::byte> section = encoded(own.field);
    const FieldInfo info = field_section::info_of(own.field);
    EXPECT_TRUE(info.has_materials);
    EXPECT_EQ(info.material_blocks, 2u);
    EXPECT_EQ(section.size(), without.size() + 12 + 2 * 4096);
    EXPECT_TRUE(std::equal(without.begin() + 64, without.end(), section.begin() + 64));
    for (const std::size_t piece : {std::size_t{1}, std::size_t{4097}, section.size()}) {
      EXPECT_EQ(fault_of(section, piece, &read.field).what, nullptr);
      expect_equal(own.field, read.field);
      EXPECT_EQ(different_codes(own.field, read.field), 0);
    }
    EXPECT_EQ(encoded(read.field), section);
    EXPECT_EQ(read.field.materials().at({16, 16, 16}), 100);
    // They go with the field: where there was one, there is none.
    EXPECT_EQ(fault_of(without, without.size(), &read.field).what, nullptr);
    EXPECT_EQ(read.field.materials().at({16, 16, 16}), 0);

    FieldInfo needed;
    ASSERT_EQ(field_section::decode_header(std::span(section).first(64), needed).what, nullptr);
    EXPECT_STREQ(none.field.reset(needed).field(), "field_material_blocks");
    EXPECT_STREQ(few.field.reset(needed).field(), "field_material_blocks");
  }
}

TEST(FieldSection, RefusesMaterialsThatContradictThemselves) {
  OwnField own(12, 24, 3);
  own.fill(8);
  const std::size_t fillings = encoded(own.field).size();
  own.fill_materials();
  const std::vector<std::byte> good = encoded(own.field);
  const std::size_t codes = fillings + 12;
  const auto fault_with = [&](std::size_t at, std::uint8_t value, std::uint32_t materials = 8) {
    std::vector<std::byte> bad = good;
    bad[at] = static_cast<std::byte>(value);
    return fault_of(bad, bad.size(), nullptr, materials).offset;
  };
  EXPECT_EQ(fault_of(good, good.size(), nullptr).what, nullptr);
  EXPECT_EQ(fault_with(fillings + 4, 225), fillings + 4);  // no code
  EXPECT_EQ(fault_with(fillings + 4, 255), fillings + 5);  // a third block: one more than stated
  EXPECT_EQ(fault_with(fillings + 5, 0), fillings + 11);   // one less
  EXPECT_EQ(fault_with(codes + 4100, 225), codes + 4096);  // no code, in the second block
  EXPECT_EQ(fault_with(44, 1), fillings + 5);              // material_blocks
  EXPECT_EQ(fault_with(44, 13), 44u);
  // Of a world with fewer materials: 100 is a mix of the sixth and another.
  EXPECT_EQ(fault_of(good, good.size(), nullptr, 7).offset, codes);
  EXPECT_EQ(fault_of(good, good.size(), nullptr, 3).offset, fillings + 10);
  // What has none says so in its header.
  std::vector<std::byte> none(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(codes));
  std::fill(none.begin() + static_cast<std::ptrdiff_t>(fillings), none.end(), std::byte{0});
  none[44] = std::byte{0};
  EXPECT_EQ(fault_of(none, none.size(), nullptr).offset, fillings + 11);
  std::vector<std::byte> alike = good;
  std::fill(alike.begin() + static_cast<std::ptrdiff_t>(codes),
            alike.begin() + static_cast<std::ptrdiff_t>(codes + 4096), std::byte{3});
  EXPECT_EQ(fault_of(alike, alike.size(), nullptr).offset, codes);
  std::vector<std::byte> cut = good;
  cut.pop_back();
  EXPECT_STREQ(fault_of(cut, cut.size(), nullptr).what, "the samples end early");
}

TEST(FieldSection, ADamagedFileIsNotRead) {
  OwnField own(12, 24), read(12, 4);
  own.fill(8);
  const std::vector<std::byte> good = file_of(own.field);
  WorldReader whole;
  ASSERT_TRUE(whole.open(ByteSource::of(good)).ok());
  std::vector<std::byte> bad = good;
  bad[bad.size() - 2000] ^= std::byte{1};  // of the samples
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(bad)).ok());
  EXPECT_EQ(reader.read_field(read.field).code(), StatusCode::corrupt);
  EXPECT_FALSE(read.field.exists());
  EXPECT_EQ(reader.verify().code(), StatusCode::corrupt);
}

}  // namespace
}  // namespace karst::core
