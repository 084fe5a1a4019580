// SPDX-License-Identifier: MIT
#include "terrain/edit/save_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/loaded_parts.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::AlignedBytes;
using test::TestWorld;

struct Loaded {
  std::vector<std::byte> file;
  TerrainParts parts;
  std::vector<PatchId> room;

  explicit Loaded(std::vector<std::byte> bytes) : file(std::move(bytes)) {
    WorldReader reader;
    EXPECT_TRUE(reader.open(ByteSource::of(file)).ok());
    const Config config = World::config_for(reader.info(), reader.info().level, reader.ground());
    memory = AlignedBytes(static_cast<std::size_t>(terrain_budget(config).cpu_bytes()));
    EXPECT_TRUE(parts.create(config, memory.bytes()).ok());
    EXPECT_TRUE(parts.load(ByteSource::of(file)).ok());
    room.resize(parts.world.patch_count());
  }
  Status save(std::vector<std::byte>& out, std::size_t most = ~std::size_t{0}) {
    out.clear();
    const auto append = [&](std::span<const std::byte> bytes) {
      if (out.size() + bytes.size() > most) return false;
      out.insert(out.end(), bytes.begin(), bytes.end());
      return true;
    };
    return SaveWorld{&parts.world, nullptr, room}.run(ByteSink::to(append));
  }

  AlignedBytes memory{0};
};

TestWorld rough_world() {
  TestWorld world = TestWorld::noise(3, {12, 9, 11}, 0.45, 3, false);
  world.roughen(3, 7, 2000);
  return world;
}

TEST(SaveWorld, WhatNobodyEditedIsTheSameFile) {
  for (const TestWorld& world : {rough_world(), TestWorld::hills()}) {
    Loaded loaded(world.file());
    std::vector<std::byte> saved;
    ASSERT_TRUE(loaded.save(saved).ok());
    ASSERT_EQ(saved.size(), loaded.file.size());
    const auto differs = std::mismatch(saved.begin(), saved.end(), loaded.file.begin()).first;
    EXPECT_EQ(differs - saved.begin(), saved.end() - saved.begin());
  }
}

TEST(SaveWorld, FailuresAreTold) {
  Loaded loaded(rough_world().file());
  std::vector<std::byte> saved;
  for (std::size_t most = 0; most < loaded.file.size(); most += 997) {
    const Status status = loaded.save(saved, most);
    EXPECT_EQ(status.code(), StatusCode::limit_reached);
    EXPECT_STREQ(status.field(), "sink");
  }
  loaded.room.pop_back();
  const Status status = loaded.save(saved);
  EXPECT_EQ(status.code(), StatusCode::invalid_argument);
  EXPECT_STREQ(status.field(), "room");
  EXPECT_EQ(status.value(), loaded.parts.world.patch_count());
}

}  // namespace
}  // namespace karst::core
