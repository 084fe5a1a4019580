// SPDX-License-Identifier: MIT
// The light that comes to the eye from a point of the terrain: materials, one directional light from
// interpolated normals (K 4.1), lamps in caves, light from sky and ground, haze. All lengths are voxels, so a
// world looks the same at any voxel size. The same for terrain.frag, which has the point from the vertices,
// and for screen.frag, which has it from the G-buffer.
//
// Macros leave out what no patch of a frame needs (terrain/shading/shading.h): KARST_BLEND (more than one
// material), KARST_CAVE (some lie under rock), KARST_LAMPS (and lamps of the world light some),
// KARST_SHADOWS (shadow maps). The renderer defines KARST_IMAGERY where the world has images, and
// KARST_VOXEL_MATERIALS where the voxels of an isosurface have materials.
// KARST_SHOW_LOOKUPS counts lookups, of pixels and not of vertices.
#ifdef KARST_SHOW_LOOKUPS
int lookups = 0;
#define KARST_COUNT_LOOKUPS(n) lookups += (n)
#else
#define KARST_COUNT_LOOKUPS(n)
#endif
#ifdef KARST_CURVED
#define KARST_UPWARDS(v) dot(v, up)
#else
#define KARST_UPWARDS(v) (v).y
#endif
#ifdef KARST_VOXEL_MATERIALS
#include "voxel_materials.glsl"
#endif
#include "materials.glsl"
#ifdef KARST_IMAGERY
#include "imagery.glsl"
#endif
#include "sky_visibility.glsl"
#ifdef KARST_CAVE
#include "point_lights.glsl"
#endif
#ifdef KARST_SHADOWS
#include "shadow.glsl"
#endif

#ifdef KARST_VOXEL_MATERIALS
#define KARST_OF_VOXELS , point.voxels
#else
#define KARST_OF_VOXELS
#endif

struct Point {
  vec3 normal;    // unit length
  vec3 from_eye;  // voxels
  // Its place is voxel + in_voxel, voxels from the octree's minimum corner.
  ivec3 voxel;
  vec3 in_voxel;
  int material;  // of all of its patch, or less than 0
  bool cave;     // its patch may be a cave or lit by lamps
#ifdef KARST_VOXEL_MATERIALS
  Voxels voxels;
#endif
#ifdef KARST_CURVED
  float height;  // voxels above height 0
#ifdef KARST_IMAGERY
  vec2 image_place;  // of terrain_vertex.glsl
#endif
#endif
};

// In caves the visitor carries a lamp: a point light at the eye.
const KARST_MEDIUM vec3 kLamp = vec3(1.5, 1.2, 0.85);

// Share of the light that surfaces reflect like mirrors, looked at straight on: what rock and plants have.
const KARST_MEDIUM float kMirrored = 0.04;

