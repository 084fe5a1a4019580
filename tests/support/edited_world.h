// SPDX-License-Identifier: MIT
// A world that is edited in memory of its own, and what it is compared with: itself saved, loaded and
// measured from scratch.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/edit/save_world.h"
#include "terrain/edit/settle.h"
#include "terrain/edit/shape/edit_shape.h"
#include "terrain/measure/measure_patches.h"
#include "terrain/world/terrain_parts.h"
#include "tests/support/test_world.h"

namespace karst::test {

// Does all that edits left for later.
inline void settle(core::World& world) {
  for (Settled done; !world.is_settled();) settle_some(world, done);
}

// One that is loaded. edit_patches 0: the least that holds it. octets: of room beyond those of the file; 0:
// as many as go with the patches.
class LoadedWorld : public TerrainParts {
 public:
  explicit LoadedWorld(std::vector<std::byte> bytes, std::uint32_t edit_patches = 0, std::uint32_t octets = 0)
      : file_(std::move(bytes)) {
    WorldReader reader;
    EXPECT_TRUE(reader.open(ByteSource::of(file_)).ok());
    Config config = core::World::config_for(reader.info(), reader.info().level, reader.ground());
    if (edit_patches > 0) core::World::add_edit_room(edit_patches, config);
    if (octets > 0) config.max_octets = reader.info().octets + octets;
    memory_ = AlignedBytes(static_cast<std::size_t>(terrain_budget(config).cpu_bytes()));
    Status status = create(config, memory_.bytes());
    if (status.ok()) status = load(ByteSource::of(file_));
    EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  }

  // Once all that edits left for later is done.
  std::vector<std::byte> save() {
    settle(world);
    std::vector<std::byte> out;
    std::vector<PatchId> room(world.patch_count());
    const auto append = [&](std::span<const std::byte> bytes) {
      out.insert(out.end(), bytes.begin(), bytes.end());
      return true;
    };
    const Status status = SaveWorld{&world, nullptr, room}.run(ByteSink::to(append));
    EXPECT_TRUE(status.ok()) << status.what();
    return out;
  }

 private:
  std::vector<std::byte> file_;
  AlignedBytes memory_{0};
};

// All that belongs to a patch, without its slot.
struct PatchFacts {
  std::vector<std::byte> bytes;

  template <class T>
  void add(const T& value) {
    const auto* from = reinterpret_cast<const std::byte*>(&value);
    bytes.insert(bytes.end(), from, from + sizeof value);
  }
  bool operator==(const PatchFacts&) const = default;
};

using AllFacts = std::map<PatchKey, PatchFacts>;

// Of a part of a world; measures: of its patches.
inline void add_facts_of(const core::World& world, std::size_t part, const PatchMeasures& measures,
                         AllFacts& all) {
  const Surface surface = world.parts()[part].surface;
  const Heights heights = world.heights();
  const auto region = static_cast<std::uint32_t>(part);
  const auto values = level_error_values(heights.level);
  for (PatchId p = 0; p < surface.patches.size(); ++p) {
    if (surface.is_free(p)) continue;
    const Patch& patch = surface.patches[p];
    PatchFacts facts;
    const Volume& volume = surface.volume_of(p);
    facts.add(volume.configuration);
    facts.add(volume.patch_count);
    facts.add(volume.gradient);
    facts.add(patch.collapsed);
    facts.add(patch.size_log2);
    for (const PatchEdge edge : patch.neighbour) {
      facts.add(edge.exists() ? key_of(surface, edge.patch()).bits() : ~std::uint64_t{0});
      facts.add(edge.exists() ? edge.edge() : -1);
    }
    facts.add(patch.height_block != kNoHeights);
    for (int v = 0; v < patch_vertices(heights.level) && patch.height_block != kNoHeights; ++v)
      facts.add(heights.block(patch.height_block)[v]);
    facts.add(measures.bounds[p]);
    facts.add(measures.cones[p]);
    facts.add(measures.shading_cones[p]);
    for (const std::uint16_t value : measures.level_errors.subspan(p * values, values)) facts.add(value);
    all[key_of(surface, p, region)] = facts;
  }
}

// As it holds them.
inline AllFacts facts_of(const core::World& world) {
  const auto copy = [](auto from) {
    return std::vector<std::remove_const_t<typename decltype(from)::element_type>>(from.begin(), from.end());
  };
  AllFacts all;
  for (std::size_t n = 0; n < world.parts().size(); ++n) {
    const WorldPart& part = world.parts()[n];
    auto errors = copy(part.level_errors.values);
    auto bounds = copy(part.bounds);
    auto cones = copy(part.cones);
    auto shading = copy(part.shading_cones);
    add_facts_of(world, n, {errors, bounds, cones, shading}, all);
  }
  return all;
}

// All patches of a part from scratch.
inline void measure_all(const core::World& world, std::size_t part, const PatchMeasures& out) {
  const Surface surface = world.parts()[part].surface;
  const std::size_t patches = surface.patches.size();
  std::vector<BorderErrors> borders(patches);
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(world.info().level)));
  const TestScratch scratch;
  const MeasurePatches measure{surface, world.heights(), {}, borders, out};
  EXPECT_TRUE(measure.validate().ok());
  measure.measure(0, patches, {scratch.get(), vertices});
  measure.join(0, patches);
}

