// SPDX-License-Identifier: MIT
#include "renderer/resources/vertex_pages.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "renderer/gl/gl_state.h"
#include "renderer/resources/object_table.h"
#include "terrain/lod/morph.h"

namespace karst::core {
namespace {

Status invalid(const char* what, const char* field, std::uint64_t value = 0) {
  return {StatusCode::invalid_argument, what, field, value};
}

bool is_page_height(int y) {
  return y >= -kMostPageHeight && y < kMostPageHeight;
}

}  // namespace

int page_table_rows(const RendererSettings& settings) {
  return page_rows(settings.all_pages()) * (settings.has_node_places() ? 2 : 1);
}

void VertexPages::create(const RendererSettings& settings) {
  vertex_pages_ = settings.vertex_pages;
  family_pages_ = settings.family_pages;
  mesh_pages_ = settings.mesh_pages;
  has_node_places_ = settings.has_node_places();
  morph_rows_ = settings.morph_rows;
  all_rows_ = settings.all_rows();
  changed_page_rows_.reset();
  mapped_ = nullptr;
  uploaded_bytes_ = 0;
}

Status VertexPages::check(const PageTable& pages, PatchId patch, std::uint32_t first, std::size_t vertices,
                          glm::ivec3 origin, std::uint32_t row) const {
  if (patch >= pages.first_page.size()) return invalid("not a patch of the page table", "patch", patch);
  if (first >= static_cast<std::uint32_t>(patch_vertices(kMaxLevel)) ||
      vertices > static_cast<std::uint32_t>(patch_vertices(kMaxLevel)) - first || vertices == 0) {
    return invalid("not vertices of a slot", "vertices", vertices);
  }
  if (!is_page_height(origin.y)) return invalid("higher or lower than a page may be", "origin");
  if (row >= morph_rows_) return invalid("not a morph row", "row", row);
  std::uint32_t page = pages.first_page[patch];
  for (std::uint32_t n = 0; n < pages_for(first + vertices); ++n, page = pages.next_page[page]) {
    if (page >= vertex_pages_ || page >= pages.next_page.size() || page >= pages.texels.size()) {
      return invalid("has fewer pages in the buffer than its vertices need", "patch", patch);
    }
  }
  return {};
}

// One mapping for all uploads between two frames. Unsynchronised, because the frames that the GPU still draws
// do not use the pages that are written; flushed range by range, because a driver that has to copy what was
// mapped shall copy no more than was written.
Status VertexPages::map(const GlDevice& device) {
  device.gl.BindBuffer(GL_ARRAY_BUFFER, name_of(device, Object::vertices));
  if (mapped_ != nullptr) return {};
  const auto bytes =
      static_cast<GLsizeiptr>(std::size_t{vertex_pages_ + family_pages_ + mesh_pages_} * kPageBytes);
  mapped_ = static_cast<GpuVertex*>(device.gl.MapBufferRange(
      GL_ARRAY_BUFFER, 0, bytes, GL_MAP_WRITE_BIT | GL_MAP_UNSYNCHRONIZED_BIT | GL_MAP_FLUSH_EXPLICIT_BIT));
  if (mapped_ != nullptr) return {};
  device.gl.BindBuffer(GL_ARRAY_BUFFER, 0);
  return {StatusCode::limit_reached, "the driver cannot map the vertex buffer", "GPU memory"};
}

Status VertexPages::upload(const GlDevice& device, const PageTable& pages, PatchId patch, std::uint32_t first,
                           std::span<const GpuVertex> vertices, glm::ivec3 origin, std::uint32_t row,
                           PatchShading shading) {
  if (shading.material > kMostMaterials) {
    return invalid("not a material plus 1", "shading", shading.material);
  }
  if (const Status status = check(pages, patch, first, vertices.size(), origin, row); !status.ok())
    return status;
  if (const Status status = map(device); !status.ok()) return status;

  std::size_t run_begins = 0;  // a run of vertices that lie side by side in the buffer, not flushed yet
  std::size_t run_ends = 0;
  const auto flush_run = [&] {
    if (run_begins == run_ends) return;
    device.gl.FlushMappedBufferRange(GL_ARRAY_BUFFER, static_cast<GLintptr>(run_begins * sizeof(GpuVertex)),
                                     static_cast<GLsizeiptr>((run_ends - run_begins) * sizeof(GpuVertex)));
  };
  std::uint32_t page = pages.first_page[patch];
  std::uint32_t place = 0;
  for (; place < first / kPageVertices; ++place) page = pages.next_page[page];
  for (std::size_t done = 0; done < vertices.size(); ++place, page = pages.next_page[page]) {
    const std::size_t skipped = done == 0 ? first % kPageVertices : 0;
    const std::size_t count = std::min(vertices.size() - done, kPageVertices - skipped);
    const std::size_t to = std::size_t{page} * kPageVertices + skipped;
    std::memcpy(mapped_ + to, vertices.data() + done, count * sizeof(GpuVertex));
    if (to != run_ends) {
      flush_run();
      run_begins = to;
    }
    run_ends = to + count;
    pages.texels[page] =
        make_page_texel(origin, 0, place, row, shading.material, (shading.needs & kShadeCave) != 0);
    changed_page_rows_.set(page >> KARST_PAGE_ROW_BITS);
    done += count;
  }
  flush_run();
  device.gl.BindBuffer(GL_ARRAY_BUFFER, 0);
  uploaded_bytes_ += vertices.size_bytes();
  return {};
}

Status VertexPages::upload_shading(const PageTable& pages, PatchId patch, std::uint32_t vertices,
                                   glm::ivec3 origin, std::uint32_t row, PatchShading shading) {
  if (shading.material > kMostMaterials) {
    return invalid("not a material plus 1", "shading", shading.material);
  }
  if (const Status status = check(pages, patch, 0, vertices, origin, row); !status.ok()) return status;
  std::uint32_t page = pages.first_page[patch];
  for (std::uint32_t place = 0; place < pages_for(vertices); ++place, page = pages.next_page[page]) {
    pages.texels[page] =
        make_page_texel(origin, 0, place, row, shading.material, (shading.needs & kShadeCave) != 0);
    changed_page_rows_.set(page >> KARST_PAGE_ROW_BITS);
  }
  return {};
}

Status VertexPages::upload_node(const GlDevice& device, const PageTable& pages, std::uint32_t page,
                                const NodePage& node,
                                std::span<const GpuVertex, kNodePageVertices> vertices) {
  if (page >= family_pages_ || page >= pages.family_texels.size())
    return invalid("not a page of the families", "page", page);
  if (!is_page_height(node.origin.y)) return invalid("higher or lower than a page may be", "origin");
  if (node.size < 0 || node.size > kMostPageSize) return invalid("not within 0..20", "size");
  if (node.quadrant < 0 || node.quadrant > 3) return invalid("not within 0..3", "quadrant");
  if (has_node_places_ && page >= pages.family_places.size())
    return invalid("not a page of the families' places", "page", page);
  if (node.row >= all_rows_ - morph_rows_) return invalid("not a row of the families", "row", node.row);
  if (node.material > kMostMaterials) return invalid("not a material plus 1", "material", node.material);
  if (const Status status = map(device); !status.ok()) return status;
  const std::size_t in_buffer = std::size_t{vertex_pages_} + page;
  const std::size_t to = in_buffer * kPageVertices;
  std::memcpy(mapped_ + to, vertices.data(), vertices.size_bytes());
  device.gl.FlushMappedBufferRange(GL_ARRAY_BUFFER, static_cast<GLintptr>(to * sizeof(GpuVertex)),
                                   static_cast<GLsizeiptr>(vertices.size_bytes()));
  device.gl.BindBuffer(GL_ARRAY_BUFFER, 0);
  pages.family_texels[page] =
      make_page_texel(node.origin, node.size, kFirstGroundPlace + static_cast<std::uint32_t>(node.quadrant),
                      node.row, node.material, node.cave);
  if (has_node_places_) {
    pages.family_places[page] = {static_cast<std::uint32_t>(node.key.x),
                                 static_cast<std::uint32_t>(node.key.z),
                                 static_cast<std::uint32_t>(node.key.size), 0};
  }
  changed_page_rows_.set(in_buffer >> KARST_PAGE_ROW_BITS);
  uploaded_bytes_ += vertices.size_bytes();
  return {};
}

Status VertexPages::upload_mesh(const GlDevice& device, const PageTable& pages, const MeshPages& chain,
                                const MeshPage& mesh, std::span<const GpuVertex> vertices) {
  if (!is_page_height(mesh.origin.y)) return invalid("higher or lower than a page may be", "origin");
  if (mesh.size < 0 || mesh.size > kMostPageSize) return invalid("not within 0..20", "size");
  std::uint32_t page = mesh.first_page;
  for (std::uint32_t n = 0; n < pages_for(vertices.size()); ++n, page = chain.next_page[page]) {
    if (page >= mesh_pages_ || page >= chain.next_page.size() || page >= pages.mesh_texels.size())
      return invalid("has fewer pages in the buffer than its vertices need", "page", page);
  }
  if (const Status status = map(device); !status.ok()) return status;
  page = mesh.first_page;
  for (std::size_t done = 0; done < vertices.size(); page = chain.next_page[page]) {
    const std::size_t count = std::min<std::size_t>(vertices.size() - done, kPageVertices);
    const std::size_t in_buffer = std::size_t{vertex_pages_} + family_pages_ + page;
    const std::size_t to = in_buffer * kPageVertices;
    std::memcpy(mapped_ + to, vertices.data() + done, count * sizeof(GpuVertex));
    device.gl.FlushMappedBufferRange(GL_ARRAY_BUFFER, static_cast<GLintptr>(to * sizeof(GpuVertex)),
                                     static_cast<GLsizeiptr>(count * sizeof(GpuVertex)));
    pages.mesh_texels[page] = make_page_texel(mesh.origin, mesh.size, kMeshPlace, 0, 0, false);
    changed_page_rows_.set(in_buffer >> KARST_PAGE_ROW_BITS);
    done += count;
  }
  device.gl.BindBuffer(GL_ARRAY_BUFFER, 0);
  uploaded_bytes_ += vertices.size_bytes();
  return {};
}

Status VertexPages::upload_morph_rows(const GlDevice& device, std::uint32_t first_row,
                                      std::span<const std::uint16_t> rows) {
  const std::size_t count = rows.size() / kMorphRow;
  if (rows.size() % kMorphRow != 0 || first_row > all_rows_ || count > all_rows_ - first_row) {
    return invalid("not within the settings' morph_rows and family_rows", "rows", first_row + count);
  }
  enter_upload(device);
  device.gl.BindTexture(GL_TEXTURE_2D, name_of(device, Object::morph_rows));
  for (std::size_t done = 0; done < count;) {
    const std::size_t row = first_row + done;
    const std::size_t beside = std::min<std::size_t>(kPatchesPerRow - row % kPatchesPerRow, count - done);
    device.gl.TexSubImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(row % kPatchesPerRow * kMorphRow),
                            static_cast<GLint>(row / kPatchesPerRow),
                            static_cast<GLsizei>(beside * kMorphRow), 1, GL_RED, GL_HALF_FLOAT,
                            rows.data() + done * kMorphRow);
    done += beside;
  }
  device.gl.BindTexture(GL_TEXTURE_2D, 0);
  leave_upload(device);
  uploaded_bytes_ += rows.size_bytes();
  return {};
}

