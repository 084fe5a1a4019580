// SPDX-License-Identifier: MIT
// Breadth first, size by size: whether a node is split depends on what is there of its size, so all of a
// size is decided before any of it gets children. Boxes are measured from the camera's voxel, in double:
// they may be planets.
#include "terrain/nodes/ground_view.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/draw/index_batches.h"
#include "terrain/draw/wall_indices.h"
#include "terrain/ground/ground_box.h"
#include "terrain/nodes/forecast.h"
#include "terrain/view/frustum.h"

namespace karst::core {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
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

// Where the neighbour of a child lies: a child of what is around its parent, or of the parent itself.
constexpr std::size_t kOwn = 8;
struct Link {
  std::uint8_t from = 0;  // the direction, or kOwn
  std::uint8_t quadrant = 0;
};
constexpr auto kLinks = [] {
  std::array<std::array<Link, 8>, 4> links{};
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    for (int d = 0; d < 8; ++d) {
      const int south = (quadrant >> 1) + kAround[d].south;
      const int east = (quadrant & 1) + kAround[d].east;
      const Step over{south < 0 ? -1 : south > 1 ? 1 : 0, east < 0 ? -1 : east > 1 ? 1 : 0};
      const bool is_own = over.south == 0 && over.east == 0;
      links[static_cast<std::size_t>(quadrant)][static_cast<std::size_t>(d)] = {
          static_cast<std::uint8_t>(is_own ? kOwn : static_cast<std::size_t>(direction_of(over))),
          static_cast<std::uint8_t>((east & 1) | (south & 1) << 1)};
    }
  }
  return links;
}();

// What the ellipsoid itself hides from an eye above it. All of the ground is above its lowest height, so what
// lies behind the horizon of an ellipsoid at that is not seen. In the space in which the ellipsoid is the
// unit sphere, which keeps lines, a place at distance r from the centre is seen if the angle between it and
// the eye there is at most acos(low / eye) + acos(low / r).
class Horizon {
 public:
  // None: nothing is hidden.
  Horizon() = default;
  Horizon(const GroundInfo& info, const glm::dvec3& eye_steps) : info_(&info) {
    const Basis& basis = info.basis;
    if (!basis.is_ellipsoid() || !level_shape(basis, shape_)) return;
    polar_m_ = basis.polar_radius_m();
    step_m_ = basis.height_unit_m / kVertexStep;
    eye_ = shape_.scale * (eye_steps * step_m_ - shape_.centre_m);
    const double distance = glm::length(eye_);
    low_ = 1.0 + least(basis.height_m(info.low)) - kSlack;
    if (!(distance > low_)) return;
    eye_ /= distance;
    eye_angle_ = std::acos(low_ / distance);
    exists_ = true;
  }

  bool hides(const NodeMeasure& measure, const NodeBall& ball) const {
    if (!exists_) return false;
    const glm::dvec3 centre = shape_.scale * (ball.centre * step_m_ - shape_.centre_m);
    const double distance = glm::length(centre);
    const double reach = ball.radius * step_m_ / polar_m_;
    if (!(reach < 0.9 * distance)) return false;
    const double angle =
        std::acos(std::clamp(glm::dot(eye_, centre) / distance, -1.0, 1.0)) - std::asin(reach / distance);
    const double top = 1.0 + most(info_->basis.height_m(measure.high)) + kSlack;
    return angle > eye_angle_ + std::acos(std::min(1.0, low_ / top)) + kSlack;
  }

 private:
  static constexpr double kSlack = 1e-6;
  double least(double height_m) const { return height_m / (height_m < 0 ? polar_m_ : info_->basis.radius_m); }
  double most(double height_m) const { return height_m / (height_m > 0 ? polar_m_ : info_->basis.radius_m); }

  const GroundInfo* info_ = nullptr;
  LevelShape shape_;
  double polar_m_ = 1, step_m_ = 1;
  glm::dvec3 eye_{0.0};
  double low_ = 0, eye_angle_ = 0;
  bool exists_ = false;
};

}  // namespace

