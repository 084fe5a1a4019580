// SPDX-License-Identifier: MIT
// From linear light to the eight bits of the picture.

// Light that is brighter than the picture can show keeps its hue and rolls off instead of clipping: within
// 1.2 of 255 of K. Narkowicz, "ACES Filmic Tone Mapping Curve", 2015, at an exposure of 0.66, encoded as IEC
// 61966-2-1 says. A fit over the root of light: a root and a division a channel instead of a power.
const float kWhiteRoot = 3.7;
vec3 display_value(vec3 light) {
  vec3 s = min(sqrt(max(light, 0.0)), kWhiteRoot);
  return max(s * (-0.0893 + s * (3.9806 + s * -0.01675)) / (1.0 + s * (-0.398 + s * 3.9345)), 0.0);
}

// Half a step of noise before rounding to eight bits, so that slow gradients show no bands: J. Jimenez,
// "Next Generation Post Processing in Call of Duty", 2014 (interleaved gradient noise).
float dither() {
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  return (noise - 0.5) / 255.0;
}

vec4 picture_colour(vec3 light) { return vec4(display_value(light) + dither(), 1.0); }
