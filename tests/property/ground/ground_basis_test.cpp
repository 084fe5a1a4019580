// SPDX-License-Identifier: MIT
// Frames of grounds on curved bases by the hundred, as ground_test has them of planes: in every frame each
// edge is used once by each of its two sides, with the same bits, over the edges of a cube's faces too, so
// that a planet is closed; drawn places are where double says; no drawn point is further from the full
// surface than stated; and an eye at 2 m stands anywhere.
//
// KARST_GROUND_FRAMES sets how many frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/ground/ground_box.h"
#include "tests/support/any_camera.h"
#include "tests/support/curved_ground.h"
#include "tests/support/ground_frame.h"
#include "tests/support/heap_count.h"
#include "tests/support/memory_ground.h"

namespace karst::core {
namespace {

using test::DrawnNode;
using test::for_each_triangle;
using test::FrameEdges;
using test::MemoryGround;
using test::noise_over;
using test::Parts;
using test::planet;
using test::Random;
using test::region;
using test::tube;
using test::voxel_m;

std::uint64_t frames_wanted() {
  const char* const set = std::getenv("KARST_GROUND_FRAMES");
  return set == nullptr ? 400 : std::strtoull(set, nullptr, 10);
}

// Tables that all frames look up.
struct Tables {
  Tables() : entries(kMorphEntries, 0), indices(index_count(kNodeLevel)) {
    build_family_entries(entries);
    EXPECT_TRUE(build_index_tables(kNodeLevel, indices).ok());
  }
  std::vector<std::uint8_t> entries;
  std::vector<std::uint16_t> indices;
};

MemoryGround::Errors any_errors(Random& random, double errors) {
  return [&random, errors](NodeKey key) {
    return static_cast<float>(
        test::between(random, 0, 1) < 0.3 ? 0.0 : errors * std::exp2(key.size) * test::between(random, 0, 2));
  };
}

struct Totals {
  std::uint64_t frames = 0, edges = 0, nodes = 0, coarser = 0, refused = 0, moving = 0, rim = 0;
};

void check_edges(const MemoryGround& ground, const GroundRequest& request, const Parts& parts,
                 const Tables& tables, FrameEdges& edges, Totals& totals) {
  edges.clear();
  const Camera& camera = *request.camera;
  const GroundInfo& info = ground.info();
  for (std::size_t n = 0; n < parts.view.items().size(); ++n) {
    const DrawItem& item = parts.view.items()[n];
    const GroundView::Node& node = parts.view.node_of(n);
    const DrawnNode drawn(info, camera, request.scale, node, tables.entries, parts.rows,
                          node.key.size == info.top_size());
    totals.moving += static_cast<std::uint64_t>(drawn.moving());
    totals.coarser += item.lower_edges != 0 ? 1 : 0;
    const std::uint32_t first = drawn.add_to(edges);
    for_each_triangle(item, tables.indices,
                      [&](const std::uint16_t* corners) { edges.use_triangle(corners, first); });
  }
  totals.nodes += parts.view.items().size();
  Camera at_voxel = camera;
  at_voxel.voxel = glm::ivec3(0);
  const Frustum frustum = make_frustum(at_voxel);
  const double step_m = info.basis.height_unit_m / kVertexStep;
  const glm::dvec3 corner = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
  // Metres: rounding of the coarsest, and of floats that far away.
  const double slack_m = std::ldexp(16.0, info.top_size()) * step_m;
  totals.edges += edges.count();
  edges.for_each_open([&](const FrameEdges::Edge& edge) {
    if (!info.is_cube() && edge.times == edge.back) return;  // what has no area lies on itself
    const glm::dvec3 a = (glm::dvec3(edge.from) + corner) * step_m;
    const glm::dvec3 b = (glm::dvec3(edge.to) + corner) * step_m;
    bool out_of_view = false;
    for (const Plane& plane : frustum.planes) {
      out_of_view =
          out_of_view || (request.culls && glm::dot(plane.normal, edge.from) + plane.offset < 0.0f &&
                          glm::dot(plane.normal, edge.to) + plane.offset < 0.0f);
    }
    bool at_rim = false;
    GridPlace ga, gb;
    if (!info.is_cube() && grid_of(info.basis, a, ga) && grid_of(info.basis, b, gb)) {
      const double low = info.basis.height_m(info.low) + slack_m;
      at_rim = ga.height_m <= low && gb.height_m <= low;
      // One that closes has ends in the north and the south alone.
      const double near = 0.25 + slack_m / (info.steps[1] * step_m);
      const double last = double(info.samples[1] - 1);
      if (info.closes()) at_rim = at_rim && std::min(std::abs(ga.k), std::abs(ga.k - last)) <= near;
    }
    // Behind the horizon nothing is drawn.
    bool hidden = false;
    LevelShape shape;
    if (request.culls && info.basis.is_ellipsoid() && level_shape(info.basis, shape)) {
      // Where the ellipsoid is the unit sphere.
      const glm::dvec3 eye = shape.scale * ((corner + glm::dvec3(camera.fine)) * step_m - shape.centre_m);
      const double low = 1 + info.basis.height_m(info.low) / info.basis.polar_radius_m();
      const glm::dvec3 way = shape.scale * (a - shape.centre_m) - eye;
      const double along = std::clamp(-glm::dot(eye, way) / glm::dot(way, way), 0.0, 1.0);
      hidden = glm::length(eye + along * way) < low && along < 1.0;
    }
    totals.rim += 1;
    if (out_of_view || at_rim || hidden || testing::Test::HasFatalFailure()) return;
    FAIL() << "an edge from " << a.x << ' ' << a.y << ' ' << a.z << " to " << b.x << ' ' << b.y << ' ' << b.z
           << " is used " << edge.times << " times, the other way " << edge.back << " times";
  });
}

// Selects until no tile is lacking, or once.
void select(const GroundInfo& info, const GroundRequest& request, Parts& parts, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    parts.tiles.begin_frame();
    parts.pool.begin_frame();
    parts.tiles.poll();
    parts.view.select(info, request, parts.tiles, parts.pool);
    parts.tiles.ask();
    if (parts.view.result().lacks_tile == 0) break;
  }
  for (MorphRows rows; !(rows = parts.view.take_rows()).halves.empty();) {
    std::copy(rows.halves.begin(), rows.halves.end(),
              parts.rows.begin() + static_cast<std::ptrdiff_t>(rows.first_row) * kMorphRow);
  }
}

GroundInfo any_ground(Random& random, int kind) {
  switch (kind) {
    case 0:
      return planet(4 << random.below(5), std::exp2(test::between(random, 8, 23)));
    case 1:
      return region(2 + random.below(200), 2 + random.below(200), test::between(random, -179, 100),
                    test::between(random, -20, 60), std::exp2(test::between(random, -12, -2)));
    case 2:
      return tube(2 + random.below(200), 2 + random.below(200), std::exp2(test::between(random, 6, 12)), 1);
    case 3: {
      // Once around.
      const int around = 4 + random.below(300);
      const double step = 360.0 / around;
      if (around % 2 == 0)
        return region(around + 1, 2 + random.below(static_cast<int>(150 / step) + 1), -180, 75, step);
      const double radius_m = 2 * around / 6.283185307179586;
      return tube(around + 1, 2 + random.below(200), around % 3 == 0 ? -radius_m : radius_m, 2);
    }
    default:
      return tube(2 + random.below(200), 2 + random.below(200), -std::exp2(test::between(random, 6, 12)), 1);
  }
}

TEST(GroundOnABasis, EveryInnerEdgeIsUsedOnceByEachSide) {
  const Tables tables;
  Random random{20261128};
  const std::uint64_t frames = frames_wanted();
  Totals totals, of_planets;
  FrameEdges edges;
  std::uint64_t worlds = 0;
  while (totals.frames < frames) {
    test::show_progress(totals.frames, frames);
    const int kind = static_cast<int>(worlds++ % 6) % 5;  // planets twice
    const GroundInfo shape = any_ground(random, kind);
    const double rough = std::exp2(test::between(random, 0, 11));
    // Each sample's once: that takes most of the time.
    const MemoryGround::Heights noise = noise_over(shape, rough);
    std::vector<std::int32_t> heights(static_cast<std::size_t>(shape.samples[0] * shape.samples[1]));
    for (std::int64_t k = 0; k < shape.samples[1]; ++k) {
      for (std::int64_t i = 0; i < shape.samples[0]; ++i)
        heights[static_cast<std::size_t>(k * shape.samples[0] + i)] = noise(i, k);
    }
    const MemoryGround ground(
        shape,
        [&](std::int64_t i, std::int64_t k) {
          return heights[static_cast<std::size_t>(k * shape.samples[0] + i)];
        },
        any_errors(random, std::exp2(test::between(random, 0, 9))));
    const GroundInfo& info = ground.info();
    Parts parts(static_cast<std::uint32_t>(ground.tile_count()) + 1,
                static_cast<std::uint32_t>(test::between(random, 8, 1500)));
    MemoryGround::Source source(ground);
    source.comes = test::between(random, 0.05, 1);
    source.fails = test::between(random, 0, 0.3);
    parts.tiles.reset(source.source(), tile_of(ground.root()), ground.tile(tile_of(ground.root())));
    parts.view.reset();
    const LatticeBox box = ground_box(info);
    const glm::dvec3 low = glm::dvec3(box.min) / double{kStepsPerVoxel};
    const glm::dvec3 size = glm::dvec3(box.max) / double{kStepsPerVoxel} - low;
    for (int frame = 0; frame < 20; ++frame, ++totals.frames) {
      Camera camera;
      const auto projection = test::kAnyProjections[random.next() % std::size(test::kAnyProjections)];
      CameraMatrices matrices =
          test::any_matrices(random, projection, 0.01, std::max({size.x, size.y, size.z}));
      // Towards a place of the ground.
      GridPlace at{double(info.samples[0] - 1) * random.unit(), double(info.samples[1] - 1) * random.unit(),
                   0, 0};
      if (info.is_cube()) {
        at.face = random.below(6);
        int x = 0, z = 0;
        cube_cell(at.face, x, z);
        const double quads = info.basis.face_quads;
        // Often at an edge or a corner.
        const auto part = [&] {
          const int kind_of = random.below(4);
          return kind_of == 0 ? 0.0 : kind_of == 1 ? 1.0 : random.unit();
        };
        at.i = quads * (x + part());
        at.k = quads * (z + part());
      }
      const glm::dvec3 target = place_m(info.basis, at) / voxel_m(info);
      test::show(random, target, std::exp2(test::between(random, -3, 7)), matrices);
      if (!make_camera(matrices, camera).ok()) continue;
      GroundRequest request;
      request.camera = &camera;
      request.error_px = std::exp2(test::between(random, -2, 5));
      request.scale = make_error_scale(camera, 640, 360, request.error_px);
      request.culls = random.next() % 2 == 0;
      const std::uint64_t before = test::heap_calls();
      parts.tiles.begin_frame();
      parts.pool.begin_frame();
      parts.tiles.poll();
      parts.view.select(info, request, parts.tiles, parts.pool);
      parts.tiles.ask();
      EXPECT_EQ(test::heap_calls() - before, 0u);
      for (MorphRows rows; !(rows = parts.view.take_rows()).halves.empty();) {
        std::copy(rows.halves.begin(), rows.halves.end(),
                  parts.rows.begin() + static_cast<std::ptrdiff_t>(rows.first_row) * kMorphRow);
      }
      totals.refused += parts.view.result().refused;
      const std::uint64_t rim = totals.rim, edges_before = totals.edges;
      check_edges(ground, request, parts, tables, edges, totals);
      if (info.is_cube() && !request.culls) {
        // A planet has no border at all.
        ++of_planets.frames;
        of_planets.edges += totals.edges - edges_before;
        EXPECT_EQ(totals.rim, rim);
      }
      if (HasFatalFailure()) {
        std::printf("basis %d, %lld x %lld, frame %d, culls %d\n", kind,
                    static_cast<long long>(info.samples[0]), static_cast<long long>(info.samples[1]), frame,
                    request.culls ? 1 : 0);
        return;
      }
    }
  }
  const auto figure = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf(
      "FIGURE curved bases: %llu frames, %llu edges, %llu of them at the feet of walls, out of view or "
      "behind the horizon; %llu nodes, %llu of them beside coarser ones; %llu splits refused, %llu "
      "vertices on their way; whole planets: %llu frames, %llu edges, no border\n",
      figure(totals.frames), figure(totals.edges), figure(totals.rim), figure(totals.nodes),
      figure(totals.coarser), figure(totals.refused), figure(totals.moving), figure(of_planets.frames),
      figure(of_planets.edges));
  EXPECT_GT(totals.coarser, totals.frames / 2);
  EXPECT_GT(totals.refused, 0u);
  EXPECT_GT(totals.moving, totals.frames);
  EXPECT_GT(of_planets.frames, 0u);
}

// The full surface of a ground whose heights a function of the sample says, metres.
glm::dvec3 full_place(const GroundInfo& info, int face, const MemoryGround::Heights& heights, double i,
                      double k) {
  const auto first_i = static_cast<std::int64_t>(i), first_k = static_cast<std::int64_t>(k);
  const double u = i - double(first_i), v = k - double(first_k);
  const auto at = [&](std::int64_t a, std::int64_t b) {
    // Beyond the last one counts nothing.
    const std::int64_t x = std::min(first_i + a, info.samples[0] - 1);
    const std::int64_t z = std::min(first_k + b, info.samples[1] - 1);
    return place_m(info.basis, {double(x), double(z), info.basis.height_m(heights(x, z)), face});
  };
  const glm::dvec3 p00 = at(0, 0), p10 = at(1, 0), p01 = at(0, 1), p11 = at(1, 1);
  if ((first_i + first_k) % 2 == 0) {
    return u > v ? p00 + u * (p10 - p00) + v * (p11 - p10) : p00 + v * (p01 - p00) + u * (p11 - p01);
  }
  return u + v < 1 ? p00 + u * (p10 - p00) + v * (p01 - p00)
                   : p11 + (1 - u) * (p01 - p11) + (1 - v) * (p10 - p11);
}

TEST(GroundOnABasis, NoDrawnPointIsFurtherFromTheFullSurfaceThanStated) {
  const Tables tables;
  Random random{8};
  double most = 0, sum = 0;
  std::uint64_t points = 0, frames = 0, beyond = 0, seams = 0;
  const std::uint64_t wanted = frames_wanted() / 4;
  // Grid places of a page's vertices.
  std::array<glm::ivec2, kNodeVertices> grid;
  for (int k = 0; k < kNodeSide; ++k) {
    for (int i = 0; i < kNodeSide; ++i)
      grid[static_cast<std::size_t>(vertex_order(kNodeLevel, k, i))] = {i, k};
  }
  for (int world = 0; frames < wanted; ++world) {
    const std::int64_t side = (std::int64_t{4} << (2 + random.below(4))) + 1;
    GroundInfo shape;
    switch (world % 4) {
      case 0:
        shape = planet(static_cast<std::int32_t>(side - 1), 6.4e6);
        break;
      case 1:
        shape = region(side, side, 6, test::between(random, 20, 60), 20.0 / double(side));
        break;
      case 2:
        shape = tube(side, side, world % 8 == 2 ? 60.0 : -60.0, 1);
        break;
      default: {
        // Three or five nodes around of some size: the seam lies in a family's middle.
        const std::int64_t around = (side - 1) / 16 * (world % 8 == 3 ? 12 : 20);
        shape = tube(around + 1, side,
                     double(around) / (world % 16 < 8 ? 6.283185307179586 : -6.283185307179586), 1);
        break;
      }
    }
    shape.basis.most_bend_m = std::numeric_limits<double>::infinity();
    // Waves by place, which fit over edges.
    const double spacing_m = shape.basis.height_unit_m * kMostCurvedSteps / kVertexStep;
    const double tall = std::exp2(test::between(random, 0, 10));
    const double length_m = spacing_m * double(side) / test::between(random, 1, 8);
    const auto heights = [&shape, tall, length_m](std::int64_t i, std::int64_t k) {
      int face = 0;
      if (shape.is_cube()) {
        face = cube_home(shape.basis.face_quads, i, k);
      }
      const glm::dvec3 p = place_m(shape.basis, {double(i), double(k), 0, face}) * (6.28 / length_m);
      return static_cast<std::int32_t>(tall * (std::sin(p.x) + std::sin(p.y + 1) + std::sin(p.z + 2)));
    };
    const MemoryGround ground(shape, heights);
    const GroundInfo& info = ground.info();
    const double voxel = voxel_m(info);
    Parts parts(static_cast<std::uint32_t>(ground.tile_count()) + 1, 6000);
    MemoryGround::Source source(ground);
    parts.tiles.reset(source.source(), tile_of(ground.root()), ground.tile(tile_of(ground.root())));
    parts.view.reset();
    for (int n = 0; n < 8; ++n, ++frames) {
      Camera camera;
      const auto kind = test::kAnyProjections[random.next() % std::size(test::kAnyProjections)];
      CameraMatrices matrices = test::any_matrices(random, kind, 0.02, double(side) * 0.25);
      GridPlace at{double(side - 1) * random.unit(), double(side - 1) * random.unit(), 0, 0};
      if (info.closes()) at.i = double(info.samples[0] - 1) * (1 - 0.02 * random.unit());  // at its seam
      if (info.is_cube()) {
        at.face = random.below(6);
        int x = 0, z = 0;
        cube_cell(at.face, x, z);
        at.i += double(x) * info.basis.face_quads;
        at.k += double(z) * info.basis.face_quads;
      }
      test::show(random, place_m(info.basis, at) / voxel, std::exp2(test::between(random, -2, 6)), matrices);
      if (!make_camera(matrices, camera).ok()) continue;
      GroundRequest request;
      request.camera = &camera;
      request.error_px = std::exp2(test::between(random, -1, 5));
      request.scale = make_error_scale(camera, 640, 360, request.error_px);
      select(info, request, parts, 16);
      const double bound = double{parts.view.result().bound_px};
      const glm::dmat4 clip = glm::dmat4(clip_from_lattice(camera));
      const glm::dvec3 corner = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
      for (std::size_t n_item = 0; n_item < parts.view.items().size(); ++n_item) {
        const DrawItem& item = parts.view.items()[n_item];
        const GroundView::Node& node = parts.view.node_of(n_item);
        const int face = face_of(info, node.key);
        const DrawnNode drawn(info, camera, request.scale, node, tables.entries, parts.rows,
                              node.key.size == info.top_size());
        // Beyond the last sample vertices move sideways: a place of the grid is none of the surface.
        if (!info.is_cube() &&
            (std::int64_t{node.key.x} + 1) * kNodeQuads << node.key.size > info.samples[0] - 1)
          continue;
        seams += has_seam_inside(info, node.key.parent()) ? 1u : 0u;
        for_each_triangle(item, tables.indices, [&](const std::uint16_t* corners) {
          if (std::max({corners[0], corners[1], corners[2]}) >= kNodeVertices) return;
          double a = random.unit(), b = random.unit();
          if (a + b > 1) a = 1 - a, b = 1 - b;
          const double weights[3] = {1 - a - b, a, b};
          glm::dvec3 place(0.0);
          glm::dvec2 sample(0.0);
          for (int c = 0; c < 3; ++c) {
            place += glm::dvec3(drawn.place(corners[c])) * weights[c];
            const glm::ivec2 own = grid[corners[c]];
            sample += glm::dvec2(double((std::int64_t{node.key.x} * kNodeQuads + own.x) << node.key.size),
                                 double((std::int64_t{node.key.z} * kNodeQuads + own.y) << node.key.size)) *
                      weights[c];
          }
          const glm::dvec3 full =
              full_place(info, face, heights, sample.x, sample.y) * (kStepsPerVoxel / voxel) - corner;
          const glm::dvec4 p = clip * glm::dvec4(place, 1), f = clip * glm::dvec4(full, 1);
          const bool in_front = p.w > 0 && f.w > 0 && p.z >= -p.w && f.z >= -f.w;
          if (!in_front || std::abs(p.x) > p.w || std::abs(p.y) > p.w) return;
          const double px = std::hypot((p.x / p.w - f.x / f.w) * 320, (p.y / p.w - f.y / f.w) * 180);
          ++points;
          sum += px / request.error_px;
          most = std::max(most, px / bound);
          beyond += px > bound ? 1 : 0;
        });
      }
    }
  }
  std::printf(
      "FIGURE curved bases: %llu points, off by %.3f of the stated bound at most, %.3f of the wanted one "
      "in the mean; %llu beyond\n",
      static_cast<unsigned long long>(points), most, sum / double(points),
      static_cast<unsigned long long>(beyond));
  EXPECT_GT(points, 10'000u);
  EXPECT_EQ(beyond, 0u);
  EXPECT_GT(seams, 0u);
}

// A node somewhere, with a tile of its own, as an eye 2 m above its middle sees it.
struct Standing {
  Standing(const GroundInfo& ground, NodeKey node, const MemoryGround::Heights& heights) : info(ground) {
    for (const NodeKey at : {node, node.parent()}) {
      Tile& tile = at == node ? own : coarser;
      const NodeKey key = tile_of(at);
      for (int k = -kTileRim; k <= kTileQuads + kTileRim; ++k) {
        for (int i = -kTileRim; i <= kTileQuads + kTileRim; ++i) {
          tile.heights[(k + kTileRim) * kTileSide + i + kTileRim] =
              heights(sample_of(info.samples[0], at.size, std::int64_t{key.x} * kTileQuads + i),
                      sample_of(info.samples[1], at.size, std::int64_t{key.z} * kTileQuads + k));
        }
      }
    }
    place = {};
    place.key = node;
    place.tile = &own;
    place.parent_family = 0;
  }

  // shares: 0 at home, 1 arrived.
  DrawnNode drawn(const Camera& camera, const Tables& tables, bool parent, bool arrived) const {
    const std::vector<std::uint16_t> rows(2 * kMorphRow, arrived ? std::uint16_t{0} : kNeverMorphs);
    GroundView::Node node = place;
    if (parent) {
      node.key = place.key.parent();
      node.tile = &coarser;
    }
    return {info, camera, make_error_scale(camera, 1280, 720, 1.0), node, tables.entries, rows, false};
  }

  const GroundInfo& info;
  Tile own{}, coarser{};
  GroundView::Node place;
};

struct Figures {
  double lattice_m = 0, drawn_m = 0;  // off double: vertices, and as floats near the eye besides
  double axis_units = 0;              // vertices, along an axis of the frame, of kVertexStep
  int shared = 0;
};

void stand(const GroundInfo& info, NodeKey node, const Tables& tables, Figures& figures) {
  const auto heights = noise_over(info, 400);
  const Standing here(info, node, heights);
  const int face = face_of(info, node);
  const double step_m = info.basis.height_unit_m / kVertexStep;
  // The eye, 2 m up.
  const GridPlace middle{node.x * 4.0 + 2, node.z * 4.0 + 2,
                         info.basis.height_m(heights(node.x * 4 + 2, node.z * 4 + 2)) + 2.0, face};
  CameraMatrices matrices;
  matrices.position = place_m(info.basis, middle) / (step_m * kStepsPerVoxel);
  matrices.clip_from_view = Camera().clip_from_view;
  Camera camera;
  ASSERT_TRUE(make_camera(matrices, camera).ok());
  const glm::dvec3 corner = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
  const DrawnNode home = here.drawn(camera, tables, false, false);
  for (int k = 0; k < kNodeSide; ++k) {
    for (int i = 0; i < kNodeSide; ++i) {
      const std::int64_t x = node.x * 4 + i, z = node.z * 4 + k;
      const glm::dvec3 exact =
          place_m(info.basis, {double(x), double(z), info.basis.height_m(heights(x, z)), face});
      const NodePlaces places(info, node);
      const glm::dvec3 lattice =
          glm::dvec3(places.at(i, k, heights(x, z)) * std::int64_t{kVertexStep}) * step_m;
      const auto v = static_cast<std::uint32_t>(vertex_order(kNodeLevel, k, i));
      const glm::dvec3 drawn = (glm::dvec3(home.place(v)) + corner) * step_m;
      figures.lattice_m = std::max(figures.lattice_m, glm::distance(lattice, exact));
      const glm::dvec3 off = glm::abs(lattice - exact) / info.basis.height_unit_m;
      figures.axis_units = std::max({figures.axis_units, off.x, off.y, off.z});
      figures.drawn_m = std::max(figures.drawn_m, glm::distance(drawn, lattice));
    }
  }
  // Each node around has the vertices of the edge or corner between them, with the same bits; so has the
  // parent's, at home, those of this one that have arrived.
  const DrawnNode arrived = here.drawn(camera, tables, false, true);
  const auto count_of = [](const DrawnNode& in, const DrawnNode& of) {
    int count = 0;
    for (std::uint32_t a = 0; a < kNodeVertices; ++a) {
      for (std::uint32_t b = 0; b < kNodeVertices; ++b)
        count += in.place(a) == of.place(b) ? 1 : 0;  // no NaN, and -0 is 0: bits
    }
    return count;
  };
  const DrawnNode parent = here.drawn(camera, tables, true, false);
  EXPECT_GE(count_of(parent, arrived), 9);
  int around = 0;
  for (int south = -1; south <= 1; ++south) {
    for (int east = -1; east <= 1; ++east) {
      NodeKey other{node.size, node.x + east, node.z + south};
      if (east == 0 && south == 0) continue;
      if (!neighbour_of(info, node, east, south, other)) continue;
      const Standing there(info, other, heights);
      const int shared = count_of(there.drawn(camera, tables, false, false), home);
      // Near a pole others lie on the same place, too.
      EXPECT_GE(shared, east != 0 && south != 0 ? 1 : kNodeSide) << east << ' ' << south;
      figures.shared += shared;
      ++around;
    }
  }
  EXPECT_GE(around, 7);
}

// A vertex lies within half a kVertexStep of its place, along each axis: it is rounded once. That step is a
// 4,096th of the way between samples, or of the longer one. Beyond that nothing is lost near the eye.
void expect_rounded_once(const Figures& figures, const GroundInfo& info, double spacing_m) {
  const double unit_m = info.basis.height_unit_m;
  EXPECT_NEAR(unit_m, spacing_m / 4096, 1e-9);
  // What double itself has of a place so far from the earth's centre.
  EXPECT_LE(figures.axis_units, 0.5 + 4e-9 / unit_m);
  EXPECT_GT(figures.axis_units, 0.45);
  EXPECT_LE(figures.lattice_m, std::sqrt(0.75) * unit_m + 4e-9);
  // Places from the eye, as floats, half a node away at most.
  EXPECT_LE(figures.drawn_m, 2e-7 * spacing_m);
}

TEST(GroundOnABasis, AnEyeAtTwoMetresStandsAnywhere) {
  const Tables tables;
  // Samples of 1 m and of 4.7 m, by longitude and latitude: within a millimetre.
  for (const double spacing_m : {1.0, 4.7}) {
    for (const double latitude : {0.0, 45.0, 89.99}) {
      const double step_deg = spacing_m / 111'694.4;
      const GroundInfo info =
          region(4097, 1025, 7.0, std::min(latitude + 0.0046 * spacing_m, 90.0), step_deg);
      Figures figures;
      for (const int x : {1, 300, 511, 700, 1020}) {
        for (const int z : {1, 60, 127, 200, 250}) stand(info, {0, x, z}, tables, figures);
      }
      expect_rounded_once(figures, info, spacing_m);
      EXPECT_LE(figures.lattice_m + figures.drawn_m, 1e-3) << latitude;
      std::printf(
          "FIGURE latitude %g, samples of %g m: vertices off double by %.3g m, as floats by %.2g m "
          "more; %d shared\n",
          latitude, spacing_m, figures.lattice_m, figures.drawn_m, figures.shared);
    }
  }
  // The finest planet, on the corners of its faces, on their edges and inside.
  const GroundInfo info = planet(kMostFaceQuads, kWgs84RadiusM);
  const int side = kMostFaceQuads / 4;
  Figures figures;
  for (int face = 0; face < kCubeFaces; ++face) {
    int x = 0, z = 0;
    cube_cell(face, x, z);
    for (const int i : {0, side / 2, side - 1}) {
      for (const int k : {0, side / 2, side - 1})
        stand(info, {0, x * side + i, z * side + k}, tables, figures);
    }
  }
  const double spacing_m = info.basis.height_unit_m * kMostCurvedSteps / kVertexStep;
  expect_rounded_once(figures, info, spacing_m);
  std::printf(
      "FIGURE planet of %.1f m samples, corners and edges of faces too: vertices off double by %.3g m, "
      "as floats by %.2g m more; %d shared\n",
      spacing_m, figures.lattice_m, figures.drawn_m, figures.shared);
}

// Where a ground that closes begins and ends: vertices of both sides, their normals and targets.
TEST(GroundOnABasis, AGroundThatClosesHasNoSeam) {
  int vertices = 0;
  for (const bool is_tube : {false, true}) {
    const int around = 192;
    const GroundInfo shape = is_tube ? tube(around + 1, 70, around / 6.283185307179586, 1)
                                     : region(around + 1, 70, -180, 80, 360.0 / around);
    ASSERT_TRUE(shape.closes());
    const MemoryGround ground(shape, noise_over(shape, 300));
    const GroundInfo& info = ground.info();
    for (int size = 0; size <= info.top_size(); ++size) {
      for (int z = 0; node_exists(info, {size, 0, z}); ++z) {
        const NodeKey east{size, 0, z}, west{size, last_column(info, size), z};
        NodeKey neighbour;
        ASSERT_TRUE(neighbour_of(info, west, 1, 0, neighbour));
        EXPECT_EQ(neighbour, east);
        ASSERT_TRUE(neighbour_of(info, east, -1, 0, neighbour));
        EXPECT_EQ(neighbour, west);
        EXPECT_EQ(node_walls(info, east) & 5u, 0u);
        EXPECT_EQ(node_walls(info, west) & 5u, 0u);
        std::array<GpuVertex, kNodePageVertices> sides[2];
        glm::ivec3 origins[2];
        for (const int side : {0, 1}) {
          const NodeKey key = side == 0 ? west : east;
          const Tile& tile = ground.tile(tile_of(key));
          MakeNode{&info, &tile, key, true, sides[side]}.run();
          origins[side] = node_origin(info, tile.nodes[node_in_tile(key)], key);
        }
        // Normals where edges of nodes lie on the seam, of the parent's size too.
        const bool even = around % (kNodeQuads << size) == 0, even_next = around % (8 << size) == 0;
        for (int k = 0; k < kNodeSide; ++k) {
          const GpuVertex& a = sides[0][static_cast<std::size_t>(vertex_order(kNodeLevel, k, kNodeQuads))];
          const GpuVertex& b = sides[1][static_cast<std::size_t>(vertex_order(kNodeLevel, k, 0))];
          for (int axis = 0; axis < 3; ++axis) {
            const int between = (origins[1][axis] - origins[0][axis]) * kStepsPerVoxel;
            EXPECT_EQ(a.position[axis], b.position[axis] + between) << size << ' ' << z << ' ' << k;
            EXPECT_EQ(a.morph[axis], b.morph[axis] + between) << size << ' ' << z << ' ' << k;
          }
          if (even) {
            EXPECT_EQ(a.normal, b.normal) << size << ' ' << z << ' ' << k;
          }
          if (even_next) {
            EXPECT_EQ(a.morph_normal, b.morph_normal) << size << ' ' << z << ' ' << k;
          }
          ++vertices;
        }
      }
    }
  }
  EXPECT_GT(vertices, 200);
}

}  // namespace
}  // namespace karst::core
