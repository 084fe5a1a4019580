// SPDX-License-Identifier: MIT
#include "terrain/query/query.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/query/segment.h"
#include "terrain/query/sweep.h"
#include "terrain/query/triangles.h"

namespace karst::core {
namespace {

constexpr double kSteps = kStepsPerVoxel;
// Segments shorter than this have no length: their inverse would not be finite. Lattice steps.
constexpr double kLeastLength = 1e-30;

// Segments are cut to the world's box grown by this, more than undisplaced patches stand out of it; the same
// for all questions, so that what is not met at the rim does not change the bits of what is met inside.
// Lattice steps.
constexpr double kCutGrowth = kMaxHeight + kStepsPerVoxel;
// Of a segment's components that are next to nothing: what lies beside them is not met.
constexpr double kMostInverse = 1e12;
constexpr double kHigh = 1e9;  // voxels; above everything

bool good(glm::dvec3 place) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(place[axis]) <= Query::kReach)) return false;
  }
  return true;
}

double largest(glm::dvec3 v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

glm::dvec3 unit(glm::dvec3 v) {
  return v / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

// How far boxes are grown for a question: with a sphere's radius, and where undisplaced patches may be met.
struct Growth {
  bool undisplaced;
  double patches;
  double nodes;

  Growth(const QueryPatches& of, Wait wait, double radius = 0.0)
      : undisplaced(of.undisplaced_reach() > 0 && (wait == Wait::never || of.failed_reads() > 0)),
        patches(kBoxMargin + 1.000002 * radius),  // roundings grow with the radius
        nodes(patches + (undisplaced ? of.undisplaced_reach() : 0)) {}
};

// Where a segment enters a box grown by so much, as its share; above 1: nowhere. inverse: of its way.
double entry_of(const Segment& segment, glm::dvec3 inverse, const NodeBox& box, double grow) {
  double first = 0.0;
  double last = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.low[axis] - grow - segment.from[axis];
    const double high = box.high[axis] + grow - segment.from[axis];
    if (!(std::abs(inverse[axis]) < kMostInverse)) {
      if (low > 0.0 || high < 0.0) return 2.0;
      continue;
    }
    const double to_low = low * inverse[axis], to_high = high * inverse[axis];
    first = std::max(first, std::min(to_low, to_high));
    last = std::min(last, std::max(to_low, to_high));
  }
  return first <= last ? first : 2.0;
}

// Where triangles are of.
struct Source {
  PatchId patch;
  std::int64_t first;  // of the tile's triangles, among all with this patch
  std::uint8_t level;
  bool coarse;

  void tell(QueryHit& hit) const {
    hit.patch = patch;
    hit.level = level;
    hit.coarse = coarse;
  }
};

Source source_of(const QueryPatches& patches, PatchId id, const QueryPatch& patch, int i, int j) {
  const auto level = static_cast<std::uint8_t>(patch.displaced ? patch.level : 0);
  return {id, (j * (patch_cells(patch.level) / 2) + i) * 8, level, level < patches.level()};
}

Source source_of(const QueryGround::Met& met, int level) {
  const std::int64_t node = (std::int64_t{met.node.z} << 24) + met.node.x;
  return {QueryHit::kGround, (node * 4 + met.tile) * 8,
          static_cast<std::uint8_t>(std::max(1, level - met.node.size)), met.node.size > 0};
}

Source source_of_field(int level) {
  return {QueryHit::kField, 0, static_cast<std::uint8_t>(std::max(1, level)), false};
}

// Calls visit(id) for the patches whose boxes are within a distance of a place, in the order of their
// numbers; returns how many. Lattice steps.
template <class Visit>
std::uint32_t patches_near(const QueryPart& world, glm::dvec3 place, double distance, Visit&& visit) {
  const auto near = [&](const LatticeBox& box) {
    const glm::dvec3 nearest = glm::clamp(place, glm::dvec3(box.min), glm::dvec3(box.max));
    const glm::dvec3 d = place - nearest;
    return d.x * d.x + d.y * d.y + d.z * d.z <= distance * distance;
  };
  const BoundsTree& tree = *world.tree;
  std::uint32_t count = 0;
  for (PatchId id = 0; id < tree.patches();) {
    // The largest node that starts here and is not near is passed over.
    int row = 0;
    for (; row + 1 < tree.rows() && id % (1u << (BoundsTree::kFanOutLog2 * (row + 2))) == 0;) ++row;
    bool passed = false;
    for (; id % BoundsTree::kFanOut == 0 && row >= 0 && !passed; --row) {
      const std::uint32_t n = id >> (BoundsTree::kFanOutLog2 * (row + 1));
      if (near(tree.node(row, n))) continue;
      id += tree.patch_count(row, n);
      passed = true;
    }
    if (passed) continue;
    if (!world.surface.is_free(id) && near(patch_box(world.surface, world.bounds, id))) {
      ++count;
      visit(id);
    }
    ++id;
  }
  return count;
}

// The same of all parts.
template <class Visit>
std::uint32_t patches_near_in_all(const QueryWorld& world, glm::dvec3 place, double distance, Visit&& visit) {
  std::uint32_t count = 0;
  for (std::size_t n = 0; n < world.parts(); ++n) {
    const QueryPart& part = world.part(n);
    const glm::dvec3 local = place - glm::dvec3(part.corner) * kSteps;
    count += patches_near(part, local, distance, [&](PatchId id) { visit(part.first + id); });
  }
  return count;
}

struct Order {
  PatchId patch;
  std::int64_t triangle;
  friend bool operator<(const Order& a, const Order& b) {
    return a.patch != b.patch ? a.patch < b.patch : a.triangle < b.triangle;
  }
};

}  // namespace

