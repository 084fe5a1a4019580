// SPDX-License-Identifier: MIT
// The buffer of all patches' vertices, cut into pages; the texture that tells what lies in which page, and
// the one with rows of thresholds. What is uploaded reaches the GPU with flush().
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "renderer/gl/gl_device.h"
#include "renderer/input/shader_interface.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/resident/page_table.h"
#include "terrain/shading/patch_shading.h"
#include "terrain/surface/patch.h"

namespace karst::core {

struct RendererSettings;

// Sizes of the textures that vertex shaders look pages, morph entries and morph rows up in; interface.glsl
// says what lies where. Texels of a row of the textures that are looked up by page, by vertex of a slot and
// by patch.
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

class VertexPages {
 public:
  void create(const RendererSettings& settings);

  // Renderer::upload_vertices and upload_morph_rows; frames that may still draw the pages are complete.
  Status upload(const GlDevice& device, const PageTable& pages, PatchId patch, std::uint32_t first,
                std::span<const GpuVertex> vertices, glm::ivec3 origin, std::uint32_t row,
                PatchShading shading);
  Status upload_morph_rows(const GlDevice& device, std::uint32_t first_row,
                           std::span<const std::uint16_t> rows);

  // Makes uploads visible to what is drawn. False: the driver lost the buffer's contents.
  bool flush(const GlDevice& device, const PageTable& pages);

  // Bytes uploaded since it was asked last.
  std::uint64_t take_uploaded_bytes();

 private:
  static constexpr std::uint32_t kMostPageRows = kMostPages >> KARST_PAGE_ROW_BITS;

  Status check(const PageTable& pages, PatchId patch, std::uint32_t first, std::size_t vertices,
               glm::ivec3 origin, std::uint32_t row) const;
  bool map(const GlDevice& device);
  void upload_page_rows(const GlDevice& device, const PageTable& pages);

  std::uint32_t vertex_pages_ = 0;
  std::uint32_t morph_rows_ = 0;
  std::bitset<kMostPageRows> changed_page_rows_;  // rows of texels that the texture does not have yet
  GpuVertex* mapped_ = nullptr;                   // the whole vertex buffer, between an upload and flush()
  std::uint64_t uploaded_bytes_ = 0;
};

}  // namespace karst::core
