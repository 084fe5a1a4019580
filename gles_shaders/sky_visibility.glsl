// SPDX-License-Identifier: MIT
// How much of the sky is seen from a place of the surface: light from the sky, and caves.

uniform KARST_MEDIUM sampler3D sky_visibility;  // r: share of the hemisphere (sky_visibility.h); x, z, y

// 0..1. position: voxels from the octree's minimum corner. A cell away from the surface, no lookup mixes in
// what lies behind it.
KARST_MEDIUM float sky_seen(vec3 position, vec3 normal) {
  if (sky_octrees.x > 1) {
    // One above the other; beyond their sides all of the sky is seen.
    for (int n = 0; n < sky_octrees.x; ++n) {
      vec3 local = position - sky_corner[n].xyz;
      if (local.x < 0.0 || local.z < 0.0 || local.x >= sky_box[n].x || local.z >= sky_box[n].y) continue;
      float cell = sky_corner[n].w;
      vec3 at = local / cell + normal;
      at.xz = clamp(at.xz, vec2(0.5), ceil(sky_box[n].xy / cell) - 0.5);
      at.y = sky_box[n].z + clamp(at.y, 0.5, sky_box[n].w - 0.5);
      return textureLod(sky_visibility, at.xzy * sky_scale.xyz * sky_scale.w, 0.0).r;
    }
    return 1.0;
  }
  return textureLod(sky_visibility, (position + normal * sky_scale.w).xzy * sky_scale.xyz, 0.0).r;
}

// The same against what a plane of this slope has in the open, 1 at most.
KARST_MEDIUM float sky_open(KARST_MEDIUM float seen, KARST_MEDIUM float upwards) {
  return min(seen / max(0.5 + 0.4 * upwards, 0.3), 1.0);
}

// 0 under the open sky, 1 deep in a cave.
KARST_MEDIUM float cave_depth(KARST_MEDIUM float seen) {
  return 1.0 - smoothstep(KARST_CAVE_IS_DARK, KARST_CAVE_BEGINS, seen);
}
