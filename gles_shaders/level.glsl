// SPDX-License-Identifier: MIT
// Up and height on a curved basis (KARST_CURVED; terrain/basis/level_view.h has the formulas): of places from
// the eye, voxels. On a plane up is y.
#ifdef KARST_CURVED
vec3 level_step(vec3 from_eye) {
  return vec3(dot(level_x.xyz, from_eye), dot(level_y.xyz, from_eye), dot(level_z.xyz, from_eye));
}
vec3 level_at_eye() { return vec3(level_x.w, level_y.w, level_z.w); }

vec3 level_up(vec3 from_eye) {
  return normalize(level_step(level_at_eye() + level_step(from_eye))) * level_eye.y;
}

float level_height(vec3 from_eye) {
  vec3 s = level_step(from_eye);
  vec3 eye = level_at_eye();
  float over = level_eye.x + 2.0 * dot(eye, s) + dot(s, s);
  float q = sqrt(max(1.0 + over, 0.0));
  return level_eye.y * (over / (q + 1.0)) * (q / length(level_step(eye + s)));
}

// Voxels along a ray from the eye to what is level at a height, over being |q|^2 of the eye less that there;
// below 0: it does not meet it.
float level_distance(vec3 direction, float over) {
  vec3 s = level_step(direction);
  float a = dot(s, s), b = dot(level_at_eye(), s), inside = b * b - a * over;
  if (inside <= 0.0) return -1.0;
  float root = sqrt(inside);
  if (level_eye.y > 0.0) return b < 0.0 && over > 0.0 ? over / (root - b) : -1.0;
  return b > 0.0 ? -over / (root + b) : (root - b) / max(a, 1e-30);
}

// Air between the eye and a place, as a share of as much air as lies at height 0: density falls with height.
float level_haze(float height) {
  if (level_air.y <= 0.0) return 1.0;
  float eye = max(level_eye.w, 0.0) * level_air.y;
  float there = max(height, 0.0) * level_air.y;
  float apart = eye - there;
  // From the lower end up, where air is densest.
  float rise = abs(apart);
  return exp(-min(eye, there)) * (rise < 1e-3 ? 1.0 - 0.5 * rise : (1.0 - exp(-rise)) / rise);
}

// Whether the sun, or the moon, is above the horizon of a place with this up: 1 by its day, 0 by its night.
// Where air does not thin there is no planet that would be in the way.
float level_day(vec3 up) {
  if (level_air.y <= 0.0) return 1.0;
  return smoothstep(-0.17, 0.05, dot(up, sun_direction.xyz));
}
#endif
