// SPDX-License-Identifier: MIT
// A world for queries, and all its triangles at a level, as they are drawn, to ask one by one.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "terrain/query/query.h"
#include "tests/support/test_world.h"

namespace karst::test {

// What a TestWorld lends to queries. Must not outlive it.
class TestQueryWorld {
 public:
  explicit TestQueryWorld(const TestWorld& world);

  // All heights in memory; or read group by group from a source that counts and can be made to fail.
  QueryWorld held() const;
  QueryWorld read() const;
  std::uint32_t reads() const { return reads_; }
  void fail(bool fails) { fails_ = fails; }
  LatticeBox box() const { return tree_.node(tree_.rows() - 1, 0); }

 private:
  const TestWorld& world_;
  std::vector<PatchBounds> bounds_;
  std::vector<LatticeBox> boxes_;
  BoundsTree tree_;
  mutable std::atomic<std::uint32_t> reads_ = 0;
  bool fails_ = false;
};

// A Query with memory of its own; aborts where it can't be made.
class TestQuery {
 public:
  TestQuery(const QueryWorld& world, int level, std::uint32_t patches);
  Query* operator->() { return &query_; }
  Query& operator*() { return query_; }

 private:
  AlignedBytes memory_;
  Query query_;
};

// Hills under rough heights, 24 x 10 x 24 voxels, level 4.
TestWorld rolling_world();

// Answers of all kinds to `count` groups of questions about places in the box of rolling_world(), eight a
// group.
std::vector<QueryHit> ask_all(Query& query, Wait wait, std::uint64_t seed, int count);

// The first answer that differs in any bit of its values; a.size() where none does.
std::size_t first_difference(std::span<const QueryHit> a, std::span<const QueryHit> b);

// Triangles in voxels, counter-clockwise from outside; those without area are left out.
struct SoupTriangle {
  glm::dvec3 corner[3];
  PatchId patch;

  glm::dvec3 normal() const;
};

class TriangleSoup {
 public:
  // displaced: else the patches as they are without heights.
  TriangleSoup(const TestWorld& world, int level, bool displaced = true);
  TriangleSoup(const Surface& surface, const Heights& heights, int level);
  explicit TriangleSoup(std::vector<SoupTriangle> triangles) : triangles_(std::move(triangles)) {}

  std::span<const SoupTriangle> triangles() const { return triangles_; }

  struct Crossing {
    double at;  // height, or the way from the start
    const SoupTriangle* triangle;
  };
  // All of a vertical line, from the top; the line must not meet an edge.
  std::vector<Crossing> column(double x, double z) const;
  // First of a segment; triangle null: none.
  Crossing ray(glm::dvec3 from, glm::dvec3 to) const;
  Crossing sphere(glm::dvec3 from, glm::dvec3 to, double radius) const;
  // Signed crossings above: 1 in rock, 0 outside where the surface does not cross itself.
  int winding(glm::dvec3 place) const;

 private:
  std::vector<SoupTriangle> triangles_;
};

// Distance of a place from a triangle.
double triangle_distance(glm::dvec3 place, const SoupTriangle& triangle);

}  // namespace karst::test