LatticeBox Query::world_box() const {
  bool any = ground_.exists();
  LatticeBox all = any ? ground_.box() : LatticeBox();
  for (std::size_t n = 0; has_patches() && n < patches_.world().parts(); ++n) {
    const QueryPart& part = patches_.world().part(n);
    if (part.tree->rows() == 0) continue;  // a field's, or one that all patches were taken from
    const LatticeBox box = part.tree->around_all(part.corner);
    all = any ? LatticeBox{glm::min(all.min, box.min), glm::max(all.max, box.max)} : box;
    any = true;
  }
  if (!field_.exists()) return all;
  const LatticeBox box = field_.box();
  return any ? LatticeBox{glm::min(all.min, box.min), glm::max(all.max, box.max)} : box;
}

// Calls visit_triangle(source, corners) for triangles of the field that a sphere on the segment may meet
// before t = limit().
template <class Limit, class VisitTriangle>
void Query::walk_field(const Segment& segment, double radius, Limit& limit,
                       VisitTriangle& visit_triangle) const {
  struct Through final : QueryField::Walk {
    double limit() const override { return double{no_further()}; }
    void visit(std::int64_t number, const glm::dvec3 (&corner)[3]) override {
      source.first = number;
      seen(source, corner);
    }
    Through(const Source& of_field, Limit& end, VisitTriangle& see)
        : source(of_field), no_further(end), seen(see) {}
    Source source;
    Limit& no_further;
    VisitTriangle& seen;
  } through(source_of_field(level()), limit, visit_triangle);
  field_.run(segment.from, segment.way, radius, through);
}

