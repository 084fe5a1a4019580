// SPDX-License-Identifier: MIT
// Frames of a ground with an isosurface in a region of it: random grounds, fields, cameras, thresholds, tiles
// that come late, blocks of any levels beside each other at the sides. In every frame each inner edge of
// nodes, meshes and belts is used once by each of its two sides, with the same bits of the places that are
// drawn.
//
// KARST_FIELD_REGION_FRAMES sets how many frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <vector>

#include <glm/common.hpp>

#include "terrain/blocks/isosurface.h"
#include "terrain/nodes/node_place.h"
#include "terrain/regions/belts.h"
#include "tests/support/any_camera.h"
#include "tests/support/field_shapes.h"
#include "tests/support/ground_frame.h"
#include "tests/support/heap_count.h"
#include "tests/support/memory_ground.h"
#include "tests/support/morph_scene.h"

namespace karst::test {
namespace {

std::uint64_t frames_wanted() {
  const char* const set = std::getenv("KARST_FIELD_REGION_FRAMES");
  return set == nullptr ? 300 : std::strtoull(set, nullptr, 10);
}

constexpr std::uint32_t kPages = 6'000;

struct Layout {
  int lattice_size = 0;
  int cell_log2 = 10;
  glm::ivec3 blocks{0};  // drawn
  int first[2] = {};     // node
  int nodes[2] = {};
  int samples[2] = {};  // of the ground

  // Voxels between the sides.
  int wide(int axis) const { return 16 * blocks[axis] >> (13 - cell_log2); }
};

Layout random_layout(Random& random) {
  for (;;) {
    Layout layout;
    layout.lattice_size = random.below(4);
    layout.cell_log2 = 10 + random.below(4);
    layout.blocks = {1 + random.below(5), 2 + random.below(2), 1 + random.below(5)};
    if (random.below(3) != 0) layout.blocks = {2 << random.below(3), 3, 4 << random.below(2)};
    bool fits = true;
    for (int axis = 0; axis < 2; ++axis) {
      const int wide = layout.wide(2 * axis);
      fits = fits && wide % (1 << layout.lattice_size) == 0 && wide > 0 && wide < 200;
      layout.nodes[axis] = wide >> layout.lattice_size;
      layout.first[axis] = 1 + random.below(9);
      layout.samples[axis] =
          (layout.first[axis] + layout.nodes[axis] + 1 + random.below(20)) * kNodeQuads + 2 + random.below(3);
    }
    if (fits) return layout;
  }
}

// Land with caves that stay away from the sides, in cells.
struct Shape {
  FieldShape value;
  bool cuts = false;
};
Shape random_shape(Random& random, glm::ivec3 blocks) {
  const std::uint64_t seed = random.next();
  const glm::dvec3 size(blocks * 16);
  const double wave = between(random, 4, 40), caves = between(random, 0.1, 0.7);
  const double tall = between(random, 0, 1);
  const bool cuts = random.below(5) == 0;
  const FieldShape value = [=](glm::dvec3 p) {
    const double rough = std::clamp(0.5 + value_noise(seed, glm::dvec3(p.x, 0, p.z) / wave), 0.0, 1.0);
    const double land = p.y - (4 + (size.y - 12) * (0.2 + 0.8 * tall * rough));
    const double side = std::min(std::min(p.x, size.x - p.x), std::min(p.z, size.z - p.z)) - 3;
    // One of five is cut by the sides, below the ground.
    const double cave = std::min({20 * (value_noise(seed + 1, p / 9.0) - 1 + caves),
                                  cuts ? std::max(side, -3 - land) : side, p.y - 3});
    return std::max(land, cave);
  };
  return {value, cuts};
}

// A field in a region, and its meshes as a renderer keeps them.
struct FieldScene {
  FieldScene(const Layout& layout, const FieldShape& shape, const GroundInfo& ground) {
    const glm::ivec3 blocks = layout.blocks + glm::ivec3(1, 0, 1);
    config.field_blocks = config.field_sample_blocks =
        static_cast<std::uint32_t>(blocks.x * blocks.y * blocks.z);
    config.field_meshes = 1'000;
    config.field_vertex_pages = config.field_index_pages = kPages;
    config.rim_edges = 4'000;
    Budget budget;
    FieldBlocks::Storage storage;
    storage.each_block(config, CountBlocks(budget));
    Isosurface::add_to(budget, config);
    memory = std::make_unique<AlignedBytes>(budget.cpu_bytes());
    Arena arena(memory->bytes());
    storage.each_block(config, TakeBlocks(arena));
    field.create(storage);
    FieldInfo info = field_info(blocks, config.field_sample_blocks);
    info.cell_log2 = layout.cell_log2;
    info.in_region = true;
    EXPECT_TRUE(field.reset(info).ok());
    fill_field(field, shape);
    EXPECT_TRUE(isosurface.create(config, arena).ok());
    isosurface.attach(field,
                      {ground.regions()[0].corner, std::int64_t{kStepsPerVoxel} << layout.lattice_size});
    vertices.resize(std::size_t{32} * kPages);
    places.resize(kPages);
  }

