// SPDX-License-Identifier: MIT
// The uniform block of air.glsl, shared by GLSL and C++ like interface.glsl. Values are those of FrameBlock's
// members of the same names.
KARST_BLOCK(KarstAir) {
  mat4 karst_world;  // from places less the eye, simulator's frame and metres, to the world's axes and voxels
  vec4 karst_sun_direction;
  vec4 karst_sun_light;
  vec4 karst_sky_light;
  vec4 karst_ground_light;
  vec4 karst_sky_zenith;
  vec4 karst_sky_horizon;
  vec4 karst_view_scale;
  vec4 karst_ray_forward;
  vec4 karst_shadow_x;
  vec4 karst_shadow_y;
  vec4 karst_shadow_z;
  vec4 karst_shadow_box_0;
  vec4 karst_shadow_box_1;
  vec4 karst_shadow_box_2;
  vec4 karst_shadow_scale;
  vec4 karst_water;
  vec4 karst_water_wave[6];  // KARST_WAVES
};
