// SPDX-License-Identifier: MIT
// What is seen where there is no ground: the sky with its disc, the sun's or the moon's, and with stars;
// below the horizon the plain around the world, or the water over it. After sky_colour.glsl and water.glsl.

// Cosines of the angles at which the disc begins and ends to fade: 0.35 and 0.27 degrees (the sun's radius
// is 0.27, the moon's 0.26).
const float kDiscOuter = 0.99998134;
const float kDiscInner = 0.99998889;
// Cells of stars along a side of the cube around the eye, and the share of them that have one.
const float kStarCells = 90.0;
const float kStarShare = 0.25;

// Three numbers of a cell, 0..1: integer finaliser of MurmurHash3 (A. Appleby).
vec3 hash_cell(ivec3 cell) {
  uint h = uint(cell.x) * 0x9e3779b1u + uint(cell.y) * 0x85ebca77u + uint(cell.z) * 0xc2b2ae3du;
  h ^= h >> 16;
  h *= 0x85ebca6bu;
  h ^= h >> 13;
  h *= 0xc2b2ae35u;
  h ^= h >> 16;
  return vec3(uvec3(h, h >> 10, h >> 20) & 1023u) / 1023.0;
}

// A star at most lies in a cell, so far from its sides that all of it is there. It covers more than a pixel,
// so that it does not flicker when the eye turns, and is the fainter for it where pixels are large.
float stars(vec3 direction) {
  vec3 size = abs(direction);
  float most = max(size.x, max(size.y, size.z));
  vec3 on_cube = direction / most;
  ivec3 side = ivec3(step(vec3(most), size) * sign(direction));
  vec2 at = side.x != 0 ? on_cube.yz : side.y != 0 ? on_cube.xz : on_cube.xy;
  at = (at * 0.5 + 0.5) * kStarCells;
  vec2 cell = floor(at);
  vec3 numbers = hash_cell(ivec3(ivec2(cell), side.x + 3 * side.y + 9 * side.z));
  if (numbers.z > kStarShare) return 0.0;
  float pixel = view_scale.y * 0.5 * kStarCells;
  vec2 from_star = at - cell - mix(vec2(0.25), vec2(0.75), numbers.xy);
  float radius = max(0.8 * pixel, 0.03);
  float magnitude = numbers.z / kStarShare;
  float bright = magnitude * magnitude * magnitude;
  float light = (0.05 + bright * bright) * min(0.08 / radius, 1.0);
  return light * exp(-dot(from_star, from_star) / (radius * radius));
}

vec3 open_sky(vec3 direction) {
  vec3 light = sky_colour(direction);
  light += sun_light.rgb * (6.0 * smoothstep(kDiscOuter, kDiscInner, dot(direction, sun_direction.xyz)));
  if (sky_zenith.w > 0.0 && direction.y > 0.0) {
    light += sky_zenith.w * min(4.0 * direction.y, 1.0) * stars(direction);
  }
  return light;
}

// direction: unit length.
vec3 background(vec3 direction) {
#ifdef KARST_WATER
  if (water.x > 0.0 && direction.y > 0.0) {
    // From under water all of the sky is seen within a cone, and around it the water's mirror.
    vec3 bent = vec3(direction.xz, 0.0).xzy * sqrt(kWaterIndex2);
    float up2 = 1.0 - dot(bent, bent);
    vec3 sky = open_sky(normalize(vec3(bent.x, sqrt(max(up2, 1e-4)), bent.z)));
    return through_water(sky * smoothstep(-0.02, 0.10, up2), water.x / direction.y, 0.0);
  }
  if (water.x > 0.0 && direction.y < 0.0) return through_water(vec3(0.0), 1e6, 0.0);
#endif
  if (direction.y >= 0.0) return open_sky(direction);
  if (plain.w >= 0.0) return sky_colour(direction);
  // A plain without end, or the bed of a sea.
  float far = plain.w / direction.y;
  vec3 light = plain.rgb * light_on_water();
#ifdef KARST_WATER
  float depth = water.x - plain.w;
  if (depth > 0.0) light = through_surface(light, direction, depth, 1.0, far);
#endif
  vec3 haze = sky_colour(vec3(direction.x, 0.0, direction.z));
  return mix(light, haze, 1.0 - exp(-far * view_scale.x));
}
