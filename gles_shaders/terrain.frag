#version 300 es
// SPDX-License-Identifier: MIT
// Terrain shaded while it is drawn.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "output.glsl"
#include "target_colour.glsl"
#include "level.glsl"
#include "sky_colour.glsl"
#include "water.glsl"
#ifdef KARST_VOXEL_MATERIALS
#define KARST_VOXEL_PIXEL
#define KARST_AT_VOXELS , unpack_voxels(pack_voxels())
#else
#define KARST_AT_VOXELS
#endif
#include "light.glsl"
#include "cull.glsl"

in vec3 normal_ws;
in vec3 from_eye_ws;
in vec3 in_patch;
flat in ivec3 patch_voxel;
flat in ivec2 patch_shading;
#ifdef KARST_CURVED
in float height;
#ifdef KARST_IMAGERY
in vec2 image_place;
#define KARST_AT_HEIGHT , height, image_place
#else
#define KARST_AT_HEIGHT , height
#endif
#else
#define KARST_AT_HEIGHT
#endif

out vec4 colour;

void main() {
  cull_back_face();
  vec3 light = light_from(Point(normalize(normal_ws), from_eye_ws, patch_voxel, in_patch, patch_shading.x,
                                patch_shading.y > 0 KARST_AT_VOXELS KARST_AT_HEIGHT));
#ifdef KARST_SHOW_LOOKUPS
  // Red counts, for programs; blue says that it does.
  float many = float(lookups) / 20.0;
  float green = 255.0 * many * (1.0 - many);
  colour = vec4(float(lookups * KARST_LOOKUP_RED), green, KARST_LOOKUP_BLUE, 255.0) / 255.0;
#else
  colour = target_colour(light);
#endif
}
