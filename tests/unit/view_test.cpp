// SPDX-License-Identifier: MIT
// The draw list and its index stream: what is listed, in which order, with which edges, and in how many
// chunks.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "terrain/draw/draw_list.h"
#include "terrain/draw/expand_indices.h"
#include "terrain/draw/index_batches.h"
#include "terrain/lod/select_lod.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/view/camera.h"
#include "tests/support/culled_view.h"
#include "tests/support/grid_surface.h"
#include "tests/support/tree_memory.h"

namespace karst::core {
namespace {

// A grid with levels chosen for a camera in its middle, and a draw list over it.
class View : public testing::Test {
 protected:
  View()
      : grid_(grid_with_a_point()),
        culled_(grid_.surface(), grid_.bounds),
        levels_(grid_.patches.size()),
        scratch_(levels_.size()) {
    CameraSettings s;
    s.position = {20.0, 25.0, 38.0};
    s.pitch_deg = -20.0;
    EXPECT_TRUE(make_camera(s, camera_).ok());
    frustum_ = make_frustum(camera_);
    items_.resize(levels_.size());
    SelectLod select;
    select.settings.mode = LodMode::distance;
    select.camera = &camera_;
    select.surface = grid_.surface();
    select.bounds = grid_.bounds;
    select.tree = &grid_.tree;
    select.levels = levels_;
    select.settings.distance_voxels = 60.0;
    EXPECT_TRUE(select.validate().ok());
    select.run();
  }

  static GridSurface grid_with_a_point() {
    GridSurface grid = make_grid_surface(40, 40, 1.0, 5);
    grid.patches[3].collapsed = 1;
    grid.patches[3].neighbour[3] = {};
    return grid;
  }

  BuildDrawList stage() {
    BuildDrawList result;
    result.boxes = culled_.boxes();
    result.culled = culled_.find(&frustum_, grid_.tree);
    result.camera = &camera_;
    result.surface = grid_.surface();
    result.levels = levels_;
    result.scratch = scratch_;
    result.items = items_;
    return result;
  }

  float distance(PatchId id) const {
    return glm::distance(glm::vec3(patch_origin(grid_.volumes[id])), glm::vec3(eye_lattice(camera_)));
  }

