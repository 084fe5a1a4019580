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
// All of this is done around the patches that were cut: where levels are as they are wanted, neighbours
// differ by at most one and are within error_px. Cut patches are marked in their levels meanwhile.
//
// A patch out of view keeps the level it would have if it were held: a neighbour in view leaves out vertices
// of their edge by it, and the triangles along that edge may be seen.
#include "terrain/lod/select_lod.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/lod/level_lanes.h"

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

// Calls visit(first, count, in_view, hidden) for eights that hold all patches in view and their neighbours;
// bit p of the two masks is patch first + p.
template <class Visit>
void visit_eights(const SelectLod& stage, const Visit& visit) {
  constexpr std::uint32_t kEight = PatchBoxes::kPatches;
  const auto patches = static_cast<std::uint32_t>(stage.levels.size());
  if (stage.culled.data() == nullptr) {
    for (PatchId first = 0; first < patches; first += kEight) {
      const std::uint32_t count = std::min(kEight, patches - first);
      visit(first, count, (1u << count) - 1, 0u);
    }
    return;
  }
  for (const CulledEight& eight : stage.culled) {
    const PatchId first = eight.n * kEight;
    visit(first, std::min(kEight, patches - first), unsigned{eight.in_view}, unsigned{eight.hidden});
  }
}

// Calls visit(patch) for the bits of a mask.
template <class Visit>
void visit_bits(PatchId first, unsigned mask, const Visit& visit) {
  for (; mask != 0; mask &= mask - 1) visit(first + static_cast<PatchId>(std::countr_zero(mask)));
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
  bool shows_hidden = false;

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
    if (stage.culled.data() != nullptr) {
      constexpr std::uint32_t kEight = PatchBoxes::kPatches;
      const auto at = std::lower_bound(stage.culled.begin(), stage.culled.end(), id / kEight,
                                       [](const CulledEight& eight, std::uint32_t n) { return eight.n < n; });
      if (at == stage.culled.end() || at->n != id / kEight) return false;
      const unsigned shown = shows_hidden ? at->in_view : at->in_view & ~unsigned{at->hidden};
      if ((shown >> id % kEight & 1u) == 0) return false;
    }
    return stage.cones.empty() || !faces_away(id);
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

  // Raises most to the patch's bound where it is in view.
  void raise(float& most, PatchId id, int j, float least_apparent) const {
    const float own = (*this)(id, j, least_apparent);
    if (own > most && in_view(id)) most = own;
  }
};

// Of levels that do not morph.
float bound_of_levels(const SelectLod& stage, bool shows_hidden) {
  if (!bound_is_known(stage)) return std::numeric_limits<float>::infinity();
  PixelBound bound(stage);
  bound.shows_hidden = shows_hidden;
  float most = 0.0f;
  visit_eights(stage, [&](PatchId first, std::uint32_t, unsigned in_view, unsigned) {
    visit_bits(first, in_view, [&](PatchId id) {
      // An edge to a coarser neighbour leaves out vertices: a mixture of two levels, which error(j) covers.
      int j = stage.levels[id];
      for (const PatchEdge edge : stage.surface.patches[id].neighbour) {
        if (is_drawn_lower(edge, stage.levels[id], stage.levels)) j = stage.levels[id] - 1;
      }
      bound.raise(most, id, std::max(j, 1), least_apparent_distance(stage.lods[id], bound.view));
    });
  });
  return most;
}

// --- what is held

// Bit p: byte p of eight a is greater than that of b; below 128, those beyond count not set.
unsigned greater_bytes(const std::uint8_t* a, const std::uint8_t* b, std::uint32_t count) {
  static_assert(std::endian::native == std::endian::little);
  constexpr std::uint64_t kTops = 0x8080808080808080u;
  const auto bytes = [count](const std::uint8_t* from) {
    std::uint64_t result = 0;
    std::memcpy(&result, from, count == 8 ? 8 : count);
    return result;
  };
  const std::uint64_t greater = ~((bytes(b) | kTops) - bytes(a)) & kTops;
  return static_cast<unsigned>((greater >> 7) * 0x0102040810204080u >> 56);
}

class Cutter {
 public:
  explicit Cutter(const SelectLod& stage) : stage_(stage), bound_(stage), known_(bound_is_known(stage)) {}

  // Lists the patches of an eight that are in view and held coarser than wanted, and cuts their levels.
  void cap(PatchId first, std::uint32_t count, unsigned shown) {
    const unsigned finer = greater_bytes(stage_.levels.data() + first, stage_.resident.data() + first, count);
    visit_bits(first, finer & shown, [&](PatchId id) {
      if (stage_.cones.empty() || !bound_.faces_away(id)) lack(id);
    });
  }

  // Brings neighbours within one level of each other, and the bound to what then holds by error.
  void finish() {
    if (result_.missing > 0 && stage_.cuts) show_hidden();
    lower_finer();
    if (stage_.settings.mode == LodMode::error) raise_bound();
    for (const PatchId id : stage_.cut.first(result_.cut)) stage_.levels[id] = level(id);
  }

  PixelBound& bound() { return bound_; }
  SelectLod::Result& result() { return result_; }

