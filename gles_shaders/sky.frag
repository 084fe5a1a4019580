#version 300 es
// SPDX-License-Identifier: MIT
// The sky behind the terrain, with the sun's disc.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "output.glsl"
#include "target_colour.glsl"
#include "sky_colour.glsl"

in vec3 ray_ws;
out vec4 colour;

// Cosines of the angles at which the disc begins and ends to fade: 0.35 and 0.27 degrees (the sun's radius
// is 0.27).
const float kSunOuter = 0.99998134;
const float kSunInner = 0.99998889;

void main() {
  vec3 direction = normalize(ray_ws);
  vec3 light = sky_colour(direction);
  light += sun_light.rgb * (6.0 * smoothstep(kSunOuter, kSunInner, dot(direction, sun_direction.xyz)));
  colour = target_colour(light);
}