  GridSurface grid_;
  test::CulledView culled_;
  Camera camera_;
  Frustum frustum_;
  std::vector<std::uint8_t> levels_;
  std::vector<std::uint32_t> scratch_;
  std::vector<DrawItem> items_;
};

TEST_F(View, ListsEveryPatchWithItsEdges) {
  BuildDrawList build = stage();
  build.culled = {};
  ASSERT_TRUE(build.validate().ok());
  BuildDrawList::Result result;
  ASSERT_TRUE(build.run(result).ok());
  ASSERT_EQ(result.drawn, grid_.patches.size());
  EXPECT_EQ(result.culled_frustum, 0u);
  std::vector<int> listed(grid_.patches.size(), 0);
  std::uint32_t triangles = 0;
  int lower_seen = 0;
  for (const DrawItem& item : items_) {
    ++listed[item.patch];
    EXPECT_EQ(item.level, levels_[item.patch]);
    for (int e = 0; e < 4; ++e) {
      const PatchEdge other = grid_.patches[item.patch].neighbour[e];
      const bool lower = other.exists() && levels_[other.patch()] == item.level - 1;
      EXPECT_EQ((item.lower_edges >> e & 1) != 0, lower);
      lower_seen += lower ? 1 : 0;
    }
    EXPECT_EQ(item.skipped_edges, item.patch == 3 ? 0b1000 : 0);
    triangles += patch_index_count(item.level, item.lower_edges, item.skipped_edges) / 3;
  }
  EXPECT_EQ(*std::min_element(listed.begin(), listed.end()), 1);
  EXPECT_EQ(*std::max_element(listed.begin(), listed.end()), 1);
  EXPECT_GT(lower_seen, 50);
  EXPECT_EQ(result.triangles, triangles);
  std::uint32_t at_levels = 0;
  for (int level = 1; level <= kMaxLevel; ++level) {
    EXPECT_EQ(result.at_level[level], std::count(levels_.begin(), levels_.end(), level));
    at_levels += result.at_level[level];
  }
  EXPECT_EQ(at_levels, result.drawn);
}

TEST_F(View, NearestComeFirst) {
  BuildDrawList::Result result;
  ASSERT_TRUE(stage().run(result).ok());
  ASSERT_GT(result.drawn, 300u);
  ASSERT_GT(result.culled_frustum, 300u);
  for (std::uint32_t n = 1; n < result.drawn; ++n) {
    const float before = distance(items_[n - 1].patch);
    const float here = distance(items_[n].patch);
    EXPECT_GT(here, before / 1.07f) << "out of order by more than a band's width";
  }
  // The same inputs give the same list.
  const std::vector<DrawItem> first = items_;
  std::fill(scratch_.begin(), scratch_.end(), 0xdeadbeefu);
  ASSERT_TRUE(stage().run(result).ok());
  EXPECT_EQ(first, items_);
}

TEST_F(View, LevelZeroIsNotDrawnAndCountsAsTheSameLevel) {
  BuildDrawList::Result whole;
  ASSERT_TRUE(stage().run(whole).ok());
  const DrawItem before = *std::find_if(items_.begin(), items_.begin() + whole.drawn,
                                        [](const DrawItem& item) { return item.lower_edges != 0; });
  PatchId coarse = 0;
  for (int e = 0; e < 4; ++e) {
    if ((before.lower_edges >> e & 1) != 0) coarse = grid_.patches[before.patch].neighbour[e].patch();
  }
  levels_[coarse] = 0;
  BuildDrawList::Result result;
  ASSERT_TRUE(stage().run(result).ok());
  EXPECT_EQ(result.missing, 1u);
  EXPECT_EQ(result.culled_frustum, whole.culled_frustum);
  EXPECT_EQ(result.drawn, whole.drawn - 1);
  bool listed = false;
  for (const DrawItem& item : std::span(items_).first(result.drawn)) {
    ASSERT_NE(item.patch, coarse);
    if (item.patch != before.patch) continue;
    listed = true;
    for (int e = 0; e < 4; ++e) {
      const PatchEdge edge = grid_.patches[item.patch].neighbour[e];
      if (edge.exists() && edge.patch() == coarse) {
        EXPECT_EQ(item.lower_edges >> e & 1, 0);
      }
    }
  }
  EXPECT_TRUE(listed);
}

TEST_F(View, FullListKeepsTheNearest) {
  BuildDrawList::Result whole;
  ASSERT_TRUE(stage().run(whole).ok());
  const std::vector<DrawItem> all(items_.begin(), items_.begin() + whole.drawn);
  for (const std::uint32_t room : {0u, 1u, 100u, whole.drawn - 1}) {
    BuildDrawList build = stage();
    std::vector<DrawItem> few(room + 1, DrawItem{77, 0, 0, 0});
    build.items = std::span(few).first(room);
    ASSERT_TRUE(build.validate().ok());
    BuildDrawList::Result result;
    const Status status = build.run(result);
    EXPECT_EQ(status.code(), StatusCode::limit_reached);
    EXPECT_STREQ(status.field(), "max_draw_items");
    EXPECT_EQ(status.value(), whole.drawn);
    EXPECT_EQ(result.drawn, room);
    EXPECT_EQ(result.dropped, whole.drawn - room);
    EXPECT_TRUE(std::equal(all.begin(), all.begin() + room, few.begin()));
    EXPECT_EQ(few.back().patch, 77u) << "written past the end";
  }
}

TEST_F(View, RefusesOneWrongFieldAtATime) {
  using Break = std::function<void(BuildDrawList&)>;
  const std::vector<std::pair<const char*, Break>> cases = {
      {"camera", [](BuildDrawList& s) { s.camera = nullptr; }},
      {"boxes", [](BuildDrawList& s) { s.boxes = s.boxes.first(3); }},
      {"levels", [](BuildDrawList& s) { s.levels = s.levels.first(3); }},
      {"scratch", [](BuildDrawList& s) { s.scratch = s.scratch.first(s.scratch.size() - 1); }},
  };
  for (const auto& [field, break_it] : cases) {
    BuildDrawList build = stage();
    ASSERT_TRUE(build.validate().ok());
    break_it(build);
    EXPECT_EQ(build.validate().code(), StatusCode::invalid_argument) << field;
    EXPECT_STREQ(build.validate().field(), field);
  }
}

TEST_F(View, EmptySurfaceIsFine) {
  BuildDrawList build;
  build.camera = &camera_;
  ASSERT_TRUE(build.validate().ok());
  BuildDrawList::Result result;
  EXPECT_TRUE(build.run(result).ok());
  EXPECT_EQ(result.drawn, 0u);
}

class Expand : public View {
 protected:
  void SetUp() override {
    ASSERT_TRUE(stage().run(result_).ok());
    items_.resize(result_.drawn);
    table_.resize(index_count(kMaxLevel));
    ASSERT_TRUE(build_index_tables(kMaxLevel, table_).ok());
    // Every patch at its own level, every second one in pages that are scattered over the whole buffer.
    const std::uint32_t patches = static_cast<std::uint32_t>(grid_.patches.size());
    first_page_.assign(patches, kNoPage);
    next_page_.assign(patches * kPlaces * 2, kNoPage);
    for (PatchId id = 0; id < patches; ++id) set_chain(id, levels_[id]);
  }

