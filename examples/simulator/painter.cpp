// SPDX-License-Identifier: MIT
#include "painter.h"

#include <cstdio>
#include <string>

#include <GLES3/gl3.h>

namespace simulator {
namespace {

// karst uses the texture units and uniform blocks that GlOptions names; these are the simulator's own. After
// karst's calls nothing is bound to karst's, so they may be shared too.
constexpr GLuint kAirBlock = 4;
constexpr GLint kShadowUnit = 12;

// A box has 36 corners, which gl_VertexID tells: no vertex buffer is needed. Places are less the eye.
constexpr const char* kVertexShader = R"(#version 300 es
uniform mat4 clip_from_eye;
uniform mat4 eye_from_box;
uniform vec3 half_sides;
out vec3 from_eye;
out vec3 normal;
void main() {
  int side = gl_VertexID / 6;
  int corner = gl_VertexID % 6;
  vec2 uv = vec2(corner == 1 || corner == 3 || corner == 4 ? 1.0 : -1.0,
                 corner == 2 || corner == 4 || corner == 5 ? 1.0 : -1.0);
  float way = side % 2 == 0 ? 1.0 : -1.0;
  vec3 out_of = side < 2 ? vec3(way, 0.0, 0.0) : side < 4 ? vec3(0.0, way, 0.0) : vec3(0.0, 0.0, way);
  vec3 at = out_of + uv.x * way * out_of.zxy + uv.y * out_of.yzx;
  from_eye = (eye_from_box * vec4(half_sides * at, 1.0)).xyz;
  normal = mat3(eye_from_box) * out_of;
  gl_Position = clip_from_eye * vec4(from_eye, 1.0);
}
)";
constexpr const char* kPrecision = R"(#version 300 es
precision highp float;
precision highp int;
precision highp sampler2DArrayShadow;
)";
constexpr const char* kLitShader = R"(
uniform vec3 albedo;
in vec3 from_eye;
in vec3 normal;
out vec4 colour;
void main() {
  vec3 light = karst_light(from_eye, normalize(normal), albedo);
  colour = karst_display(karst_haze(light, from_eye));
}
)";
constexpr const char* kDepthShader = "void main() {}\n";

GLuint compile(GLenum stage, const std::string& text) {
  const GLuint shader = glCreateShader(stage);
  const char* const texts[] = {text.c_str()};
  glShaderSource(shader, 1, texts, nullptr);
  glCompileShader(shader);
  return shader;
}

// 0 where it does not link.
GLuint link(const std::string& fragment_shader) {
  const GLuint program = glCreateProgram();
  const GLuint stages[] = {compile(GL_VERTEX_SHADER, kVertexShader),
                           compile(GL_FRAGMENT_SHADER, kPrecision + fragment_shader)};
  for (const GLuint stage : stages) glAttachShader(program, stage);
  glLinkProgram(program);
  GLint linked = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  for (const GLuint stage : stages) {
    char words[1024] = "";
    if (linked == 0) glGetShaderInfoLog(stage, sizeof(words), nullptr, words);
    if (words[0] != '\0') std::fprintf(stderr, "simulator: %s\n", words);
    glDeleteShader(stage);
  }
  return linked != 0 ? program : 0;
}

void set_matrix(GLuint program, const char* name, const Mat4& m) {
  GLfloat values[16];
  for (std::size_t i = 0; i < 16; ++i) values[i] = static_cast<GLfloat>(m[i]);
  glUniformMatrix4fv(glGetUniformLocation(program, name), 1, GL_FALSE, values);
}

}  // namespace

bool Painter::create() {
  lit_ = link(std::string(karst::Renderer::air_glsl()) + kLitShader);
  depth_ = link(kDepthShader);
  if (lit_ == 0 || depth_ == 0) return false;
  glGenVertexArrays(1, &corners_);
  glUseProgram(lit_);
  const GLuint block = glGetUniformBlockIndex(lit_, "KarstAir");
  if (block != GL_INVALID_INDEX) glUniformBlockBinding(lit_, block, kAirBlock);
  glUniform1i(glGetUniformLocation(lit_, "karst_shadow_maps"), kShadowUnit);
  return true;
}

void Painter::draw(const karst::ViewState& view, const karst::Air& air, std::span<const Box> boxes) const {
  Mat4 clip_from_view;
  for (std::size_t i = 0; i < 16; ++i) clip_from_view[i] = view.clip_from_view[i];
  glUseProgram(lit_);
  glBindBufferBase(GL_UNIFORM_BUFFER, kAirBlock, air.block);
  glActiveTexture(GL_TEXTURE0 + kShadowUnit);
  glBindTexture(GL_TEXTURE_2D_ARRAY, air.shadow_texture);
  // What karst left is as OpenGL has it initially: no depth test, no culling.
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_CULL_FACE);
  glDepthFunc(GL_LEQUAL);
  draw_boxes(lit_, multiply(clip_from_view, from_rotation(view.view_from_world)), view.eye, boxes);
}

void Painter::cast(const double (&clip_from_world)[16], Vec3 eye, std::span<const Box> boxes) const {
  Mat4 clip_from_eye;
  for (std::size_t i = 0; i < 16; ++i) clip_from_eye[i] = clip_from_world[i];
  draw_boxes(depth_, clip_from_eye, eye, boxes);
}

void Painter::draw_boxes(unsigned program, const Mat4& clip_from_eye, Vec3 eye,
                         std::span<const Box> boxes) const {
  glUseProgram(program);
  glBindVertexArray(corners_);
  set_matrix(program, "clip_from_eye", clip_from_eye);
  for (const Box& box : boxes) {
    Mat4 eye_from_box =
        box.place;  // in double: near the eye little is left of places far from the zero point
    eye_from_box[12] -= eye.x;
    eye_from_box[13] -= eye.y;
    eye_from_box[14] -= eye.z;
    set_matrix(program, "eye_from_box", eye_from_box);
    glUniform3f(glGetUniformLocation(program, "half_sides"), static_cast<GLfloat>(box.half.x),
                static_cast<GLfloat>(box.half.y), static_cast<GLfloat>(box.half.z));
    glUniform3fv(glGetUniformLocation(program, "albedo"), 1, box.albedo);
    glDrawArrays(GL_TRIANGLES, 0, 36);
  }
  glBindVertexArray(0);
}

}  // namespace simulator
