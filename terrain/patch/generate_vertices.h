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

#include "terrain/base/status.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/surface.h"

namespace karst {

// Working memory of one run at a time; lives in the arena (Consumer::scratch).
struct PatchScratch;

struct GenerateVertices {
  // Inputs, borrowed.
  Surface surface;
  Heights heights;
  // 1..heights.level; vertices are those of the full level at stride 2^(heights.level - level).
  int level = 0;

  // Working memory, borrowed; one run at a time.
  PatchScratch* scratch = nullptr;

  Status validate() const;

  // out: patch_vertices(level) values in the order of gpu_vertex.h. bounds may be null.
  // Precondition: validate() is ok, patch < surface.patches.size(), out is long enough.
  void run(PatchId patch, std::span<GpuVertex> out, PatchBounds* bounds) const;
};

// Bytes of a PatchScratch, for the budget, and its construction in caller-supplied memory (aligned to 64
// bytes).
std::size_t patch_scratch_bytes();
PatchScratch* make_patch_scratch(std::span<std::byte> memory);

}  // namespace karst