  // The page that holds a patch's place.
  std::uint32_t page(PatchId id, std::uint32_t place) const {
    const auto patches = static_cast<std::uint32_t>(grid_.patches.size());
    if (id % 2 == 0) return id * kPlaces + place;
    return kPlaces * patches + (patches - 1 - id) + place * 7919 % kPlaces * patches;
  }
  void set_chain(PatchId id, int level) {
    first_page_[id] = page(id, 0);
    for (std::uint32_t place = 0; place + 1 < slot_pages(level); ++place) {
      next_page_[page(id, place)] = page(id, place + 1);
    }
    next_page_[page(id, slot_pages(level) - 1)] = kNoPage;
  }

  PageTable pages() const { return {first_page_, next_page_, {}}; }

  // Straight from the table, item by item.
  std::vector<std::uint32_t> expected() const {
    std::vector<std::uint32_t> all;
    for (const DrawItem& item : items_) {
      if (first_page_[item.patch] == kNoPage) continue;
      IndexRange ranges[kMaxIndexRanges];
      const int used = index_ranges(item.level, item.lower_edges, item.skipped_edges, ranges);
      for (int r = 0; r < used; ++r) {
        for (std::uint32_t n = 0; n < ranges[r].count; ++n) {
          const std::uint32_t v = table_[ranges[r].first + n];
          all.push_back(page(item.patch, v / kPageVertices) * kPageVertices + v % kPageVertices);
        }
      }
    }
    return all;
  }

