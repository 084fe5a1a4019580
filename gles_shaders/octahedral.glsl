// SPDX-License-Identifier: MIT
// The inverse of encode_octahedral in terrain/patch/octahedral.h: x in the low byte, z in the high byte,
// both snorm8.

vec3 octahedral_decode(int bits) {
  vec2 e = vec2(ivec2(bits << 24, bits << 16) >> 24) / 127.0;
  vec3 n = vec3(e.x, 1.0 - abs(e.x) - abs(e.y), e.y);
  if (n.y < 0.0) n.xz = (1.0 - abs(e.yx)) * vec2(e.x < 0.0 ? -1.0 : 1.0, e.y < 0.0 ? -1.0 : 1.0);
  return normalize(n);
}
