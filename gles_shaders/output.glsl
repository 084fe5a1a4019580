// SPDX-License-Identifier: MIT
// From linear light to the eight bits of the picture.

// Light that is brighter than the picture can show keeps its hue and rolls off instead of clipping. Fit of
// the ACES filmic curve: K. Narkowicz, "ACES Filmic Tone Mapping Curve", 2015.
const float kExposure = 0.66;
vec3 tone_map(vec3 light) {
  vec3 x = light * kExposure;
  return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

// IEC 61966-2-1.
vec3 encode_srgb(vec3 linear) {
  return mix(linear * 12.92, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, linear));
}

// Half a step of noise before rounding to eight bits, so that slow gradients show no bands: J. Jimenez,
// "Next Generation Post Processing in Call of Duty", 2014 (interleaved gradient noise).
float dither() {
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  return (noise - 0.5) / 255.0;
}

vec4 picture_colour(vec3 light) { return vec4(encode_srgb(tone_map(light)) + dither(), 1.0); }
