// SPDX-License-Identifier: MIT
// The sky with the sun's disc, as the eye sees it.

// Cosines of the angles at which the disc begins and ends to fade: 0.35 and 0.27 degrees (the sun's radius
// is 0.27).
const float kSunOuter = 0.99998134;
const float kSunInner = 0.99998889;

// direction: unit length.
vec3 sky_with_sun(vec3 direction) {
  vec3 light = sky_colour(direction);
  return light + sun_light.rgb * (6.0 * smoothstep(kSunOuter, kSunInner, dot(direction, sun_direction.xyz)));
}
