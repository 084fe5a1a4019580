// SPDX-License-Identifier: MIT
// Where the vertices of patches lie on the GPU: in pages of kPageVertices of one buffer. A patch that is
// resident at level r has a chain of slot_pages(r) pages anywhere in the buffer; vertex v of its slot
// (gpu_vertex.h) lies in the chain's page v / kPageVertices. Raising r appends pages and moves nothing.
// Levels 1 and 2 take the same single page: whoever makes it resident writes both. The table is kept by
// whoever hands out pages; the renderer and the index stream read it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/check.h"
#include "terrain/base/config.h"
#include "terrain/base/lattice.h"

namespace karst::core {

// Ends a chain; as a patch's first page: not resident.
inline constexpr std::uint32_t kNoPage = 0xffffffffu;

constexpr std::uint32_t pages_for(std::size_t vertices) {
  return static_cast<std::uint32_t>((vertices + kPageVertices - 1) / kPageVertices);
}
// Pages that a patch takes at a level, 1..kMaxLevel.
constexpr std::uint32_t slot_pages(int level) {
  return pages_for(static_cast<std::size_t>(patch_vertices(level)));
}
inline constexpr std::uint32_t kMostSlotPages = slot_pages(kMaxLevel);

// What vertex shaders learn of a page, as a texel of two unsigned integers; gles_shaders/interface.glsl.
struct PageTexel {
  std::uint32_t origin =
      0;  // the patch's origin in voxels, 10 bits an axis, x lowest; bit 30: it may be a cave
  std::uint32_t place = 0;  // of the page in its chain, 8 bits; the patch's morph row, 20 bits; 4 bits for
                            // the material that all of the patch has plus 1, or 0

  friend bool operator==(const PageTexel&, const PageTexel&) = default;
};
inline constexpr std::uint32_t kMostMorphRows = 1u << 20;
static_assert(sizeof(PageTexel) == 8);
static_assert(kMostSlotPages <= 256 && (1 << kMaxDepth) < 1024, "what a texel has bits for");

// Precondition: origin within 0..1023, place below kMostSlotPages, row below kMostMorphRows, material
// below 16.
constexpr PageTexel make_page_texel(glm::ivec3 origin, std::uint32_t place, std::uint32_t row,
                                    std::uint32_t material, bool cave) {
  KARST_ASSERT(origin.x >> 10 == 0 && origin.y >> 10 == 0 && origin.z >> 10 == 0);
  KARST_ASSERT(place < kMostSlotPages && row < kMostMorphRows && material < 16);
  const auto axis = [](int v) { return static_cast<std::uint32_t>(v); };
  return {axis(origin.x) | axis(origin.y) << 10 | axis(origin.z) << 20 | std::uint32_t{cave} << 30,
          place | row << 8 | material << 28};
}

struct PageTable {
  std::span<const std::uint32_t> first_page;  // by patch
  std::span<const std::uint32_t> next_page;   // by page
  // By page, as many as next_page: memory that is lent to the renderer, which alone writes and reads it.
  std::span<PageTexel> texels;
};

}  // namespace karst::core
