// SPDX-License-Identifier: MIT
// Frames of a ground with one to four regions in it: random grounds and voxels, cameras, thresholds, tiles
// that come late or fail, patches held at any level or not at all, a node or many between regions. In every
// frame each inner edge of nodes, patches and belts is used once by each of its two sides, with the same bits
// of the places that are drawn.
//
// KARST_REGION_FRAMES sets how many frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/draw/index_batches.h"
#include "terrain/draw/wall_indices.h"
#include "terrain/regions/belts.h"
#include "terrain/regions/region_rim.h"
#include "tests/support/any_camera.h"
#include "tests/support/ground_frame.h"
#include "tests/support/heap_count.h"
#include "tests/support/memory_ground.h"
#include "tests/support/morph_scene.h"

namespace karst::core {
namespace {

using test::DrawnNode;
using test::FrameEdges;
using test::MemoryGround;
using test::Parts;

std::uint64_t frames_wanted() {
  const char* const set = std::getenv("KARST_REGION_FRAMES");
  return set == nullptr ? 300 : std::strtoull(set, nullptr, 10);
}

// A region of a ground.
struct Place {
  int first[2] = {};  // its first node
  int nodes[2] = {};  // along x and z
  glm::ivec3 extent{0};
  int height = 0;  // of its corner
};

// Where the ground lies, and what of it regions have.
struct Layout {
  int lattice_size = 0;
  std::vector<Place> places;
  int samples[2] = {};  // of the ground
};

bool are_apart(const Place& a, const Place& b) {
  for (int axis = 0; axis < 2; ++axis) {
    if (a.first[axis] + a.nodes[axis] < b.first[axis] || b.first[axis] + b.nodes[axis] < a.first[axis])
      return true;
  }
  return false;
}

// As wide as any one, but never nearer to another than a node; often just that.
Layout random_layout(Random& random) {
  Layout layout;
  layout.lattice_size = random.below(3);
  const int wide = 1 << layout.lattice_size;
  const int wanted = 1 + random.below(4);
  const int range = random.below(2) == 0 ? 20 : 5;
  int end[2] = {};
  for (int tries = 0; tries < 40 && static_cast<int>(layout.places.size()) < wanted; ++tries) {
    Place place;
    for (int axis = 0; axis < 2; ++axis) {
      place.nodes[axis] = 1 + random.below(12 / wide + 1);
      if (place.nodes[axis] * wide < 3) place.nodes[axis] = (3 + wide - 1) / wide;
      place.first[axis] = 1 + random.below(range);
      if (!layout.places.empty() && random.below(2) == 0) {
        const Place& other =
            layout.places[static_cast<std::size_t>(random.below(static_cast<int>(layout.places.size())))];
        place.first[axis] = other.first[axis] + other.nodes[axis] + 1;
      }
      place.extent[2 * axis] = place.nodes[axis] * wide + 1;
    }
    place.extent.y = 14;
    bool fits = true;
    for (const Place& other : layout.places) fits = fits && are_apart(place, other);
    if (!fits) continue;
    place.height = layout.places.empty() ? 0 : random.below(3);
    for (int axis = 0; axis < 2; ++axis)
      end[axis] = std::max(end[axis], place.first[axis] + place.nodes[axis]);
    layout.places.push_back(place);
  }
  for (int axis = 0; axis < 2; ++axis)
    layout.samples[axis] = (end[axis] + random.below(20)) * kNodeQuads + 2 + random.below(3);
  return layout;
}

// A height over the voxels' columns, and caves that stay away from the sides.
TestWorld random_voxels(Random& random, const Place& place, int level) {
  const std::uint64_t seed = random.next();
  const double tall = between(random, 0, 4), caves = between(random, 0.1, 0.7);
  const glm::ivec3 extent = place.extent;
  const double floor = 7 - place.height;
  TestWorld world(
      extent,
      [=](glm::ivec3 v) {
        const bool inside = v.y > 0 && v.x > 2 && v.z > 2 && v.x < extent.x - 3 && v.z < extent.z - 3;
        if (inside && test::value_noise(seed + 1, glm::dvec3(v) / 3.0) > 1 - caves) return false;
        return v.y + 0.5 < floor + tall * test::value_noise(seed, glm::dvec3(v.x, 0, v.z) / 5.0);
      },
      true);
  const double rough = std::exp2(between(random, 0, 11));
  world.set_heights(level, [=](glm::dvec3 p) { return rough * test::value_noise(seed + 2, 3.0 * p); });
  return world;
}

// A region with its patches.
struct Region {
  Region(Random& random, const Place& place, int level)
      : scene(random_voxels(random, place, level)),
        edges(RegionRim::count(scene.drawn.surface())),
        marks(edges.size()) {
    rim.create({edges, marks});
  }
  Scene scene;
  std::vector<RegionRim::Edge> edges;
  std::vector<std::uint32_t> marks;
  RegionRim rim;
};
using Regions = std::vector<std::unique_ptr<Region>>;

// A camera as a region's octree sees it.
Camera seen_from(const GroundRegion& region, const Camera& camera) {
  Camera moved = camera;
  moved.voxel -= region.corner;
  return moved;
}

struct Totals {
  std::uint64_t several = 0;
  std::uint64_t frames = 0, with_region = 0, edges = 0, open = 0, belts = 0, nodes = 0, mixed = 0;
  std::uint64_t refused = 0, halves = 0;
};

class RegionFrames {
 public:
  RegionFrames() : table_(index_count(kMaxLevel)) {
    entries_.resize(kMorphEntries);
    build_family_entries(entries_);
    EXPECT_TRUE(build_index_tables(kMaxLevel, table_).ok());
  }