  static constexpr std::uint32_t kPlaces = kMostSlotPages;
  BuildDrawList::Result result_;
  std::vector<std::uint16_t> table_;
  std::vector<std::uint32_t> first_page_, next_page_;
};

TEST_F(Expand, ChunksOfAnySizeMakeTheWholeStream) {
  first_page_[items_[2].patch] = kNoPage;
  first_page_[items_.back().patch] = kNoPage;
  const std::vector<std::uint32_t> wanted = expected();
  ASSERT_GT(wanted.size(), 100'000u);
  for (const std::size_t room :
       {std::size_t{ExpandIndices::least_room(5)}, std::size_t{10'001}, wanted.size() - 1, wanted.size()}) {
    std::vector<std::uint32_t> out(room + 1, 0xabcdabcdu);
    const ExpandIndices expand{table_, items_, pages(), std::span(out).first(room)};
    ASSERT_TRUE(expand.validate(5).ok());
    std::vector<std::uint32_t> stream;
    std::uint32_t left_out = 0;
    int chunks = 0;
    for (ExpandIndices::Chunk c; c.next_item < items_.size(); ++chunks) {
      const std::uint32_t from = c.next_item;
      c = expand.run(from);
      ASSERT_GT(c.next_item, from);
      ASSERT_LE(c.indices, room);
      stream.insert(stream.end(), out.begin(), out.begin() + c.indices);
      left_out += c.left_out;
      ASSERT_EQ(out.back(), 0xabcdabcdu) << "written past the end";
    }
    EXPECT_EQ(stream, wanted);
    EXPECT_EQ(left_out, 2u);
    EXPECT_EQ(chunks == 1, room >= wanted.size());
  }
}

// Nodes come after the items, from pages of their own, and in the same chunks.
TEST_F(Expand, NodesFollowTheItems) {
  constexpr std::uint32_t kFirst = 70'000;
  constexpr std::uint32_t kPages = 40;
  std::vector<DrawItem> nodes;
  for (std::uint32_t n = 0; n < kPages; ++n)
    nodes.push_back({n * 7 % kPages, 2, static_cast<std::uint8_t>(n % 16), 0});
  std::vector<std::uint32_t> wanted = expected();
  for (const DrawItem& node : nodes) {
    IndexRange ranges[kMaxIndexRanges];
    const int used = index_ranges(node.level, node.lower_edges, 0, ranges);
    for (int r = 0; r < used; ++r) {
      for (std::uint32_t n = 0; n < ranges[r].count; ++n)
        wanted.push_back((kFirst + node.patch) * kPageVertices + table_[ranges[r].first + n]);
    }
  }
  // One that has no page, and one whose level has more than one.
  nodes.insert(nodes.begin() + 3, {kPages, 2, 0, 0});
  nodes.push_back({0, 3, 0, 0});
  for (const std::size_t room : {std::size_t{ExpandIndices::least_room(5)}, wanted.size()}) {
    std::vector<std::uint32_t> out(room);
    ExpandIndices expand{table_, items_, pages(), out};
    expand.nodes = nodes;
    expand.first_node_page = kFirst;
    expand.node_pages = kPages;
    ASSERT_TRUE(expand.validate(5).ok());
    std::vector<std::uint32_t> stream;
    std::uint32_t left_out = 0;
    int chunks = 0;
    for (ExpandIndices::Chunk c; c.next_item < expand.count(); ++chunks) {
      c = expand.run(c.next_item);
      stream.insert(stream.end(), out.begin(), out.begin() + c.indices);
      left_out += c.left_out;
    }
    EXPECT_EQ(stream, wanted);
    EXPECT_EQ(left_out, 2u);
    EXPECT_EQ(chunks == 1, room >= wanted.size());
  }
  ExpandIndices alone;
  std::vector<std::uint32_t> out(ExpandIndices::kLeastNodeRoom);
  alone.table = std::span(table_).first(index_count(2));
  alone.nodes = std::span(nodes).first(1);
  alone.node_pages = 1;
  alone.out = out;
  EXPECT_TRUE(alone.validate(2).ok());
  EXPECT_EQ(alone.run(0).indices, patch_index_count(2, 0, 0));
  // With walls all around it takes all of that.
  std::vector<DrawItem> walled(nodes.begin(), nodes.begin() + 1);
  walled[0].walls = 15;
  alone.nodes = walled;
  ASSERT_EQ(alone.run(0).indices, out.size());
  for (std::size_t edge = 0; edge < 4; ++edge) {
    const auto at = out.end() - static_cast<std::ptrdiff_t>((4 - edge) * kIndicesPerWall);
    EXPECT_TRUE(std::equal(kWallIndices[edge].begin(), kWallIndices[edge].end(), at)) << edge;
  }
}

// Vertices that a patch does not have are other patches' or none: such an item must not be drawn at all.
TEST_F(Expand, PatchesWithFewerPagesThanTheLevelNeedsAreLeftOut) {
  std::vector<std::uint32_t> out(ExpandIndices::least_room(5));
  DrawItem item = items_[0];
  ASSERT_GE(item.level, 3);
  const ExpandIndices expand{table_, std::span(&item, 1), pages(), out};
  const auto drawn = [&] {
    std::fill(out.begin(), out.end(), 0xabcdabcdu);
    const ExpandIndices::Chunk chunk = expand.run(0);
    EXPECT_EQ(chunk.next_item, 1u);
    EXPECT_EQ(chunk.left_out, chunk.indices == 0 ? 1u : 0u);
    EXPECT_EQ(out[0] == 0xabcdabcdu, chunk.indices == 0);
    return chunk.indices > 0;
  };
  const int resident = item.level;
  for (int level = 1; level <= 5; ++level) {
    item.level = static_cast<std::uint8_t>(level);
    EXPECT_EQ(drawn(), slot_pages(level) <= slot_pages(resident)) << level;
  }
  item.level = static_cast<std::uint8_t>(resident);
  // A page that is none of the buffer's, first or last in the chain; a patch that is none of the table's.
  const std::uint32_t last = page(item.patch, slot_pages(resident) - 1);
  const std::uint32_t before_last = page(item.patch, slot_pages(resident) - 2);
  for (const std::uint32_t no_page : {static_cast<std::uint32_t>(next_page_.size()), 0xfffffffeu, kNoPage}) {
    next_page_[before_last] = no_page;
    EXPECT_FALSE(drawn());
    next_page_[before_last] = last;
    first_page_[item.patch] = no_page;
    EXPECT_FALSE(drawn());
    first_page_[item.patch] = page(item.patch, 0);
  }
  EXPECT_TRUE(drawn());
  item.patch = static_cast<PatchId>(first_page_.size());
  EXPECT_FALSE(drawn());
}

TEST_F(Expand, TrianglesOfTheResultAreThoseOfTheStream) {
  EXPECT_EQ(expected().size(), 3u * result_.triangles);
}

TEST_F(Expand, RefusesOneWrongFieldAtATime) {
  std::vector<std::uint32_t> out(ExpandIndices::least_room(5));
  const ExpandIndices good{table_, items_, pages(), out};
  EXPECT_TRUE(good.validate(5).ok());
  EXPECT_STREQ(good.validate(0).field(), "max_level");
  EXPECT_STREQ(good.validate(kMaxLevel + 1).field(), "max_level");
  EXPECT_STREQ(good.validate(6).field(), "out");
  ExpandIndices bad = good;
  bad.table = bad.table.first(index_count(5) - 1);
  EXPECT_STREQ(bad.validate(5).field(), "table");
  bad = good;
  bad.pages.first_page = {};
  EXPECT_STREQ(bad.validate(5).field(), "first_page");
  bad = good;
  bad.out = bad.out.first(out.size() - 1);
  EXPECT_STREQ(bad.validate(5).field(), "out");
  EXPECT_EQ(bad.validate(5).value(), ExpandIndices::least_room(5));
}

}  // namespace
}  // namespace karst::core
