// SPDX-License-Identifier: MIT
// Isosurfaces of random fields in blocks of mixed resolutions: closed, and near the surface that they mean.
// KARST_BLOCKS: how many blocks of random fields (without: 400).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "terrain/field/scalar_field.h"
#include "terrain/isosurface/extract_block.h"
#include "terrain/patch/octahedral.h"

namespace karst::core {
namespace {

using Field = ScalarField<std::int8_t>;

struct OwnField {
  explicit OwnField(glm::ivec3 blocks)
      : table(static_cast<std::size_t>(blocks.x * blocks.y * blocks.z)),
        pool(table.size() * Field::kBlockSamples) {
    EXPECT_TRUE(field.create(blocks, table, pool).ok());
  }
  // value(sample): to be rounded down, so that v stands for v + 0.5.
  template <class Value>
  void fill(const Value& value) {
    const glm::ivec3 n = field.blocks();
    for (int z = 0; z < n.z; ++z) {
      for (int y = 0; y < n.y; ++y) {
        for (int x = 0; x < n.x; ++x) fill_block({x, y, z}, value);
      }
    }
  }
  template <class Value>
  void fill_block(glm::ivec3 block, const Value& value) {
    const std::span<std::int8_t> out = field.open(block);
    ASSERT_FALSE(out.empty());
    for (int n = 0; n < static_cast<int>(out.size()); ++n) {
      const glm::ivec3 inside(n & 15, n >> 4 & 15, n >> 8);
      const double v = std::floor(value(block * Field::kBlock + inside));
      out[static_cast<std::size_t>(n)] = static_cast<std::int8_t>(std::clamp(v, -128.0, 127.0));
    }
    field.close(block);
  }

  std::vector<std::uint32_t> table;
  std::vector<std::int8_t> pool;
  Field field;
};

// An octree of blocks: for each place of a level whether it is divided.
class Blocks {
 public:
  Blocks(int side, int top) : side_(side), top_(top) {}

  void divide(glm::ivec3 corner, int level) {
    if (level == 0 || divided_.contains(key(corner, level))) return;
    if (level < top_) divide(parent(corner, level), level + 1);
    divided_.insert({key(corner, level), true});
    // No block beside it, also across edges and corners, is two levels coarser.
    for (int n = 0; n < 27; ++n) {
      const glm::ivec3 at = corner + offset(n) * width(level);
      if (inside(at) && level < top_) divide(parent(at, level), level + 1);
    }
  }

  // Divides one more where two divided blocks of four around an edge are diagonal to each other.
  void settle() {
    for (bool changed = true; changed;) {
      changed = false;
      const auto divided = divided_;
      for (const auto& [at, yes] : divided) {
        const auto level = static_cast<int>(at >> 48);
        const glm::ivec3 corner(at >> 32 & 0xffff, at >> 16 & 0xffff, at & 0xffff);
        for (int n = 0; n < 27; ++n) {
          const glm::ivec3 o = offset(n);
          if (std::abs(o.x) + std::abs(o.y) + std::abs(o.z) != 2) continue;
          glm::ivec3 first = o;
          first[o.x != 0 ? 0 : 1] = 0;
          const glm::ivec3 across = corner + o * width(level);
          if (!divided_.contains(key(across, level)) || !inside(across)) continue;
          const glm::ivec3 a = corner + first * width(level), b = corner + (o - first) * width(level);
          if (divided_.contains(key(a, level)) || divided_.contains(key(b, level))) continue;
          divide(a, level);
          changed = true;
        }
      }
    }
  }

  // Calls visit(corner, level) for each block.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (int z = 0; z < side_; z += width(top_)) {
      for (int y = 0; y < side_; y += width(top_)) {
        for (int x = 0; x < side_; x += width(top_)) descend({x, y, z}, top_, visit);
      }
    }
  }

  std::array<IsoNeighbour, 27> around(glm::ivec3 corner, int level) const {
    std::array<IsoNeighbour, 27> out{};
    for (int n = 0; n < 27; ++n) {
      const glm::ivec3 at = corner + offset(n) * width(level);
      if (n == 13 || !inside(at)) continue;
      if (level > 0 && divided_.contains(key(at, level))) {
        out[static_cast<std::size_t>(n)] = IsoNeighbour::finer;
      } else if (level < top_ && !divided_.contains(key(parent(at, level), level + 1))) {
        out[static_cast<std::size_t>(n)] = IsoNeighbour::coarser;
      }
    }
    return out;
  }