  // Draws the frame, and looks at each edge.
  void check(const MemoryGround& ground, const GroundRequest& request, const Parts& parts,
             const Regions& regions, Totals& totals) {
    edges_.clear();
    const Camera& camera = *request.camera;
    const std::uint32_t drawn_regions = parts.view.result().regions;
    // Vertices as they lie in the buffer: of patches, region by region, then of nodes.
    const std::uint32_t pages = slot_pages(regions[0]->scene.drawn.level());
    std::uint32_t patches = 0;
    for (const auto& region : regions)
      patches += static_cast<std::uint32_t>(region->scene.drawn.surface().patches.size());
    const std::uint32_t first_node_page = patches * pages;
    ends_.assign((std::size_t{first_node_page} + 4 * std::size_t{parts.pool.count()}) * kPageVertices,
                 edges_.add({}));
    first_page_.resize(patches);
    next_page_.resize(std::size_t{first_node_page});
    for (std::uint32_t page = 0; page < first_node_page; ++page)
      next_page_[page] = (page + 1) % pages == 0 ? kNoPage : page + 1;
    for (PatchId p = 0; p < patches; ++p) first_page_[p] = p * pages;
    PatchId first_patch = 0;
    for (std::size_t n = 0; n < regions.size(); ++n) {
      const Scene& scene = regions[n]->scene;
      const Surface surface = scene.drawn.surface();
      const Camera moved_camera = seen_from(ground.info().regions()[n], camera);
      for (PatchId p = 0; (drawn_regions >> n & 1u) != 0 && p < surface.patches.size(); ++p) {
        if (scene.levels[p] == 0) continue;
        const std::vector<glm::vec3> moved = scene.moved(p, scene.levels[p], moved_camera);
        const std::uint32_t first = (first_patch + p) * pages * kPageVertices;
        std::transform(moved.begin(), moved.end(), ends_.begin() + static_cast<std::ptrdiff_t>(first),
                       [&](glm::vec3 place) { return edges_.add(place); });
        use_item(make_draw_item(surface, scene.levels, p), first);
      }
      first_patch += static_cast<PatchId>(surface.patches.size());
    }
    for (std::size_t n = 0; n < parts.view.items().size(); ++n) {
      const DrawItem& item = parts.view.items()[n];
      const GroundView::Node& node = parts.view.node_of(n);
      const DrawnNode drawn(ground.info(), camera, request.scale, node, entries_, parts.rows,
                            node.key == ground.root());
      const std::uint32_t first = (first_node_page + item.patch) * kPageVertices;
      for (std::uint32_t v = 0; v < kNodePageVertices; ++v) ends_[first + v] = edges_.add(drawn.place(v));
      use_item(item, first);
      for (std::size_t edge = 0; edge < 4; ++edge) {
        for (std::size_t at = 0; (item.walls >> edge & 1u) != 0 && at < kIndicesPerWall; at += 3)
          use_triangle(kWallIndices[edge].data() + at, first);
      }
    }
    totals.nodes += parts.view.items().size();
    totals.several += std::popcount(drawn_regions) > 1 ? 1u : 0u;
    first_patch = 0;
    for (std::size_t n = 0; n < regions.size(); ++n) {
      const Scene& scene = regions[n]->scene;
      if ((drawn_regions >> n & 1u) != 0) {
        BuildBelts belts;
        belts.info = &ground.info();
        belts.region = n;
        belts.rim = &regions[n]->rim;
        belts.view = &parts.view;
        belts.levels = belts.resident = scene.levels;
        belts.pages = {std::span(first_page_).subspan(first_patch), next_page_, {}, {}};
        belts.first_node_page = first_node_page;
        indices_.resize(BuildBelts::room(static_cast<std::uint32_t>(regions[n]->rim.edges().size()),
                                         scene.drawn.level()));
        belts.out = indices_;
        const std::uint64_t before = test::heap_calls();
        const std::size_t count = belts.run();
        EXPECT_EQ(test::heap_calls() - before, 0u);
        for (std::size_t at = 0; at < count; at += 3) use_triangle(indices_.data() + at, 0);
        totals.belts += count / 3;
      }
      first_patch += static_cast<PatchId>(scene.drawn.surface().patches.size());
    }
    look(ground, request, totals);
  }

