// SPDX-License-Identifier: MIT
// From a patch to its GPU vertices: exact undisplaced positions (K 3.5.1), displacement along the smoothed
// gradient (design 4.4), area-weighted normals over all triangles around a vertex, those of neighbouring
// patches included (K 3.5.3), morph targets (K 4.4.4), and the 16-byte layout.
//
// The result for a patch is a function of the surface and the heights alone: patches can be generated in any
// order, one at a time or all, and every attribute of a vertex that patches share is the same bits in each of
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/corner_fan.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// Working memory of one run at a time; lives in the arena (Consumer::scratch).
struct PatchScratch;

// How far vertices of a level are from their morph targets at most: squares of twice that, less what floats
// lose (2^-20), over the whole patch and along each edge. [m]: m = 2..heights.level.
struct MorphWays {
  float longest[kMaxLevel + 1] = {};
  float on_edge[kMaxLevel + 1][4] = {};
};

struct GenerateVertices {
  // Inputs, borrowed.
  Surface surface;
  Heights heights;
  // 1..heights.level; vertices are those of the full level at stride 2^(heights.level - level).
  int level = 0;
  // 1..level, or 0 for level: vertices of finer levels are left out, those of this level and the coarser ones
  // are the same bits as without, their normals included.
  int emit_level = 0;

  // Working memory, borrowed; one run at a time.
  PatchScratch* scratch = nullptr;

  Status validate() const;

  // out: patch_vertices(emit_level or level) values in the order of gpu_vertex.h. bounds may be null.
  // Precondition: validate() is ok, patch < surface.patches.size(), out is long enough.
  void run(PatchId patch, std::span<GpuVertex> out, PatchBounds* bounds) const;

  // The box of the patch's vertices alone. Same preconditions.
  PatchBounds bounds(PatchId patch) const;
  // The same, and the ways of all vertices.
  PatchBounds bounds(PatchId patch, MorphWays& ways) const;

  // Calls need(block) for the height blocks that run() reads for a patch, a block more than once at times.
  // Borders need those of all patches around the patch's corners.
  template <class Need>
  void for_each_block(PatchId patch, const Need& need) const {
    const auto ask = [&](PatchId id) {
      if (surface.patches[id].height_block != kNoHeights) need(surface.patches[id].height_block);
    };
    ask(patch);
    for (int corner = 0; corner < 4; ++corner) {
      PatchCorner fan[kMaxCornerFan];
      const int count = corner_fan(surface.patches, {patch, corner}, fan);
      for (int i = 1; i < count; ++i) ask(fan[i].patch);
    }
  }
};

// Bytes of a PatchScratch, for the budget, and its construction in caller-supplied memory (aligned to 64
// bytes).
std::size_t patch_scratch_bytes();
PatchScratch* make_patch_scratch(std::span<std::byte> memory);

}  // namespace karst::core
