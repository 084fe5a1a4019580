// SPDX-License-Identifier: MIT
// What is chosen of an isosurface for any eyes fills the field once, keeps what ExtractBlock asks for, and is
// closed as it lies in pages; memory is what was given. And how far blocks of a level are off.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <tuple>
#include <unordered_map>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/blocks/isosurface.h"
#include "terrain/draw/expand_indices.h"
#include "terrain/draw/index_batches.h"
#include "terrain/edit/field/edit_field.h"
#include "tests/support/field_shapes.h"
#include "tests/support/test_world.h"

namespace karst::test {
namespace {

Config config_of(glm::ivec3 blocks, std::uint32_t pages) {
  Config config;
  config.field_blocks = config.field_sample_blocks =
      static_cast<std::uint32_t>(blocks.x * blocks.y * blocks.z);
  config.field_meshes = 2'000;
  config.field_vertex_pages = config.field_index_pages = pages;
  return config;
}

// A field and what is drawn of it. The GPU's vertices are kept by page.
struct Scene {
  Scene(glm::ivec3 blocks, std::uint32_t pages, const FieldShape& shape, int cell_log2 = 13,
        glm::ivec3 corner = glm::ivec3(0))
      : config(config_of(blocks, pages)),
        memory(bytes()),
        arena(memory.bytes()),
        vertices(32 * pages),
        drawn_in(pages, -10) {
    FieldBlocks::Storage storage;
    storage.each_block(config, TakeBlocks(arena));
    field.create(storage);
    FieldInfo info = field_info(blocks, config.field_sample_blocks);
    info.cell_log2 = cell_log2;
    info.corner = corner;
    EXPECT_TRUE(field.reset(info).ok());
    fill_field(field, shape);
    EXPECT_TRUE(isosurface.create(config, arena).ok());
    EXPECT_EQ(arena.used(), memory.bytes().size());
    isosurface.attach(field);
  }
  std::size_t bytes() const {
    Budget budget;
    FieldBlocks::Storage storage;
    storage.each_block(config, CountBlocks(budget));
    Isosurface::add_to(budget, config);
    return budget.cpu_bytes();
  }
  void begin_frame() {
    ++frame;
    isosurface.begin_frame();
  }
  // The next meshes of what was chosen, at most so many; copied as a renderer would, to pages that none of
  // the frames draws that may be in flight.
  int make(int most) {
    MeshUpload upload;
    Status status;
    int count = 0;
    for (; count < most && isosurface.make_next(upload, status); ++count) {
      const MeshPages pages = isosurface.pool().pages(0);
      std::uint32_t page = upload.first_page;
      for (std::size_t done = 0; done < upload.vertices.size(); page = pages.next_page[page]) {
        const std::size_t n = std::min<std::size_t>(32, upload.vertices.size() - done);
        std::copy_n(upload.vertices.begin() + static_cast<std::ptrdiff_t>(done), n,
                    vertices.begin() + static_cast<std::ptrdiff_t>(32 * std::size_t{page}));
        EXPECT_GE(frame - drawn_in[page], static_cast<int>(kFramesInFlight));
        isosurface.pool().texels()[page] =
            make_page_texel(upload.origin, upload.size, kMeshPlace, 0, 0, false);
        done += n;
      }
    }
    EXPECT_TRUE(status.ok()) << status.field();
    return count;
  }
  // Everything that is drawn, in lattice steps, as the index stream has it.
  struct Triangle {
    std::array<glm::i64vec3, 3> at;
  };
  std::vector<Triangle> drawn() {
    const Isosurface::List list = isosurface.list(0, nullptr);
    ExpandIndices expand;
    std::vector<std::uint16_t> table(index_count(1));
    EXPECT_TRUE(build_index_tables(1, table).ok());
    expand.table = table;
    expand.meshes = list.items;
    expand.mesh_pages = isosurface.pool().pages(0);
    std::vector<std::uint32_t> out(1'000), all;
    expand.out = out;
    EXPECT_TRUE(expand.validate(1).ok());
    for (ExpandIndices::Chunk chunk; chunk.next_item < expand.count();) {
      chunk = expand.run(chunk.next_item);
      EXPECT_EQ(chunk.left_out, 0u);
      EXPECT_GT(chunk.indices, 0u);
      if (chunk.indices == 0) break;
      all.insert(all.end(), out.begin(), out.begin() + chunk.indices);
    }
    EXPECT_EQ(all.size(), 3 * std::size_t{list.triangles});
    std::vector<Triangle> triangles(all.size() / 3);
    for (std::size_t n = 0; n < all.size(); ++n) {
      triangles[n / 3].at[n % 3] = place(all[n]);
      drawn_in[all[n] / 32] = frame;
    }
    return triangles;
  }
  glm::i64vec3 place(std::uint32_t vertex) {
    const GpuVertex& v = vertices[vertex];
    const PageTexel& t = isosurface.pool().texels()[vertex / 32];
    EXPECT_EQ(t.place & 255u, kMeshPlace);
    const int size = static_cast<int>(t.y_size >> 26 & 31u);
    const auto y = static_cast<std::int32_t>(t.y_size << 6) >> 6;
    const glm::i64vec3 origin(static_cast<std::int32_t>(t.x), y, static_cast<std::int32_t>(t.z));
    return (origin * std::int64_t{8192} + glm::i64vec3(v.position[0], v.position[1], v.position[2])) *
           (std::int64_t{1} << size);
  }

  Config config;
  AlignedBytes memory;
  Arena arena;
  FieldBlocks field;
  Isosurface isosurface;
  std::vector<GpuVertex> vertices;
  int frame = 0;
  std::vector<int> drawn_in;  // by page, the last frame that drew it
};

BlockEye eye_at(glm::dvec3 steps, float steps_per_step) {
  BlockEye eye;
  eye.eye.eye = glm::vec3(steps);
  eye.eye.least_cos2 = 0.4f;
  eye.eye.forward = glm::vec3(0, 0, -1);
  eye.steps_per_step = steps_per_step;
  return eye;
}

// Edges that are not there once each way.
std::size_t open_edges(const std::vector<Scene::Triangle>& triangles) {
  using Edge = std::array<std::int64_t, 6>;
  std::vector<Edge> ahead_edges, back_edges;
  for (const Scene::Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::i64vec3 a = t.at[k], b = t.at[(k + 1) % 3];
      const bool ahead = std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
      const glm::i64vec3 c = ahead ? a : b, d = ahead ? b : a;
      (ahead ? ahead_edges : back_edges).push_back({c.x, c.y, c.z, d.x, d.y, d.z});
    }
  }
  std::sort(ahead_edges.begin(), ahead_edges.end());
  std::sort(back_edges.begin(), back_edges.end());
  std::vector<Edge> apart;
  std::set_symmetric_difference(ahead_edges.begin(), ahead_edges.end(), back_edges.begin(), back_edges.end(),
                                std::back_inserter(apart));
  return apart.size();
}

double waves(glm::dvec3 p, unsigned seed) {
  double sum = 0;
  Random random{seed};
  for (int n = 0; n < 10; ++n) {
    const glm::dvec3 way(random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5);
    sum += std::sin(glm::dot(way, p) * (0.1 + 0.4 * random.unit()) + 6.3 * random.unit());
  }
  return sum;
}

// Closed within the field.
FieldShape lumps(glm::dvec3 size, unsigned seed) {
  return [=](glm::dvec3 p) {
    const glm::dvec3 side = glm::min(p, size - 1.0 - p) - 3.0;
    return std::max(2 * waves(p, seed), -std::min(side.x, std::min(side.y, side.z)));
  };
}

TEST(Blocks, WhatIsChosenKeepsWhatExtractionAsksFor) {
  constexpr glm::ivec3 kBlocks(7, 5, 9);
  Scene scene(kBlocks, 64, lumps(glm::dvec3(kBlocks * 16), 3));
  BlockTree tree = scene.isosurface.tree();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-0.3, 1.3);
  std::vector<ChosenBlock> chosen(2'000);
  std::size_t mixed = 0, diagonal_candidates = 0;
  for (std::size_t n = 0; n < 200; ++n) {
    std::array<BlockEye, 2> eyes;
    for (BlockEye& eye : eyes) {
      const glm::dvec3 at(any(random), any(random), any(random));
      eye = eye_at(at * glm::dvec3(kBlocks * (16 * 8192)), std::exp2f(static_cast<float>(n % 7) - 2));
    }
    const std::size_t count = tree.choose(std::span(eyes).first(1 + n % 2), 0, chosen);
    ASSERT_LE(count, chosen.size());
    // Nothing is made where there are no samples.
    for (const ChosenBlock& c : std::span(chosen).first(count)) {
      const glm::ivec3 end = (c.block.place() + 1) << int{c.block.level};
      ASSERT_TRUE(glm::all(glm::lessThanEqual(end, kBlocks))) << n;
    }
    // The level of each place of the finest.
    std::map<std::array<int, 3>, int> level_at;
    tree.each_chosen([&](BlockKey key) {
      const glm::ivec3 low = key.place() << int{key.level};
      for (int o = 0; o < 1 << (3 * key.level); ++o) {
        const int mask = (1 << key.level) - 1;
        const glm::ivec3 at = low + glm::ivec3(o & mask, o >> key.level & mask, o >> (2 * key.level));
        if (at.x >= kBlocks.x || at.y >= kBlocks.y || at.z >= kBlocks.z) continue;
        const bool is_new = level_at.insert({{at.x, at.y, at.z}, key.level}).second;
        ASSERT_TRUE(is_new);
      }
    });
    ASSERT_EQ(level_at.size(), static_cast<std::size_t>(kBlocks.x * kBlocks.y * kBlocks.z));
    std::array<int, 9> of_level{};
    for (const auto& [at, level] : level_at) {
      ++of_level[static_cast<std::size_t>(level)];
      for (int o = 0; o < 27; ++o) {
        const auto beside = level_at.find({at[0] + o % 3 - 1, at[1] + o / 3 % 3 - 1, at[2] + o / 9 - 1});
        if (beside == level_at.end()) continue;
        ASSERT_LE(std::abs(beside->second - level), 1);
      }
      // Around each edge that begins here, along each axis.
      for (int axis = 0; axis < 3; ++axis) {
        std::array<int, 4> around{};
        bool whole = true;
        for (int k = 0; k < 4; ++k) {
          std::array<int, 3> there = at;
          there[static_cast<std::size_t>((axis + 1) % 3)] -= k & 1;
          there[static_cast<std::size_t>((axis + 2) % 3)] -= k >> 1;
          const auto found = level_at.find(there);
          whole = whole && found != level_at.end();
          if (whole) around[static_cast<std::size_t>(k)] = found->second;
        }
        if (!whole) continue;
        const auto [a, b, c, d] = around;
        ASSERT_FALSE(a == d && b == c && a != b) << n;
        diagonal_candidates += a != b || c != d;
      }
    }
    mixed += std::count_if(of_level.begin(), of_level.end(), [](int c) { return c > 0; }) > 1;
  }
  EXPECT_GT(mixed, 60u);
  EXPECT_GT(diagonal_candidates, 1'000u);
}

TEST(Blocks, AreClosedInTheirPages) {
  struct Case {
    int cell_log2;
    glm::ivec3 corner;
  };
  for (const Case& c : {Case{13, {0, 0, 0}}, Case{12, {3, 17, 101}}, Case{10, {77, 1, 5}}}) {
    constexpr glm::ivec3 kBlocks(6, 4, 5);
    Scene scene(kBlocks, 8'000, lumps(glm::dvec3(kBlocks * 16), 4), c.cell_log2, c.corner);
    const glm::dvec3 size(kBlocks * (16 << c.cell_log2));
    std::mt19937 random(9);
    std::uniform_real_distribution<double> any(-0.2, 1.2);
    std::size_t transitions = 0;
    for (int n = 0; n < 12; ++n) {
      const glm::dvec3 at(any(random), any(random), any(random));
      const BlockEye eye =
          eye_at(glm::dvec3(c.corner * 8192) + at * size, static_cast<float>(std::exp2(n % 5)));
      scene.begin_frame();
      scene.isosurface.choose({&eye, 1});
      scene.make(1 << 20);
      ASSERT_TRUE(scene.isosurface.is_complete());
      const auto triangles = scene.drawn();
      ASSERT_GT(triangles.size(), 100u);
      EXPECT_EQ(open_edges(triangles), 0u) << n;
      for (const ChosenBlock& block : scene.isosurface.drawn()) transitions += block.around != 0;
      // Where it should be.
      for (const Scene::Triangle& t : triangles) {
        for (int axis = 0; axis < 3; ++axis) {
          const std::int64_t low = std::int64_t{c.corner[axis]} * 8192;
          ASSERT_GE(t.at[0][axis], low);
          ASSERT_LE(t.at[0][axis], low + (std::int64_t{kBlocks[axis]} << (4 + c.cell_log2)));
        }
      }
    }
    EXPECT_GT(transitions, 50u);
  }
}

TEST(Blocks, AreClosedInEveryFrameWhileEyesMoveAndMemoryIsShort) {
  constexpr glm::ivec3 kBlocks(6);
  const FieldShape shape = lumps(glm::dvec3(kBlocks * 16), 6);
  for (const std::uint32_t pages : {500u, 3'500u, 6'000u}) {
    Scene scene(kBlocks, pages, shape);
    std::mt19937 random(11);
    glm::dvec3 at(0.5, 0.5, 1.1);
    std::size_t incomplete = 0, changed = 0, last = 0;
    for (int frame = 0; frame < 40; ++frame) {
      at += 0.04 * glm::dvec3(std::sin(frame * 0.1), std::cos(frame * 0.07), std::sin(frame * 0.03));
      const BlockEye eye = eye_at(at * glm::dvec3(kBlocks * (16 * 8192)), 24);
      scene.begin_frame();
      if (scene.isosurface.is_complete()) scene.isosurface.choose({&eye, 1});
      scene.make(frame == 0 ? 1 << 20 : 5);
      incomplete += !scene.isosurface.is_complete();
      const auto triangles = scene.drawn();
      if (frame == 0 && triangles.empty()) continue;  // what is kept back is free two frames later
      EXPECT_EQ(open_edges(triangles), 0u) << frame << " " << pages;
      changed += triangles.size() != last;
      last = triangles.size();
    }
    EXPECT_GT(last, 0u) << pages;
    // With the least memory one block that holds all stays.
    EXPECT_GT(changed, pages == 500u ? 0u : 1u) << pages;
    if (pages > 500u) {
      EXPECT_GT(incomplete, 3u) << pages;
    }
    if (pages == 500u) {
      EXPECT_GT(scene.isosurface.error_scale(), 1.0f);
    }
  }
}

// --- How far blocks are off

double off_triangle(glm::dvec3 p, const std::array<glm::dvec3, 3>& t) {
  // The nearest point of a triangle (C. Ericson, Real-Time Collision Detection, 5.1.5).
  const glm::dvec3 a = t[0], b = t[1], c = t[2], ab = b - a, ac = c - a, ap = p - a;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return glm::length(ap);
  const glm::dvec3 bp = p - b;
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return glm::length(bp);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return glm::length(ap - ab * (d1 / (d1 - d3)));
  const glm::dvec3 cp = p - c;
  const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return glm::length(cp);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return glm::length(ap - ac * (d2 / (d2 - d6)));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return glm::length(bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
  const double sum = va + vb + vc;
  return glm::length(ap - ab * (vb / sum) - ac * (vc / sum));
}

using Mesh = std::vector<std::array<glm::dvec3, 3>>;

Mesh mesh_at(Scene& scene, int level) {
  Mesh mesh;
  BlockPool& pool = const_cast<BlockPool&>(scene.isosurface.pool());
  BlockTree tree = scene.isosurface.tree();
  std::vector<ChosenBlock> chosen(4'000);
  BlockEye eye = eye_at(glm::dvec3(0), 1e30f);
  const std::size_t count = tree.choose({&eye, 1}, level, chosen);
  pool.reset();
  for (std::size_t n = 0; n < count; ++n) {
    std::uint32_t made = 0;
    MeshUpload upload;
    EXPECT_TRUE(pool.make(scene.field, chosen[n], made, upload).ok());
    const MeshPages pages = pool.pages(0);
    std::uint32_t page = pool.mesh(made).first_index_page;
    std::array<glm::dvec3, 3> t;
    for (std::uint32_t i = 0; i < pool.mesh(made).indices; ++i) {
      if (i > 0 && i % kIndexPage == 0) page = pages.next_index_page[page];
      const GpuVertex& v = upload.vertices[pages.indices[page * kIndexPage + i % kIndexPage]];
      t[i % 3] =
          (glm::dvec3(upload.origin) * 8192.0 + glm::dvec3(v.position[0], v.position[1], v.position[2])) *
          std::ldexp(1.0, upload.size - scene.field.info().cell_log2);
      if (i % 3 == 2) mesh.push_back(t);
    }
  }
  return mesh;
}

// Points of a mesh: corners, middles of sides, and more within where triangles are large.
template <class Visit>
void each_point(const Mesh& mesh, int parts, const Visit& visit) {
  for (std::size_t n = 0; n < mesh.size(); ++n) {
    for (int i = 0; i <= parts; ++i) {
      for (int j = 0; i + j <= parts; ++j) {
        const glm::dvec3 weights = glm::dvec3(i, j, parts - i - j) / static_cast<double>(parts);
        visit(n, mesh[n][0] * weights.x + mesh[n][1] * weights.y + mesh[n][2] * weights.z);
      }
    }
  }
}

// Distances from a mesh, up to `most`, by triangles in places of a width.
class Near {
 public:
  Near(const Mesh& mesh, double width, double most) : mesh_(mesh), width_(width), most_(most) {
    for (std::size_t n = 0; n < mesh.size(); ++n) {
      const glm::ivec3 low = at(glm::min(mesh[n][0], glm::min(mesh[n][1], mesh[n][2])));
      const glm::ivec3 high = at(glm::max(mesh[n][0], glm::max(mesh[n][1], mesh[n][2])));
      for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
          for (int x = low.x; x <= high.x; ++x) places_[key({x, y, z})].push_back(n);
    }
  }
  double distance(glm::dvec3 p) const {
    double near = most_;
    const glm::ivec3 middle = at(p);
    // Shell by shell: what lies in the next one is at least so far.
    for (int r = 0; near > (r - 1) * width_; ++r) {
      for (int z = -r; z <= r; ++z) {
        for (int y = -r; y <= r; ++y) {
          const bool whole = std::abs(z) == r || std::abs(y) == r;
          for (int x = -r; x <= r; x += whole || r == 0 ? 1 : 2 * r) {
            const auto found = places_.find(key(middle + glm::ivec3(x, y, z)));
            if (found == places_.end()) continue;
            for (const std::size_t n : found->second) near = std::min(near, off_triangle(p, mesh_[n]));
          }
        }
      }
    }
    return near;
  }

 private:
  glm::ivec3 at(glm::dvec3 p) const { return glm::ivec3(glm::floor(p / width_)); }
  static std::int64_t key(glm::ivec3 at) { return (std::int64_t{at.x} * 4096 + at.y) * 4096 + at.z; }

  const Mesh& mesh_;
  double width_, most_;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> places_;
};

// Of each triangle how wide all is that hangs together with it.
std::vector<double> widths(const Mesh& mesh) {
  std::map<std::array<double, 3>, std::size_t> numbers;
  std::vector<std::size_t> first;
  const auto root = [&](std::size_t n) {
    while (first[n] != n) n = first[n] = first[first[n]];
    return n;
  };
  std::vector<std::size_t> of_triangle;
  std::vector<glm::dvec3> low, high;
  for (const auto& t : mesh) {
    std::array<std::size_t, 3> corner{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [at, is_new] = numbers.insert({{t[k].x, t[k].y, t[k].z}, first.size()});
      if (is_new) {
        first.push_back(first.size());
        low.push_back(t[k]);
        high.push_back(t[k]);
      }
      corner[k] = root(at->second);
    }
    for (const std::size_t other : {corner[1], corner[2]}) {
      const std::size_t a = root(corner[0]), b = root(other);
      first[b] = a;
      low[a] = glm::min(low[a], low[b]);
      high[a] = glm::max(high[a], high[b]);
    }
    of_triangle.push_back(corner[0]);
  }
  std::vector<double> out;
  for (const std::size_t n : of_triangle) out.push_back(glm::length(high[root(n)] - low[root(n)]));
  return out;
}

FieldShape torus(glm::dvec3 centre, double size) {
  return [=](glm::dvec3 p) {
    const glm::dvec3 q = p - centre;
    return std::hypot(std::hypot(q.x, q.z) - 2.8 * size, q.y) - size;
  };
}

// Both ways, block by block: what is measured is within what is stated, and where all is smooth that is not
// much more. A piece that a level lacks altogether is off by its width at most.
TEST(Blocks, AreWithinTheirStatedErrorsOfTheFinest) {
  constexpr glm::ivec3 kBlocks(6);
  const glm::dvec3 size(kBlocks * 16), centre = size / 2.0;
  struct Case {
    const char* name;
    FieldShape shape;
    double most;    // cells that are stated
    double factor;  // and how many times what is measured
  };
  constexpr double kAny = 1e9;
  const Case cases[] = {{"sphere", ball(centre + 0.37, 40), 0.3, 4.5},
                        {"torus", torus(centre, 10), 0.6, 2.5},
                        {"cave", gyroid_cave(centre, 42, 40), 4, kAny},
                        {"lumps", lumps(size, 8), kAny, kAny}};
  for (const Case& c : cases) {
    Scene scene(kBlocks, 30'000, c.shape);
    const BlockTree& tree = scene.isosurface.tree();
    const Mesh finest = mesh_at(scene, 0);
    const std::vector<double> width = widths(finest);
    for (int level = 1; level <= 3; ++level) {
      const Mesh coarse = mesh_at(scene, level);
      const double cell = std::ldexp(1.0, level), most = 6;
      std::map<std::array<int, 3>, double> off;
      double there = 0, back = 0, stated = 0, mean_measured = 0, mean_stated = 0;
      const auto note = [&](glm::dvec3 in, double distance) {
        const glm::ivec3 block(glm::floor(in / (cell * kIsoCells)));
        double& so_far = off[{block.x, block.y, block.z}];
        so_far = std::max(so_far, distance / cell);
      };
      const auto middle = [](const std::array<glm::dvec3, 3>& t) { return (t[0] + t[1] + t[2]) / 3.0; };
      const Near near_coarse(coarse, cell, cell * most), near_finest(finest, 1, cell * most);
      each_point(finest, 1, [&](std::size_t n, glm::dvec3 p) {
        const double d = std::min(near_coarse.distance(p), width[n]);
        there = std::max(there, d / cell);
        note(middle(finest[n]), d);
      });
      each_point(coarse, 1 << level, [&](std::size_t n, glm::dvec3 p) {
        const double d = near_finest.distance(p);
        back = std::max(back, d / cell);
        note(middle(coarse[n]), d);
      });
      for (const auto& [at, measured] : off) {
        const BlockKey key = block_key({at[0], at[1], at[2]}, level);
        const double bound = static_cast<double>(tree.block_error(key)) / std::ldexp(1.0, 13 + level);
        EXPECT_LE(measured, bound) << c.name << " " << level;
        stated = std::max(stated, bound);
        mean_measured += measured / static_cast<double>(off.size());
        mean_stated += bound / static_cast<double>(off.size());
      }
      std::printf("%-6s level %d: %.3f of a cell off, %.3f the other way; stated %.3f; a block: %.3f, %.3f\n",
                  c.name, level, there, back, stated, mean_measured, mean_stated);
      EXPECT_LE(stated, c.most) << c.name << " " << level;
      EXPECT_LE(mean_stated, c.factor * mean_measured) << c.name << " " << level;
    }
  }
}

TEST(Blocks, StatedErrorsFollowEdits) {
  constexpr glm::ivec3 kBlocks(5, 4, 6);
  Scene scene(kBlocks, 64, lumps(glm::dvec3(kBlocks * 16), 12));
  const BlockTree& tree = scene.isosurface.tree();
  const auto errors = [&] {
    std::vector<float> out;
    for (int level = 1; level < tree.levels(); ++level) {
      const glm::ivec3 n = tree.blocks(level);
      for (int b = 0; b < n.x * n.y * n.z; ++b)
        out.push_back(tree.block_error(block_key({b % n.x, b / n.x % n.y, b / n.x / n.y}, level)));
    }
    return out;
  };
  Random random{7};
  std::vector<float> last = errors();
  std::size_t greater = 0;
  for (int round = 0; round < 12; ++round) {
    for (int n = 0; n < 10; ++n) {
      Edit dab;
      dab.tool = n % 2 == 0 ? EditTool::clear : EditTool::fill;
      dab.place =
          (glm::dvec3(random.unit(), random.unit(), random.unit()) * 0.8 + 0.1) * glm::dvec3(kBlocks * 16);
      dab.radius = 0.6 + 5 * random.unit();
      FieldChange change;
      ASSERT_TRUE(edit_field({&scene.field, {}}, dab, nullptr, change).ok());
      if (change.changed) scene.isosurface.change(change.first, change.last);
    }
    const std::vector<float> live = errors();
    scene.isosurface.attach(scene.field);
    const std::vector<float> loaded = errors();
    for (std::size_t n = 0; n < live.size(); ++n) {
      ASSERT_GE(live[n], loaded[n]) << round << " " << n;
      greater += loaded[n] > last[n];
    }
    last = loaded;
  }
  // Else what is kept from before would do.
  EXPECT_GT(greater, 20u);
}

// What is drawn, with transition cells and what makes way for them, is off by what was asked for at most, and
// so is what a change of levels moves.
TEST(Blocks, PicturesAreWithinWhatWasAskedForAndSoIsWhatPops) {
  constexpr glm::ivec3 kBlocks(4);
  const glm::dvec3 size(kBlocks * 16), centre = size / 2.0;
  struct Case {
    const char* name;
    FieldShape shape;
    float steps_per_step;
  };
  const Case cases[] = {{"torus", torus(centre, 7), 150},
                        {"cave", gyroid_cave(centre, 27, 24), 20},
                        {"lumps", lumps(size, 21), 12}};
  for (const Case& c : cases) {
    Scene scene(kBlocks, 30'000, c.shape);
    const Mesh finest = mesh_at(scene, 0);
    scene.isosurface.forget();
    const std::vector<double> width = widths(finest);
    const Near near_finest(finest, 1, 24);
    double most = 0, most_popped = 0;
    std::size_t changes = 0, mixed = 0;
    Mesh before;
    for (int pose = 0; pose < 10; ++pose) {
      const glm::dvec3 at = (centre + size * glm::dvec3(0.1, 0.2, 0.4 + 0.3 * pose)) * 8192.0;
      const BlockEye eye = eye_at(at, c.steps_per_step);
      scene.begin_frame();
      scene.isosurface.choose({&eye, 1});
      scene.make(1 << 20);
      ASSERT_TRUE(scene.isosurface.is_complete());
      Mesh mesh;
      for (const Scene::Triangle& t : scene.drawn())
        mesh.push_back(
            {glm::dvec3(t.at[0]) / 8192.0, glm::dvec3(t.at[1]) / 8192.0, glm::dvec3(t.at[2]) / 8192.0});
      std::array<bool, 9> levels{};
      for (const ChosenBlock& block : scene.isosurface.drawn()) levels[block.block.level] = true;
      mixed += std::count(levels.begin(), levels.end(), true) > 1;
      // The share of what was asked for at a place.
      const auto share = [&](glm::dvec3 p, double distance) {
        const glm::vec3 from = glm::vec3(p * 8192.0) - eye.eye.eye;
        const double apparent =
            static_cast<double>(apparent_distance(from, eye.eye.forward, eye.eye.least_cos2));
        return distance * 8192.0 * static_cast<double>(c.steps_per_step) / apparent;
      };
      const Near near_drawn(mesh, 2, 24);
      each_point(mesh, 2, [&](std::size_t, glm::dvec3 p) {
        most = std::max(most, share(p, near_finest.distance(p)));
      });
      each_point(finest, 1, [&](std::size_t n, glm::dvec3 p) {
        most = std::max(most, share(p, std::min(near_drawn.distance(p), width[n])));
      });
      if (!before.empty() && before.size() != mesh.size()) {
        ++changes;
        const std::vector<double> before_width = widths(before);
        const Near near_before(before, 2, 24);
        each_point(mesh, 2, [&](std::size_t, glm::dvec3 p) {
          most_popped = std::max(most_popped, share(p, near_before.distance(p)));
        });
        each_point(before, 2, [&](std::size_t n, glm::dvec3 p) {
          most_popped = std::max(most_popped, share(p, std::min(near_drawn.distance(p), before_width[n])));
        });
      }
      before = mesh;
    }
    std::printf("%-6s off by %.2f of what was asked for, %.2f popped; %zu changes\n", c.name, most,
                most_popped, changes);
    EXPECT_LE(most, 1) << c.name;
    EXPECT_LE(most_popped, 1) << c.name;
    EXPECT_GT(most, 0.1) << c.name;
    EXPECT_GT(changes, 2u) << c.name;
    EXPECT_GT(mixed, 1u) << c.name;
  }
}

}  // namespace
}  // namespace karst::test