// What a pixel covers, from distance (1 in parallel views) and slope. Screen-space derivatives would jump
// between triangles, and mean nothing in thin ones. At grazing angles the long side of the footprint alone
// would blur everything: without anisotropic lookups take a third of it, which the textures stand without
// visible flicker. With them, lookups are blurred by KARST_SOFTEN_LEVELS on the short side alone.
Footprint footprint_of(float distance_voxels, vec3 normal, vec3 direction) {
  float voxels = distance_voxels * view_scale.y;
  float facing_eye = max(-dot(normal, direction), 0.05);
#if KARST_ANISOTROPY > 1
  float longer = max(1.0, exp2(-KARST_SOFTEN_LEVELS) / facing_eye);
  float ratio = min(longer, float(KARST_ANISOTROPY));
  // Looked at straight on, any two axes will do.
  vec3 across = normalize(cross(normal, direction + 1e-3 * normalize(ray_up.xyz)));
  return Footprint(voxels * (longer / ratio), across, cross(normal, across) * ratio);
#else
  return Footprint(voxels * max(1.0, 0.35 / facing_eye), vec3(0.0), vec3(0.0));
#endif
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

vec3 light_from(Point point) {
  vec3 normal = point.normal;
  float distance_voxels = length(point.from_eye);
  vec3 direction = point.from_eye / distance_voxels;
  float seen_from = distance_voxels;
  if (view_scale.z > 0.5) {
    // Parallel: every point is looked at from the same direction, and lies as far as it is deep.
    direction = ray_forward.xyz;
    distance_voxels = max(dot(point.from_eye, direction), 0.0);
    seen_from = 1.0;
  }
  Footprint footprint = footprint_of(seen_from, normal, direction);
#ifdef KARST_CURVED
  vec3 up = level_up(point.from_eye);
  float height = point.height;
#else
  float height = float(point.voxel.y) + point.in_voxel.y;
#endif
  Lookup at = lookup_at(point.voxel, point.in_voxel, footprint);

  KARST_COUNT_LOOKUPS(1);
  KARST_MEDIUM float seen = sky_seen(vec3(point.voxel) + point.in_voxel, normal);
  KARST_MEDIUM float open = sky_open(seen, KARST_UPWARDS(normal));
  float cave = 0.0;
#ifdef KARST_CAVE
  if (point.cave) cave = cave_depth(seen);
#endif
#ifdef KARST_BLEND
  Choice choice = Choice(point.material, point.material, 0.0);
  if (point.material < 0) {
    vec3 noise_place =
        (vec3(point.voxel & (KARST_VARIATION_REPEAT - 1)) + point.in_voxel) / float(KARST_VARIATION_REPEAT);
    vec2 column = vec2(point.voxel.xz) + point.in_voxel.xz;
    choice = choice_of(KARST_UPWARDS(normal), height, noise_place, cave,
                       painted_at(column, footprint, KARST_UPWARDS(normal), cave) KARST_OF_VOXELS);
  }
  Surface ground = blended_surface(choice, at, normal);
#else
  Surface ground = surface_of(point.material, at, normal);
#endif
#ifdef KARST_IMAGERY
#ifdef KARST_BLEND
  KARST_MEDIUM vec3 average =
      mix(material_average[choice.first].rgb, material_average[choice.second].rgb, choice.share);
#else
  KARST_MEDIUM vec3 average = material_average[point.material].rgb;
#endif
#ifdef KARST_CURVED
  lay_image(ground, average, image_on_curve(point.image_place, point.from_eye, footprint.voxels),
            KARST_UPWARDS(normal), cave);
#else
  lay_image(ground, average, image_on_plane(point.from_eye, footprint.voxels), normal.y, cave);
#endif
#endif

  // The normal turns against the gradient along the surface.
  KARST_MEDIUM vec3 gradient = ground.gradient;
  vec3 bumped = normalize(normal - (gradient - normal * dot(normal, gradient)));

  // K 4.1, per pixel. The sun does not reach into caves, by shadow maps or as a guess. Where rock hides the
  // sky, it throws back light as the ground does; both are dim where little of the sky is seen, and stronger
  // from the sun's side, so that slopes in shade keep their relief.
  float facing_sun = dot(bumped, sun_direction.xyz);
  KARST_MEDIUM float sun = max(facing_sun, 0.0);
  KARST_MEDIUM float shines = smoothstep(KARST_SUN_GRAZES, KARST_SUN_SHINES, dot(normal, sun_direction.xyz));
  sun *= shines;
#ifdef KARST_CURVED
  float day = level_day(up);
  sun *= day;
#endif
  bool sunlit = sun > 0.0 || least_work.w > 0;
  KARST_MEDIUM float reaches = 1.0;
#ifdef KARST_SHADOWS
  if (sunlit) {
    KARST_COUNT_LOOKUPS(shadow_scale.x > 0.0 ? 4 : 0);
    reaches = sun_reaches(point.from_eye, normal);
  }
#else
  reaches = 1.0 - cave * light_scale.y;
#endif
  sun *= reaches;
  KARST_MEDIUM vec3 ambient =
      mix(ground_light.rgb, sky_light.rgb, (0.5 + 0.5 * KARST_UPWARDS(bumped)) * open) *
      (0.8 + sun_direction.w * facing_sun);
#ifdef KARST_CURVED
  ambient *= 0.02 + 0.98 * day;
#endif
  KARST_MEDIUM vec3 incoming = sun_light.rgb * sun + ambient * mix(0.4, 1.0, open);
#ifdef KARST_CAVE
  if (point.cave) {
#ifdef KARST_LAMPS
    incoming += light_of_lamps(point.from_eye, bumped);
#endif
    float lamp = max(-dot(bumped, direction), 0.0) * max(1.0 - distance_voxels / KARST_LAMP_REACH, 0.0);
    incoming += kLamp * (lamp * cave);
  }
#endif
  KARST_MEDIUM vec3 light = ground.albedo * incoming;
  if (sunlit) {
    float mirrored = mirrored_sun(bumped, -direction, ground.roughness);
    light += sun_light.rgb * (sun * mirrored);
  }

  vec3 arrives = light;
#ifdef KARST_WATER
#ifdef KARST_CURVED
  float below = water.z - height;
  height = max(height, water.z);
  // What the ray meets on its way up again, behind the sea's own horizon, is seen through all of the sea.
  if (water.x <= 0.0 && view_scale.z < 0.5 && dot(direction, up) > 0.0) {
    float met = level_distance(direction, water.w);
    if (met >= 0.0 && met < 0.999 * distance_voxels) below = distance_voxels;
  }
#else
  float below = water.x - point.from_eye.y;
#endif
  if (below > -kWetHeight / water.y) {
    // However steep the bed is, water over it is level.
    float lit = sun > 0.0 ? shines * reaches : 0.0;
    arrives = in_water(arrives, direction, below, lit, distance_voxels);
  }
#endif
#ifdef KARST_CURVED
  float hazed = 1.0 - exp(-distance_voxels * view_scale.x * level_haze(height));
  float below_level = max(-dot(direction, level_top.xyz) - level_top.w, 0.0);
  vec3 haze = sky_colour(normalize(direction + level_top.xyz * below_level)) * day;
#else
  float hazed = (1.0 - exp(-distance_voxels * view_scale.x)) * (1.0 - 0.9 * cave);
  vec3 haze = sky_colour(vec3(direction.x, max(direction.y, 0.0), direction.z));
#endif
  return mix(arrives, haze, hazed);
}