struct GroundView::Looks {
  Looks(const GroundInfo& ground, const GroundRequest& asked, TileCache& cache)
      : info(ground),
        request(asked),
        tiles(cache),
        thresholds(ground, asked),
        frustum(planes_at(asked)),
        fine(asked.camera->fine),
        corner(glm::dvec3(asked.camera->voxel) * double{kStepsPerVoxel}),
        forward(asked.camera->forward),
        regions(asked.regions & ((std::uint32_t{1} << ground.region_count) - 1)) {}

  const GroundInfo& info;
  const GroundRequest& request;
  TileCache& tiles;
  NodeThresholds thresholds;
  Frustum frustum;    // relative to the camera's voxel
  glm::dvec3 fine;    // the eye, relative to it
  glm::dvec3 corner;  // of the camera's voxel, steps
  glm::vec3 forward;
  std::uint32_t regions;  // that there are and that are asked for
  int top = 0;
  unsigned walls = 15;  // that may face the eye, by edge
  Horizon horizon{};
  const Forecast* forecast = nullptr;  // of when what is asked for will have come; null: nothing moves

  // The tile of nodes' children: neighbours ask for the same one. Null: not there.
  const Tile* find_below(NodeKey tile) {
    Found& found = found_[static_cast<std::size_t>((tile.x & 1) | (tile.z & 1) << 1)];
    if (!found.valid || !(found.key == tile)) found = {tile, tiles.find(tile), true};
    return found.tile;
  }

 private:
  struct Found {
    NodeKey key;
    const Tile* tile = nullptr;
    bool valid = false;
  };
  std::array<Found, 4> found_{};
};

// Walls stand upright where the ground ends: those of an end that the eye is within are seen from behind, if
// at all. slack: what their places are rounded by, steps.
unsigned GroundView::facing_walls(const Looks& looks, double slack) {
  const GroundRequest& request = looks.request;
  const bool any = looks.info.basis.is_curved() || !request.culls || request.frustum != nullptr ||
                   request.camera->parallel;
  if (any) return 15;
  const glm::dvec3 eye = looks.corner + looks.fine;
  const auto place = [&](int axis, std::int64_t sample) {
    return static_cast<double>(sample_place(looks.info, axis, sample) * kVertexStep);
  };
  const auto within = [&](int axis, unsigned low, unsigned high) {
    const double at = eye[2 * axis];
    return (at < place(axis, 0) + slack ? low : 0u) |
           (at > place(axis, looks.info.samples[axis] - 1) - slack ? high : 0u);
  };
  return within(0, 1, 4) | within(1, 8, 2);
}

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
  Looks looks(info, request, tiles);
  looks.top = info.top_size();
  looks.walls = facing_walls(looks, std::ldexp(4.0, info.page_size(looks.top)));
  std::optional<Forecast> forecast;
  if (request.motion != glm::dvec3(0.0))
    looks.forecast = &forecast.emplace(info, request, request.motion * (kOfUse * tiles.frames_to_come()));

  if (info.basis.is_curved() && request.culls && request.frustum == nullptr && !request.camera->parallel)
    looks.horizon = Horizon(info, looks.corner + looks.fine);
  if (!add_roots(looks, pool)) return;

  std::uint32_t begin = 0;
  for (std::uint32_t end = node_count_; begin < end; begin = end, end = node_count_) {
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
  result_.regions = left_regions(looks);
  for (std::uint32_t rest = looks.regions & ~result_.regions; rest != 0; rest &= rest - 1)
    add_bound_of_closed(looks, rest & ~(rest - 1));
  list(looks);
}

