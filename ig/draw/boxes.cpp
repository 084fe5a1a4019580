// SPDX-License-Identifier: MIT
#include "ig/draw/boxes.h"

#include <algorithm>
#include <string>

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>

#include "app/common/gl/link_program.h"

namespace karst::ig {
namespace {

// Karst takes the texture units and uniform blocks from 0 on; nothing of it is bound after its calls.
constexpr GLuint kAirBlock = 4;
constexpr GLint kShadowUnit = 14;
constexpr GLenum kLowerLeft = 0x8CA1, kNegativeOneToOne = 0x935E, kZeroToOne = 0x935F;  // EXT_clip_control
constexpr GLsizei kCorners = 36;

// The corners of a box by their number; sides look outwards.
constexpr const char* kVertex = R"(#version 300 es
layout(location = 0) in vec4 along;
layout(location = 1) in vec4 across;
layout(location = 2) in vec4 down;
layout(location = 3) in vec4 middle;
uniform mat4 clip_from_eye;
out vec3 from_eye;
out vec3 normal;
flat out vec4 colour_of_box;
void main() {
  int side = gl_VertexID / 6;
  int corner = gl_VertexID % 6;
  vec2 uv = vec2(corner == 1 || corner == 3 || corner == 4 ? 1.0 : -1.0,
                 corner == 2 || corner == 4 || corner == 5 ? 1.0 : -1.0);
  float way = side % 2 == 0 ? 1.0 : -1.0;
  vec3 out_of = side < 2 ? vec3(way, 0.0, 0.0) : side < 4 ? vec3(0.0, way, 0.0) : vec3(0.0, 0.0, way);
  vec3 at = out_of + uv.x * way * out_of.zxy + uv.y * out_of.yzx;
  mat3 axes = mat3(along.xyz, across.xyz, down.xyz);
  from_eye = axes * at + middle.xyz;
  normal = axes * out_of;
  colour_of_box = vec4(along.w, across.w, down.w, middle.w);
  gl_Position = clip_from_eye * vec4(from_eye, 1.0);
}
)";
constexpr const char* kFragmentHead = R"(#version 300 es
precision highp float;
precision highp int;
precision highp sampler2DArrayShadow;
)";
constexpr const char* kFragment = R"(
in vec3 from_eye;
in vec3 normal;
flat in vec4 colour_of_box;
out vec4 colour;
void main() {
  vec3 light = karst_light(from_eye, normalize(normal), colour_of_box.rgb);
  colour = vec4(karst_display(karst_haze(light, from_eye)).rgb, colour_of_box.a);
}
)";

// Types are told apart by their colours.
glm::vec3 colour_of(std::uint16_t type) {
  const std::uint32_t mixed = (type * 2'654'435'761u) >> 8;
  const auto part = [&](int shift) { return 0.15f + 0.7f * static_cast<float>(mixed >> shift & 255u) / 255; };
  return {part(0), part(8), part(16)};
}

bool is_mirrored(const ViewState& view) {
  const double* const m = view.view_from_world;
  const glm::dmat3 rotation(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
  return glm::determinant(rotation) < 0;
}

// Of a range of depth, with places less the eye. half: depth reaches the buffer as it is, not halved.
void set_matrix(const ViewState& view, const DepthRange* range, bool half, GLfloat (&out)[16]) {
  glm::dmat4 clip;
  for (int n = 0; n < 16; ++n) clip[n / 4][n % 4] = view.clip_from_view[n];
  if (range != nullptr) {
    const double near = range->near_m, far = range->far_m;
    clip[2][2] = -(far + near) / (far - near);
    clip[3][2] = -2 * far * near / (far - near);
  }
  for (int column = 0; column < 4 && half; ++column)
    clip[column][2] = 0.5 * (clip[column][2] + clip[column][3]);
  glm::dmat4 turn(1.0);
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) turn[column][row] = view.view_from_world[column * 3 + row];
  const glm::dmat4 all = clip * turn;
  for (int n = 0; n < 16; ++n) out[n] = static_cast<GLfloat>(all[n / 4][n % 4]);
}

}  // namespace

Boxes::Boxes() : instances_(Entities::kMost), order_(Entities::kMost) {}

Status Boxes::create(const GlLoader& loader) {
  destroy();
  const char* missing = nullptr;
  KARST_BOXES_FUNCTIONS(KARST_GL_LOAD)
  if (missing != nullptr) return app::lacks_function(missing);
  gl_.ClipControlEXT =
      reinterpret_cast<decltype(gl_.ClipControlEXT)>(loader.load(loader.user, "glClipControlEXT"));
  created_ = true;
  const std::string fragment = std::string(kFragmentHead) + Renderer::air_glsl() + kFragment;
  if (!app::link_program(gl_, kVertex, fragment.c_str(), program_)) {
    destroy();
    return {StatusCode::unsupported, "the driver rejects a shader", "boxes"};
  }
  clip_from_eye_ = gl_.GetUniformLocation(program_, "clip_from_eye");
  gl_.UseProgram(program_);
  const GLuint block = gl_.GetUniformBlockIndex(program_, "KarstAir");
  if (block != GL_INVALID_INDEX) gl_.UniformBlockBinding(program_, block, kAirBlock);
  gl_.Uniform1i(gl_.GetUniformLocation(program_, "karst_shadow_maps"), kShadowUnit);
  gl_.UseProgram(0);
  gl_.GenVertexArrays(1, &array_);
  gl_.GenBuffers(1, &buffer_);
  gl_.BindVertexArray(array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffer_);
  for (GLuint n = 0; n < 4; ++n) {
    gl_.VertexAttribPointer(n, 4, GL_FLOAT, GL_FALSE, sizeof(Instance),
                            reinterpret_cast<const void*>(std::size_t{n} * 16));
    gl_.VertexAttribDivisor(n, 1);
    gl_.EnableVertexAttribArray(n);
  }
  gl_.BindVertexArray(0);
  gl_.BindBuffer(GL_ARRAY_BUFFER, 0);
  return {};
}

