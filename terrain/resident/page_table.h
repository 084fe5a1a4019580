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

// What vertex shaders learn of a page, as a texel of four unsigned integers; gles_shaders/interface.glsl.
// What lies in a page has a *size*: its lattice step is 2^size steps, its voxel 2^size voxels. Patches have
// size 0, nodes of the ground their own (terrain/ground/ground.h).
struct PageTexel {
  // The origin in voxels of the size, two's complement: of x and z all 32 bits; of y 26, above which lie the
  // size, 5 bits, and one for what may be a cave.
  std::uint32_t x = 0;
  std::uint32_t z = 0;
  std::uint32_t y_size = 0;
  std::uint32_t place = 0;  // of the page in its chain, 8 bits; the morph row, 20 bits; 4 bits for the one
                            // material that all of it has plus 1, or 0

  friend bool operator==(const PageTexel&, const PageTexel&) = default;
};
inline constexpr std::uint32_t kMostMorphRows = 1u << 20;
inline constexpr std::uint32_t kMostPlaces = 256;  // of pages in a chain, and what nodes have instead
// The place of pages of meshes, in which nothing morphs (terrain/blocks).
inline constexpr std::uint32_t kMeshPlace = 251;
inline constexpr int kMostPageSize = 20;                  // shaders' positions are exact up to it
inline constexpr std::int32_t kMostPageHeight = 1 << 25;  // y of an origin is within [-this, this)
static_assert(sizeof(PageTexel) == 16);
static_assert(kMostSlotPages <= kMeshPlace, "what a texel has bits for");

// Precondition: origin.y within +-kMostPageHeight, size within 0..kMostPageSize, place below kMostPlaces, row
// below kMostMorphRows, material below 16.
constexpr PageTexel make_page_texel(glm::ivec3 origin, int size, std::uint32_t place, std::uint32_t row,
                                    std::uint32_t material, bool cave) {
  KARST_ASSERT(origin.y >= -kMostPageHeight && origin.y < kMostPageHeight);
  KARST_ASSERT(size >= 0 && size <= kMostPageSize);
  KARST_ASSERT(place < kMostPlaces && row < kMostMorphRows && material < 16);
  const auto bits = [](int v) { return static_cast<std::uint32_t>(v); };
  return {bits(origin.x), bits(origin.z),
          (bits(origin.y) & 0x3ffffffu) | bits(size) << 26 | std::uint32_t{cave} << 31,
          place | row << 8 | material << 28};
}

struct PageTable {
  std::span<const std::uint32_t> first_page;  // by patch
  std::span<const std::uint32_t> next_page;   // by page
  // By page, as many as next_page: memory that is lent to the renderer, which alone writes and reads it.
  std::span<PageTexel> texels;
  // The same of the pages of families, which lie behind them: by page's number among those.
  std::span<PageTexel> family_texels = {};
  // Where those pages lie among images: x, z: the node's, y_size: its size. By the same number, or empty.
  std::span<PageTexel> family_places = {};
  // The same of the pages of meshes, behind all others.
  std::span<PageTexel> mesh_texels = {};
};

}  // namespace karst::core