// Calls visit(source, tile) for tiles that a sphere on the segment may meet before t = limit(), and
// visit_triangle(source, corners) for single triangles. at: where it meets the ground's grid, if it runs
// along the ground's up there, or null.
template <class Limit, class Visit, class VisitTriangle>
void Query::walk_segment(const Segment& segment, double radius, Wait wait, const GridPlace* at, Limit& limit,
                         Visit& visit, VisitTriangle& visit_triangle) {
  const Growth growth(patches_, wait, radius);
  for (std::size_t n = 0; has_patches() && n < patches_.world().parts(); ++n) {
    const QueryPart& part = patches_.world().part(n);
    Segment local = segment;
    local.from -= glm::dvec3(part.corner) * kSteps;
    const SlabTest node_test(local, growth.nodes);
    const SlabTest patch_test(local, growth.patches);
    SlabTest tile_test(segment, growth.patches);
    walk_patches(part, node_test, patch_test, growth.undisplaced, limit, [&](PatchId of_part) {
      const PatchId id = part.first + of_part;
      const QueryPatch patch = patches_.get(id, wait == Wait::for_file);
      tile_test.move_to(segment, patch.origin, growth.patches);
      walk_tiles(patch, tile_test, limit, [&](int i, int j) {
        visit(source_of(patches_, id, patch, i, j), TileVertices(patch, i, j));
      });
    });
  }
  if (field_.exists()) walk_field(segment, radius, limit, visit_triangle);
  if (!ground_.exists()) return;
  struct Along final : QueryGround::Walk {
    double distance(const NodeBox& box) const override {
      const double first = entry_of(segment, inverse, box, grow);
      return first <= double{limit()} ? first : -1.0;
    }
    void visit(const QueryGround::Met& met, const TileVertices& tile) override {
      visit_tile(source_of(met, level), tile);
    }
    Along(const Segment& way, double by, int of_query, Limit& no_further, Visit& seen)
        : segment(way),
          inverse(1.0 / way.way),
          grow(by),
          level(of_query),
          limit(no_further),
          visit_tile(seen) {}
    const Segment& segment;
    glm::dvec3 inverse;
    double grow;
    int level;
    Limit& limit;
    Visit& visit_tile;
  } along(segment, growth.patches, std::max(level(), 1), limit, visit);
  // Edges of quads are straight and the grid's lines are not: they are apart by less than the angle that
  // ground turns by from one sample to the next, as a share of the step.
  constexpr double kLeastWithin = 1.0 / 32;
  if (at == nullptr || !ground_.run_at(*at, kLeastWithin + ground_.info().basis.turn_rad, along))
    ground_.run(wait == Wait::for_file, along);
}

// Calls visit(source, triangle of the tile, its area, height, up) for what the vertical line through a place
// crosses between bottom and top, lattice steps. limit(): the height below which nothing is wanted any more.
template <class Limit, class Visit>
void Query::walk_line(glm::dvec3 place, double top, double bottom, Wait wait, Limit&& limit, Visit&& visit) {
  const VerticalLine line(place);
  const LatticeBox box = world_box();
  if (!(top > bottom)) return;
  if (line.x < box.min.x - kCutGrowth || line.x > box.max.x + kCutGrowth || line.z < box.min.z - kCutGrowth ||
      line.z > box.max.z + kCutGrowth || top < box.min.y - kCutGrowth || bottom > box.max.y + kCutGrowth)
    return;
  const auto cross_tile = [&](const Source& source, const TileVertices& tile) {
    line.cross(tile, [&](int t, double height, bool up) {
      if (height > top || height < bottom) return;
      visit(source, t, tile.area(t), height, up);
    });
  };
  const Growth growth(patches_, wait);
  const auto node_growth = static_cast<int>(growth.nodes) + 1;
  const auto patch_growth = static_cast<int>(growth.patches) + 1;
  for (std::size_t n = 0; has_patches() && n < patches_.world().parts(); ++n) {
    const QueryPart& part = patches_.world().part(n);
    const glm::dvec3 corner = glm::dvec3(part.corner) * kSteps;
    const ColumnTest node_test(line.x - corner.x, line.z - corner.z, top - corner.y, node_growth);
    const ColumnTest patch_test(line.x - corner.x, line.z - corner.z, top - corner.y, patch_growth);
    const auto visit_patch = [&](PatchId of_part) {
      const PatchId id = part.first + of_part;
      const QueryPatch patch = patches_.get(id, wait == Wait::for_file);
      const auto local = [](double steps) { return static_cast<float>(std::clamp(steps, -1e6, 1e6)); };
      walk_tile_column(
          patch, local(line.x - patch.origin.x), local(top - patch.origin.y), local(line.z - patch.origin.z),
          static_cast<float>(patch_growth), [&] { return local(limit() - patch.origin.y); },
          [&](int i, int j) { cross_tile(source_of(patches_, id, patch, i, j), TileVertices(patch, i, j)); });
    };
    const auto least = [&] { return ColumnTest::whole(limit() - corner.y); };
    if (growth.undisplaced) {
      walk_column<true>(part, node_test, patch_test, node_growth, least, visit_patch);
    } else {
      walk_column<false>(part, node_test, patch_test, node_growth, least, visit_patch);
    }
  }
  Segment segment;
  if (field_.exists() && segment.cut({line.x, top, line.z}, {line.x, bottom, line.z}, box, kCutGrowth) &&
      segment.length >= kLeastLength) {
    const auto share_limit = [&] {
      return box_limit(std::clamp((segment.from.y - limit()) / segment.length, 0.0, 1.0));
    };
    const auto visit_triangle = [&](const Source& source, const glm::dvec3(&corner)[3]) {
      double height = 0;
      bool up = false;
      if (!line.cross(corner, height, up) || height > top || height < bottom) return;
      visit(source, 0, area_of(corner), height, up);
    };
    walk_field(segment, 0.0, share_limit, visit_triangle);
  }
  if (!ground_.exists()) return;
  struct Down final : QueryGround::Walk {
    double distance(const NodeBox& node) const override {
      if (line.x < node.low.x - grow || line.x > node.high.x + grow || line.z < node.low.z - grow ||
          line.z > node.high.z + grow || top < node.low.y - grow || node.high.y + grow < limit())
        return -1.0;
      return std::max(0.0, top - node.high.y);
    }
    void visit(const QueryGround::Met& met, const TileVertices& tile) override {
      cross(source_of(met, level), tile);
    }
    Down(const VerticalLine& way, double from, double by, int of_query, Limit& no_lower,
         const decltype(cross_tile)& seen)
        : line(way), top(from), grow(by), level(of_query), limit(no_lower), cross(seen) {}
    const VerticalLine& line;
    double top, grow;
    int level;
    Limit& limit;
    const decltype(cross_tile)& cross;
  } down(line, top, growth.patches, std::max(level(), 1), limit, cross_tile);
  const GroundInfo& info = ground_.info();
  const auto index = [&](int axis, double steps) {
    return (steps - static_cast<double>(info.corner[axis]) * kVertexStep) / info.steps[axis];
  };
  // Samples are rounded to kVertexStep.
  const double within = (growth.patches + kVertexStep) / std::min(info.steps[0], info.steps[1]);
  if (!ground_.run_at({index(0, line.x), index(1, line.z), 0, 0}, within, down))
    ground_.run(wait == Wait::for_file, down);
}

