#version 300 es
// SPDX-License-Identifier: MIT
// A terrain vertex: from 16 bytes to clip space.
//
// Positions stay exact (design 4.3): the patch's origin minus the camera's voxel is subtracted in integers;
// `offset` and the vertex are whole numbers of lattice steps, so offset + q is the same real number
// correctly rounded in every patch that has the vertex, and with `invariant` so is gl_Position: no crack
// can open.
precision highp float;
precision highp int;
precision highp isampler2D;
#include "interface.glsl"
#include "octahedral.glsl"

layout(location = KARST_LOCATION_POSITION) in ivec4 position_normal;

uniform isampler2D page_origins;  // xyz: origin of the patch that a page belongs to, voxels

invariant gl_Position;
out vec3 normal_ws;
out vec3 from_eye_ws;           // voxels
out vec3 in_patch;              // voxels from the patch's origin, +-4
flat out ivec3 patch_voxel;     // the patch's origin, voxels from the octree's minimum corner

void main() {
  int page = gl_VertexID >> KARST_PAGE_BITS;
  ivec2 texel = ivec2(page & ((1 << KARST_PAGE_ROW_BITS) - 1), page >> KARST_PAGE_ROW_BITS);
  ivec3 origin = texelFetch(page_origins, texel, 0).xyz;
  vec3 q = vec3(position_normal.xyz);
  vec3 offset = vec3(origin - camera_voxel.xyz) * KARST_STEPS_PER_VOXEL;
  vec3 p = offset + q;
  gl_Position = clip_from_lattice * vec4(p, 1.0);

  normal_ws = octahedral_decode(position_normal.w);
  from_eye_ws = (p - camera_fine.xyz) / KARST_STEPS_PER_VOXEL;
  in_patch = q / KARST_STEPS_PER_VOXEL;
  patch_voxel = origin;
}
