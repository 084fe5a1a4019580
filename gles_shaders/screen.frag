#version 300 es
// SPDX-License-Identifier: MIT
// Shades what is in the G-buffer, a pixel once, and the sky around it; into the host's framebuffer, with
// depth, so that what the host draws meets the terrain either way round.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "output.glsl"
#include "target_colour.glsl"
#include "sky_colour.glsl"
#include "water.glsl"
#include "background.glsl"
#include "light.glsl"
#include "geometry.glsl"

uniform highp usampler2D geometry;

in vec3 ray_ws;
out vec4 colour;

void main() {
  uvec2 texel = texelFetch(geometry, ivec2(gl_FragCoord.xy) - screen_place.xy, 0).xy;
  if (texel.y == 0u) {
    if (screen_place.z == 0) discard;
    colour = target_colour(background(normalize(ray_ws)));
    gl_FragDepth = screen_scale.y;
    return;
  }
  float over_w = uintBitsToFloat(texel.y);
  vec3 from_eye = ray_ws * (screen_scale.x / over_w);
  vec3 in_voxel = camera_fine.xyz / KARST_STEPS_PER_VOXEL + from_eye;
  Point point = Point(unpack_normal(texel.x), from_eye, camera_voxel.xyz, in_voxel,
                      int(texel.x >> KARST_GEOMETRY_MATERIAL_SHIFT & 15u) - 1,
                      (texel.x >> KARST_GEOMETRY_CAVE_SHIFT & 1u) > 0u);
  colour = target_colour(light_from(point));
  // Depth as the vertices have it, by the row of clip z.
  float z = dot(screen_depth.xyz, from_eye) + screen_depth.w;
  gl_FragDepth = z * over_w * screen_scale.z + screen_scale.w;
}
