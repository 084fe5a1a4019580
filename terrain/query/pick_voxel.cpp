// SPDX-License-Identifier: MIT
// The octree from the root down, cubes that the segment enters earlier first, until no other can be nearer.
#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "terrain/query/query.h"

namespace karst::core {
namespace {

struct Interval {
  double first, last;
  int axis;  // of the side through which the segment comes in; -1 where it starts inside
};

class Pick {
 public:
  Pick(const Octree& octree, glm::dvec3 from, glm::dvec3 to, int level)
      : octree_(octree), from_(from), way_(to - from), level_(level) {}

  bool run(PickedVoxel& picked) {
    const Interval all = interval(glm::ivec3(0), octree_.size());
    if (!(all.first <= all.last)) return false;
    visit(octree_.root(), glm::ivec3(0), 0, all);
    if (!found_) return false;
    picked = best_;
    picked.distance = best_t_ * glm::length(way_);
    return true;
  }

 private:
  // Where the segment is in a cube; empty (first > last) where it is not. Planes that cubes share are met at
  // the same bits.
  Interval interval(glm::ivec3 origin, std::int32_t size) const {
    Interval in{0.0, 1.0, -1};
    for (int axis = 0; axis < 3; ++axis) {
      const double low = origin[axis];
      const double high = origin[axis] + size;
      if (way_[axis] == 0.0) {
        if (from_[axis] < low || from_[axis] > high) return {1.0, 0.0, -1};
        continue;
      }
      const bool forwards = way_[axis] > 0.0;
      const double enter = ((forwards ? low : high) - from_[axis]) / way_[axis];
      const double leave = ((forwards ? high : low) - from_[axis]) / way_[axis];
      if (enter > in.first) {
        in.first = enter;
        in.axis = axis;
      }
      in.last = std::min(in.last, leave);
    }
    return in;
  }

  void visit(Octree::Node node, glm::ivec3 origin, int depth, const Interval& in) {
    if (in.first > best_t_ || node == Octree::kEmpty) return;
    if (depth == level_ || Octree::is_leaf(node)) {
      offer(node, origin, depth, in);
      return;
    }
    struct Child {
      int octant;
      glm::ivec3 origin;
      Interval in;
    };
    Child children[8];
    int count = 0;
    const std::int32_t half = octree_.size() >> (depth + 1);
    for (int octant = 0; octant < 8; ++octant) {
      const glm::ivec3 at = origin + half * glm::ivec3(octant & 1, octant >> 1 & 1, octant >> 2);
      const Interval child = interval(at, half);
      if (!(child.first <= child.last)) continue;
      int to = count++;
      for (; to > 0 && children[to - 1].in.first > child.first; --to) children[to] = children[to - 1];
      children[to] = {octant, at, child};
    }
    for (int c = 0; c < count; ++c) {
      visit(octree_.child(node, children[c].octant), children[c].origin, depth + 1, children[c].in);
    }
  }

  // A voxel of the level, or a filled leaf above it: then the voxel in it that the segment enters.
  void offer(Octree::Node node, glm::ivec3 origin, int depth, const Interval& in) {
    if (found_ && in.first >= best_t_) return;
    const std::int32_t whole = octree_.size() >> depth;
    const std::int32_t size = octree_.size() >> level_;
    glm::ivec3 at(0);
    for (int axis = 0; axis < 3; ++axis) {
      const double place = std::floor(from_[axis] + in.first * way_[axis]);
      at[axis] = std::clamp(static_cast<std::int32_t>(std::clamp(place, 0.0, octree_.size() - 1.0)),
                            origin[axis], origin[axis] + whole - 1);
      if (axis == in.axis) at[axis] = way_[axis] > 0.0 ? origin[axis] : origin[axis] + whole - 1;
      at[axis] = at[axis] / size * size;
    }
    found_ = true;
    best_t_ = in.first;
    best_.voxel = VoxelIndex::of(level_, at, octree_.depth(), Octree::is_filled(node));
    best_.has_before = false;
    if (in.axis < 0) return;
    glm::ivec3 back(0);
    back[in.axis] = way_[in.axis] > 0.0 ? -1 : 1;
    best_.has_before = best_.voxel.neighbour(back, best_.before);
  }

  const Octree& octree_;
  glm::dvec3 from_;
  glm::dvec3 way_;
  int level_;
  bool found_ = false;
  double best_t_ = 1.0;
  PickedVoxel best_;
};

}  // namespace

bool pick_voxel(const Octree& octree, glm::dvec3 from, glm::dvec3 to, int level, PickedVoxel& picked) {
  picked = {};
  if (level < 0 || level > octree.depth() || from == to) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(from[axis]) <= Query::kReach && std::abs(to[axis]) <= Query::kReach)) return false;
  }
  return Pick(octree, from, to, level).run(picked);
}

}  // namespace karst::core
