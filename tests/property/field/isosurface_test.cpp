// SPDX-License-Identifier: MIT
// Isosurfaces of random fields in blocks of mixed resolutions: closed, and near the surface that they mean.
// KARST_BLOCKS: how many blocks of random fields (without: 400); KARST_SEED: the first field's (without: 1).
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
    // Of the block, that each would be in without transition cells: 2 bits an axis, lower and upper.
    std::array<std::uint8_t, 3> sides;
    int level;
    bool transition;
  };
  std::vector<Triangle> triangles;
  std::vector<std::size_t> blocks;  // the first triangle of each
  std::uint64_t vertices = 0;
};

std::uint8_t sides_of(const IsoVertex& v) {
  unsigned sides = 0;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const unsigned lower = v.primary[axis] == 0, upper = v.primary[axis] == kIsoCells * kIsoStepsPerCell;
    sides |= (lower | upper << 1) << 2 * axis;
  }
  return static_cast<std::uint8_t>(sides);
}

void extract(const Field& field, const Blocks& blocks, Mesh& mesh) {
  std::vector<std::byte> room(ExtractBlock<std::int8_t>::room_bytes() + 16);
  void* aligned = room.data();
  std::size_t space = room.size();
  std::align(16, ExtractBlock<std::int8_t>::room_bytes(), aligned, space);
  std::vector<IsoVertex> vertices(28'000);
  std::vector<std::uint16_t> indices(3 * 40'000);
  blocks.for_each([&](glm::ivec3 corner, int level) {
    mesh.blocks.push_back(mesh.triangles.size());
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
    for (std::uint32_t n = 0; n < result.triangles; ++n) {
      Mesh::Triangle t;
      t.level = level;
      t.transition = n >= result.first_transition_triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        const IsoVertex& v = vertices[indices[3 * std::size_t{n} + k]];
        t.at[k] = (glm::i64vec3(v.place[0], v.place[1], v.place[2]) << std::int64_t{level}) +
                  glm::i64vec3(corner) * std::int64_t{kIsoStepsPerCell};
        t.normal[k] = decode_octahedral(v.normal);
        t.sides[k] = sides_of(v);
      }
      mesh.triangles.push_back(t);
    }
  });
}

struct Closed {
  std::uint64_t edges = 0, unmatched = 0, repeated = 0, flat = 0;
};

// Looks whether each inner edge is there once from each side, block by block. Of an edge whose ends do not
// both belong to a side of its block, the other side must be the block's, too, because no other block has
// both ends. The others are looked for among all, at the end.
class Closure {
 public:
  explicit Closure(int side) : end_(std::int64_t{side} * kIsoStepsPerCell) {}

  // Of a block.
  void add(std::span<const Mesh::Triangle> triangles) {
    begin(triangles.size());
    for (const Mesh::Triangle& t : triangles) {
      const glm::dvec3 a(t.at[1] - t.at[0]), b(t.at[2] - t.at[0]);
      closed_.flat += glm::cross(a, b) == glm::dvec3(0);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t to = (k + 1) % 3;
        const std::uint64_t from_key = key(t.at[k]), to_key = key(t.at[to]);
        ++closed_.edges;
        if (from_key == to_key) continue;  // of a flat triangle: its own other side
        if ((t.sides[k] & t.sides[to]) == 0) {
          add_inner(from_key, to_key);
        } else if (!is_open(t.at[k], t.at[to])) {
          ahead_.push_back({from_key, to_key});
          back_.push_back({to_key, from_key});
        }
      }
    }
    closed_.unmatched += half_;
  }

  Closed finish() {
    std::sort(ahead_.begin(), ahead_.end());
    std::sort(back_.begin(), back_.end());
    for (std::size_t n = 1; n < ahead_.size(); ++n) closed_.repeated += ahead_[n] == ahead_[n - 1];
    std::vector<Edge> apart;
    std::set_symmetric_difference(ahead_.begin(), ahead_.end(), back_.begin(), back_.end(),
                                  std::back_inserter(apart));
    closed_.unmatched += apart.size();
    return closed_;
  }

 private:
  using Edge = std::array<std::uint64_t, 2>;
  struct Slot {
    Edge edge{};
    std::uint32_t block = 0;  // whose it is
    unsigned ways = 0;        // 1: from the lesser end, 2: from the other
  };

  static std::uint64_t key(const glm::i64vec3& v) {
    return static_cast<std::uint64_t>(v.x + 4096) << 42 | static_cast<std::uint64_t>(v.y + 4096) << 21 |
           static_cast<std::uint64_t>(v.z + 4096);
  }
  // In a side of the field.
  bool is_open(const glm::i64vec3& from, const glm::i64vec3& to) const {
    bool open = false;
    for (int axis = 0; axis < 3; ++axis) {
      open = open || (from[axis] == 0 && to[axis] == 0) || (from[axis] == end_ && to[axis] == end_);
    }
    return open;
  }
  void begin(std::size_t triangles) {
    while (slots_.size() < 4 * triangles) slots_.resize(2 * slots_.size());
    mask_ = 63;
    while (mask_ + 1 < 4 * triangles) mask_ = 2 * mask_ + 1;
    ++block_;
    half_ = 0;
  }
  void add_inner(std::uint64_t from, std::uint64_t to) {
    const Edge edge{std::min(from, to), std::max(from, to)};
    const unsigned way = from < to ? 1 : 2;
    std::uint64_t h = edge[0] * 0x9e3779b97f4a7c15u ^ edge[1] * 0xc2b2ae3d27d4eb4fu;
    h ^= h >> 29;
    for (std::size_t at = h & mask_;; at = (at + 1) & mask_) {
      Slot& slot = slots_[at];
      if (slot.block != block_) {
        slot = {edge, block_, way};
        ++half_;
        return;
      }
      if (slot.edge != edge) continue;
      closed_.repeated += (slot.ways & way) != 0;
      if ((slot.ways & way) == 0) --half_;
      slot.ways |= way;
      return;
    }
  }

  std::int64_t end_;
  Closed closed_;
  std::vector<Edge> ahead_, back_;
  std::vector<Slot> slots_ = std::vector<Slot>(64);
  std::size_t mask_ = 63;
  std::uint32_t block_ = 0;
  std::uint64_t half_ = 0;  // edges of the block that one side alone has
};

