// SPDX-License-Identifier: MIT
// Still water up to a level: what is under it is seen through its surface. It has no geometry: a ray from an
// eye above it that ends on ground below the level has crossed the surface on its way. After sky_colour.glsl.

// Light that falls on the surface from above.
#ifdef KARST_CURVED
vec3 light_on_water(vec3 up) {
  return (sun_light.rgb * max(dot(sun_direction.xyz, up), 0.0) + sky_light.rgb) *
         (0.02 + 0.98 * level_day(up));
}
#else
vec3 light_on_water() { return sun_light.rgb * max(sun_direction.y, 0.0) + sky_light.rgb; }
#endif

// KARST_WATER: the world has water.
#ifdef KARST_WATER
// What is left of light after a metre of coastal water, as exponents, and the colour that deep water throws
// back. Values between those of Jerlov's types III and 1C at 650, 550 and 450 nm: N. G. Jerlov, "Marine
// Optics", 1976, table XXVII.
const vec3 kWaterExtinction = vec3(0.42, 0.14, 0.17);
const vec3 kWaterScatter = vec3(0.010, 0.040, 0.050);
// Squared ratio of the refractive indices, and what a surface that is looked at straight on reflects.
const float kWaterIndex2 = 1.777;
const float kWaterReflects = 0.02;
// Slope of each wave, and the variance of slopes of what is too small to be a wave: together those of a wind
// of 5 m/s. C. Cox, W. Munk, "Measurement of the Roughness of the Sea Surface from Photographs of the Sun's
// Glitter", 1954.
const float kWaveSlope = 0.062;
const float kRippleVariance = 0.014;
// Metres of depth over which foam lies at the shore, and of height over which the shore is wet; how dark wet
// ground is.
const float kFoamDepth = 0.35;
const float kWetHeight = 0.5;
const float kWetAlbedo = 0.62;

vec3 water_absorbs(float voxels) { return exp(-kWaterExtinction * (voxels * water.y)); }

#ifdef KARST_CURVED
// As below, of waves through space: along the surface. up: at the place.
vec3 water_slope(vec3 from_eye, vec3 up, float footprint, out float variance) {
  vec3 slope = vec3(0.0);
  variance = kRippleVariance;
  float bent = 0.0;
  for (int n = 0; n < KARST_WAVES; ++n) {
    vec3 wave = water_wave[n].xyz;
    float many = length(wave);
    float seen = clamp(2.0 - footprint * many, 0.0, 1.0);
    float rise = cos(dot(wave, from_eye) + water_wave[n].w + bent);
    bent += 1.4 * rise;
    slope += wave * (seen * kWaveSlope / many * rise);
    variance += (1.0 - seen * seen) * (0.5 * kWaveSlope * kWaveSlope);
  }
  return slope - up * dot(slope, up);
}
#else
// Slope of the waves at a place less the eye, voxels, as seen by pixels that cover `footprint` voxels: waves
// of fewer than three to six pixels fade out. Each bends the next ones, so that no pattern is seen. variance:
// of the slopes that are not in it.
vec2 water_slope(vec2 from_eye, float footprint, out float variance) {
  vec2 slope = vec2(0.0);
  variance = kRippleVariance;
  float bent = 0.0;
  for (int n = 0; n < KARST_WAVES; ++n) {
    vec4 wave = water_wave[n];
    float seen = clamp(2.0 - footprint * wave.w, 0.0, 1.0);
    float rise = cos(dot(wave.xy, from_eye) + wave.z + bent);
    bent += 1.4 * rise;
    slope += wave.xy * (seen * kWaveSlope / wave.w * rise);
    variance += (1.0 - seen * seen) * (0.5 * kWaveSlope * kWaveSlope);
  }
  return slope;
}
#endif

// Share of the sun that rough water throws to the eye, a sunlit white surface being 1: as mirrored_sun().
float water_glint(vec3 normal, vec3 to_eye, float variance) {
  vec3 half_way = normalize(sun_direction.xyz + to_eye);
  float facing_half = max(dot(normal, half_way), 0.0);
  float grazing = max(dot(sun_direction.xyz, half_way), 0.1);
  float alpha2 = 2.0 * variance;
  float spread = facing_half * facing_half * (alpha2 - 1.0) + 1.0;
  return kWaterReflects * alpha2 / (4.0 * spread * spread * grazing * grazing * (sqrt(sqrt(alpha2)) + 0.5));
}

