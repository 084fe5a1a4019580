#version 300 es
// SPDX-License-Identifier: MIT
precision highp float;
uniform highp sampler2D font;   // r: covered
uniform float opacity;
in vec4 vertex_colour;
in vec2 vertex_texel;
out vec4 colour;

void main() {
  float covered = texture(font, vertex_texel / vec2(textureSize(font, 0))).r;
  colour = vec4(vertex_colour.rgb, vertex_colour.a * covered * opacity);
}
