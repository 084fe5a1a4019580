#version 300 es
// SPDX-License-Identifier: MIT
// Terrain under an image: its colours are taken as they are, and light scales them. KARST_LINEAR: for targets
// that take light.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "cull.glsl"

uniform highp sampler2D drape;

in vec3 drape_light;
out vec4 colour;

#ifdef KARST_LINEAR
// IEC 61966-2-1.
vec3 decode_srgb(vec3 shown) {
  return mix(shown / 12.92, pow((shown + 0.055) / 1.055, vec3(2.4)), step(0.04045, shown));
}
#endif

void main() {
  cull_back_face();
  vec3 shown = texture(drape, drape_light.xy).rgb * drape_light.z;
#ifdef KARST_LINEAR
  shown = decode_srgb(shown);
#endif
  colour = vec4(shown, 1.0);
}
