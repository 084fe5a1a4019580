// SPDX-License-Identifier: MIT
#include "renderer/passes/sky_pass.h"

#include "renderer/resources/object_table.h"

namespace karst::core {

bool sees_edge(const RendererSettings& settings, const ViewInput& input, std::uint32_t vertices) {
  // The rim strays from the sides by less than this.
  constexpr int kStrays = 4;  // voxels
  const glm::ivec3 eye = input.camera.voxel;
  const bool inside = eye.x >= kStrays && eye.x < settings.extent.x - kStrays && eye.z >= kStrays &&
                      eye.z < settings.extent.z - kStrays;
  return vertices > 0 && input.show == Show::materials && (!inside || input.camera.parallel);
}

void draw_edge(const GlDevice& device, const Programs& programs, ShaderVariant variant,
               std::uint32_t vertices, FrameCounts& counts) {
  const Gl& gl = device.gl;
  device.push_group("edge");
  gl.BindVertexArray(name_of(device, Object::rim_array));
  gl.UseProgram(programs[variant]);
  gl.DrawArrays(GL_TRIANGLE_STRIP, 0, static_cast<GLsizei>(vertices));
  device.pop_group();
  counts.draw_calls += 1;
  counts.triangles += vertices - 2;
}

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
