#version 300 es
// SPDX-License-Identifier: MIT
// Terrain shaded while it is drawn.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "output.glsl"
#include "target_colour.glsl"
#include "sky_colour.glsl"
#include "light.glsl"

in vec3 normal_ws;
in vec3 from_eye_ws;
in vec3 in_patch;
flat in ivec3 patch_voxel;
flat in ivec2 patch_shading;

out vec4 colour;

void main() {
  colour = target_colour(light_from(
      Point(normalize(normal_ws), from_eye_ws, patch_voxel, in_patch, patch_shading.x, patch_shading.y > 0)));
}