// As they are measured from scratch.
inline AllFacts measured_facts_of(const core::World& world) {
  AllFacts all;
  for (std::size_t n = 0; n < world.parts().size(); ++n) {
    const std::size_t patches = world.parts()[n].surface.patches.size();
    std::vector<std::uint16_t> errors(patches * level_error_values(world.info().level));
    std::vector<PatchBounds> bounds(patches);
    std::vector<NormalCone> cones(patches), shading(patches);
    const PatchMeasures out{errors, bounds, cones, shading};
    measure_all(world, n, out);
    add_facts_of(world, n, out, all);
  }
  return all;
}

// All of a part that is not of single patches.
inline void expect_same_part(const WorldPart& a, const WorldPart& b) {
  ASSERT_EQ(a.octree->octets_used(), b.octree->octets_used());
  ASSERT_TRUE(std::ranges::equal(a.sky->cells(), b.sky->cells()));
  const Occluders& rock = *a.occluders;
  ASSERT_EQ(rock.size(), b.occluders->size());
  ASSERT_EQ(rock.interior().min, b.occluders->interior().min);
  ASSERT_EQ(rock.interior().max, b.occluders->interior().max);
  for (const auto kind : {Occluders::Kind::rock, Occluders::Kind::air})
    ASSERT_EQ(rock.count(kind), b.occluders->count(kind));
  for (int y = 0; y < rock.size().y; ++y) {
    for (int z = 0; z < rock.size().z; ++z) {
      for (int x = 0; x < rock.size().x; ++x) {
        const glm::ivec3 cell(x, y, z);
        ASSERT_EQ(rock.is_rock(cell), b.occluders->is_rock(cell));
        ASSERT_EQ(rock.covers(Occluders::Kind::air, 0, x, {y, z}, {y, z}),
                  b.occluders->covers(Occluders::Kind::air, 0, x, {y, z}, {y, z}));
      }
    }
  }
  ASSERT_EQ(a.rim->edges().size(), b.rim->edges().size());
  ASSERT_EQ(a.rim->columns(), b.rim->columns());
  for (std::size_t n = 0; n < a.rim->edges().size(); ++n) {
    const RegionRim::Edge &own = a.rim->edges()[n], &other = b.rim->edges()[n];
    ASSERT_EQ(key_of(a.surface, own.edge.patch()), key_of(b.surface, other.edge.patch()));
    ASSERT_EQ(own.edge.edge(), other.edge.edge());
    ASSERT_EQ(own.from, other.from);
    ASSERT_EQ(own.to, other.to);
  }
  for (std::uint32_t column = 0; column < a.rim->columns(); ++column)
    ASSERT_EQ(a.rim->mark(column), b.rim->mark(column));
  // The tree's boxes hold what lies below them, and nothing else.
  const BoundsTree& tree = *a.tree;
  ASSERT_EQ(tree.longest_diagonal(), b.tree->longest_diagonal());
  for (std::uint32_t n = 0; n < tree.nodes(0); ++n) {
    LatticeBox box{glm::ivec3(INT32_MAX), glm::ivec3(INT32_MIN)};
    for (PatchId p = tree.first_patch(0, n); p < tree.first_patch(0, n) + tree.patch_count(0, n); ++p) {
      const PatchBoxes& boxes = a.boxes[n];
      const bool free = a.surface.is_free(p);
      ASSERT_EQ((boxes.free >> p % 8 & 1u) != 0, free);
      if (free) continue;
      const LatticeBox own = patch_box(a.surface, a.bounds, p);
      ASSERT_EQ(boxes.box(p % 8).min, own.min);
      ASSERT_EQ(boxes.box(p % 8).max, own.max);
      box = {glm::min(box.min, own.min), glm::max(box.max, own.max)};
    }
    if (box.min.x > box.max.x) {
      ASSERT_TRUE(is_nowhere(tree.node(0, n)));
    } else {
      ASSERT_EQ(tree.node(0, n).min, box.min);
      ASSERT_EQ(tree.node(0, n).max, box.max);
    }
  }
}

