// SPDX-License-Identifier: MIT
// Breadth first, size by size: whether a node is split depends on what is there of its size, so all of a
// size is decided before any of it gets children. Boxes are measured from the camera's voxel, in double:
// they may be planets.
#include "terrain/nodes/ground_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/draw/index_batches.h"
#include "terrain/draw/wall_indices.h"
#include "terrain/ground/ground_box.h"
#include "terrain/view/frustum.h"

namespace karst::core {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
// What halves and floats lose of a threshold and of distances: a factor a size.
constexpr double kThresholdRounding = 1.0 + 0x1p-9;
// Of a box's corner, what a plane of float coefficients and the GPU may be off by (frustum.cpp).
constexpr double kPlaneRounding = 0x1p-19;

// Over which of a node's eight directions its children's lie: a step to the south and to the east.
struct Step {
  int south, east;
};
// Edges 0..3: west, south, east, north; corners 0..3: north-west, south-west, south-east, north-east.
constexpr Step kAround[8] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}, {-1, -1}, {1, -1}, {1, 1}, {-1, 1}};

constexpr int direction_of(Step step) {
  for (int d = 0; d < 8; ++d) {
    if (kAround[d].south == step.south && kAround[d].east == step.east) return d;
  }
  return -1;
}

// No drawn point of a node is further from the full surface; lattice steps. A threshold is at least demand
// times error.
float most_error(const GroundInfo& info, const NodeMeasure& measure, int size) {
  const std::uint16_t greatest = measure.thresholds[kDemands - 1];
  if (greatest >= kNeverMorphs) return kInfinite;
  return threshold_steps(greatest) * std::ldexp(1.0f, info.page_size(size)) /
         static_cast<float>(demand(kDemands - 1));
}

// Relative to the camera's voxel.
Frustum planes_at(const GroundRequest& request) {
  Camera camera = *request.camera;
  const glm::dvec3 corner = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
  if (request.frustum != nullptr) {
    Frustum moved = *request.frustum;
    for (Plane& plane : moved.planes) {
      const double offset = double{plane.offset} + glm::dot(glm::dvec3(plane.normal), corner);
      // What floats lost of both terms.
      plane.offset = static_cast<float>(
          offset +
          (std::abs(offset) + std::abs(double{plane.offset}) + glm::length(corner)) * kPlaneRounding);
    }
    return moved;
  }
  camera.voxel = glm::ivec3(0);
  return make_frustum(camera);
}

}  // namespace

struct GroundView::Looks {
  const GroundInfo& info;
  const GroundRequest& request;
  TileCache& tiles;
  Frustum frustum;    // relative to the camera's voxel
  glm::dvec3 fine;    // the eye, relative to it
  glm::dvec3 corner;  // of the camera's voxel, steps
  glm::vec3 forward;
  DemandPlace demand{};
  bool is_finite = true;                     // the demand
  double steps_away = 0;                     // sides_away, of a node of size 0, over unit[0]
  std::array<double, kMostSize + 1> unit{};  // by size: 2^s f^s
  int top = 0;
};