// The root, or a cube's six. False: there is no room.
bool GroundView::add_roots(const Looks& looks, FamilyPool& pool) {
  const int wide = looks.info.is_cube() ? kCubeCells[0] : 1, deep = looks.info.is_cube() ? kCubeCells[1] : 1;
  for (int z = 0; z < deep; ++z) {
    for (int x = 0; x < wide; ++x) {
      const NodeKey key{looks.top, x, z};
      if (!node_exists(looks.info, key)) continue;
      Node& root = storage_.nodes[node_count_];
      root = {};
      root.key = key;
      for (std::int32_t& there : root.around) there = Node::kOutside;
      root.tile = looks.tiles.find(tile_of(root.key));
      root.parent_family = pool.see(root.key.parent());
      KARST_ASSERT(root.tile != nullptr);
      if (root.parent_family == FamilyPool::kNone) {
        node_count_ = 0;
        return false;
      }
      ++node_count_;
      root.walls = static_cast<std::uint8_t>(node_walls(looks.info, root.key));
      root.planes = looks.request.culls ? kAllPlanes : 0;
      root.touches = touched(looks, looks.regions, root.key);
      if (looks.info.basis.is_curved()) {
        look_at_ball(looks, root);
      } else {
        look_at(looks, node_box(looks.info, root.tile->nodes[node_in_tile(root.key)], root.key), root);
      }
    }
  }
  root_count_ = node_count_;
  for (std::uint32_t n = 0; n < root_count_ && (looks.info.is_cube() || looks.info.closes()); ++n) {
    Node& root = storage_.nodes[n];
    for (int d = 0; d < 8; ++d) {
      NodeKey key;
      if (!neighbour_of(looks.info, root.key, kAround[d].east, kAround[d].south, key)) continue;
      for (std::uint32_t other = 0; other < root_count_; ++other) {
        const Node& there = storage_.nodes[other];
        if (there.key == key)
          root.around[d] = there.in_view ? static_cast<std::int32_t>(other) : Node::kOutOfView;
      }
    }
  }
  return true;
}

// Its ball, of a curved basis, as look_at() does with boxes.
void GroundView::look_at_ball(const Looks& looks, Node& node) {
  const NodeMeasure& measure = node.tile->nodes[node_in_tile(node.key)];
  const NodeBall ball = node_ball(looks.info, measure, node.key);
  const glm::dvec3 centre = ball.centre - looks.corner;
  node.in_view = true;
  if (looks.request.culls) {
    double reach = ball.radius;
    // Walls are not in it.
    if (node.walls != 0) reach += (static_cast<double>(measure.low) - looks.info.low) * kVertexStep;
    const glm::dvec3 farthest = glm::abs(centre) + reach;
    const double margin = (farthest.x + farthest.y + farthest.z) * kPlaneRounding;
    for (const Plane& plane : looks.frustum.planes) {
      const glm::dvec3 normal(plane.normal);
      if (double{plane.offset} + margin + glm::dot(normal, centre) + reach * glm::length(normal) < 0)
        node.in_view = false;
    }
    if (node.in_view && looks.horizon.hides(measure, ball)) node.in_view = false;
  }
  node.least_apparent = least_apparent(looks, centre, ball.radius, nullptr);
  set_threshold(looks, node);
}

// As least_apparent_distance(), in double but for what the GPU computes in float. centre: from the camera's
// voxel. half: of a box, or a ball's radius. At distance r, ahead z and with u = z / r, rho is the greater of
// two functions, each of which is bounded from the centre. least_cos2 r is convex: it is not below its
// tangent. z^2 / r has the gradient 2 u forward - u^2 way and curves down by 1 / r at most: eigenvalues of r
// times its second derivatives are 0, 2 - 3 u^2 and -u^2. So within a radius R it is below its tangent by R^2
// / (2 (r - R)) at most, as long as all is in front of the eye.
float GroundView::least_apparent(const Looks& looks, const glm::dvec3& centre, double radius,
                                 const glm::dvec3* half) {
  const float least_cos2 = looks.request.scale.least_cos2;
  if (least_cos2 < 0.0f) return -least_cos2;
  const glm::dvec3 d = centre - looks.fine;
  const double r = glm::length(d);
  const glm::dvec3 forward(looks.forward);
  const double ahead = std::max(0.0, glm::dot(d, forward));
  double seen = std::max(ahead * ahead, double{least_cos2} * r * r) / std::max(r, 1.0) - kSteepest * radius;
  if (r > 2 * radius) {
    const glm::dvec3 way = d / r;
    const auto falls_by = [&](const glm::dvec3& gradient) {
      return half != nullptr ? glm::dot(glm::abs(gradient), *half) : glm::length(gradient) * radius;
    };
    seen = std::max(seen, double{least_cos2} * (r - falls_by(way)));
    if (ahead > radius) {
      const double u = ahead / r;
      seen = std::max(
          seen, u * ahead - falls_by(u * (2.0 * forward - u * way)) - 0.5 * radius * radius / (r - radius));
    }
  }
  return static_cast<float>(seen - r * 0x1p-17 - 2.0);
}

