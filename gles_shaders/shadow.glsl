// SPDX-License-Identifier: MIT
// How much of the sun reaches a point, from the shadow maps of terrain/shadow/cascades.h.

uniform highp sampler2DArrayShadow shadow_maps;  // depth of what is nearest to the sun, a layer a cascade

// Where a point is looked up, so that a surface does not shade itself. Each of the filter's four comparisons
// is with the depth that the plane through the point has at its own place; it mixes texels up to one texel
// from there, in which the plane's depth differs by its slope. That much the point is lifted along the light,
// which moves no shadow's edge; and a little along its normal, because what casts is of a coarser level and
// no plane. Away from the picture's middle what is seen is finer than what casts, whose levels are the same
// all around the eye (terrain/shadow/cascades.h): there the point is lifted by as much as that may stray.
const float kNormalTexels = 0.75;
const float kStraysFrom = 4.0;  // all of it from here on: where 1 - cos^2 of the angle is a fourth
const float kMostStrayTexels = 4.0;  // and no more, so that what is small still casts
const float kSlopeTexels = 1.0;
const float kLeastFacing = 0.05;  // below, next to nothing of the sun is left
// Steps of depth in a map of 16 bits.
const float kDepthSteps = 1.5 / 65535.0;

// A tent of 3 x 3 texels by four comparisons that the hardware filters: I. Castano, "Shadow Mapping Summary -
// Part 1", 2013 (the optimised filter of J. Blow's The Witness). slope: of depth, a texel.
float tent(vec3 at, vec2 slope, float layer) {
  vec2 texel = at.xy * shadow_scale.y + 0.5;
  vec2 base = floor(texel);
  vec2 part = texel - base;
  vec2 weight_0 = 3.0 - 2.0 * part;
  vec2 weight_1 = 1.0 + 2.0 * part;
  vec2 at_0 = base - 0.5 + (2.0 - part) / weight_0 - 1.0;
  vec2 at_1 = base - 0.5 + part / weight_1 + 1.0;
  vec2 rise_0 = slope * (at_0 - at.xy * shadow_scale.y);
  vec2 rise_1 = slope * (at_1 - at.xy * shadow_scale.y);
  at_0 *= shadow_scale.z;
  at_1 *= shadow_scale.z;
  float sum = weight_0.x * weight_0.y * texture(shadow_maps, vec4(at_0, layer, at.z + rise_0.x + rise_0.y));
  sum += weight_1.x * weight_0.y *
         texture(shadow_maps, vec4(at_1.x, at_0.y, layer, at.z + rise_1.x + rise_0.y));
  sum += weight_0.x * weight_1.y *
         texture(shadow_maps, vec4(at_0.x, at_1.y, layer, at.z + rise_0.x + rise_1.y));
  sum += weight_1.x * weight_1.y * texture(shadow_maps, vec4(at_1, layer, at.z + rise_1.x + rise_1.y));
  return sum / 16.0;
}

// Inside a map, so far from its sides that the tent and the normal's offset stay in it.
bool covers(vec4 box, vec2 light) {
  vec2 from_middle = abs(light * box.z + box.xy - 0.5);
  return max(from_middle.x, from_middle.y) < 0.5 - KARST_SHADOW_BORDER * shadow_scale.z;
}

// The smallest map that covers a place in light space, and its box; -1 where none does.
int cascade_of(vec2 light, out vec4 box) {
  int map = 0;
  box = shadow_box_0;
  if (shadow_scale.x > 1.0 && !covers(box, light)) {
    map = 1;
    box = shadow_box_1;
  }
  if (shadow_scale.x > 2.0 && !covers(box, light)) {
    map = 2;
    box = shadow_box_2;
  }
  return shadow_scale.x < 1.0 || !covers(box, light) ? -1 : map;
}

// 0 in shadow, 1 in the sun. from_eye: voxels. normal: of the surface, unit length.
float sun_reaches(vec3 from_eye, vec3 normal) {
  vec2 light = vec2(dot(shadow_x.xyz, from_eye), dot(shadow_y.xyz, from_eye));
  vec4 box;
  int map = cascade_of(light, box);
  if (map < 0) return 1.0;
  vec3 in_light = vec3(dot(shadow_x.xyz, normal), dot(shadow_y.xyz, normal), dot(sun_direction.xyz, normal));
  float ahead = dot(ray_forward.xyz, from_eye);
  float r2 = max(dot(from_eye, from_eye), 1e-6);
  float strays = shadow_x.w * sqrt(r2) * clamp(kStraysFrom * (1.0 - ahead * ahead / r2), 0.0, 1.0);
  strays = min(strays, kMostStrayTexels * box.w);
  vec3 moved = from_eye + normal * (kNormalTexels * box.w + strays);
  vec2 at = vec2(dot(shadow_x.xyz, moved), dot(shadow_y.xyz, moved)) * box.z + box.xy;
  vec2 slope = in_light.xy / max(in_light.z, kLeastFacing) * (box.w * shadow_scale.w);
  float depth = dot(shadow_z.xyz, moved) + shadow_z.w;
  depth -= kSlopeTexels * (abs(slope.x) + abs(slope.y)) + kDepthSteps;
  return tent(vec3(at, depth), slope, float(map));
}
