// SPDX-License-Identifier: MIT
// A texel of the G-buffer, 8 bytes. x: the normal, octahedral (octahedral.glsl), 13 bits a part; the material
// of all of the patch, plus 1, 4 bits; whether it may be a cave, 1 bit. y: 1 / clip w, the bits of a float; 0
// where there is no terrain.

const float kNormalCodes = 4095.0;  // to either side of 0

// normal: any length.
uint pack_normal(vec3 normal) {
  vec3 n = normal / (abs(normal.x) + abs(normal.y) + abs(normal.z));
  vec2 e = n.y < 0.0 ? (1.0 - abs(n.zx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.z < 0.0 ? -1.0 : 1.0) : n.xz;
  uvec2 code = uvec2(ivec2(floor(e * kNormalCodes + 0.5)) + 4096);
  return code.x | code.y << 13;
}

vec3 unpack_normal(uint texel) {
  vec2 e = vec2(ivec2(texel & 8191u, texel >> 13 & 8191u) - 4096) / kNormalCodes;
  vec3 n = vec3(e.x, 1.0 - abs(e.x) - abs(e.y), e.y);
  if (n.y < 0.0) n.xz = (1.0 - abs(e.yx)) * vec2(e.x < 0.0 ? -1.0 : 1.0, e.y < 0.0 ? -1.0 : 1.0);
  return normalize(n);
}
