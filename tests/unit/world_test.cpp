// SPDX-License-Identifier: MIT
// Worlds and the memory of all parts: exactly the budget, limits named, contradictions refused, heights from
// memory and from the file alike, read by several threads at a time.
#include "terrain/world/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <thread>

#include "terrain/base/checksum.h"
#include "tests/support/hilly_world.h"
#include "tests/support/loaded_parts.h"
#include "tests/support/world_io.h"

namespace karst::core {
namespace {

using test::AlignedBytes;
using test::hilly_world;
using test::LoadedParts;

constexpr int kLevel = 3;

// A world whose load failed calls no patch by a key, nor has it any.
void expect_empty(const World& world, std::span<const PatchKey> keys) {
  EXPECT_EQ(world.patch_count(), 0u);
  EXPECT_EQ(world.patch_table().size(), 0u);
  EXPECT_EQ(world.patch_table().end(), 0u);
  for (const PatchKey key : keys) ASSERT_EQ(world.patch_table().find(key), PatchTable::kNone);
}

// Every patch lies at the slot that its key has, and that is its number in the file.
void expect_slots(const World& world, std::span<const PatchKey> keys) {
  const PatchTable& table = world.patch_table();
  ASSERT_EQ(world.patch_count(), keys.size());
  EXPECT_EQ(table.size(), keys.size());
  EXPECT_EQ(table.end(), keys.size());
  const Surface surface = world.surface();
  for (PatchId p = 0; p < keys.size(); ++p) {
    ASSERT_EQ(key_of(surface, p), keys[p]);
    ASSERT_EQ(table.find(keys[p]), p);
    ASSERT_TRUE(table.is_used(p));
    ASSERT_EQ(table.key(p), keys[p]);
  }
}

// Bytes whose n-th read fails.
struct FailingFile {
  std::span<const std::byte> bytes;
  int good_reads = 0;
  std::uint64_t asked = 0;  // where the read began that failed

