// SPDX-License-Identifier: MIT
// How a draw list becomes draw calls: the variants that were tried, over one world and one view at several
// error targets. karst_bench_draws [--smoke]
//
//   stream      all indices of the frame in one buffer of 32 bits, one draw call (what the renderer does)
//   base vertex a call a range of indices, from a static 16-bit table (EXT_draw_elements_base_vertex); needs
//               slots of consecutive pages
//   multi-draw  the same, all ranges of a level in one call (EXT_multi_draw_arrays)
//   instances   a call a level and edge state, from the static table; plain ES 3.0, but vertices have to be
//               pulled from a texture, because attributes do not start anew for an instance
//
// The picture is small, so that vertices, triangles and calls are what is measured, and not pixels.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "platform/base/freed_memory.h"
#include "renderer/input/shader_interface.h"
#include "terrain/draw/expand_indices.h"
#include "terrain/draw/index_batches.h"
#include "tests/gl/gl_fixture.h"

namespace karst::core {
namespace {

using test::DrawnWorld;
using test::GlContext;

constexpr int kLevel = 4;
constexpr int kPulledWidth = 2048;  // texels of a row of the texture that vertices are pulled from

// What the renderer binds for its draw calls stays bound for those that are measured.
bool keep_bindings = false;
Gl driver;
Gl keeping(const Gl& gl) {
  driver = gl;
  Gl kept = gl;
  kept.BindTexture = [](GLenum target, GLuint name) {
    if (name != 0 || !keep_bindings) driver.BindTexture(target, name);
  };
  kept.BindBufferBase = [](GLenum target, GLuint index, GLuint name) {
    if (name != 0 || !keep_bindings) driver.BindBufferBase(target, index, name);
  };
  return kept;
}

struct Result {
  double submit_ms = 0;
  double frame_ms = 0;
  std::uint32_t calls = 0;
};

template <class Work>
Result measure(const Gl& gl, int repeats, Work&& work) {
  std::vector<double> submit, frame;
  Result result;
  for (int n = 0; n < repeats; ++n) {
    const GLfloat far = 1.0f;
    gl.ClearBufferfv(GL_DEPTH, 0, &far);
    gl.Finish();
    const auto start = std::chrono::steady_clock::now();
    result.calls = work();
    const auto submitted = std::chrono::steady_clock::now();
    gl.Finish();
    const auto end = std::chrono::steady_clock::now();
    submit.push_back(std::chrono::duration<double, std::milli>(submitted - start).count());
    frame.push_back(std::chrono::duration<double, std::milli>(end - start).count());
  }
  const auto median = [](std::vector<double>& v) {
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
  };
  result.submit_ms = median(submit);
  result.frame_ms = median(frame);
  return result;
}

void print(const char* name, const Result& r) {
  std::printf("  %-20s %7.3f ms submit  %7.3f ms frame  %5u calls\n", name, r.submit_ms, r.frame_ms, r.calls);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

// The terrain's vertex shader with its vertex pulled by index from a texture.
std::string pulling_shader() {
  std::string text = kShaderTexts[static_cast<std::size_t>(ShaderVariant::terrain)].vertex;
  text = replaced(text, "gl_VertexID", "vertex_id");
  text = replaced(text, "layout(location = KARST_LOCATION_POSITION) in ivec4 position_normal;",
                  "layout(location = 2) in int first_vertex;\nuniform highp isampler2D pulled;\n"
                  "int vertex_id;\nivec4 position_normal;");
  text =
      replaced(text, "layout(location = KARST_LOCATION_MORPH) in ivec4 morph_normal;", "ivec4 morph_normal;");
  return replaced(text, "TerrainVertex v = read_terrain_vertex();",
                  "vertex_id = first_vertex + gl_VertexID;\n"
                  "ivec4 t = texelFetch(pulled, ivec2(vertex_id & 2047, vertex_id >> 11), 0);\n"
                  "position_normal = ivec4(t.x << 16, t.x, t.y << 16, t.y) >> 16;\n"
                  "morph_normal = ivec4(t.z << 16, t.z, t.w << 16, t.w) >> 16;\n"
                  "TerrainVertex v = read_terrain_vertex();");
}

class Bench {
 public:
  Bench(int side, int repeats) : repeats_(repeats), world_(make(side), gl_, settings()) {
    world_.lod.mode = LodMode::error;
    char log[512];
    Status status = programs_.create(gl_, {}, log);
    EXPECT_TRUE(status.ok());
    const Surface surface = world_.world().surface();
    const std::uint32_t slot = slot_pages(kLevel);
    vertices_.resize(surface.patches.size() * slot * kPageVertices);
    std::vector<GpuVertex> patch(static_cast<std::size_t>(patch_vertices(kLevel)));
    // Slots in one piece, which base vertex needs; morph rows stay where they are.
    const PageTable resident = world_.pages();
    pages_ = test::TestPages(surface.patches.size(), world_.renderer().settings().vertex_pages);
    for (PatchId p = 0; p < surface.patches.size(); ++p) {
      EXPECT_TRUE(world_.residency().generate(p, kLevel, kLevel, patch).ok());
      std::copy(patch.begin(), patch.end(), vertices_.begin() + p * std::ptrdiff_t{slot} * kPageVertices);
      pages_.set(p, p * slot, slot);
      const Volume& v = surface.volume_of(p);
      const std::uint32_t row =
          resident.texels[resident.first_page[p]].place >> KARST_PLACE_BITS & KARST_MASK(KARST_ROW_BITS);
      EXPECT_TRUE(
          world_.renderer()
              .upload_vertices(pages_.table(), p, 0, patch, {v.corner[0], v.corner[1], v.corner[2]}, row)
              .ok());
    }
    make_buffers();
    make_pulling();
  }

  void run(double error_px) {
    world_.lod.error_px = error_px;
    CameraSettings camera;
    camera.position = {40, 26, 90};
    camera.pitch_deg = -25;
    FrameCounts counts;
    EXPECT_TRUE(world_.prepare(camera, input_).ok());
    input_.pages = pages_.table();
    keep_bindings = true;
    EXPECT_TRUE(world_.draw(input_, &counts).ok());
    keep_bindings = false;
    world_.target().begin();
    gl_.Viewport(0, 0, world_.target().settings().width, world_.target().settings().height);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.Enable(GL_CULL_FACE);
    std::printf("%g px: %zu patches, %llu triangles\n", error_px, input_.items.size(),
                static_cast<unsigned long long>(counts.triangles));
    gl_.UseProgram(programs_[ShaderVariant::terrain]);
    print("stream", measure(gl_, repeats_, [&] { return stream(); }));
    const auto base_vertex =
        context_.function<PFNGLDRAWELEMENTSBASEVERTEXEXTPROC>("glDrawElementsBaseVertexEXT");
    const auto multi_draw =
        context_.function<PFNGLMULTIDRAWELEMENTSBASEVERTEXEXTPROC>("glMultiDrawElementsBaseVertexEXT");
    if (base_vertex != nullptr) {
      print("base vertex", measure(gl_, repeats_, [&] { return ranges(base_vertex, nullptr); }));
    }
    if (multi_draw != nullptr) {
      print("multi-draw", measure(gl_, repeats_, [&] { return ranges(nullptr, multi_draw); }));
    }
    gl_.UseProgram(pulling_);
    print("instances", measure(gl_, repeats_, [&] { return instances(); }));
    EXPECT_EQ(gl_.GetError(), GLenum{GL_NO_ERROR});
  }

 private:
  static test::DrawnSettings settings() {
    test::DrawnSettings s;
    s.picture.width = 64;
    s.picture.height = 36;
    return s;
  }
  static test::TestWorld make(int side) {
    test::TestWorld world({side, 24, side}, [](glm::ivec3 v) {
      return v.y < 10 + 6 * test::value_noise(3, glm::dvec3(v.x, v.y, v.z) / 9.0);
    });
    world.roughen(kLevel, 9, 500);
    return world;
  }

  void make_array(GLuint& array, GLuint indices) {
    gl_.GenVertexArrays(1, &array);
    gl_.BindVertexArray(array);
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
    for (const GLuint half : {0u + KARST_LOCATION_POSITION, 0u + KARST_LOCATION_MORPH}) {
      gl_.VertexAttribIPointer(half, 4, GL_SHORT, sizeof(GpuVertex),
                               reinterpret_cast<const void*>(std::size_t{half} * 8));
      gl_.EnableVertexAttribArray(half);
    }
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
  }

  void make_buffers() {
    gl_.GenBuffers(4, buffers_);
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices_.size() * sizeof(GpuVertex)),
                   vertices_.data(), GL_STATIC_DRAW);
    make_array(streamed_, buffers_[1]);
    stream_indices_ = world_.renderer().settings().stream_indices;
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, GLsizeiptr{stream_indices_} * 4, nullptr, GL_STREAM_DRAW);
    make_array(tabled_, buffers_[2]);
    const auto table = world_.world().index_table();
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(table.size_bytes()), table.data(),
                   GL_STATIC_DRAW);
  }

  void make_pulling() {
    const std::string vertex = pulling_shader();
    pulling_ = gl_.CreateProgram();
    const char* const texts[] = {vertex.c_str(),
                                 kShaderTexts[static_cast<std::size_t>(ShaderVariant::terrain)].fragment};
    for (const int stage : {0, 1}) {
      const GLuint shader = gl_.CreateShader(stage == 0 ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
      gl_.ShaderSource(shader, 1, &texts[stage], nullptr);
      gl_.CompileShader(shader);
      gl_.AttachShader(pulling_, shader);
    }
    gl_.LinkProgram(pulling_);
    GLint linked = GL_FALSE;
    gl_.GetProgramiv(pulling_, GL_LINK_STATUS, &linked);
    EXPECT_EQ(linked, GL_TRUE);
    gl_.UseProgram(pulling_);
    gl_.UniformBlockBinding(pulling_, gl_.GetUniformBlockIndex(pulling_, "FrameBlock"), KARST_BINDING_FRAME);
    const std::pair<const char*, int> samplers[] = {
        {"page_table", KARST_UNIT_PAGE_TABLE},       {"morph_entries", KARST_UNIT_MORPH_ENTRIES},
        {"morph_rows", KARST_UNIT_MORPH_ROWS},       {"far_textures", KARST_UNIT_FAR_TEXTURES},
        {"near_textures", KARST_UNIT_NEAR_TEXTURES}, {"pulled", 15}};
    for (const auto& [name, unit] : samplers) gl_.Uniform1i(gl_.GetUniformLocation(pulling_, name), unit);
    const auto rows = static_cast<GLsizei>(vertices_.size() / kPulledWidth + 1);
    vertices_.resize(static_cast<std::size_t>(rows) * kPulledWidth);
    gl_.GenTextures(1, &pulled_);
    gl_.ActiveTexture(GL_TEXTURE0 + 15);
    gl_.BindTexture(GL_TEXTURE_2D, pulled_);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl_.TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32I, kPulledWidth, rows);
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kPulledWidth, rows, GL_RGBA_INTEGER, GL_INT, vertices_.data());
    gl_.GenVertexArrays(1, &instanced_);
    gl_.BindVertexArray(instanced_);
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[2]);
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[3]);
    gl_.EnableVertexAttribArray(2);
    context_.function<PFNGLVERTEXATTRIBDIVISORPROC>("glVertexAttribDivisor")(2, 1);
  }

  std::uint32_t stream() {
    gl_.BindVertexArray(streamed_);
    const ExpandIndices all{input_.index_table, input_.items, input_.pages, {}};
    std::uint32_t calls = 0;
    for (ExpandIndices::Chunk chunk; chunk.next_item < input_.items.size(); ++calls) {
      void* mapped = gl_.MapBufferRange(GL_ELEMENT_ARRAY_BUFFER, 0, GLsizeiptr{stream_indices_} * 4,
                                        GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
      ExpandIndices expand = all;
      expand.out = {static_cast<std::uint32_t*>(mapped), stream_indices_};
      chunk = expand.run(chunk.next_item);
      gl_.UnmapBuffer(GL_ELEMENT_ARRAY_BUFFER);
      gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(chunk.indices), GL_UNSIGNED_INT, nullptr);
    }
    return calls;
  }

  static const void* offset(const IndexRange& range) {
    return reinterpret_cast<const void*>(std::size_t{range.first} * sizeof(std::uint16_t));
  }

  std::uint32_t ranges(PFNGLDRAWELEMENTSBASEVERTEXEXTPROC single,
                       PFNGLMULTIDRAWELEMENTSBASEVERTEXEXTPROC multi) {
    gl_.BindVertexArray(tabled_);
    counts_.clear();
    offsets_.clear();
    bases_.clear();
    std::uint32_t calls = 0;
    for (const DrawItem& item : input_.items) {
      IndexRange found[kMaxIndexRanges];
      const int used = index_ranges(item.level, item.lower_edges, item.skipped_edges, found);
      const auto base = static_cast<GLint>(input_.pages.first_page[item.patch] * kPageVertices);
      for (int r = 0; r < used; ++r) {
        const auto count = static_cast<GLsizei>(found[r].count);
        if (single != nullptr) {
          single(GL_TRIANGLES, count, GL_UNSIGNED_SHORT, offset(found[r]), base);
          ++calls;
        } else {
          counts_.push_back(count);
          offsets_.push_back(offset(found[r]));
          bases_.push_back(base);
        }
      }
    }
    if (multi != nullptr) {
      multi(GL_TRIANGLES, counts_.data(), GL_UNSIGNED_SHORT, offsets_.data(),
            static_cast<GLsizei>(counts_.size()), bases_.data());
      ++calls;
    }
    return calls;
  }

  std::uint32_t instances() {
    const auto divided = context_.function<PFNGLDRAWELEMENTSINSTANCEDPROC>("glDrawElementsInstanced");
    gl_.BindVertexArray(instanced_);
    std::map<std::tuple<int, int, int>, std::vector<GLint>> groups;
    for (const DrawItem& item : input_.items) {
      groups[{item.level, item.lower_edges, item.skipped_edges}].push_back(
          static_cast<GLint>(input_.pages.first_page[item.patch] * kPageVertices));
    }
    std::vector<GLint> firsts;
    for (const auto& [state, group] : groups) firsts.insert(firsts.end(), group.begin(), group.end());
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[3]);
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(firsts.size() * sizeof(GLint)), firsts.data(),
                   GL_STREAM_DRAW);
    std::uint32_t calls = 0;
    std::size_t first = 0;
    for (const auto& [state, group] : groups) {
      gl_.VertexAttribIPointer(2, 1, GL_INT, 0, reinterpret_cast<const void*>(first * sizeof(GLint)));
      IndexRange found[kMaxIndexRanges];
      const auto [level, lower, skipped] = state;
      const int used =
          index_ranges(level, static_cast<unsigned>(lower), static_cast<unsigned>(skipped), found);
      for (int r = 0; r < used; ++r, ++calls) {
        divided(GL_TRIANGLES, static_cast<GLsizei>(found[r].count), GL_UNSIGNED_SHORT, offset(found[r]),
                static_cast<GLsizei>(group.size()));
      }
      first += group.size();
    }
    return calls;
  }

  int repeats_;
  GlContext& context_ = GlContext::get();
  const Gl gl_ = keeping(context_.gl());
  DrawnWorld world_;
  Programs programs_;
  std::vector<GpuVertex> vertices_;  // of all slots
  test::TestPages pages_{0, 0};
  ViewInput input_;
  std::uint32_t stream_indices_ = 0;
  GLuint buffers_[4] = {};  // vertices, streamed indices, table of indices, instances
  GLuint streamed_ = 0, tabled_ = 0, instanced_ = 0;
  GLuint pulling_ = 0, pulled_ = 0;
  std::vector<GLsizei> counts_;
  std::vector<const void*> offsets_;
  std::vector<GLint> bases_;
};

}  // namespace
}  // namespace karst::core

int main(int argc, char** argv) {
  karst::keep_freed_memory();
  const bool smoke = argc > 1 && std::strcmp(argv[1], "--smoke") == 0;
  karst::core::Bench bench(smoke ? 24 : 96, smoke ? 1 : 51);
  for (const double error_px : {4.0, 1.0, 0.25}) bench.run(error_px);
  return testing::Test::HasFailure() ? 1 : 0;
}
