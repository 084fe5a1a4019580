#version 300 es
// SPDX-License-Identifier: MIT
// Terrain surface: materials by slope (K 4.2.3), tri-planar noise, one directional light per pixel from
// interpolated normals (K 4.1), light from sky and ground, haze. All lengths are voxels, so a world looks
// the same at any voxel size.
precision highp float;
precision highp int;
precision highp sampler2D;
#include "interface.glsl"
#include "output.glsl"
#include "sky_colour.glsl"
#include "surface_noise.glsl"
#ifdef KARST_SHADOWS
#include "shadow.glsl"
#endif

uniform sampler2D sky_line;  // r: height of the open sky over a column, voxels (renderer/sky_line.h)

in vec3 normal_ws;
in vec3 from_eye_ws;
in vec3 in_patch;
flat in ivec3 patch_voxel;

out vec4 colour;

// Voxels that one repeat of the noise texture covers at the three scales; powers of two, so that positions
// can be taken modulo the repeat in integers and stay precise however far from the origin.
const int kFarRepeat = 32;
const int kMiddleRepeat = 4;
const float kNearRepeatsPerVoxel = 2.0;
const float kBedRepeat = 8.0;

// Levels of detail that lookups are blurred by: slopes at one texel a pixel would beat with the pixel grid.
const float kSoften = 0.8;

// Albedos in linear light.
const vec3 kGrassDark = vec3(0.036, 0.043, 0.017);
const vec3 kGrassLight = vec3(0.130, 0.112, 0.050);
const vec3 kSoil = vec3(0.135, 0.096, 0.060);
const vec3 kRockDark = vec3(0.080, 0.070, 0.060);
const vec3 kRockLight = vec3(0.285, 0.245, 0.195);
const vec3 kRockWarm = vec3(0.235, 0.145, 0.085);
const vec3 kCaveDark = vec3(0.060, 0.057, 0.055);
const vec3 kCaveLight = vec3(0.230, 0.205, 0.170);

// In caves the visitor carries a lamp: the point light of K's equation 4.2, at the eye.
const vec3 kLamp = vec3(1.5, 1.2, 0.85);
const float kLampReach = 28.0;  // voxels

// Voxels a pixel covers, from distance and slope. Screen-space derivatives would jump between triangles,
// and mean nothing in thin ones. At grazing angles the long side of the footprint alone would blur
// everything: take half of it, which the smooth noise stands without visible flicker.
float pixel_footprint(float distance_voxels, float facing_eye) {
  return distance_voxels * view_scale.y * max(1.0, 0.5 / max(facing_eye, 0.05));
}

// lod: of a texture that repeats once a voxel.
SurfaceNoise repeated_noise(int repeat, vec3 weights, float lod) {
  vec3 position = vec3(patch_voxel & (repeat - 1)) + in_patch;
  return triplanar_noise(position / float(repeat), weights, lod - log2(float(repeat)));
}

// 0 under the open sky, 1 deep in a cave.
float cave_depth(vec3 position) {
  return smoothstep(0.75, 5.0, texture(sky_line, position.xz * sky_line_scale.xy).r - position.y);
}

// Strata: a line through the noise texture along the height, warped a little, so that beds undulate.
vec3 rock_albedo(vec3 position, float fine, SurfaceNoise far, SurfaceNoise middle, float footprint) {
  float bed = position.y / kBedRepeat + far.mottle * 0.035 + middle.mottle * 0.004;
  float lod = log2(footprint / kBedRepeat) + kNoiseSideLog2;
  vec2 beds = textureLod(noise, vec2(0.37, bed), lod).rg - kNeutral;
  float light = 0.45 + 0.8 * beds.x + 0.6 * fine + 0.25 * far.height;
  vec3 rock = mix(kRockDark, kRockLight, clamp(light, 0.0, 1.0));
  return mix(rock, kRockWarm, clamp(0.25 + 1.4 * beds.y + 0.5 * far.mottle, 0.0, 0.8));
}

