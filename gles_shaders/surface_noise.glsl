// SPDX-License-Identifier: MIT
// Tri-planar texture coordinates (K 4.2.1, equations 4.4 and 4.5) and the noise texture on them, at three
// scales (K 4.2.2: a near texture for detail, a far one against visible repetition).
//
// The noise texture (renderer/noise_texture.h) holds: r, soft mottle; g, a rough height field; ba, the
// height field's slope in s and t. All are centred on 128/255, so the coarsest mip level is neutral and
// detail fades instead of flickering in the distance.

uniform sampler2D noise;

// epsilon of equation 4.4. K found 0.15 to 0.25 good; weights below it are exactly zero, so flat ground
// takes one fetch.
const float kTriplanarEpsilon = 0.2;
const float kNeutral = 128.0 / 255.0;
// log2 of the noise texture's side in texels.
const float kNoiseSideLog2 = 8.0;

vec3 triplanar_weights(vec3 normal) {
  vec3 z = max(abs(normal) - kTriplanarEpsilon, 0.0);
  return z / (z.x + z.y + z.z);
}

struct SurfaceNoise {
  float mottle;   // about -1..1
  float height;   // about -1..1
  vec3 gradient;  // of height, along the world's axes
};

// position: in repeats of the texture. lod: of a texture lookup; explicit because the lookups lie in
// branches, where implicit derivatives are undefined.
SurfaceNoise triplanar_noise(vec3 position, vec3 weights, float lod) {
  vec2 value = vec2(0.0);
  vec3 gradient = vec3(0.0);
  if (weights.x > 0.0) {
    vec4 t = textureLod(noise, position.zy, lod) - kNeutral;
    value += weights.x * t.xy;
    gradient.zy += weights.x * t.zw;
  }
  if (weights.y > 0.0) {
    vec4 t = textureLod(noise, position.xz, lod) - kNeutral;
    value += weights.y * t.xy;
    gradient.xz += weights.y * t.zw;
  }
  if (weights.z > 0.0) {
    vec4 t = textureLod(noise, position.xy, lod) - kNeutral;
    value += weights.z * t.xy;
    gradient.xy += weights.z * t.zw;
  }
  return SurfaceNoise(value.x * 2.0, value.y * 2.0, gradient * 2.0);
}
