// SPDX-License-Identifier: MIT
// What the vertex shader makes of the 16 bytes, read back with transform feedback: the same numbers as C++,
// vertices moved as terrain/lod/morph.h says, and the same bits in clip space for every patch that shares a
// vertex.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "gles_shaders/shader_texts.h"
#include "renderer/input/frame_block.h"
#include "terrain/nodes/node_place.h"
#include "terrain/patch/octahedral.h"
#include "tests/gl/gl_fixture.h"
#include "tests/support/morphed_surface.h"

namespace karst::core {
namespace {

using test::GlContext;

struct Decoded {
  float clip[4];
  float normal[3];
  float from_eye[3];
  float in_patch[3];
  std::int32_t patch_voxel[3];
};

constexpr int kTextureRows = 32;  // of the page table and of the morph rows: 32,768 pages, 2,048 patches

// The terrain program's vertex shader alone.
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
    // Nothing is rasterised, but drawing needs a complete framebuffer.
    EXPECT_TRUE(target_.create(context_.loader(), {.width = 1, .height = 1}).ok());
    gl.GenTextures(3, textures_);
    make_texture(KARST_UNIT_PAGE_TABLE, GL_RGBA32UI, 1 << KARST_PAGE_ROW_BITS, "page_table");
    make_texture(KARST_UNIT_MORPH_ENTRIES, GL_R8UI, 1 << KARST_ENTRY_ROW_BITS, "morph_entries");
    std::vector<std::uint8_t> entries(static_cast<std::size_t>(1 << KARST_ENTRY_ROW_BITS) * kEntryRows);
    EXPECT_TRUE(build_morph_entries(kMaxLevel, entries).ok());
    build_family_entries(entries);
    gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 1 << KARST_ENTRY_ROW_BITS, kEntryRows, GL_RED_INTEGER,
                     GL_UNSIGNED_BYTE, entries.data());
    make_texture(KARST_UNIT_MORPH_ROWS, GL_R16F, kRowTexels, "morph_rows");
    // Samplers of another kind must not share a unit with these, used or not.
    gl.Uniform1i(gl.GetUniformLocation(program_, "far_textures"), KARST_UNIT_FAR_TEXTURES);
    gl.Uniform1i(gl.GetUniformLocation(program_, "near_textures"), KARST_UNIT_NEAR_TEXTURES);
    gl.Uniform1i(gl.GetUniformLocation(program_, "sky_visibility"), KARST_UNIT_SKY_VISIBILITY);
  }
  ~Decoder() {
    const Gl& gl = context_.gl();
    gl.DeleteProgram(program_);
    gl.DeleteVertexArrays(1, &array_);
    gl.DeleteBuffers(3, buffers_);
    gl.DeleteTextures(3, textures_);
    EXPECT_EQ(gl.GetError(), GLenum{GL_NO_ERROR});
  }

  // texels: one a page of kPageVertices vertices. rows: kMorphRow thresholds a patch.
  std::vector<Decoded> run(const shader::FrameBlock& block, const std::vector<GpuVertex>& vertices,
                           std::vector<PageTexel> texels, std::vector<std::uint16_t> rows) {
    const Gl& gl = context_.gl();
    EXPECT_LE(texels.size(), std::size_t{kTextureRows} << KARST_PAGE_ROW_BITS);
    EXPECT_LE(rows.size(), std::size_t{kTextureRows} * kRowTexels);
    texels.resize(std::size_t{kTextureRows} << KARST_PAGE_ROW_BITS);
    rows.resize(std::size_t{kTextureRows} * kRowTexels);
    target_.begin();
    gl.UseProgram(program_);
    gl.UniformBlockBinding(program_, gl.GetUniformBlockIndex(program_, "FrameBlock"), KARST_BINDING_FRAME);
    gl.ActiveTexture(GL_TEXTURE0 + KARST_UNIT_PAGE_TABLE);
    gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 1 << KARST_PAGE_ROW_BITS, kTextureRows, GL_RGBA_INTEGER,
                     GL_UNSIGNED_INT, texels.data());
    gl.ActiveTexture(GL_TEXTURE0 + KARST_UNIT_MORPH_ROWS);
    gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kRowTexels, kTextureRows, GL_RED, GL_HALF_FLOAT, rows.data());
    gl.BindBuffer(GL_UNIFORM_BUFFER, buffers_[0]);
    gl.BufferData(GL_UNIFORM_BUFFER, sizeof block, &block, GL_STATIC_DRAW);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, KARST_BINDING_FRAME, buffers_[0]);
    gl.BindVertexArray(array_);
    gl.BindBuffer(GL_ARRAY_BUFFER, buffers_[1]);
    gl.BufferData(GL_ARRAY_BUFFER, bytes_of(vertices), vertices.data(), GL_STATIC_DRAW);
    gl.VertexAttribIPointer(KARST_LOCATION_POSITION, 4, GL_SHORT, sizeof(GpuVertex), nullptr);
    gl.EnableVertexAttribArray(KARST_LOCATION_POSITION);
    gl.VertexAttribIPointer(KARST_LOCATION_MORPH, 4, GL_SHORT, sizeof(GpuVertex),
                            reinterpret_cast<const void*>(sizeof(GpuVertex) / 2));
    gl.EnableVertexAttribArray(KARST_LOCATION_MORPH);

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
  static constexpr int kRowTexels = kMorphRow << KARST_MORPH_ROW_BITS;

  // Leaves the texture bound and its unit active.
  void make_texture(int unit, GLenum format, int width, const char* sampler) {
    const Gl& gl = context_.gl();
    gl.ActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
    gl.BindTexture(GL_TEXTURE_2D, textures_[unit]);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    const int rows = unit == KARST_UNIT_MORPH_ENTRIES ? kEntryRows : kTextureRows;
    gl.TexStorage2D(GL_TEXTURE_2D, 1, format, width, rows);
    gl.UseProgram(program_);
    gl.Uniform1i(gl.GetUniformLocation(program_, sampler), unit);
  }

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
  GLuint textures_[3] = {};  // by unit
  app::PictureTarget target_;
};

