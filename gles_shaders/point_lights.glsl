// SPDX-License-Identifier: MIT
// Lamps in caves (K 4.1, equation 4.2).

#ifdef KARST_LAMPS
// from_eye: voxels.
KARST_MEDIUM vec3 light_of_lamps(vec3 from_eye, KARST_MEDIUM vec3 normal) {
  KARST_MEDIUM vec3 sum = vec3(0.0);
  for (int n = 0; n < int(light_scale.x); ++n) {
    vec3 way = light_place[n].xyz - from_eye;
    float d = max(length(way), 1e-3);
    float reach = light_place[n].w;
    KARST_MEDIUM float fades = max(reach - d, 0.0) / reach;
    sum += light_colour[n].rgb * (max(dot(normal, way / d), 0.0) * fades);
  }
  return sum;
}
#endif
