// SPDX-License-Identifier: MIT
// Levels of detail by error: a patch's level is a function of the camera and its own thresholds, which
// already hold what its neighbours need (morph.h); patches out of view are skipped by their boxes.
//
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
//
// Levels that are not held can't be drawn: there the rule is met by lowering, from the coarsest up, and again
// each patch is lowered once at most. Nothing cracks: a patch that is drawn coarser than wanted has all its
// vertices at home (morph.h (2) holds for all its lower levels and for its neighbours), and a finer neighbour
// leaves out the vertices between them, whatever their share. So the edge is off by what error(m - 1) covers
// of the finer one, a mixture of its level and the next lower, and the bound is raised to that.
//
// A patch out of view keeps the level it would have if it were held: a neighbour in view leaves out vertices
// of their edge by it, and the triangles along that edge may be seen.
#include "terrain/lod/select_lod.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

// Of a patch's box: vertices are within 4 voxels of the origin on each axis. sqrt(3) * 8 voxels, rounded up.
constexpr float kLongestDiagonal = 14.0f * kStepsPerVoxel;

// --- by distance

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

// Whether the patch across an edge of one at `level` is drawn one level lower. What is further apart is not
// in view (SelectLod::levels).
bool is_drawn_lower(PatchEdge edge, int level, std::span<const std::uint8_t> levels) {
  return level > 1 && edge.exists() && levels[edge.patch()] == level - 1;
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

// Calls visit(id) for the patches of a run that are at a level. Looks at eight bytes at a time.
template <class Visit>
void for_each_at_level(std::span<const std::uint8_t> levels, PatchId first, std::uint32_t count, int level,
                       const Visit& visit) {
  const PatchId end = first + count;
  const PatchId in_eights = first + count / 8 * 8;
  for (; first < in_eights; first += 8) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, levels.data() + first, 8);
    if (!has_byte(eight, level)) continue;
    for (PatchId id = first; id < first + 8; ++id) {
      if (levels[id] == level) visit(id);
    }
  }
  for (PatchId id = in_eights; id < end; ++id) {
    if (levels[id] == level) visit(id);
  }
}

// One pass a level, from the finest down to 3: below that nothing can be two levels coarser. Most patches are
// far away and coarse, so a pass skips most of them.
std::uint32_t raise_coarser(const Surface& surface, std::span<std::uint8_t> levels, int top) {
  std::uint32_t raised = 0;
  for (int level = top; level > 2; --level) {
    for_each_at_level(levels, 0, static_cast<std::uint32_t>(levels.size()), level,
                      [&](PatchId id) { raised += raise_neighbours(surface, levels, id); });
  }
  return raised;
}

// Calls visit(first, count) for runs of patches that hold all in view and their neighbours.
template <class Visit>
void visit_view(const BoundsTree& tree, const Frustum& frustum, int row, std::uint32_t n, PlaneMask mask,
                const Visit& visit) {
  mask = classify(frustum, tree.node(row, n), mask);
  if (mask == kOutside) return;
  if (mask == 0 || row == 0) {
    visit(tree.first_patch(row, n), tree.patch_count(row, n));
    return;
  }
  const std::uint32_t end = std::min((n + 1) * BoundsTree::kFanOut, tree.nodes(row - 1));
  for (std::uint32_t child = n * BoundsTree::kFanOut; child < end; ++child) {
    visit_view(tree, frustum, row - 1, child, mask, visit);
  }
}

template <class Visit>
void visit_patches(const SelectLod& stage, const Visit& visit) {
  if (stage.frustum == nullptr) {
    visit(PatchId{0}, static_cast<std::uint32_t>(stage.levels.size()));
    return;
  }
  // A neighbour's box touches that of the patch in view: moved outwards by the longest diagonal of a box, a
  // plane that does not cull the one does not cull the other.
  Frustum wide = *stage.frustum;
  for (Plane& plane : wide.planes) plane.offset += stage.tree->longest_diagonal();
  visit_view(*stage.tree, wide, stage.tree->rows() - 1, 0, kAllPlanes, visit);
}

