// SPDX-License-Identifier: MIT
#include "tests/support/query_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include <glm/geometric.hpp>

#include "terrain/base/budget.h"
#include "terrain/draw/index_batches.h"

namespace karst::test {
namespace {

void require(const Status& status) {
  if (!status.ok()) std::abort();
}

std::size_t query_bytes(const Query::Limits& limits) {
  Budget budget;
  Query::add_to(budget, limits);
  return budget.cpu_bytes();
}

Query::Limits query_limits(int level, std::uint32_t patches) {
  Query::Limits limits;
  limits.level = level;
  limits.patches = patches;
  limits.max_level = kMaxLevel;
  return limits;
}

using Real = long double;
struct Real3 {
  Real x, y, z;
};
Real3 operator-(const Real3& a, const Real3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Real3 real(glm::dvec3 v) {
  return {v.x, v.y, v.z};
}
Real dot(const Real3& a, const Real3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Real3 cross(const Real3& a, const Real3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Moeller and Trumbore, 1997. Share of the way, or -1.
double cross_triangle(glm::dvec3 from, glm::dvec3 to, const SoupTriangle& triangle) {
  const Real3 a = real(triangle.corner[0]);
  const Real3 e1 = real(triangle.corner[1]) - a;
  const Real3 e2 = real(triangle.corner[2]) - a;
  const Real3 way = real(to) - real(from);
  const Real3 p = cross(way, e2);
  const Real det = dot(e1, p);
  if (det == 0) return -1;
  const Real3 s = real(from) - a;
  const Real u = dot(s, p) / det;
  const Real3 q = cross(s, e1);
  const Real v = dot(way, q) / det;
  if (u < 0 || v < 0 || u + v > 1) return -1;
  const Real t = dot(e2, q) / det;
  return t < 0 || t > 1 ? -1 : static_cast<double>(t);
}

}  // namespace

TestQueryWorld::TestQueryWorld(const TestWorld& world)
    : world_(world),
      bounds_(world.bounds()),
      boxes_(BoundsTree::node_count(static_cast<std::uint32_t>(bounds_.size()))) {
  tree_.create(boxes_);
  require(tree_.build(world.surface(), bounds_));
}

QueryWorld TestQueryWorld::held() const {
  QueryWorld w;
  w.surface = world_.surface();
  w.bounds = bounds_;
  w.tree = &tree_;
  w.heights = world_.heights();
  w.height_blocks = static_cast<std::uint32_t>(w.heights.samples.empty() ? 0 : bounds_.size());
  return w;
}

QueryWorld TestQueryWorld::read() const {
  QueryWorld w = held();
  w.heights.samples = {};
  w.source = {this, [](const void* context, std::uint32_t group, std::span<std::int16_t> out) {
                const auto* self = static_cast<const TestQueryWorld*>(context);
                ++self->reads_;
                if (self->fails_) return Status(StatusCode::io, "made to fail", "file", group);
                const Heights heights = self->world_.heights();
                const std::size_t block = static_cast<std::size_t>(patch_vertices(heights.level));
                const auto from = heights.samples.subspan(group * kHeightGroup * block, out.size());
                std::copy(from.begin(), from.end(), out.begin());
                return Status();
              }};
  return w;
}

TestQuery::TestQuery(const QueryWorld& world, int level, std::uint32_t patches)
    : memory_(query_bytes(query_limits(level, patches))) {
  Arena arena(memory_.bytes());
  require(query_.create(query_limits(level, patches), arena));
  if (arena.used() != memory_.bytes().size()) std::abort();
  require(query_.set_world(world));
}

TestWorld rolling_world() {
  TestWorld world({24, 10, 24}, [](glm::ivec3 v) {
    return v.y < 4.0 + 3.0 * value_noise(5, glm::dvec3(v.x, 0, v.z) / 6.0) || v.y == 0;
  });
  world.set_heights(4, [](glm::dvec3 p) { return 2500.0 * value_noise(6, 2.0 * p); });
  return world;
}

std::vector<QueryHit> ask_all(Query& query, Wait wait, std::uint64_t seed, int count) {
  Random random{seed};
  std::vector<QueryHit> answers;
  const auto place = [&] {
    const double x = random.unit();
    const double y = random.unit();
    return glm::dvec3(24.0 * x, 10.0 * y, 24.0 * random.unit());
  };
  for (int n = 0; n < count; ++n) {
    const glm::dvec3 a = place();
    const glm::dvec3 b = place();
    std::array<QueryHit, 8> hits;
    query.ray(a, b, wait, hits[0]);
    query.ground(a, 1.0, wait, hits[1]);
    query.sphere(a, a + 0.2 * (b - a), 0.3, wait, hits[2]);
    hits[3].level = query.inside(b, wait) ? 1 : 0;
    query.column(b, wait, std::span(hits).subspan(4));
    answers.insert(answers.end(), hits.begin(), hits.end());
  }
  return answers;
}

std::size_t first_difference(std::span<const QueryHit> a, std::span<const QueryHit> b) {
  const auto same = [](const QueryHit& x, const QueryHit& y) {
    return x.place == y.place && x.normal == y.normal && x.distance == y.distance && x.patch == y.patch &&
           x.level == y.level && x.coarse == y.coarse;
  };
  std::size_t n = 0;
  while (n < a.size() && n < b.size() && same(a[n], b[n])) ++n;
  return n;
}

glm::dvec3 SoupTriangle::normal() const {
  return glm::normalize(glm::cross(corner[1] - corner[0], corner[2] - corner[0]));
}

TriangleSoup::TriangleSoup(const TestWorld& world, int level, bool displaced)
    : TriangleSoup(world.surface(), displaced ? world.heights() : Heights{world.heights().level, {}}, level) {
}

TriangleSoup::TriangleSoup(const Surface& surface, const Heights& heights, int level) {
  std::vector<std::uint16_t> table(index_count(kMaxLevel));
  require(build_index_tables(kMaxLevel, table));
  const TestScratch scratch;
  GenerateVertices generate;
  generate.surface = surface;
  generate.heights = heights;
  generate.level = level;
  generate.scratch = scratch.get();
  require(generate.validate());
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(level)));
  for (PatchId id = 0; id < surface.patches.size(); ++id) {
    generate.run(id, vertices, nullptr);
    const glm::dvec3 origin = glm::dvec3(patch_origin(surface.volume_of(id)));
    IndexRange ranges[kMaxIndexRanges];
    const int count = index_ranges(level, 0, 0, ranges);
    for (int r = 0; r < count; ++r) {
      for (std::uint32_t i = ranges[r].first; i < ranges[r].first + ranges[r].count; i += 3) {
        SoupTriangle triangle{{}, id};
        for (std::uint32_t k = 0; k < 3; ++k) {
          const GpuVertex& v = vertices[table[i + k]];
          triangle.corner[k] = (origin + glm::dvec3(v.position[0], v.position[1], v.position[2])) /
                               static_cast<double>(kStepsPerVoxel);
        }
        const glm::dvec3 area =
            glm::cross(triangle.corner[1] - triangle.corner[0], triangle.corner[2] - triangle.corner[0]);
        if (area != glm::dvec3(0.0)) triangles_.push_back(triangle);
      }
    }
  }
}

std::vector<TriangleSoup::Crossing> TriangleSoup::column(double x, double z) const {
  std::vector<Crossing> found;
  for (const SoupTriangle& t : triangles_) {
    const auto side = [&](int a, int b) {
      const glm::dvec3& p = t.corner[a];
      const glm::dvec3& q = t.corner[b];
      return (Real{p.x} - x) * (Real{q.z} - z) - (Real{p.z} - z) * (Real{q.x} - x);
    };
    const Real w[3] = {side(1, 2), side(2, 0), side(0, 1)};
    const bool in = (w[0] > 0 && w[1] > 0 && w[2] > 0) || (w[0] < 0 && w[1] < 0 && w[2] < 0);
    if (!in) continue;
    const Real sum = w[0] + w[1] + w[2];
    found.push_back(
        {static_cast<double>((w[0] * t.corner[0].y + w[1] * t.corner[1].y + w[2] * t.corner[2].y) / sum),
         &t});
  }
  std::sort(found.begin(), found.end(), [](const Crossing& a, const Crossing& b) { return a.at > b.at; });
  return found;
}

TriangleSoup::Crossing TriangleSoup::ray(glm::dvec3 from, glm::dvec3 to) const {
  Crossing first{2.0, nullptr};
  for (const SoupTriangle& t : triangles_) {
    const double share = cross_triangle(from, to, t);
    if (share >= 0 && share < first.at) first = {share, &t};
  }
  first.at *= glm::length(to - from);
  return first;
}

double triangle_distance(glm::dvec3 place, const SoupTriangle& triangle) {
  const auto to_edge = [&](glm::dvec3 a, glm::dvec3 b) {
    const glm::dvec3 e = b - a;
    const double t = std::clamp(glm::dot(place - a, e) / glm::dot(e, e), 0.0, 1.0);
    return glm::length(a + t * e - place);
  };
  const glm::dvec3 n = triangle.normal();
  bool over = true;
  double least = 1e300;
  for (int k = 0; k < 3; ++k) {
    const glm::dvec3 a = triangle.corner[k];
    const glm::dvec3 b = triangle.corner[(k + 1) % 3];
    over = over && glm::dot(glm::cross(b - a, place - a), n) >= 0;
    least = std::min(least, to_edge(a, b));
  }
  return over ? std::min(least, std::abs(glm::dot(n, place - triangle.corner[0]))) : least;
}

// The distance of a moving place from a triangle is convex in its way: least first, then where it falls to
// the radius.
TriangleSoup::Crossing TriangleSoup::sphere(glm::dvec3 from, glm::dvec3 to, double radius) const {
  Crossing first{2.0, nullptr};
  for (const SoupTriangle& triangle : triangles_) {
    const auto distance = [&](double t) { return triangle_distance(from + t * (to - from), triangle); };
    double low = 0.0;
    double high = 1.0;
    const double closest = distance(0.0);
    if (closest > radius + glm::length(to - from)) continue;
    if (closest > radius) {
      for (int n = 0; n < 50; ++n) {
        const double a = low + (high - low) / 3;
        const double b = high - (high - low) / 3;
        (distance(a) <= distance(b) ? high : low) = distance(a) <= distance(b) ? b : a;
      }
      const double nearest = 0.5 * (low + high);
      if (distance(nearest) > radius) continue;
      low = 0.0;
      high = nearest;
      for (int n = 0; n < 40; ++n) {
        const double middle = 0.5 * (low + high);
        (distance(middle) <= radius ? high : low) = middle;
      }
    } else {
      high = 0.0;
    }
    if (high < first.at) first = {high, &triangle};
  }
  first.at *= glm::length(to - from);
  return first;
}

int TriangleSoup::winding(glm::dvec3 place) const {
  int sum = 0;
  for (const Crossing& c : column(place.x, place.z)) {
    if (c.at > place.y) sum += c.triangle->normal().y > 0 ? 1 : -1;
  }
  return sum;
}

}  // namespace karst::test
