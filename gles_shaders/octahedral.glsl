// SPDX-License-Identifier: MIT
// The inverse of encode_octahedral in terrain/patch/octahedral.h: x in the low byte, y in the high byte, both snorm8.

vec3 octahedral_decode(int bits) {
  vec2 e = vec2(ivec2(bits << 24, bits << 16) >> 24) / 127.0;
  vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(e.yx)) * vec2(e.x < 0.0 ? -1.0 : 1.0, e.y < 0.0 ? -1.0 : 1.0);
  return normalize(n);
}
