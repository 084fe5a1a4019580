// SPDX-License-Identifier: MIT
// A small world file in memory, with made-up but consistent counts.
#pragma once

#include "terrain/base/lattice.h"
#include "terrain/field/voxelize.h"
#include "terrain/measure/level_error.h"
#include "tests/support/tree_memory.h"
#include "tests/support/world_io.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace karst::core {

struct TestWorld {
  WorldInfo info;
  TreeMemory memory;
  std::vector<PatchKey> keys;
  std::vector<std::byte> mask;
  std::vector<std::int16_t> samples;
  std::vector<std::uint16_t> errors;
  std::vector<PatchBounds> bounds;
  std::vector<NormalCone> cones;
  // None, unless add_materials() was called.
  MaterialSet set;
  std::vector<std::byte> textures;
  std::vector<std::uint8_t> overrides;
  std::vector<PointLight> lights;
  std::vector<std::byte> blend_map;  // none, unless add_blend_map() was called

  TestWorld(int depth, int level, std::uint64_t seed) : memory(depth) {
    TestRandom random(seed);
    const int size = 1 << depth;
    info.voxel_size_m = 0.25 + random.range(0, 100);
    for (double& axis : info.origin_m) axis = random.range(-100'000, 100'000) * 0.5;
    info.extent = {random.range(2, size), random.range(1, size - 1), random.range(2, size)};
    info.depth = depth;
    info.level = level;
    const auto noise = [&](glm::ivec3 v, bool) {
      return random.chance(v.y < info.extent.y / 2 ? 0.95 : 0.05);
    };
    const Status status = VoxelizePredicate{info.extent, VoxelFunction(noise)}.run(memory.tree);
    EXPECT_TRUE(status.ok()) << status.what();
    info.octets = memory.tree.octets_used();
    // Any counts that a surface could have: the file does not extract it.
    const int corners = (info.extent.x - 1) * info.extent.y * (info.extent.z - 1);
    info.volumes = static_cast<std::uint32_t>(random.range(0, std::min(corners, 40)));
    info.patches = info.volumes * 2;
    make_keys(random);
    mask.assign((info.patches + 7) / 8, std::byte{0});
    for (std::uint32_t p = 0; p < info.patches; ++p) {
      if (!random.chance(0.7)) continue;
      mask[p / 8] |= static_cast<std::byte>(1u << p % 8);
      ++info.height_blocks;
    }
    samples.resize(info.height_blocks * static_cast<std::size_t>(patch_vertices(level)));
    for (std::int16_t& s : samples) s = static_cast<std::int16_t>(random.range(-28'000, 28'000));
    errors.resize(info.patches * level_error_values(level));
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const bool starts = i % static_cast<std::size_t>(level - 1) == 0;
      errors[i] = static_cast<std::uint16_t>(random.below(starts ? 65'536u : errors[i - 1] + 1u));
    }
    cones.resize(info.patches);
    for (NormalCone& cone : cones) cone.sine = static_cast<std::uint8_t>(random.below(256));
    bounds.resize(info.patches);
    for (PatchBounds& box : bounds) {
      for (int axis = 0; axis < 3; ++axis) {
        box.min[axis] = static_cast<std::int16_t>(random.range(-32'000, 32'000));
        box.max[axis] = static_cast<std::int16_t>(random.range(box.min[axis], 32'000));
      }
    }
    std::snprintf(info.name, sizeof info.name, "world %llu", static_cast<unsigned long long>(seed));
  }

  // Random ones of `count` layers, overrides of all patches, and `light_count` lights.
  void add_materials(std::uint32_t count, std::uint32_t side, TextureFormat format, int light_count,
                     std::uint64_t seed) {
    TestRandom random(seed);
    set.count = count;
    set.side = side;
    set.format = format;
    set.repeat_log2 = -3;
    for (std::uint32_t k = 0; k < count; ++k) {
      Material& material = set.materials[k];
      std::snprintf(material.name, sizeof material.name, "mat %u", k);
      material.slope_low = 0.01f * static_cast<float>(random.range(-100, 0));
      material.slope_high = 0.01f * static_cast<float>(random.range(0, 100));
      material.height_high = static_cast<float>(random.range(0, 500));
      material.cave = 0.01f * static_cast<float>(random.range(0, 100));
      for (float& channel : material.average) channel = 0.01f * static_cast<float>(random.range(1, 100));
      for (float& channel : material.tint) channel = 0.01f * static_cast<float>(random.range(0, 150));
      material.slope_span = 0.01f * static_cast<float>(random.range(1, 200));
    }
    textures.resize(texture_bytes(set));
    for (std::byte& b : textures) b = static_cast<std::byte>(random.below(256));
    overrides.resize(info.patches);
    for (std::uint8_t& b : overrides) b = static_cast<std::uint8_t>(random.below(count + 1));
    lights.resize(static_cast<std::size_t>(light_count));
    for (PointLight& light : lights) {
      light.position = {0.5f * static_cast<float>(random.range(0, 100)), 3, 4};
      light.radius = static_cast<float>(random.range(1, 20));
    }
  }

  // Random weights of the first materials; a fifth of the patches lie under it.
  void add_blend_map(std::uint32_t width, std::uint32_t depth, std::uint64_t seed) {
    TestRandom random(seed);
    set.blend_map = {width, depth, {}};
    for (std::uint32_t m = 0; m < 4 && m < set.count; ++m) {
      set.blend_map.materials[m] = static_cast<std::uint8_t>(m + 1);
    }
    blend_map.resize(std::size_t{width} * depth * kBlendTexelBytes);
    for (std::byte& b : blend_map) b = static_cast<std::byte>(random.below(64));
    for (std::uint8_t& b : overrides) b = random.chance(0.2) ? kPaintedByMap : b;
  }

  WorldPatches patches() const { return {keys, mask, samples, errors, bounds, cones}; }
  WorldMaterials materials() const {
    WorldMaterials result{set, textures, overrides, lights};
    result.blend_map = blend_map;
    return result;
  }

  std::vector<std::byte> bytes() const {
    const WorldWriter writer{info, &memory.tree, patches(), materials()};
    std::vector<std::byte> out;
    const Status status = write_world(writer, out);
    EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
    EXPECT_EQ(writer.file_bytes(), out.size());
    return out;
  }

 private:
  // Two patches in each of as many corners, drawn from all of them.
  void make_keys(TestRandom& random) {
    std::uint32_t wanted = info.volumes;
    std::uint32_t left =
        static_cast<std::uint32_t>((info.extent.x - 1) * info.extent.y * (info.extent.z - 1));
    for (int z = 1; z < info.extent.z; ++z) {
      for (int y = 1; y <= info.extent.y; ++y) {
        for (int x = 1; x < info.extent.x; ++x) {
          if (random.below(left--) >= wanted) continue;
          --wanted;
          const auto at = [](int v) { return static_cast<std::uint32_t>(v); };
          for (const std::uint32_t c : {0u, 1u}) keys.push_back(PatchKey::make(0, at(x), at(y), at(z), c));
        }
      }
    }
    std::sort(keys.begin(), keys.end());
  }
};

inline bool same_nodes(const Octree& a, Octree::Node na, const Octree& b, Octree::Node nb) {
  if (Octree::is_leaf(na) || Octree::is_leaf(nb)) return na == nb;
  for (int octant = 0; octant < 8; ++octant) {
    if (!same_nodes(a, a.child(na, octant), b, b.child(nb, octant))) return false;
  }
  return true;
}

}  // namespace karst::core
