// SPDX-License-Identifier: MIT
// Back faces, where the driver would drop them by corners that are not rounded yet (GlCaps::culls_unrounded):
// to a pixel a triangle faces as it is rasterised.

void cull_back_face() {
#ifdef KARST_CULL_PIXELS
  if (!gl_FrontFacing) discard;
#endif
}