Closed check_closed(const Mesh& mesh, int side) {
  Closure closure(side);
  for (std::size_t n = 0; n < mesh.blocks.size(); ++n) {
    const std::size_t end = n + 1 < mesh.blocks.size() ? mesh.blocks[n + 1] : mesh.triangles.size();
    closure.add(std::span(mesh.triangles).subspan(mesh.blocks[n], end - mesh.blocks[n]));
  }
  return closure.finish();
}

// Sums of waves: smooth, and nowhere regular. Whole rows along x, by turning each wave from sample to sample.
class Waves {
 public:
  explicit Waves(std::uint32_t seed) {
    std::uint32_t h = seed * 2654435761u + 12345;
    const auto next = [&] { return (h = h * 1664525u + 1013904223u) / 4294967296.0; };
    for (std::size_t n = 0; n < kCount; ++n) {
      way_[n].x = next() - 0.5;
      way_[n].y = next() - 0.5;
      way_[n].z = next() - 0.5;
      way_[n] *= 0.2 + 0.5 * next();
      phase_[n] = 6.3 * next();
      turn_cos_[n] = static_cast<float>(std::cos(way_[n].x));
      turn_sin_[n] = static_cast<float>(std::sin(way_[n].x));
    }
  }
  void row(glm::ivec3 first, std::span<float> out) const {
    std::array<float, kCount> sine, cosine;
    for (std::size_t n = 0; n < kCount; ++n) {
      const double at = glm::dot(way_[n], glm::dvec3(first)) + phase_[n];
      sine[n] = static_cast<float>(std::sin(at));
      cosine[n] = static_cast<float>(std::cos(at));
    }
    for (float& value : out) {
      float sum = 0;
      for (std::size_t n = 0; n < kCount; ++n) {
        sum += sine[n];
        const float s = sine[n] * turn_cos_[n] + cosine[n] * turn_sin_[n];
        cosine[n] = cosine[n] * turn_cos_[n] - sine[n] * turn_sin_[n];
        sine[n] = s;
      }
      value = sum;
    }
  }

