#version 300 es
// SPDX-License-Identifier: MIT
// Terrain surface: materials, one directional light per pixel from interpolated normals (K 4.1), lamps in
// caves, light from sky and ground, haze. All lengths are voxels, so a world looks the same at any voxel
// size. Macros leave out what no patch of a frame needs (terrain/shading/shading.h): KARST_BLEND (more than
// one material), KARST_CAVE (some lie under rock, or in a lamp's reach), KARST_SHADOWS (shadow maps).
precision highp float;
precision highp int;
#include "interface.glsl"
#include "output.glsl"
#include "target_colour.glsl"
#include "sky_colour.glsl"
#include "materials.glsl"
#ifdef KARST_CAVE
#include "point_lights.glsl"
#endif
#ifdef KARST_SHADOWS
#include "shadow.glsl"
#endif

in vec3 normal_ws;
in vec3 from_eye_ws;
in vec3 in_patch;
flat in ivec3 patch_voxel;
flat in ivec2 patch_shading;

out vec4 colour;

// In caves the visitor carries a lamp: a point light at the eye.
const KARST_MEDIUM vec3 kLamp = vec3(1.5, 1.2, 0.85);

// Share of the light that surfaces reflect like mirrors, looked at straight on: what rock and plants have.
const KARST_MEDIUM float kMirrored = 0.04;

// Voxels a pixel covers, from distance (1 in parallel views) and slope. Screen-space derivatives would jump
// between triangles, and mean nothing in thin ones. At grazing angles the long side of the footprint alone
// would blur everything: take half of it, which the textures stand without visible flicker.
float pixel_footprint(float distance_voxels, float facing_eye) {
  return distance_voxels * view_scale.y * max(1.0, 0.5 / max(facing_eye, 0.05));
}

// Sunlight thrown back as by rough mirrors, a sunlit white surface being 1: GGX facets, with a fit of what
// they hide of each other and of Fresnel's law together: R. Zioma, "Optimizing PBR for Mobile", SIGGRAPH
// 2015.
float mirrored_sun(vec3 normal, vec3 to_eye, float roughness) {
  vec3 half_way = normalize(sun_direction.xyz + to_eye);
  float facing_half = max(dot(normal, half_way), 0.0);
  float grazing = max(dot(sun_direction.xyz, half_way), 0.1);
  float alpha2 = roughness * roughness * roughness * roughness;
  float spread = facing_half * facing_half * (alpha2 - 1.0) + 1.0;
  return kMirrored * alpha2 / (4.0 * spread * spread * grazing * grazing * (roughness + 0.5));
}

void main() {
  vec3 normal = normalize(normal_ws);
  vec3 position = vec3(patch_voxel) + in_patch;
  float distance_voxels = length(from_eye_ws);
  vec3 direction = from_eye_ws / distance_voxels;
  float seen_from = distance_voxels;
  if (view_scale.z > 0.5) {
    // Parallel: every point is looked at from the same direction, and lies as far as it is deep.
    direction = ray_forward.xyz;
    distance_voxels = max(dot(from_eye_ws, direction), 0.0);
    seen_from = 1.0;
  }
  float footprint = pixel_footprint(seen_from, -dot(normal, direction));
  float lod = log2(footprint) + material_scale.y + KARST_SOFTEN_LEVELS;
  Lookup at = lookup_at(patch_voxel, in_patch, lod);
  Planes planes = planes_of(normal);

  float cave = 0.0;
#ifdef KARST_CAVE
  if (patch_shading.y > 0) cave = cave_depth(position);
#endif
#ifdef KARST_BLEND
  Choice choice = Choice(patch_shading.x, patch_shading.x, 0.0);
  if (patch_shading.x < 0) {
    vec3 noise_place =
        (vec3(patch_voxel & (KARST_VARIATION_REPEAT - 1)) + in_patch) / float(KARST_VARIATION_REPEAT);
    choice = choice_of(normal.y, position.y, noise_place, cave);
  }
  Surface ground = blended_surface(choice, at, planes);
#else
  Surface ground = surface_of(patch_shading.x, at, planes);
#endif

  // The normal turns against the gradient along the surface.
  KARST_MEDIUM vec3 gradient = ground.gradient;
  vec3 bumped = normalize(normal - (gradient - normal * dot(normal, gradient)));

  // K 4.1, per pixel. The sun does not reach into caves, by shadow maps or as a guess; sky light does a
  // little. Sky light is stronger from the sun's side, so that slopes in shade keep their relief.
  float facing_sun = dot(bumped, sun_direction.xyz);
  KARST_MEDIUM float sun = max(facing_sun, 0.0);
  sun *= smoothstep(KARST_SUN_GRAZES, KARST_SUN_SHINES, dot(normal, sun_direction.xyz));
  bool sunlit = sun > 0.0 || least_work.w > 0;
#ifdef KARST_SHADOWS
  if (sunlit) sun *= sun_reaches(from_eye_ws, normal);
#else
  sun *= 1.0 - cave * light_scale.y;
#endif
  KARST_MEDIUM vec3 ambient =
      mix(ground_light.rgb, sky_light.rgb, 0.5 + 0.5 * bumped.y) * (0.8 + 0.4 * facing_sun);
  KARST_MEDIUM vec3 incoming = sun_light.rgb * sun + ambient * mix(1.0, 0.4, cave);
#ifdef KARST_CAVE
  if (patch_shading.y > 0) {
    incoming += light_of_lamps(from_eye_ws, bumped);
    float lamp = max(-dot(bumped, direction), 0.0) * max(1.0 - distance_voxels / KARST_LAMP_REACH, 0.0);
    incoming += kLamp * (lamp * cave);
  }
#endif
  KARST_MEDIUM vec3 light = ground.albedo * incoming;
  if (sunlit) {
    float mirrored = mirrored_sun(bumped, -direction, ground.roughness);
    light += sun_light.rgb * (sun * mirrored);
  }

  float hazed = (1.0 - exp(-distance_voxels * view_scale.x)) * (1.0 - 0.9 * cave);
  vec3 haze = sky_colour(vec3(direction.x, max(direction.y, 0.0), direction.z));
  colour = target_colour(mix(light, haze, hazed));
}