// Whole rows of texels, because pages come in any order and a call costs more than a row.
void VertexPages::upload_page_rows(const GlDevice& device, const PageTable& pages) {
  enter_upload(device);
  device.gl.BindTexture(GL_TEXTURE_2D, name_of(device, Object::page_table));
  const auto rows = static_cast<std::size_t>(page_rows(vertex_pages_ + family_pages_ + mesh_pages_));
  for (std::size_t row = 0; row < rows; ++row) {
    if (!changed_page_rows_.test(row)) continue;
    upload_texels(device, row, 0, pages.texels);
    upload_texels(device, row, vertex_pages_, pages.family_texels);
    upload_texels(device, row, std::size_t{vertex_pages_} + family_pages_, pages.mesh_texels);
    if (has_node_places_)
      upload_texels(device, rows + row, rows * kPageRowTexels + vertex_pages_, pages.family_places);
  }
  device.gl.BindTexture(GL_TEXTURE_2D, 0);
  leave_upload(device);
  changed_page_rows_.reset();
}

// What a row of the texture has of texels that begin at a page.
void VertexPages::upload_texels(const GlDevice& device, std::size_t row, std::size_t first_page,
                                std::span<const PageTexel> texels) {
  const std::size_t begin = std::max(row << KARST_PAGE_ROW_BITS, first_page);
  const std::size_t end = std::min((row + 1) << KARST_PAGE_ROW_BITS, first_page + texels.size());
  if (begin >= end) return;
  device.gl.TexSubImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(begin % kPageRowTexels),
                          static_cast<GLint>(row), static_cast<GLsizei>(end - begin), 1, GL_RGBA_INTEGER,
                          GL_UNSIGNED_INT, texels.data() + (begin - first_page));
  uploaded_bytes_ += (end - begin) * sizeof(PageTexel);
}

bool VertexPages::flush(const GlDevice& device, const PageTable& pages) {
  bool intact = true;
  if (mapped_ != nullptr) {
    device.gl.BindBuffer(GL_ARRAY_BUFFER, name_of(device, Object::vertices));
    intact = device.gl.UnmapBuffer(GL_ARRAY_BUFFER) != GL_FALSE;
    device.gl.BindBuffer(GL_ARRAY_BUFFER, 0);
    mapped_ = nullptr;
  }
  if (changed_page_rows_.any()) upload_page_rows(device, pages);
  return intact;
}

std::uint64_t VertexPages::take_uploaded_bytes() {
  return std::exchange(uploaded_bytes_, 0);
}

}  // namespace karst::core