  static int width(int level) { return kIsoCells << level; }

 private:
  static glm::ivec3 offset(int n) { return {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}; }
  static glm::ivec3 parent(glm::ivec3 corner, int level) {
    return corner / width(level + 1) * width(level + 1);
  }
  bool inside(glm::ivec3 at) const {
    return at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x < side_ && at.y < side_ && at.z < side_;
  }
  static std::uint64_t key(glm::ivec3 corner, int level) {
    return static_cast<std::uint64_t>(level) << 48 | static_cast<std::uint64_t>(corner.x) << 32 |
           static_cast<std::uint64_t>(corner.y) << 16 | static_cast<std::uint64_t>(corner.z);
  }
  template <class Visit>
  void descend(glm::ivec3 corner, int level, const Visit& visit) const {
    if (!divided_.contains(key(corner, level))) return visit(corner, level);
    for (int o = 0; o < 8; ++o) {
      descend(corner + glm::ivec3(o & 1, o >> 1 & 1, o >> 2) * width(level - 1), level - 1, visit);
    }
  }

  int side_, top_;
  std::map<std::uint64_t, bool> divided_;
};

// The surface of all blocks; places in 1 / 1024 samples.
struct Mesh {
  struct Triangle {
    std::array<glm::i64vec3, 3> at;
    std::array<glm::vec3, 3> normal;
    int level;
    bool transition;
  };
  std::vector<Triangle> triangles;
  std::uint64_t vertices = 0;
  std::uint64_t blocks = 0;
};

void extract(const Field& field, const Blocks& blocks, Mesh& mesh) {
  std::vector<std::byte> room(ExtractBlock<std::int8_t>::room_bytes() + 16);
  void* aligned = room.data();
  std::size_t space = room.size();
  std::align(16, ExtractBlock<std::int8_t>::room_bytes(), aligned, space);
  std::vector<IsoVertex> vertices(28'000);
  std::vector<std::uint16_t> indices(3 * 40'000);
  blocks.for_each([&](glm::ivec3 corner, int level) {
    ExtractBlock<std::int8_t> job;
    job.field = &field;
    job.corner = corner;
    job.level = level;
    job.around = blocks.around(corner, level);
    job.vertices = vertices;
    job.triangles = indices;
    ExtractBlock<std::int8_t>::Result result;
    ASSERT_TRUE(job.run({static_cast<std::byte*>(aligned), space}, result).ok());
    mesh.vertices += result.vertices;
    ++mesh.blocks;
    for (std::uint32_t n = 0; n < result.triangles; ++n) {
      Mesh::Triangle t;
      t.level = level;
      t.transition = n >= result.first_transition_triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        const IsoVertex& v = vertices[indices[3 * std::size_t{n} + k]];
        t.at[k] = (glm::i64vec3(v.place[0], v.place[1], v.place[2]) << std::int64_t{level}) +
                  glm::i64vec3(corner) * std::int64_t{kIsoStepsPerCell};
        t.normal[k] = decode_octahedral(v.normal);
      }
      mesh.triangles.push_back(t);
    }
  });
}

struct Closed {
  std::uint64_t edges = 0, unmatched = 0, repeated = 0, flat = 0;
};

// side: of the field, samples; what lies in its faces is open.
Closed check_closed(const Mesh& mesh, int side) {
  const auto key = [](const glm::i64vec3& v) {
    return static_cast<std::uint64_t>(v.x + 4096) << 42 | static_cast<std::uint64_t>(v.y + 4096) << 21 |
           static_cast<std::uint64_t>(v.z + 4096);
  };
  using Edge = std::array<std::uint64_t, 2>;
  std::vector<Edge> ahead, back;
  Closed out;
  const std::int64_t end = std::int64_t{side} * kIsoStepsPerCell;
  for (const Mesh::Triangle& t : mesh.triangles) {
    const glm::dvec3 a(t.at[1] - t.at[0]), b(t.at[2] - t.at[0]);
    out.flat += glm::length(glm::cross(a, b)) == 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::i64vec3 from = t.at[k], to = t.at[(k + 1) % 3];
      bool open = false;
      for (int axis = 0; axis < 3; ++axis) {
        open = open || (from[axis] == 0 && to[axis] == 0) || (from[axis] == end && to[axis] == end);
      }
      ++out.edges;
      if (open) continue;
      ahead.push_back({key(from), key(to)});
      back.push_back({key(to), key(from)});
    }
  }
  std::sort(ahead.begin(), ahead.end());
  std::sort(back.begin(), back.end());
  for (std::size_t n = 1; n < ahead.size(); ++n) out.repeated += ahead[n] == ahead[n - 1];
  std::vector<Edge> apart;
  std::set_symmetric_difference(ahead.begin(), ahead.end(), back.begin(), back.end(),
                                std::back_inserter(apart));
  out.unmatched = apart.size();
  return out;
}

