#version 300 es
// SPDX-License-Identifier: MIT
// One triangle that covers the picture, without attributes. The range of depths says how far it is.
precision highp float;
precision highp int;
#include "interface.glsl"

out vec3 ray_ws;  // view ray of the pixel, not normalised

void main() {
  vec2 ndc = vec2((gl_VertexID & 1) << 2, (gl_VertexID & 2) << 1) - 1.0;
  gl_Position = vec4(ndc, 0.0, 1.0);
  ray_ws = ray_forward.xyz + ndc.x * ray_right.xyz + ndc.y * ray_up.xyz;
}