void GroundView::select(const GroundInfo& info, const GroundRequest& request, TileCache& tiles,
                        FamilyPool& pool) {
  KARST_ASSERT(info.exists() && request.camera != nullptr);
  result_ = {};
  result_.bound_px = request.sides_away > 0 ? 0.0f : static_cast<float>(request.error_px);
  node_count_ = 0;
  if (known_rows_ == 0) {
    known_rows_ = static_cast<std::uint32_t>(storage_.rows.size()) / kMorphRow;
    std::fill(storage_.rows.begin(), storage_.rows.end(), kNeverMorphs);
    dirty_begin_ = 0;
    dirty_end_ = known_rows_;
  }
  const Camera& camera = *request.camera;
  Looks looks{info,
              request,
              tiles,
              planes_at(request),
              glm::dvec3(camera.fine),
              glm::dvec3(camera.voxel) * double{kStepsPerVoxel},
              glm::vec3(camera.forward)};
  looks.top = info.top_size();
  const float least_cos2 = request.scale.least_cos2;
  const double rounding = kThresholdRounding * (least_cos2 < 0.0f ? 1.0 : 1.0 + 0x1p-16 / double{least_cos2});
  looks.unit[0] = std::ldexp(1.0, info.lattice_size);
  for (std::size_t size = 1; size < looks.unit.size(); ++size)
    looks.unit[size] = looks.unit[size - 1] * 2 * rounding;
  const bool by_error = request.sides_away <= 0;
  looks.is_finite = !by_error || request.scale.steps_per_step < kInfinite;
  looks.demand = place_of_demand(by_error && looks.is_finite ? double{request.scale.steps_per_step} : 1.0);
  looks.steps_away =
      std::max(request.sides_away, 0.0) * kNodeQuads * std::max(info.steps[0], info.steps[1]) / looks.unit[0];

  Node& root = storage_.nodes[0];
  root = {};
  root.key = {looks.top, 0, 0};
  for (std::int32_t& there : root.around) there = Node::kOutside;
  root.tile = tiles.find(tile_of(root.key));
  root.parent_family = pool.see(root.key.parent());
  node_count_ = 1;
  KARST_ASSERT(root.tile != nullptr);
  if (root.parent_family == FamilyPool::kNone) return;
  look_at(looks, root);

  std::uint32_t begin = 0;
  for (std::uint32_t end = 1; begin < end; begin = end, end = node_count_) {
    for (std::uint32_t n = begin; n < end; ++n) decide(looks, pool, storage_.nodes[n]);
    for (std::uint32_t n = begin; n < end; ++n) {
      if (storage_.nodes[n].family != FamilyPool::kNone) add_children(looks, static_cast<std::int32_t>(n));
    }
    for (std::uint32_t n = begin; n < end; ++n) {
      const Node& node = storage_.nodes[n];
      if (!node.is_split()) continue;
      link_children(looks, static_cast<std::int32_t>(n));
      make_row(looks, node);
    }
  }
  result_.visited = node_count_;
  result_.region = request.has_region && leaves_region(looks);
  list(looks);
}

// Its box, whether that is in view, and how near it is.
void GroundView::look_at(const Looks& looks, Node& node) const {
  const NodeMeasure& measure = node.tile->nodes[node_in_tile(node.key)];
  const NodeBox box = node_box(looks.info, measure, node.key);
  glm::dvec3 low = box.low - looks.corner;
  const glm::dvec3 high = box.high - looks.corner;
  node.in_view = true;
  const double lowest = low.y;
  if (looks.request.culls) {
    // Walls are not in its box.
    if (node_walls(looks.info, node.key) != 0) {
      low.y = std::min(low.y, double(std::int64_t{looks.info.low} * kVertexStep) - looks.corner.y);
    }
    const glm::dvec3 farthest = glm::max(glm::abs(low), glm::abs(high));
    const double margin = (farthest.x + farthest.y + farthest.z) * kPlaneRounding;
    for (const Plane& plane : looks.frustum.planes) {
      double inmost = double{plane.offset} + margin;
      for (int axis = 0; axis < 3; ++axis) {
        const double normal = plane.normal[axis];
        inmost += std::max(normal * low[axis], normal * high[axis]);
      }
      if (inmost < 0) node.in_view = false;
    }
  }
  // Belts are not in boxes of nodes, and need all nodes around the region.
  if (looks.request.has_region && borders_region(looks.info, node.key)) node.in_view = true;
  low.y = lowest;
  // As least_apparent_distance(), in double but for what the GPU computes in float.
  const float least_cos2 = looks.request.scale.least_cos2;
  if (least_cos2 < 0.0f) {
    node.least_apparent = -least_cos2;
  } else {
    const glm::dvec3 d = 0.5 * (low + high) - looks.fine;
    const double reach = 0.5 * kSteepest * glm::length(high - low);
    const double r = glm::length(d);
    const double ahead = std::max(0.0, glm::dot(d, glm::dvec3(looks.forward)));
    const double seen = std::max(ahead * ahead, double{least_cos2} * r * r) / std::max(r, 1.0);
    node.least_apparent = static_cast<float>(seen - r * 0x1p-17 - (reach + 2.0));
  }
  node.threshold = 0.0f;
  if (node.key.size == 0) return;
  double threshold = double{kInfinite};
  const std::uint16_t* const halves = measure.thresholds + looks.demand.n;
  if (looks.request.morphing && looks.is_finite && halves[1] < kNeverMorphs) {
    const double at_n = double{threshold_steps(halves[0])};
    const double after_n = double{threshold_steps(halves[1])};
    threshold = ((at_n + (after_n - at_n) * looks.demand.share) * looks.demand.factor + looks.steps_away) *
                looks.unit[static_cast<std::size_t>(node.key.size)];
  }
  node.threshold = threshold_steps(threshold_half(static_cast<float>(threshold)));
}