// Of regions that touch its parent, those that touch a node.
std::uint16_t GroundView::touched(const Looks& looks, std::uint32_t of_parent, NodeKey key) {
  std::uint32_t touches = 0;
  for (std::uint32_t rest = of_parent; rest != 0; rest &= rest - 1) {
    const GroundRegion& region = looks.info.regions()[static_cast<std::size_t>(std::countr_zero(rest))];
    if (in_region(region, key) != InRegion::none || borders(region, key)) touches |= rest & ~(rest - 1);
  }
  return static_cast<std::uint16_t>(touches);
}

// Whether its box is in view, and how near it is. node.planes: in, those that its parent's box crosses.
void GroundView::look_at(const Looks& looks, const NodeBox& box, Node& node) {
  glm::dvec3 low = box.low - looks.corner;
  glm::dvec3 high = box.high - looks.corner;
  node.in_view = true;
  const double lowest = low.y, highest = high.y;
  if (node.planes != 0) {
    // Nor are belts.
    for (std::uint32_t rest = node.touches; rest != 0; rest &= rest - 1) {
      const GroundRegion& region = looks.info.regions()[static_cast<std::size_t>(std::countr_zero(rest))];
      if (!borders(region, node.key)) continue;
      low.y = std::min(low.y, static_cast<double>(region.belt_low) - looks.corner.y);
      high.y = std::max(high.y, static_cast<double>(region.belt_high) - looks.corner.y);
    }
    // Walls are not in its box.
    if ((node.walls & looks.walls) != 0) {
      low.y = std::min(low.y, double(std::int64_t{looks.info.low} * kVertexStep) - looks.corner.y);
    }
    const glm::dvec3 farthest = glm::max(glm::abs(low), glm::abs(high));
    const double margin = (farthest.x + farthest.y + farthest.z) * kPlaneRounding;
    unsigned crossed = 0;
    for (unsigned n = 0; n < Frustum::kPlanes; ++n) {
      if ((unsigned{node.planes} >> n & 1u) == 0) continue;
      const Plane& plane = looks.frustum.planes[n];
      double inmost = double{plane.offset} + margin;
      double outmost = double{plane.offset};
      for (int axis = 0; axis < 3; ++axis) {
        const double a = plane.normal[axis] * low[axis];
        const double b = plane.normal[axis] * high[axis];
        inmost += std::max(a, b);
        outmost += std::min(a, b);
      }
      if (inmost < 0) {
        node.in_view = false;
        return;
      }
      if (outmost < 0) crossed |= 1u << n;
    }
    node.planes = static_cast<std::uint8_t>(crossed);
  }
  low.y = lowest;
  high.y = highest;
  const glm::dvec3 half = 0.5 * (high - low);
  node.least_apparent = least_apparent(looks, low + half, glm::length(half), &half);
  set_threshold(looks, node);
}

void GroundView::set_threshold(const Looks& looks, Node& node) {
  if (node.key.size == 0) return;
  const double threshold = looks.thresholds.of(node.tile->nodes[node_in_tile(node.key)], node.key.size);
  node.half = threshold_half(static_cast<float>(threshold));
  node.threshold = threshold_steps(node.half);
}

