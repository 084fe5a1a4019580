// SPDX-License-Identifier: MIT
#include "renderer/passes/sky_pass.h"

#include "renderer/resources/object_table.h"

namespace karst::core {

void draw_sky(const GlDevice& device, const Programs& programs, bool reversed_depth, FrameCounts& counts) {
  const Gl& gl = device.gl;
  device.push_group("sky");
  // Whatever clip space's depth is, the triangle gets exactly the far plane's.
  const float far = reversed_depth ? 0.0f : 1.0f;
  gl.DepthRangef(far, far);
  gl.DepthFunc(GL_EQUAL);
  gl.DepthMask(GL_FALSE);
  gl.Disable(GL_CULL_FACE);
  gl.BindVertexArray(name_of(device, Object::no_attributes));
  gl.UseProgram(programs[ShaderVariant::sky]);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  device.pop_group();
  counts.draw_calls += 1;
  counts.triangles += 1;
}

}  // namespace karst::core
