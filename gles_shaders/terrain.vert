#version 300 es
// SPDX-License-Identifier: MIT
// A terrain vertex of the main pass.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "terrain_vertex.glsl"

out vec3 normal_ws;
out vec3 from_eye_ws;        // voxels
out vec3 in_patch;           // voxels from the page's origin, +-4 of its size
flat out ivec3 patch_voxel;  // the page's origin, voxels from the octree's minimum corner, modulo 2^32
flat out ivec2 patch_shading;  // x: material of all of the patch, or less than 0; y: 1 in caves, or 0
#ifdef KARST_CURVED
out float height;  // voxels above height 0: linear between vertices, where a chord's own falls below them
#endif
#if defined(KARST_CURVED) && defined(KARST_IMAGERY)
out vec2 image_place;
#endif
#ifdef KARST_SHOW_LEVELS
flat out int node_size;  // or a mesh's, or less than 0 of a patch
#endif

void main() {
  TerrainVertex v = read_terrain_vertex();
  gl_Position = clip_from_lattice * vec4(v.position, 1.0);
  normal_ws = morphed_normal(v.share);
  from_eye_ws = (v.position - camera_fine.xyz) / KARST_STEPS_PER_VOXEL;
  in_patch = v.in_patch / KARST_STEPS_PER_VOXEL;
  patch_voxel = v.patch_voxel;
  patch_shading = ivec2(v.material, v.cave);
#ifdef KARST_CURVED
  // Targets lie on chords.
  height = level_height((v.home - camera_fine.xyz) / KARST_STEPS_PER_VOXEL);
#endif
#if defined(KARST_CURVED) && defined(KARST_IMAGERY)
  image_place = v.image_place;
#endif
#ifdef KARST_SHOW_LEVELS
  node_size = v.node_size;
#endif
#ifdef KARST_VOXEL_MATERIALS
  put_voxels(v.voxels);
#endif
}
