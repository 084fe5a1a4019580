// SPDX-License-Identifier: MIT
// Caves: how deep a point lies in one, and the lamps that light it (K 4.1, equation 4.2).

uniform highp sampler2D sky_line;  // r: height of the open sky over a column, voxels (sky_line.h)

// 0 under the open sky, 1 deep in a cave. position: voxels from the octree's minimum corner.
float cave_depth(vec3 position) {
  float below = texture(sky_line, position.xz * sky_line_scale.xy).r - position.y;
  return smoothstep(KARST_CAVE_BEGINS, KARST_CAVE_IS_DARK, below);
}

#ifdef KARST_LAMPS
// from_eye: voxels.
KARST_MEDIUM vec3 light_of_lamps(vec3 from_eye, KARST_MEDIUM vec3 normal) {
  KARST_MEDIUM vec3 sum = vec3(0.0);
  for (int n = 0; n < int(light_scale.x); ++n) {
    vec3 way = light_place[n].xyz - from_eye;
    float d = max(length(way), 1e-3);
    float reach = light_place[n].w;
    KARST_MEDIUM float fades = max(reach - d, 0.0) / reach;
    sum += light_colour[n].rgb * (max(dot(normal, way / d), 0.0) * fades);
  }
  return sum;
}
#endif
