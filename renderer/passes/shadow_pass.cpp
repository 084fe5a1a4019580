// SPDX-License-Identifier: MIT
#include "renderer/passes/shadow_pass.h"

#include "renderer/gl/gl_state.h"
#include "renderer/resources/index_stream.h"
#include "renderer/resources/object_table.h"

namespace karst::core {
namespace {

// The host draws with depth test and viewport set; then the state is whatever it likes.
void draw_host_casters(const GlDevice& device, const CascadeInput& input) {
  if (input.draw_more == nullptr) return;
  unbind_textures(device);
  reset_state(device);
  device.gl.Enable(GL_DEPTH_TEST);
  input.draw_more(input.user);
}

}  // namespace

Status draw_shadow_map(const GlDevice& device, const RendererSettings& settings, const Programs& programs,
                       int index, const CascadeInput& input, FrameCounts& counts) {
  const Gl& gl = device.gl;
  device.push_group("shadow");
  shader::FrameBlock block = make_cascade_block(input.cascade);
  block.first_rows.x = static_cast<int>(input.first_morph_row);
  block.first_rows.y = static_cast<int>(input.first_family_row);
  block.camera_fine.w = foot_from(input.cascade.eye, input.foot);
  set_level({.view = input.level}, block);
  use_block(device, nth(Object::cascade_block_0, index), KARST_BINDING_FRAME, as_bytes(block));
  gl.BindFramebuffer(GL_FRAMEBUFFER, name_of(device, nth(Object::shadow_target_0, index)));
  DrawState state;
  state.viewport = {0, 0, settings.shadow_size, settings.shadow_size};
  state.cull = false;
  enter_draw(device, state);
  const GLfloat far = 1.0f;
  gl.ClearBufferfv(GL_DEPTH, 0, &far);
  bind_textures(device);
  gl.UseProgram(programs[ShaderVariant::depth_only]);
  const Status status = draw_items(device, expand_of(settings, input), input.max_level, counts);
  if (status.ok()) draw_host_casters(device, input);
  device.pop_group();
  return status;
}

}  // namespace karst::core