  // What is chosen for random eyes, of any levels.
  void choose(Random& random) {
    const glm::dvec3 size(field.info().drawn_steps());
    std::array<BlockEye, 2> eyes;
    for (BlockEye& eye : eyes) {
      for (int axis = 0; axis < 3; ++axis)
        eye.eye.eye[axis] = static_cast<float>(size[axis] * between(random, -0.3, 1.3));
      eye.eye.least_cos2 = 0.4f;
      eye.eye.forward = glm::vec3(0, 0, -1);
      eye.steps_per_step = std::exp2f(static_cast<float>(between(random, -4, 4)));
    }
    isosurface.begin_frame();
    isosurface.choose(eyes);
    MeshUpload upload;
    Status status;
    for (int tries = 0; !isosurface.is_complete() && tries < 9; ++tries) {
      while (isosurface.make_next(upload, status)) {
        const MeshPages pages = isosurface.pool().pages(0);
        std::uint32_t page = upload.first_page;
        for (std::size_t done = 0; done < upload.vertices.size(); page = pages.next_page[page], done += 32) {
          const std::size_t n = std::min<std::size_t>(32, upload.vertices.size() - done);
          std::copy_n(upload.vertices.begin() + static_cast<std::ptrdiff_t>(done), n,
                      vertices.begin() + static_cast<std::ptrdiff_t>(32 * std::size_t{page}));
          places[page] = {upload.origin, upload.size};
        }
      }
      EXPECT_TRUE(status.ok());
      isosurface.release_kept();
    }
    EXPECT_TRUE(isosurface.is_complete());
  }
  glm::vec3 place(std::uint32_t vertex, const Camera& camera) const {
    const GpuVertex& v = vertices[vertex];
    const Place& at = places[vertex / 32];
    return node_place(camera.voxel, at.size, at.origin, {v.position[0], v.position[1], v.position[2]});
  }

  struct Place {
    glm::ivec3 origin{0};
    int size = 0;
  };
  Config config;
  std::unique_ptr<AlignedBytes> memory;
  FieldBlocks field;
  Isosurface isosurface;
  std::vector<GpuVertex> vertices;
  std::vector<Place> places;
};

struct Totals {
  std::uint64_t frames = 0, with_region = 0, edges = 0, belts = 0, points = 0, mixed = 0, loops = 0,
                without = 0;
  std::array<std::uint64_t, 9> at_side{};  // blocks that end at a side, by level
};

class FieldRegionFrames {
 public:
  FieldRegionFrames() : table_(index_count(kMaxLevel)) {
    entries_.resize(kMorphEntries);
    build_family_entries(entries_);
    EXPECT_TRUE(build_index_tables(kMaxLevel, table_).ok());
  }

  void check(const MemoryGround& ground, const GroundRequest& request, const Parts& parts, FieldScene& scene,
             Totals& totals) {
    edges_.clear();
    const Camera& camera = *request.camera;
    const std::uint32_t first_mesh_page = 4 * parts.pool.count();
    ends_.assign((std::size_t{first_mesh_page} + kPages) * kPageVertices, edges_.add({}));
    for (std::size_t n = 0; n < parts.view.items().size(); ++n) {
      const DrawItem& item = parts.view.items()[n];
      const DrawnNode drawn(ground.info(), camera, request.scale, parts.view.node_of(n), entries_, parts.rows,
                            parts.view.node_of(n).key == ground.root());
      const std::uint32_t first = item.patch * kPageVertices;
      for (std::uint32_t v = 0; v < kNodePageVertices; ++v) ends_[first + v] = edges_.add(drawn.place(v));
      IndexRange ranges[kMaxIndexRanges];
      const int count = index_ranges(item.level, item.lower_edges, item.skipped_edges, ranges);
      for (int r = 0; r < count; ++r) {
        for (std::uint32_t at = ranges[r].first; at < ranges[r].first + ranges[r].count; at += 3)
          use_triangle(table_.data() + at, first);
      }
      for (std::size_t edge = 0; edge < 4; ++edge) {
        for (std::size_t at = 0; (item.walls >> edge & 1u) != 0 && at < kIndicesPerWall; at += 3)
          use_triangle(kWallIndices[edge].data() + at, first);
      }
    }
    if (parts.view.result().regions != 0) {
      add_meshes(camera, scene, first_mesh_page, totals);
      BuildBelts belts;
      belts.info = &ground.info();
      belts.blocks = &scene.isosurface.rim();
      belts.view = &parts.view;
      belts.first_mesh_page = first_mesh_page;
      indices_.resize(BuildBelts::room(scene.config.rim_edges, 1));
      belts.out = indices_;
      const std::uint64_t before = heap_calls();
      const std::size_t count = belts.run();
      EXPECT_EQ(heap_calls() - before, 0u);
      for (std::size_t at = 0; at < count; at += 3) use_triangle(indices_.data() + at, 0);
      totals.belts += count / 3;
      totals.points += scene.isosurface.rim().points().size();
      totals.loops += scene.isosurface.rim().loops();
    }
    look(ground, request, totals);
  }

