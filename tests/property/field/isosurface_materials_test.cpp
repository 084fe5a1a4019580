// SPDX-License-Identifier: MIT
// Materials of an isosurface's vertices in blocks of mixed resolutions: each is that of the solid one of the
// two finest samples that the surface goes between there, and of no other; two blocks that share a vertex
// give it the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <random>
#include <vector>

#include <glm/common.hpp>

#include "terrain/base/arena.h"
#include "terrain/base/budget.h"
#include "terrain/base/storage_plan.h"
#include "terrain/blocks/block_tree.h"
#include "terrain/isosurface/extract_block.h"
#include "tests/support/field_shapes.h"
#include "tests/support/test_world.h"

namespace karst::test {
namespace {

constexpr glm::ivec3 kBlocks(5, 4, 6);
constexpr std::uint32_t kCount = 5 * 4 * 6;

struct Rock {
  Rock() : config(config_of()), memory(bytes()), arena(memory.bytes()) {
    FieldBlocks::Storage storage;
    storage.each_block(config, TakeBlocks(arena));
    field.create(storage);
    FieldInfo info = field_info(kBlocks, kCount);
    info.has_materials = true;
    info.material_blocks = kCount;
    EXPECT_TRUE(field.reset(info).ok());
    BlockTree::Storage nodes;
    nodes.each_block(config, TakeBlocks(arena));
    tree.create(nodes);
  }
  static Config config_of() {
    Config config;
    config.field_blocks = config.field_sample_blocks = config.field_material_blocks = kCount;
    return config;
  }
  std::size_t bytes() const {
    Budget budget;
    FieldBlocks::Storage storage;
    storage.each_block(config, CountBlocks(budget));
    BlockTree::Storage nodes;
    nodes.each_block(config, CountBlocks(budget));
    return budget.cpu_bytes();
  }
  // Lumps of some seed, thinner ones too, in each sample any material: what is next to the surface is not
  // what lies behind it.
  void fill(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    std::array<std::array<double, 4>, 8> waves;
    for (auto& w : waves) w = {0.5 * any(random), 0.5 * any(random), 0.5 * any(random), 3 * any(random)};
    const glm::dvec3 size(kBlocks * 16);
    fill_field(field, [&](glm::dvec3 p) {
      double sum = 0;
      for (const auto& w : waves) sum += std::sin(w[0] * p.x + w[1] * p.y + w[2] * p.z + w[3]);
      const glm::dvec3 side = glm::min(p, size - 1.0 - p) - 2.0;
      return std::max(1.5 * sum, -std::min(side.x, std::min(side.y, side.z)));
    });
    std::uniform_int_distribution<int> code(0, material_code::kCount - 1);
    for (int b = 0; b < static_cast<int>(kCount); ++b) {
      const glm::ivec3 block(b % kBlocks.x, b / kBlocks.x % kBlocks.y, b / kBlocks.x / kBlocks.y);
      for (std::uint8_t& c : field.materials().open(block)) c = static_cast<std::uint8_t>(code(random));
    }
    tree.reset(field);
  }

