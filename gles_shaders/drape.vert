#version 300 es
// SPDX-License-Identifier: MIT
// A terrain vertex under an image that is laid over the world from above, lit a vertex: what interpolates is
// three numbers, and a pixel is one fetch and one multiplication.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "terrain_vertex.glsl"

// Of the image's own brightness, where no sun falls.
const float kAmbient = 0.25;

out vec3 drape_light;  // xy: place in the image, z: light

void main() {
  TerrainVertex v = read_terrain_vertex();
  gl_Position = clip_from_lattice * vec4(v.position, 1.0);
  vec2 place = vec2(v.patch_voxel.xz) + v.in_patch.xz / KARST_STEPS_PER_VOXEL;
  float facing_sun = max(dot(normalize(morphed_normal(v.share)), sun_direction.xyz), 0.0);
  drape_light = vec3(place * drape_place.xy + drape_place.zw, mix(kAmbient, 1.0, facing_sun));
}
