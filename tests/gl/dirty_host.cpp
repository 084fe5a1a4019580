// SPDX-License-Identifier: MIT
#include "tests/gl/dirty_host.h"

#include <cstring>

#include <gtest/gtest.h>

#include "platform/headless/headless_display.h"

namespace karst::test {
namespace {

// What headers of OpenGL ES 3.0 do not have.
constexpr GLenum kTextureBuffer = 0x8C2A;
constexpr GLenum kSampleMask = 0x8E51, kSampleShading = 0x8C36, kDepthClamp = 0x864F;
constexpr GLenum kClipDistance0 = 0x3000, kFramebufferSrgb = 0x8DB9;
constexpr GLenum kColourLogicOp = 0x0BF2, kPolygonSmooth = 0x0B41, kMultisample = 0x809D;
constexpr GLenum kSampleAlphaToOne = 0x809F, kPrimitiveRestart = 0x8F9D, kPolygonMode = 0x0B40;
constexpr GLenum kLine = 0x1B01, kFill = 0x1B02, kProvokingVertex = 0x8E4F;
constexpr GLenum kFirstVertexConvention = 0x8E4D, kLastVertexConvention = 0x8E4E;
constexpr GLenum kUpperLeft = 0x8CA2, kLowerLeft = 0x8CA1, kZeroToOne = 0x935F, kNegativeOneToOne = 0x935E;
constexpr GLenum kClipOrigin = 0x935C, kClipDepthMode = 0x935D;
constexpr GLenum kUnpackSwapBytes = 0x0CF0, kUnpackCompressedBlockWidth = 0x9127;
constexpr GLenum kShaderStorageBuffer = 0x90D2, kDrawIndirectBuffer = 0x8F3F;

using VoidFunction = void();

constexpr int kBufferBytes = 256;
constexpr int kSide = 4;  // texels of foreign textures

std::vector<std::uint8_t> pattern(std::size_t bytes, unsigned seed) {
  std::vector<std::uint8_t> out(bytes);
  for (std::size_t i = 0; i < bytes; ++i) out[i] = static_cast<std::uint8_t>(i * 37 + seed * 101 + 11);
  return out;
}

EglApi egl_for(Api api) {
  EglApi egl = linked_egl();
  if (api == Api::es) return egl;
  egl.bind_api = [](EGLenum) { return eglBindAPI(EGL_OPENGL_API); };
  egl.create_context = [](EGLDisplay display, EGLConfig config, EGLContext share, const EGLint*) {
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 3,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    return eglCreateContext(display, config, share, attributes);
  };
  return egl;
}

}  // namespace

// Calls a GL function by its name and the types of its arguments, which are those of the function.
#define KARST_CALL(name, ...) host_.get<decltype(::name)>(#name)(__VA_ARGS__)

HostContext::HostContext(Api api) : api_(api) {
  Error error;
  display_ = open_headless_display({}, error, egl_for(api));
  EXPECT_NE(display_, nullptr) << error.text();
  if (display_ == nullptr) return;
  for (int i = 0; i < integer(GL_NUM_EXTENSIONS); ++i) {
    const GLubyte* name =
        get<decltype(::glGetStringi)>("glGetStringi")(GL_EXTENSIONS, static_cast<GLuint>(i));
    extensions_.insert(reinterpret_cast<const char*>(name));
  }
  version_ = 10 * integer(GL_MAJOR_VERSION) + integer(GL_MINOR_VERSION);
}

GlLoader HostContext::loader() {
  return {.load = [](void* user, const char* name) { return static_cast<Display*>(user)->gl_function(name); },
          .user = display_.get()};
}

int HostContext::integer(GLenum name) const {
  GLint values[4] = {};
  get<decltype(::glGetIntegerv)>("glGetIntegerv")(name, values);
  return values[0];
}

HostTarget::HostTarget(const HostContext& host, int samples) : host_(host) {
  const auto make = [&](int count) {
    GLuint buffers[2] = {};
    GLuint framebuffer = 0;
    KARST_CALL(glGenRenderbuffers, 2, buffers);
    KARST_CALL(glGenFramebuffers, 1, &framebuffer);
    KARST_CALL(glBindFramebuffer, GL_FRAMEBUFFER, framebuffer);
    for (int i = 0; i < 2; ++i) {
      KARST_CALL(glBindRenderbuffer, GL_RENDERBUFFER, buffers[i]);
      KARST_CALL(glRenderbufferStorageMultisample, GL_RENDERBUFFER, count,
                 i == 0 ? GL_SRGB8_ALPHA8 : GL_DEPTH24_STENCIL8, kWidth, kHeight);
      KARST_CALL(glFramebufferRenderbuffer, GL_FRAMEBUFFER,
                 i == 0 ? GL_COLOR_ATTACHMENT0 : GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, buffers[i]);
    }
    EXPECT_EQ(KARST_CALL(glCheckFramebufferStatus, GL_FRAMEBUFFER), GLenum{GL_FRAMEBUFFER_COMPLETE});
    return framebuffer;
  };
  framebuffer_ = make(samples);
  resolved_ = samples > 0 ? make(0) : framebuffer_;
}

void HostTarget::clear(float depth) const {
  KARST_CALL(glBindFramebuffer, GL_FRAMEBUFFER, framebuffer_);
  KARST_CALL(glDisable, GL_SCISSOR_TEST);
  KARST_CALL(glDisable, GL_RASTERIZER_DISCARD);
  KARST_CALL(glColorMask, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  KARST_CALL(glDepthMask, GL_TRUE);
  KARST_CALL(glStencilMask, 0xffu);
  if (host_.api() == Api::desktop || host_.has("GL_EXT_sRGB_write_control")) {
    KARST_CALL(glEnable, kFramebufferSrgb);
  }
  const GLfloat colour[4] = {0.5f, 0.25f, 0.75f, 1.0f};
  KARST_CALL(glClearBufferfv, GL_COLOR, 0, colour);
  KARST_CALL(glClearBufferfi, GL_DEPTH_STENCIL, 0, depth, 77);
}

std::vector<std::uint8_t> HostTarget::picture() const {
  KARST_CALL(glDisable, GL_SCISSOR_TEST);
  KARST_CALL(glBindFramebuffer, GL_READ_FRAMEBUFFER, framebuffer_);
  if (resolved_ != framebuffer_) {
    KARST_CALL(glBindFramebuffer, GL_DRAW_FRAMEBUFFER, resolved_);
    KARST_CALL(glBlitFramebuffer, 0, 0, kWidth, kHeight, 0, 0, kWidth, kHeight, GL_COLOR_BUFFER_BIT,
               GL_NEAREST);
    KARST_CALL(glBindFramebuffer, GL_READ_FRAMEBUFFER, resolved_);
  }
  KARST_CALL(glBindBuffer, GL_PIXEL_PACK_BUFFER, 0u);
  for (const int name : {GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS}) {
    KARST_CALL(glPixelStorei, static_cast<GLenum>(name), 0);
  }
  KARST_CALL(glPixelStorei, GL_PACK_ALIGNMENT, 4);
  std::vector<std::uint8_t> rgba(std::size_t{kWidth} * kHeight * 4);
  KARST_CALL(glReadPixels, 0, 0, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  return rgba;
}

DirtyHost::DirtyHost(const HostContext& host) : host_(host) {
  clean_up();
  make_textures();
  make_buffers();
  make_vertex_array();
  make_framebuffers();
  make_program();
  make_rest();
  contents_ = contents();
  EXPECT_EQ(KARST_CALL(glGetError), GLenum{GL_NO_ERROR});
}

// Another host may have left its state.
void DirtyHost::clean_up() {
  KARST_CALL(glBindBuffer, GL_PIXEL_UNPACK_BUFFER, 0u);
  KARST_CALL(glPixelStorei, GL_UNPACK_ALIGNMENT, 4);
  for (const int name : {GL_UNPACK_ROW_LENGTH, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_ROWS,
                         GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_IMAGES}) {
    KARST_CALL(glPixelStorei, static_cast<GLenum>(name), 0);
  }
  if (host_.api() == Api::desktop) KARST_CALL(glPixelStorei, kUnpackSwapBytes, 0);
  KARST_CALL(glDisable, GL_SCISSOR_TEST);
  KARST_CALL(glDisable, GL_RASTERIZER_DISCARD);
  KARST_CALL(glColorMask, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void DirtyHost::make_textures() {
  textures_ = {{GL_TEXTURE_2D, GL_TEXTURE_BINDING_2D, 0},
               {GL_TEXTURE_3D, GL_TEXTURE_BINDING_3D, 0},
               {GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BINDING_2D_ARRAY, 0},
               {GL_TEXTURE_CUBE_MAP, GL_TEXTURE_BINDING_CUBE_MAP, 0}};
  for (Texture& texture : textures_) {
    KARST_CALL(glGenTextures, 1, &texture.name);
    KARST_CALL(glBindTexture, texture.target, texture.name);
    const auto texels = pattern(std::size_t{kSide} * kSide * kSide * 4, texture.target);
    if (texture.target == GL_TEXTURE_3D || texture.target == GL_TEXTURE_2D_ARRAY) {
      KARST_CALL(glTexStorage3D, texture.target, 1, GL_RGBA8, kSide, kSide, kSide);
      KARST_CALL(glTexSubImage3D, texture.target, 0, 0, 0, 0, kSide, kSide, kSide, GL_RGBA, GL_UNSIGNED_BYTE,
                 texels.data());
    } else {
      KARST_CALL(glTexStorage2D, texture.target, 1, GL_RGBA8, kSide, kSide);
      for (GLenum face = 0; face < (texture.target == GL_TEXTURE_2D ? 1u : 6u); ++face) {
        const GLenum image =
            texture.target == GL_TEXTURE_2D ? GL_TEXTURE_2D : GL_TEXTURE_CUBE_MAP_POSITIVE_X + face;
        KARST_CALL(glTexSubImage2D, image, 0, 0, 0, kSide, kSide, GL_RGBA, GL_UNSIGNED_BYTE,
                   texels.data() + face * 16);
      }
    }
  }
}

void DirtyHost::make_buffers() {
  buffers_.resize(8);
  KARST_CALL(glGenBuffers, 8, buffers_.data());
  for (std::size_t i = 0; i < buffers_.size(); ++i) {
    const auto bytes = pattern(kBufferBytes, static_cast<unsigned>(i));
    KARST_CALL(glBindBuffer, GL_COPY_WRITE_BUFFER, buffers_[i]);
    KARST_CALL(glBufferData, GL_COPY_WRITE_BUFFER, kBufferBytes, bytes.data(), GL_DYNAMIC_DRAW);
  }
}

// Attributes at karst's locations, of other types, from buffer 0; elements in buffer 1.
void DirtyHost::make_vertex_array() {
  KARST_CALL(glGenVertexArrays, 1, &array_);
  KARST_CALL(glBindVertexArray, array_);
  KARST_CALL(glBindBuffer, GL_ARRAY_BUFFER, buffers_[0]);
  for (GLuint location = 0; location < 4; ++location) {
    KARST_CALL(glVertexAttribPointer, location, 3, GL_FLOAT, GL_FALSE, 20, nullptr);
    KARST_CALL(glEnableVertexAttribArray, location);
    KARST_CALL(glVertexAttribDivisor, location, 2);
  }
  KARST_CALL(glBindBuffer, GL_ELEMENT_ARRAY_BUFFER, buffers_[1]);
  KARST_CALL(glBindVertexArray, 0u);
}

void DirtyHost::make_framebuffers() {
  KARST_CALL(glGenFramebuffers, 1, &framebuffer_);
  KARST_CALL(glGenFramebuffers, 1, &read_framebuffer_);
  KARST_CALL(glGenFramebuffers, 1, &scratch_);
  KARST_CALL(glGenRenderbuffers, 1, &renderbuffer_);
  KARST_CALL(glBindRenderbuffer, GL_RENDERBUFFER, renderbuffer_);
  KARST_CALL(glRenderbufferStorage, GL_RENDERBUFFER, GL_RGBA8, kSide, kSide);
  KARST_CALL(glBindFramebuffer, GL_FRAMEBUFFER, read_framebuffer_);
  KARST_CALL(glFramebufferTexture2D, GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures_[0].name,
             0);
  KARST_CALL(glBindFramebuffer, GL_FRAMEBUFFER, framebuffer_);
  KARST_CALL(glFramebufferRenderbuffer, GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, renderbuffer_);
  const GLfloat colour[4] = {0.2f, 0.4f, 0.6f, 0.8f};
  KARST_CALL(glClearBufferfv, GL_COLOR, 0, colour);
}

void DirtyHost::make_program() {
  program_ = KARST_CALL(glCreateProgram);
  const char* const texts[2] = {
      "#version 300 es\nvoid main() { gl_Position = vec4(0); }\n",
      "#version 300 es\nprecision highp float; uniform vec4 u; out vec4 c; void main() { c = u; }\n"};
  for (int i = 0; i < 2; ++i) {
    const GLuint shader = KARST_CALL(glCreateShader, i == 0 ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
    KARST_CALL(glShaderSource, shader, 1, &texts[i], nullptr);
    KARST_CALL(glCompileShader, shader);
    KARST_CALL(glAttachShader, program_, shader);
    KARST_CALL(glDeleteShader, shader);
  }
  KARST_CALL(glLinkProgram, program_);
  KARST_CALL(glUseProgram, program_);
  KARST_CALL(glUniform4f, KARST_CALL(glGetUniformLocation, program_, "u"), 1.0f, 2.0f, 3.0f, 4.0f);
  KARST_CALL(glUseProgram, 0u);
}

void DirtyHost::make_rest() {
  KARST_CALL(glGenSamplers, 1, &sampler_);
  KARST_CALL(glSamplerParameteri, sampler_, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  KARST_CALL(glSamplerParameteri, sampler_, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  KARST_CALL(glSamplerParameteri, sampler_, GL_TEXTURE_WRAP_S, GL_MIRRORED_REPEAT);
  KARST_CALL(glGenTransformFeedbacks, 1, &feedback_);
  KARST_CALL(glGenQueries, 1, &query_);
}

void DirtyHost::dirty(GLuint framebuffer, bool error) const {
  KARST_CALL(glBindFramebuffer, GL_READ_FRAMEBUFFER, read_framebuffer_);
  KARST_CALL(glBindFramebuffer, GL_DRAW_FRAMEBUFFER, framebuffer == 0 ? framebuffer_ : framebuffer);
  KARST_CALL(glBindRenderbuffer, GL_RENDERBUFFER, renderbuffer_);
  KARST_CALL(glUseProgram, program_);
  KARST_CALL(glBindVertexArray, array_);
  set_switches();
  set_values();
  if (host_.api() == Api::desktop) set_desktop();
  set_extensions();
  set_pixels();
  bind_units();
  bind_buffers();
  EXPECT_EQ(KARST_CALL(glGetError), GLenum{GL_NO_ERROR});
  if (error) KARST_CALL(glEnable, 0xffffu);
}

void DirtyHost::set_switches() const {
  for (const int name : {GL_BLEND, GL_CULL_FACE, GL_DEPTH_TEST, GL_POLYGON_OFFSET_FILL,
                         GL_PRIMITIVE_RESTART_FIXED_INDEX, GL_RASTERIZER_DISCARD, GL_SAMPLE_ALPHA_TO_COVERAGE,
                         GL_SAMPLE_COVERAGE, GL_SCISSOR_TEST, GL_STENCIL_TEST}) {
    KARST_CALL(glEnable, static_cast<GLenum>(name));
  }
  KARST_CALL(glDisable, GL_DITHER);
  if (host_.api() == Api::desktop || host_.version() >= 31) {
    KARST_CALL(glEnable, kSampleMask);
    host_.get<void(GLuint, GLbitfield)>("glSampleMaski")(0, 1);
  }
  if (host_.api() == Api::desktop || host_.version() >= 32) {
    KARST_CALL(glEnable, kSampleShading);
    host_.get<void(GLfloat)>("glMinSampleShading")(1.0f);
  }
}

void DirtyHost::set_values() const {
  KARST_CALL(glBlendFunc, GL_ONE, GL_ONE);
  KARST_CALL(glBlendEquation, GL_FUNC_REVERSE_SUBTRACT);
  KARST_CALL(glClearColor, 0.9f, 0.1f, 0.2f, 0.3f);
  KARST_CALL(glClearDepthf, 0.25f);
  KARST_CALL(glClearStencil, 3);
  KARST_CALL(glColorMask, GL_FALSE, GL_TRUE, GL_FALSE, GL_FALSE);
  KARST_CALL(glCullFace, GL_FRONT);
  KARST_CALL(glDepthFunc, GL_NEVER);
  KARST_CALL(glDepthMask, GL_FALSE);
  KARST_CALL(glDepthRangef, 0.7f, 0.2f);
  KARST_CALL(glFrontFace, GL_CW);
  KARST_CALL(glPolygonOffset, -3.0f, 10000.0f);
  KARST_CALL(glSampleCoverage, 0.3f, GL_TRUE);
  KARST_CALL(glScissor, 1, 1, 2, 2);
  KARST_CALL(glStencilFunc, GL_NEVER, 5, 0xf0u);
  KARST_CALL(glStencilMask, 0x0fu);
  KARST_CALL(glStencilOp, GL_INVERT, GL_INVERT, GL_INVERT);
  KARST_CALL(glViewport, 3, 2, 5, 7);
}

void DirtyHost::set_desktop() const {
  for (const GLenum name : {kColourLogicOp, kPolygonSmooth, kSampleAlphaToOne, kPrimitiveRestart, kDepthClamp,
                            kFramebufferSrgb}) {
    KARST_CALL(glEnable, name);
  }
  for (GLenum n = 0; n < 8; ++n) KARST_CALL(glEnable, kClipDistance0 + n);
  KARST_CALL(glDisable, kMultisample);
  host_.get<void(GLenum)>("glLogicOp")(0x1506);  // XOR
  host_.get<void(GLenum, GLenum)>("glPolygonMode")(GL_FRONT_AND_BACK, kLine);
  host_.get<void(GLuint)>("glPrimitiveRestartIndex")(5);
  host_.get<void(GLenum)>("glProvokingVertex")(kFirstVertexConvention);
}

void DirtyHost::set_extensions() const {
  if (host_.has("GL_ARB_clip_control")) {
    host_.get<void(GLenum, GLenum)>("glClipControl")(kUpperLeft, kZeroToOne);
  }
  if (host_.has("GL_EXT_clip_control")) {
    host_.get<void(GLenum, GLenum)>("glClipControlEXT")(kUpperLeft, kZeroToOne);
  }
  if (host_.has("GL_EXT_depth_clamp")) KARST_CALL(glEnable, kDepthClamp);
  if (host_.has("GL_EXT_sRGB_write_control")) KARST_CALL(glDisable, kFramebufferSrgb);
  if (host_.has("GL_EXT_clip_cull_distance")) {
    for (GLenum n = 0; n < 8; ++n) KARST_CALL(glEnable, kClipDistance0 + n);
  }
}

// Of what is read from memory and written to it: rows that overlap, so that nothing lies outside.
void DirtyHost::set_pixels() const {
  for (const int name : {GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_IMAGES,
                         GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_ROWS}) {
    KARST_CALL(glPixelStorei, static_cast<GLenum>(name), 1);
  }
  KARST_CALL(glPixelStorei, GL_UNPACK_ALIGNMENT, 8);
  KARST_CALL(glPixelStorei, GL_UNPACK_ROW_LENGTH, 3);
  KARST_CALL(glPixelStorei, GL_UNPACK_IMAGE_HEIGHT, 2);
  KARST_CALL(glPixelStorei, GL_PACK_ALIGNMENT, 8);
  KARST_CALL(glPixelStorei, GL_PACK_ROW_LENGTH, 9);
  if (host_.api() == Api::es) return;
  KARST_CALL(glPixelStorei, kUnpackSwapBytes, 1);
  // Width, height, depth and size of a block.
  const int block[4] = {4, 4, 1, 16};
  for (GLenum n = 0; n < 4; ++n) KARST_CALL(glPixelStorei, kUnpackCompressedBlockWidth + n, block[n]);
}

void DirtyHost::bind_units() const {
  const int units = host_.integer(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS);
  for (int unit = 0; unit < units; ++unit) {
    KARST_CALL(glActiveTexture, GL_TEXTURE0 + static_cast<GLenum>(unit));
    for (const Texture& texture : textures_) KARST_CALL(glBindTexture, texture.target, texture.name);
    KARST_CALL(glBindSampler, static_cast<GLuint>(unit), sampler_);
  }
}

void DirtyHost::bind_buffers() const {
  KARST_CALL(glBindTransformFeedback, GL_TRANSFORM_FEEDBACK, feedback_);
  for (GLuint n = 0; n < 4; ++n) {
    KARST_CALL(glBindBufferBase, GL_TRANSFORM_FEEDBACK_BUFFER, n, buffers_[2]);
  }
  const int blocks = host_.integer(GL_MAX_UNIFORM_BUFFER_BINDINGS);
  for (int n = 0; n < blocks; ++n) {
    KARST_CALL(glBindBufferBase, GL_UNIFORM_BUFFER, static_cast<GLuint>(n), buffers_[3]);
  }
  KARST_CALL(glBindBuffer, GL_ARRAY_BUFFER, buffers_[4]);
  KARST_CALL(glBindBuffer, GL_COPY_READ_BUFFER, buffers_[5]);
  KARST_CALL(glBindBuffer, GL_COPY_WRITE_BUFFER, buffers_[6]);
  KARST_CALL(glBindBuffer, GL_PIXEL_PACK_BUFFER, buffers_[7]);
  KARST_CALL(glBindBuffer, GL_PIXEL_UNPACK_BUFFER, buffers_[7]);
  KARST_CALL(glBindBuffer, GL_UNIFORM_BUFFER, buffers_[3]);
  if (host_.api() == Api::es) return;
  KARST_CALL(glBindBuffer, kTextureBuffer, buffers_[5]);
  KARST_CALL(glBindBuffer, kShaderStorageBuffer, buffers_[5]);
  KARST_CALL(glBindBuffer, kDrawIndirectBuffer, buffers_[5]);
}

std::vector<std::uint8_t> DirtyHost::read_texture(const Texture& texture) const {
  std::vector<std::uint8_t> all;
  const int layers = texture.target == GL_TEXTURE_2D ? 1 : texture.target == GL_TEXTURE_CUBE_MAP ? 6 : kSide;
  for (int layer = 0; layer < layers; ++layer) {
    if (texture.target == GL_TEXTURE_2D || texture.target == GL_TEXTURE_CUBE_MAP) {
      const GLenum image = texture.target == GL_TEXTURE_2D
                               ? GL_TEXTURE_2D
                               : GL_TEXTURE_CUBE_MAP_POSITIVE_X + static_cast<GLenum>(layer);
      KARST_CALL(glFramebufferTexture2D, GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, image, texture.name, 0);
    } else {
      KARST_CALL(glFramebufferTextureLayer, GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, texture.name, 0,
                 layer);
    }
    std::uint8_t texels[kSide * kSide * 4] = {};
    KARST_CALL(glReadPixels, 0, 0, kSide, kSide, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    all.insert(all.end(), std::begin(texels), std::end(texels));
  }
  return all;
}

std::vector<std::uint8_t> DirtyHost::read_buffer(GLuint name) const {
  std::vector<std::uint8_t> bytes(kBufferBytes);
  KARST_CALL(glBindBuffer, GL_COPY_READ_BUFFER, name);
  GLint size = 0;
  KARST_CALL(glGetBufferParameteriv, GL_COPY_READ_BUFFER, GL_BUFFER_SIZE, &size);
  EXPECT_EQ(size, kBufferBytes);
  const void* mapped = KARST_CALL(glMapBufferRange, GL_COPY_READ_BUFFER, 0, kBufferBytes, GL_MAP_READ_BIT);
  if (mapped != nullptr) std::memcpy(bytes.data(), mapped, kBufferBytes);
  KARST_CALL(glUnmapBuffer, GL_COPY_READ_BUFFER);
  return bytes;
}

// All that foreign objects hold, one after the other.
std::vector<std::uint8_t> DirtyHost::contents() const {
  std::vector<std::uint8_t> all;
  const auto add = [&](const std::vector<std::uint8_t>& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  const auto add_integer = [&](GLint value) { all.push_back(static_cast<std::uint8_t>(value)); };
  KARST_CALL(glBindBuffer, GL_PIXEL_PACK_BUFFER, 0u);
  for (const int name : {GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS}) {
    KARST_CALL(glPixelStorei, static_cast<GLenum>(name), 0);
  }
  KARST_CALL(glPixelStorei, GL_PACK_ALIGNMENT, 4);
  KARST_CALL(glBindFramebuffer, GL_READ_FRAMEBUFFER, scratch_);
  for (const Texture& texture : textures_) add(read_texture(texture));
  KARST_CALL(glFramebufferRenderbuffer, GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
             renderbuffer_);
  std::vector<std::uint8_t> pixels(kSide * kSide * 4);
  KARST_CALL(glReadPixels, 0, 0, kSide, kSide, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  add(pixels);
  for (const GLuint name : buffers_) add(read_buffer(name));

  KARST_CALL(glBindVertexArray, array_);
  for (GLuint location = 0; location < 4; ++location) {
    for (const int name :
         {GL_VERTEX_ATTRIB_ARRAY_ENABLED, GL_VERTEX_ATTRIB_ARRAY_SIZE, GL_VERTEX_ATTRIB_ARRAY_STRIDE,
          GL_VERTEX_ATTRIB_ARRAY_BUFFER_BINDING, GL_VERTEX_ATTRIB_ARRAY_DIVISOR}) {
      GLint value = 0;
      KARST_CALL(glGetVertexAttribiv, location, static_cast<GLenum>(name), &value);
      add_integer(value);
    }
  }
  add_integer(host_.integer(GL_ELEMENT_ARRAY_BUFFER_BINDING));
  KARST_CALL(glBindVertexArray, 0u);
  GLint wrap = 0;
  KARST_CALL(glGetSamplerParameteriv, sampler_, GL_TEXTURE_WRAP_S, &wrap);
  add_integer(wrap == GL_MIRRORED_REPEAT);
  for (const Texture& texture : textures_) {
    KARST_CALL(glBindTexture, texture.target, texture.name);
    for (const int name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_WRAP_S, GL_TEXTURE_COMPARE_MODE}) {
      GLint value = 0;
      KARST_CALL(glGetTexParameteriv, texture.target, static_cast<GLenum>(name), &value);
      add_integer(value);
    }
  }
  GLfloat uniform[4] = {};
  KARST_CALL(glGetUniformfv, program_, KARST_CALL(glGetUniformLocation, program_, "u"), uniform);
  for (const GLfloat value : uniform) add_integer(static_cast<GLint>(value));
  return all;
}

std::string DirtyHost::changed_objects() const {
  const std::vector<std::uint8_t> now = contents();
  if (now.size() != contents_.size()) return "number of bytes";
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (now[i] != contents_[i]) return "byte " + std::to_string(i) + " of the foreign objects";
  }
  return {};
}

std::string DirtyHost::wrong_error(bool error) const {
  const GLenum first = KARST_CALL(glGetError);
  if (first != (error ? GLenum{GL_INVALID_ENUM} : GLenum{GL_NO_ERROR}))
    return "error " + std::to_string(first);
  const GLenum second = KARST_CALL(glGetError);
  return second == GL_NO_ERROR ? std::string() : "another error " + std::to_string(second);
}

void DirtyHost::check(std::string& wrong, const char* text, GLenum name, std::vector<int> expected) const {
  GLfloat values[4] = {};
  KARST_CALL(glGetFloatv, name, values);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (values[i] != static_cast<float>(expected[i]))
      wrong += std::string(text) + " is " + std::to_string(values[i]) + "; ";
  }
}

void DirtyHost::check_switch(std::string& wrong, const char* text, GLenum name, bool expected) const {
  if ((KARST_CALL(glIsEnabled, name) != GL_FALSE) != expected) wrong += std::string(text) + "; ";
}

#define KARST_CHECK(name, ...) check(wrong, #name, name, {__VA_ARGS__})
#define KARST_CHECK_SWITCH(name, on) check_switch(wrong, #name, name, on)

void DirtyHost::check_unpacking(std::string& wrong) const {
  KARST_CHECK(GL_PIXEL_UNPACK_BUFFER_BINDING, 0);
  KARST_CHECK(GL_UNPACK_ALIGNMENT, 4);
  KARST_CHECK(GL_UNPACK_ROW_LENGTH, 0);
  KARST_CHECK(GL_UNPACK_IMAGE_HEIGHT, 0);
  KARST_CHECK(GL_UNPACK_SKIP_ROWS, 0);
  KARST_CHECK(GL_UNPACK_SKIP_PIXELS, 0);
  KARST_CHECK(GL_UNPACK_SKIP_IMAGES, 0);
  KARST_CHECK(GL_ACTIVE_TEXTURE, GL_TEXTURE0);
  if (host_.api() == Api::es) return;
  KARST_CHECK(kUnpackSwapBytes, 0);
  for (GLenum n = 0; n < 4; ++n) check(wrong, "compressed block", kUnpackCompressedBlockWidth + n, {0});
}

void DirtyHost::check_extensions(std::string& wrong) const {
  const bool desktop = host_.api() == Api::desktop;
  if (desktop || host_.version() >= 31) KARST_CHECK_SWITCH(kSampleMask, false);
  if (desktop || host_.version() >= 32) KARST_CHECK_SWITCH(kSampleShading, false);
  if (host_.has("GL_ARB_clip_control") || host_.has("GL_EXT_clip_control")) {
    KARST_CHECK(kClipOrigin, kLowerLeft);
    KARST_CHECK(kClipDepthMode, kNegativeOneToOne);
  }
  if (desktop || host_.has("GL_EXT_depth_clamp")) KARST_CHECK_SWITCH(kDepthClamp, false);
  if (desktop || host_.has("GL_EXT_sRGB_write_control")) KARST_CHECK_SWITCH(kFramebufferSrgb, !desktop);
  if (desktop || host_.has("GL_EXT_clip_cull_distance")) {
    for (GLenum n = 0; n < 8; ++n) check_switch(wrong, "clip distance", kClipDistance0 + n, false);
  }
  if (!desktop) return;
  KARST_CHECK_SWITCH(kColourLogicOp, false);
  KARST_CHECK_SWITCH(kPolygonSmooth, false);
  KARST_CHECK_SWITCH(kSampleAlphaToOne, false);
  KARST_CHECK_SWITCH(kPrimitiveRestart, false);
  KARST_CHECK_SWITCH(kMultisample, true);
  KARST_CHECK(kPolygonMode, kFill);
  KARST_CHECK(kProvokingVertex, kLastVertexConvention);
}

std::string DirtyHost::wrong_upload_state(std::uint32_t first_unit) const {
  std::string wrong;
  check_unpacking(wrong);
  KARST_CALL(glActiveTexture, GL_TEXTURE0 + first_unit);
  for (const int name : {GL_TEXTURE_BINDING_2D, GL_TEXTURE_BINDING_3D, GL_TEXTURE_BINDING_2D_ARRAY}) {
    const int bound = host_.integer(static_cast<GLenum>(name));
    bool foreign = bound == 0;
    for (const Texture& texture : textures_) foreign = foreign || texture.name == static_cast<GLuint>(bound);
    if (!foreign) wrong += "a texture of karst's is bound; ";
  }
  return wrong;
}

std::string DirtyHost::wrong_state(std::uint32_t first_unit, std::uint32_t first_block) const {
  std::string wrong;
  check_unpacking(wrong);
  KARST_CHECK(GL_ARRAY_BUFFER_BINDING, 0);
  KARST_CHECK(GL_UNIFORM_BUFFER_BINDING, 0);
  KARST_CHECK(GL_CURRENT_PROGRAM, 0);
  KARST_CHECK(GL_VERTEX_ARRAY_BINDING, 0);
  KARST_CHECK_SWITCH(GL_BLEND, false);
  KARST_CHECK_SWITCH(GL_CULL_FACE, false);
  KARST_CHECK_SWITCH(GL_DEPTH_TEST, false);
  KARST_CHECK_SWITCH(GL_DITHER, true);
  KARST_CHECK_SWITCH(GL_POLYGON_OFFSET_FILL, false);
  KARST_CHECK_SWITCH(GL_PRIMITIVE_RESTART_FIXED_INDEX, false);
  KARST_CHECK_SWITCH(GL_RASTERIZER_DISCARD, false);
  KARST_CHECK_SWITCH(GL_SAMPLE_ALPHA_TO_COVERAGE, false);
  KARST_CHECK_SWITCH(GL_SAMPLE_COVERAGE, false);
  KARST_CHECK_SWITCH(GL_SCISSOR_TEST, false);
  KARST_CHECK_SWITCH(GL_STENCIL_TEST, false);
  KARST_CHECK(GL_DEPTH_FUNC, GL_LESS);
  KARST_CHECK(GL_DEPTH_WRITEMASK, 1);
  KARST_CHECK(GL_DEPTH_RANGE, 0, 1);
  KARST_CHECK(GL_COLOR_WRITEMASK, 1, 1, 1, 1);
  KARST_CHECK(GL_CULL_FACE_MODE, GL_BACK);
  KARST_CHECK(GL_FRONT_FACE, GL_CCW);
  check_extensions(wrong);
  // As interface.glsl has them.
  constexpr GLenum k2D = GL_TEXTURE_BINDING_2D;
  constexpr GLenum kArray = GL_TEXTURE_BINDING_2D_ARRAY;
  constexpr GLenum k3D = GL_TEXTURE_BINDING_3D;
  constexpr GLenum kBindings[] = {k2D, k2D, k2D, kArray, k3D, k3D, k2D, kArray, kArray, k2D};
  for (GLenum n = 0; n < 10; ++n) {
    KARST_CALL(glActiveTexture, GL_TEXTURE0 + first_unit + n);
    check(wrong, "a texture", kBindings[n], {0});
    check(wrong, "a sampler", GL_SAMPLER_BINDING, {0});
  }
  for (GLuint n = 0; n < 2; ++n) {
    GLint bound = -1;
    KARST_CALL(glGetIntegeri_v, GL_UNIFORM_BUFFER_BINDING, first_block + n, &bound);
    if (bound != 0) wrong += "a uniform block; ";
  }
  return wrong;
}

}  // namespace karst::test