Camera camera_at(glm::dvec3 eye, double yaw_deg, double pitch_deg) {
  CameraSettings settings;
  settings.position = eye;
  settings.yaw_deg = yaw_deg;
  settings.pitch_deg = pitch_deg;
  Camera camera;
  EXPECT_TRUE(make_camera(settings, camera).ok());
  return camera;
}

shader::FrameBlock block_of(const Camera& camera, float least_cos2) {
  return make_frame_block(camera, least_cos2, {}, {}, 720);
}

// A row whose entries are all the same threshold.
std::vector<std::uint16_t> same_rows(std::size_t patches, std::uint16_t threshold) {
  return std::vector<std::uint16_t>(patches * kMorphRow, threshold);
}

// Every packed normal there is, and positions over the whole range; at home and arrived.
TEST(VertexDecode, EveryPackedNormalAndPositionsDecodeAsInCpp) {
  std::vector<GpuVertex> vertices(1 << 15);
  test::Random random{17};
  std::vector<glm::ivec3> origins(vertices.size() / kPageVertices);
  std::vector<PageTexel> texels(origins.size());
  for (std::size_t page = 0; page < origins.size(); ++page) {
    for (int axis = 0; axis < 3; ++axis) origins[page][axis] = random.below(513);
    texels[page] = make_page_texel(origins[page], 0, 0, 0, 0, false);
  }
  const glm::dvec3 eye{300.3, 77.7, 211.1};
  const shader::FrameBlock block = block_of(camera_at(eye, 30, -20), 0.5f);
  const auto coordinate = [&] {
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(random.next()));
  };
  // -128 is no code of a snorm8.
  const auto code = [](std::size_t bits) {
    const auto normal = static_cast<std::uint16_t>(bits);
    return (normal & 0xff) == 0x80 || normal >> 8 == 0x80 ? std::uint16_t{0} : normal;
  };
  Decoder decoder;
  for (int turn = 0; turn < 4; ++turn) {
    const bool arrived = turn >= 2;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      for (std::int16_t& axis : vertices[i].position) axis = coordinate();
      for (std::int16_t& axis : vertices[i].morph) axis = coordinate();
      vertices[i].normal = code(i + static_cast<std::size_t>(turn & 1) * vertices.size());
      vertices[i].morph_normal = code(vertices.size() * 2 - 1 - i - static_cast<std::size_t>(turn & 1) * i);
    }
    const std::vector<Decoded> decoded =
        decoder.run(block, vertices, texels, same_rows(1, arrived ? kLeastThreshold : kNeverMorphs));
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const glm::ivec3 origin = origins[i / kPageVertices];
      const glm::vec3 normal = decode_octahedral(arrived ? vertices[i].morph_normal : vertices[i].normal);
      const auto& position = arrived ? vertices[i].morph : vertices[i].position;
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        // Divisions by a power of two are exact.
        ASSERT_EQ(decoded[i].in_patch[axis], static_cast<float>(position[axis]) / kStepsPerVoxel);
        ASSERT_EQ(decoded[i].patch_voxel[axis], origin[axis]);
        // GLSL ES 3.00, 4.5.1: divisions and inversesqrt may be off by 2.5 and 2 units in the last place.
        ASSERT_NEAR(decoded[i].normal[axis], normal[axis], 4e-7) << vertices[i].normal;
        const double voxel = origin[axis] + static_cast<double>(position[axis]) / kStepsPerVoxel;
        ASSERT_NEAR(decoded[i].from_eye[axis], voxel - eye[static_cast<int>(a)], 1e-4);
      }
    }
  }
}