 private:
  void use_item(const DrawItem& item, std::uint32_t first) {
    IndexRange ranges[kMaxIndexRanges];
    const int count = index_ranges(item.level, item.lower_edges, item.skipped_edges, ranges);
    for (int r = 0; r < count; ++r) {
      for (std::uint32_t at = ranges[r].first; at < ranges[r].first + ranges[r].count; at += 3)
        use_triangle(table_.data() + at, first);
    }
  }
  template <class Index>
  void use_triangle(const Index* corners, std::uint32_t first) {
    for (int side = 0; side < 3; ++side)
      edges_.use(ends_[first + corners[side]], ends_[first + corners[(side + 1) % 3]]);
  }

  void look(const MemoryGround& ground, const GroundRequest& request, Totals& totals) {
    const GroundInfo& info = ground.info();
    const Camera& camera = *request.camera;
    Camera at_voxel = camera;
    at_voxel.voxel = glm::ivec3(0);
    const Frustum frustum = make_frustum(at_voxel);
    const glm::dvec3 corner = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
    // Of regions, and where the ground ends.
    std::vector<std::array<double, 2>> low, high;
    double end[2];
    for (int axis = 0; axis < 2; ++axis) {
      const auto at = [&](std::int64_t sample) {
        return double(sample_place(info, axis, sample) * kVertexStep);
      };
      low.resize(info.regions().size());
      high.resize(info.regions().size());
      const auto number = static_cast<std::size_t>(axis);
      for (std::size_t n = 0; n < info.regions().size(); ++n) {
        low[n][number] = at(std::int64_t{info.regions()[n].nodes.low[axis]} * kNodeQuads);
        high[n][number] = at(std::int64_t{info.regions()[n].nodes.high[axis]} * kNodeQuads);
      }
      end[axis] = at(info.samples[axis] - 1);
    }
    const double foot = double(info.low) * kVertexStep;
    const double slack = std::ldexp(4.0, info.page_size(info.top_size()));
    totals.edges += edges_.count();
    edges_.for_each_open([&](const FrameEdges::Edge& edge) {
      const glm::dvec3 a = glm::dvec3(edge.from) + corner;
      const glm::dvec3 b = glm::dvec3(edge.to) + corner;
      const bool at_foot = std::abs(a.y - foot) <= slack && std::abs(b.y - foot) <= slack;
      bool out_of_view = false;
      for (const Plane& plane : frustum.planes) {
        out_of_view =
            out_of_view || (request.culls && glm::dot(plane.normal, edge.from) + plane.offset < 0.0f &&
                            glm::dot(plane.normal, edge.to) + plane.offset < 0.0f);
      }
      const bool at_end = std::max(a.x, b.x) >= end[0] - slack || std::max(a.z, b.z) >= end[1] - slack;
      const bool at_lowest = std::min(a.y, b.y) <= foot + slack;
      if (edge.times == edge.back && (at_end || at_lowest)) return;
      // In a side of a region triangles of the belt may have no area: their sides lie on each other. And
      // patches may touch along an edge.
      bool in_region = false;
      for (std::size_t n = 0; n < low.size(); ++n) {
        bool inside = true;
        for (std::size_t axis = 0; axis < 2; ++axis) {
          for (const glm::dvec3& place : {a, b}) {
            const double along = place[2 * static_cast<int>(axis)];
            inside = inside && along >= low[n][axis] && along <= high[n][axis];
          }
        }
        in_region = in_region || inside;
      }
      if (edge.times == edge.back && in_region) return;
      ++totals.open;
      if (test::has_wall_behind(info, request, a, b)) return;
      if (at_foot || out_of_view || testing::Test::HasFatalFailure()) return;
      FAIL() << "an edge from " << a.x << ' ' << a.y << ' ' << a.z << " to " << b.x << ' ' << b.y << ' '
             << b.z << " is used " << edge.times << " times, the other way " << edge.back
             << " times; the first region is " << low[0][0] << ".." << high[0][0] << ", " << low[0][1] << ".."
             << high[0][1];
    });
  }