// Light of ground that lies `depth` voxels below the surface, as it comes to an eye above it along
// `direction`. far: voxels from the eye to the ground, becomes those to the surface. sun: share of the sun
// that reaches the place.
vec3 through_surface(vec3 light, vec3 direction, float depth, float sun, inout float far) {
#ifdef KARST_CURVED
  float met = level_distance(direction, water.w);
  if (met >= 0.0) far = min(far, met);
  vec3 up = level_up(direction * far);
  float down = -dot(direction, up);
#else
  float down = -direction.y;
  far = max(far - depth / max(down, 1e-4), 0.0);
#endif
  float footprint = (view_scale.z > 0.5 ? 1.0 : far) * view_scale.y;
  float variance;
  float longer = footprint * max(1.0, 0.5 / max(down, 0.05));
#ifdef KARST_CURVED
  vec3 slope = water_slope(direction * far, up, longer, variance);
  vec3 normal = normalize(up - slope);
  float rises = slope.x + slope.y + slope.z, day = level_day(up);
  vec3 incoming = light_on_water(up);
#else
  vec2 slope = water_slope(direction.xz * far, longer, variance);
  vec3 normal = normalize(vec3(-slope.x, 1.0, -slope.y));
  float rises = slope.x + slope.y;
  vec3 incoming = light_on_water();
#endif

  // Down, bent by the surface; and up again.
  float bent = depth * inversesqrt(1.0 - (1.0 - down * down) / kWaterIndex2);
  vec3 left = water_absorbs(bent + depth);
  vec3 below = mix(incoming * kWaterScatter, light, left);

  // Fresnel's law averaged over the slopes that are not in the normal: E. Bruneton et al., "Real-time
  // Realistic Ocean Lighting using Seamless Transitions from Geometry to BRDF", 2010.
  float facing = max(-dot(direction, normal), 0.0);
  float rough = sqrt(variance);
  float mirror = kWaterReflects + (1.0 - kWaterReflects) * pow(1.0 - facing, 5.0 * exp(-2.69 * rough)) /
                                      (1.0 + 22.7 * rough * sqrt(rough));
  // The shore is where the depth is 0, within a pixel.
  mirror *= clamp(depth / (0.15 * footprint), 0.0, 1.0);
  vec3 mirrored = reflect(direction, normal);
#ifdef KARST_CURVED
  mirrored += up * (2.0 * max(-dot(mirrored, up), 0.0));
  vec3 seen = mix(below, sky_colour(mirrored) * day, mirror);
  float falls = max(dot(sun_direction.xyz, up), 0.0);
#else
  mirrored.y = abs(mirrored.y);
  vec3 seen = mix(below, sky_colour(mirrored), mirror);
  float falls = max(sun_direction.y, 0.0);
#endif
  // Of what falls on a level surface: the bed's slope has no part in it.
  sun *= falls;
  seen += sun_light.rgb * (sun * water_glint(normal, -direction, variance));

  float depth_m = depth * water.y;
  float foam = clamp(1.0 - depth_m / kFoamDepth, 0.0, 1.0);
  foam *= min(kFoamDepth / (0.4 * footprint * water.y), 1.0);
  foam *= 0.35 + 0.65 * smoothstep(-0.04, 0.06, rises);
  return mix(seen, 0.7 * incoming, 0.8 * foam);
}

// Light of anything as it comes to an eye in the water, along `in_water` voxels of it. depth: of the thing
// below the surface, voxels, or 0.
vec3 through_water(vec3 light, float in_water, float depth) {
#ifdef KARST_CURVED
  vec3 incoming = light_on_water(level_top.xyz);
#else
  vec3 incoming = light_on_water();
#endif
  vec3 scattered = incoming * kWaterScatter * water_absorbs(0.5 * water.x);
  return mix(scattered, light * water_absorbs(depth), water_absorbs(in_water));
}

// Light of ground as it comes to the eye, but for haze. below: of the water's level, voxels. far: from the
// eye to the ground; becomes how much of the way is in air.
vec3 in_water(vec3 light, vec3 direction, float below, float sun, inout float far) {
  if (water.x > 0.0) {
#ifdef KARST_CURVED
    float rise = dot(direction, level_top.xyz);
#else
    float rise = direction.y;
#endif
    float in_water = below > 0.0 ? far : min(far, water.x / max(rise, 1e-4));
    light = through_water(light, in_water, max(below, 0.0));
    far -= in_water;
    return light;
  }
  if (below > 0.0) return through_surface(light, direction, below, sun, far);
  return light * mix(kWetAlbedo, 1.0, clamp(-below * water.y / kWetHeight, 0.0, 1.0));
}
#endif