void Boxes::destroy() {
  if (!created_) return;
  gl_.DeleteProgram(program_);
  gl_.DeleteBuffers(1, &buffer_);
  gl_.DeleteVertexArrays(1, &array_);
  forget();
}

void Boxes::forget() {
  created_ = false;
  program_ = buffer_ = array_ = 0;
}

// Opaque ones first, then the others from the farthest on.
std::size_t Boxes::list(const Entities& entities, glm::dvec3 half_m, const ViewState& view) {
  const glm::dvec3 eye(view.eye.x, view.eye.y, view.eye.z);
  const std::span<const Entity> all = entities.all();
  std::size_t count = 0;
  for (std::uint32_t n = 0; n < all.size(); ++n) {
    if (!all[n].is_seen || all[n].alpha <= 0) continue;
    const glm::dvec3 apart = all[n].body.place - eye;
    order_[count++] = {glm::dot(apart, apart), all[n].alpha >= 1, n};
  }
  std::sort(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(count),
            [](const Order& a, const Order& b) {
              if (a.opaque != b.opaque) return a.opaque;
              return a.opaque ? a.distance2 < b.distance2 : a.distance2 > b.distance2;
            });
  for (std::size_t n = 0; n < count; ++n) {
    const Entity& entity = all[order_[n].entity];
    const glm::vec3 colour = colour_of(entity.control.type);
    const glm::dvec3 middle = entity.body.place - eye;
    for (int column = 0; column < 4; ++column) {
      const glm::dvec3 way = column < 3 ? entity.body.axes[column] * half_m[column] : middle;
      for (int row = 0; row < 3; ++row) instances_[n].columns[column][row] = static_cast<float>(way[row]);
      instances_[n].columns[column][3] = column < 3 ? colour[column] : entity.alpha;
    }
  }
  return count;
}

void Boxes::draw(const Entities& entities, glm::dvec3 half_m, const ViewState& view, const Air& air,
                 bool two_ranges) {
  const std::size_t count = list(entities, half_m, view);
  if (count == 0) return;
  DepthRange ranges[2];
  const std::uint32_t range_count = two_ranges ? depth_ranges(view, ranges) : 1;
  const bool half = view.reversed_depth && gl_.ClipControlEXT != nullptr;
  gl_.UseProgram(program_);
  gl_.BindBufferBase(GL_UNIFORM_BUFFER, kAirBlock, air.block);
  gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(kShadowUnit));
  gl_.BindTexture(GL_TEXTURE_2D_ARRAY, air.shadow_texture);
  gl_.BindVertexArray(array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffer_);
  // A new store each time, of one size: the driver need not wait for what drew from the last one.
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(kBytes), instances_.data(), GL_STREAM_DRAW);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.DepthFunc(view.reversed_depth ? GL_GEQUAL : GL_LEQUAL);
  gl_.Enable(GL_CULL_FACE);
  gl_.FrontFace(is_mirrored(view) ? GL_CW : GL_CCW);
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  if (half) gl_.ClipControlEXT(kLowerLeft, kZeroToOne);
  // The farther range first, because what is not opaque is in order.
  for (std::uint32_t n = range_count; n-- > 0;) {
    GLfloat matrix[16];
    set_matrix(view, range_count > 1 ? &ranges[n] : nullptr, half, matrix);
    gl_.UniformMatrix4fv(clip_from_eye_, 1, GL_FALSE, matrix);
    if (range_count > 1) gl_.DepthRangef(ranges[n].buffer_near, ranges[n].buffer_far);
    gl_.DrawArraysInstanced(GL_TRIANGLES, 0, kCorners, static_cast<GLsizei>(count));
  }
  if (half) gl_.ClipControlEXT(kLowerLeft, kNegativeOneToOne);
  gl_.DepthRangef(0, 1);
  gl_.BlendFunc(GL_ONE, GL_ZERO);
  gl_.Disable(GL_BLEND);
  gl_.FrontFace(GL_CCW);
  gl_.Disable(GL_CULL_FACE);
  gl_.DepthFunc(GL_LESS);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.BindBuffer(GL_ARRAY_BUFFER, 0);
  gl_.BindVertexArray(0);
  gl_.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindBufferBase(GL_UNIFORM_BUFFER, kAirBlock, 0);
  gl_.UseProgram(0);
}

}  // namespace karst::ig
