// SPDX-License-Identifier: MIT
// Thresholds level by level from the finest: those of a level need only those of the next finer one, of the
// patch and of its neighbours.
#include "terrain/lod/morph.h"

#include <algorithm>
#include <limits>

#include "terrain/base/check.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/view/frustum.h"
#include "terrain/view/projection.h"

namespace karst::core {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();

// Positions, distances and shares in float are off by less than 2^-20 of the distance to the eye.
constexpr double kRounding = 0x1p-20;

void set_place(const SetThresholds& job, PatchId id, PatchLod& lod) {
  const glm::ivec3 origin = patch_origin(job.surface.volume_of(id));
  const PatchBounds& b = job.bounds[id];
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int size = b.max[axis] - b.min[axis];
    lod.centre[axis] =
        static_cast<float>(origin[axis]) + 0.5f * static_cast<float>(b.min[axis] + b.max[axis]);
    squared += double(size) * size;
  }
  // A step more than its float can have lost.
  lod.reach = static_cast<float>(0.5 * kSteepest * std::sqrt(squared) + 1.0);
}

// Voxels from the eye, at least those of the farthest point of the world that a parallel view shows; twice as
// many at most, so that they seldom change while it moves.
double farthest(const Camera& camera) {
  const glm::dvec3 eye = eye_lattice(camera) / double{kStepsPerVoxel};
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double away =
        std::max(std::abs(eye[axis]), std::abs(kBoxReach / double{kStepsPerVoxel} - eye[axis]));
    squared += away * away;
  }
  const double in_world = std::exp2(std::ceil(0.5 * std::log2(squared)));
  return std::min({in_world, std::max(near_reach(camera), far_reach(camera))});
}

}  // namespace

std::uint16_t threshold_half(float steps) {
  const float units = steps * (1.0f / kThresholdUnit);
  if (!(units > 0.0f)) return 0;
  if (units <= 0x1p-14f) return kLeastThreshold;
  if (units >= 65'504.0f) return kNeverMorphs;
  return static_cast<std::uint16_t>((std::bit_cast<std::uint32_t>(units) - (112u << 23) + 0x1fffu) >> 13);
}

Status build_morph_entries(int level, std::span<std::uint8_t> out) {
  if (level < 1 || level > kMaxLevel) return {StatusCode::invalid_argument, "not a level of detail", "level"};
  const auto needed = static_cast<std::size_t>(patch_vertices(level));
  if (out.size() < needed) return {StatusCode::invalid_argument, "too small for the level", "out", needed};
  const int n = patch_cells(level);
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      int m = level;
      for (int both = i | j; m > 1 && (both & 1) == 0; both >>= 1) --m;
      const int edge = j == 0 ? 0 : i == n ? 1 : j == n ? 2 : i == 0 ? 3 : -1;
      const int entry = m == 1 ? 0 : morph_entry(m, edge < 0 ? 0 : morph_class_edge(edge));
      out[static_cast<std::size_t>(vertex_order(level, i, j))] = static_cast<std::uint8_t>(entry);
    }
  }
  return {};
}

ErrorScale make_error_scale(const Camera& camera, int width_px, int height_px, double error_px) {
  auto [pixels, least_pixels] = pixel_scale(camera, width_px, height_px);
  const double least_cos2 = corner_cos2(camera);
  const double left_px =
      error_px - pixels * kRounding * (camera.parallel ? farthest(camera) : 1.0 / least_cos2);
  ErrorScale result;
  if (camera.parallel) {
    pixels *= kParallelDistance / kStepsPerVoxel;
    least_pixels *= kParallelDistance / kStepsPerVoxel;
  }
  result.pixels = static_cast<float>(pixels);
  result.least_pixels = static_cast<float>(least_pixels);
  result.steps_per_step =
      left_px > 0 ? static_cast<float>((pixels / left_px + 1.0) * (1.0 + 1e-6)) : kInfinite;
  result.least_cos2 = camera.parallel ? -kParallelDistance : static_cast<float>(least_cos2 * (1.0 - 1e-6));
  return result;
}

Status SetThresholds::validate() const {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  const std::size_t patches = surface.patches.size();
  const bool known =
      scale.least_cos2 == -kParallelDistance || (scale.least_cos2 > 0.0f && scale.least_cos2 <= 1.0f);
  if (!(scale.steps_per_step > 0.0f && known)) {
    return refuse("not made by make_error_scale", "scale");
  }
  if (max_level < 1 || max_level > kMaxLevel) return refuse("not a level of detail", "max_level");
  if (bounds.size() != patches) return refuse("must hold one box a patch", "bounds");
  if (!errors.known(patches)) return refuse("must hold the values of every patch", "errors");
  if (lods.size() != patches) return refuse("must hold one entry a patch", "lods");
  return {};
}

struct SetThresholds::Factors {
  float start, per_reach, slack;

  // What a threshold of a level adds to those of the next coarser one around it.
  float needed(const PatchLod& lod, int m) const {
    const float finer = threshold_steps(lod.threshold[m + 1]);
    return finer > 0.0f ? ((finer + 2.0f * lod.reach) * slack + 8.0f) * start : 0.0f;
  }
};

