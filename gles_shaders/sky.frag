#version 300 es
// SPDX-License-Identifier: MIT
// What is behind the terrain.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "output.glsl"
#include "target_colour.glsl"
#include "level.glsl"
#include "sky_colour.glsl"
#include "water.glsl"
#include "background.glsl"

in vec3 ray_ws;
out vec4 colour;

void main() { colour = target_colour(background(normalize(ray_ws))); }
