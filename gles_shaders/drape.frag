#version 300 es
// SPDX-License-Identifier: MIT
// Terrain under an image: its colours are taken as they are, and light scales them.
precision highp float;
precision highp int;
#include "interface.glsl"

uniform highp sampler2D drape;

in vec3 drape_light;
out vec4 colour;

// IEC 61966-2-1.
vec3 decode_srgb(vec3 shown) {
  return mix(shown / 12.92, pow((shown + 0.055) / 1.055, vec3(2.4)), step(0.04045, shown));
}

void main() {
  vec3 shown = texture(drape, drape_light.xy).rgb * drape_light.z;
  colour = vec4(view_scale.w > 0.0 ? decode_srgb(shown) : shown, 1.0);
}