// On a curved basis: the ground below a place, no higher than step above it, along the place's own up. There
// is one surface at most.
bool Query::drop(glm::dvec3 place, double step, Wait wait, QueryHit& hit) {
  hit = {};
  const GroundInfo& info = ground_.info();
  const double voxel_m = info.basis.height_unit_m / kVertexStep * kStepsPerVoxel;
  GridPlace at;
  if (!grid_of(info.basis, place * voxel_m, at)) return false;
  const glm::dvec3 up = up_at(info.basis, at);
  const double height = at.height_m / voxel_m;
  const double top = std::min(height + step, info.basis.height_m(info.high) / voxel_m + 1.0);
  const double bottom = info.basis.height_m(info.low) / voxel_m - 1.0;
  // A caller's function may bend what is up.
  const bool is_straight = info.basis.kind != BasisKind::function;
  if (!(top > bottom) || !cast(place + up * (top - height), place + up * (bottom - height), wait,
                               is_straight ? &at : nullptr, hit))
    return false;
  hit.distance = glm::dot(place - hit.place, up);
  return true;
}

Status Query::prepare(glm::dvec3 place, double radius) {
  if (!good(place)) return {StatusCode::invalid_argument, "not a place near a world", "place"};
  if (!(radius >= 0.0 && radius <= kReach)) {
    return {StatusCode::invalid_argument, "not 0 to 2^30 voxels", "radius"};
  }
  if (ground_.exists()) {
    // A walk through all of them reads them; more than there is room for give way to each other.
    const std::uint64_t failed = ground_.failed_reads();
    const glm::dvec3 at = place * kSteps;
    const double reach = radius * kSteps;
    struct Around final : QueryGround::Walk {
      double distance(const NodeBox& box) const override {
        const glm::dvec3 d = at - glm::clamp(at, box.low, box.high);
        const double away = curved ? glm::length(d) : std::max(std::abs(d.x), std::abs(d.z));
        return away <= reach ? away : -1.0;
      }
      void visit(const QueryGround::Met&, const TileVertices&) override {}
      Around(glm::dvec3 place_steps, double steps, bool has_basis)
          : at(place_steps), reach(steps), curved(has_basis) {}
      glm::dvec3 at;
      double reach;
      bool curved;
    } around(at, reach, ground_.info().basis.is_curved());
    ground_.run(true, around);
    if (ground_.failed_reads() != failed) return ground_.trouble();
  }
  if (!has_patches()) return {};
  const QueryWorld& world = patches_.world();
  const std::uint32_t count = patches_near_in_all(world, place * kSteps, radius * kSteps, [](PatchId) {});
  double within = radius;
  if (count > patches_.capacity()) {
    // The widest circle that has no more patches than there is room for, to a thousandth.
    double low = 0.0;
    for (int n = 0; n < 10; ++n) {
      const double middle = 0.5 * (low + within);
      const bool fits =
          patches_near_in_all(world, place * kSteps, middle * kSteps, [](PatchId) {}) <= patches_.capacity();
      (fits ? low : within) = middle;
    }
    within = low;
  }
  const std::uint64_t failed = patches_.failed_reads();
  patches_near_in_all(world, place * kSteps, within * kSteps, [this](PatchId id) { patches_.get(id, true); });
  if (patches_.failed_reads() != failed) return patches_.trouble();
  if (count > patches_.capacity()) {
    return {StatusCode::limit_reached, "more patches than a query keeps ready", "query_patches", count};
  }
  return {};
}

