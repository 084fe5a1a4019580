#version 300 es
// SPDX-License-Identifier: MIT
layout(location = 0) in vec4 clip;
layout(location = 1) in vec4 colour;
layout(location = 2) in vec2 texel;
out vec4 vertex_colour;
out vec2 vertex_texel;

void main() {
  gl_Position = clip;
  vertex_colour = colour;
  vertex_texel = texel;
}
