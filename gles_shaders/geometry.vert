#version 300 es
// SPDX-License-Identifier: MIT
// A terrain vertex of the pass into the G-buffer.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "terrain_vertex.glsl"

out vec3 normal_ws;
flat out uint patch_bits;  // as geometry.glsl packs them

void main() {
  TerrainVertex v = read_terrain_vertex();
  gl_Position = clip_from_lattice * vec4(v.position, 1.0);
  normal_ws = morphed_normal(v.share);
  patch_bits = uint(v.material + 1) << KARST_GEOMETRY_MATERIAL_SHIFT |
               uint(v.cave) << KARST_GEOMETRY_CAVE_SHIFT;
#ifdef KARST_VOXEL_MATERIALS
  put_voxels(v.voxels);
#endif
}
