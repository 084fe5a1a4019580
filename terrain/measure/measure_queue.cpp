// SPDX-License-Identifier: MIT
#include "terrain/measure/measure_queue.h"

#include <algorithm>

#include "terrain/base/check.h"
#include "terrain/measure/bounds/quick_bounds.h"
#include "terrain/measure/level_triangles.h"
#include "terrain/measure/shading_cone.h"

namespace karst::core {
namespace {

// The most that a patch's borders can be off, from what all of it may be.
BorderErrors borders_within(int level, std::span<const std::uint16_t> row) {
  BorderErrors all{};
  for (int e = 0; e < 4; ++e) {
    std::copy_n(row.begin(), level - 1, all.error[e]);
    std::copy_n(row.begin() + (level - 1), level - 1, all.reach[e]);
  }
  return all;
}

}  // namespace

void MeasureQueue::reset() {
  std::ranges::fill(storage_.states, std::uint8_t{0});
  left_ = loose_ = 0;
  next_ = next_loose_ = 0;
}

void MeasureQueue::wait(PatchId patch, unsigned more) {
  std::uint8_t& state = storage_.states[patch];
  if ((state & kWaits) == 0) ++left_;
  state = static_cast<std::uint8_t>(state | kWaits | more);
}

void MeasureQueue::forget(PatchId slot) {
  if ((storage_.states[slot] & kWaits) != 0) --left_;
  set_loose(slot, false);
  storage_.states[slot] = 0;
}

void MeasureQueue::add(const Surface& surface, const Heights& heights, std::span<const PatchId> changed,
                       std::span<const PatchId> touched, std::span<const GridRows> rows,
                       PatchScratch* scratch, const PatchMeasures& out, std::size_t exact) {
  GenerateVertices generate;
  generate.surface = surface;
  generate.heights = heights;
  generate.level = heights.level;
  generate.scratch = scratch;
  for (std::size_t n = 0; n < changed.size(); ++n) {
    const PatchId patch = changed[n];
    set_loose(patch, n >= exact);
    if (n < exact) {
      bound(generate, patch, out);
    } else {
      const QuickBounds quick = quick_bounds(surface, heights, patch);
      out.bounds[patch] = quick.box;
      bound_own_errors(heights.level, quick.ways, quick.box, storage_.own[patch], quick.apart);
    }
    out.cones[patch] = {};
    storage_.states[patch] &= static_cast<std::uint8_t>(~kKnown);
    wait(patch, kErrors | kCone | kBounded);
  }
  for (std::size_t n = 0; n < touched.size(); ++n) {
    if (!rows[n].any()) continue;
    out.shading_cones[touched[n]] = {};
    wait(touched[n], 0);
  }
  for (const PatchId patch : changed) join_bounds(surface, heights, patch, out);
  // Neighbours that are what they were: their borders' other side is not.
  for (const PatchId patch : changed) {
    for (const PatchEdge edge : surface.patches[patch].neighbour) {
      if (!edge.exists()) continue;
      if ((storage_.states[edge.patch()] & kBounded) != 0) {
        join_bounds(surface, heights, edge.patch(), out);
        continue;
      }
      BorderErrors none{};
      const BorderErrors* theirs[4];
      for (int e = 0; e < 4; ++e) {
        const PatchEdge other = surface.patches[edge.patch()].neighbour[e];
        theirs[e] = other.exists() && other.patch() == patch ? &storage_.own[patch].borders : &none;
      }
      join_errors(surface, heights.level, edge.patch(), none, theirs, row_of(heights, edge.patch(), out));
      wait(edge.patch(), kErrors);
    }
  }
}

void MeasureQueue::set_loose(PatchId patch, bool loose) {
  std::uint8_t& state = storage_.states[patch];
  if (((state & kLoose) != 0) == loose) return;
  state ^= static_cast<std::uint8_t>(kLoose);
  loose_ += loose ? 1u : ~0u;
}

void MeasureQueue::bound(const GenerateVertices& generate, PatchId patch, const PatchMeasures& out) {
  MorphWays ways;
  out.bounds[patch] = generate.bounds(patch, ways);
  bound_own_errors(generate.level, ways, out.bounds[patch], storage_.own[patch]);
}

PatchId MeasureQueue::next_loose() {
  KARST_ASSERT(loose_ > 0);
  while ((storage_.states[next_loose_] & kLoose) == 0)
    next_loose_ = (next_loose_ + 1) % storage_.states.size();
  return static_cast<PatchId>(next_loose_);
}

void MeasureQueue::fit(const Surface& surface, const Heights& heights, PatchId patch, PatchScratch* scratch,
                       const PatchMeasures& out) {
  KARST_ASSERT((storage_.states[patch] & kLoose) != 0);
  GenerateVertices generate;
  generate.surface = surface;
  generate.heights = heights;
  generate.level = heights.level;
  generate.scratch = scratch;
  bound(generate, patch, out);
  set_loose(patch, false);
  join_bounds(surface, heights, patch, out);
}

void MeasureQueue::join_bounds(const Surface& surface, const Heights& heights, PatchId patch,
                               const PatchMeasures& out) {
  const OwnErrors& own = storage_.own[patch];
  const std::span<std::uint16_t> row = row_of(heights, patch, out);
  BorderErrors made[4];
  const BorderErrors* theirs[4] = {};
  for (int e = 0; e < 4; ++e) {
    const PatchEdge other = surface.patches[patch].neighbour[e];
    if (!other.exists()) continue;
    theirs[e] = &storage_.own[other.patch()].borders;
    if ((storage_.states[other.patch()] & (kBounded | kKnown)) != 0) continue;
    made[e] = borders_within(heights.level, row_of(heights, other.patch(), out));
    theirs[e] = &made[e];
  }
  std::copy_n(own.values, row.size(), row.begin());
  join_errors(surface, heights.level, patch, own.borders, theirs, row);
}

void MeasureQueue::know(const LevelGrid& grid, PatchId patch) {
  std::uint8_t& state = storage_.states[patch];
  if ((state & kKnown) != 0) return;
  OwnErrors& own = storage_.own[patch];
  measure_own_errors(grid, own.borders, own.values);
  state = static_cast<std::uint8_t>((state & ~unsigned{kBounded}) | kKnown);
}

PatchId MeasureQueue::measure_next(const Surface& surface, const Heights& heights,
                                   const MeasurePatches::Room& room, const PatchMeasures& out) {
  KARST_ASSERT(left_ > 0 && loose_ == 0);
  while ((storage_.states[next_] & kWaits) == 0) next_ = (next_ + 1) % storage_.states.size();
  const auto patch = static_cast<PatchId>(next_);
  std::uint8_t& state = storage_.states[patch];
  if ((state & (kErrors | kCone)) != 0) {
    const LevelGrid grid(surface, heights, patch);
    if ((state & kErrors) != 0) {
      know(grid, patch);
      for (const PatchEdge edge : surface.patches[patch].neighbour) {
        if (edge.exists() && (storage_.states[edge.patch()] & kKnown) == 0)
          know(LevelGrid(surface, heights, edge.patch()), edge.patch());
      }
      join_bounds(surface, heights, patch, out);
    }
    if ((state & kCone) != 0) out.cones[patch] = measure_normal_cone(grid);
  }
  GenerateVertices generate;
  generate.surface = surface;
  generate.heights = heights;
  generate.level = heights.level;
  generate.scratch = room.scratch;
  generate.run(patch, room.vertices, nullptr);
  out.shading_cones[patch] = measure_shading_cone(room.vertices);
  state &= kKnown;
  --left_;
  return patch;
}

}  // namespace karst::core
