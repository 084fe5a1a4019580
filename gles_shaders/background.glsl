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

#ifdef KARST_CURVED
const float kSeaDeepM = 1e4;  // where the bed is not known

// How bright the air is along a ray from the eye, beside the sky from the ground: above it thins, and is seen
// from outside where the ray passes close to the ground.
float air_along(vec3 direction) {
  float air = level_air.x;
  if (level_air.y <= 0.0) return air;
  vec3 s = level_step(direction), eye = level_at_eye();
  float b = dot(eye, s), a = dot(s, s);
  if (b >= 0.0) return air;
  float over = max(level_eye.x - b * b / a, -0.9);
  float height = over / (1.0 + sqrt(1.0 + over)) * inversesqrt(a);
  float day = level_day(normalize(level_step(eye - s * (b / a))));
  return max(air, exp(-max(height, 0.0) * level_air.y) * day);
}

vec3 open_sky(vec3 direction) {
  float air = air_along(direction);
  vec3 light = sky_colour(direction) * air;
  light += sun_light.rgb * (6.0 * smoothstep(kDiscOuter, kDiscInner, dot(direction, sun_direction.xyz)));
  float dark = max(sky_zenith.w * min(4.0 * max(dot(direction, level_top.xyz) + level_top.w, 0.0), 1.0),
                   clamp(1.0 - 5.0 * air, 0.0, 1.0));
  return dark > 0.0 ? light + dark * stars(direction) : light;
}

// direction: unit length.
vec3 background(vec3 direction) {
#ifdef KARST_WATER
  float rise = dot(direction, level_top.xyz);
  if (water.x > 0.0) {
    return rise > 0.0 ? through_water(open_sky(direction), water.x / max(rise, 1e-4), 0.0)
                      : through_water(vec3(0.0), 1e6, 0.0);
  }
  float surface = level_distance(direction, water.w);
  if (surface >= 0.0) {
    // A sea whose bed the ray passes by.
    float sea = surface;
    vec3 seen = through_surface(vec3(0.0), direction, kSeaDeepM / water.y, 1.0, sea);
    vec3 mist = sky_colour(normalize(direction - level_top.xyz * min(rise + level_top.w, 0.0)));
    float misty = 1.0 - exp(-sea * view_scale.x * level_haze(water.z));
    return mix(seen, mist * level_day(level_up(direction * sea)), misty);
  }
#endif
  if (level_air.w < 0.5) return open_sky(direction);
  vec3 s = level_step(direction), eye = level_at_eye();
  float a = dot(s, s), b = dot(eye, s), c = level_eye.x - level_air.z;
  float inside = b * b - a * c;
  if (b >= 0.0 || inside <= 0.0 || c <= 0.0) return open_sky(direction);
  float far = c / (sqrt(inside) - b);
  vec3 up = level_up(direction * far);
  vec3 light = plain.rgb * (sun_light.rgb * max(dot(up, sun_direction.xyz), 0.0) + sky_light.rgb);
  float day = level_day(up);
  vec3 haze = sky_colour(normalize(direction - level_top.xyz * min(dot(direction, level_top.xyz), 0.0)));
  float hazed = 1.0 - exp(-far * view_scale.x * level_haze(level_height(direction * far)));
  return mix(light, haze, hazed) * (0.02 + 0.98 * day);
}
#else
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
#endif
