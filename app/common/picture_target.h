// SPDX-License-Identifier: MIT
// The framebuffer that the programs draw into: they are karst's host, and this is host code. Colour, and
// depth that can be read back; what is in it is copied to the display's framebuffer or read as a picture.
//
//   target.create({load, user}, settings);
//   each frame: target.begin();  renderer.draw(...);  target.end();  target.present();
#pragma once

#include <GLES3/gl3.h>

#include <cstddef>
#include <cstdint>
#include <span>

#include "app/common/gl/function_table.h"
#include "karst/status.h"
#include "karst/types.h"

#define KARST_TARGET_FUNCTIONS(X)   \
  X(ActiveTexture)                  \
  X(AttachShader)                   \
  X(BindFramebuffer)                \
  X(BindRenderbuffer)               \
  X(BindTexture)                    \
  X(BindVertexArray)                \
  X(BlitFramebuffer)                \
  X(CheckFramebufferStatus)         \
  X(ClearBufferfv)                  \
  X(CompileShader)                  \
  X(CreateProgram)                  \
  X(CreateShader)                   \
  X(DeleteFramebuffers)             \
  X(DeleteProgram)                  \
  X(DeleteRenderbuffers)            \
  X(DeleteShader)                   \
  X(DeleteTextures)                 \
  X(DeleteVertexArrays)             \
  X(Disable)                        \
  X(DrawArrays)                     \
  X(Finish)                         \
  X(FramebufferRenderbuffer)        \
  X(FramebufferTexture2D)           \
  X(GenFramebuffers)                \
  X(GenRenderbuffers)               \
  X(GenTextures)                    \
  X(GenVertexArrays)                \
  X(GetError)                       \
  X(GetIntegerv)                    \
  X(GetProgramiv)                   \
  X(InvalidateFramebuffer)          \
  X(LinkProgram)                    \
  X(PixelStorei)                    \
  X(ReadPixels)                     \
  X(RenderbufferStorage)            \
  X(RenderbufferStorageMultisample) \
  X(ShaderSource)                   \
  X(TexParameteri)                  \
  X(TexStorage2D)                   \
  X(UseProgram)                     \
  X(Viewport)

namespace karst::app {

struct PictureSettings {
  int width = 1280;  // pixels, 1..kMaxPicture
  int height = 720;
  bool rgb565 = false;              // 16 bits a pixel instead of 32: for screens that show no more
  int samples = 1;                  // of a pixel's edges: 1, 2 or 4; more than 1 not with keep_depth
  bool float_depth = false;         // of 32 bits instead of 24, for reversed depth
  bool own_depth = true;            // else depth_texture is the target's depth: of its size or larger
  std::uint32_t depth_texture = 0;  // which create() takes
  bool keep_depth = false;  // keeps the depth of a frame for read_depth(); costs bandwidth on tiling GPUs

  static constexpr int kMaxPicture = 16384;  // pixels a side

  // invalid_argument naming the first field outside its range.
  Status validate() const;
  // That create() takes of GPU memory; drivers may take 4 samples where 2 are asked for.
  std::size_t bytes() const;
};

class PictureTarget {
 public:
  PictureTarget() = default;
  PictureTarget(const PictureTarget&) = delete;
  PictureTarget& operator=(const PictureTarget&) = delete;
  ~PictureTarget() { destroy(); }

  // The context that is current has to be so in all calls; its state is OpenGL's initial one but for what
  // karst leaves. unsupported or limit_reached where the device cannot do it.
  Status create(const GlLoader& loader, const PictureSettings& settings);
  void destroy();
  // Instead, where the context is lost: forgets the objects without calling GL.
  void forget();

  const PictureSettings& settings() const { return settings_; }
  std::uint32_t framebuffer() const { return target_; }
  Rect viewport() const { return {0, 0, settings_.width, settings_.height}; }

  // Binds the target and clears its depth to what is farthest: 1, or 0 with reversed depth. Every pixel's
  // colour is going to be drawn.
  void begin(float farthest = 1);
  // The same, and clears its colour: red, green, blue, 0..1, as they are shown.
  void begin(const float (&rgb)[3], float farthest = 1);
  // The picture is complete.
  void end();
  // Waits until the GPU has done all that it was told.
  void finish() { gl_.Finish(); }

  // Copies the picture to framebuffer 0, which is the display's and of the picture's size or larger.
  void present();
  // Reads the picture, row 0 at the top. rgba: width x height x 4 bytes.
  Status read_colour(std::span<std::uint8_t> rgba);
  // Reads its depth as the buffer holds it, row 0 at the top. depth: width x height. Needs keep_depth and not
  // rgb565; overwrites the picture, so read_colour() comes first.
  Status read_depth(std::span<float> depth);

  // The first GL error since the last call, GL_NO_ERROR where there was none. Asking makes some drivers wait.
  GLenum take_error();

 private:
  struct Functions {
    KARST_TARGET_FUNCTIONS(KARST_GL_MEMBER)
  };

  GLuint depth_texture() const { return settings_.own_depth ? depth_ : settings_.depth_texture; }
  Status load(const GlLoader& loader);
  Status check_device() const;
  Status create_framebuffers();
  bool create_depth_copy();
  void copy_picture();  // from the framebuffer that is bound for reading to that for drawing
  void read_pixels(void* rgba);

  Functions gl_;
  PictureSettings settings_;
  bool created_ = false;
  bool has_picture_ = false;
  GLuint colour_ = 0;         // renderbuffer: the picture
  GLuint depth_ = 0;          // texture; 0 with several samples
  GLuint sampled_[2] = {};    // renderbuffers of several samples: colour, depth
  GLuint target_ = 0;         // framebuffer: what is drawn into
  GLuint colour_target_ = 0;  // framebuffer: colour_ alone
  GLuint depth_copy_ = 0;     // program; 0: depth is not kept
  GLuint no_attributes_ = 0;  // vertex array
};

}  // namespace karst::app
