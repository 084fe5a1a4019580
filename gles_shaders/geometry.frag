#version 300 es
// SPDX-License-Identifier: MIT
// What is seen in a pixel, for screen.frag to shade once: a pixel of small triangles is shaded several times
// otherwise, because GPUs shade blocks of pixels and throw away what lies outside a triangle.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "geometry.glsl"
#include "cull.glsl"
#ifdef KARST_VOXEL_MATERIALS
#define KARST_VOXEL_PIXEL
#include "voxel_materials.glsl"
#endif

in vec3 normal_ws;
flat in uint patch_bits;

layout(location = 0) out uvec2 geometry;
#ifdef KARST_VOXEL_MATERIALS
layout(location = 1) out uint voxels;
#endif

void main() {
  cull_back_face();
  geometry = uvec2(pack_normal(normal_ws) | patch_bits, floatBitsToUint(gl_FragCoord.w));
#ifdef KARST_VOXEL_MATERIALS
  voxels = pack_voxels();
#endif
}