 private:
  void add_meshes(const Camera& camera, FieldScene& scene, std::uint32_t first_page, Totals& totals) {
    const Isosurface::List list = scene.isosurface.list(0, nullptr);
    const MeshPages pages = scene.isosurface.pool().pages(0);
    for (const MeshItem& item : list.items) {
      std::vector<std::uint32_t> of_vertex;
      for (std::uint32_t page = item.first_page; page < pages.next_page.size();
           page = pages.next_page[page]) {
        for (std::uint32_t v = 0; v < 32; ++v) {
          of_vertex.push_back((first_page + page) * 32 + v);
          ends_[of_vertex.back()] = edges_.add(scene.place(32 * page + v, camera));
        }
      }
      std::uint32_t page = item.first_index_page;
      for (std::uint32_t at = 0; at < item.indices; at += 3) {
        if (at > 0 && at % kIndexPage == 0) page = pages.next_index_page[page];
        const std::uint16_t* const corner = &pages.indices[std::size_t{page} * kIndexPage + at % kIndexPage];
        const std::uint32_t corners[3] = {of_vertex[corner[0]], of_vertex[corner[1]], of_vertex[corner[2]]};
        use_triangle(corners, 0);
      }
    }
    int least = 9, most = -1;
    for (const ChosenBlock& block : scene.isosurface.drawn()) {
      if (sides_of(scene.field.info(), block.block) == 0) continue;
      ++totals.at_side[block.block.level];
      least = std::min<int>(least, block.block.level);
      most = std::max<int>(most, block.block.level);
    }
    totals.mixed += most > least ? 1u : 0u;
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
    double low[2], high[2], end[2];
    for (int axis = 0; axis < 2; ++axis) {
      const auto at = [&](std::int64_t sample) {
        return double(sample_place(info, axis, sample) * kVertexStep);
      };
      low[axis] = at(std::int64_t{info.regions()[0].nodes.low[axis]} * kNodeQuads);
      high[axis] = at(std::int64_t{info.regions()[0].nodes.high[axis]} * kNodeQuads);
      end[axis] = at(info.samples[axis] - 1);
    }
    const double foot = double(info.low) * kVertexStep;
    const double slack = std::ldexp(4.0, info.page_size(info.top_size()));
    totals.edges += edges_.count();
    edges_.for_each_open([&](const FrameEdges::Edge& edge) {
      const glm::dvec3 a = glm::dvec3(edge.from) + corner, b = glm::dvec3(edge.to) + corner;
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
      // In a side triangles of the belt may have no area, and where the surface touches itself in a coarse
      // mesh edges lie on each other.
      bool inside = true;
      for (int axis = 0; axis < 2; ++axis) {
        for (const glm::dvec3& place : {a, b})
          inside = inside && place[2 * axis] >= low[axis] && place[2 * axis] <= high[axis];
      }
      if (edge.times == edge.back && inside) return;
      if (has_wall_behind(info, request, a, b)) return;
      if (at_foot || out_of_view || testing::Test::HasFatalFailure()) return;
      FAIL() << "an edge from " << a.x << ' ' << a.y << ' ' << a.z << " to " << b.x << ' ' << b.y << ' '
             << b.z << " is used " << edge.times << " times, the other way " << edge.back
             << " times; the region is " << low[0] << ".." << high[0] << ", " << low[1] << ".." << high[1];
    });
  }

