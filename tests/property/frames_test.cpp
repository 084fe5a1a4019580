// SPDX-License-Identifier: MIT
// Frames by the million: levels and draw lists for random cameras over small random worlds, in all modes and
// with patches held at any level or not at all. No frame has a T-junction, and none calls the heap.
//
// The proof of a frame is in integers. Two patches that share an edge draw it as a chain of segments between
// vertices of the full level's grid, which is a function of the patch's level and of the edge's state; it is
// read from the index tables beforehand, as the set of the chain's vertices, one bit each. The two sets must
// be the same, one reversed. That vertices at the same place of an edge have the same bits, morphing or not,
// is Morph.SharedVerticesMoveAlike's to show.
//
// KARST_FRAMES sets how many frames; `ctest -C Long -L long` runs ten million, which takes a minute.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <vector>

#include <glm/common.hpp>

#include "terrain/draw/draw_list.h"
#include "terrain/draw/index_batches.h"
#include "terrain/lod/select_lod.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/surface/bezier/case_tables.h"
#include "tests/support/culled_view.h"
#include "tests/support/heap_count.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::Random;
using test::TestWorld;

// Vertices of an edge at the finest level that there is, without the last: bit t is place t of 2^kMaxLevel.
// Both ends are always drawn.
using Chain = std::uint64_t;
constexpr int kPlaces = 1 << kMaxLevel;

// By level, whether the neighbour is lower, and edge. forward: as the patch runs along its edge; backward: as
// its neighbour does.
struct Chains {
  Chain forward[kMaxLevel + 1][2][4] = {};
  Chain backward[kMaxLevel + 1][2][4] = {};
};

// Reads the chains from the triangles that the index tables draw. False where the segments on an edge are not
// one chain from corner to corner.
bool read_chains(Chains& chains) {
  std::vector<std::uint16_t> table(index_count(kMaxLevel));
  if (!build_index_tables(kMaxLevel, table).ok()) return false;
  for (int level = 1; level <= kMaxLevel; ++level) {
    std::vector<std::uint16_t> grid(static_cast<std::size_t>(patch_vertices(level)));
    if (!build_grid_order(level, grid).ok()) return false;
    const int side = patch_side(level);
    const int n = patch_cells(level);
    const int stride = kPlaces / n;
    // Place along an edge of grid vertex g, or -1 where it is not on it.
    const auto place = [&](int edge, int g) {
      const int i = g % side;
      const int j = g / side;
      const int on[4] = {j == 0 ? i : -1, i == n ? j : -1, j == n ? n - i : -1, i == 0 ? n - j : -1};
      return on[edge] < 0 ? -1 : on[edge] * stride;
    };
    for (unsigned lower = 0; lower < 16; ++lower) {
      IndexRange ranges[kMaxIndexRanges];
      const int used = index_ranges(level, lower, 0, ranges);
      for (int edge = 0; edge < 4; ++edge) {
        std::array<int, kPlaces + 1> next{};  // where the segment from a place leads; 0: none
        for (int r = 0; r < used; ++r) {
          for (std::uint32_t t = 0; t < ranges[r].count; t += 3) {
            for (std::uint32_t k = 0; k < 3; ++k) {
              const int a = place(edge, grid[table[ranges[r].first + t + k]]);
              const int b = place(edge, grid[table[ranges[r].first + t + (k + 1) % 3]]);
              if (a < 0 || b < 0) continue;
              if (b <= a || next[static_cast<std::size_t>(a)] != 0) return false;
              next[static_cast<std::size_t>(a)] = b;
            }
          }
        }
        Chain forward = 0;
        Chain backward = 0;
        int at = 0;
        while (at < kPlaces) {
          forward |= Chain{1} << at;
          if (at > 0) backward |= Chain{1} << (kPlaces - at);
          at = next[static_cast<std::size_t>(at)];
          if (at == 0) return false;
        }
        backward |= 1;
        const unsigned is_lower = level > 1 ? lower >> edge & 1u : 0u;
        Chain& known = chains.forward[level][is_lower][edge];
        if (known != 0 && known != forward) return false;  // edges do not depend on each other
        known = forward;
        chains.backward[level][is_lower][edge] = backward;
      }
    }
    for (int edge = 0; edge < 4 && level == 1; ++edge) {
      chains.forward[1][1][edge] = chains.forward[1][0][edge];
      chains.backward[1][1][edge] = chains.backward[1][0][edge];
    }
  }
  return true;
}

