// SPDX-License-Identifier: MIT
#include "renderer/resources/index_stream.h"

#include <algorithm>

#include "renderer/resources/object_table.h"
#include "terrain/ground/ground.h"

namespace karst::core {

Status draw_items(const GlDevice& device, ExpandIndices expand, int max_level, FrameCounts& counts) {
  if (expand.count() == 0) return {};
  if (!expand.nodes.empty()) max_level = std::max(max_level, kNodeLevel);
  const Gl& gl = device.gl;
  gl.BindVertexArray(name_of(device, Object::terrain_array));
  const std::size_t bytes = device.objects.bytes(row_of(Object::stream_indices));
  for (ExpandIndices::Chunk chunk; chunk.next_item < expand.count();) {
    // Invalidating lets the driver give fresh memory while the GPU still reads the last chunk.
    void* mapped = gl.MapBufferRange(GL_ELEMENT_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(bytes),
                                     GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
    if (mapped == nullptr)
      return {StatusCode::limit_reached, "the driver cannot map the index stream", "GPU memory"};
    expand.out = {static_cast<std::uint32_t*>(mapped), bytes / sizeof(std::uint32_t)};
    const Status status = chunk.next_item == 0 ? expand.validate(max_level) : Status();
    if (status.ok()) chunk = expand.run(chunk.next_item);
    const bool intact = gl.UnmapBuffer(GL_ELEMENT_ARRAY_BUFFER) == GL_TRUE;
    if (!status.ok()) return status;
    counts.left_out += chunk.left_out;
    // What was written is lost where a driver says so (a change of the screen's mode): the next frame draws
    // it.
    if (!intact || chunk.indices == 0) continue;
    gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(chunk.indices), GL_UNSIGNED_INT, nullptr);
    counts.draw_calls += 1;
    counts.triangles += chunk.indices / 3;
  }
  return {};
}

}  // namespace karst::core
