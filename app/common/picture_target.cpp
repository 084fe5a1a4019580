// SPDX-License-Identifier: MIT
#include "app/common/picture_target.h"

#include <algorithm>

#include "app/common/gl/link_program.h"

namespace karst::app {
namespace {

// One triangle that covers the picture.
constexpr const char* kVertexShader = R"(#version 300 es
void main() {
  gl_Position = vec4(vec2((gl_VertexID & 1) << 2, (gl_VertexID & 2) << 1) - 1.0, 0.0, 1.0);
}
)";

// OpenGL ES cannot read a depth buffer back; this writes its numbers as floats into the bytes of a colour
// buffer, low byte in red.
constexpr const char* kDepthCopyShader = R"(#version 300 es
precision highp float;
precision highp int;
uniform highp sampler2D depth;
out vec4 colour;
void main() {
  highp uint bits = floatBitsToUint(texelFetch(depth, ivec2(gl_FragCoord.xy), 0).x);
  colour = vec4(uvec4(bits, bits >> 8, bits >> 16, bits >> 24) & 255u) / 255.0;
}
)";

Status invalid(const char* what, const char* field, std::uint64_t value = 0) {
  return {StatusCode::invalid_argument, what, field, value};
}

std::size_t pixels_of(const PictureSettings& settings) {
  return static_cast<std::size_t>(settings.width) * static_cast<std::size_t>(settings.height);
}

}  // namespace

Status PictureSettings::validate() const {
  if (width < 1 || width > kMaxPicture) return invalid("not within 1..16384 pixels", "width");
  if (height < 1 || height > kMaxPicture) return invalid("not within 1..16384 pixels", "height");
  if (samples != 1 && samples != 2 && samples != 4) return invalid("not 1, 2 or 4", "samples");
  if (samples > 1 && keep_depth) return invalid("depth of several samples is not kept", "keep_depth");
  return {};
}

std::size_t PictureSettings::bytes() const {
  const std::size_t colour = rgb565 ? 2 : 4;
  const std::size_t resolved = samples > 1 ? colour : 0;
  const std::size_t depth = own_depth ? 4 : 0;
  return pixels_of(*this) * ((colour + depth) * static_cast<std::size_t>(samples) + resolved);
}

Status PictureTarget::load(const GlLoader& loader) {
  const char* missing = nullptr;
  KARST_TARGET_FUNCTIONS(KARST_GL_LOAD)
  if (missing == nullptr) return {};
  return lacks_function(missing);
}

Status PictureTarget::create(const GlLoader& loader, const PictureSettings& settings) {
  destroy();
  settings_ = settings;
  if (const Status status = settings.validate(); !status.ok()) return status;
  if (const Status status = load(loader); !status.ok()) return status;
  if (const Status status = check_device(); !status.ok()) return status;
  created_ = true;
  Status status = create_framebuffers();
  if (status.ok() && settings.keep_depth && !create_depth_copy()) {
    status = {StatusCode::unsupported, "the driver rejects a shader", "shader"};
  }
  if (!status.ok()) destroy();
  return status;
}

Status PictureTarget::check_device() const {
  GLint most_texels = 0;
  GLint most_pixels = 0;
  GLint viewport[2] = {0, 0};
  gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &most_texels);
  gl_.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most_pixels);
  gl_.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  const auto limit = [](const char* field, int value) {
    return Status{StatusCode::limit_reached, "more than the device can do", field,
                  static_cast<std::uint64_t>(value)};
  };
  const GLint most = std::min(most_texels, most_pixels);
  if (settings_.width > std::min(most, viewport[0])) return limit("width", settings_.width);
  if (settings_.height > std::min(most, viewport[1])) return limit("height", settings_.height);
  return {};
}

Status PictureTarget::create_framebuffers() {
  const GLsizei width = settings_.width;
  const GLsizei height = settings_.height;
  gl_.GenRenderbuffers(1, &colour_);
  gl_.BindRenderbuffer(GL_RENDERBUFFER, colour_);
  const GLenum colour_format = settings_.rgb565 ? GL_RGB565 : GL_RGBA8;
  const GLenum depth_format = settings_.float_depth ? GL_DEPTH_COMPONENT32F : GL_DEPTH_COMPONENT24;
  gl_.RenderbufferStorage(GL_RENDERBUFFER, colour_format, width, height);
  if (settings_.samples > 1) {
    gl_.GenRenderbuffers(2, sampled_);
    for (const int n : {0, 1}) {
      gl_.BindRenderbuffer(GL_RENDERBUFFER, sampled_[n]);
      gl_.RenderbufferStorageMultisample(GL_RENDERBUFFER, settings_.samples,
                                         n == 0 ? colour_format : depth_format, width, height);
    }
  } else if (settings_.own_depth) {
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.GenTextures(1, &depth_);
    gl_.BindTexture(GL_TEXTURE_2D, depth_);
    gl_.TexStorage2D(GL_TEXTURE_2D, 1, depth_format, width, height);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl_.BindTexture(GL_TEXTURE_2D, 0);
  }
  gl_.BindRenderbuffer(GL_RENDERBUFFER, 0);
  gl_.GenFramebuffers(1, &target_);
  gl_.GenFramebuffers(1, &colour_target_);
  gl_.GenVertexArrays(1, &no_attributes_);
  for (const GLuint framebuffer : {colour_target_, target_}) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    const bool sampled = framebuffer == target_ && settings_.samples > 1;
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                                sampled ? sampled_[0] : colour_);
    if (sampled) {
      gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, sampled_[1]);
    } else if (framebuffer == target_) {
      gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_texture(), 0);
    }
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      return {StatusCode::limit_reached, "the driver could not make a framebuffer of this size",
              "width, height"};
    }
  }
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  return {};
}

