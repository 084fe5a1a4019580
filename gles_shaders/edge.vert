#version 300 es
// SPDX-License-Identifier: MIT
// The wall around a world, from its rim down to the plain: renderer/resources/ground_objects.h. It is ground
// like any other, so its outputs are those of terrain.vert, or of geometry.vert (KARST_GEOMETRY).
precision highp float;
precision highp int;
#include "interface.glsl"
#include "place.glsl"
#include "level.glsl"
#ifdef KARST_VOXEL_MATERIALS
#define KARST_VOXEL_VERTEX
#include "voxel_materials.glsl"
#endif

layout(location = KARST_LOCATION_POSITION) in ivec4 rim;  // xyz: lattice steps; w: normal's yaw, 2^16 a turn

invariant gl_Position;

out vec3 normal_ws;
#ifdef KARST_GEOMETRY
flat out uint patch_bits;
#else
out vec3 from_eye_ws;
out vec3 in_patch;
flat out ivec3 patch_voxel;
flat out ivec2 patch_shading;
#ifdef KARST_CURVED
out float height;
#ifdef KARST_IMAGERY
out vec2 image_place;
#endif
#endif
#endif

void main() {
  vec3 position = place_in_page(page_reference(camera_voxel.xyz, 0, ivec3(0)), rim.xyz);
  gl_Position = clip_from_lattice * vec4(position, 1.0);
  float yaw = float(rim.w) * (6.283185307 / 65536.0);
  normal_ws = vec3(cos(yaw), 0.0, sin(yaw));
#ifdef KARST_VOXEL_MATERIALS
  put_voxels(0);
#endif
#ifdef KARST_GEOMETRY
  patch_bits = 0u;
#else
  from_eye_ws = (position - camera_fine.xyz) / KARST_STEPS_PER_VOXEL;
  in_patch = vec3(rim.xyz) / KARST_STEPS_PER_VOXEL;
  patch_voxel = ivec3(0);
  patch_shading = ivec2(-1, 0);
#ifdef KARST_CURVED
  height = level_height(from_eye_ws);
#ifdef KARST_IMAGERY
  image_place = vec2(0.0);
#endif
#endif
#endif
}