 private:
  static constexpr std::size_t kCount = 12;
  std::array<glm::dvec3, kCount> way_;
  std::array<double, kCount> phase_;
  std::array<float, kCount> turn_cos_, turn_sin_;
};

// 0: every state of cells and transition cells comes up in values that know nothing of their neighbours.
// 1: smooth. 2: both.
void fill_random(OwnField& own, std::size_t kind, std::uint32_t seed, std::mt19937& random) {
  const Waves waves(seed);
  const auto any = [&] { return static_cast<int>(random() >> 24) - 128; };
  const glm::ivec3 n = own.field.blocks();
  std::array<float, Field::kBlock> row{};
  for (int b = 0; b < n.x * n.y * n.z; ++b) {
    const glm::ivec3 block(b % n.x, b / n.x % n.y, b / n.x / n.y);
    const std::span<std::int8_t> out = own.field.open(block);
    ASSERT_FALSE(out.empty());
    for (int yz = 0; yz < Field::kBlock * Field::kBlock; ++yz) {
      if (kind != 0) waves.row(block * Field::kBlock + glm::ivec3(0, yz & 15, yz >> 4), row);
      for (std::size_t x = 0; x < row.size(); ++x) {
        float v = kind == 0 ? static_cast<float>(any()) : 40 * row[x];
        if (kind == 2) v += 0.3f * static_cast<float>(any());
        const float rounded = std::floor(std::clamp(v, -128.0f, 127.0f));
        out[static_cast<std::size_t>(yz) * row.size() + x] = static_cast<std::int8_t>(rounded);
      }
    }
    own.field.close(block);
  }
}

std::uint64_t number_from(const char* variable, std::uint64_t otherwise) {
  const char* const text = std::getenv(variable);
  return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
}

constexpr int kRandomSide = 128;

Blocks random_blocks(std::mt19937& random) {
  constexpr int kTop = 2;
  Blocks tree(kRandomSide, kTop);
  std::uniform_int_distribution<int> place(0, kRandomSide / kIsoCells - 1), count(0, 6);
  for (int n = count(random); n > 0; --n) {
    const int x = place(random), y = place(random), z = place(random);
    const int level = 1 + static_cast<int>(random() % kTop);
    const glm::ivec3 at = glm::ivec3(x, y, z) * kIsoCells;
    tree.divide(at / Blocks::width(level) * Blocks::width(level), level);
  }
  tree.settle();
  return tree;
}

