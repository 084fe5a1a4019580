// SPDX-License-Identifier: MIT
// What the vertex shader makes of the 16 bytes, read back with transform feedback: the same numbers as C++,
// and the same bits in clip space for every patch that shares a vertex.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "gles_shaders/shader_texts.h"
#include "renderer/frame_block.h"
#include "terrain/patch/octahedral.h"
#include "tests/gl/gl_fixture.h"

namespace karst {
namespace {

using test::GlContext;

struct Decoded {
  float clip[4];
  float normal[3];
  float from_eye[3];
  float in_patch[3];
  std::int32_t patch_voxel[3];
};

// The terrain program's vertex shader alone, over vertices that belong to pages of given origins.
class Decoder {
 public:
  Decoder() {
    const Gl& gl = context_.gl();
    program_ = gl.CreateProgram();
    attach(GL_VERTEX_SHADER, kShaderTexts[static_cast<std::size_t>(ShaderVariant::terrain)].vertex);
    attach(GL_FRAGMENT_SHADER, kShaderTexts[static_cast<std::size_t>(ShaderVariant::terrain)].fragment);
    const char* const outputs[] = {"gl_Position", "normal_ws", "from_eye_ws", "in_patch", "patch_voxel"};
    context_.function<PFNGLTRANSFORMFEEDBACKVARYINGSPROC>("glTransformFeedbackVaryings")(
        program_, 5, outputs, GL_INTERLEAVED_ATTRIBS);
    gl.LinkProgram(program_);
    GLint linked = GL_FALSE;
    gl.GetProgramiv(program_, GL_LINK_STATUS, &linked);
    EXPECT_EQ(linked, GL_TRUE);
    gl.GenVertexArrays(1, &array_);
    gl.GenBuffers(3, buffers_);
    gl.GenTextures(1, &origins_);
    gl.BindTexture(GL_TEXTURE_2D, origins_);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA16I, 1 << KARST_PAGE_ROW_BITS, 1);
    // Nothing is rasterised, but drawing needs a complete framebuffer.
    gl.GenRenderbuffers(1, &colour_);
    gl.BindRenderbuffer(GL_RENDERBUFFER, colour_);
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, 1, 1);
    gl.GenFramebuffers(1, &framebuffer_);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  }
  ~Decoder() {
    const Gl& gl = context_.gl();
    gl.DeleteProgram(program_);
    gl.DeleteVertexArrays(1, &array_);
    gl.DeleteBuffers(3, buffers_);
    gl.DeleteTextures(1, &origins_);
    gl.DeleteRenderbuffers(1, &colour_);
    gl.DeleteFramebuffers(1, &framebuffer_);
    EXPECT_EQ(gl.GetError(), GLenum{GL_NO_ERROR});
  }

  // origins: one a page of kPageVertices vertices, at most a texture row of them.
  std::vector<Decoded> run(const shader::FrameBlock& block, const std::vector<GpuVertex>& vertices,
                           const std::vector<std::array<std::int16_t, 4>>& origins) {
    const Gl& gl = context_.gl();
    gl.UseProgram(program_);
    gl.UniformBlockBinding(program_, gl.GetUniformBlockIndex(program_, "FrameBlock"), KARST_BINDING_FRAME);
    gl.Uniform1i(gl.GetUniformLocation(program_, "page_origins"), 0);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, origins_);
    gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, static_cast<GLsizei>(origins.size()), 1, GL_RGBA_INTEGER,
                     GL_SHORT, origins.data());
    gl.BindBuffer(GL_UNIFORM_BUFFER, buffers_[0]);
    gl.BufferData(GL_UNIFORM_BUFFER, sizeof block, &block, GL_STATIC_DRAW);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, KARST_BINDING_FRAME, buffers_[0]);
    gl.BindVertexArray(array_);
    gl.BindBuffer(GL_ARRAY_BUFFER, buffers_[1]);
    gl.BufferData(GL_ARRAY_BUFFER, bytes_of(vertices), vertices.data(), GL_STATIC_DRAW);
    gl.VertexAttribIPointer(KARST_LOCATION_POSITION, 4, GL_SHORT, sizeof(GpuVertex), nullptr);
    gl.EnableVertexAttribArray(KARST_LOCATION_POSITION);

    std::vector<Decoded> decoded(vertices.size());
    gl.BindBuffer(GL_TRANSFORM_FEEDBACK_BUFFER, buffers_[2]);
    gl.BufferData(GL_TRANSFORM_FEEDBACK_BUFFER, bytes_of(decoded), nullptr, GL_STATIC_READ);
    gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffers_[2]);
    gl.Enable(GL_RASTERIZER_DISCARD);
    context_.function<PFNGLBEGINTRANSFORMFEEDBACKPROC>("glBeginTransformFeedback")(GL_POINTS);
    gl.DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(vertices.size()));
    context_.function<PFNGLENDTRANSFORMFEEDBACKPROC>("glEndTransformFeedback")();
    gl.Disable(GL_RASTERIZER_DISCARD);
    const void* mapped =
        gl.MapBufferRange(GL_TRANSFORM_FEEDBACK_BUFFER, 0, bytes_of(decoded), GL_MAP_READ_BIT);
    EXPECT_NE(mapped, nullptr);
    if (mapped != nullptr) std::memcpy(decoded.data(), mapped, decoded.size() * sizeof(Decoded));
    gl.UnmapBuffer(GL_TRANSFORM_FEEDBACK_BUFFER);
    gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
    return decoded;
  }

 private:
  template <class T>
  static GLsizeiptr bytes_of(const std::vector<T>& values) {
    return static_cast<GLsizeiptr>(values.size() * sizeof(T));
  }

  void attach(GLenum stage, const char* text) {
    const Gl& gl = context_.gl();
    const GLuint shader = gl.CreateShader(stage);
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    gl.AttachShader(program_, shader);
    gl.DeleteShader(shader);
  }

  GlContext& context_ = GlContext::get();
  GLuint program_ = 0;
  GLuint array_ = 0;
  GLuint buffers_[3] = {};
  GLuint origins_ = 0;
  GLuint colour_ = 0;
  GLuint framebuffer_ = 0;
};

