// SPDX-License-Identifier: MIT
// What the renderer says to settings and drivers that will not do, and that it leaves nothing behind then.
#include <cmath>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/renderer.h"
#include "terrain/draw/index_batches.h"
#include "tests/gl/gl_fixture.h"
#include "tests/gl/noop_gl.h"

namespace karst::core {
namespace {

using test::NoopGl;

void nothing() {}

const DrawTarget kSmall{.viewport = {0, 0, 16, 9}};

RendererSettings small_settings() {
  RendererSettings settings;
  settings.vertex_pages = 100;
  settings.morph_rows = 10;
  settings.stream_indices = 1000;
  return settings;
}

TEST(DeviceLimits, SettingsAreChecked) {
  EXPECT_TRUE(small_settings().validate().ok());
  const struct {
    const char* field;
    std::function<void(RendererSettings&)> spoil;
  } cases[] = {
      {"vertex_pages", [](RendererSettings& s) { s.vertex_pages = 0; }},
      {"vertex_pages", [](RendererSettings& s) { s.vertex_pages = kMostPages + 1; }},
      {"morph_rows", [](RendererSettings& s) { s.morph_rows = 0; }},
      {"morph_rows", [](RendererSettings& s) { s.morph_rows = kMostViews * kMostPages + 1; }},
      {"stream_indices", [](RendererSettings& s) { s.stream_indices = 23; }},
      {"anisotropy", [](RendererSettings& s) { s.anisotropy = 17; }},
      {"anisotropy", [](RendererSettings& s) { s.anisotropy = -1; }},
      {"cascades", [](RendererSettings& s) { s.cascades = 4; }},
      {"air_blocks", [](RendererSettings& s) { s.air_blocks = 9; }},
      {"shadow_size", [](RendererSettings& s) { s.shadow_size = 1000; }},
      {"shadow_bits", [](RendererSettings& s) { s.shadow_bits = 32; }},
      {"drape_width", [](RendererSettings& s) { s.drape_height = 1; }},
      {"drape_height", [](RendererSettings& s) { s.drape_width = RendererSettings::kMaxPicture; }},
      {"drape_repeat", [](RendererSettings& s) { s.drape_width = s.drape_height = 1, s.drape_repeat = NAN; }},
      {"extent", [](RendererSettings& s) { s.extent.y = 0; }},
      {"extent", [](RendererSettings& s) { s.extent.z = (1 << 20) + 1; }},
      {"sky", [](RendererSettings& s) { s.sky.cells.x = 0; }},
      {"sky", [](RendererSettings& s) { s.sky.cells.y = 257; }},
  };
  for (const auto& c : cases) {
    RendererSettings settings = small_settings();
    c.spoil(settings);
    EXPECT_EQ(settings.validate().code(), StatusCode::invalid_argument) << c.field;
    EXPECT_STREQ(settings.validate().field(), c.field);
    const Gl gl = NoopGl::reset();
    Renderer renderer;
    EXPECT_EQ(renderer.create(gl, settings).code(), StatusCode::invalid_argument);
    EXPECT_EQ(NoopGl::get().objects_made, 0u);
  }
}

TEST(DeviceLimits, TheLeastDeviceOfES30HoldsTheLargestConfig) {
  const Gl gl = NoopGl::reset();
  RendererSettings settings = small_settings();
  settings.vertex_pages = kMostPages;
  settings.morph_rows = 2048 * 64;
  settings.extent = glm::ivec3(512);
  settings.sky = SkyVisibility::grid_for(settings.extent, SIZE_MAX);
  Renderer renderer;
  EXPECT_TRUE(renderer.create(gl, settings).ok());
}

TEST(DeviceLimits, MissingFunctionIsNamed) {
  GlLoader loader;
  loader.load = [](void*, const char* name) -> void (*)() {
    return std::strcmp(name, "glMapBufferRange") == 0 ? nullptr : nothing;
  };
  Gl gl;
  const Status status = load_gl(loader, false, gl);
  EXPECT_EQ(status.code(), StatusCode::unsupported);
  EXPECT_STREQ(status.field(), "glMapBufferRange");
  // Functions of extensions may be missing.
  loader.load = [](void*, const char* name) -> void (*)() {
    const std::string text = name;
    return text.ends_with("KHR") || text.ends_with("EXT") || text.ends_with("NV") ? nullptr : nothing;
  };
  EXPECT_TRUE(load_gl(loader, false, gl).ok());
}

TEST(DeviceLimits, OtherContextsAreRefused) {
  for (const char* version : {"OpenGL ES 2.0 Mesa 22.3.6", "4.5 (Core Profile) Mesa 22.3.6", ""}) {
    const Gl gl = NoopGl::reset();
    NoopGl::get().version = version;
    Renderer renderer;
    const Status status = renderer.create(gl, small_settings());
    EXPECT_EQ(status.code(), StatusCode::unsupported) << version;
    EXPECT_STREQ(renderer.message(), version);
  }
}

// A host's error is neither karst's nor lost.
TEST(DeviceLimits, PendingErrorsAreTakenWhenCreating) {
  const Gl gl = NoopGl::reset();
  NoopGl::get().error = GL_OUT_OF_MEMORY;
  Renderer renderer;
  ASSERT_TRUE(renderer.create(gl, small_settings()).ok());
  EXPECT_EQ(renderer.pending_error(), GLenum{GL_OUT_OF_MEMORY});
  ASSERT_TRUE(renderer.create(gl, small_settings()).ok());
  EXPECT_EQ(renderer.pending_error(), GLenum{GL_NO_ERROR});
}

TEST(DeviceLimits, ViewsThatDoNotFitAreRefused) {
  const Gl gl = NoopGl::reset();
  Renderer renderer;
  ASSERT_TRUE(renderer.create(gl, small_settings()).ok());
  ViewInput input;
  ASSERT_TRUE(make_camera(CameraSettings(), input.camera).ok());
  EXPECT_STREQ(renderer.draw(input, {.viewport = {0, 0, 0, 9}}).field(), "viewport");
  EXPECT_STREQ(renderer.draw(input, {.viewport = {0, 0, 16, 16385}}).field(), "viewport");
  EXPECT_STREQ(renderer.draw(input, {.viewport = {0, 0, 16, 9}, .depth_zero_to_one = true}).field(),
               "depth_zero_to_one");
  const Cascade cascades[1] = {};
  input.cascades = cascades;
  EXPECT_STREQ(renderer.draw(input, kSmall).field(), "cascades");
  EXPECT_STREQ(renderer.set_air(0, {}).field(), "view");
  EXPECT_EQ(NoopGl::get().draws, 0u);
}

TEST(DeviceLimits, EachLimitIsNamedAndNothingIsLeft) {
  const struct {
    const char* field;
    StatusCode code;
    std::function<void(NoopGl&, RendererSettings&)> spoil;
  } cases[] = {
      {"vertex_pages", StatusCode::limit_reached,
       [](NoopGl& gl, RendererSettings&) { gl.max_element_index = 100 * kPageVertices - 2; }},
      {"vertex_pages", StatusCode::limit_reached,
       [](NoopGl& gl, RendererSettings& s) {
         gl.max_texture_size = 300;
         s.vertex_pages = 301 * 1024;
       }},
      {"drape_width", StatusCode::limit_reached,
       [](NoopGl&, RendererSettings& s) { s.drape_width = 2049, s.drape_height = 1; }},
      {"drape_height", StatusCode::limit_reached,
       [](NoopGl&, RendererSettings& s) { s.drape_width = 1, s.drape_height = 2049; }},
      {"morph_rows", StatusCode::limit_reached,
       [](NoopGl&, RendererSettings& s) { s.morph_rows = 2048 * 64 + 1; }},
      {"first_unit", StatusCode::limit_reached, [](NoopGl&, RendererSettings& s) { s.first_unit = 24; }},
      {"first_block", StatusCode::limit_reached, [](NoopGl&, RendererSettings& s) { s.first_block = 23; }},
      {"shadow_size", StatusCode::limit_reached,
       [](NoopGl& gl, RendererSettings& s) { gl.framebuffers_complete = false, s.cascades = 1; }},
      {"GPU memory", StatusCode::limit_reached,
       [](NoopGl& gl, RendererSettings&) { gl.out_of_memory = true; }},
      {"shader", StatusCode::unsupported, [](NoopGl& gl, RendererSettings&) { gl.compiles = false; }},
  };
  for (const auto& c : cases) {
    const Gl gl = NoopGl::reset();
    RendererSettings settings = small_settings();
    c.spoil(NoopGl::get(), settings);
    Renderer renderer;
    const Status status = renderer.create(gl, settings);
    EXPECT_EQ(status.code(), c.code) << c.field;
    EXPECT_STREQ(status.field(), c.field);
    EXPECT_EQ(NoopGl::get().objects_deleted, NoopGl::get().objects_made) << c.field;
  }
}

TEST(DeviceLimits, ShaderErrorsSayWhichShaderAndWhy) {
  const Gl gl = NoopGl::reset();
  NoopGl::get().compiles = false;
  Renderer renderer;
  EXPECT_FALSE(renderer.create(gl, small_settings()).ok());
  EXPECT_STREQ(renderer.message(), "terrain (vertex shader): 0:1: no-op cannot compile");
}

TEST(DeviceLimits, WorksWithoutExtensions) {
  const Gl gl = NoopGl::reset();
  NoopGl::get().extensions = false;
  Renderer renderer;
  ASSERT_TRUE(renderer.create(gl, small_settings()).ok());
  EXPECT_FALSE(renderer.caps().debug);
  EXPECT_FALSE(renderer.caps().timer_query);
  ViewInput input;
  ASSERT_TRUE(make_camera(CameraSettings(), input.camera).ok());
  EXPECT_TRUE(renderer.draw(input, kSmall).ok());
  EXPECT_NE(renderer.terrain_gpu_ms(), renderer.terrain_gpu_ms());  // NaN
}

TEST(DeviceLimits, AnisotropyFitsTheDevice) {
  const struct {
    const char* what;
    bool extensions;
    int most, wanted, expected;
  } cases[] = {{"by itself", true, 16, 0, 4},          {"of a lesser device", true, 2, 0, 2},
               {"as wanted", true, 16, 8, 8},          {"more than there is", true, 4, 16, 4},
               {"none wanted", true, 16, 1, 1},        {"no extension", false, 16, 8, 1},
               {"a driver that says 0", true, 0, 8, 1}};
  for (const auto& c : cases) {
    const Gl gl = NoopGl::reset();
    NoopGl::get().extensions = c.extensions;
    NoopGl::get().max_anisotropy = c.most;
    Renderer renderer;
    RendererSettings settings = small_settings();
    settings.anisotropy = c.wanted;
    ASSERT_TRUE(renderer.create(gl, settings).ok());
    EXPECT_EQ(renderer.settings().anisotropy, c.expected) << c.what;
    // Near and far textures. Where it is 1, a driver without the extension would take the call for an error.
    EXPECT_EQ(NoopGl::get().anisotropic_textures, c.expected > 1 ? 2u : 0u) << c.what;
    EXPECT_EQ(NoopGl::get().anisotropy, c.expected > 1 ? c.expected : 0) << c.what;
  }
  const Gl gl = NoopGl::reset();
  Renderer renderer;
  RendererSettings settings = small_settings();
  settings.drape_width = settings.drape_height = 16;
  ASSERT_TRUE(renderer.create(gl, settings).ok());
  EXPECT_EQ(NoopGl::get().anisotropic_textures, 3u);
}

TEST(DeviceLimits, TimerReportsTheGpusTime) {
  const Gl gl = NoopGl::reset();
  Renderer renderer;
  RendererSettings settings = small_settings();
  settings.timers = true;
  ASSERT_TRUE(renderer.create(gl, settings).ok());
  EXPECT_NE(renderer.terrain_gpu_ms(), renderer.terrain_gpu_ms());
  ViewInput input;
  ASSERT_TRUE(make_camera(CameraSettings(), input.camera).ok());
  ASSERT_TRUE(renderer.draw(input, kSmall).ok());
  EXPECT_EQ(renderer.terrain_gpu_ms(), 1.5);
}

TEST(DeviceLimits, UploadsThatDoNotFitAreRefused) {
  const Gl gl = NoopGl::reset();
  Renderer renderer;
  ASSERT_TRUE(renderer.create(gl, small_settings()).ok());
  const std::vector<GpuVertex> vertices(33);  // two pages
  test::TestPages pages(3, 200);
  const std::uint32_t chain[] = {99, 7};
  pages.set(0, chain);
  pages.set(1, 98, 1);                       // one page
  const std::uint32_t beyond[] = {50, 150};  // the second page is none of the buffer's
  pages.set(2, beyond);
  EXPECT_TRUE(renderer.upload_vertices(pages.table(), 0, 0, vertices, {}, 9).ok());
  EXPECT_TRUE(renderer.upload_vertices(pages.table(), 0, 31, vertices, {}, 9).ok());

  const struct {
    const char* field;
    PatchId patch;
    std::uint32_t first;
    std::size_t count;
    glm::ivec3 origin;
    std::uint32_t row;
  } cases[] = {{"patch", 1, 0, 33, {}, 0},
               {"patch", 2, 0, 33, {}, 0},
               {"patch", 3, 0, 33, {}, 0},
               {"patch", 0, 32, 33, {}, 0},
               {"vertices", 0, 0, 0, {}, 0},
               {"vertices", 0, 4193, 33, {}, 0},
               {"vertices", 0, 0xffffffffu, 33, {}, 0},
               {"origin", 0, 0, 33, {0, -kMostPageHeight - 1, 0}, 0},
               {"origin", 0, 0, 33, {0, kMostPageHeight, 0}, 0},
               {"row", 0, 0, 33, {}, 10}};
  for (const auto& c : cases) {
    const std::span<const GpuVertex> some = std::span(vertices).first(c.count);
    const Status status = renderer.upload_vertices(pages.table(), c.patch, c.first, some, c.origin, c.row);
    EXPECT_EQ(status.code(), StatusCode::invalid_argument);
    EXPECT_STREQ(status.field(), c.field);
  }
  const std::vector<std::uint16_t> rows(3 * kMorphRow);
  EXPECT_TRUE(renderer.upload_morph_rows(7, rows).ok());
  EXPECT_STREQ(renderer.upload_morph_rows(8, rows).field(), "rows");
  EXPECT_STREQ(renderer.upload_morph_rows(0xffffffffu, rows).field(), "rows");
  EXPECT_STREQ(renderer.upload_morph_rows(0, std::span(rows).first(33)).field(), "rows");
}

TEST(DeviceLimits, LostVerticesAreTold) {
  const Gl gl = NoopGl::reset();
  Renderer renderer;
  ASSERT_TRUE(renderer.create(gl, small_settings()).ok());
  test::TestPages pages(1, 100);
  pages.set(0, 5, 1);
  const std::vector<GpuVertex> vertices(9);
  std::vector<std::uint16_t> table(index_count(1));
  ASSERT_TRUE(build_index_tables(1, table).ok());
  const DrawItem item{0, 1, 0, 0};
  ViewInput input;
  ASSERT_TRUE(make_camera(CameraSettings(), input.camera).ok());
  input.items = {&item, 1};
  input.pages = pages.table();
  input.index_table = table;
  input.max_level = 1;
  for (const bool lost : {false, true, false}) {
    NoopGl::get().loses_vertices = lost;
    ASSERT_TRUE(renderer.upload_vertices(pages.table(), 0, 0, vertices, {}, 0).ok());
    ASSERT_TRUE(renderer.draw(input, kSmall).ok());
    const FrameCounts counts = renderer.end_frame();
    EXPECT_EQ(counts.vertices_lost, lost);
    EXPECT_EQ(counts.draw_calls, lost ? 1u : 2u);
    EXPECT_EQ(counts.uploaded_bytes, vertices.size() * sizeof(GpuVertex) + 100 * sizeof(PageTexel));
  }
}

}  // namespace
}  // namespace karst::core
