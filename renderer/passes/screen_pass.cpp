// SPDX-License-Identifier: MIT
#include "renderer/passes/screen_pass.h"

#include <glm/geometric.hpp>

#include "renderer/passes/terrain_pass.h"
#include "renderer/passes/terrain_variants.h"
#include "renderer/resources/object_table.h"

namespace karst::core {

void set_screen(const ViewInput& input, const DrawTarget& target, shader::FrameBlock& block) {
  const Camera& camera = input.camera;
  const auto row = [&block](int n) {
    const glm::mat4& m = block.clip_from_lattice;
    return glm::dvec4(m[0][n], m[1][n], m[2][n], m[3][n]);
  };
  constexpr double kSteps = kStepsPerVoxel;
  const double w_a_voxel = glm::length(glm::dvec3(row(3))) * kSteps;
  // Of places relative to the camera's voxel; at the eye it is not 0.
  const glm::dvec4 z = row(2);
  const double z_at_eye = glm::dot(glm::dvec3(z), glm::dvec3(camera.fine)) + z.w;
  block.screen_place = {target.viewport.x, target.viewport.y, target.sky ? 1 : 0,
                        target.viewport.width | target.viewport.height << 16};
  const float half = target.depth_zero_to_one ? 1.0f : 0.5f;
  block.screen_scale = {camera.parallel ? 0.0f : static_cast<float>(1.0 / w_a_voxel),
                        camera.reversed_depth ? 0.0f : 1.0f, half, 1.0f - half};
  if (const DepthRanges ranges = ranges_of(input, target); ranges.count == 2) {
    // Depth is x + y / w of the nearer range, z + w / w of the other one.
    block.screen_place.z |= 2;
    block.screen_scale.z = static_cast<float>(1.0 / ranges.far_of(0) / w_a_voxel);
    const auto start = [&](int n) { return 0.25 + 0.5 * n + 0.25 * ranges.a(n); };
    const auto slope = [&](int n) { return 0.25 * ranges.b(n) * w_a_voxel; };
    block.screen_depth = glm::vec4(start(0), slope(0), start(1), slope(1));
    return;
  }
  block.screen_depth = glm::vec4(glm::vec3(glm::dvec3(z) * kSteps), static_cast<float>(z_at_eye));
}

void draw_screen(const GlDevice& device, const RendererSettings& settings, const Programs& programs,
                 const ViewInput& input, const DrawTarget& target, FrameCounts& counts) {
  const Gl& gl = device.gl;
  device.push_group("screen");
  const Rect& view = target.viewport;
  gl.Viewport(view.x, view.y, view.width, view.height);
  const bool reversed = input.camera.reversed_depth;
  if (!settings.share_depth) {
    // The sky has the far plane's depth.
    gl.DepthFunc(reversed ? GL_GEQUAL : GL_LEQUAL);
  } else {
    // What is nearer than the far plane is terrain; with silhouettes the background is drawn too.
    const float far = reversed ? 0.0f : 1.0f;
    gl.DepthRangef(far, far);
    gl.DepthFunc(settings.smooth_edges ? GL_ALWAYS : reversed ? GL_LESS : GL_GREATER);
    gl.DepthMask(GL_FALSE);
  }
  gl.Disable(GL_CULL_FACE);
  gl.BindVertexArray(name_of(device, Object::no_attributes));
  gl.UseProgram(programs[variant_for(ShaderVariant::screen, frame_shading(input))]);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  device.pop_group();
  counts.draw_calls += 1;
  counts.triangles += 1;
}

}  // namespace karst::core
