// SPDX-License-Identifier: MIT
// The formulas of a vertex in terrain/lod/morph.h, which explains them; tests/gl compares the two. Lengths
// in lattice steps.

// from_eye: the vertex at home less the eye.
float apparent_distance(vec3 from_eye, vec3 forward, float least_cos2) {
  float ahead = from_eye.x * forward.x + from_eye.y * forward.y + from_eye.z * forward.z;
  float r2 = from_eye.x * from_eye.x + from_eye.y * from_eye.y + from_eye.z * from_eye.z;
  float z = max(ahead, 0.0);
  float seen = max(z * z, least_cos2 * r2) / sqrt(max(r2, 1.0));
  return least_cos2 < 0.0 ? -least_cos2 : seen;
}

// last: the share of the threshold over which a vertex moves.
float morph_share(float apparent, float threshold, float last) {
  float start = (1.0 - last) * threshold;
  return clamp((apparent - start) / max(last * threshold, 1.0), 0.0, 1.0);
}

vec3 morph_position(vec3 home, vec3 way, vec3 target, float share) {
  return share < 1.0 ? home + way * share : target;
}