  ByteSource source() {
    return {bytes.size(), this, [](const void* context, std::uint64_t offset, std::span<std::byte> out) {
              auto* self = static_cast<FailingFile*>(const_cast<void*>(context));
              if (self->good_reads-- == 0) {
                self->asked = offset;
                return false;
              }
              std::copy_n(self->bytes.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
              return true;
            }};
  }
};

TEST(World, PartsUseExactlyTheirBudget) {
  const test::TestWorld world = hilly_world();
  for (const std::uint32_t views : {1u, 3u}) {
    Config config = World::config_for(world.info(), kLevel);
    config.max_views = views;
    const Budget budget = terrain_budget(config);
    const AlignedBytes memory(budget.cpu_bytes());
    TerrainParts parts;
    ASSERT_TRUE(parts.create(config, memory.bytes()).ok());
    EXPECT_EQ(parts.arena.used(), budget.cpu_bytes());
    EXPECT_EQ(parts.arena.capacity(), budget.cpu_bytes());
    EXPECT_TRUE(parts.arena.frozen());
    for (std::size_t c = 0; c < kConsumerCount; ++c) {
      const Consumer consumer = static_cast<Consumer>(c);
      EXPECT_EQ(parts.arena.used(consumer), budget.bytes(consumer)) << kConsumerNames[c];
    }
    ASSERT_TRUE(parts.load(world.file()).ok());
    EXPECT_EQ(parts.arena.used(), budget.cpu_bytes());
  }
}

TEST(World, OneByteLessIsTooLittle) {
  const test::TestWorld world = hilly_world();
  const Config config = World::config_for(world.info(), kLevel);
  const std::size_t needed = terrain_budget(config).cpu_bytes();
  const AlignedBytes memory(needed);
  TerrainParts parts;
  const Status status = parts.create(config, memory.bytes().first(needed - 1));
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "memory");
  EXPECT_EQ(status.value(), needed);
  EXPECT_EQ(parts.create(config, memory.bytes().subspan(1)).code(), StatusCode::limit_reached);
  // An arena that is not there has room for none of them.
  Arena none({});
  World alone;
  EXPECT_STREQ(alone.create(config, none).field(), "memory");
}

// Each limit, one below what the world needs.
TEST(World, EachLimitIsNamed) {
  const test::TestWorld world = hilly_world();
  const std::vector<std::byte> file = world.file();
  const struct {
    std::uint32_t Config::*member;
    const char* name;
  } limits[] = {{&Config::max_depth, "max_depth"},
                {&Config::max_level, "max_level"},
                {&Config::max_octets, "max_octets"},
                {&Config::max_volumes, "max_volumes"},
                {&Config::max_patches, "max_patches"}};
  for (const auto& limit : limits) {
    Config config = World::config_for(world.info(), kLevel);
    config.*limit.member -= 1;
    LoadedParts parts(config);
    const Status status = parts.load(file);
    EXPECT_EQ(status.code(), StatusCode::limit_reached) << limit.name;
    EXPECT_STREQ(status.field(), limit.name);
    EXPECT_EQ(parts.world.patch_count(), 0u);
  }
}

// One patch more than the world has, too, so that capacity and count differ.
TEST(World, EachPatchIsFoundByItsKey) {
  const test::TestWorld shape = hilly_world();
  const std::vector<PatchKey> keys = shape.keys();
  for (const std::uint32_t more : {0u, 1u, 5000u}) {
    Config config = World::config_for(shape.info(), kLevel);
    config.max_patches += more;
    LoadedParts parts(config);
    EXPECT_EQ(parts.world.patch_table().size(), 0u);
    ASSERT_TRUE(parts.load(shape.file()).ok());
    expect_slots(parts.world, keys);
    EXPECT_EQ(parts.world.patch_table().capacity(), config.max_patches);
    const glm::ivec3 extent = shape.extent();
    const auto absent = PatchKey::make(0u, static_cast<std::uint32_t>(extent.x), 1023,
                                       static_cast<std::uint32_t>(extent.z), 0);
    EXPECT_EQ(parts.world.patch_table().find(absent), PatchTable::kNone);
  }
}

// The next world's patches take the place of those of the last, whichever of the two is larger.
TEST(World, AnotherWorldHasOtherKeys) {
  const test::TestWorld large = hilly_world();
  test::TestWorld small = test::TestWorld::noise(3, {14, 10, 14}, 0.5, 3.0, false);
  small.roughen(kLevel, 9, 500);
  Config config = World::config_for(large.info(), kLevel);
  config.max_octets = std::max(config.max_octets, small.info().octets);
  config.max_volumes = std::max(config.max_volumes, small.info().volumes);
  config.max_patches = std::max(config.max_patches, small.info().patches);
  config.max_height_blocks = config.max_patches;
  ASSERT_NE(small.info().patches, large.info().patches);
  LoadedParts parts(config);
  for (const test::TestWorld* shape : std::initializer_list<const test::TestWorld*>{&large, &small, &large}) {
    ASSERT_TRUE(parts.load(shape->file()).ok());
    expect_slots(parts.world, shape->keys());
  }
}

// 28 bytes a patch, one for its material, eight for its key, and four an entry of a table at most 2/3 full:
// each block in whole cache lines.
TEST(World, PatchesTakeWhatIsStated) {
  const auto lines = [](std::size_t bytes) { return (bytes + 63) / 64 * 64; };
  Config config;
  for (const std::size_t patches : {1u, 2u, 3u, 1000u, 4096u}) {
    config.max_patches = static_cast<std::uint32_t>(patches);
    std::size_t entries = 4;
    while (entries * 2 < patches * 3) entries *= 2;
    Budget budget;
    World::add_to(budget, config);
    EXPECT_EQ(budget.bytes(Consumer::patches),
              lines(28 * patches) + lines(patches) + lines(8 * patches) + lines(4 * entries));
  }
}

// Whichever read of the file fails: it is named, the world is empty, and it can be loaded again.
TEST(World, AFileThatCannotBeReadIsNamed) {
  const test::TestWorld shape = hilly_world();
  const std::vector<std::byte> bytes = shape.file();
  LoadedParts parts(shape);
  FailingFile file{bytes};
  const auto expect_io = [&](const Status& status, int read) {
    EXPECT_EQ(status.code(), StatusCode::io) << read;
    EXPECT_STREQ(status.field(), "file");
    EXPECT_EQ(status.value(), file.asked);
  };
  const auto failures = [&](const auto& run, const auto& check) {
    for (int read = 0;; ++read) {
      file.good_reads = read;
      const Status status = run();
      if (file.good_reads >= 0) {
        EXPECT_TRUE(status.ok());
        return read;
      }
      expect_io(status, read);
      check();
    }
  };
  const auto load = [&] { return parts.load(file.source()); };
  EXPECT_GT(failures(load, [&] { expect_empty(parts.world, shape.keys()); }), 20);
  expect_slots(parts.world, shape.keys());
  file.good_reads = 1 << 20;
  WorldReader reader;
  ASSERT_TRUE(reader.open(file.source()).ok());
  EXPECT_GT(failures([&] { return reader.verify(); }, [] {}), 20);
}

TEST(World, LoadsAgainAfterAFailure) {
  const test::TestWorld world = hilly_world();
  LoadedParts parts(world);
  expect_slots(parts.world, world.keys());
  std::vector<std::byte> file = world.file();
  std::vector<std::byte> broken = file;
  broken[broken.size() / 2] ^= std::byte{1};
  EXPECT_EQ(parts.load(broken).code(), StatusCode::corrupt);
  expect_empty(parts.world, world.keys());
  EXPECT_TRUE(parts.load(file).ok());
  expect_slots(parts.world, world.keys());
}

// A valid file whose patches disagree about a vertex they share would draw a crack.
TEST(World, RefusesHeightsThatDisagree) {
  test::TestWorld world = hilly_world();
  LoadedParts parts(world);
  const int side = patch_side(kLevel);
  // Vertex (1, 0) of the first patch that has a neighbour across edge 0.
  for (PatchId p = 0; p < world.patches().size(); ++p) {
    if (!world.patches()[p].neighbour[0].exists()) continue;
    world.height_samples()[static_cast<std::size_t>(p) * static_cast<std::size_t>(side * side) + 1] ^= 1;
    break;
  }
  const Status status = parts.load(world.file());
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "heights");
  expect_empty(parts.world, world.keys());
}

// A file whose sections fit one another, but whose patches are not those that its voxels make: the counts of
// the header tell, and where they are right, the keys do.
TEST(World, RefusesPatchesThatContradictTheVoxels) {
  test::TestWorld world = test::TestWorld::noise(3, {14, 10, 14}, 0.5, 3.0, false);
  world.roughen(kLevel, 9, 500);
  LoadedParts parts(world);
  const auto load = [&](std::vector<PatchKey> keys, std::uint32_t volumes) {
    WorldInfo info = world.info();
    info.patches = info.height_blocks = static_cast<std::uint32_t>(keys.size());
    info.volumes = volumes;
    std::vector<std::int16_t> samples(keys.size() * static_cast<std::size_t>(patch_vertices(kLevel)));
    std::vector<std::byte> mask((keys.size() + 7) / 8, std::byte{0});
    for (std::size_t p = 0; p < keys.size(); ++p) mask[p / 8] |= static_cast<std::byte>(1u << (p % 8));
    std::vector<std::uint16_t> errors(keys.size() * level_error_values(kLevel));
    std::vector<PatchBounds> bounds(keys.size());
    std::vector<NormalCone> cones(keys.size());
    const WorldWriter writer{info, &world.octree(), {keys, mask, samples, errors, bounds, cones}};
    std::vector<std::byte> file;
    EXPECT_TRUE(write_world(writer, file).ok());
    const Status status = parts.load(file);
    EXPECT_EQ(parts.world.patch_count(), status.ok() ? info.patches : 0u);
    return status;
  };
  const std::vector<PatchKey> keys = world.keys();
  const std::uint32_t volumes = world.info().volumes;
  EXPECT_TRUE(load(keys, volumes).ok());

  // The last patch of a volume with several is missing; then all of a volume with one.
  const auto following = [&](bool several) {
    for (std::size_t k = keys.size() / 2; k + 1 < keys.size(); ++k) {
      if (keys[k + 1].case_patch() == 0 && (keys[k].case_patch() > 0) == several) return k;
    }
    return keys.size();
  };
  std::vector<PatchKey> fewer = keys;
  fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(following(true)));
  EXPECT_STREQ(load(fewer, volumes).field(), "patches");
  fewer = keys;
  const std::size_t single = following(false);
  fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(single));
  EXPECT_STREQ(load(fewer, volumes - 1).field(), "volumes");

  // As many of each, but one lies elsewhere: in a corner that holds no surface.
  const glm::ivec3 extent = world.extent();
  std::vector<PatchKey> others = keys;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(single));
  for (std::uint32_t y = 1; others.size() < keys.size() && y <= static_cast<std::uint32_t>(extent.y); ++y) {
    const PatchKey key = PatchKey::make(0u, 1, y, 1, 0);
    const auto at = std::lower_bound(others.begin(), others.end(), key);
    if (!std::binary_search(keys.begin(), keys.end(), key)) others.insert(at, key);
  }
  ASSERT_EQ(others.size(), keys.size());
  const Status status = load(others, volumes);
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "patch keys");
}

