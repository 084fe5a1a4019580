#version 300 es
// SPDX-License-Identifier: MIT
// A terrain vertex of a pass that writes depth alone: the same place as in every other pass.
precision highp float;
precision highp int;
#include "interface.glsl"
#include "terrain_vertex.glsl"

void main() { gl_Position = clip_from_lattice * vec4(read_terrain_vertex().position, 1.0); }
