// SPDX-License-Identifier: MIT
// Config: the table of limits is complete and sane, and validate() names the field that is wrong.
#include "terrain/base/config.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace karst::core {
namespace {

TEST(ConfigTest, DefaultsAreValidAndEqualTheTable) {
  const Config config;
  EXPECT_TRUE(config.validate().ok());
  for (const ConfigField& field : kConfigFields) {
    EXPECT_EQ(config.*field.member, field.default_value) << field.name;
  }
}

TEST(ConfigTest, EveryFieldIsInTheTableOnce) {
  // Each entry must change a member that no other entry changes; their number is that of the members.
  ASSERT_EQ(kConfigFields.size() * sizeof(std::uint32_t), sizeof(Config));
  Config marked{};
  for (std::size_t i = 0; i < kConfigFields.size(); ++i) {
    marked.*kConfigFields[i].member = static_cast<std::uint32_t>(1000 + i);
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < kConfigFields.size(); ++i) {
    EXPECT_EQ(marked.*kConfigFields[i].member, 1000 + i) << kConfigFields[i].name;
    names.insert(kConfigFields[i].name);
    EXPECT_LT(kConfigFields[i].min, kConfigFields[i].max);
    EXPECT_GT(std::strlen(kConfigFields[i].unit), 0u);
    EXPECT_GT(std::strlen(kConfigFields[i].reason), 0u);
  }
  EXPECT_EQ(names.size(), kConfigFields.size());
}

TEST(ConfigTest, ValuesOutsideTheRangeAreNamed) {
  for (const ConfigField& field : kConfigFields) {
    Config above;
    above.*field.member = field.max + 1;
    const Status too_large = above.validate();
    EXPECT_EQ(too_large.code(), StatusCode::invalid_argument) << field.name;
    EXPECT_STREQ(too_large.field(), field.name);
    EXPECT_EQ(too_large.value(), std::uint64_t{field.max} + 1);

    if (field.min == 0) continue;
    Config below;
    below.*field.member = field.min - 1;
    const Status too_small = below.validate();
    EXPECT_EQ(too_small.code(), StatusCode::invalid_argument) << field.name;
    EXPECT_STREQ(too_small.field(), field.name);
    EXPECT_EQ(too_small.value(), std::uint64_t{field.min} - 1);
  }
}

TEST(ConfigTest, EndsOfEveryRangeAreLegal) {
  for (const ConfigField& field : kConfigFields) {
    for (const std::uint32_t value : {field.min, field.max}) {
      Config config;
      config.max_draw_items = 1;  // keeps the limits that depend on it out of the way
      config.*field.member = value;
      if (field.member == &Config::max_draw_items) config.gpu_vertex_pages = kMostPages;
      if (field.member == &Config::max_draw_items) config.max_resident_patches = kMostPages;
      if (field.member == &Config::max_draw_items) config.stream_indices = 1u << 26;
      EXPECT_TRUE(config.validate().ok()) << field.name << " = " << value;
    }
  }
}

TEST(ConfigTest, EveryDrawItemHasRoomAtLevelOne) {
  Config config;
  config.max_draw_items = 100;
  config.gpu_vertex_pages = 100;
  config.stream_indices = 2400;
  EXPECT_TRUE(config.validate().ok());
  config.gpu_vertex_pages = 99;
  EXPECT_STREQ(config.validate().field(), "gpu_vertex_pages");
  config.gpu_vertex_pages = 100;
  config.stream_indices = 2399;
  EXPECT_STREQ(config.validate().field(), "stream_indices");
}

TEST(ConfigTest, DocsShowTheTable) {
  std::ifstream file(KARST_SOURCE_DIR "/docs/memory.md");
  const std::string page(std::istreambuf_iterator<char>(file), {});
  for (const ConfigField& field : kConfigFields) {
    const std::string row = "| `" + std::string(field.name) + "` | " + std::to_string(field.default_value) +
                            " | " + std::to_string(field.min) + " – " + std::to_string(field.max) + " | " +
                            field.unit + " | " + field.reason + " |\n";
    EXPECT_NE(page.find(row), std::string::npos) << "docs/memory.md lacks this row:\n" << row;
  }
}

TEST(ConfigTest, LevelOneFitsOnePage) {
  EXPECT_LE(patch_vertices(1), static_cast<int>(kPageVertices));
  EXPECT_EQ(kLeastIndicesPerPatch, 24u);
}

}  // namespace
}  // namespace karst::core
