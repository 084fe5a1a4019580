// SPDX-License-Identifier: MIT
// Levels of detail by distance: k = 1 - log2(d / d_max) (K equation 4.13), rounded up, so that a patch is at
// level 1 exactly from d_max on, as K's figure 4.19 draws it.
//
// Departure from K 4.4.2: K measures to the centre of the patch's box. Here d is the distance to the box's
// nearest point (design 4.7), because only then every vertex of the patch is at least that far, whatever the
// patch's size and displacement; a level's threshold then holds for its vertices, which a morph relies on.
//
// The rule of one level between neighbours (K 4.4.3) is met by raising the coarser patch, never by lowering
// the finer one: the error that a distance asks for is kept. The finest patches raise their neighbours first;
// what they raise ends up coarser than themselves and raises its own neighbours later, so each patch is
// looked at once. The result is the least one that is nowhere below the distance's choice, whatever the order
// in a level.
#include "terrain/view/select_lod.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace karst {
namespace {

struct Thresholds {
  int top = 1;          // finest level
  glm::vec3 eye{0.0f};  // lattice steps
  float squared[kMaxLevel + 1] =
      {};  // [m]: squared distance, in steps, below which a patch is at level m or finer

  int level(float squared_distance) const {
    int result = 1;
    for (int m = 2; m <= top; ++m) result += squared_distance < squared[m] ? 1 : 0;
    return result;
  }
};

// Squared distances from a point to a box. All steps are monotonic in float, so a box inside another one is
// never found nearer than the outer box's nearest nor farther than its farthest point: a run of patches whose
// box lies in one level's ring needs no look at each of them, and gets the same levels.
float nearest_squared(const LatticeBox& box, glm::vec3 eye) {
  const glm::vec3 d = glm::max(glm::max(glm::vec3(box.min) - eye, eye - glm::vec3(box.max)), glm::vec3(0.0f));
  return d.x * d.x + d.y * d.y + d.z * d.z;
}

float farthest_squared(const LatticeBox& box, glm::vec3 eye) {
  const glm::vec3 d = glm::max(glm::abs(glm::vec3(box.min) - eye), glm::abs(eye - glm::vec3(box.max)));
  return d.x * d.x + d.y * d.y + d.z * d.z;
}

void choose(const SelectLod& stage, const Thresholds& thresholds, int row, std::uint32_t n) {
  const BoundsTree& tree = *stage.tree;
  const LatticeBox& box = tree.node(row, n);
  const PatchId first = tree.first_patch(row, n);
  const std::uint32_t count = tree.patch_count(row, n);
  const int finest = thresholds.level(nearest_squared(box, thresholds.eye));
  const int coarsest = thresholds.level(farthest_squared(box, thresholds.eye));
  if (finest == coarsest) {
    std::memset(stage.levels.data() + first, finest, count);
  } else if (row == 0) {
    for (PatchId id = first; id < first + count; ++id) {
      const LatticeBox patch = patch_box(stage.surface, stage.bounds, id);
      stage.levels[id] = static_cast<std::uint8_t>(thresholds.level(nearest_squared(patch, thresholds.eye)));
    }
  } else {
    const std::uint32_t end = std::min((n + 1) * BoundsTree::kFanOut, tree.nodes(row - 1));
    for (std::uint32_t child = n * BoundsTree::kFanOut; child < end; ++child) {
      choose(stage, thresholds, row - 1, child);
    }
  }
}

// Whether one of eight bytes equals value, by finding a zero byte in the difference.
bool has_byte(std::uint64_t eight, int value) {
  constexpr std::uint64_t kOnes = 0x0101010101010101u;
  constexpr std::uint64_t kTops = 0x8080808080808080u;
  const std::uint64_t difference = eight ^ (kOnes * static_cast<std::uint64_t>(value));
  return ((difference - kOnes) & ~difference & kTops) != 0;
}

std::uint32_t raise_neighbours(const Surface& surface, std::span<std::uint8_t> levels, PatchId id) {
  std::uint32_t raised = 0;
  const auto wanted = static_cast<std::uint8_t>(levels[id] - 1);
  for (const PatchEdge edge : surface.patches[id].neighbour) {
    if (!edge.exists() || levels[edge.patch()] >= wanted) continue;
    levels[edge.patch()] = wanted;
    ++raised;
  }
  return raised;
}

// One pass a level, from the finest down to 3: below that nothing can be two levels coarser. Most patches are
// far away and coarse, so a pass looks at eight bytes at a time and skips them.
std::uint32_t raise_coarser(const Surface& surface, std::span<std::uint8_t> levels, int top) {
  std::uint32_t raised = 0;
  const std::size_t in_eights = levels.size() / 8 * 8;
  for (int level = top; level > 2; --level) {
    for (std::size_t first = 0; first < in_eights; first += 8) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, levels.data() + first, 8);
      if (!has_byte(eight, level)) continue;
      for (std::size_t id = first; id < first + 8; ++id) {
        if (levels[id] == level) raised += raise_neighbours(surface, levels, static_cast<PatchId>(id));
      }
    }
    for (std::size_t id = in_eights; id < levels.size(); ++id) {
      if (levels[id] == level) raised += raise_neighbours(surface, levels, static_cast<PatchId>(id));
    }
  }
  return raised;
}

}  // namespace

Status SelectLod::validate() const {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  const LodSettings& s = settings;
  if (s.mode != LodMode::distance && s.mode != LodMode::full) return refuse("not a mode", "mode");
  if (s.max_level < 1 || s.max_level > kMaxLevel) return refuse("not a level of detail", "max_level");
  if (s.resident_level < 1 || s.resident_level > kMaxLevel) {
    return refuse("not a level of detail", "resident_level");
  }
  if (!(s.distance_voxels >= 0.0 && s.distance_voxels <= kCameraReach)) {
    return refuse("not within 0..2^20 voxels", "distance_voxels");
  }
  if (camera == nullptr) return refuse("missing", "camera");
  if (bounds.size() != surface.patches.size()) return refuse("must hold one box a patch", "bounds");
  if (tree == nullptr) return refuse("missing", "tree");
  if (tree->patches() != surface.patches.size()) return refuse("not built over the surface", "tree");
  if (levels.size() != surface.patches.size()) return refuse("must hold one byte a patch", "levels");
  return {};
}

SelectLod::Result SelectLod::run() const {
  if (levels.empty()) return {};
  Thresholds thresholds;
  thresholds.top = std::min(settings.max_level, settings.resident_level);
  if (settings.mode == LodMode::full) {
    std::memset(levels.data(), thresholds.top, levels.size());
    return {};
  }
  thresholds.eye = glm::vec3(eye_lattice(*camera));
  for (int m = 2; m <= thresholds.top; ++m) {
    const double distance = std::ldexp(settings.distance_voxels * kStepsPerVoxel, 2 - m);
    thresholds.squared[m] = static_cast<float>(distance * distance);
  }
  choose(*this, thresholds, tree->rows() - 1, 0);
  return {raise_coarser(surface, levels, thresholds.top)};
}

}  // namespace karst