// Its sampler reads texture unit 0, as samplers do initially.
bool PictureTarget::create_depth_copy() {
  return link_program(gl_, kVertexShader, kDepthCopyShader, depth_copy_);
}

void PictureTarget::destroy() {
  if (!created_) return;
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  gl_.DeleteFramebuffers(1, &target_);
  gl_.DeleteFramebuffers(1, &colour_target_);
  gl_.DeleteRenderbuffers(1, &colour_);
  gl_.DeleteRenderbuffers(2, sampled_);
  gl_.DeleteTextures(1, &depth_);
  gl_.DeleteVertexArrays(1, &no_attributes_);
  gl_.DeleteProgram(depth_copy_);
  forget();
}

void PictureTarget::forget() {
  created_ = false;
  has_picture_ = false;
  colour_ = depth_ = sampled_[0] = sampled_[1] = target_ = colour_target_ = depth_copy_ = no_attributes_ = 0;
}

void PictureTarget::begin(float farthest) {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_);
  const GLenum colour = GL_COLOR_ATTACHMENT0;
  gl_.InvalidateFramebuffer(GL_FRAMEBUFFER, 1, &colour);
  gl_.ClearBufferfv(GL_DEPTH, 0, &farthest);
}

void PictureTarget::begin(const float (&rgb)[3], float farthest) {
  const float colour[4] = {rgb[0], rgb[1], rgb[2], 1.0f};
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_);
  gl_.ClearBufferfv(GL_COLOR, 0, colour);
  gl_.ClearBufferfv(GL_DEPTH, 0, &farthest);
}

void PictureTarget::end() {
  const GLenum spent[] = {GL_DEPTH_ATTACHMENT, GL_COLOR_ATTACHMENT0};
  if (settings_.samples > 1) {
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, target_);
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, colour_target_);
    copy_picture();
    gl_.InvalidateFramebuffer(GL_READ_FRAMEBUFFER, 2, spent);
  } else if (!settings_.keep_depth) {
    gl_.InvalidateFramebuffer(GL_FRAMEBUFFER, 1, spent);
  }
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  has_picture_ = true;
}

void PictureTarget::present() {
  if (!has_picture_) return;
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, colour_target_);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  copy_picture();
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, 0);
}

void PictureTarget::copy_picture() {
  const GLint width = settings_.width;
  const GLint height = settings_.height;
  gl_.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

// GL's rows go upwards; pictures' go downwards.
void PictureTarget::read_pixels(void* rgba) {
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 4);
  gl_.ReadPixels(0, 0, settings_.width, settings_.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
  const std::size_t row = static_cast<std::size_t>(settings_.width) * 4;
  auto* top = static_cast<std::uint8_t*>(rgba);
  auto* bottom = top + row * static_cast<std::size_t>(settings_.height - 1);
  for (; top < bottom; top += row, bottom -= row) std::swap_ranges(top, top + row, bottom);
}

Status PictureTarget::read_colour(std::span<std::uint8_t> rgba) {
  const std::size_t bytes = pixels_of(settings_) * 4;
  if (!has_picture_) return invalid("nothing was drawn yet", "picture");
  if (rgba.size() < bytes) return invalid("too short", "rgba", bytes);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, colour_target_);
  read_pixels(rgba.data());
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  return {};
}

Status PictureTarget::read_depth(std::span<float> depth) {
  const std::size_t pixels = pixels_of(settings_);
  if (!has_picture_ || !settings_.keep_depth) return invalid("no depth was kept", "keep_depth");
  if (depth.size() < pixels) return invalid("too short", "depth", pixels);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, colour_target_);
  gl_.Viewport(0, 0, settings_.width, settings_.height);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.BindVertexArray(no_attributes_);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, depth_texture());
  gl_.UseProgram(depth_copy_);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.UseProgram(0);
  gl_.BindTexture(GL_TEXTURE_2D, 0);
  gl_.BindVertexArray(0);
  read_pixels(depth.data());
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  has_picture_ = false;
  return {};
}

GLenum PictureTarget::take_error() {
  const GLenum first = gl_.GetError();
  // Errors are flags, one a kind: a handful at most. A lost context gives errors without end.
  for (int i = 0; first != GL_NO_ERROR && i < 16 && gl_.GetError() != GL_NO_ERROR;) ++i;
  return first;
}

}  // namespace karst::app
