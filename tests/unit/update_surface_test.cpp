// SPDX-License-Identifier: MIT
// Random edits of voxels, one after another: what is still there keeps its slot, and the surface is that of a
// fresh extraction of everything but for the slots.
#include "terrain/surface/bezier/update_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <map>
#include <vector>

#include <glm/common.hpp>

#include "terrain/surface/bezier/extract_surface.h"
#include "tests/support/heap_count.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

// A surface extracted anew, with memory of its own.
struct Extracted {
  std::vector<Volume> volumes;
  std::vector<Patch> patches;

  explicit Extracted(const Octree& octree, glm::ivec3 extent, CornerBox box = {{0, 0, 0}, {512, 512, 512}}) {
    ExtractSurface extract;
    extract.octree = &octree;
    extract.extent = extent;
    extract.low = box.low;
    extract.high = box.high;
    ExtractSurface::Result made;
    EXPECT_TRUE(extract.count(made).ok());
    volumes.resize(made.volumes);
    patches.resize(made.patches);
    std::vector<std::uint32_t> scratch(ExtractSurface::scratch_size(made.volumes));
    extract.volumes = volumes;
    extract.patches = patches;
    extract.scratch = scratch;
    EXPECT_TRUE(extract.run(made).ok());
  }

  Surface surface() const { return {volumes, patches}; }
};

// A world whose patches have slots, with room to grow.
struct Edited {
  test::TestWorld world;
  glm::ivec3 extent;
  Octree& octree;
  std::vector<Volume> volumes;
  std::vector<Patch> patches;
  std::vector<std::uint64_t> keys;
  std::vector<std::uint32_t> entries;
  PatchTable table;
  SurfaceSlots slots;
  std::vector<PatchChange> changes;

  Edited(test::TestWorld w, std::uint32_t max_volumes, std::uint32_t max_patches)
      : world(std::move(w)),
        extent(world.extent()),
        octree(world.octree()),
        volumes(max_volumes),
        patches(max_patches),
        keys(max_patches),
        entries(PatchTable::entry_count(max_patches)),
        changes(2 * max_patches) {
    table.create({keys, entries});
    slots.create(volumes, patches, &table);
    const Surface s = world.surface();
    std::copy(s.volumes.begin(), s.volumes.end(), volumes.begin());
    std::copy(s.patches.begin(), s.patches.end(), patches.begin());
    slots.adopt(static_cast<std::uint32_t>(s.volumes.size()), static_cast<std::uint32_t>(s.patches.size()));
    // As a loader does: heights by slot.
    for (PatchId p = 0; p < s.patches.size(); ++p) patches[p].height_block = 1'000 + p;
  }

  Status update(CornerBox box, UpdateSurface::Result& result) {
    const Extracted fresh(octree, extent, box);
    const UpdateSurface update{fresh.surface(), box, &slots, changes};
    const std::size_t before = test::heap_calls();
    const Status status = update.run(result);
    EXPECT_EQ(test::heap_calls(), before);
    return status;
  }
};

