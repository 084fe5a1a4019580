// SPDX-License-Identifier: MIT
// Light, haze and output for fragment shaders that are not karst's: karst::Renderer::air_glsl(). All names
// begin with karst_; inside, the terrain's own functions are used under other names.
#define KARST_BLOCK(name) layout(std140) uniform name
#include "air_interface.glsl"
#undef KARST_BLOCK
#define KARST_SHADOW_BORDER 4.0
#define sun_direction karst_sun_direction
#define sun_light karst_sun_light
#define sky_zenith karst_sky_zenith
#define sky_horizon karst_sky_horizon
#define shadow_maps karst_shadow_maps
#define shadow_x karst_shadow_x
#define shadow_y karst_shadow_y
#define shadow_z karst_shadow_z
#define shadow_box_0 karst_shadow_box_0
#define shadow_box_1 karst_shadow_box_1
#define shadow_box_2 karst_shadow_box_2
#define shadow_scale karst_shadow_scale
#define ray_forward karst_ray_forward
#define kNormalTexels karst_kNormalTexels
#define kStraysFrom karst_kStraysFrom
#define kMostStrayTexels karst_kMostStrayTexels
#define kSlopeTexels karst_kSlopeTexels
#define kLeastFacing karst_kLeastFacing
#define kDepthSteps karst_kDepthSteps
#define kWhiteRoot karst_kWhiteRoot
#define tent karst_tent
#define covers karst_covers
#define cascade_of karst_cascade_of
#define sun_reaches karst_sun_reaches
#define sky_colour karst_sky_colour
#define display_value karst_display_value
#define dither karst_dither
#define picture_colour karst_display
#define light_on_water karst_light_on_water
#define kWaterExtinction karst_kWaterExtinction
#define kWaterScatter karst_kWaterScatter
#define kWaterIndex2 karst_kWaterIndex2
#define kWaterReflects karst_kWaterReflects
#define kWaveSlope karst_kWaveSlope
#define kRippleVariance karst_kRippleVariance
#define kFoamDepth karst_kFoamDepth
#define kWetHeight karst_kWetHeight
#define kWetAlbedo karst_kWetAlbedo
#define water_absorbs karst_water_absorbs
#define water_slope karst_water_slope
#define water_glint karst_water_glint
#define through_surface karst_through_surface
#define through_water karst_through_water
#define in_water karst_in_water
#define water_wave karst_water_wave
#define water karst_water
#define sky_light karst_sky_light
#define view_scale karst_view_scale
#define KARST_WATER 1
#define KARST_WAVES 6
#include "output.glsl"
#include "sky_colour.glsl"
#include "shadow.glsl"
#include "water.glsl"
#undef KARST_SHADOW_BORDER
#undef sun_direction
#undef sun_light
#undef sky_zenith
#undef sky_horizon
#undef shadow_maps
#undef shadow_x
#undef shadow_y
#undef shadow_z
#undef shadow_box_0
#undef shadow_box_1
#undef shadow_box_2
#undef shadow_scale
#undef ray_forward
#undef kNormalTexels
#undef kStraysFrom
#undef kMostStrayTexels
#undef kSlopeTexels
#undef kLeastFacing
#undef kDepthSteps
#undef kWhiteRoot
#undef tent
#undef covers
#undef cascade_of
#undef sun_reaches
#undef sky_colour
#undef display_value
#undef dither
#undef picture_colour
#undef light_on_water
#undef kWaterExtinction
#undef kWaterScatter
#undef kWaterIndex2
#undef kWaterReflects
#undef kWaveSlope
#undef kRippleVariance
#undef kFoamDepth
#undef kWetHeight
#undef kWetAlbedo
#undef water_absorbs
#undef water_slope
#undef water_glint
#undef through_surface
#undef through_water
#undef in_water
#undef water_wave
#undef water
#undef sky_light
#undef view_scale
#undef KARST_WATER
#undef KARST_WAVES

// Light that a matt surface throws back. from_eye: a place less the eye, metres; normal: of the surface, unit
// length; both in the simulator's frame.
vec3 karst_light(vec3 from_eye, vec3 normal, vec3 albedo) {
  vec3 up = normalize(mat3(karst_world) * normal);
  float facing = dot(up, karst_sun_direction.xyz);
  float sun = max(facing, 0.0);
  if (sun > 0.0) sun *= karst_sun_reaches(mat3(karst_world) * from_eye, up);
  vec3 ambient = mix(karst_ground_light.rgb, karst_sky_light.rgb, 0.5 + 0.5 * up.y) *
                 (0.8 + karst_sun_direction.w * facing);
  return albedo * (karst_sun_light.rgb * sun + ambient);
}

vec3 karst_haze(vec3 light, vec3 from_eye) {
  vec3 ray = mat3(karst_world) * from_eye;
  float distance_voxels = length(ray);
  vec3 direction = ray / max(distance_voxels, 1e-6);
  if (karst_view_scale.z > 0.5) {
    // A parallel view: as terrain.frag has it.
    direction = karst_ray_forward.xyz;
    distance_voxels = max(dot(ray, direction), 0.0);
  }
  // Under water, or seen from there: as light.glsl has it of level ground.
  float below = karst_water.x - ray.y;
  if (below > 0.0 || karst_water.x > 0.0) {
    float sun = karst_sun_direction.y > 0.0 ? karst_sun_reaches(ray, vec3(0.0, 1.0, 0.0)) : 0.0;
    light = karst_in_water(light, direction, below, sun, distance_voxels);
  }
  float hazed = 1.0 - exp(-distance_voxels * karst_view_scale.x);
  return mix(light, karst_sky_colour(vec3(direction.x, max(direction.y, 0.0), direction.z)), hazed);
}
