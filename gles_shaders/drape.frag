#version 300 es
// SPDX-License-Identifier: MIT
// Terrain under an image: its colours are taken as they are, and light scales them.
precision highp float;
precision highp int;
#include "interface.glsl"

uniform highp sampler2D drape;

in vec3 drape_light;
out vec4 colour;

void main() { colour = vec4(texture(drape, drape_light.xy).rgb * drape_light.z, 1.0); }