 private:
  static constexpr std::uint8_t kCut = 0x80;

  std::uint8_t level(PatchId id) const { return stage_.levels[id] & ~unsigned{kCut} & 0xffu; }
  bool is_cut(PatchId id) const { return (stage_.levels[id] & kCut) != 0; }
  void cut(PatchId id, int to) {
    if (!is_cut(id)) stage_.cut[result_.cut++] = id;
    stage_.levels[id] = static_cast<std::uint8_t>(to | kCut);
  }

  void lack(PatchId id) {
    const std::uint8_t wanted = stage_.levels[id];
    const std::uint8_t held = stage_.resident[id];
    if (result_.capped < stage_.lacking.size()) {
      const float px =
          known_ ? bound_(id, std::max<int>(held, 1), least_apparent_distance(stage_.lods[id], bound_.view))
                 : std::numeric_limits<float>::infinity();
      stage_.lacking[result_.capped] = {id, px, wanted};
    }
    ++result_.capped;
    result_.missing += held == 0 ? 1u : 0u;
    if (stage_.cuts) cut(id, held);
  }

  // Where something is missing, what it would hide is drawn, too.
  void show_hidden() {
    bound_.shows_hidden = true;
    visit_eights(stage_, [&](PatchId first, std::uint32_t, unsigned, unsigned hidden) {
      visit_bits(first, hidden, [&](PatchId id) {
        if (stage_.levels[id] > stage_.resident[id]) cut(id, stage_.resident[id]);
      });
    });
  }

  // Patches of a level lower their neighbours to one more than it, both in view. What is out of view imposes
  // nothing: its edges are not seen.
  void lower_finer() {
    for (int coarse = 1; coarse < stage_.settings.top_level() - 1; ++coarse) {
      for (std::uint32_t n = 0; n < result_.cut; ++n) {
        if (level(stage_.cut[n]) == coarse) lower_neighbours(stage_.cut[n], coarse + 1);
      }
    }
  }

  void lower_neighbours(PatchId id, int most) {
    for (const PatchEdge edge : stage_.surface.patches[id].neighbour) {
      if (!edge.exists() || level(edge.patch()) <= most) continue;
      if (!bound_.in_view(id)) return;
      if (!bound_.in_view(edge.patch())) continue;
      cut(edge.patch(), most);
      ++result_.lowered;
    }
  }

  // The border vertices that an edge to a coarser neighbour leaves out have arrived, unless one of the two
  // patches was cut; and they are seen where both patches are.
  void raise_edge(PatchId fine, PatchId coarse) {
    const int j = level(fine) - 1;
    if (j < 1 || level(coarse) != j) return;
    const float apparent = least_apparent_distance(stage_.lods[fine], bound_.view);
    if (bound_(fine, j, apparent) > result_.bound_px && bound_.in_view(coarse)) {
      bound_.raise(result_.bound_px, fine, j, apparent);
    }
  }

  void raise_bound() {
    for (const PatchId id : stage_.cut.first(result_.cut)) {
      bound_.raise(result_.bound_px, id, std::max<int>(level(id), 1),
                   least_apparent_distance(stage_.lods[id], bound_.view));
      for (const PatchEdge edge : stage_.surface.patches[id].neighbour) {
        if (!edge.exists()) continue;
        raise_edge(id, edge.patch());
        raise_edge(edge.patch(), id);
      }
    }
  }

  const SelectLod& stage_;
  PixelBound bound_;
  const bool known_;
  SelectLod::Result result_;
};

// --- by error

SelectLod::Result select_by_error(const SelectLod& stage) {
  Cutter cutter(stage);
  const PixelBound& bound = cutter.bound();
  SelectLod::Result& result = cutter.result();
  const LevelLanes lanes(bound.view);
  const int top = stage.settings.top_level();
  const bool missing_levels = top < stage.errors.level;
  result.bound_px = static_cast<float>(stage.settings.error_px);
  visit_eights(stage, [&](PatchId first, std::uint32_t count, unsigned in_view, unsigned hidden) {
    lanes.run(stage.lods.data() + first, count, stage.levels.data() + first);
    if (missing_levels) {
      visit_bits(first, in_view & ~hidden, [&](PatchId id) {
        if (stage.levels[id] != top) return;
        bound.raise(result.bound_px, id, top, least_apparent_distance(stage.lods[id], bound.view));
      });
    }
    if (!stage.resident.empty()) cutter.cap(first, count, in_view & ~hidden);
  });
  cutter.finish();
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
  if (!resident.empty() && cut.size() < surface.patches.size()) {
    return refuse("must hold one value a patch", "cut");
  }
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
  bool shows_hidden = false;
  if (!resident.empty()) {
    Cutter cutter(*this);
    cutter.result() = result;
    visit_eights(*this, [&](PatchId first, std::uint32_t count, unsigned in_view, unsigned hidden) {
      cutter.cap(first, count, in_view & ~hidden);
    });
    cutter.finish();
    result = cutter.result();
    shows_hidden = cutter.bound().shows_hidden;
  }
  result.bound_px = bound_of_levels(*this, shows_hidden);
  return result;
}

}  // namespace karst::core