double noise(glm::dvec3 p, std::uint32_t seed) {
  // Sums of waves: smooth, and nowhere regular.
  double sum = 0;
  std::uint32_t h = seed * 2654435761u + 12345;
  const auto next = [&] { return (h = h * 1664525u + 1013904223u) / 4294967296.0; };
  for (int n = 0; n < 12; ++n) {
    const glm::dvec3 way(next() - 0.5, next() - 0.5, next() - 0.5);
    sum += std::sin(glm::dot(way, p) * (0.2 + 0.5 * next()) + 6.3 * next());
  }
  return sum;
}

std::uint64_t wanted_blocks() {
  const char* const text = std::getenv("KARST_BLOCKS");
  return text != nullptr ? std::strtoull(text, nullptr, 10) : 400;
}

TEST(Isosurface, RandomFieldsInMixedResolutionsAreClosed) {
  constexpr int kSide = 128;
  constexpr int kTop = 2;
  std::uint64_t blocks = 0, triangles = 0, transitions = 0, levels = 0;
  Closed sum;
  for (std::uint32_t seed = 1; blocks < wanted_blocks(); ++seed) {
    std::mt19937 random(seed);
    OwnField own(glm::ivec3(kSide / Field::kBlock + 1));
    const int kind = seed % 5 == 0 ? 0 : static_cast<int>(1 + seed % 2);
    std::uniform_int_distribution<int> any(-128, 127);
    own.fill([&](glm::ivec3 s) {
      // Every state of cells and transition cells comes up in values that know nothing of their neighbours.
      if (kind == 0) return static_cast<double>(any(random));
      const double smooth = 40 * noise(glm::dvec3(s), seed);
      return kind == 1 ? smooth : smooth + 0.3 * any(random);
    });
    Blocks tree(kSide, kTop);
    std::uniform_int_distribution<int> place(0, kSide / kIsoCells - 1), count(0, 6);
    for (int n = count(random); n > 0; --n) {
      const glm::ivec3 at(place(random), place(random), place(random));
      const int level = 1 + static_cast<int>(random() % kTop);
      tree.divide(at * kIsoCells / Blocks::width(level) * Blocks::width(level), level);
    }
    tree.settle();
    Mesh mesh;
    extract(own.field, tree, mesh);
    const Closed closed = check_closed(mesh, kSide);
    ASSERT_EQ(closed.unmatched, 0u) << "seed " << seed;
    ASSERT_EQ(closed.repeated, 0u) << "seed " << seed;
    blocks += mesh.blocks;
    triangles += mesh.triangles.size();
    for (const Mesh::Triangle& t : mesh.triangles) {
      transitions += t.transition;
      levels |= std::uint64_t{1} << t.level;
    }
    sum.edges += closed.edges;
    sum.flat += closed.flat;
    if (kind != 0) {
      EXPECT_EQ(closed.flat, 0u) << "seed " << seed;
    }
  }
  std::printf("%llu blocks, %llu triangles, %llu of transition cells, %llu edges, %llu flat triangles\n",
              static_cast<unsigned long long>(blocks), static_cast<unsigned long long>(triangles),
              static_cast<unsigned long long>(transitions), static_cast<unsigned long long>(sum.edges),
              static_cast<unsigned long long>(sum.flat));
  EXPECT_GT(transitions, triangles / 100);
  EXPECT_EQ(levels, 7u);
  // By chance alone, in noise.
  EXPECT_LE(sum.flat, 1 + triangles / 1'000'000);
}

