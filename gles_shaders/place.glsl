// SPDX-License-Identifier: MIT
// Where the camera sees a point of a page of any size: terrain/ground/node_place.h, which explains it;
// tests/gl compares the two.

struct PageReference {
  vec3 origin;  // lattice steps of the size from the last whole voxel of the size before the camera's
  vec3 rest;    // from there to the camera's voxel, steps of the size
  float unit;   // a step of the size in lattice steps
};

// 2^n, exactly. n: within -126..127.
float power_of_two(int n) { return intBitsToFloat((127 + n) << 23); }

// origin: of the page, voxels of the size.
PageReference page_reference(ivec3 camera, int size, ivec3 origin) {
  return PageReference(vec3(origin - (camera >> size)) * KARST_STEPS_PER_VOXEL,
                       vec3(camera & KARST_MASK(size)) * power_of_two(KARST_STEPS_LOG2 - size),
                       power_of_two(size));
}

// q: steps of the size from the page's origin. Returns lattice steps from camera.
vec3 place_in_page(PageReference page, ivec3 q) {
  return (page.origin + (vec3(q) - page.rest)) * page.unit;
}
