#version 300 es
// SPDX-License-Identifier: MIT
// OpenGL ES cannot read a depth buffer back; this writes its 24 bits into the bytes of a colour buffer,
// high byte in red.
precision highp float;
precision highp int;
precision highp sampler2D;
#include "interface.glsl"

uniform sampler2D depth;

out vec4 colour;

void main() {
  highp uint bits = uint(round(texelFetch(depth, ivec2(gl_FragCoord.xy), 0).x * 16777215.0));
  colour = vec4(uvec4(bits >> 16, bits >> 8, bits, 255u) & 255u) / 255.0;
}
