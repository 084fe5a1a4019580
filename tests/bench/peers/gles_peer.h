// SPDX-License-Identifier: MIT
// What programs of published schemes share on the peers' scene (peer_common.h): an OpenGL ES 3.0 context
// without a screen, a picture of 1280 x 720, one texture, light a vertex, culling, and the peers' laps.
#pragma once

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>
#include <png.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <peer_common.h>

namespace peer {

[[noreturn]] inline void fail(const char* what) {
  std::fprintf(stderr, "%s\n", what);
  std::exit(1);
}

inline void open_context() {
  const auto get_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (get_display == nullptr) fail("EGL without platforms");
  const EGLDisplay display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (eglInitialize(display, nullptr, nullptr) == EGL_FALSE) fail("no EGL display without a screen");
  eglBindAPI(EGL_OPENGL_ES_API);
  const EGLint attributes[] = {EGL_CONTEXT_CLIENT_VERSION, 3, EGL_NONE};
  const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
  if (context == EGL_NO_CONTEXT ||
      eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_FALSE)
    fail("no context of OpenGL ES 3.0");
}

// Heights and slopes of the scene's samples; beyond its sides those at them.
class Ground {
 public:
  explicit Ground(const Heightmap& map) : map_(map) {}
  float height(int i, int j) const { return static_cast<float>(map_.h(inside(i), inside(j))); }
  // The upward normal's x and z, from neighbours `step` samples away.
  std::array<float, 2> normal(int i, int j, int step) const {
    const double across = 2.0 * kCell * step;
    const double x = (map_.h(inside(i - step), inside(j)) - map_.h(inside(i + step), inside(j))) / across;
    const double z = (map_.h(inside(i), inside(j - step)) - map_.h(inside(i), inside(j + step))) / across;
    const double length = std::sqrt(x * x + 1 + z * z);
    return {static_cast<float>(x / length), static_cast<float>(z / length)};
  }

 private:
  static int inside(int i) { return std::clamp(i, 0, kN - 1); }
  const Heightmap& map_;
};

// Six planes, inner side positive, of a view-projection.
struct Planes {
  float plane[6][4];
  explicit Planes(const float m[16]) {
    for (int p = 0; p < 6; ++p) {
      const float sign = p % 2 == 0 ? 1.0f : -1.0f;
      for (int c = 0; c < 4; ++c) plane[p][c] = m[c * 4 + 3] + sign * m[c * 4 + p / 2];
    }
  }
  bool sees(const float low[3], const float high[3]) const {
    for (const auto& p : plane) {
      float most = p[3];
      for (int axis = 0; axis < 3; ++axis) most += std::max(p[axis] * low[axis], p[axis] * high[axis]);
      if (most < 0) return false;
    }
    return true;
  }
};

inline GLuint compile(GLenum kind, const std::string& text) {
  const GLuint shader = glCreateShader(kind);
  const char* const source = text.c_str();
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok == 0) {
    char log[2048];
    glGetShaderInfoLog(shader, sizeof log, nullptr, log);
    fail(log);
  }
  return shader;
}

constexpr char kHead[] = R"(#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
)";
// Of a vertex: its place and the upward normal's x and z to light and texture.
constexpr char kShade[] = R"(
out vec3 to_colour;  // texture, light
uniform mat4 clip_from_world;
void shade(vec3 at, vec2 slope) {
  vec3 normal = vec3(slope.x, sqrt(max(0.0, 1.0 - dot(slope, slope))), slope.y);
  vec3 light = normalize(vec3(0.5, 0.7, 0.5));
  to_colour = vec3((at.xz + 2000.0) * (32.0 / 4000.0), 0.25 + max(dot(normal, light), 0.0));
  gl_Position = clip_from_world * vec4(at, 1.0);
}
)";

// A program whose vertex shader main() ends with shade(); one that draws colours, and one that draws depths.
struct Programs {
  GLuint colour = 0, depth = 0;
  explicit Programs(const std::string& vertex) {
    colour = link(vertex, R"(
in vec3 to_colour;
out vec4 colour;
uniform sampler2D diffuse;
void main() { colour = vec4(texture(diffuse, to_colour.xy).rgb * min(to_colour.z, 1.0), 1.0); }
)");
    depth = link(vertex, R"(
in vec3 to_colour;
out vec4 colour;
void main() { colour = vec4(gl_FragCoord.z); }
)");
  }
  static GLuint link(const std::string& vertex, const std::string& fragment) {
    const GLuint program = glCreateProgram();
    glAttachShader(program, compile(GL_VERTEX_SHADER, kHead + std::string(kShade) + vertex));
    glAttachShader(program, compile(GL_FRAGMENT_SHADER, kHead + fragment));
    glLinkProgram(program);
    GLint ok = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    if (ok == 0) fail("a program does not link");
    return program;
  }
};

