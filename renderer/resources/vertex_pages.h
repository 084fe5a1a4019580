// SPDX-License-Identifier: MIT
// The buffer of all vertices of patches, and behind them of nodes, cut into pages; the texture that tells
// what lies in which page, and the one with rows of thresholds. What is uploaded reaches the GPU with
// flush().
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "renderer/gl/gl_device.h"
#include "renderer/input/shader_interface.h"
#include "terrain/draw/mesh_items.h"
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
inline constexpr int kEntryRows = static_cast<int>(kMorphEntries) / kEntryRowTexels;
inline constexpr int kPatchesPerRow = 1 << KARST_MORPH_ROW_BITS;

inline constexpr std::size_t kPageBytes = kPageVertices * sizeof(GpuVertex);

inline int page_rows(std::uint32_t pages) {
  return static_cast<int>((pages + kPageRowTexels - 1) / kPageRowTexels);
}
// Places of nodes follow the pages' texels, from a row of their own on.
int page_table_rows(const RendererSettings& settings);
inline int morph_texture_rows(std::uint32_t patches) {
  return static_cast<int>((patches + kPatchesPerRow - 1) / kPatchesPerRow);
}

// What a page of a node holds besides its vertices.
struct NodePage {
  glm::ivec3 origin{0};       // voxels of its size; y within +-kMostPageHeight
  int size = 0;               // 0..kMostPageSize
  int quadrant = 0;           // of its family, 0..3 (NodeKey::quadrant)
  NodeKey key = {};           // used where the settings' has_node_places()
  std::uint32_t row = 0;      // of its family, from ViewInput::first_family_row on
  std::uint8_t material = 0;  // the one that all of it has plus 1, or 0
  bool cave = false;          // it may be a cave or lit by lamps
};

// What pages of a mesh hold besides its vertices, which are where they are: nothing morphs.
struct MeshPage {
  std::uint32_t first_page = 0;  // of its chain, among the settings' mesh_pages
  glm::ivec3 origin{0};          // voxels of its size; y within +-kMostPageHeight
  int size = 0;                  // 0..kMostPageSize
};

class VertexPages {
 public:
  void create(const RendererSettings& settings);

  // Renderer::upload_vertices, upload_node, upload_mesh and upload_morph_rows; frames that may still draw the
  // pages are complete.
  Status upload(const GlDevice& device, const PageTable& pages, PatchId patch, std::uint32_t first,
                std::span<const GpuVertex> vertices, glm::ivec3 origin, std::uint32_t row,
                PatchShading shading);
  Status upload_shading(const PageTable& pages, PatchId patch, std::uint32_t vertices, glm::ivec3 origin,
                        std::uint32_t row, PatchShading shading);
  Status upload_node(const GlDevice& device, const PageTable& pages, std::uint32_t page, const NodePage& node,
                     std::span<const GpuVertex, kNodePageVertices> vertices);
  Status upload_mesh(const GlDevice& device, const PageTable& pages, const MeshPages& chain,
                     const MeshPage& mesh, std::span<const GpuVertex> vertices);
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
  // Maps the buffer and leaves it bound.
  Status map(const GlDevice& device);
  void upload_page_rows(const GlDevice& device, const PageTable& pages);
  void upload_texels(const GlDevice& device, std::size_t row, std::size_t first_page,
                     std::span<const PageTexel> texels);

  std::uint32_t vertex_pages_ = 0;
  std::uint32_t family_pages_ = 0;
  std::uint32_t mesh_pages_ = 0;
  bool has_node_places_ = false;
  std::uint32_t morph_rows_ = 0;                  // of patches
  std::uint32_t all_rows_ = 0;                    // and of families
  std::bitset<kMostPageRows> changed_page_rows_;  // rows of texels that the texture does not have yet
  GpuVertex* mapped_ = nullptr;                   // the whole vertex buffer, between an upload and flush()
  std::uint64_t uploaded_bytes_ = 0;
};

}  // namespace karst::core