bool same_volume(const Volume& a, const Volume& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

// Slot by slot against an extraction of everything: volumes, patches, neighbours, nothing else.
void expect_fresh(const Edited& edited) {
  const Extracted fresh(edited.octree, edited.extent);
  const Surface now = edited.slots.surface();
  ASSERT_EQ(edited.table.size(), fresh.patches.size());
  ASSERT_EQ(edited.slots.volume_count(), fresh.volumes.size());
  const auto slot_of = [&](PatchId number) { return edited.table.find(key_of(fresh.surface(), number)); };
  for (PatchId p = 0; p < fresh.patches.size(); ++p) {
    const PatchId slot = slot_of(p);
    ASSERT_NE(slot, PatchTable::kNone);
    ASSERT_TRUE(same_volume(now.volume_of(slot), fresh.surface().volume_of(p)));
    const Patch& a = now.patches[slot];
    const Patch& b = fresh.patches[p];
    ASSERT_EQ(a.case_patch, b.case_patch);
    ASSERT_EQ(a.collapsed, b.collapsed);
    ASSERT_EQ(a.size_log2, b.size_log2);
    for (int e = 0; e < 4; ++e) {
      const PatchEdge n = b.neighbour[e];
      const PatchEdge wanted = n.exists() ? PatchEdge::make(slot_of(n.patch()), n.edge()) : PatchEdge();
      ASSERT_EQ(a.neighbour[e], wanted);
    }
  }
  std::size_t used_volumes = 0;
  for (const Volume& v : now.volumes) used_volumes += v.patch_count > 0 ? 1u : 0u;
  EXPECT_EQ(used_volumes, fresh.volumes.size());
  for (PatchId slot = 0; slot < now.patches.size(); ++slot)
    EXPECT_EQ(now.patches[slot].volume == kNoVolume, !edited.table.is_used(slot));
}

using Held = std::map<PatchKey, std::pair<PatchId, std::uint32_t>>;

Held held(const Edited& edited) {
  Held all;
  edited.table.for_each([&](PatchId slot, PatchKey key) {
    all[key] = {slot, edited.slots.surface().patches[slot].height_block};
  });
  return all;
}

// Whoever was there and is there has the same slot and the same heights; changes tell the rest.
void expect_kept(const Held& before, const Edited& edited, const UpdateSurface::Result& result) {
  std::map<PatchId, PatchChange::Kind> last;
  std::uint32_t appeared = 0;
  std::uint32_t vanished = 0;
  for (std::uint32_t i = 0; i < result.changes; ++i) {
    const PatchChange change = edited.changes[i];
    appeared += change.kind == PatchChange::appeared ? 1u : 0u;
    vanished += change.kind == PatchChange::vanished ? 1u : 0u;
    last[change.slot] = change.kind;
  }
  EXPECT_EQ(appeared, result.appeared);
  EXPECT_EQ(vanished, result.vanished);
  const Held now = held(edited);
  std::uint32_t gone = 0;
  for (const auto& [key, had] : before) gone += now.count(key) == 0 ? 1u : 0u;
  std::uint32_t come = 0;
  for (const auto& [key, has] : now) {
    const auto old = before.find(key);
    if (old != before.end()) {
      ASSERT_EQ(has, old->second);
      continue;
    }
    ++come;
    EXPECT_EQ(has.second, kNoHeights);
    ASSERT_EQ(last.count(has.first), 1u);
    EXPECT_EQ(last[has.first], PatchChange::appeared);
  }
  EXPECT_EQ(gone, vanished);
  EXPECT_EQ(come, appeared);
}

TEST(UpdateSurface, AThousandEdits) {
  test::Random random{41};
  std::uint64_t kept = 0, appeared = 0, vanished = 0;
  for (int round = 0; round < 20; ++round) {
    const glm::ivec3 extent(6 + random.below(14), 5 + random.below(12), 6 + random.below(14));
    const auto corners = static_cast<std::uint32_t>((extent.x - 1) * extent.y * (extent.z - 1));
    Edited edited(test::TestWorld::noise(random.next(), extent, 0.45, round % 3 == 0 ? 0.0 : 5.0, false),
                  corners, 4 * corners);
    expect_fresh(edited);
    for (int edit = 0; edit < 50; ++edit) {
      // One voxel, or a box of some.
      const glm::ivec3 voxel(random.below(extent.x), random.below(extent.y), random.below(extent.z));
      const int size = random.below(3) == 0 ? 3 : 1;
      const glm::ivec3 last = glm::min(voxel + size - 1, extent - 1);
      const bool fill = random.below(2) == 0;
      for (int z = voxel.z; z <= last.z; ++z) {
        for (int y = voxel.y; y <= last.y; ++y) {
          for (int x = voxel.x; x <= last.x; ++x)
            ASSERT_TRUE(edited.octree.set({x, y, z}, edited.octree.depth(), fill).ok());
        }
      }
      const Held before = held(edited);
      // Every fifth time all of the surface is made anew.
      const CornerBox box =
          edit % 5 == 0 ? CornerBox{{0, 0, 0}, {512, 512, 512}} : corners_touched(voxel, last);
      UpdateSurface::Result result;
      const Status status = edited.update(box, result);
      ASSERT_TRUE(status.ok()) << status.field();
      expect_kept(before, edited, result);
      expect_fresh(edited);
      if (testing::Test::HasFatalFailure()) return;
      kept += result.kept;
      appeared += result.appeared;
      vanished += result.vanished;
    }
    // Nothing leaks: emptied, all slots can be handed out again.
    ASSERT_TRUE(edited.octree.set({0, 0, 0}, 0, false).ok());
    UpdateSurface::Result result;
    ASSERT_TRUE(edited.update({{0, 0, 0}, {512, 512, 512}}, result).ok());
    EXPECT_EQ(edited.table.size(), 0u);
    EXPECT_EQ(edited.slots.volume_count(), 0u);
    PatchId slot = 0;
    for (std::uint32_t i = 0; i < edited.table.capacity(); ++i)
      ASSERT_TRUE(edited.table.take(PatchKey::from_bits(i), slot).ok());
    EXPECT_FALSE(edited.table.take(PatchKey::from_bits(99'999'999), slot).ok());
  }
  std::printf("%llu patches kept, %llu appeared, %llu vanished\n", static_cast<unsigned long long>(kept),
              static_cast<unsigned long long>(appeared), static_cast<unsigned long long>(vanished));
  EXPECT_GT(kept, 100'000u);
  EXPECT_GT(appeared, 3'000u);
  EXPECT_GT(vanished, 3'000u);
}

// What has no room leaves everything as it was.
TEST(UpdateSurface, NamesTheLimitAndChangesNothing) {
  const glm::ivec3 extent(10, 8, 10);
  const auto flat = [](glm::ivec3 v) { return v.y < 3; };
  const test::TestWorld probe(extent, flat);
  const auto volumes = static_cast<std::uint32_t>(probe.surface().volumes.size());
  const auto patches = static_cast<std::uint32_t>(probe.surface().patches.size());
  const struct {
    std::uint32_t volumes, patches, changes;
    const char* field;
  } cases[] = {{volumes, patches + 100, 1'000, "max_volumes"},
               {volumes + 100, patches, 1'000, "max_patches"},
               {volumes + 100, patches + 100, 3, "changes"}};
  for (const auto& c : cases) {
    Edited edited(test::TestWorld(extent, flat), c.volumes, c.patches);
    const Held before = held(edited);
    // A tower two voxels high.
    for (const int y : {3, 4}) ASSERT_TRUE(edited.octree.set({5, y, 5}, edited.octree.depth(), true).ok());
    const CornerBox box = corners_touched({5, 3, 5}, {5, 4, 5});
    const Extracted fresh(edited.octree, extent, box);
    UpdateSurface::Result result;
    const UpdateSurface update{fresh.surface(), box, &edited.slots,
                               std::span(edited.changes).first(std::min<std::size_t>(c.changes, 50))};
    const Status status = update.run(result);
    EXPECT_EQ(status.code(), StatusCode::limit_reached);
    EXPECT_STREQ(status.field(), c.field);
    EXPECT_GT(status.value(), 0u);
    EXPECT_EQ(held(edited), before);
    EXPECT_EQ(result.changes, 0u);
  }
}

// Extraction of a box makes what extraction of everything makes there.
TEST(ExtractSurface, ABoxIsAPartOfTheWhole) {
  test::Random random{43};
  for (int round = 0; round < 50; ++round) {
    const glm::ivec3 extent(12, 10, 14);
    const test::TestWorld world = test::TestWorld::noise(random.next(), extent, 0.5, 4.0, false);
    const glm::ivec3 low(random.below(14) - 2, random.below(12) - 2, random.below(14) - 2);
    const CornerBox box{low, low + glm::ivec3(random.below(9), random.below(9), random.below(9))};
    const Extracted part(world.octree(), extent, box);
    std::vector<Volume> wanted;
    for (const Volume& v : world.surface().volumes) {
      bool in = true;
      for (int axis = 0; axis < 3; ++axis)
        in = in && v.corner[axis] >= box.low[axis] && v.corner[axis] <= box.high[axis];
      if (in) wanted.push_back(v);
    }
    ASSERT_EQ(part.volumes.size(), wanted.size());
    EXPECT_TRUE(std::equal(wanted.begin(), wanted.end(), part.volumes.begin(), same_volume));
  }
}

}  // namespace
}  // namespace karst::core