// --- Against surfaces that are known

struct Shape {
  const char* name;
  std::function<double(glm::dvec3)> distance;  // below 0 within; of length 1 or nearly where it is 0
};

// Half of a sample's step: what eight bits resolve where they reach two samples far.
constexpr double kSteps = 64;

struct Off {
  double mean = 0, most = 0, most_normal_deg = 0;
  std::uint64_t vertices = 0;
};

Off measure(const Shape& shape, int level) {
  constexpr int kSide = 128;
  OwnField own(glm::ivec3(kSide / Field::kBlock + 1));
  own.fill([&](glm::ivec3 s) { return kSteps * shape.distance(glm::dvec3(s)); });
  Blocks tree(kSide, level);
  Mesh mesh;
  extract(own.field, tree, mesh);
  EXPECT_EQ(check_closed(mesh, kSide).unmatched, 0u);
  Off off;
  for (const Mesh::Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3 at = glm::dvec3(t.at[k]) / static_cast<double>(kIsoStepsPerCell);
      const double d = std::abs(shape.distance(at));
      off.mean += d;
      off.most = std::max(off.most, d);
      ++off.vertices;
      const double h = 1e-4;
      const auto slope = [&](glm::dvec3 e) {
        return shape.distance(at + e * h) - shape.distance(at - e * h);
      };
      const glm::dvec3 n = glm::normalize(glm::dvec3(slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})));
      if (glm::min(at.x, glm::min(at.y, at.z)) < 1) continue;  // nothing is beyond for a gradient
      const double cosine = std::clamp(glm::dot(n, glm::normalize(glm::dvec3(t.normal[k]))), -1.0, 1.0);
      off.most_normal_deg = std::max(off.most_normal_deg, std::acos(cosine) * 57.29577951308232);
    }
  }
  off.mean /= static_cast<double>(std::max<std::uint64_t>(off.vertices, 1));
  return off;
}

TEST(Isosurface, IsOnTheSurfaceThatEightBitsMean) {
  const glm::dvec3 middle(63.7, 64.2, 63.9);
  const Shape shapes[] = {
      {"sphere", [&](glm::dvec3 p) { return glm::length(p - middle) - 41.3; }},
      {"torus",
       [&](glm::dvec3 p) {
         const glm::dvec3 q = p - middle;
         const double round = std::sqrt(q.x * q.x + q.z * q.z) - 36.2;
         return std::sqrt(round * round + q.y * q.y) - 15.4;
       }},
      {"gyroid", [](glm::dvec3 p) {
         const double k = 6.283185307179586 / 40;
         const double v = std::sin(k * p.x) * std::cos(k * p.y) + std::sin(k * p.y) * std::cos(k * p.z) +
                          std::sin(k * p.z) * std::cos(k * p.x);
         const glm::dvec3 g(
             k * (std::cos(k * p.x) * std::cos(k * p.y) - std::sin(k * p.z) * std::sin(k * p.x)),
             k * (std::cos(k * p.y) * std::cos(k * p.z) - std::sin(k * p.x) * std::sin(k * p.y)),
             k * (std::cos(k * p.z) * std::cos(k * p.x) - std::sin(k * p.y) * std::sin(k * p.z)));
         return v / std::max(glm::length(g), 0.02);
       }}};
  for (const Shape& shape : shapes) {
    for (int level = 0; level <= 2; ++level) {
      const Off off = measure(shape, level);
      std::printf("%-6s level %d: mean %.4f, most %.4f samples, normals %.2f degrees\n", shape.name, level,
                  off.mean, off.most, off.most_normal_deg);
      EXPECT_GT(off.vertices, 500u);
      // Vertices lie where the finest data have them, whatever the level.
      EXPECT_LE(off.mean, 0.01) << shape.name;
      EXPECT_LE(off.most, 0.05) << shape.name;
      EXPECT_LE(off.most_normal_deg, 1.4) << shape.name;
    }
  }
}

}  // namespace
}  // namespace karst::core
