#version 300 es
// SPDX-License-Identifier: MIT
// How a picture is made, in place of its materials: which shadow map a pixel is looked up in
// (KARST_SHOW_CASCADES), or the triangles, each of one shade, coloured by their level of detail or their
// node's size (KARST_SHOW_LEVELS).
precision highp float;
precision highp int;
#include "interface.glsl"
#include "output.glsl"
#include "target_colour.glsl"
#include "cull.glsl"
#ifdef KARST_SHOW_CASCADES
#include "shadow.glsl"
#endif

uniform int shown_level;  // of all patches that are drawn with this call, 1..6

#ifdef KARST_SHOW_LEVELS
flat in int node_size;  // or a mesh's, or less than 0 of a patch
#endif
in vec3 normal_ws;
in vec3 from_eye_ws;

out vec4 colour;

// Linear light. Levels from the coarsest on, and nodes' sizes from the sixth down, the same every six sizes;
// maps from the smallest on, and what none covers.
const vec3 kLevels[6] = vec3[6](vec3(0.10, 0.16, 0.45), vec3(0.05, 0.38, 0.50), vec3(0.10, 0.45, 0.14),
                                vec3(0.55, 0.48, 0.06), vec3(0.60, 0.22, 0.05), vec3(0.55, 0.05, 0.10));
const vec3 kMaps[4] = vec3[4](vec3(0.60, 0.10, 0.08), vec3(0.12, 0.45, 0.12), vec3(0.10, 0.18, 0.55),
                              vec3(0.35, 0.35, 0.35));
const float kAmbient = 0.35;

void main() {
  cull_back_face();
#ifdef KARST_SHOW_CASCADES
  vec3 normal = normalize(normal_ws);
  vec4 box;
  int map = cascade_of(vec2(dot(shadow_x.xyz, from_eye_ws), dot(shadow_y.xyz, from_eye_ws)), box);
  vec3 shown = kMaps[map < 0 ? 3 : map];
  float reached = sun_reaches(from_eye_ws, normal);
#else
  // The triangle's own normal, which shows where it ends.
  vec3 normal = normalize(cross(dFdx(from_eye_ws), dFdy(from_eye_ws)));
  // It points at the eye, unless the picture is mirrored.
  normal *= -sign(dot(normal, view_scale.z > 0.5 ? ray_forward.xyz : from_eye_ws));
  vec3 shown = kLevels[node_size < 0 ? clamp(shown_level, 1, 6) - 1 : 5 - node_size % 6];
  float reached = 1.0;
#endif
  float sun = max(dot(normal, sun_direction.xyz), 0.0) * reached;
  colour = target_colour(shown * mix(kAmbient, 1.0, sun) * 2.0);
}