// --- the bound

bool bound_is_known(const SelectLod& stage) {
  return stage.errors.known(stage.levels.size()) && stage.lods.size() == stage.levels.size();
}

// The most pixels by which a patch that nowhere strays by more than error(j) can be off, in front of the near
// plane: morph.h's formula, with the depth of the point on the full surface not below the near plane's.
struct PixelBound {
  const SelectLod& stage;
  LodEye view;
  float least_depth;  // lattice steps

  explicit PixelBound(const SelectLod& s)
      : stage(s),
        view(make_lod_eye(*s.camera, s.scale.least_cos2)),
        least_depth(s.camera->parallel ? kParallelDistance / 2
                                       : std::sqrt(s.scale.least_cos2) *
                                             static_cast<float>(s.camera->near_voxels * kStepsPerVoxel)) {}

  float operator()(PatchId id, int j, float least_apparent) const {
    if (j >= stage.errors.level) return 0.0f;
    const std::uint16_t error = stage.errors.error(id, j);
    const float steps = error == kUnboundedError ? kLongestDiagonal : static_cast<float>(error);
    return stage.scale.pixels * steps / std::max(least_apparent - steps, least_depth);
  }
  bool in_view(PatchId id) const {
    if (stage.frustum != nullptr &&
        classify(*stage.frustum, patch_box(stage.surface, stage.bounds, id), kAllPlanes) == kOutside) {
      return false;
    }
    if (!stage.cones.empty() && faces_away(id)) return false;
    return stage.occlusion == nullptr || !is_hidden(id);
  }

  // At the finest level, so that all that may be drawn is in view.
  bool faces_away(PatchId id) const {
    const glm::ivec3 origin = patch_origin(stage.surface.volume_of(id));
    const int level = stage.settings.top_level();
    const float pixels = stage.scale.least_pixels;
    if (view.least_cos2 < 0.0f) {
      return is_back_facing(stage.cones[id], view.forward, snap_sine(kParallelDistance, level, pixels));
    }
    return is_back_facing(stage.cones[id], stage.bounds[id], origin, view.eye, back_facing_slack(view.eye),
                          snap_sine(glm::length(glm::vec3(origin) - view.eye), level, pixels));
  }

  bool is_hidden(PatchId id) const {
    Occlusion& occlusion = *stage.occlusion;
    for (int row = Occlusion::kRows - 1; row >= 0; --row) {
      if (row >= stage.tree->rows()) continue;
      if (occlusion.hides_node(*stage.tree, row, id >> (BoundsTree::kFanOutLog2 * (row + 1)))) return true;
    }
    return occlusion.hides_patch(id, patch_box(stage.surface, stage.bounds, id));
  }

  // Raises most to the patch's bound where it is in view.
  void raise(float& most, PatchId id, int j, float least_apparent) const {
    const float own = (*this)(id, j, least_apparent);
    if (own > most && in_view(id)) most = own;
  }
};

// Of levels that do not morph.
float bound_of_levels(const SelectLod& stage) {
  if (!bound_is_known(stage)) return std::numeric_limits<float>::infinity();
  const PixelBound bound(stage);
  float most = 0.0f;
  visit_patches(stage, [&](PatchId first, std::uint32_t count) {
    for (PatchId id = first; id < first + count; ++id) {
      // An edge to a coarser neighbour leaves out vertices: a mixture of two levels, which error(j) covers.
      int j = stage.levels[id];
      for (const PatchEdge edge : stage.surface.patches[id].neighbour) {
        if (is_drawn_lower(edge, stage.levels[id], stage.levels)) j = stage.levels[id] - 1;
      }
      bound.raise(most, id, std::max(j, 1), least_apparent_distance(stage.lods[id], bound.view));
    }
  });
  return most;
}

// --- what is held

bool is_held(const SelectLod& stage, PatchId first, std::uint32_t count) {
  const std::uint8_t* const wanted = stage.levels.data() + first;
  const std::uint8_t* const held = stage.resident.data() + first;
  unsigned lacking = 0;
  for (std::uint32_t i = 0; i < count; ++i) lacking |= wanted[i] > held[i] ? 1u : 0u;
  return lacking == 0;
}

