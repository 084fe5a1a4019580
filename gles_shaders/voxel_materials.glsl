// SPDX-License-Identifier: MIT
// Materials of an isosurface's voxels (L 5.3): a vertex has two of them and the share of the second. What
// interpolates over a triangle is a weight for each material of the world, never a number of one; a pixel
// takes the two that weigh most, and 16 bits of the G-buffer hold them. So both ways of shading see the same.
//
// Materials are their numbers plus 1, or 0: rules decide.

struct Voxels {
  int first;
  int second;
  KARST_MEDIUM float share;  // of the second, 0..0.5
};

#ifdef KARST_VOXEL_VERTEX
#if KARST_MATERIALS > 4
out vec4 voxels_low;   // weights of materials 0..3
out vec4 voxels_high;  // 4..7
#else
out vec4 voxels_low;
#endif

vec4 voxel_weights(ivec4 materials, int code) {
  float share = float(code >> 8 & 7) / 7.0;
  return mix(vec4(equal(materials, ivec4(code & 15))), vec4(equal(materials, ivec4(code >> 4 & 15))), share);
}

// code: of a mesh's vertex (terrain/isosurface/field_materials.h), else 0.
void put_voxels(int code) {
  voxels_low = voxel_weights(ivec4(1, 2, 3, 4), code);
#if KARST_MATERIALS > 4
  voxels_high = voxel_weights(ivec4(5, 6, 7, 8), code);
#endif
}
#endif

#ifdef KARST_VOXEL_PIXEL
#if KARST_MATERIALS > 4
in vec4 voxels_low;
in vec4 voxels_high;
#else
in vec4 voxels_low;
#endif

void weigh(float weight, int material, inout ivec2 numbers, inout vec3 most) {
  bool is_first = weight > most.x;
  bool is_second = weight > most.y;
  numbers = is_first ? ivec2(material, numbers.x) : is_second ? ivec2(numbers.x, material) : numbers;
  most = is_first ? vec3(weight, most.xy)
                  : is_second ? vec3(most.x, weight, most.y) : vec3(most.xy, max(most.z, weight));
}

// Bits 0..3 the first, 4..7 the second, 8..15 its share, of which 255 is a half. What the third weighs is
// taken off both, so that nothing jumps where another takes a place.
uint pack_voxels() {
  float left = 1.0 - dot(voxels_low, vec4(1.0));
#if KARST_MATERIALS > 4
  left -= dot(voxels_high, vec4(1.0));
#endif
  ivec2 numbers = ivec2(0);
  vec3 most = vec3(max(left, 0.0), 0.0, 0.0);
  weigh(voxels_low.x, 1, numbers, most);
#if KARST_MATERIALS > 1
  weigh(voxels_low.y, 2, numbers, most);
#endif
#if KARST_MATERIALS > 2
  weigh(voxels_low.z, 3, numbers, most);
#endif
#if KARST_MATERIALS > 3
  weigh(voxels_low.w, 4, numbers, most);
#endif
#if KARST_MATERIALS > 4
  weigh(voxels_high.x, 5, numbers, most);
#endif
#if KARST_MATERIALS > 5
  weigh(voxels_high.y, 6, numbers, most);
#endif
#if KARST_MATERIALS > 6
  weigh(voxels_high.z, 7, numbers, most);
#endif
#if KARST_MATERIALS > 7
  weigh(voxels_high.w, 8, numbers, most);
#endif
  vec2 over = most.xy - most.z;
  float share = over.y / max(over.x + over.y, 1e-4);
  return uint(numbers.x) | uint(numbers.y) << 4 | uint(510.0 * share + 0.5) << 8;
}
#endif

Voxels unpack_voxels(uint bits) {
  return Voxels(int(bits & 15u), int(bits >> 4 & 15u), float(bits >> 8 & 255u) / 510.0);
}
