// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "terrain/isosurface/field_blocks.h"

namespace karst::core {
namespace {

struct OwnBlocks {
  explicit OwnBlocks(std::size_t blocks, std::size_t samples)
      : table(blocks), bytes(samples * FieldBlocks::kBlockBytes) {
    field.create({table, bytes});
  }
  std::vector<std::uint32_t> table;
  std::vector<std::byte> bytes;
  FieldBlocks field;
};

FieldInfo info_of(int bits, std::uint32_t stored) {
  FieldInfo info;
  info.blocks = {2, 3, 4};
  info.sample_bits = bits;
  info.stored = stored;
  return info;
}

TEST(FieldBlocks, HoldSamplesOfEightAndSixteenBits) {
  OwnBlocks own(24, 4);
  ASSERT_TRUE(own.field.reset(info_of(8, 4)).ok());
  EXPECT_EQ(own.field.bytes().free_blocks(), 4u);
  own.field.bytes().open({1, 2, 3})[5] = -7;
  EXPECT_EQ(own.field.with([](const auto& f) { return f.at({16 + 5, 32, 48}); }), -7);
  EXPECT_EQ(own.field.with([](const auto& f) { return f.at({0, 0, 0}); }), 127);

  ASSERT_TRUE(own.field.reset(info_of(16, 2)).ok());
  EXPECT_EQ(own.field.words().free_blocks(), 2u);
  own.field.words().open({0, 0, 0})[0] = -7000;
  EXPECT_EQ(own.field.with([](const auto& f) { return f.at({0, 0, 0}); }), -7000);
  EXPECT_EQ(own.field.with([](const auto& f) { return f.at({21, 32, 48}); }), 32767);
}

TEST(FieldBlocks, SayWhatTheyHaveNoRoomFor) {
  OwnBlocks own(24, 3);
  const Status samples = own.field.reset(info_of(16, 2));
  EXPECT_EQ(samples.code(), StatusCode::limit_reached);
  EXPECT_STREQ(samples.field(), "field_sample_blocks");
  EXPECT_EQ(samples.value(), 4u);
  EXPECT_FALSE(own.field.exists());
  FieldInfo wide = info_of(8, 1);
  wide.blocks.x = 3;
  const Status table = own.field.reset(wide);
  EXPECT_STREQ(table.field(), "field_blocks");
  EXPECT_EQ(table.value(), 36u);
}

TEST(FieldBlocks, InfosThatMeanNothingAreRefused) {
  EXPECT_TRUE(validate(info_of(8, 24)).ok());
  const auto refused = [](auto change) {
    FieldInfo info = info_of(8, 1);
    change(info);
    return std::string(validate(info).ok() ? "" : validate(info).field());
  };
  EXPECT_EQ(refused([](FieldInfo& i) { i.stored = 25; }), "stored");
  EXPECT_EQ(refused([](FieldInfo& i) { i.cell_log2 = 14; }), "cell_log2");
  EXPECT_EQ(refused([](FieldInfo& i) { i.cell_log2 = 9; }), "cell_log2");
  EXPECT_EQ(refused([](FieldInfo& i) { i.sample_bits = 12; }), "sample_bits");
  EXPECT_EQ(refused([](FieldInfo& i) { i.blocks.y = 0; }), "blocks");
  EXPECT_EQ(refused([](FieldInfo& i) { i.blocks.y = 33; }), "blocks");
  EXPECT_EQ(refused([](FieldInfo& i) { i.corner.z = -1; }), "corner");
}

}  // namespace
}  // namespace karst::core