// Cuts the levels of patches in view to what is held; true where that changed any.
bool cap_run(const SelectLod& stage, const PixelBound& bound, PatchId first, std::uint32_t count,
             SelectLod::Result& result) {
  if (is_held(stage, first, count)) return false;
  const bool known = bound_is_known(stage);
  bool changed = false;
  for (PatchId id = first; id < first + count; ++id) {
    const std::uint8_t wanted = stage.levels[id];
    const std::uint8_t held = stage.resident[id];
    if (wanted <= held || !bound.in_view(id)) continue;
    stage.levels[id] = held;
    changed = true;
    if (result.capped < stage.lacking.size()) {
      const float px =
          known ? bound(id, std::max<int>(held, 1), least_apparent_distance(stage.lods[id], bound.view))
                : std::numeric_limits<float>::infinity();
      stage.lacking[result.capped] = {id, px, wanted};
    }
    ++result.capped;
    result.missing += held == 0 ? 1u : 0u;
  }
  return changed;
}

// Where something is missing, what it would hide is drawn, too.
void cut_hidden(const SelectLod& stage) {
  visit_patches(stage, [&](PatchId first, std::uint32_t count) {
    for (PatchId id = first; id < first + count; ++id) {
      stage.levels[id] = std::min(stage.levels[id], stage.resident[id]);
    }
  });
}

// Patches of a level lower their neighbours to one more than it; both in view, so both are among those that
// were visited. What is out of view imposes nothing: its edges are not seen.
std::uint32_t lower_finer(const SelectLod& stage, const PixelBound& bound) {
  std::uint32_t lowered = 0;
  for (int level = 1; level < stage.settings.top_level() - 1; ++level) {
    visit_patches(stage, [&](PatchId first, std::uint32_t count) {
      for_each_at_level(stage.levels, first, count, level, [&](PatchId id) {
        for (const PatchEdge edge : stage.surface.patches[id].neighbour) {
          if (!edge.exists() || stage.levels[edge.patch()] <= level + 1) continue;
          if (!bound.in_view(id)) return;
          if (!bound.in_view(edge.patch())) continue;
          stage.levels[edge.patch()] = static_cast<std::uint8_t>(level + 1);
          ++lowered;
        }
      });
    });
  }
  return lowered;
}

// The bound of morphing levels that were cut.
void raise_capped_bound(const SelectLod& stage, const PixelBound& bound, float& most) {
  const auto wanted = [&](PatchId id) {
    return level_at(stage.lods[id], least_apparent_distance(stage.lods[id], bound.view));
  };
  visit_patches(stage, [&](PatchId first, std::uint32_t count) {
    for (PatchId id = first; id < first + count; ++id) {
      const int level = stage.levels[id];
      const float apparent = least_apparent_distance(stage.lods[id], bound.view);
      const bool cut = level < level_at(stage.lods[id], apparent);
      if (cut) bound.raise(most, id, std::max(level, 1), apparent);
      // Where that is no more than is known already, as nearly everywhere, edges need no look.
      if (level < 2 || !(bound(id, level - 1, apparent) > most)) continue;
      for (const PatchEdge edge : stage.surface.patches[id].neighbour) {
        if (!is_drawn_lower(edge, level, stage.levels)) continue;
        // The border vertices that are left out have arrived, unless one of the two patches was cut; and they
        // are seen where both patches are.
        if ((cut || wanted(edge.patch()) >= level) && bound(id, level - 1, apparent) > most &&
            bound.in_view(edge.patch())) {
          bound.raise(most, id, level - 1, apparent);
        }
      }
    }
  });
}

// --- by error

