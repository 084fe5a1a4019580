// SPDX-License-Identifier: MIT
// Passes into the shadow maps: one texture array, a layer a cascade. Both sides of the surface are drawn,
// because a world is open at its sides and below: light that comes in there must not pass through the ground
// from within.
#include "renderer/renderer.h"

namespace karst::core {

Status Renderer::create_shadow_maps() {
  const int count = settings_.cascades;
  if (count == 0) return {};
  gl_.GenTextures(1, &shadow_maps_);
  gl_.ActiveTexture(GL_TEXTURE0 + KARST_UNIT_SHADOW_MAPS);
  gl_.BindTexture(GL_TEXTURE_2D_ARRAY, shadow_maps_);
  gl_.TexStorage3D(GL_TEXTURE_2D_ARRAY, 1,
                   settings_.shadow_bits == 16 ? GL_DEPTH_COMPONENT16 : GL_DEPTH_COMPONENT24,
                   settings_.shadow_size, settings_.shadow_size, count);
  const auto set = [&](GLenum name, GLenum value) {
    gl_.TexParameteri(GL_TEXTURE_2D_ARRAY, name, static_cast<GLint>(value));
  };
  // Linear: the hardware mixes the results of four comparisons.
  set(GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  set(GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  set(GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  set(GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  set(GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  set(GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  gl_.GenFramebuffers(count, shadow_targets_);
  gl_.GenBuffers(count, cascade_buffers_);
  for (int layer = 0; layer < count; ++layer) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, shadow_targets_[layer]);
    gl_.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, shadow_maps_, 0, layer);
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      return {StatusCode::limit_reached, "the driver could not make a shadow map of this size",
              "shadow_size"};
    }
    gl_.BindBuffer(GL_UNIFORM_BUFFER, cascade_buffers_[layer]);
    gl_.BufferData(GL_UNIFORM_BUFFER, sizeof(shader::FrameBlock), nullptr, GL_DYNAMIC_DRAW);
  }
  return {};
}

Status Renderer::draw_cascade(int index, const CascadeInput& input) {
  if (index < 0 || index >= settings_.cascades) {
    return {StatusCode::invalid_argument, "none of the settings' cascades", "index"};
  }
  begin_frame(input.pages);
  if (pending_.vertices_lost) return {};
  push_group("shadow");
  shadow_timer_.begin(gl_);
  use_block(cascade_buffers_[index], make_cascade_block(input.cascade));
  gl_.BindFramebuffer(GL_FRAMEBUFFER, shadow_targets_[index]);
  gl_.Viewport(0, 0, settings_.shadow_size, settings_.shadow_size);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(GL_LESS);
  gl_.Disable(GL_CULL_FACE);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  gl_.UseProgram(programs_[ShaderVariant::depth_only]);
  const ExpandIndices expand{input.index_table, input.items, input.pages, {}};
  const Status status = draw_items(expand, input.max_level, pending_);
  shadow_timer_.end(gl_);
  pop_group();
  return status;
}

}  // namespace karst::core