std::uint32_t Query::column(glm::dvec3 place, Wait wait, std::span<QueryHit> out) {
  if (is_empty() || !good(place)) return 0;
  if (is_curved()) {
    QueryHit hit;
    if (!drop(place, kHigh, wait, hit)) return 0;
    if (!out.empty()) out[0] = hit;
    return 1;
  }
  const LatticeBox box = world_box();
  const double reach = patches_.undisplaced_reach() + kBoxMargin;
  const double bottom = box.min.y - reach;
  std::uint32_t count = 0;
  walk_line(
      place * kSteps, box.max.y + reach, bottom, wait, [&] { return bottom; },
      [&](const Source& source, int, const glm::dvec3& area, double height, bool) {
        QueryHit hit;
        hit.place = glm::dvec3(place.x, height / kSteps, place.z);
        hit.normal = unit(area);
        hit.distance = place.y - hit.place.y;
        source.tell(hit);
        // Sorted into what is there; beyond the end of out the lowest one is dropped. Equal heights: by
        // patch.
        std::size_t held = std::min<std::size_t>(count, out.size());
        ++count;
        std::size_t at = held;
        const auto above = [](const QueryHit& a, const QueryHit& b) {
          return a.place.y != b.place.y ? a.place.y > b.place.y : a.patch < b.patch;
        };
        while (at > 0 && above(hit, out[at - 1])) --at;
        if (at == out.size()) return;
        if (held == out.size()) --held;
        for (std::size_t n = held; n > at; --n) out[n] = out[n - 1];
        out[at] = hit;
      });
  return count;
}

bool Query::ground(glm::dvec3 place, double step, Wait wait, QueryHit& hit) {
  hit = {};
  if (is_empty() || !good(place) || !(std::abs(step) <= kReach)) return false;
  if (is_curved()) return drop(place, step, wait, hit);
  const LatticeBox box = world_box();
  const double reach = patches_.undisplaced_reach() + kBoxMargin;
  const double bottom = box.min.y - reach;
  double best = bottom;
  Order first{QueryHit::kNone, 0};
  walk_line(
      place * kSteps, std::min((place.y + step) * kSteps, box.max.y + reach), bottom, wait,
      [&] { return best; },
      [&](const Source& source, int t, const glm::dvec3& area, double height, bool up) {
        const Order order{source.patch, source.first + t};
        if (!up || height < best || (height == best && first < order)) return;
        best = height;
        first = order;
        hit.normal = unit(area);
        source.tell(hit);
      });
  if (!hit.found()) return false;
  hit.place = glm::dvec3(place.x, best / kSteps, place.z);
  hit.distance = place.y - hit.place.y;
  return true;
}

bool Query::inside(glm::dvec3 place, Wait wait) {
  if (is_empty() || !good(place)) return false;
  if (is_curved()) {
    QueryHit above;
    return drop(place, kHigh, wait, above) && above.distance < 0;
  }
  const LatticeBox box = world_box();
  const double top = box.max.y + patches_.undisplaced_reach() + kBoxMargin;
  const double height_of_place = place.y * kSteps;
  int up_less_down = 0;
  walk_line(
      place * kSteps, top, height_of_place, wait, [&] { return height_of_place; },
      [&](const Source&, int, const glm::dvec3&, double height, bool up) {
        if (height > height_of_place) up_less_down += up ? 1 : -1;
      });
  return up_less_down > 0;
}

