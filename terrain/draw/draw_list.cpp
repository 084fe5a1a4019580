// SPDX-License-Identifier: MIT
// Two passes over what is in view and one over the items: culling writes a key and a patch a visible patch, a
// counting sort puts them in order. A key is eight bits of distance, so that it shares 32 bits with a patch.
#include "terrain/draw/draw_list.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/base/simd.h"
#include "terrain/draw/index_batches.h"
#include "terrain/lod/morph.h"

namespace karst::core {
namespace {

constexpr std::uint32_t kKeyShift = 24;
constexpr std::uint32_t kPatchMask = (1u << kKeyShift) - 1;
static_assert(BoundsTree::kMaxPatches - 1 <= kPatchMask);

constexpr std::uint32_t kBands = 256;
using BandCounts = std::array<std::uint32_t, kBands>;

// Exponent and first three bits of the mantissa of the squared distance: eight bands an octave of it, sixteen
// an octave of the distance. The first band ends at 2^14 squared steps, 1/64 voxel; the last one begins near
// 2^46, 990 voxels.
simd::Int4 bands(simd::Float4 squared_distance) {
  constexpr int kMantissaShift = 23 - 3;
  constexpr std::int32_t kFirst = (127 + 14) << 3;
  const simd::Int4 band = (simd::as_int(squared_distance) >> kMantissaShift) - kFirst;
  const simd::Int4 last = simd::splat(std::int32_t{kBands - 1});
  return simd::select(band > last, last, band & (band > 0));
}

// Patch::collapsed is said of edge 3.
constexpr unsigned kCollapsedEdge = 1u << 3;

constexpr std::uint32_t kEight = PatchBoxes::kPatches;

// Which patches are listed: all, those that face the eye, or, in a parallel view, its direction.
enum class Facing : std::uint8_t { any, eye, along };

struct Collector {
  explicit Collector(const BuildDrawList& s)
      : stage(s),
        eye(eye_lattice(*s.camera)),
        forward(s.camera->forward),
        slack(back_facing_slack(eye)),
        patches(static_cast<std::uint32_t>(s.surface.patches.size())),
        out(s.scratch.data()) {}

  const BuildDrawList& stage;
  const glm::vec3 eye;
  const glm::vec3 forward;
  const float slack;
  const std::uint32_t patches;
  std::uint32_t* out;
  BandCounts counts{};
  std::uint32_t missing = 0;
  std::uint32_t back_facing = 0;
  std::uint32_t occluded = 0;

  std::uint32_t visible() const { return static_cast<std::uint32_t>(out - stage.scratch.data()); }

  void run() {
    if (stage.cones.empty()) {
      run_all<Facing::any>();
    } else if (stage.camera->parallel) {
      run_all<Facing::along>();
    } else {
      run_all<Facing::eye>();
    }
  }

 private:
  template <Facing kFacing>
  void run_all() {
    if (stage.culled.data() == nullptr) {
      for (std::uint32_t n = 0; n < stage.boxes.size(); ++n) {
        const std::uint32_t count = std::min(kEight, patches - n * kEight);
        add<kFacing>(n, (1u << count) - 1);
      }
      return;
    }
    for (const CulledEight& eight : stage.culled) {
      unsigned in_view = eight.in_view;
      if (!stage.shows_hidden) {
        occluded += static_cast<std::uint32_t>(std::popcount(unsigned{eight.hidden}));
        in_view &= ~unsigned{eight.hidden};
      }
      if (in_view != 0) add<kFacing>(eight.n, in_view);
    }
  }