TEST(Isosurface, RandomFieldsInMixedResolutionsAreClosed) {
  constexpr int kSide = kRandomSide;
  const std::uint64_t wanted = number_from("KARST_BLOCKS", 400);
  // A long run divides each field in several ways, and has no more noise, whose meshes are 20 times as large,
  // once it has had so many blocks of it.
  const std::uint64_t divisions = std::clamp<std::uint64_t>(wanted / 50'000, 1, 16);
  constexpr std::array<std::uint64_t, 3> kNoiseBlocks{20'000, 0, 100'000};
  std::uint64_t blocks = 0, triangles = 0, transitions = 0, levels = 0, fields = 0;
  std::array<std::uint64_t, 3> noise_blocks{};
  std::uint64_t noise_flat = 0;
  Closed sum;
  Mesh mesh;
  for (auto seed = static_cast<std::uint32_t>(number_from("KARST_SEED", 1)); blocks < wanted; ++seed) {
    const std::size_t kind = seed % 5 == 0 ? 0 : 1 + seed % 2;
    if (kind != 1 && noise_blocks[kind] > kNoiseBlocks[kind]) continue;
    std::mt19937 random(seed);
    OwnField own(glm::ivec3(kSide / Field::kBlock + 1));
    fill_random(own, kind, seed, random);
    ++fields;
    for (std::uint64_t division = 0; division < divisions; ++division) {
      const Blocks tree = random_blocks(random);
      mesh.triangles.clear();
      mesh.blocks.clear();
      extract(own.field, tree, mesh);
      const Closed closed = check_closed(mesh, kSide);
      ASSERT_EQ(closed.unmatched, 0u) << "seed " << seed << ", division " << division;
      blocks += mesh.blocks.size();
      noise_blocks[kind] += mesh.blocks.size();
      triangles += mesh.triangles.size();
      for (const Mesh::Triangle& t : mesh.triangles) {
        transitions += t.transition;
        levels |= std::uint64_t{1} << t.level;
      }
      sum.edges += closed.edges;
      sum.flat += closed.flat;
      sum.repeated += closed.repeated;
      noise_flat += kind != 1 ? closed.flat : 0;
      // In noise two vertices may make way to the same place.
      if (kind == 1 || wanted < 10'000) {
        ASSERT_EQ(closed.repeated, 0u) << "seed " << seed << ", division " << division;
        EXPECT_EQ(kind == 0 ? 0 : closed.flat, 0u) << "seed " << seed << ", division " << division;
      }
    }
    if (wanted > 10'000 && fields % 20 == 0) {
      std::fprintf(stderr, "seed %u: %llu blocks\n", seed, static_cast<unsigned long long>(blocks));
    }
  }
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf(
      "%llu fields, %llu blocks (%llu of noise, %llu with noise), %llu triangles, %llu of transition "
      "cells, %llu edges (%llu more than once), %llu flat triangles (%llu in noise)\n",
      number(fields), number(blocks), number(noise_blocks[0]), number(noise_blocks[2]), number(triangles),
      number(transitions), number(sum.edges), number(sum.repeated), number(sum.flat), number(noise_flat));
  EXPECT_GT(transitions, triangles / 100);
  EXPECT_EQ(levels, 7u);
  // By chance alone, in noise.
  EXPECT_LE(sum.flat, 1 + triangles / 1'000'000);
  EXPECT_LE(sum.repeated, sum.edges / 1'000'000);
}

// Fields and blocks, of the random ones, in which three vertices of a thin transition cell lie on a line
// unless places on sides of blocks keep them apart (kLineSteps in extract_block.cpp).
TEST(Isosurface, ThinTransitionCellsHaveNoFlatTriangles) {
  std::uint64_t thin = 0;
  Mesh mesh;
  // With 532 two vertices made way to the same place (kMovedSteps).
  for (const std::uint32_t seed : {46u, 104u, 112u, 118u, 532u}) {
    std::mt19937 random(seed);
    OwnField own(glm::ivec3(kRandomSide / Field::kBlock + 1));
    fill_random(own, 1, seed, random);
    for (int division = 0; division < (seed == 532 ? 9 : 7); ++division) {
      const Blocks tree = random_blocks(random);
      mesh.triangles.clear();
      mesh.blocks.clear();
      extract(own.field, tree, mesh);
      const Closed closed = check_closed(mesh, kRandomSide);
      EXPECT_EQ(closed.unmatched, 0u) << seed << " " << division;
      EXPECT_EQ(closed.flat, 0u) << seed << " " << division;
      EXPECT_EQ(closed.repeated, 0u) << seed << " " << division;
      for (const Mesh::Triangle& t : mesh.triangles) {
        for (int axis = 0; axis < 3 && t.transition; ++axis)
          thin += t.at[0][axis] == t.at[1][axis] && t.at[0][axis] == t.at[2][axis];
      }
    }
  }
  EXPECT_GT(thin, 500u);
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
