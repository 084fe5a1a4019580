// SPDX-License-Identifier: MIT
// The rays from the eye to a box cross a layer of cells in a rectangle; the layers between the two are tried
// one after the other, along each axis, those alone whose cell on the way to the box's middle is rock. Where
// the eye does not count as outside, a layer of air has to come first.
#include "terrain/cull/occlusion.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "terrain/view/projection.h"

namespace karst::core {
namespace {

// Searches that a frame may always make, and those more for each that found rock in the frame before.
constexpr std::uint32_t kLeastSearches = 8;
constexpr std::uint32_t kSearchesPerFind = 8;

// After so many frames with nothing hidden, all but one frame in kQuietPeriod leave it at that.
constexpr std::uint32_t kQuietFrames = 64;
constexpr std::uint32_t kQuietPeriod = 16;

// Layers that are looked at for air, from the eye on.
constexpr int kAirLayers = 6;

// The other two axes, in the order of Occluders::covers.
constexpr int kRowAxis[3] = {1, 2, 1};
constexpr int kColumnAxis[3] = {2, 0, 0};

// Without special flags compilers call a library function for std::floor. Precondition: |v| < 2^31.
int floor_of(float v) {
  const int whole = static_cast<int>(v);
  return static_cast<float>(whole) > v ? whole - 1 : whole;
}
int ceil_of(float v) {
  return -floor_of(-v);
}

// All rays from the eye to a box, seen along one axis. In cells.
class Shaft {
 public:
  Shaft(glm::vec3 eye, glm::vec3 low, glm::vec3 high) : eye_(eye), low_(low), high_(high) {}

  // False where no layer across the axis lies wholly between the two.
  bool aim(int axis) {
    axis_ = axis;
    const float e = eye_[axis];
    float near_side = 0;
    float far_side = 0;
    if (e < low_[axis]) {
      near_side = low_[axis] - e;
      far_side = high_[axis] - e;
      step_ = 1;
      first_ = ceil_of(e);
      end_ = floor_of(low_[axis]);
    } else if (e > high_[axis]) {
      near_side = e - high_[axis];
      far_side = e - low_[axis];
      step_ = -1;
      first_ = floor_of(e) - 1;
      end_ = ceil_of(high_[axis]) - 1;
    } else {
      return false;
    }
    if ((end_ - first_) * step_ <= 0) return false;
    // A side's ray is the steepest that leads to any point of the box.
    const auto low_slope = [&](int other) {
      const float aside = low_[other] - eye_[other];
      return aside / (aside < 0.0f ? near_side : far_side);
    };
    const auto high_slope = [&](int other) {
      const float aside = high_[other] - eye_[other];
      return aside / (aside > 0.0f ? near_side : far_side);
    };
    from_ = {eye_[kRowAxis[axis]], eye_[kColumnAxis[axis]]};
    low_slope_ = {low_slope(kRowAxis[axis]), low_slope(kColumnAxis[axis])};
    high_slope_ = {high_slope(kRowAxis[axis]), high_slope(kColumnAxis[axis])};
    middle_slope_ = 0.5f * (low_slope_ + high_slope_);
    return true;
  }

  int first() const { return first_; }
  int end() const { return end_; }
  int step() const { return step_; }
  bool is_before(int layer, int other) const { return (other - layer) * step_ > 0; }
  bool is_between(int layer) const { return (layer - first_) * step_ >= 0 && (end_ - layer) * step_ > 0; }

  // Whether the cell on the way to about the box's middle is rock.
  bool may_be_covered(const Occluders& occluders, int layer) const {
    const glm::vec2 at = from_ + middle_slope_ * (near_of(layer) + 0.5f);
    glm::ivec3 cell;
    cell[axis_] = layer;
    cell[kRowAxis[axis_]] = floor_of(at.x);
    cell[kColumnAxis[axis_]] = floor_of(at.y);
    return occluders.is_rock(cell);
  }
  bool is_covered(const Occluders& occluders, Occluders::Kind kind, int layer) const {
    const float near_side = near_of(layer);
    const float far_side = near_side + 1.0f;
    glm::ivec2 low;
    glm::ivec2 high;
    for (int k = 0; k < 2; ++k) {
      const float least = from_[k] + low_slope_[k] * (low_slope_[k] < 0.0f ? far_side : near_side);
      const float most = from_[k] + high_slope_[k] * (high_slope_[k] > 0.0f ? far_side : near_side);
      low[k] = floor_of(least);
      high[k] = floor_of(most);
    }
    return occluders.covers(kind, axis_, layer, low, high);
  }
  // The layer next to the eye, at least `near` from it, where all rays are in air; end() where none is found
  // soon.
  int find_air(const Occluders& occluders, float near) const {
    int layer = first_;
    for (int tries = 0; tries < kAirLayers && layer != end_; layer += step_) {
      if (near_of(layer) < near) continue;
      if (is_covered(occluders, Occluders::Kind::air, layer)) return layer;
      ++tries;
    }
    return end_;
  }

 private:
  // How far the layer's nearer side is from the eye.
  float near_of(int layer) const {
    const auto at = static_cast<float>(layer);
    return step_ > 0 ? at - eye_[axis_] : eye_[axis_] - at - 1.0f;
  }