// What height_source() gives is what the file holds, whether heights are in memory or not, for any number of
// threads that ask at a time.
TEST(World, HeightsAreReadFromSeveralThreads) {
  const test::TestWorld shape = hilly_world();
  const std::vector<std::byte> file = shape.file();
  for (const bool all : {true, false}) {
    Config config = World::config_for(shape.info(), kLevel);
    if (!all) config.max_height_blocks = HeightCache::kLeastGroups * kHeightGroup;
    LoadedParts parts(config);
    ASSERT_TRUE(parts.load(file).ok());
    const World& world = parts.world;
    ASSERT_EQ(world.holds_all_heights(), all);
    const auto block = static_cast<std::size_t>(patch_vertices(kLevel));
    const Heights expected = shape.heights();
    const std::uint32_t blocks = world.info().height_blocks;
    const auto check = [&](bool& same) {
      const HeightSource source = world.height_source();
      std::vector<std::int16_t> group(kHeightGroup * block);
      for (std::uint32_t g = 0; g < height_groups(blocks); ++g) {
        const std::size_t count = std::min(kHeightGroup, blocks - g * kHeightGroup) * block;
        const std::span<std::int16_t> out = std::span(group).first(count);
        same = same && source.read(source.context, g, out).ok() &&
               std::memcmp(out.data(), expected.block(g * kHeightGroup), out.size_bytes()) == 0;
      }
    };
    bool same[4] = {true, true, true, true};
    std::vector<std::thread> threads;
    for (bool& result : same) threads.emplace_back([&] { check(result); });
    for (std::thread& thread : threads) thread.join();
    for (const bool result : same) EXPECT_TRUE(result) << all;
  }
}

}  // namespace
}  // namespace karst::core