// The thresholds of families begin at a row of their own, behind others that would move everything the other
// way.
constexpr int kFirstFamilyRow = 3;

// A page of a node.
struct Page {
  glm::ivec3 origin{0};
  int size = 0;
};

bool same_bits(const float* a, const float* b, std::size_t count) {
  return std::memcmp(a, b, count * sizeof(float)) == 0;
}

// Bits of a vertex as drawn at one end of its way, and as C++ has them.
void expect_place(const Decoded& d, const Camera& camera, const Page& page, const std::int16_t (&at)[3]) {
  const glm::vec3 place = node_place(camera.voxel, page.size, page.origin, {at[0], at[1], at[2]});
  for (int axis = 0; axis < 3; ++axis) {
    const float from_eye = (place[axis] - camera.fine[axis]) / kStepsPerVoxel;
    ASSERT_TRUE(same_bits(&d.from_eye[axis], &from_eye, 1)) << page.size << ' ' << axis;
    const float in_patch = std::ldexp(static_cast<float>(at[axis]), page.size) / kStepsPerVoxel;
    ASSERT_EQ(d.in_patch[axis], in_patch);
    ASSERT_EQ(static_cast<std::uint32_t>(d.patch_voxel[axis]), static_cast<std::uint32_t>(page.origin[axis])
                                                                   << page.size);
  }
}

