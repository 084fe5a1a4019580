// SPDX-License-Identifier: MIT
// Sources: OpenGL ES 3.2, chapter 21 (state tables); OpenGL 4.6 core profile, chapter 23.
#include "renderer/gl/gl_state.h"

namespace karst::core {
namespace {

// Of OpenGL ES 3.1 and OpenGL; headers of ES 3.0 do not have them.
constexpr GLenum kSampleMask = 0x8E51;
constexpr GLenum kColourLogicOp = 0x0BF2;
constexpr GLenum kPolygonSmooth = 0x0B41;
constexpr GLenum kPrimitiveRestart = 0x8F9D;
constexpr GLenum kLastVertexConvention = 0x8E4E;
constexpr GLenum kUnpackSwapBytes = 0x0CF0;
constexpr GLenum kUnpackCompressedBlockWidth = 0x9127;  // height, depth and size follow

void set(const Gl& gl, GLenum capability, bool on) {
  if (on) {
    gl.Enable(capability);
  } else {
    gl.Disable(capability);
  }
}

// Off initially, and karst has no use for it.
constexpr GLenum kOff[] = {GL_BLEND,
                           GL_POLYGON_OFFSET_FILL,
                           GL_PRIMITIVE_RESTART_FIXED_INDEX,
                           GL_RASTERIZER_DISCARD,
                           GL_SAMPLE_ALPHA_TO_COVERAGE,
                           GL_SAMPLE_COVERAGE,
                           GL_SCISSOR_TEST,
                           GL_STENCIL_TEST};
constexpr GLenum kOffOnDesktop[] = {kColourLogicOp, kPolygonSmooth, kPrimitiveRestart};

constexpr GLenum kUnpackZero[] = {GL_UNPACK_ROW_LENGTH, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_ROWS,
                                  GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_IMAGES};

// What draw calls need as it is initially.
void set_initial(const GlDevice& device) {
  const Gl& gl = device.gl;
  const GlCaps& caps = device.caps;
  for (const GLenum capability : kOff) gl.Disable(capability);
  gl.Enable(GL_DITHER);
  gl.DepthRangef(0.0f, 1.0f);
  gl.CullFace(GL_BACK);
  if (caps.sample_mask) gl.Disable(kSampleMask);
  if (caps.sample_shading) gl.Disable(GL_SAMPLE_SHADING_OES);
  if (caps.depth_clamp) gl.Disable(GL_DEPTH_CLAMP_EXT);
  if (caps.polygon_mode) gl.PolygonModeNV(GL_FRONT_AND_BACK, GL_FILL_NV);
  if (caps.multisample_switch) {
    gl.Enable(GL_MULTISAMPLE_EXT);
    gl.Disable(GL_SAMPLE_ALPHA_TO_ONE_EXT);
  }
  for (std::int32_t n = 0; n < caps.max_clip_distances; ++n) {
    gl.Disable(GL_CLIP_DISTANCE0_EXT + static_cast<GLenum>(n));
  }
  if (!caps.desktop) return;
  for (const GLenum capability : kOffOnDesktop) gl.Disable(capability);
  gl.ProvokingVertex(kLastVertexConvention);
}

void set_unpacking(const GlDevice& device) {
  const Gl& gl = device.gl;
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  for (const GLenum name : kUnpackZero) gl.PixelStorei(name, 0);
  if (!device.caps.desktop) return;
  gl.PixelStorei(kUnpackSwapBytes, 0);
  for (GLenum n = 0; n < 4; ++n) gl.PixelStorei(kUnpackCompressedBlockWidth + n, 0);
}

}  // namespace

void enter_draw(const GlDevice& device, const DrawState& state) {
  const Gl& gl = device.gl;
  set_initial(device);
  const Rect& view = state.viewport;
  gl.Viewport(view.x, view.y, view.width, view.height);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(state.depth_func);
  gl.DepthMask(state.depth_writes ? GL_TRUE : GL_FALSE);
  const GLboolean colour = state.colour_writes ? GL_TRUE : GL_FALSE;
  gl.ColorMask(colour, colour, colour, colour);
  set(gl, GL_CULL_FACE, state.cull);
  gl.FrontFace(state.mirrored ? GL_CW : GL_CCW);
  if (device.caps.clip_control) {
    gl.ClipControlEXT(GL_LOWER_LEFT_EXT,
                      state.depth_zero_to_one ? GL_ZERO_TO_ONE_EXT : GL_NEGATIVE_ONE_TO_ONE_EXT);
  }
  if (device.caps.srgb_switch) set(gl, GL_FRAMEBUFFER_SRGB_EXT, state.linear);
}

void reset_state(const GlDevice& device) {
  const Gl& gl = device.gl;
  set_initial(device);
  gl.Disable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_LESS);
  gl.DepthMask(GL_TRUE);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl.Disable(GL_CULL_FACE);
  gl.FrontFace(GL_CCW);
  if (device.caps.clip_control) gl.ClipControlEXT(GL_LOWER_LEFT_EXT, GL_NEGATIVE_ONE_TO_ONE_EXT);
  if (device.caps.srgb_switch) set(gl, GL_FRAMEBUFFER_SRGB_EXT, !device.caps.desktop);
  set_unpacking(device);
  gl.UseProgram(0);
  gl.BindVertexArray(0);
  gl.BindBuffer(GL_ARRAY_BUFFER, 0);
  // The last one unbinds the uniform buffer too.
  gl.BindBufferBase(GL_UNIFORM_BUFFER, device.first_block + 1, 0);
  gl.BindBufferBase(GL_UNIFORM_BUFFER, device.first_block, 0);
  gl.ActiveTexture(GL_TEXTURE0);
}

void enter_upload(const GlDevice& device) {
  set_unpacking(device);
  device.gl.ActiveTexture(GL_TEXTURE0 + device.first_unit);
}

void leave_upload(const GlDevice& device) {
  device.gl.ActiveTexture(GL_TEXTURE0);
}

}  // namespace karst::core
