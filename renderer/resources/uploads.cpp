// SPDX-License-Identifier: MIT
// What the renderer copies to the GPU between frames: vertices, texels of pages, rows of thresholds.
#include <algorithm>
#include <cstring>

#include "renderer/renderer.h"
#include "renderer/resources/texture_layout.h"

namespace karst::core {
namespace {

Status invalid(const char* what, const char* field, std::uint64_t value = 0) {
  return {StatusCode::invalid_argument, what, field, value};
}

}  // namespace

Status Renderer::check_upload(const PageTable& pages, PatchId patch, std::uint32_t first,
                              std::size_t vertices, glm::ivec3 origin, std::uint32_t row) const {
  if (patch >= pages.first_page.size()) return invalid("not a patch of the page table", "patch", patch);
  if (first >= static_cast<std::uint32_t>(patch_vertices(kMaxLevel)) ||
      vertices > static_cast<std::uint32_t>(patch_vertices(kMaxLevel)) - first || vertices == 0) {
    return invalid("not vertices of a slot", "vertices", vertices);
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (origin[axis] < 0 || origin[axis] > 1023) return invalid("not within 0..1023 voxels", "origin");
  }
  if (row >= settings_.morph_rows) return invalid("not a morph row", "row", row);
  std::uint32_t page = pages.first_page[patch];
  for (std::uint32_t n = 0; n < pages_for(first + vertices); ++n, page = pages.next_page[page]) {
    if (page >= settings_.vertex_pages || page >= pages.next_page.size() || page >= pages.texels.size()) {
      return invalid("has fewer pages in the buffer than its vertices need", "patch", patch);
    }
  }
  return {};
}

// One mapping for all uploads between two frames. Unsynchronised, because the frames that the GPU still draws
// do not use the pages that are written; flushed range by range, because a driver that has to copy what was
// mapped shall copy no more than was written.
bool Renderer::map_vertices() {
  if (mapped_ != nullptr) return true;
  wait_for_frame();
  gl_.BindBuffer(GL_ARRAY_BUFFER, vertex_buffer_);
  const auto bytes = static_cast<GLsizeiptr>(std::size_t{settings_.vertex_pages} * kPageBytes);
  mapped_ = static_cast<GpuVertex*>(gl_.MapBufferRange(
      GL_ARRAY_BUFFER, 0, bytes, GL_MAP_WRITE_BIT | GL_MAP_UNSYNCHRONIZED_BIT | GL_MAP_FLUSH_EXPLICIT_BIT));
  return mapped_ != nullptr;
}

Status Renderer::upload_vertices(const PageTable& pages, PatchId patch, std::uint32_t first,
                                 std::span<const GpuVertex> vertices, glm::ivec3 origin, std::uint32_t row,
                                 PatchShading shading) {
  if (shading.material > kMostMaterials) {
    return invalid("not a material plus 1", "shading", shading.material);
  }
  if (const Status status = check_upload(pages, patch, first, vertices.size(), origin, row); !status.ok())
    return status;
  if (!map_vertices())
    return {StatusCode::limit_reached, "the driver cannot map the vertex buffer", "GPU memory"};
  gl_.BindBuffer(GL_ARRAY_BUFFER, vertex_buffer_);

  std::size_t run_begins = 0;  // a run of vertices that lie side by side in the buffer, not flushed yet
  std::size_t run_ends = 0;
  const auto flush_run = [&] {
    if (run_begins == run_ends) return;
    gl_.FlushMappedBufferRange(GL_ARRAY_BUFFER, static_cast<GLintptr>(run_begins * sizeof(GpuVertex)),
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
        make_page_texel(origin, place, row, shading.material, (shading.needs & kShadeCave) != 0);
    changed_page_rows_.set(page >> KARST_PAGE_ROW_BITS);
    done += count;
  }
  flush_run();
  pending_.uploaded_bytes += vertices.size_bytes();
  return {};
}

Status Renderer::upload_morph_rows(std::uint32_t first_row, std::span<const std::uint16_t> rows) {
  const std::size_t count = rows.size() / kMorphRow;
  if (rows.size() % kMorphRow != 0 || first_row > settings_.morph_rows ||
      count > settings_.morph_rows - first_row) {
    return invalid("not within the settings' morph_rows", "rows", first_row + count);
  }
  gl_.ActiveTexture(GL_TEXTURE0 + KARST_UNIT_MORPH_ROWS);
  for (std::size_t done = 0; done < count;) {
    const std::size_t row = first_row + done;
    const std::size_t beside = std::min<std::size_t>(kPatchesPerRow - row % kPatchesPerRow, count - done);
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(row % kPatchesPerRow * kMorphRow),
                      static_cast<GLint>(row / kPatchesPerRow), static_cast<GLsizei>(beside * kMorphRow), 1,
                      GL_RED, GL_HALF_FLOAT, rows.data() + done * kMorphRow);
    done += beside;
  }
  pending_.uploaded_bytes += rows.size_bytes();
  return {};
}

// Whole rows of texels, because pages come in any order and a call costs more than a row.
void Renderer::upload_page_rows(const PageTable& pages) {
  gl_.ActiveTexture(GL_TEXTURE0 + KARST_UNIT_PAGE_TABLE);
  const auto rows = static_cast<std::size_t>(page_rows(settings_.vertex_pages));
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t first = row << KARST_PAGE_ROW_BITS;
    if (!changed_page_rows_.test(row) || first >= pages.texels.size()) continue;
    const auto texels = pages.texels.subspan(first);
    const std::size_t count = std::min<std::size_t>(texels.size(), kPageRowTexels);
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, static_cast<GLint>(row), static_cast<GLsizei>(count), 1,
                      GL_RG_INTEGER, GL_UNSIGNED_INT, texels.data());
    pending_.uploaded_bytes += count * sizeof(PageTexel);
  }
  changed_page_rows_.reset();
}

void Renderer::flush_uploads(const PageTable& pages) {
  if (mapped_ != nullptr) {
    gl_.BindBuffer(GL_ARRAY_BUFFER, vertex_buffer_);
    pending_.vertices_lost = gl_.UnmapBuffer(GL_ARRAY_BUFFER) == GL_FALSE;
    mapped_ = nullptr;
  }
  if (changed_page_rows_.any()) upload_page_rows(pages);
}

}  // namespace karst::core