  // Patches 8 n + p for the bits p of a mask.
  template <Facing kFacing>
  void add(std::uint32_t n, unsigned in_view) {
    const PatchBoxes& boxes = stage.boxes[n];
    const PatchId first = n * kEight;
    const std::uint8_t* const levels = stage.levels.data() + first;
    const auto at = [&](unsigned mask) { return static_cast<unsigned>(std::countr_zero(mask)); };
    std::uint32_t keys[kEight];
    for (unsigned half = 0; half < 2; ++half) {
      simd::Float4 d[3];  // origins less the eye
      for (int axis = 0; axis < 3; ++axis) {
        d[axis] = simd::to_float(four(boxes.corner[axis], half) << kLatticeBits) - simd::splat(eye[axis]);
      }
      simd::store(keys + 4 * half, bands(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
      if constexpr (kFacing != Facing::any) {
        if (first + 4 * half >= patches) continue;
        unsigned away = in_view & may_face_away<kFacing>(boxes, half, first + 4 * half, d) << 4 * half;
        for (; away != 0; away &= away - 1) {
          const unsigned p = at(away);
          if (levels[p] == 0 || !faces_away<kFacing>(boxes, p, first + p)) continue;
          in_view &= ~(1u << p);
          ++back_facing;
        }
      }
    }
    for (; in_view != 0; in_view &= in_view - 1) {
      const unsigned p = at(in_view);
      if (levels[p] == 0) {
        ++missing;
        continue;
      }
      ++counts[keys[p]];
      *out++ = keys[p] << kKeyShift | (first + p);
    }
  }

  static simd::Int4 four(const std::int16_t (&values)[kEight], unsigned half) {
    return simd::to_int(simd::load<simd::Short4>(values + 4 * half));
  }

  // Bit l: cone first + l is not known to face the eye.
  template <Facing kFacing>
  unsigned may_face_away(const PatchBoxes& boxes, unsigned half, PatchId first,
                         const simd::Float4 (&d)[3]) const {
    static_assert(std::endian::native == std::endian::little);
    simd::Int4 cones{};
    if (first + 4 <= patches) {
      cones = simd::load<simd::Int4>(stage.cones.data() + first);
    } else {
      std::memcpy(&cones, stage.cones.data() + first, sizeof(NormalCone) * (patches - first));
    }
    simd::Float4 axes[3];
    for (int n = 0; n < 3; ++n) axes[n] = simd::to_float(cones << (24 - 8 * n) >> 24);
    const auto dot = [](const simd::Float4(&a)[3], const simd::Float4(&b)[3]) {
      return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    };
    // Most patches' axes lead to the eye, and nothing more needs to be known.
    const simd::Float4 zero = simd::splat(0.0f);
    if constexpr (kFacing == Facing::along) {
      const simd::Float4 sight[3] = {simd::splat(forward.x), simd::splat(forward.y), simd::splat(forward.z)};
      return simd::lanes(dot(axes, sight) > zero);
    }
    const simd::Int4 turned = dot(axes, d) > zero;
    if (!simd::any(turned)) return 0;
    // is_back_facing() with a cone that is no wider than it takes it to be.
    simd::Float4 centre[3];
    simd::Float4 size[3];
    simd::Float4 widths[3];
    for (int n = 0; n < 3; ++n) {
      const simd::Int4 low = four(boxes.min[n], half);
      const simd::Int4 high = four(boxes.max[n], half);
      centre[n] = d[n] + simd::splat(0.5f) * simd::to_float(low + high);
      size[n] = simd::splat(0.5f) * simd::to_float(high - low);
      widths[n] = simd::abs(axes[n]);
    }
    const simd::Float4 least = dot(axes, centre) - dot(widths, size) - simd::splat(128.0f * slack);
    const simd::Float4 sine =
        simd::splat(NormalCone::kSineUnit) * simd::to_float(cones >> 24 & std::int32_t{NormalCone::kNone});
    const simd::Float4 length = simd::sqrt(dot(centre, centre)) + simd::sqrt(dot(size, size));
    return simd::lanes(turned & (least > zero) & (least > sine * length));
  }

  template <Facing kFacing>
  bool faces_away(const PatchBoxes& boxes, unsigned p, PatchId id) const {
    const NormalCone& cone = stage.cones[id];
    if (cone.sine == NormalCone::kNone) return false;
    const glm::ivec3 low(boxes.min[0][p], boxes.min[1][p], boxes.min[2][p]);
    const glm::ivec3 high(boxes.max[0][p], boxes.max[1][p], boxes.max[2][p]);
    const glm::vec3 centre = glm::vec3(boxes.origin(p)) - eye + 0.5f * glm::vec3(low + high);
    constexpr bool parallel = kFacing == Facing::along;
    const float distance = parallel ? kParallelDistance : glm::length(centre);
    const float snap = snap_sine(distance, stage.levels[id], stage.least_pixels);
    return parallel ? is_back_facing(cone, forward, snap)
                    : is_back_facing(cone, centre, 0.5f * glm::vec3(high - low), slack, snap);
  }
};

// What a list has at each level and in each state of edges: a patch's triangles follow from these.
struct ItemCounts {
  std::uint32_t counts[kMaxLevel + 1][2 * 16] = {};

  void add(const DrawItem& item) {
    ++counts[item.level][item.lower_edges << 1 | (item.skipped_edges != 0 ? 1 : 0)];
  }
  void finish(BuildDrawList::Result& result) const {
    for (int level = 1; level <= kMaxLevel; ++level) {
      for (unsigned edges = 0; edges < 2 * 16; ++edges) {
        const std::uint32_t count = counts[level][edges];
        result.at_level[level] += count;
        const unsigned skipped = (edges & 1u) != 0 ? kCollapsedEdge : 0u;
        result.triangles += count * (patch_index_count(level, edges >> 1, skipped) / 3);
      }
    }
  }
};

}  // namespace

DrawItem make_draw_item(const Surface& surface, std::span<const std::uint8_t> levels, PatchId id) {
  const Patch& patch = surface.patches[id];
  const std::uint8_t level = levels[id];
  unsigned lower = 0;
  for (unsigned e = 0; e < 4; ++e) {
    const PatchEdge other = patch.neighbour[e];
    // Two levels apart they cannot both be in view (SelectLod::levels).
    if (level > 1 && other.exists() && levels[other.patch()] == level - 1) lower |= 1u << e;
  }
  const unsigned skipped = patch.collapsed != 0 ? kCollapsedEdge : 0u;
  return {id, level, static_cast<std::uint8_t>(lower), static_cast<std::uint8_t>(skipped)};
}

Status BuildDrawList::validate() const {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  const std::size_t patches = surface.patches.size();
  if (patches > kMaxPatches) return refuse("more than 2^24 patches", "surface");
  if (camera == nullptr) return refuse("missing", "camera");
  if (boxes.size() != PatchBoxes::count_for(static_cast<std::uint32_t>(patches))) {
    return refuse("must hold one entry eight patches", "boxes");
  }
  if (culled.size() > boxes.size()) return refuse("holds more than the patches", "culled");
  if (levels.size() != patches) return refuse("must hold one byte a patch", "levels");
  if (!cones.empty() && cones.size() != patches) return refuse("must hold one cone a patch", "cones");
  if (scratch.size() < patches) return refuse("must hold one value a patch", "scratch");
  return {};
}

Status BuildDrawList::run(Result& result) const {
  KARST_ASSERT(validate().ok());
  result = {};
  const auto patches = static_cast<std::uint32_t>(surface.patches.size());
  if (patches == 0) return {};
  Collector seen(*this);
  seen.run();

  BandCounts position;  // where the next item of a band goes
  std::uint32_t next = 0;
  for (std::uint32_t b = 0; b < kBands; ++b) {
    position[b] = next;
    next += seen.counts[b];
  }
  ItemCounts counts;
  const std::uint32_t visible = seen.visible();
  for (const std::uint32_t entry : scratch.first(visible)) {
    const std::uint32_t at = position[entry >> kKeyShift]++;
    if (at >= items.size()) continue;
    const PatchId id = entry & kPatchMask;
    DrawItem item{id, 1, 0, 0};
    if (levels[id] == 1) {
      // No neighbour is lower: the patch itself needs no look.
      if ((unsigned{boxes[id / kEight].collapsed} >> id % kEight & 1u) != 0)
        item.skipped_edges = kCollapsedEdge;
    } else {
      item = make_draw_item(surface, levels, id);
    }
    items[at] = item;
    counts.add(item);
  }
  counts.finish(result);

  result.drawn = items.size() < visible ? static_cast<std::uint32_t>(items.size()) : visible;
  result.dropped = visible - result.drawn;
  result.culled_frustum = patches - visible - seen.missing - seen.back_facing - seen.occluded;
  result.culled_occluded = seen.occluded;
  result.culled_backface = seen.back_facing;
  result.missing = seen.missing;
  if (result.dropped > 0) {
    return {StatusCode::limit_reached, "more patches in view than draw items", "max_draw_items", visible};
  }
  return {};
}

}  // namespace karst::core
