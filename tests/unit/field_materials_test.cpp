// SPDX-License-Identifier: MIT
// Materials of a field's samples: codes say what they were made of, blocks that are alike take no room, and
// what gives way is free again.
#include <gtest/gtest.h>

#include <set>
#include <tuple>
#include <vector>

#include "terrain/isosurface/field_blocks.h"
#include "terrain/isosurface/field_materials.h"

namespace karst::core {
namespace {

TEST(FieldMaterials, CodesAreAllMixesOfTwo) {
  std::set<std::tuple<int, int, int>> seen;
  for (unsigned c = 0; c < material_code::kCount; ++c) {
    const auto code = static_cast<std::uint8_t>(c);
    const MaterialMix mix = mix_of(code);
    EXPECT_EQ(code_of(mix), code);
    EXPECT_LE(mix.first, mix.second);
    EXPECT_LE(mix.second, 8);
    EXPECT_EQ(mix.sevenths == 0, mix.first == mix.second);
    EXPECT_LT(mix.sevenths, 7);
    seen.insert({mix.first, mix.second, mix.sevenths});
    EXPECT_EQ(vertex_material(code), mix.first + 16 * mix.second + 256 * mix.sevenths);
  }
  // Nine alone, and each pair with six shares.
  EXPECT_EQ(seen.size(), 9u + 36 * 6);
  for (std::uint8_t m = 0; m <= 8; ++m) EXPECT_EQ(mix_of(m), (MaterialMix{m, m, 0}));
}

struct OwnMaterials {
  OwnMaterials(glm::ivec3 blocks, std::size_t slots)
      : table(static_cast<std::size_t>(blocks.x * blocks.y * blocks.z)), pool(slots * 4096) {
    EXPECT_TRUE(materials.create(blocks, table, pool).ok());
  }
  std::vector<std::uint32_t> table;
  std::vector<std::uint8_t> pool;
  FieldMaterials materials;
};

TEST(FieldMaterials, BlocksTakeRoomOnlyWhereTheyDiffer) {
  OwnMaterials own({3, 2, 2}, 2);
  FieldMaterials& m = own.materials;
  EXPECT_EQ(m.free_blocks(), 2u);
  EXPECT_EQ(m.at({40, 20, 20}), 0);
  m.fill({2, 1, 1}, 200);
  EXPECT_EQ(m.at({47, 31, 31}), 200);
  EXPECT_EQ(m.at({400, 400, 400}), 200);  // as at the sides
  EXPECT_EQ(m.at({31, 31, 31}), 0);
  EXPECT_EQ(m.free_blocks(), 2u);

  const std::span<std::uint8_t> codes = m.open({2, 1, 1});
  ASSERT_EQ(codes.size(), 4096u);
  EXPECT_EQ(codes[77], 200);
  codes[FieldMaterials::offset({1, 2, 3})] = 5;
  m.close({2, 1, 1});
  EXPECT_EQ(m.at({33, 18, 19}), 5);
  EXPECT_EQ(m.at({34, 18, 19}), 200);
  EXPECT_EQ(m.free_blocks(), 1u);
  ASSERT_FALSE(m.open({0, 0, 0}).empty());
  EXPECT_TRUE(m.open({1, 0, 0}).empty());  // none is left
  m.close({0, 0, 0});
  EXPECT_EQ(m.free_blocks(), 1u);
  EXPECT_EQ(m.filling({0, 0, 0}), 0);

  m.open({2, 1, 1})[FieldMaterials::offset({1, 2, 3})] = 200;
  m.close({2, 1, 1});
  EXPECT_EQ(m.free_blocks(), 2u);
  EXPECT_EQ(m.filling({2, 1, 1}), 200);
  EXPECT_TRUE(m.block({2, 1, 1}).empty());
}

TEST(FieldMaterials, AFieldHasThemWhereThereIsRoom) {
  std::vector<std::uint32_t> table(8), material_table(8);
  std::vector<std::byte> samples(4096);
  std::vector<std::uint8_t> codes(4096);
  FieldInfo info;
  info.blocks = {2, 2, 2};
  FieldBlocks without, with;
  without.create({table, samples});
  ASSERT_TRUE(without.reset(info).ok());
  EXPECT_FALSE(without.materials().exists());
  with.create({table, samples, material_table, codes});
  ASSERT_TRUE(with.reset(info).ok());
  EXPECT_TRUE(with.materials().exists());

  info.has_materials = true;
  EXPECT_STREQ(without.reset(info).field(), "field_material_blocks");
  EXPECT_FALSE(without.exists());
  info.material_blocks = 2;
  const Status more = with.reset(info);
  EXPECT_EQ(more.code(), StatusCode::limit_reached);
  EXPECT_STREQ(more.field(), "field_material_blocks");
  EXPECT_EQ(more.value(), 2u);
  EXPECT_FALSE(with.materials().exists());
  info.has_materials = false;
  EXPECT_STREQ(with.reset(info).field(), "material_blocks");
}

}  // namespace
}  // namespace karst::core
