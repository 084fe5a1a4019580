// SPDX-License-Identifier: MIT
#include "app/overlay/overlay.h"

#include <array>
#include <cstddef>

#include "app/common/gl/link_program.h"
#include "app/overlay/font.h"
#include "app/overlay/overlay_shaders.h"

namespace karst::app {

Status Overlay::create(const GlLoader& loader) {
  destroy();
  const char* missing = nullptr;
  KARST_OVERLAY_FUNCTIONS(KARST_GL_LOAD)
  if (missing != nullptr) return lacks_function(missing);
  created_ = true;
  if (!link_program(gl_, kOverlayVert, kOverlayFrag, program_)) {
    destroy();
    return {StatusCode::unsupported, "the driver rejects a shader", "overlay"};
  }
  opacity_ = gl_.GetUniformLocation(program_, "opacity");
  std::array<std::uint8_t, std::size_t{kFontWidth} * kFontHeight> atlas;
  make_font(atlas);
  gl_.GenTextures(1, &font_);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, font_);
  gl_.TexStorage2D(GL_TEXTURE_2D, 1, GL_R8, kFontWidth, kFontHeight);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kFontWidth, kFontHeight, GL_RED, GL_UNSIGNED_BYTE, atlas.data());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl_.BindTexture(GL_TEXTURE_2D, 0);
  gl_.GenVertexArrays(1, &array_);
  gl_.GenBuffers(1, &buffer_);
  gl_.BindVertexArray(array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffer_);
  constexpr GLsizei kStride = sizeof(OverlayVertex);
  const auto offset = [](std::size_t bytes) { return reinterpret_cast<const void*>(bytes); };
  gl_.VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(OverlayVertex, clip)));
  gl_.VertexAttribPointer(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, kStride, offset(offsetof(OverlayVertex, colour)));
  gl_.VertexAttribPointer(2, 2, GL_UNSIGNED_SHORT, GL_FALSE, kStride, offset(offsetof(OverlayVertex, texel)));
  for (const GLuint attribute : {0u, 1u, 2u}) gl_.EnableVertexAttribArray(attribute);
  gl_.BindVertexArray(0);
  gl_.BindBuffer(GL_ARRAY_BUFFER, 0);
  return {};
}

void Overlay::destroy() {
  if (!created_) return;
  gl_.DeleteProgram(program_);
  gl_.DeleteTextures(1, &font_);
  gl_.DeleteBuffers(1, &buffer_);
  gl_.DeleteVertexArrays(1, &array_);
  forget();
}

void Overlay::forget() {
  created_ = false;
  program_ = buffer_ = array_ = font_ = 0;
}

void Overlay::draw_vertices(std::span<const OverlayVertex> vertices, float opacity) {
  if (vertices.empty()) return;
  // A new store each time: the driver need not wait for what drew from the last one.
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size_bytes()), vertices.data(),
                 GL_STREAM_DRAW);
  gl_.Uniform1f(opacity_, opacity);
  gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices.size()));
}

void Overlay::draw(const OverlayMesh& mesh, const ViewState& view, bool two_ranges) {
  constexpr float kHidden = 0.25f;
  DepthRange ranges[2];
  std::uint32_t count = two_ranges ? depth_ranges(view, ranges) : 1;
  if (count == 1) ranges[0] = {};
  gl_.UseProgram(program_);
  gl_.BindVertexArray(array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffer_);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, font_);
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl_.DepthMask(GL_FALSE);
  for (const DepthRange& range : std::span(ranges).first(count)) {
    const std::vector<OverlayVertex> lines = mesh.lines(range);
    draw_vertices(lines, kHidden);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.DepthFunc(view.reversed_depth ? GL_GEQUAL : GL_LEQUAL);
    gl_.DepthRangef(range.buffer_near, range.buffer_far);
    draw_vertices(lines, 1);
    gl_.Disable(GL_DEPTH_TEST);
  }
  draw_vertices(mesh.screen(), 1);
  gl_.DepthRangef(0, 1);
  gl_.DepthFunc(GL_LESS);
  gl_.DepthMask(GL_TRUE);
  gl_.BlendFunc(GL_ONE, GL_ZERO);
  gl_.Disable(GL_BLEND);
  gl_.BindTexture(GL_TEXTURE_2D, 0);
  gl_.BindBuffer(GL_ARRAY_BUFFER, 0);
  gl_.BindVertexArray(0);
  gl_.UseProgram(0);
}

}  // namespace karst::app