SelectLod::Result select_by_error(const SelectLod& stage) {
  const PixelBound bound(stage);
  const int top = stage.settings.top_level();
  const bool missing_levels = top < stage.errors.level;
  SelectLod::Result result;
  result.bound_px = static_cast<float>(stage.settings.error_px);
  bool cut = false;
  visit_patches(stage, [&](PatchId first, std::uint32_t count) {
    for (PatchId id = first; id < first + count; ++id) {
      const PatchLod& lod = stage.lods[id];
      const float apparent = least_apparent_distance(lod, bound.view);
      const int level = level_at(lod, apparent);
      stage.levels[id] = static_cast<std::uint8_t>(level);
      if (missing_levels && level == top) bound.raise(result.bound_px, id, top, apparent);
    }
    if (!stage.resident.empty()) cut = cap_run(stage, bound, first, count, result) || cut;
  });
  if (cut) {
    if (result.missing > 0 && stage.occlusion != nullptr) cut_hidden(stage);
    result.lowered = lower_finer(stage, bound);
    raise_capped_bound(stage, bound, result.bound_px);
  }
  return result;
}

}  // namespace

Status SelectLod::validate() const {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  const LodSettings& s = settings;
  if (s.mode != LodMode::error && s.mode != LodMode::distance && s.mode != LodMode::full) {
    return refuse("not a mode", "mode");
  }
  if (s.max_level < 1 || s.max_level > kMaxLevel) return refuse("not a level of detail", "max_level");
  if (s.resident_level < 1 || s.resident_level > kMaxLevel) {
    return refuse("not a level of detail", "resident_level");
  }
  if (!(s.error_px >= kLeastErrorPx && s.error_px <= kMostErrorPx)) {
    return refuse("not within 0.01..1000 pixels", "error_px");
  }
  if (!(s.distance_voxels >= 0.0 && s.distance_voxels <= kCameraReach)) {
    return refuse("not within 0..2^20 voxels", "distance_voxels");
  }
  if (camera == nullptr) return refuse("missing", "camera");
  if (bounds.size() != surface.patches.size()) return refuse("must hold one box a patch", "bounds");
  if (tree == nullptr) return refuse("missing", "tree");
  if (tree->patches() != surface.patches.size()) return refuse("not built over the surface", "tree");
  if (s.mode == LodMode::error) {
    if (!(scale.steps_per_step > 0.0f)) return refuse("not made by make_error_scale", "scale");
    if (lods.size() != surface.patches.size()) return refuse("must hold one entry a patch", "lods");
    if (!errors.known(surface.patches.size())) return refuse("must hold the values of every patch", "errors");
  }
  if (!resident.empty() && resident.size() != surface.patches.size()) {
    return refuse("must hold one byte a patch", "resident");
  }
  if (!cones.empty() && cones.size() != surface.patches.size()) {
    return refuse("must hold one cone a patch", "cones");
  }
  if (levels.size() != surface.patches.size()) return refuse("must hold one byte a patch", "levels");
  return {};
}

SelectLod::Result SelectLod::run() const {
  KARST_ASSERT(validate().ok());
  if (levels.empty()) return {};
  if (settings.mode == LodMode::error) return select_by_error(*this);
  Result result;
  if (settings.mode == LodMode::full) {
    std::memset(levels.data(), settings.top_level(), levels.size());
  } else {
    Thresholds thresholds;
    thresholds.top = settings.top_level();
    thresholds.eye = glm::vec3(eye_lattice(*camera));
    for (int m = 2; m <= thresholds.top; ++m) {
      const double distance = std::ldexp(settings.distance_voxels * kStepsPerVoxel, 2 - m);
      thresholds.squared[m] = static_cast<float>(distance * distance);
    }
    choose(*this, thresholds, tree->rows() - 1, 0);
    result.raised = raise_coarser(surface, levels, thresholds.top);
  }
  if (!resident.empty()) {
    const PixelBound bound(*this);
    const auto patches = static_cast<std::uint32_t>(levels.size());
    const bool cut = cap_run(*this, bound, 0, patches, result);
    if (cut && result.missing > 0 && occlusion != nullptr) cut_hidden(*this);
    if (cut) result.lowered = lower_finer(*this, bound);
  }
  result.bound_px = bound_of_levels(*this);
  return result;
}

}  // namespace karst::core