// Live against saved, loaded and measured, once it is settled: by key, to the bit.
inline void expect_as_loaded(LoadedWorld& live) {
  const std::vector<std::byte> saved = live.save();
  LoadedWorld fresh(saved);
  const core::World& a = live.world;
  const core::World& b = fresh.world;
  ASSERT_EQ(a.parts().size(), b.parts().size());
  ASSERT_EQ(a.patch_count() - a.free_patches(), b.patch_count());
  const auto loaded = facts_of(b);
  ASSERT_TRUE(facts_of(a) == loaded);
  ASSERT_TRUE(measured_facts_of(b) == loaded);
  ASSERT_TRUE(fresh.save() == saved);
  for (std::size_t n = 0; n < a.parts().size(); ++n) {
    expect_same_part(a.parts()[n], b.parts()[n]);
    if (testing::Test::HasFatalFailure()) return;
  }
}

// A random edit of voxels in a world of so many.
inline core::Edit random_voxel_edit(Random& random, glm::ivec3 extent, int depth) {
  core::Edit edit;
  const auto place = [&] {
    return glm::dvec3(extent) * glm::dvec3(random.unit(), random.unit(), random.unit());
  };
  edit.tool = random.below(2) == 0 ? core::EditTool::clear : core::EditTool::fill;
  edit.shape = static_cast<core::BrushShape>(random.below(4));
  edit.octree_level = static_cast<std::uint8_t>(depth - random.below(3));
  edit.place = place();
  edit.to = edit.place + 4.0 * (glm::dvec3(random.unit(), random.unit(), random.unit()) - 0.5);
  edit.half = glm::dvec3(random.unit(), random.unit(), random.unit()) * 2.0;
  edit.radius = 0.3 + 2 * random.unit();
  return edit;
}

// And of heights.
inline core::Edit random_heights_edit(Random& random, glm::ivec3 extent) {
  core::Edit edit = random_voxel_edit(random, extent, 0);
  edit.octree_level = 0;
  edit.tool = static_cast<core::EditTool>(static_cast<int>(core::EditTool::extrude) + random.below(5));
  edit.shape = static_cast<core::BrushShape>(1 + random.below(4));
  edit.half += 0.1;
  edit.up = glm::dvec3(random.unit(), random.unit(), random.unit()) - 0.4;
  edit.strength = 2 * random.unit() - 1;
  edit.amount = random.unit();
  edit.hardness = random.unit();
  edit.wave = 0.3 + 3 * random.unit();
  edit.seed = static_cast<std::uint32_t>(random.next());
  return edit;
}

}  // namespace karst::test