  std::vector<std::uint8_t> entries_;
  std::vector<std::uint16_t> table_;
  FrameEdges edges_;
  std::vector<std::uint32_t> ends_, indices_;
};

TEST(FieldRegion, EveryInnerEdgeIsUsedOnceByEachSide) {
  Random random{20261129};
  FieldRegionFrames frames;
  Totals totals;
  const std::uint64_t wanted = frames_wanted();
  while (totals.frames < wanted) {
    show_progress(totals.frames, wanted);
    const Layout layout = random_layout(random);
    const double rough = std::exp2(between(random, 0, 13));
    const double middle = between(random, 0, 2 * layout.wide(1));
    std::vector<std::int32_t> heights(static_cast<std::size_t>(layout.samples[0] * layout.samples[1]));
    for (std::int32_t& h : heights) {
      h = static_cast<std::int32_t>(middle * kStepsPerVoxel / kVertexStep) +
          static_cast<std::int32_t>(between(random, -rough, rough));
    }
    const double errors = std::exp2(between(random, 0, 9));
    const double steps = std::ldexp(2048, layout.lattice_size);
    const RegionMeasure measure{std::exp2(between(random, 10, 18)),
                                double{kStepsPerVoxel} * (layout.wide(0) + layout.wide(1) + layout.wide(2))};
    const MemoryGround ground(
        layout.samples[0], layout.samples[1], steps, steps,
        [&](std::int64_t i, std::int64_t k) {
          return heights[static_cast<std::size_t>(k * layout.samples[0] + i)];
        },
        [&](NodeKey key) {
          return static_cast<float>(
              between(random, 0, 1) < 0.3 ? 0.0 : errors * std::exp2(key.size) * between(random, 0, 2));
        },
        {{layout.wide(0) + 1, layout.wide(2) + 1, layout.first[0], layout.first[1], measure,
          layout.wide(1) + 1, 0}});
    ASSERT_EQ(ground.info().region_count, 1);
    const Shape shape = random_shape(random, layout.blocks);
    FieldScene scene(layout, shape.value, ground.info());
    Parts parts(static_cast<std::uint32_t>(ground.tile_count()) + 1,
                static_cast<std::uint32_t>(between(random, 0, 1) < 0.5 ? 1500 : between(random, 3, 300)));
    MemoryGround::Source source(ground);
    source.comes = between(random, 0.4, 1);
    source.fails = between(random, 0, 0.2);
    parts.tiles.reset(source.source(), ground.root(), ground.tile(ground.root()));
    parts.view.reset();
    for (int frame = 0; frame < 20; ++frame, ++totals.frames) {
      scene.choose(random);
      // What is cut all around has none.
      ASSERT_TRUE(shape.cuts || scene.isosurface.rim().exists());
      totals.without += scene.isosurface.rim().exists() ? 0u : 1u;
      Camera camera;
      const auto kind = kAnyProjections[random.next() % std::size(kAnyProjections)];
      CameraMatrices matrices = any_matrices(random, kind, 0.01, 64);
      show(random,
           glm::dvec3(between(random, 0, layout.wide(0)), middle + between(random, -3, 3),
                      between(random, 0, layout.wide(2))),
           std::exp2(between(random, -3, 9)), matrices);
      if (!make_camera(matrices, camera).ok()) continue;
      GroundRequest request;
      request.camera = &camera;
      request.error_px = std::exp2(between(random, -2, 6));
      request.scale = make_error_scale(camera, 640, 360, request.error_px);
      request.culls = random.next() % 2 == 0;
      request.regions = random.below(8) != 0 && scene.isosurface.rim().exists() ? 1 : 0;
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
      totals.with_region += parts.view.result().regions != 0 ? 1u : 0u;
      frames.check(ground, request, parts, scene, totals);
      if (HasFatalFailure()) {
        std::printf("blocks %d x %d x %d, cells 2^%d, lattice %d, frame %d\n", layout.blocks.x,
                    layout.blocks.y, layout.blocks.z, layout.cell_log2, layout.lattice_size, frame);
        return;
      }
    }
  }
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf(
      "FIGURE %llu frames, %llu with the region, %llu of them with blocks of several levels at its sides; "
      "%llu "
      "edges, %llu triangles of belts, %llu points of rims, %llu loops, %llu frames without a rim; blocks at "
      "sides by level: %llu, "
      "%llu, %llu, "
      "%llu\n",
      number(totals.frames), number(totals.with_region), number(totals.mixed), number(totals.edges),
      number(totals.belts), number(totals.points), number(totals.loops), number(totals.without),
      number(totals.at_side[0]), number(totals.at_side[1]), number(totals.at_side[2]),
      number(totals.at_side[3]));
  EXPECT_GT(totals.with_region, totals.frames / 8);
  EXPECT_LT(totals.with_region, totals.frames);
  EXPECT_GT(totals.mixed, totals.frames / 50);
  EXPECT_GT(totals.belts, totals.frames);
  EXPECT_LT(totals.without, totals.frames / 10);
  EXPECT_GT(totals.loops, totals.frames / 10);
}

}  // namespace
}  // namespace karst::test