  glm::vec3 eye_, low_, high_;
  int axis_ = 0;
  int step_ = 1;
  int first_ = 0;  // layer next to the eye
  int end_ = 0;    // the one after the last
  glm::vec2 from_{0.0f};
  glm::vec2 low_slope_{0.0f};
  glm::vec2 high_slope_{0.0f};
  glm::vec2 middle_slope_{0.0f};
};

}  // namespace

void Occlusion::reset() {
  std::fill(entries_.begin(), entries_.end(), std::uint16_t{0});
  active_ = false;
  fresh_ = true;
  searched_ = found_ = hidden_ = quiet_ = 0;
  turn_ = next_turn_ = 0;
}

void Occlusion::begin(const Occluders& occluders, const Octree& octree, const BoundsTree& tree,
                      const Surface& surface, std::span<const PatchBounds> bounds, const Camera& camera,
                      std::uint32_t searches) {
  active_ = false;
  ++frame_;
  if (occluders.empty() || camera.parallel || (quiet_ >= kQuietFrames && frame_ % kQuietPeriod != 0)) return;
  const glm::dvec3 eye = eye_lattice(camera);
  const double near_steps = near_reach(camera) * kStepsPerVoxel;
  if (!std::isfinite(near_steps)) return;
  outside_ = occluders.is_outside(octree, tree, surface, bounds, eye, near_steps + 1.0);
  active_ = true;
  occluders_ = &occluders;
  const float cell = 1.0f / occluders.cell_steps();
  near_ = static_cast<float>(near_steps + 2.0) * cell;
  eye_ = glm::vec3(eye) * cell;
  reach_ = static_cast<float>(reach_of_depth(depth_near(camera))) * cell;
  quiet_ = hidden_ > 0 || fresh_ ? 0 : quiet_ + 1;
  allowed_ = fresh_ ? searches : std::min(searches, kLeastSearches + kSearchesPerFind * found_);
  fresh_ = false;
  turn_ = next_turn_;
  next_turn_ = 0;
  searched_ = 0;
  found_ = 0;
  hidden_ = 0;
}

std::uint8_t Occlusion::hides_patches(const PatchBoxes& boxes, std::uint32_t n, std::uint8_t mask) {
  const PatchId first = n * PatchBoxes::kPatches;
  const std::uint32_t count = std::min(PatchBoxes::kPatches, first_node_ - first);
  if (searched_ >= allowed_) {
    std::uint16_t any = 0;
    for (std::uint32_t p = 0; p < count; ++p) any = static_cast<std::uint16_t>(any | entries_[first + p]);
    if ((any & kHidden) == 0) return 0;
  }
  std::uint8_t hidden = 0;
  for (std::uint32_t p = 0; p < count; ++p) {
    const PatchId id = first + p;
    const std::uint16_t state = entries_[id];
    if ((unsigned{mask} >> p & 1u) == 0 || ((state & kHidden) == 0 && !is_due(id, id, state))) continue;
    if (ask(id, id, state, boxes.box(p))) hidden |= static_cast<std::uint8_t>(1u << p);
  }
  return hidden;
}

bool Occlusion::ask(std::uint32_t entry, PatchId first, std::uint16_t state, const LatticeBox& box) {
  const float cell = 1.0f / occluders_->cell_steps();
  const glm::vec3 low = glm::vec3(box.min) * cell;
  const glm::vec3 high = glm::vec3(box.max) * cell;
  const glm::vec3 away = glm::max(glm::abs(low - eye_), glm::abs(high - eye_));
  const float distance = away.x + away.y + away.z;  // not below the true one of any point
  if (distance > reach_) return false;
  const float wider = distance * 0x1p-12f + 8.0f * cell;
  Shaft shaft(eye_, low - wider, high + wider);
  if ((state & kHidden) != 0) {
    const int layer = state & kLayerMask;
    if (shaft.aim(state >> kAxisShift & 3) && shaft.is_between(layer) &&
        shaft.is_covered(*occluders_, Occluders::Kind::rock, layer) &&
        (outside_ || shaft.is_before(shaft.find_air(*occluders_, near_), layer))) {
      ++hidden_;
      return true;
    }
    entries_[entry] = state = 0;
    if (searched_ >= allowed_) return false;
  }
  state = static_cast<std::uint16_t>(state & ~unsigned{kWoken});
  if (++searched_ == allowed_) next_turn_ = first + 1;
  for (int axis = 0; axis < 3; ++axis) {
    if (!shaft.aim(axis)) continue;
    const int from = outside_ ? shaft.first() : shaft.find_air(*occluders_, near_);
    for (int layer = from; layer != shaft.end(); layer += shaft.step()) {
      if (!shaft.may_be_covered(*occluders_, layer)) continue;
      if (!shaft.is_covered(*occluders_, Occluders::Kind::rock, layer)) continue;
      entries_[entry] = static_cast<std::uint16_t>(kHidden | axis << kAxisShift | layer);
      ++found_;
      ++hidden_;
      wake_siblings(entry);
      return true;
    }
  }
  entries_[entry] = std::min<std::uint16_t>(static_cast<std::uint16_t>(state + 1), kRarest);
  return false;
}

// What lies beside a hidden box is likely hidden too.
void Occlusion::wake_siblings(std::uint32_t entry) {
  const std::uint32_t base = entry < first_node_ ? 0 : first_node_;
  const std::uint32_t first = base + ((entry - base) & ~(BoundsTree::kFanOut - 1));
  const auto entries = static_cast<std::uint32_t>(entries_.size());
  for (std::uint32_t e = first; e < std::min(first + BoundsTree::kFanOut, entries); ++e) {
    if ((entries_[e] & kHidden) == 0) entries_[e] = kWoken;
  }
}

}  // namespace karst::core
