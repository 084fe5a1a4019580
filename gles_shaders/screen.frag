#version 300 es
// SPDX-License-Identifier: MIT
// Shades what is in the G-buffer, a pixel once; into the host's framebuffer, with depth, so that what the
// host draws meets the terrain either way round, or where that has the G-buffer's own depth, by a test of it
// (KARST_SHARE_DEPTH). Where silhouettes are smoothed (KARST_EDGES), the background too.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "output.glsl"
#include "target_colour.glsl"
#include "level.glsl"
#include "sky_colour.glsl"
#include "water.glsl"
#ifdef KARST_EDGES
#include "background.glsl"
#endif
#include "light.glsl"
#include "geometry.glsl"

uniform highp usampler2D geometry;
#ifdef KARST_VOXEL_MATERIALS
uniform highp usampler2D geometry_voxels;  // of geometry.frag
#define KARST_AT_VOXELS , unpack_voxels(texelFetch(geometry_voxels, place, 0).x)
#else
#define KARST_AT_VOXELS
#endif

#ifdef KARST_EDGES
#include "silhouette.glsl"
#endif

in vec3 ray_ws;
out vec4 colour;

vec3 from_eye_of(float over_w) { return ray_ws * (screen_scale.x / over_w); }

// llvmpipe takes the footprints of a lookup in several places from one pixel of each block of 2 x 2, whether
// that is shaded or not: where it shows no terrain, it has what another one of its block shows.
#if KARST_ANISOTROPY > 1
uvec2 of_block(ivec2 place, uvec2 texel) {
  ivec2 other = (ivec2(gl_FragCoord.xy) ^ 1) - ivec2(gl_FragCoord.xy);
  if (texel.y == 0u) texel = texelFetch(geometry, place + ivec2(0, other.y), 0).xy;
  if (texel.y == 0u) texel = texelFetch(geometry, place + ivec2(other.x, 0), 0).xy;
  if (texel.y == 0u) texel = texelFetch(geometry, place + other, 0).xy;
  return texel;
}
#else
uvec2 of_block(ivec2 place, uvec2 texel) { return texel; }
#endif

// place: of the texel.
vec4 colour_of(uvec2 texel, ivec2 place) {
#ifdef KARST_EDGES
  if (texel.y == 0u) return target_colour(background(normalize(ray_ws)));
#endif
  vec3 from_eye = from_eye_of(uintBitsToFloat(texel.y));
  vec3 in_voxel = camera_fine.xyz / KARST_STEPS_PER_VOXEL + from_eye;
  Point point = Point(unpack_normal(texel.x), from_eye, camera_voxel.xyz, in_voxel,
                      int(texel.x >> KARST_GEOMETRY_MATERIAL_SHIFT & 15u) - 1,
                      (texel.x >> KARST_GEOMETRY_CAVE_SHIFT & 1u) > 0u KARST_AT_VOXELS
#ifdef KARST_CURVED
                      , level_height(from_eye)
#ifdef KARST_IMAGERY
                      , vec2(0.0)  // never drawn: images on a curved basis are shaded while they are drawn
#endif
#endif
  );
  return target_colour(light_from(point));
}

void main() {
  ivec2 place = ivec2(gl_FragCoord.xy) - screen_place.xy;
  uvec2 texel = texelFetch(geometry, place, 0).xy;
#ifdef KARST_EDGES
  if (texel.y == 0u && (screen_place.z & 1) == 0) discard;
  colour = colour_of(texel, place);
#else
  colour = colour_of(of_block(place, texel), place);
#ifndef KARST_SHARE_DEPTH
  if (texel.y == 0u) discard;
#endif
#endif
  float over_w = uintBitsToFloat(texel.y);
#ifdef KARST_EDGES
  Silhouette edge = silhouette_at(place, over_w);
  if (edge.cover > 0.0) {
    ivec2 beside = place + edge.side;
    colour = mix(colour, colour_of(texelFetch(geometry, beside, 0).xy, beside), edge.cover);
  }
#endif
#ifndef KARST_SHARE_DEPTH
  gl_FragDepth = screen_scale.y;
  if (texel.y > 0u) {
    // Depth as the vertices have it, by the row of clip z.
    float z = dot(screen_depth.xyz, from_eye_of(over_w)) + screen_depth.w;
    gl_FragDepth = z * over_w * screen_scale.z + screen_scale.w;
    if ((screen_place.z & 2) != 0) {
      // In two ranges.
      vec2 range = over_w >= screen_scale.z ? screen_depth.xy : screen_depth.zw;
      gl_FragDepth = range.x + range.y * over_w;
    }
  }
#endif
}
