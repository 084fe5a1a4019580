// SPDX-License-Identifier: MIT
// The sky as a function of direction. Terrain uses it too, for what it fades to in the distance.

// direction: unit length. Without the disc of the sun.
vec3 sky_colour(vec3 direction) {
#ifdef KARST_CURVED
  float above = (dot(direction, level_top.xyz) + level_top.w) / (1.0 + level_top.w);
#else
  float above = direction.y;
#endif
  // Air mass grows steeply towards the horizon: most of the gradient lies in the lowest third.
  float height = max(above, 0.0);
  float low = 1.0 - height;
  vec3 sky = mix(sky_horizon.rgb, sky_zenith.rgb, 1.0 - low * low * low * sqrt(low));
  // Below the horizon there is no ground to see around the world: haze that darkens slowly downwards.
  sky *= 1.0 - 0.45 * smoothstep(0.0, 1.0, -above);
  // Forward scattering around the sun: a wide, weak glow.
  float towards_sun = max(dot(direction, sun_direction.xyz), 0.0);
  towards_sun *= towards_sun;
  towards_sun *= towards_sun;
  return sky + sun_light.rgb * (0.04 * towards_sun * towards_sun);
}
