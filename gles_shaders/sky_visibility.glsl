// SPDX-License-Identifier: MIT
// How much of the sky is seen from a place of the surface: light from the sky, and caves.

uniform KARST_MEDIUM sampler3D sky_visibility;  // r: share of the hemisphere (sky_visibility.h); x, z, y

// 0..1. position: voxels from the octree's minimum corner. A cell away from the surface, no lookup mixes in
// what lies behind it.
KARST_MEDIUM float sky_seen(vec3 position, vec3 normal) {
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