vec3 surface_albedo(vec3 normal, vec3 position, float cave, SurfaceNoise far, SurfaceNoise middle,
                    SurfaceNoise near, float footprint) {
  float fine = middle.height * 0.6 + near.height * 0.4;

  vec3 soil = kSoil * (1.0 + 0.35 * middle.mottle + 0.45 * near.height);
  vec3 grass = mix(kGrassDark, kGrassLight,
                   clamp(0.45 + 0.55 * far.mottle + 0.40 * middle.mottle + 0.30 * near.mottle, 0.0, 1.0));

  // Slopes: noise frays the borders between materials.
  float flatness = normal.y + 0.10 * far.height + 0.14 * middle.height + 0.08 * near.height;
  vec3 outside = mix(soil, grass, smoothstep(0.78, 0.92, flatness));
  float bare = 1.0 - smoothstep(0.64, 0.80, flatness);
  if (bare > 0.0) outside = mix(outside, rock_albedo(position, fine, far, middle, footprint), bare);

  float dry = 0.45 + 0.5 * fine + 0.45 * middle.mottle + 0.3 * far.mottle;
  vec3 damp = mix(kCaveDark, kCaveLight, clamp(dry, 0.0, 1.0));
  float ceiling = 1.0 - smoothstep(-0.30, -0.10, normal.y + 0.08 * middle.height);
  return mix(outside, damp, max(ceiling, cave));
}

void main() {
  vec3 normal = normalize(normal_ws);
  vec3 position = vec3(patch_voxel) + in_patch;
  float distance_voxels = length(from_eye_ws);
  vec3 direction = from_eye_ws / distance_voxels;
  float footprint = pixel_footprint(distance_voxels, -dot(normal, direction));
  float lod = log2(footprint) + kNoiseSideLog2 + kSoften;

  vec3 weights = triplanar_weights(normal);
  SurfaceNoise far = repeated_noise(kFarRepeat, weights, lod);
  SurfaceNoise middle = repeated_noise(kMiddleRepeat, weights, lod);
  // From the mip level of one texel on, a lookup would return neutral.
  float near_lod = lod + log2(kNearRepeatsPerVoxel);
  SurfaceNoise near = SurfaceNoise(0.0, 0.0, vec3(0.0));
  if (near_lod < kNoiseSideLog2) near = triplanar_noise(in_patch * kNearRepeatsPerVoxel, weights, near_lod);

  float cave = cave_depth(position);
  vec3 albedo = surface_albedo(normal, position, cave, far, middle, near, footprint);

  // Bump: the normal turns against the height field's gradient along the surface.
  vec3 gradient = 0.5 * middle.gradient + 0.5 * near.gradient;
  vec3 bumped = normalize(normal - (gradient - normal * dot(normal, gradient)));

  // K 4.1, per pixel. The sun does not reach into caves, by shadow maps or as a guess; sky light does a
  // little. Sky light is stronger from the sun's side, so that slopes in shade keep their relief.
#ifdef KARST_SHADOWS
  float reached = sun_reaches(from_eye_ws, normal);
#else
  float reached = 1.0 - cave;
#endif
  float facing_sun = dot(bumped, sun_direction.xyz);
  float sun = max(facing_sun, 0.0) * smoothstep(-0.05, 0.15, dot(normal, sun_direction.xyz));
  vec3 ambient = mix(ground_light.rgb, sky_light.rgb, 0.5 + 0.5 * bumped.y) * (0.8 + 0.4 * facing_sun);
  float lamp = max(-dot(bumped, direction), 0.0) * max(1.0 - distance_voxels / kLampReach, 0.0);
  vec3 incoming = sun_light.rgb * (sun * reached);
  incoming += ambient * mix(1.0, 0.4, cave);
  incoming += kLamp * (lamp * cave);

  float hazed = (1.0 - exp(-distance_voxels * view_scale.x)) * (1.0 - 0.9 * cave);
  vec3 haze = sky_colour(vec3(direction.x, max(direction.y, 0.0), direction.z));
  colour = picture_colour(mix(albedo * incoming, haze, hazed));
}