// Whether a node is to be split: then it has a family. Its children are not there yet.
void GroundView::decide(Looks& looks, FamilyPool& pool, Node& node) {
  if (!node.in_view) {
    ++result_.culled;
    return;
  }
  if (node.key.size == 0) return;
  const bool is_near = node.least_apparent < node.threshold;
  if (!is_near && looks.thresholds.steps_away == 0) return;
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
  node.below = looks.find_below(below);
  const bool has_tile = node.below != nullptr;
  if (!has_tile) {
    // Which of its tile's four children that is.
    const int quadrant = (below.x & 1) | (below.z & 1) << 1;
    float urgency = px;
    if (looks.forecast != nullptr) {
      const NodeMeasure& measure = node.tile->nodes[node_in_tile(node.key)];
      urgency = looks.forecast->need(measure, node.key, looks.forecast->ball(measure, node.key));
    }
    if (urgency > 0) {
      looks.tiles.want(below, node.tile->children[quadrant], urgency);
    } else {
      ++result_.left_out;
      result_.left_out_below = std::max(result_.left_out_below, node.key.size);
    }
    ++result_.lacks_tile;
  }
  const bool enclosed = std::none_of(std::begin(node.around), std::end(node.around),
                                     [](std::int32_t n) { return n == Node::kNotThere; });
  if (has_tile && enclosed) {
    if (result_.split < looks.request.most_splits) node.family = pool.see(node.key);
    if (node.family != FamilyPool::kNone) {
      ++result_.split;
      return;
    }
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
  const bool curved = looks.info.basis.is_curved();
  const bool ends = node.walls != 0 || has_end(looks.info, node.key);
  std::array<NodeBox, 4> boxes;
  if (!curved) {
    child_boxes(looks.info, *node.below, node.key, boxes);
    // Where the four meet, without what boxes have around them.
    const glm::dvec3 middle = 0.5 * (boxes[0].high + boxes[3].low);
    const glm::dvec3 eye = looks.corner + looks.fine;
    node.nearest = static_cast<std::uint8_t>((eye.x >= middle.x ? 1 : 0) | (eye.z >= middle.z ? 2 : 0));
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    Node& child = storage_.nodes[static_cast<std::size_t>(node.first_child + quadrant)];
    child = {};
    child.key = node.key.child(quadrant);
    child.tile = node.below;
    child.parent_family = node.family;
    // Within a node that ends at no wall all is there, and ends at none.
    if (ends) {
      if (!node_exists(looks.info, child.key)) continue;
      child.walls = static_cast<std::uint8_t>(node_walls(looks.info, child.key));
    }
    child.planes = node.planes;
    if (node.touches != 0) child.touches = touched(looks, node.touches, child.key);
    if (!curved) {
      look_at(looks, boxes[static_cast<std::size_t>(quadrant)], child);
      continue;
    }
    look_at_ball(looks, child);
    const auto apparent = [&](int n) {
      return storage_.nodes[static_cast<std::size_t>(node.first_child + n)].least_apparent;
    };
    if (quadrant == 0 || apparent(quadrant) < apparent(node.nearest))
      node.nearest = static_cast<std::uint8_t>(quadrant);
  }
}

void GroundView::link_children(const Looks& looks, std::int32_t parent) {
  const Node& node = storage_.nodes[static_cast<std::size_t>(parent)];
  // By direction: the first child of the one around it, or what its children would read.
  std::array<std::int32_t, kOwn + 1> first;
  std::array<bool, kOwn + 1> ends;  // some of the children may not exist
  first[kOwn] = node.first_child;
  // Of a ground that closes: nodes at its ends, whose children's neighbours lie beyond.
  const bool closes = looks.info.closes();
  const std::int32_t last = closes ? last_column(looks.info, node.key.size) : 0;
  const bool at_seam = closes && (node.key.x == 0 || node.key.x == last);
  ends[kOwn] = node.walls != 0 || at_seam;
  for (std::size_t d = 0; d < kOwn; ++d) {
    first[d] = node.around[d];
    ends[d] = false;
    if (first[d] < 0) continue;
    const Node& other = storage_.nodes[static_cast<std::size_t>(first[d])];
    first[d] = !other.in_view ? Node::kOutOfView : other.is_split() ? other.first_child : Node::kNotThere;
    ends[d] = other.walls != 0 || (closes && other.key.x == last);
  }
  for (std::size_t quadrant = 0; quadrant < 4; ++quadrant) {
    Node& child = storage_.nodes[static_cast<std::size_t>(node.first_child) + quadrant];
    for (std::size_t d = 0; d < 8; ++d) {
      if (at_seam) {
        child.around[d] = around_at_seam(looks, node, child.key, d, first);
        continue;
      }
      const Link link = kLinks[quadrant][d];
      std::int32_t at = first[link.from];
      if (at >= 0) {
        NodeKey over_edge;
        if (looks.info.is_cube() && link.from != kOwn) {
          // Faces may be turned.
          const bool exists =
              neighbour_of(looks.info, child.key, kAround[d].east, kAround[d].south, over_edge);
          at = exists ? at + over_edge.quadrant() : Node::kOutside;
        } else {
          at += link.quadrant;
        }
        if (at >= 0 && ends[link.from] &&
            !node_exists(looks.info, storage_.nodes[static_cast<std::size_t>(at)].key))
          at = Node::kOutside;
      }
      child.around[d] = at;
    }
  }
}

// Of a child of a node at the ends of a ground that closes: what is around it. first: as link_children() has
// it.
std::int32_t GroundView::around_at_seam(const Looks& looks, const Node& node, NodeKey child, std::size_t d,
                                        std::span<const std::int32_t> first) {
  NodeKey there, parent;
  if (!node_exists(looks.info, child) ||
      !neighbour_of(looks.info, child, kAround[d].east, kAround[d].south, there))
    return Node::kOutside;
  std::size_t from = kOwn;
  // The nearest of several: the root is its own neighbour.
  if (!(there.parent() == node.key)) {
    for (from = 0; from < kOwn; ++from) {
      if (neighbour_of(looks.info, node.key, kAround[from].east, kAround[from].south, parent) &&
          parent == there.parent())
        break;
    }
    KARST_ASSERT(from < kOwn);
  }
  return first[from] < 0 ? first[from] : first[from] + there.quadrant();
}

// Of a split node, for its family.
void GroundView::make_row(const Looks& looks, const Node& node) {
  std::array<std::uint16_t, kMorphRow> row{};
  if (looks.request.morphing) {
    // By direction: at most this, for what is around.
    std::array<std::uint16_t, 8> most;
    for (std::size_t d = 0; d < 8; ++d) {
      most[d] = node.half;
      if (node.around[d] < 0) continue;
      const Node& other = storage_.nodes[static_cast<std::size_t>(node.around[d])];
      if (other.in_view) most[d] = other.refused ? std::uint16_t{0} : std::min(node.half, other.half);
    }
    row[kFamilyInside] = node.half;
    for (std::size_t n = 0; n < 4; ++n) {
      row[static_cast<std::size_t>(family_edge(static_cast<int>(n)))] = most[n];
      // The edges that meet there.
      row[static_cast<std::size_t>(family_corner(static_cast<int>(n)))] =
          std::min({most[n], most[(n + 3) % 4], most[4 + n]});
    }
    if (has_seam_inside(looks.info, node.key)) {
      // What lies on its line in the middle is shared with those to the east: 2, 6 to the south, 7 to the
      // north.
      row[kFamilyInside] = most[2];
      row[static_cast<std::size_t>(family_edge(1))] = std::min({most[1], most[2], most[6]});
      row[static_cast<std::size_t>(family_edge(3))] = std::min({most[3], most[2], most[7]});
    }
  } else {
    std::fill(row.begin(), row.end(), kNeverMorphs);
  }
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
  std::uint64_t hash = 0xcbf29ce484222325u + result_.regions;
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

// Those of which no node that has them in part is drawn.
std::uint32_t GroundView::left_regions(const Looks& looks) const {
  std::uint32_t left = looks.regions;
  for (const Node& node : nodes()) {
    if ((node.touches & left) == 0 || !node.in_view || node.is_split()) continue;
    for (std::uint32_t rest = node.touches & left; rest != 0; rest &= rest - 1) {
      const std::uint32_t bit = rest & ~(rest - 1);
      const GroundRegion& region = looks.info.regions()[static_cast<std::size_t>(std::countr_zero(rest))];
      if (in_region(region, node.key) == InRegion::part) left &= ~bit;
    }
  }
  return left;
}

// Of a region that the ground stands for. Where a node that has it in part is not to be split, (3) holds for
// all of it. Else it is closed for want of data, and however near: what a node there is off by and the
// region's own error, which such nodes' errors are not below.
void GroundView::add_bound_of_closed(const Looks& looks, std::uint32_t bit) {
  const GroundRegion& region = looks.info.regions()[static_cast<std::size_t>(std::countr_zero(bit))];
  const auto error_of = [&](const Node& node) {
    return node.key.size == 0
               ? 0.0f
               : most_error(looks.info, node.tile->nodes[node_in_tile(node.key)], node.key.size);
  };
  float error = kInfinite;
  for (const Node& node : nodes()) {
    if ((node.touches & bit) == 0 || !node.in_view || in_region(region, node.key) != InRegion::part) continue;
    if (!node.is_split() && !node.refused) return;
    error = std::min(error, error_of(node));
  }
  for (const Node& node : nodes()) {
    if ((node.touches & bit) == 0 || !node.in_view || node.is_split()) continue;
    if (in_region(region, node.key) == InRegion::none) continue;
    const float off = error + error_of(node), left = node.least_apparent - off;
    const float px = left > 0.0f ? looks.request.scale.pixels * off / left : kInfinite;
    result_.bound_px = std::max(result_.bound_px, px);
  }
}

// Whether a region that is drawn has all of a node.
bool GroundView::is_left_out(const Looks& looks, const Node& node) const {
  for (std::uint32_t rest = node.touches & result_.regions; rest != 0; rest &= rest - 1) {
    const GroundRegion& region = looks.info.regions()[static_cast<std::size_t>(std::countr_zero(rest))];
    if (in_region(region, node.key) == InRegion::all) return true;
  }
  return false;
}

// From the root on, of four children the one that the eye stands over first.
void GroundView::list(const Looks& looks) {
  result_.least_size = looks.top;
  std::array<std::int32_t, 4 * (kMostSize + 2) + kCubeFaces> stack;
  std::size_t depth = 0;
  for (std::uint32_t n = root_count_; n > 0; --n) stack[depth++] = static_cast<std::int32_t>(n - 1);
  while (depth > 0) {
    const std::int32_t at = stack[--depth];
    const Node& node = storage_.nodes[static_cast<std::size_t>(at)];
    if (!node.in_view) continue;
    if (is_left_out(looks, node)) continue;
    if (!node.is_split()) {
      DrawItem item{};
      item.patch = 4 * node.parent_family + static_cast<std::uint32_t>(node.key.quadrant());
      item.level = kNodeLevel;
      for (int edge = 0; edge < 4; ++edge) {
        if (node.around[edge] == Node::kNotThere) item.lower_edges |= static_cast<std::uint8_t>(1 << edge);
      }
      // Where a function says, what is below is not known.
      const unsigned walls = looks.info.basis.kind == BasisKind::function ? 0u : node.walls & looks.walls;
      item.walls = static_cast<std::uint8_t>(walls);
      storage_.item_nodes[result_.drawn] = at;
      storage_.items[result_.drawn++] = item;
      result_.triangles +=
          (patch_index_count(item.level, item.lower_edges, 0) + wall_index_count(item.walls)) / 3;
      result_.least_size = std::min(result_.least_size, node.key.size);
      result_.greatest_size = std::max(result_.greatest_size, node.key.size);
      continue;
    }
    for (const int away : {3, 2, 1, 0}) stack[depth++] = node.first_child + (node.nearest ^ away);
  }
}

}  // namespace karst::core