// Whether a node is to be split: then it has a family. Its children are not there yet.
void GroundView::decide(const Looks& looks, FamilyPool& pool, Node& node) {
  if (!node.in_view) {
    ++result_.culled;
    return;
  }
  if (node.key.size == 0) return;
  const bool is_near = node.least_apparent < node.threshold;
  if (!is_near && looks.steps_away == 0) return;
  const float error = most_error(looks.info, node.tile->nodes[node_in_tile(node.key)], node.key.size);
  const float left = node.least_apparent - error;
  const float px = left > 0.0f ? looks.request.scale.pixels * error / left : kInfinite;
  if (!is_near) {
    result_.bound_px = std::max(result_.bound_px, px);
    return;
  }
  if (node.key.size <= looks.request.least_size || error <= looks.request.spared_error) {
    node.refused = true;
    result_.bound_px = std::max(result_.bound_px, px);
    return;
  }
  const NodeKey below = tile_of(node.key.child(0));
  const bool has_tile = looks.tiles.find(below) != nullptr;
  if (!has_tile) {
    // Which of its tile's four children that is.
    const int quadrant = (below.x & 1) | (below.z & 1) << 1;
    looks.tiles.want(below, node.tile->children[quadrant], px);
    ++result_.lacks_tile;
  }
  const bool enclosed = std::none_of(std::begin(node.around), std::end(node.around),
                                     [](std::int32_t n) { return n == Node::kNotThere; });
  if (has_tile && enclosed) {
    node.family = pool.see(node.key);
    if (node.family != FamilyPool::kNone) return;
    ++result_.lacks_room;
  }
  node.refused = true;
  ++result_.refused;
  result_.bound_px = std::max(result_.bound_px, px);
}

void GroundView::add_children(const Looks& looks, std::int32_t parent) {
  Node& node = storage_.nodes[static_cast<std::size_t>(parent)];
  // There is room for the children of as many nodes as there are families.
  KARST_ASSERT(node_count_ + 4 <= storage_.nodes.size());
  node.first_child = static_cast<std::int32_t>(node_count_);
  node_count_ += 4;
  const Tile* const tile = looks.tiles.find(tile_of(node.key.child(0)));
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    Node& child = storage_.nodes[static_cast<std::size_t>(node.first_child + quadrant)];
    child = {};
    child.key = node.key.child(quadrant);
    child.tile = tile;
    child.parent_family = node.family;
    if (node_exists(looks.info, child.key)) look_at(looks, child);
  }
}

void GroundView::link_children(const Looks& looks, std::int32_t parent) {
  const Node& node = storage_.nodes[static_cast<std::size_t>(parent)];
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    Node& child = storage_.nodes[static_cast<std::size_t>(node.first_child + quadrant)];
    for (int d = 0; d < 8; ++d) {
      const int south = (quadrant >> 1) + kAround[d].south;
      const int east = (quadrant & 1) + kAround[d].east;
      // Whose child that is: the parent's own, or that of one around it.
      const Step over{south < 0 ? -1 : south > 1 ? 1 : 0, east < 0 ? -1 : east > 1 ? 1 : 0};
      std::int32_t from = parent;
      if (over.south != 0 || over.east != 0) from = node.around[direction_of(over)];
      if (from < 0) {
        child.around[d] = from;
        continue;
      }
      const Node& other = storage_.nodes[static_cast<std::size_t>(from)];
      if (!other.in_view) {
        child.around[d] = Node::kOutOfView;
      } else if (!other.is_split()) {
        child.around[d] = Node::kNotThere;
      } else {
        const std::int32_t at = other.first_child + ((east & 1) | (south & 1) << 1);
        const bool exists = node_exists(looks.info, storage_.nodes[static_cast<std::size_t>(at)].key);
        child.around[d] = exists ? at : Node::kOutside;
      }
    }
  }
}

// Of a split node, for its family.
void GroundView::make_row(const Looks& looks, const Node& node) {
  std::array<std::uint16_t, kMorphRow> row{};
  const auto own = threshold_half(node.threshold);
  const auto shared = [&](std::uint16_t least, int direction) {
    const std::int32_t at = node.around[direction];
    if (at < 0) return least;
    const Node& other = storage_.nodes[static_cast<std::size_t>(at)];
    if (!other.in_view) return least;
    if (other.refused) return std::uint16_t{0};
    return std::min(least, threshold_half(other.threshold));
  };
  row[kFamilyInside] = own;
  for (int edge = 0; edge < 4; ++edge) row[static_cast<std::size_t>(family_edge(edge))] = shared(own, edge);
  for (int corner = 0; corner < 4; ++corner) {
    // The edges that meet there.
    std::uint16_t least = shared(own, corner);
    least = shared(least, (corner + 3) % 4);
    row[static_cast<std::size_t>(family_corner(corner))] = shared(least, 4 + corner);
  }
  if (!looks.request.morphing) std::fill(row.begin(), row.end(), kNeverMorphs);
  store_row(node.family + 1, row);
}

