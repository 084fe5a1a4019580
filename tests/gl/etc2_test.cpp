// SPDX-License-Identifier: MIT
// The driver's decoder of ETC2 and EAC against karst-bake's: the same bytes for any block.
#include "etc2/etc2.h"

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/gl/gl_fixture.h"

namespace karst::core {
using namespace etc2;
namespace {

using test::GlContext;
using Bytes = std::vector<std::uint8_t>;

// The second texture is what the first should be: where they differ the target has 0.
constexpr const char* kVertex = R"(#version 300 es
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
})";
constexpr const char* kFragment = R"(#version 300 es
precision highp float;
uniform highp sampler2D first, second;
uniform int compare;
out vec4 colour;
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  colour = texelFetch(first, texel, 0);
  if (compare != 0) colour = vec4(equal(colour, texelFetch(second, texel, 0)));
})";

class Etc2Gl : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(context_.ok());
    program_ = gl_.CreateProgram();
    attach(GL_VERTEX_SHADER, kVertex);
    attach(GL_FRAGMENT_SHADER, kFragment);
    gl_.LinkProgram(program_);
    GLint linked = GL_FALSE;
    gl_.GetProgramiv(program_, GL_LINK_STATUS, &linked);
    ASSERT_EQ(linked, GL_TRUE);
    gl_.GenVertexArrays(1, &array_);
    gl_.GenTextures(3, textures_);
    gl_.GenFramebuffers(1, &framebuffer_);
  }
  void TearDown() override {
    gl_.DeleteFramebuffers(1, &framebuffer_);
    gl_.DeleteTextures(3, textures_);
    gl_.DeleteVertexArrays(1, &array_);
    gl_.DeleteProgram(program_);
    EXPECT_EQ(gl_.GetError(), GLenum{GL_NO_ERROR});
  }

  // What the shader fetches from the blocks, row 0 first.
  Bytes fetch(const Bytes& blocks, int width, int height, GLenum format) {
    upload_blocks(blocks, width, height, format);
    return draw(width, height, 0);
  }
  // 255 in each byte where the shader fetches the same from the blocks as from an uncompressed texture.
  Bytes equal(const Bytes& blocks, const Bytes& rgba, int width, int height, GLenum format,
              GLint plain_format) {
    upload_blocks(blocks, width, height, format);
    upload(1, rgba.data(), width, height, plain_format);
    return draw(width, height, 1);
  }

 private:
  void attach(GLenum stage, const char* text) {
    const GLuint shader = gl_.CreateShader(stage);
    gl_.ShaderSource(shader, 1, &text, nullptr);
    gl_.CompileShader(shader);
    gl_.AttachShader(program_, shader);
    gl_.DeleteShader(shader);
  }
  void bind(int unit) {
    gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl_.BindTexture(GL_TEXTURE_2D, textures_[unit]);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  void upload(int unit, const void* rgba, int width, int height, GLint format) {
    bind(unit);
    context_.function<PFNGLTEXIMAGE2DPROC>("glTexImage2D")(GL_TEXTURE_2D, 0, format, width, height, 0,
                                                           GL_RGBA, GL_UNSIGNED_BYTE, rgba);
  }
  void upload_blocks(const Bytes& blocks, int width, int height, GLenum format) {
    bind(0);
    context_.function<PFNGLCOMPRESSEDTEXIMAGE2DPROC>("glCompressedTexImage2D")(
        GL_TEXTURE_2D, 0, format, width, height, 0, static_cast<GLsizei>(blocks.size()), blocks.data());
  }
  Bytes draw(int width, int height, int compare) {
    upload(2, nullptr, width, height, GL_RGBA8);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures_[2], 0);
    EXPECT_EQ(gl_.CheckFramebufferStatus(GL_FRAMEBUFFER), GLenum{GL_FRAMEBUFFER_COMPLETE});
    gl_.Viewport(0, 0, width, height);
    for (const int state : {GL_BLEND, GL_DEPTH_TEST, GL_CULL_FACE, GL_SCISSOR_TEST, GL_DITHER})
      gl_.Disable(static_cast<GLenum>(state));
    gl_.UseProgram(program_);
    gl_.Uniform1i(gl_.GetUniformLocation(program_, "first"), 0);
    gl_.Uniform1i(gl_.GetUniformLocation(program_, "second"), compare);
    gl_.Uniform1i(gl_.GetUniformLocation(program_, "compare"), compare);
    gl_.BindVertexArray(array_);
    gl_.DrawArrays(GL_TRIANGLES, 0, 3);
    Bytes read(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
    context_.function<PFNGLREADPIXELSPROC>("glReadPixels")(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE,
                                                           read.data());
    return read;
  }

  GlContext& context_ = GlContext::get();
  const Gl& gl_ = context_.gl();
  GLuint program_ = 0, array_ = 0, framebuffer_ = 0;
  GLuint textures_[3] = {};  // by unit: blocks, what they should be, the target
};