inline GLuint make_diffuse() {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, data_path("diffuse_1024.png").c_str()) == 0)
    fail("diffuse_1024.png is missing: run gen_terrain, set PEER_DATA");
  image.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> rgba(PNG_IMAGE_SIZE(image));
  png_image_finish_read(&image, nullptr, rgba.data(), 0, nullptr);
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, static_cast<GLsizei>(image.width),
               static_cast<GLsizei>(image.height), 0, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  glGenerateMipmap(GL_TEXTURE_2D);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  return texture;
}

// A picture; of floats: for depths.
class Picture {
 public:
  explicit Picture(bool floats) : floats_(floats) {
    glGenRenderbuffers(2, buffers_);
    glBindRenderbuffer(GL_RENDERBUFFER, buffers_[0]);
    glRenderbufferStorage(GL_RENDERBUFFER, floats ? GL_R32F : GL_RGBA8, kW, kH);
    glBindRenderbuffer(GL_RENDERBUFFER, buffers_[1]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, kW, kH);
    glGenFramebuffers(1, &frame_);
    glBindFramebuffer(GL_FRAMEBUFFER, frame_);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffers_[0]);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, buffers_[1]);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) fail("no picture of floats");
  }
  void begin() const {
    glBindFramebuffer(GL_FRAMEBUFFER, frame_);
    glViewport(0, 0, kW, kH);
    if (floats_) {
      glClearColor(1, 1, 1, 1);
    } else {
      glClearColor(0.5f, 0.7f, 0.9f, 1);
    }
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  }

 private:
  bool floats_;
  GLuint buffers_[2] = {};
  GLuint frame_ = 0;
};

// What one frame of a scheme submitted.
struct Drawn {
  double triangles = 0, draws = 0;
};

// Two laps, the second one measured, as all peers; with `dump` errors, and a picture NAME.ppm of frame 0.
// draw(program, frame, clip_from_world): binds all it needs beside them and the diffuse texture, on unit 1,
// which is active.
template <class Draw>
void run_laps(Bench& bench, const Heightmap& map, const Programs& programs, const std::string& name,
              bool dump, Draw draw) {
  const GLuint diffuse = make_diffuse();
  const Picture picture(false);
  const Picture depths = dump ? Picture(true) : picture;
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_CULL_FACE);
  ErrorStats errors;
  const auto draw_with = [&](GLuint program, const Picture& into, int frame) {
    float clip_from_world[16];
    camera_matrix(frame, clip_from_world);
    into.begin();
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "clip_from_world"), 1, GL_FALSE, clip_from_world);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, diffuse);
    glActiveTexture(GL_TEXTURE1);
    return draw(program, frame, clip_from_world);
  };
  for (int lap = 0; lap < 2; ++lap) {
    for (int frame = 0; frame < kFrames; ++frame) {
      bench.begin();
      const Drawn drawn = draw_with(programs.colour, picture, frame);
      glFinish();
      bench.end(lap == 1);
      if (lap == 0 && frame == 0) bench.load = now_ms() - bench.t0;
      if (lap == 0) continue;
      bench.tris.push_back(drawn.triangles);
      bench.batches.push_back(drawn.draws);
      if (!dump || frame % 40 != 0) continue;
      if (frame == 0) {
        std::vector<std::uint8_t> rgba(std::size_t{kW} * kH * 4);
        glReadPixels(0, 0, kW, kH, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
        write_ppm((name.substr(0, name.find('/')) + ".ppm").c_str(), rgba.data());
      }
      draw_with(programs.depth, depths, frame);
      std::vector<float> depth(std::size_t{kW} * kH * 4);
      glReadPixels(0, 0, kW, kH, GL_RGBA, GL_FLOAT, depth.data());
      for (std::size_t n = 0; n < std::size_t{kW} * kH; ++n) depth[n] = depth[4 * n];
      accumulate_error(map, frame, depth.data(), errors);
    }
  }
  if (glGetError() != GL_NO_ERROR) fail("OpenGL reports an error");
  bench.report(name.c_str());
  if (dump) report_error(name.c_str(), errors);
}

}  // namespace peer