bool Query::ray(glm::dvec3 from, glm::dvec3 to, Wait wait, QueryHit& hit) {
  return cast(from, to, wait, nullptr, hit);
}

// at: as walk_segment() has it.
bool Query::cast(glm::dvec3 from, glm::dvec3 to, Wait wait, const GridPlace* at, QueryHit& hit) {
  hit = {};
  if (is_empty() || !good(from) || !good(to)) return false;
  Segment segment;
  if (!segment.cut(from * kSteps, to * kSteps, world_box(), kCutGrowth)) return false;
  if (!(largest(segment.way) >= kLeastLength)) return false;
  const SegmentShear shear(segment);
  double best = 1.0;
  Order first{QueryHit::kNone, 0};
  const auto limit = [&] { return box_limit(best); };
  const auto meet = [&](const Source& source, int t, double share, const glm::dvec3& place,
                        const glm::dvec3& area) {
    const Order order{source.patch, source.first + t};
    if (share > best || (share == best && first < order)) return;
    best = share;
    first = order;
    hit.place = place;
    hit.normal = area;
    source.tell(hit);
  };
  const auto visit_tile = [&](const Source& source, const TileVertices& tile) {
    shear.cross(tile,
                [&](int t, double share, glm::dvec3 place) { meet(source, t, share, place, tile.area(t)); });
  };
  const auto visit_triangle = [&](const Source& source, const glm::dvec3(&corner)[3]) {
    double share = 0;
    glm::dvec3 place;
    if (shear.cross(corner, share, place)) meet(source, 0, share, place, area_of(corner));
  };
  walk_segment(segment, 0.0, wait, at, limit, visit_tile, visit_triangle);
  if (!hit.found()) return false;
  hit.place = hit.place / kSteps;
  hit.normal = unit(hit.normal);
  hit.distance = (segment.before + best * segment.length) / kSteps;
  return true;
}

bool Query::sphere(glm::dvec3 from, glm::dvec3 to, double radius, Wait wait, QueryHit& hit) {
  hit = {};
  if (is_empty() || !good(from) || !good(to) || !(radius >= 0.0 && radius <= kReach)) return false;
  Segment segment;
  if (!segment.cut(from * kSteps, to * kSteps, world_box(), kCutGrowth + radius * kSteps)) return false;
  if (!(largest(segment.way) >= kLeastLength)) segment.way = glm::dvec3(0.0);
  Contact best;
  Order first{QueryHit::kNone, 0};
  const auto limit = [&] { return box_limit(best.t); };
  const auto meet = [&](const Source& source, int t, const Triangle& triangle) {
    const glm::dvec3 area = area_of(triangle.corner);
    Contact contact;
    if (!sweep_triangle(segment, radius * kSteps, triangle, area, best, contact)) return;
    const Order order{source.patch, source.first + t};
    if (best < contact || (!(contact < best) && first < order)) return;
    best = contact;
    first = order;
    hit.normal = area;
    source.tell(hit);
  };
  const auto visit_tile = [&](const Source& source, const TileVertices& tile) {
    for (int t = 0; t < 8; ++t)
      meet(source, t, Triangle{{tile.corner(t, 0), tile.corner(t, 1), tile.corner(t, 2)}});
  };
  const auto visit_triangle = [&](const Source& source, const glm::dvec3(&corner)[3]) {
    meet(source, 0, Triangle{{corner[0], corner[1], corner[2]}});
  };
  walk_segment(segment, radius * kSteps, wait, nullptr, limit, visit_tile, visit_triangle);
  if (!hit.found()) return false;
  hit.place = best.place / kSteps;
  hit.normal = unit(hit.normal);
  hit.distance = (segment.before + best.t * segment.length) / kSteps;
  return true;
}

void Query::rays(std::span<const glm::dvec3> from, std::span<const glm::dvec3> to, Wait wait,
                 std::span<QueryHit> hits) {
  KARST_ASSERT(from.size() == to.size() && from.size() == hits.size());
  for (std::size_t n = 0; n < from.size(); ++n) ray(from[n], to[n], wait, hits[n]);
}

}  // namespace karst::core