  Config config;
  AlignedBytes memory;
  Arena arena;
  FieldBlocks field;
  BlockTree tree;
};

BlockEye any_eye(std::mt19937& random, double steps_per_step) {
  std::uniform_real_distribution<double> any(-0.3, 1.3);
  BlockEye eye;
  const glm::dvec3 at(any(random), any(random), any(random));
  eye.eye.eye = glm::vec3(at * glm::dvec3(kBlocks * (16 * 8192)));
  eye.eye.least_cos2 = 0.4f;
  eye.eye.forward = glm::vec3(0, 0, -1);
  eye.steps_per_step = static_cast<float>(steps_per_step);
  return eye;
}

// Whether a vertex's code is that of a solid sample which the surface passes, of the finest edge that it lies
// on. at: 1 / 1024 samples, of which a coarse level rounds.
bool is_of_the_rock_there(const FieldBlocks& field, glm::ivec3 at, int axis, int rounded, unsigned code) {
  const auto is_solid = [&](glm::ivec3 s) { return field.with([&](const auto& f) { return f.at(s); }) < 0; };
  for (int off : {-rounded, rounded}) {
    glm::ivec3 low = at;
    low[axis] += off;
    low = low >> 10;
    glm::ivec3 high = low;
    ++high[axis];
    const bool low_solid = is_solid(low);
    if (low_solid == is_solid(high)) continue;
    if (field.materials().at(low_solid ? low : high) == code) return true;
  }
  return false;
}

// Of three runs.
template <class Run>
double least_ns(const Run& run) {
  double least = 1e30;
  for (int n = 0; n < 3; ++n) {
    const auto start = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - start;
    least = std::min(least, took.count());
  }
  return least;
}

TEST(IsosurfaceMaterials, AreOfTheSolidSampleAtTheFinestCrossing) {
  Rock rock;
  std::mt19937 random(11);
  std::vector<IsoVertex> vertices(28'000);
  std::vector<std::uint16_t> triangles(3 * 36'000);
  std::vector<std::byte> room(ExtractBlock<std::int8_t>::room_bytes());
  std::vector<ChosenBlock> chosen(2 * kCount);
  std::size_t count = 0, coarse = 0, shared = 0, poisoned = 0, apart = 0;
  double with_ns = 0, without_ns = 0;
  for (unsigned n = 0; n < 24; ++n) {
    rock.fill(n);
    const BlockEye eye = any_eye(random, std::exp2(n % 5));
    const std::size_t blocks = rock.tree.choose(std::span(&eye, 1), 0, chosen);
    ASSERT_LE(blocks, chosen.size());
    std::map<std::array<int, 3>, unsigned> at_sides;
    for (std::size_t b = 0; b < blocks; ++b) {
      const int level = chosen[b].block.level;
      ExtractBlock<std::int8_t> job;
      job.field = &rock.field.bytes();
      job.materials = &rock.field.materials();
      job.level = level;
      job.corner = chosen[b].block.place() * (16 << level);
      job.around = unpack_around(chosen[b].around);
      job.vertices = vertices;
      job.triangles = triangles;
      ExtractBlock<std::int8_t>::Result made;
      ExtractBlock<std::int8_t> plain = job;
      plain.materials = nullptr;
      without_ns += least_ns([&] { ASSERT_TRUE(plain.run(room, made).ok()); });
      with_ns += least_ns([&] { ASSERT_TRUE(job.run(room, made).ok()); });
      for (std::uint32_t v = 0; v < made.vertices; ++v) {
        const IsoVertex& vertex = vertices[v];
        const glm::ivec3 primary(vertex.primary[0], vertex.primary[1], vertex.primary[2]);
        const glm::ivec3 at = job.corner * 1024 + primary * (1 << level);
        bool alright = false;
        for (int axis = 0; axis < 3; ++axis) {
          const glm::ivec3 off_grid = at & 1023;
          const glm::ivec3 others(axis == 0 ? 0 : off_grid.x, axis == 1 ? 0 : off_grid.y,
                                  axis == 2 ? 0 : off_grid.z);
          if (others != glm::ivec3(0)) continue;
          alright = alright || is_of_the_rock_there(rock.field, at, axis, 16 << level, vertex.material);
        }
        poisoned += !alright;
        ++count;
        coarse += level > 0;
        bool on_side = false;
        for (int k = 0; k < 3; ++k) on_side = on_side || primary[k] == 0 || primary[k] == 16 * 1024;
        if (!on_side) continue;
        const glm::ivec3 place =
            job.corner * 1024 + glm::ivec3(vertex.place[0], vertex.place[1], vertex.place[2]) * (1 << level);
        const auto [other, is_new] = at_sides.insert({{place.x, place.y, place.z}, vertex.material});
        shared += !is_new;
        apart += !is_new && other->second != vertex.material;
      }
    }
  }
  EXPECT_EQ(poisoned, 0u);
  EXPECT_EQ(apart, 0u);
  EXPECT_GT(count, 100'000u);
  EXPECT_GT(coarse, 20'000u);
  EXPECT_GT(shared, 20'000u);
  const auto of = static_cast<double>(count);
  std::printf("%zu vertices, %zu of coarse blocks, %zu shared by blocks; ", count, coarse, shared);
  std::printf("%.1f ns each with materials, %.1f without\n", with_ns / of, without_ns / of);
}

}  // namespace
}  // namespace karst::test