// Pages of nodes, near the eye and as far as there is room for, alternately of a size and of the next greater
// one: vertices of the first go to those of the second.
TEST(VertexDecode, PlacesThatTwoSizesShareAreTheSameBits) {
  test::Random random{23};
  Decoder decoder;
  constexpr std::size_t kPages = 1'024;
  std::vector<std::uint16_t> rows((kFirstFamilyRow + 2) * std::size_t{kMorphRow});
  const auto fill_rows = [&rows](int first, int count, std::uint16_t threshold) {
    std::fill_n(rows.begin() + first * kMorphRow, count * kMorphRow, threshold);
  };
  std::size_t rounded = 0;
  for (int turn = 0; turn < 40; ++turn) {
    const auto coordinate = [&random] { return (random.unit() * 2 - 1) * kCameraReach; };
    const Camera camera = camera_at({coordinate(), coordinate(), coordinate()}, 33.3, -21.7);
    shader::FrameBlock block = block_of(camera, 0.5f);
    block.first_rows.y = kFirstFamilyRow;
    block.camera_fine.w = -1234.0f;
    std::vector<Page> pages(kPages);
    std::vector<PageTexel> texels(kPages);
    std::vector<GpuVertex> vertices(kPages * kPageVertices);
    for (std::size_t n = 0; n < kPages; n += 2) {
      const int size = random.below(random.below(kMostSize) + 1);
      Page& coarse = pages[n + 1];
      Page& fine = pages[n];
      coarse.size = size + 1;
      fine.size = size;
      const double reach = std::exp2(random.unit() * 20);  // voxels
      for (int axis = 0; axis < 3; ++axis) {
        const double away = (random.unit() * 2 - 1) * reach;
        coarse.origin[axis] = static_cast<int>(std::floor(std::ldexp(camera.voxel[axis] + away, -size - 1)));
        fine.origin[axis] = 2 * coarse.origin[axis] + (axis == 1 ? random.below(5) - 2 : random.below(2));
      }
      for (std::size_t v = 0; v < kPageVertices; ++v) {
        GpuVertex& from = vertices[n * kPageVertices + v];
        GpuVertex& to = vertices[(n + 1) * kPageVertices + v];
        for (int axis = 0; axis < 3; ++axis) {
          const int span = axis == 1 ? 1 << 13 : 1 << 11;
          const int low = axis == 1 ? -span : 0;
          const int target = 4 * (low + random.below(span - low));
          const int moved = fine.origin[axis] - 2 * coarse.origin[axis];
          from.morph[axis] = static_cast<std::int16_t>(target);
          from.position[axis] = static_cast<std::int16_t>(target / 2 + 2 * random.below(64));
          to.position[axis] = static_cast<std::int16_t>((target + moved * kStepsPerVoxel) / 2);
          to.morph[axis] = static_cast<std::int16_t>(to.position[axis] / 2);
        }
      }
      const auto texel = [&](std::size_t page, std::uint32_t row) {
        const auto place = kFirstGroundPlace + static_cast<std::uint32_t>(random.below(4));
        return make_page_texel(pages[page].origin, pages[page].size, place, row, 0, false);
      };
      texels[n] = texel(n, 0);
      texels[n + 1] = texel(n + 1, 1);
    }
    // First the fine ones have arrived and the coarse ones are at home, then the other way round.
    for (const bool fine_arrived : {true, false}) {
      fill_rows(0, kFirstFamilyRow, fine_arrived ? kNeverMorphs : kLeastThreshold);
      fill_rows(kFirstFamilyRow, 1, fine_arrived ? kLeastThreshold : kNeverMorphs);
      fill_rows(kFirstFamilyRow + 1, 1, fine_arrived ? kNeverMorphs : kLeastThreshold);
      const std::vector<Decoded> decoded = decoder.run(block, vertices, texels, rows);
      for (std::size_t i = 0; i < vertices.size(); ++i) {
        const std::size_t page = i / kPageVertices;
        const bool arrived = fine_arrived == (page % 2 == 0);
        if (i % kPageVertices >= kNodeVertices) {
          // Below its corner.
          const float foot = (block.camera_fine.w - camera.fine.y) / kStepsPerVoxel;
          ASSERT_TRUE(same_bits(&decoded[i].from_eye[1], &foot, 1));
          continue;
        }
        expect_place(decoded[i], camera, pages[page], arrived ? vertices[i].morph : vertices[i].position);
        if (HasFatalFailure()) return;
        if (page % 2 == 1 || !fine_arrived) continue;
        const Decoded& shared = decoded[i + kPageVertices];
        ASSERT_TRUE(same_bits(decoded[i].clip, shared.clip, 4)) << pages[page].size;
        ASSERT_TRUE(same_bits(decoded[i].from_eye, shared.from_eye, 3)) << pages[page].size;
        const double in_voxels = pages[page].origin.x + vertices[i].morph[0] / double{kStepsPerVoxel};
        const double exact = std::ldexp(in_voxels, pages[page].size) - camera.voxel.x;
        rounded += static_cast<double>(static_cast<float>(exact)) != exact ? 1 : 0;
      }
    }
  }
  // Places that a float does not hold, without which nothing would have been shown.
  EXPECT_GT(rounded, 40'000u);
}

// Each vertex of each quadrant by the entry that its family's row has for it.
TEST(VertexDecode, NodesMoveByTheirFamilysRow) {
  Decoder decoder;
  const Camera camera = camera_at({100.5, 40.25, -30.75}, 33.3, -21.7);
  shader::FrameBlock block = block_of(camera, 0.5f);
  block.first_rows.y = kFirstFamilyRow;
  std::vector<std::uint8_t> entries(kMorphEntries);
  build_family_entries(entries);
  std::vector<PageTexel> texels;
  std::vector<GpuVertex> vertices(4 * kPageVertices);
  for (std::uint32_t quadrant = 0; quadrant < 4; ++quadrant)
    texels.push_back(make_page_texel({-7, 3, 9}, 2, kFirstGroundPlace + quadrant, 1, 0, false));
  for (GpuVertex& v : vertices) v.morph[1] = 2 * kStepsPerVoxel;
  int arrived = 0;
  for (int moving = 1; moving <= kFamilyClasses; ++moving) {
    std::vector<std::uint16_t> rows = same_rows(kFirstFamilyRow, kLeastThreshold);
    rows.resize(rows.size() + 2 * std::size_t{kMorphRow}, kNeverMorphs);
    rows[(kFirstFamilyRow + 1) * std::size_t{kMorphRow} + static_cast<std::size_t>(moving)] = kLeastThreshold;
    const std::vector<Decoded> decoded = decoder.run(block, vertices, texels, rows);
    for (std::uint32_t quadrant = 0; quadrant < 4; ++quadrant) {
      for (std::uint32_t v = 0; v < kNodeVertices; ++v) {
        const bool moves = entries[(kFirstGroundPlace + quadrant) * kPageVertices + v] == moving;
        const float y = decoded[quadrant * kPageVertices + v].in_patch[1];
        ASSERT_EQ(y, moves ? 8.0f : 0.0f) << moving << ' ' << quadrant << ' ' << v;
        arrived += moves ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(arrived, 4 * kNodeVertices);
}

// All vertices of a world with thresholds of its own, and what morph.h makes of them.
class Morphing : public testing::Test {
 protected:
  static constexpr int kLevel = 3;
  static constexpr int kHeight = 720;

  Morphing() {
    const Surface surface = surface_.surface();
    for (PatchId p = 0; p < surface_.patches(); ++p) {
      const glm::ivec3 origin = patch_origin(surface.volume_of(p)) / kStepsPerVoxel;
      std::vector<GpuVertex> patch = surface_.vertices(p);
      patch.resize(slot_pages(kLevel) * kPageVertices);
      vertices_.insert(vertices_.end(), patch.begin(), patch.end());
      for (std::uint32_t n = 0; n < slot_pages(kLevel); ++n)
        texels_.push_back(make_page_texel(origin, 0, n, p, 0, false));
    }
  }

  void set_thresholds(const Camera& camera, double error_px) {
    scale_ = make_error_scale(camera, kHeight * 16 / 9, kHeight, error_px);
    lods_.resize(surface_.patches());
    const std::vector<std::uint16_t> errors = world_.level_errors();
    SetThresholds set;
    set.scale = scale_;
    set.surface = surface_.surface();
    set.bounds = surface_.bounds();
    set.errors = {kLevel, errors};
    set.lods = lods_;
    ASSERT_TRUE(set.validate().ok());
    set.run();
    rows_.resize(surface_.patches() * kMorphRow);
    for (PatchId p = 0; p < surface_.patches(); ++p) {
      make_morph_row(
          surface_.surface(), lods_, p,
          std::span<std::uint16_t, kMorphRow>(rows_.data() + p * std::size_t{kMorphRow}, kMorphRow));
    }
  }

  std::size_t slot(PatchId patch) const { return patch * std::size_t{slot_pages(kLevel)} * kPageVertices; }

  test::TestWorld world_ = test::hills_with_cave(kLevel);
  test::MorphedSurface surface_{world_};
  std::vector<GpuVertex> vertices_;
  std::vector<PageTexel> texels_;
  std::vector<std::uint16_t> rows_;
  std::vector<PatchLod> lods_;
  ErrorScale scale_;
  Decoder decoder_;
};

// 40 voxels wide.
Camera parallel_at(glm::dvec3 eye) {
  CameraMatrices matrices;
  matrices.position = eye;
  matrices.view_from_world = camera_at(eye, 33.3, -21.7).view_from_world;
  matrices.clip_from_view = glm::dmat4(0.05, 0, 0, 0, 0, 0.09, 0, 0, 0, 0, -0.01, 0, 0, 0, 0, 1);
  Camera camera;
  EXPECT_TRUE(make_camera(matrices, camera).ok());
  return camera;
}

constexpr glm::dvec3 kEyes[3] = {{10.37, 8.111, 9.23}, {12.7, 13.9, 30.2}, {-40.3, 90.7, 123.6}};

TEST_F(Morphing, VerticesMoveAsInCpp) {
  int home = 0;
  int moving = 0;
  int arrived = 0;
  int moved_parallel = 0;
  int other_bits = 0;
  double worst = 0;
  for (int view = 0; view < 4; ++view) {
    const bool parallel = view == 3;
    const Camera camera = parallel ? parallel_at(kEyes[1]) : camera_at(kEyes[view], 33.3, -21.7);
    for (const double error_px : {0.5, 4.0, 30.0}) {
      set_thresholds(camera, error_px);
      const std::vector<Decoded> decoded =
          decoder_.run(block_of(camera, scale_.least_cos2), vertices_, texels_, rows_);
      for (PatchId p = 0; p < surface_.patches(); ++p) {
        const std::vector<glm::vec3> moved = surface_.moved(p, kLevel, camera, scale_, lods_);
        for (std::size_t v = 0; v < moved.size(); ++v) {
          const Decoded& d = decoded[slot(p) + v];
          const GpuVertex& g = vertices_[slot(p) + v];
          const glm::vec3 from_eye = moved[v] - camera.fine;
          const glm::vec3 actual =
              glm::vec3(d.from_eye[0], d.from_eye[1], d.from_eye[2]) * float{kStepsPerVoxel};
          // What the thresholds' proof allows for (kRounding in morph.cpp).
          const double allowed = 0x1p-20 * glm::length(glm::dvec3(from_eye));
          const double off = glm::length(glm::dvec3(actual) - glm::dvec3(from_eye));
          ASSERT_LE(off, allowed) << p << ' ' << v;
          worst = std::max(worst, off / allowed);
          other_bits += actual != from_eye ? 1 : 0;
          // No rounding at either end of the way.
          const glm::vec3 in_patch =
              glm::vec3(d.in_patch[0], d.in_patch[1], d.in_patch[2]) * float{kStepsPerVoxel};
          const glm::vec3 at_home(g.position[0], g.position[1], g.position[2]);
          const glm::vec3 target(g.morph[0], g.morph[1], g.morph[2]);
          if (at_home == target) continue;
          (in_patch == at_home ? home : in_patch == target ? arrived : moving) += 1;
          if (parallel && in_patch != at_home) ++moved_parallel;
        }
      }
    }
  }
  RecordProperty("other_bits", other_bits);
  std::printf(
      "%d at home, %d moving, %d arrived; %d with other bits than in C++, at most %.3f of what is allowed\n",
      home, moving, arrived, other_bits, worst);
  EXPECT_GT(moved_parallel, 1'000);
  EXPECT_GT(home, 10'000);
  EXPECT_GT(moving, 10'000);
  EXPECT_GT(arrived, 10'000);
}

// Camera inside and far away: a point that patches share has one place in clip space, wherever on its way it
// is.
TEST_F(Morphing, SharedVerticesAreTheSameBitsInClipSpace) {
  std::size_t shared = 0;
  std::size_t moving = 0;
  for (const glm::dvec3 eye : {kEyes[0], kEyes[1], glm::dvec3(-4000.3, 900.7, 12345.6)}) {
    const Camera camera = camera_at(eye, 33.3, -21.7);
    set_thresholds(camera, 4.0);
    const std::vector<Decoded> decoded =
        decoder_.run(block_of(camera, scale_.least_cos2), vertices_, texels_, rows_);
    ASSERT_NE(decoded[0].clip[3], 0.0f);
    std::map<std::tuple<int, int, int>, const Decoded*> seen;
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      const std::size_t patch = i / kPageVertices / slot_pages(kLevel);
      if (i - slot(static_cast<PatchId>(patch)) >= static_cast<std::size_t>(patch_vertices(kLevel))) continue;
      const glm::ivec3 origin = patch_origin(surface_.surface().volume_of(static_cast<PatchId>(patch)));
      const GpuVertex& g = vertices_[i];
      const auto [first, inserted] = seen.emplace(
          std::tuple(origin.x + g.position[0], origin.y + g.position[1], origin.z + g.position[2]),
          &decoded[i]);
      if (inserted) continue;
      ++shared;
      const float x = decoded[i].in_patch[0] * float{kStepsPerVoxel};
      moving += x != static_cast<float>(g.position[0]) && x != static_cast<float>(g.morph[0]) ? 1 : 0;
      ASSERT_EQ(std::memcmp(first->second->clip, decoded[i].clip, sizeof decoded[i].clip), 0);
    }
  }
  EXPECT_GT(shared, 10'000u);
  EXPECT_GT(moving, 1'000u);
}

}  // namespace
}  // namespace karst::core