void GroundView::store_row(std::uint32_t row, std::span<const std::uint16_t, kMorphRow> halves) {
  const auto to = storage_.rows.subspan(std::size_t{row} * kMorphRow, kMorphRow);
  if (std::equal(halves.begin(), halves.end(), to.begin())) return;
  std::copy(halves.begin(), halves.end(), to.begin());
  if (dirty_begin_ == dirty_end_) dirty_begin_ = dirty_end_ = row;
  dirty_begin_ = std::min(dirty_begin_, row);
  dirty_end_ = std::max(dirty_end_, row + 1);
}

std::uint64_t GroundView::hash() const {
  std::uint64_t hash = result_.region ? 0xcbf29ce484222326u : 0xcbf29ce484222325u;
  const auto mix = [&](std::uint64_t word) { hash = (hash ^ word) * 0x100000001b3u; };
  for (std::size_t n = 0; n < result_.drawn; ++n) {
    const DrawItem& item = storage_.items[n];
    const Node& node = node_of(n);
    mix(std::uint64_t{item.patch} << 8 | item.lower_edges);
    mix(std::uint64_t{static_cast<std::uint32_t>(node.key.x)} << 32 | static_cast<std::uint32_t>(node.key.z));
    const std::size_t row = (std::size_t{node.parent_family} + 1) * kMorphRow;
    for (std::size_t entry = 1; entry <= kFamilyClasses; ++entry) mix(storage_.rows[row + entry]);
  }
  return hash;
}

MorphRows GroundView::take_rows() {
  if (dirty_begin_ == dirty_end_) return {};
  const MorphRows rows{dirty_begin_, storage_.rows.subspan(std::size_t{dirty_begin_} * kMorphRow,
                                                           (dirty_end_ - dirty_begin_) * kMorphRow)};
  dirty_begin_ = dirty_end_ = 0;
  return rows;
}

// Whether no node that has the region in part is drawn.
bool GroundView::leaves_region(const Looks& looks) const {
  for (const Node& node : nodes()) {
    if (node.in_view && !node.is_split() && in_region(looks.info, node.key) == InRegion::part) return false;
  }
  return true;
}

// From the root on, of four children the one that the eye stands over first.
void GroundView::list(const Looks& looks) {
  result_.least_size = looks.top;
  std::array<std::int32_t, 4 * (kMostSize + 2)> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  const glm::dvec3 eye = looks.corner + looks.fine;
  while (depth > 0) {
    const std::int32_t at = stack[--depth];
    const Node& node = storage_.nodes[static_cast<std::size_t>(at)];
    if (!node.in_view) continue;
    if (result_.region && in_region(looks.info, node.key) == InRegion::all) continue;
    if (!node.is_split()) {
      DrawItem item{};
      item.patch = 4 * node.parent_family + static_cast<std::uint32_t>(node.key.quadrant());
      item.level = kNodeLevel;
      for (int edge = 0; edge < 4; ++edge) {
        if (node.around[edge] == Node::kNotThere) item.lower_edges |= static_cast<std::uint8_t>(1 << edge);
      }
      item.walls = static_cast<std::uint8_t>(node_walls(looks.info, node.key));
      storage_.item_nodes[result_.drawn] = at;
      storage_.items[result_.drawn++] = item;
      result_.triangles +=
          (patch_index_count(item.level, item.lower_edges, 0) + wall_index_count(item.walls)) / 3;
      result_.least_size = std::min(result_.least_size, node.key.size);
      continue;
    }
    // The middle vertex of its family.
    const auto middle = [&](int axis, int index) {
      const std::int64_t vertex = (std::int64_t{2} * index + 1) * kNodeQuads;
      const std::int64_t sample = sample_of(looks.info.samples[axis], node.key.size - 1, vertex);
      return static_cast<double>(sample_place(looks.info, axis, sample) * kVertexStep);
    };
    const int near = (eye.x >= middle(0, node.key.x) ? 1 : 0) | (eye.z >= middle(1, node.key.z) ? 2 : 0);
    for (const int away : {3, 2, 1, 0}) stack[depth++] = node.first_child + (near ^ away);
  }
}

}  // namespace karst::core