  std::vector<std::uint8_t> entries_;
  std::vector<std::uint16_t> table_;
  FrameEdges edges_;
  std::vector<std::uint32_t> ends_;  // of the vertices in the buffer
  std::vector<std::uint32_t> first_page_, next_page_, indices_;
};

TEST(Region, EveryInnerEdgeIsUsedOnceByEachSide) {
  Random random{20261128};
  RegionFrames frames;
  Totals totals;
  const std::uint64_t wanted = frames_wanted();
  while (totals.frames < wanted) {
    test::show_progress(totals.frames, wanted);
    const Layout layout = random_layout(random);
    const int level = 1 + random.below(4);
    Regions regions;
    for (const Place& place : layout.places)
      regions.push_back(std::make_unique<Region>(random, place, level));
    const double rough = std::exp2(between(random, 0, 13));
    std::vector<std::int32_t> heights(static_cast<std::size_t>(layout.samples[0] * layout.samples[1]));
    for (std::int32_t& h : heights)
      h = 7 * kStepsPerVoxel / kVertexStep + static_cast<std::int32_t>(between(random, -rough, rough));
    const double errors = std::exp2(between(random, 0, 9));
    const double steps = std::ldexp(2048, layout.lattice_size);
    std::vector<test::MemoryRegion> places;
    for (const Place& place : layout.places) {
      const RegionMeasure measure{std::exp2(between(random, 10, 18)),
                                  kStepsPerVoxel * glm::length(glm::dvec3(place.extent))};
      places.push_back({place.extent.x, place.extent.z, place.first[0], place.first[1], measure,
                        place.extent.y, place.height});
    }
    const MemoryGround ground(
        layout.samples[0], layout.samples[1], steps, steps,
        [&](std::int64_t i, std::int64_t k) {
          return heights[static_cast<std::size_t>(k * layout.samples[0] + i)];
        },
        [&](NodeKey key) {
          return static_cast<float>(
              between(random, 0, 1) < 0.3 ? 0.0 : errors * std::exp2(key.size) * between(random, 0, 2));
        },
        places);
    for (std::size_t n = 0; n < regions.size(); ++n) {
      const Status built = regions[n]->rim.build(ground.info().regions()[n], ground.info().lattice_size,
                                                 regions[n]->scene.drawn.surface());
      ASSERT_TRUE(built.ok()) << built.what();
    }
    Parts parts(static_cast<std::uint32_t>(ground.tile_count()) + 1,
                static_cast<std::uint32_t>(between(random, 0, 1) < 0.5 ? 1500 : between(random, 3, 300)));
    MemoryGround::Source source(ground);
    source.comes = between(random, 0.4, 1);
    source.fails = between(random, 0, 0.2);
    parts.tiles.reset(source.source(), ground.root(), ground.tile(ground.root()));
    parts.view.reset();
    for (int frame = 0; frame < 20; ++frame, ++totals.frames) {
      Camera camera;
      const auto kind = test::kAnyProjections[random.next() % std::size(test::kAnyProjections)];
      CameraMatrices matrices = test::any_matrices(random, kind, 0.01, 64);
      const GroundRegion& looked_at =
          ground.info().regions()[static_cast<std::size_t>(random.below(static_cast<int>(regions.size())))];
      test::show(random,
                 glm::dvec3(looked_at.corner.x, 0, looked_at.corner.z) +
                     glm::dvec3(between(random, 0, looked_at.extent.x), 7 + between(random, -3, 3),
                                between(random, 0, looked_at.extent.z)),
                 std::exp2(between(random, -3, 9)), matrices);
      if (!make_camera(matrices, camera).ok()) continue;
      GroundRequest request;
      request.camera = &camera;
      request.error_px = std::exp2(between(random, -2, 6));
      request.culls = random.next() % 2 == 0;
      for (std::size_t n = 0; n < regions.size(); ++n) {
        Scene& scene = regions[n]->scene;
        const Camera moved = seen_from(ground.info().regions()[n], camera);
        const SelectLod::Result patches = scene.select(moved, {640, 360}, request.error_px, level);
        request.scale = scene.scale;
        if (patches.missing == 0 && random.below(8) != 0) request.regions |= std::uint32_t{1} << n;
        if (random.below(2) == 0) {
          // Held at any level, but none missing.
          LodSettings settings;
          settings.error_px = request.error_px;
          settings.max_level = settings.resident_level = level;
          std::vector<LackingPatch> lacking(scene.levels.size());
          const std::vector<std::uint8_t> held = random_held(random, scene, 0);
          scene.select_held(settings, moved, nullptr, held, lacking);
        }
      }
      for (int round = random.below(6); round >= 0; --round) {
        parts.tiles.begin_frame();
        parts.pool.begin_frame();
        parts.tiles.poll();
        parts.view.select(ground.info(), request, parts.tiles, parts.pool);
        parts.tiles.ask();
      }
      for (MorphRows rows; !(rows = parts.view.take_rows()).halves.empty();) {
        std::copy(rows.halves.begin(), rows.halves.end(),
                  parts.rows.begin() + static_cast<std::ptrdiff_t>(rows.first_row) * kMorphRow);
      }
      totals.refused += parts.view.result().refused;
      totals.with_region += parts.view.result().regions != 0 ? 1u : 0u;
      frames.check(ground, request, parts, regions, totals);
      if (HasFatalFailure()) {
        std::printf("ground %d x %d, %zu regions, lattice %d, frame %d, culls %d\n", layout.samples[0],
                    layout.samples[1], regions.size(), layout.lattice_size, frame, request.culls ? 1 : 0);
        return;
      }
    }
  }
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf(
      "FIGURE %llu frames, %llu with regions, %llu with several; %llu edges, %llu of them at feet of walls "
      "or out of view; "
      "%llu nodes, %llu triangles of belts, %llu splits refused\n",
      number(totals.frames), number(totals.with_region), number(totals.several), number(totals.edges),
      number(totals.open), number(totals.nodes), number(totals.belts), number(totals.refused));
  EXPECT_GT(totals.with_region, totals.frames / 8);
  EXPECT_LT(totals.with_region, totals.frames);
  EXPECT_GT(totals.several, totals.frames / 16);
  EXPECT_GT(totals.belts, totals.frames);
}

}  // namespace
}  // namespace karst::core
