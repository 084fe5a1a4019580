// SPDX-License-Identifier: MIT
// How much of the sun reaches a point, from the shadow maps of terrain/view/cascades.h.

uniform highp sampler2DArrayShadow shadow_maps;  // depth of what is nearest to the sun, a layer a cascade

// Where a point is looked up, so that a surface does not shade itself. The filter compares with texels up to
// 2 texels to each side. On a plane at the angle a to the light, depth changes by tan a a texel; moved by m
// along its normal, a point is m / cos a above it as the light sees it: m = 2 sin a is enough at every angle,
// and the shadow of what stands on the plane still begins at its foot. A texel more, because what casts is of
// a coarser level that is off by as much; and a little along the light for what is not plane.
const float kNormalTexels = 2.0;
const float kLevelTexels = 1.0;
const float kSlopeTexels = 0.25;
const float kMostSlope = 4.0;
// Steps of depth in a map of 16 bits.
const float kDepthSteps = 1.5 / 65535.0;

// A tent of 3 x 3 texels by four comparisons that the hardware filters: I. Castano, "Shadow Mapping Summary -
// Part 1", 2013 (the optimised filter of J. Blow's The Witness).
float tent(vec3 at, float layer) {
  vec2 texel = at.xy * shadow_scale.y + 0.5;
  vec2 base = floor(texel);
  vec2 part = texel - base;
  vec2 weight_0 = 3.0 - 2.0 * part;
  vec2 weight_1 = 1.0 + 2.0 * part;
  vec2 at_0 = (base - 0.5 + (2.0 - part) / weight_0 - 1.0) * shadow_scale.z;
  vec2 at_1 = (base - 0.5 + part / weight_1 + 1.0) * shadow_scale.z;
  float sum = weight_0.x * weight_0.y * texture(shadow_maps, vec4(at_0, layer, at.z));
  sum += weight_1.x * weight_0.y * texture(shadow_maps, vec4(at_1.x, at_0.y, layer, at.z));
  sum += weight_0.x * weight_1.y * texture(shadow_maps, vec4(at_0.x, at_1.y, layer, at.z));
  sum += weight_1.x * weight_1.y * texture(shadow_maps, vec4(at_1, layer, at.z));
  return sum / 16.0;
}

// Inside a map, so far from its sides that the tent and the normal's offset stay in it.
bool covers(vec4 box, vec2 light) {
  vec2 from_middle = abs(light * box.z + box.xy - 0.5);
  return max(from_middle.x, from_middle.y) < 0.5 - KARST_SHADOW_BORDER * shadow_scale.z;
}

// 0 in shadow, 1 in the sun. from_eye: voxels. normal: of the surface, unit length.
float sun_reaches(vec3 from_eye, vec3 normal) {
  vec2 light = vec2(dot(shadow_x.xyz, from_eye), dot(shadow_y.xyz, from_eye));
  float layer = 0.0;
  vec4 box = shadow_box_0;
  if (shadow_scale.x > 1.0 && !covers(box, light)) {
    layer = 1.0;
    box = shadow_box_1;
  }
  if (shadow_scale.x > 2.0 && !covers(box, light)) {
    layer = 2.0;
    box = shadow_box_2;
  }
  if (shadow_scale.x < 1.0 || !covers(box, light)) return 1.0;
  float facing = max(dot(normal, sun_direction.xyz), 0.05);
  float across = sqrt(max(1.0 - facing * facing, 0.0));
  vec3 moved = from_eye + normal * ((kNormalTexels * across + kLevelTexels) * box.w);
  vec2 at = vec2(dot(shadow_x.xyz, moved), dot(shadow_y.xyz, moved)) * box.z + box.xy;
  float depth = dot(shadow_z.xyz, moved) + shadow_z.w;
  depth -= kSlopeTexels * box.w * min(across / facing, kMostSlope) * shadow_scale.w + kDepthSteps;
  return tent(vec3(at, clamp(depth, 0.0, 1.0)), layer);
}