SetThresholds::Factors SetThresholds::factors() const {
  const float morph_starts = 1.0f - kMorphShare;
  Factors by{};
  by.per_reach = static_cast<float>(kSteepest / morph_starts * (1.0 + 1e-6));
  // Rounding of the distances that (2) compares: a few 2^-20 of the distance to the eye, which is less than
  // that of the threshold and the box over least_cos2; and a few steps.
  by.start = 1.0f / morph_starts * (1.0f + 0x1p-20f);
  // Constant distances are exact.
  by.slack = scale.least_cos2 < 0.0f ? 1.0f : 1.0f + 0x1p-16f / scale.least_cos2;
  return by;
}

std::uint16_t SetThresholds::threshold(const Factors& by, PatchId p, int m) const {
  const std::uint16_t error = errors.error(p, m - 1);
  float steps = 0.0f;
  if (error == kUnboundedError) {
    steps = kInfinite;
  } else if (error > 0) {
    steps = scale.steps_per_step * static_cast<float>(error) +
            by.per_reach * static_cast<float>(errors.reach(p, m));
  }
  if (m < errors.level) {
    steps = std::max(steps, by.needed(lods[p], m));
    for (const PatchEdge edge : surface.patches[p].neighbour) {
      if (edge.exists()) steps = std::max(steps, by.needed(lods[edge.patch()], m));
    }
  }
  return threshold_half(steps);
}

void SetThresholds::run() const {
  KARST_ASSERT(validate().ok());
  const auto patches = static_cast<PatchId>(lods.size());
  const int top = std::min(max_level, errors.level);
  for (PatchId p = 0; p < patches; ++p) {
    lods[p] = {};
    set_place(*this, p, lods[p]);
    for (int m = 2; m <= top && !morphing; ++m) lods[p].threshold[m] = kNeverMorphs;
  }
  if (!morphing) return;
  const Factors by = factors();
  for (int m = errors.level; m >= 2; --m) {
    for (PatchId p = 0; p < patches; ++p) lods[p].threshold[m] = threshold(by, p, m);
  }
  if (top == errors.level) return;
  for (PatchLod& lod : lods) {
    for (int m = top + 1; m <= kMaxLevel; ++m) lod.threshold[m] = 0;
  }
}

// Level by level as run(): what a level's thresholds change spreads by a patch to the next coarser one.
// While it runs, threshold[0] of those in the list is 1.
std::size_t SetThresholds::update(std::span<PatchId> list, std::size_t changed) const {
  KARST_ASSERT(validate().ok() && max_level >= errors.level);
  constexpr std::uint16_t kMoved = 2;  // in threshold[0]: its reach is another
  std::size_t count = changed;
  for (const PatchId p : list.first(count)) {
    PatchLod& lod = lods[p];
    const float reach = lod.reach;
    set_place(*this, p, lod);
    lod.threshold[0] = lod.reach == reach ? std::uint16_t{1} : kMoved;
    for (int m = 2; m <= errors.level && !morphing; ++m) lod.threshold[m] = kNeverMorphs;
  }
  const Factors by = factors();
  for (int m = errors.level; m >= 2 && morphing; --m) {
    const std::size_t end = count;
    for (std::size_t n = 0; n < end; ++n) {
      const PatchId p = list[n];
      const std::uint16_t made = threshold(by, p, m);
      const bool spreads = made != lods[p].threshold[m] || lods[p].threshold[0] == kMoved;
      lods[p].threshold[m] = made;
      if (!spreads || m == 2) continue;
      for (const PatchEdge edge : surface.patches[p].neighbour) {
        if (!edge.exists() || lods[edge.patch()].threshold[0] != 0) continue;
        lods[edge.patch()].threshold[0] = 1;
        list[count++] = edge.patch();
      }
    }
  }
  for (const PatchId p : list.first(count)) lods[p].threshold[0] = 0;
  return count;
}

void make_morph_row(const Surface& surface, std::span<const PatchLod> lods, PatchId patch,
                    std::span<std::uint16_t, kMorphRow> row) {
  std::fill(row.begin(), row.end(), std::uint16_t{0});
  row[0] = kNeverMorphs;
  const PatchLod& own = lods[patch];
  for (int edge = -1; edge < 4; ++edge) {
    const PatchEdge other = edge < 0 ? PatchEdge{} : surface.patches[patch].neighbour[edge];
    const PatchLod& sharing = other.exists() ? lods[other.patch()] : own;
    for (int m = 2; m <= kMaxLevel; ++m) {
      const auto entry = static_cast<std::size_t>(morph_entry(m, 1 + edge));
      row[entry] = std::min(own.threshold[m], sharing.threshold[m]);
    }
  }
}

LodEye make_lod_eye(const Camera& camera, float least_cos2) {
  return {glm::vec3(eye_lattice(camera)), glm::vec3(camera.forward), least_cos2};
}

}  // namespace karst::core
