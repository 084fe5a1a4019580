// SPDX-License-Identifier: MIT
// Meshes that have indices of their own, as blocks of an isosurface have: where those lie, for the index
// stream. A mesh has a chain of pages of vertices, as a patch has (page_table.h), and a chain of pages of
// indices: 16 bits each, of the mesh's vertices.
#pragma once

#include <cstdint>
#include <span>

namespace karst::core {

inline constexpr std::uint32_t kIndexPage = 192;  // indices; whole triangles

constexpr std::uint32_t index_pages_for(std::uint32_t indices) {
  return (indices + kIndexPage - 1) / kIndexPage;
}

// A mesh as it is drawn. before: pages of indices of all items before it in its list.
struct MeshItem {
  std::uint32_t first_page = 0;
  std::uint32_t first_index_page = 0;
  std::uint32_t indices = 0;
  std::uint32_t before = 0;

  std::uint32_t index_pages() const { return index_pages_for(indices); }
  friend bool operator==(const MeshItem&, const MeshItem&) = default;
};

// first_page counts pages of vertices from first_vertex_page of the buffer on.
struct MeshPages {
  std::uint32_t first_vertex_page = 0;
  std::span<const std::uint32_t> next_page;        // by page of vertices
  std::span<const std::uint32_t> next_index_page;  // by page of indices
  std::span<const std::uint16_t> indices;          // kIndexPage a page
};

}  // namespace karst::core
