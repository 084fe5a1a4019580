// SPDX-License-Identifier: MIT
// Sizes of the textures that vertex shaders look pages, morph entries and morph rows up in; interface.glsl
// says what lies where.
#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/shader_interface.h"
#include "terrain/patch/gpu_vertex.h"

namespace karst::core {

// Texels of a row of the textures that are looked up by page, by vertex of a slot and by patch.
inline constexpr int kPageRowTexels = 1 << KARST_PAGE_ROW_BITS;
inline constexpr int kEntryRowTexels = 1 << KARST_ENTRY_ROW_BITS;
inline constexpr int kEntryRows = (patch_vertices(kMaxLevel) + kEntryRowTexels - 1) / kEntryRowTexels;
inline constexpr int kPatchesPerRow = 1 << KARST_MORPH_ROW_BITS;

inline constexpr std::size_t kPageBytes = kPageVertices * sizeof(GpuVertex);

inline int page_rows(std::uint32_t pages) {
  return static_cast<int>((pages + kPageRowTexels - 1) / kPageRowTexels);
}
inline int morph_texture_rows(std::uint32_t patches) {
  return static_cast<int>((patches + kPatchesPerRow - 1) / kPatchesPerRow);
}

}  // namespace karst::core