Bytes decoded(const Bytes& blocks, int width, int height) {
  Bytes rgba(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
  const Status status =
      decode_etc2(blocks, static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), rgba);
  EXPECT_TRUE(status.ok()) << status.what() << ' ' << status.field();
  return rgba;
}

Bytes random_bytes(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() >> 24);
  return bytes;
}

// The mode of a block of colour, in the order of what overflows: none, red, green, blue.
int mode_of(const std::uint8_t* colour) {
  if ((colour[3] & 2) == 0) return 0;
  for (int c = 0; c < 3; ++c) {
    const int difference = (colour[c] & 7) >= 4 ? (colour[c] & 7) - 8 : colour[c] & 7;
    const int sum = (colour[c] >> 3) + difference;
    if (sum < 0 || sum > 31) return c + 2;
  }
  return 1;
}

TEST_F(Etc2Gl, DecodesAnyBlockAlike) {
  constexpr int kSide = 1024;
  const Bytes blocks = random_bytes(etc2_bytes(kSide, kSide), 7);
  std::array<int, 5> modes{};
  for (std::size_t at = 8; at < blocks.size(); at += kEtc2BlockBytes)
    ++modes[static_cast<std::size_t>(mode_of(&blocks[at]))];
  for (std::size_t mode = 0; mode < modes.size(); ++mode) EXPECT_GT(modes[mode], 1000) << "mode " << mode;

  const Bytes expected = decoded(blocks, kSide, kSide);
  const Bytes got = fetch(blocks, kSide, kSide, GL_COMPRESSED_RGBA8_ETC2_EAC);
  ASSERT_EQ(got.size(), expected.size());
  int different = 0;
  for (std::size_t texel = 0; texel < kSide * kSide && different < 10; ++texel) {
    for (std::size_t c = 0; c < 4; ++c) {
      const std::size_t at = texel * 4 + c;
      if (got[at] == expected[at]) continue;
      const std::size_t x = texel % kSide, y = texel / kSide;
      const std::size_t block = (y / 4 * (kSide / 4) + x / 4) * kEtc2BlockBytes;
      ADD_FAILURE() << "texel " << x << ' ' << y << " channel " << c << " mode "
                    << mode_of(&blocks[block + 8]) << ": driver " << int{got[at]} << ", decoder "
                    << int{expected[at]};
      ++different;
    }
  }
}

// As colours of sRGB, the blocks are what a texture of the decoded bytes is, bit by bit.
TEST_F(Etc2Gl, DecodesSrgbAlike) {
  constexpr int kSide = 512;
  const Bytes blocks = random_bytes(etc2_bytes(kSide, kSide), 8);
  const Bytes same = equal(blocks, decoded(blocks, kSide, kSide), kSide, kSide,
                           GL_COMPRESSED_SRGB8_ALPHA8_ETC2_EAC, GL_SRGB8_ALPHA8);
  EXPECT_EQ(same, Bytes(same.size(), 255));
  // The comparison can fail: as linear colours the decoded bytes are others.
  const Bytes other = equal(blocks, decoded(blocks, kSide, kSide), kSide, kSide,
                            GL_COMPRESSED_SRGB8_ALPHA8_ETC2_EAC, GL_RGBA8);
  EXPECT_NE(other, same);
}

// The last levels of a mip pyramid, and sides that are no multiple of a block's.
TEST_F(Etc2Gl, SmallImagesHaveTheFirstTexelsOfTheirBlocks) {
  for (const auto& [width, height] : {std::array{1, 1}, {2, 2}, {2, 4}, {3, 7}, {9, 5}}) {
    SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
    const auto w = static_cast<std::uint32_t>(width), h = static_cast<std::uint32_t>(height);
    const Bytes blocks = random_bytes(etc2_bytes(w, h), w * 16 + h);
    EXPECT_EQ(fetch(blocks, width, height, GL_COMPRESSED_RGBA8_ETC2_EAC), decoded(blocks, width, height));
  }
}

}  // namespace
}  // namespace karst::core