shader::FrameBlock block_at(glm::dvec3 eye, double yaw_deg, double pitch_deg) {
  CameraSettings settings;
  settings.position = eye;
  settings.yaw_deg = yaw_deg;
  settings.pitch_deg = pitch_deg;
  Camera camera;
  EXPECT_TRUE(make_camera(settings, camera).ok());
  return make_frame_block(camera, {}, glm::ivec3(64), 720);
}

// Every packed normal there is, and positions over the whole range.
TEST(VertexDecode, EveryPackedNormalAndPositionsDecodeAsInCpp) {
  std::vector<GpuVertex> vertices(1 << 15);
  test::Random random{17};
  std::vector<std::array<std::int16_t, 4>> origins(vertices.size() / kPageVertices);
  for (auto& origin : origins) {
    for (std::size_t axis = 0; axis < 3; ++axis) origin[axis] = static_cast<std::int16_t>(random.below(513));
  }
  const glm::dvec3 eye{300.3, 77.7, 211.1};
  const shader::FrameBlock block = block_at(eye, 30, -20);
  Decoder decoder;
  for (int half = 0; half < 2; ++half) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      for (std::int16_t& axis : vertices[i].position) {
        axis = static_cast<std::int16_t>(static_cast<std::uint16_t>(random.next()));
      }
      vertices[i].normal = static_cast<std::uint16_t>(i + static_cast<std::size_t>(half) * vertices.size());
      // -128 is no code of a snorm8.
      if ((vertices[i].normal & 0xff) == 0x80 || vertices[i].normal >> 8 == 0x80) vertices[i].normal = 0;
    }
    const std::vector<Decoded> decoded = decoder.run(block, vertices, origins);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto& origin = origins[i / kPageVertices];
      const glm::vec3 normal = decode_octahedral(vertices[i].normal);
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        // Divisions by a power of two are exact.
        ASSERT_EQ(decoded[i].in_patch[axis], static_cast<float>(vertices[i].position[axis]) / kStepsPerVoxel);
        ASSERT_EQ(decoded[i].patch_voxel[axis], origin[a]);
        ASSERT_NEAR(decoded[i].normal[axis], normal[axis], 2e-7) << vertices[i].normal;
        const double voxel = origin[a] + static_cast<double>(vertices[i].position[axis]) / kStepsPerVoxel;
        ASSERT_NEAR(decoded[i].from_eye[axis], voxel - eye[axis], 1e-4);
      }
    }
  }
}

// The vertices of a whole world, camera inside and far away: a point that patches share has one place in clip
// space.
TEST(VertexDecode, SharedVerticesAreTheSameBitsInClipSpace) {
  constexpr int kLevel = 2;
  const test::TestWorld world = test::hills_with_cave(kLevel);
  const Surface surface = world.surface();
  std::vector<GpuVertex> vertices;
  std::vector<std::array<std::int16_t, 4>> origins;
  for (PatchId p = 0; p < surface.patches.size() && origins.size() < (1u << KARST_PAGE_ROW_BITS); ++p) {
    std::vector<GpuVertex> patch = world.vertices(p, kLevel);
    patch.resize(kPageVertices);
    vertices.insert(vertices.end(), patch.begin(), patch.end());
    const Volume& v = surface.volume_of(p);
    origins.push_back({static_cast<std::int16_t>(v.corner[0]), static_cast<std::int16_t>(v.corner[1]),
                       static_cast<std::int16_t>(v.corner[2]), 0});
  }
  Decoder decoder;
  std::size_t shared = 0;
  for (const glm::dvec3 eye : {glm::dvec3(10.37, 8.111, 9.23), glm::dvec3(-4000.3, 900.7, 12345.6)}) {
    const std::vector<Decoded> decoded = decoder.run(block_at(eye, 33.3, -21.7), vertices, origins);
    ASSERT_NE(decoded[0].clip[3], 0.0f);
    std::map<std::tuple<int, int, int>, const Decoded*> seen;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (i % kPageVertices >= static_cast<std::size_t>(patch_vertices(kLevel))) continue;
      int lattice[3];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lattice[axis] = origins[i / kPageVertices][axis] * kStepsPerVoxel + vertices[i].position[axis];
      }
      const auto [first, inserted] =
          seen.emplace(std::tuple(lattice[0], lattice[1], lattice[2]), &decoded[i]);
      if (inserted) continue;
      ++shared;
      ASSERT_EQ(std::memcmp(first->second->clip, decoded[i].clip, sizeof decoded[i].clip), 0);
    }
  }
  EXPECT_GT(shared, 5000u);
}

}  // namespace
}  // namespace karst
