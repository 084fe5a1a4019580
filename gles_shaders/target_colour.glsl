// SPDX-License-Identifier: MIT
// What is written to the host's framebuffer: after output.glsl.

vec4 target_colour(vec3 light) {
  if (view_scale.w > 0.0) return vec4(light, 1.0);
  return picture_colour(light);
}