// A small world with made-up errors and boxes around its control points.
struct SmallWorld {
  explicit SmallWorld(Random& random)
      : level(1 + random.below(kMaxLevel)),
        world(TestWorld::noise(random.next(), {5, 5, 5}, 0.3 + 0.4 * random.unit(),
                               random.below(3) == 0 ? 0.0 : 2.0 + 2.0 * random.unit(), random.below(2) == 0)),
        patches(world.surface().patches.size()),
        bounds(patches),
        errors(patches * level_error_values(level)),
        lods(patches),
        nodes(BoundsTree::node_count(static_cast<std::uint32_t>(patches))),
        levels(patches, 99),
        scratch(patches),
        cut(patches),
        items(patches),
        drawn(patches) {
    const Surface surface = world.surface();
    const double roughness = std::exp2(12.0 * random.unit());
    for (PatchId p = 0; p < patches; ++p) {
      const Patch& patch = surface.patches[p];
      const PatchCase& shape = kCaseTable[surface.volume_of(p).configuration].patch[patch.case_patch];
      for (int axis = 0; axis < 3; ++axis) {
        int low = 0;
        int high = 0;
        for (const auto& row : shape.control) {
          for (const auto& c : row) {
            low = std::min(low, c[static_cast<std::size_t>(axis)] * kStepsPerHalfVoxel);
            high = std::max(high, c[static_cast<std::size_t>(axis)] * kStepsPerHalfVoxel);
          }
        }
        bounds[p].min[axis] = static_cast<std::int16_t>(low - random.below(3000));
        bounds[p].max[axis] = static_cast<std::int16_t>(high + random.below(3000));
      }
      // Errors and reaches that fall with the level; some patches are flat from a level on.
      std::uint16_t* const row = errors.data() + p * level_error_values(level);
      double error = roughness * random.unit();
      for (int j = 1; j < level; ++j) {
        row[j - 1] = static_cast<std::uint16_t>(error);
        row[level - 1 + j - 1] = static_cast<std::uint16_t>(9'000 >> j);
        error *= random.below(8) == 0 ? 0.0 : 0.2 + 0.8 * random.unit();
      }
    }
    tree.create(nodes);
    EXPECT_TRUE(tree.build(surface, bounds).ok());
    culled.emplace(surface, bounds);
    for (auto& held : residents) {
      held.resize(patches);
      const double missing = random.below(2) == 0 ? 0.0 : 0.2 * random.unit();
      const double full = random.unit();
      for (std::uint8_t& r : held) {
        r = static_cast<std::uint8_t>(random.unit() < full ? level : 1 + random.below(level));
        if (random.unit() < missing) r = 0;
      }
    }
  }

  int level;
  TestWorld world;
  std::size_t patches;
  std::vector<PatchBounds> bounds;
  std::vector<std::uint16_t> errors;
  std::vector<PatchLod> lods;
  std::vector<LatticeBox> nodes;
  BoundsTree tree;
  std::optional<test::CulledView> culled;
  std::vector<std::uint8_t> levels;
  std::vector<std::uint32_t> scratch;
  std::vector<PatchId> cut;
  std::vector<DrawItem> items;
  std::vector<const DrawItem*> drawn;  // by patch; null: not listed
  std::array<std::vector<std::uint8_t>, 8> residents;
};

struct Totals {
  std::uint64_t edges = 0;
  std::uint64_t between_levels = 0;
  std::uint64_t capped = 0;
  std::uint64_t lowered = 0;
  std::uint64_t items = 0;
};

// Draws one frame's list and proves it.
bool prove_frame(SmallWorld& w, const SelectLod& select, BuildDrawList& build, const Chains& chains,
                 Totals& totals) {
  const SelectLod::Result selected = select.run();
  BuildDrawList::Result listed;
  if (!build.run(listed).ok()) return false;
  totals.capped += selected.capped;
  totals.lowered += selected.lowered;
  totals.items += listed.drawn;
  std::fill(w.drawn.begin(), w.drawn.end(), nullptr);
  for (std::uint32_t n = 0; n < listed.drawn; ++n) w.drawn[w.items[n].patch] = &w.items[n];
  for (std::uint32_t n = 0; n < listed.drawn; ++n) {
    const DrawItem& item = w.items[n];
    if (item.level < 1 || item.level > w.level) return false;
    if (!select.resident.empty() && item.level > select.resident[item.patch]) return false;
    for (int e = 0; e < 4; ++e) {
      const PatchEdge other = build.surface.patches[item.patch].neighbour[e];
      if (!other.exists() || w.drawn[other.patch()] == nullptr) continue;
      const DrawItem& beside = *w.drawn[other.patch()];
      const Chain mine = chains.forward[item.level][item.lower_edges >> e & 1][e];
      const Chain theirs =
          chains.backward[beside.level][beside.lower_edges >> other.edge() & 1][other.edge()];
      if (mine != theirs) return false;
      ++totals.edges;
      totals.between_levels += item.level != beside.level ? 1u : 0u;
    }
  }
  return true;
}

std::uint64_t frames_wanted() {
  const char* const text = std::getenv("KARST_FRAMES");
  return text == nullptr ? 300'000 : std::strtoull(text, nullptr, 10);
}

TEST(Frames, NoneHasATJunctionOrCallsTheHeap) {
  Chains chains;
  ASSERT_TRUE(read_chains(chains));
  Random random{401};
  Totals totals;
  const std::uint64_t wanted = frames_wanted();
  constexpr std::uint64_t kFramesAWorld = 5'000;
  std::uint64_t frame = 0;
  std::size_t patches = 0;
  std::size_t worlds = 0;
  while (frame < wanted) {
    SmallWorld w(random);
    patches += w.patches;
    ++worlds;
    Camera camera;
    CameraSettings settings;
    Frustum frustum;
    SelectLod select;
    select.camera = &camera;
    select.surface = w.world.surface();
    select.bounds = w.bounds;
    select.tree = &w.tree;
    select.lods = w.lods;
    select.errors = {w.level, w.errors};
    select.levels = w.levels;
    select.cut = w.cut;
    SetThresholds set;
    set.surface = select.surface;
    set.bounds = w.bounds;
    set.errors = select.errors;
    set.lods = w.lods;
    BuildDrawList build;
    build.boxes = w.culled->boxes();
    build.surface = select.surface;
    build.levels = w.levels;
    build.scratch = w.scratch;
    build.items = w.items;
    const std::uint64_t heap = test::heap_calls();
    for (std::uint64_t n = 0; n < kFramesAWorld && frame < wanted; ++n, ++frame) {
      if (n % 16 == 0) {
        settings.fov_y_deg = 20 + 100 * random.unit();
        settings.aspect = 0.4 + 2.2 * random.unit();
        settings.near_voxels = std::exp2(-9.0 + 7.0 * random.unit());
        select.settings.mode = n % 5 == 0 ? LodMode::distance : n % 7 == 0 ? LodMode::full : LodMode::error;
        select.settings.error_px = std::exp2(-3.0 + 9.0 * random.unit());
        select.settings.distance_voxels = std::exp2(6.0 * random.unit());
        select.settings.max_level = random.below(4) == 0 ? 1 + random.below(w.level) : w.level;
        select.settings.resident_level = w.level;
        if (!make_camera(settings, camera).ok()) FAIL();
        select.scale = make_error_scale(camera, 200 + random.below(2000), 200 + random.below(2000),
                                        select.settings.error_px);
        set.scale = select.scale;
        set.morphing = select.settings.mode == LodMode::error;
        set.max_level = select.settings.top_level();
        set.run();
      }
      for (int axis = 0; axis < 3; ++axis) settings.position[axis] = 2.5 + 9.0 * (random.unit() - 0.5);
      settings.yaw_deg = 360 * random.unit();
      settings.pitch_deg = 180 * random.unit() - 90;
      if (!make_camera(settings, camera).ok()) FAIL();
      frustum = make_frustum(camera);
      build.camera = &camera;
      build.culled = select.culled = w.culled->find(random.below(4) != 0 ? &frustum : nullptr, w.tree);
      const auto held = static_cast<std::size_t>(random.below(2 * static_cast<int>(w.residents.size())));
      select.resident = {};
      if (held < w.residents.size()) select.resident = w.residents[held];
      if (n < 20 && (!select.validate().ok() || !build.validate().ok() || !set.validate().ok())) FAIL();
      ASSERT_TRUE(prove_frame(w, select, build, chains, totals)) << "frame " << frame;
    }
    ASSERT_EQ(test::heap_calls(), heap);
  }
  std::printf(
      "%llu frames over %zu worlds of %zu patches on average, %llu items; %llu edges proved, %llu of them "
      "between levels; %llu patches capped, %llu lowered\n",
      static_cast<unsigned long long>(frame), worlds, patches / worlds,
      static_cast<unsigned long long>(totals.items), static_cast<unsigned long long>(totals.edges),
      static_cast<unsigned long long>(totals.between_levels), static_cast<unsigned long long>(totals.capped),
      static_cast<unsigned long long>(totals.lowered));
  EXPECT_GT(totals.between_levels, wanted);
  EXPECT_GT(totals.capped, wanted);
  EXPECT_GT(totals.lowered, wanted / 4);
}

}  // namespace
}  // namespace karst::core
