// SPDX-License-Identifier: MIT
// A host's own things in karst's light and air, and in its shadow maps; linear output; the drape.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "tests/gl/dirty_host.h"
#include "tests/library/host.h"
#include "tests/library/vec3.h"
#include "tests/support/test_world.h"
#include "tests/support/world_io.h"

namespace karst {
namespace {

using test::HostPicture;
using test::HostWorld;
using test::Pixels;

constexpr int kWidth = 160;
constexpr int kHeight = 120;

using Rgb = std::array<double, 3>;

Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vec3 unit(Vec3 a) {
  return a * (1 / std::sqrt(dot(a, a)));
}

// output.glsl's curve, typed in again; 0..255.
double displayed(double light) {
  const double x = std::max(light, 0.0) * 0.66;
  const double toned = std::clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
  return 255 * (toned < 0.0031308 ? toned * 12.92 : 1.055 * std::pow(toned, 1 / 2.4) - 0.055);
}

// A parallelogram; u, v: from its middle to two sides.
struct Quad {
  Vec3 middle, u, v;
};

constexpr const char* kQuadShader = R"(#version 300 es
uniform mat4 clip_from_eye;
uniform vec3 middle, u, v;
uniform float nearest;
out vec3 from_eye;
void main() {
  vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2) * 2.0 - 1.0;
  from_eye = middle + u * corner.x + v * corner.y;
  gl_Position = clip_from_eye * vec4(from_eye, 1.0);
  gl_Position.z = max(gl_Position.z, nearest * gl_Position.w);
}
)";
constexpr const char* kPrecision = R"(#version 300 es
precision highp float;
precision highp int;
precision highp sampler2DArrayShadow;
)";
constexpr const char* kLit = R"(
uniform vec3 normal;
in vec3 from_eye;
out vec4 colour;
void main() { colour = karst_display(karst_light(from_eye, normal, vec3(0.5))); }
)";
constexpr const char* kHazed = R"(
uniform vec3 normal;
in vec3 from_eye;
out vec4 colour;
void main() { colour = karst_display(karst_haze(karst_light(from_eye, normal, vec3(0.5)), from_eye)); }
)";

// Any context: its functions by name. 0 and the driver's words where it does not compile and link.
template <class Get>
GLuint link(const Get& get, const std::string& fragment, std::string& words) {
#define KARST_GET(name) const auto name = reinterpret_cast<decltype(&::gl##name)>(get("gl" #name));
  KARST_GET(CreateProgram)
  KARST_GET(CreateShader)
  KARST_GET(ShaderSource)
  KARST_GET(CompileShader)
  KARST_GET(AttachShader)
  KARST_GET(LinkProgram)
  KARST_GET(GetProgramiv)
  KARST_GET(GetShaderInfoLog)
  KARST_GET(DeleteShader)
#undef KARST_GET
  const GLuint program = CreateProgram();
  for (const bool vertex : {true, false}) {
    const GLuint shader = CreateShader(vertex ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
    const std::string text = vertex ? kQuadShader : kPrecision + fragment;
    const char* const texts[] = {text.c_str()};
    ShaderSource(shader, 1, texts, nullptr);
    CompileShader(shader);
    AttachShader(program, shader);
    char log[2048] = "";
    GetShaderInfoLog(shader, sizeof log, nullptr, log);
    words += log;
    DeleteShader(shader);
  }
  LinkProgram(program);
  GLint linked = 0;
  GetProgramiv(program, GL_LINK_STATUS, &linked);
  return linked != 0 ? program : 0;
}

void set(GLuint program, const char* name, Vec3 value) {
  glUniform3f(glGetUniformLocation(program, name), static_cast<GLfloat>(value.x),
              static_cast<GLfloat>(value.y), static_cast<GLfloat>(value.z));
}

void draw_quad(GLuint program, const double* clip_from_eye, Vec3 eye, const Quad& quad,
               float nearest = -1e6f) {
  GLfloat matrix[16];
  for (int n = 0; n < 16; ++n) matrix[n] = static_cast<GLfloat>(clip_from_eye[n]);
  glUseProgram(program);
  glUniformMatrix4fv(glGetUniformLocation(program, "clip_from_eye"), 1, GL_FALSE, matrix);
  glUniform1f(glGetUniformLocation(program, "nearest"), nearest);
  set(program, "middle", quad.middle - eye);
  set(program, "u", quad.u);
  set(program, "v", quad.v);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glUseProgram(0);
}

class Light : public test::HostTest {
 protected:
  Light() : HostTest(kWidth, kHeight) {}
  void SetUp() override {
    std::string words;
    const auto get = [&](const char* name) { return picture_.loader().load(picture_.loader().user, name); };
    lit_ = link(get, std::string(Renderer::air_glsl()) + kLit, words);
    hazed_ = link(get, std::string(Renderer::air_glsl()) + kHazed, words);
    depth_ = link(get, "void main() {}\n", words);
    ASSERT_NE(lit_, 0u) << words;
    ASSERT_NE(hazed_, 0u) << words;
    ASSERT_NE(depth_, 0u) << words;
  }
  void TearDown() override {
    close();
    for (const GLuint program : {lit_, hazed_, depth_}) glDeleteProgram(program);
  }

  void open(Needs needs = {}, std::vector<std::byte> file = test::cave_world_file()) {
    needs.queries = 1;
    needs.query_level = 4;
    needs.query_patches = 65'536;
    HostTest::open(needs, Placement{Axes::east_north_up, {5000, -300, 20}, 25}, {}, std::move(file));
    ASSERT_NE(renderer_, nullptr);
    // From the south and above; and a place for the host's things, high over the ground.
    view_ = test::looking(*host_->world, {20, 45, 50}, {20, 10, 18}, kWidth, kHeight);
    view_.error_px = 0.5;
    place_ = host_->world->from_world({20, 34, 20});
    towards_ = unit(Sun().towards);
  }

  // The caster is drawn into shadow maps where there is one.
  void frame(const Quad* caster, bool moved = true, Output output = Output::display) {
    caster_ = caster;
    casts_ = 0;
    FrameInput input;
    input.views = {&view_, 1};
    input.work_ms = 0;
    input.user = this;
    input.casters_moved = moved;
    input.draw_casters = [](void* user, const double* clip_from_world, Vec3 eye) {
      auto* const self = static_cast<Light*>(user);
      ++self->casts_;
      if (self->caster_ == nullptr) return;
      draw_quad(self->depth_, clip_from_world, eye, *self->caster_, self->nearest_);
    };
    FrameResult result;
    const Status begun = renderer_->begin_frame(input, result);
    ASSERT_TRUE(begun.ok()) << begun.what() << " " << begun.field();
    EXPECT_TRUE(result.complete);
    if (output == Output::display) picture_.clear();
    ASSERT_TRUE(renderer_->draw(0, {{0, 0, kWidth, kHeight}, true, output}).ok());
    ASSERT_TRUE(renderer_->end_frame().ok());
    ASSERT_EQ(glGetError(), GLenum{GL_NO_ERROR});
  }

  Vec3 eye_from_world(Vec3 v) const {
    const double* m = view_.view_from_world;
    return {m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
            m[2] * v.x + m[5] * v.y + m[8] * v.z};
  }

  // Draws a quad over the picture and returns its middle's pixel.
  std::array<int, 3> shade(GLuint program, const Quad& quad, Vec3 normal) {
    const Air air = renderer_->air(0);
    picture_.bind();
    glViewport(0, 0, kWidth, kHeight);
    glUseProgram(program);
    set(program, "normal", normal);
    glUniformBlockBinding(program, glGetUniformBlockIndex(program, "KarstAir"), 4);
    glBindBufferBase(GL_UNIFORM_BUFFER, 4, air.block);
    glUniform1i(glGetUniformLocation(program, "karst_shadow_maps"), 12);
    glActiveTexture(GL_TEXTURE12);
    glBindTexture(GL_TEXTURE_2D_ARRAY, air.shadow_texture);
    double matrix[16] = {};
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) {
        double& sum = matrix[column * 4 + row];
        if (column == 3) {
          sum = view_.clip_from_view[12 + row];
          continue;
        }
        for (int k = 0; k < 3; ++k) {
          sum += view_.clip_from_view[k * 4 + row] * view_.view_from_world[column * 3 + k];
        }
      }
    }
    draw_quad(program, matrix, view_.eye, quad);
    EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    const Vec3 at = eye_from_world(quad.middle - view_.eye);
    const double x = view_.clip_from_view[0] * at.x / -at.z;
    const double y = view_.clip_from_view[5] * at.y / -at.z;
    const Pixels pixels = picture_.read();
    const std::uint8_t* pixel =
        pixels.at(static_cast<int>((0.5 + 0.5 * x) * kWidth), static_cast<int>((0.5 + 0.5 * y) * kHeight));
    return {pixel[0], pixel[1], pixel[2]};
  }

  // What air_glsl() promises of a surface of albedo 0.5.
  Rgb expected(Vec3 normal, bool sunlit) const {
    const Air air = renderer_->air(0);
    const double facing = dot(normal, towards_);
    Rgb out;
    for (std::size_t c = 0; c < 3; ++c) {
      const double sky = 0.5 + 0.5 * normal.z;
      const double ambient = double{air.ground_rgb[c]} * (1 - sky) + double{air.sky_rgb[c]} * sky;
      out[c] = 0.5 * (double{air.sun_rgb[c]} * (sunlit ? std::max(facing, 0.0) : 0.0) +
                      ambient * (0.8 + 0.4 * facing));
    }
    return out;
  }
  static void expect_light(const std::array<int, 3>& pixel, const Rgb& light) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], displayed(light[c]), 2) << c;
  }

  // Places of the ground that pixels show; false where there is none.
  bool ground_at(Query& query, int x, int y, Hit& hit) const {
    const double at_x = (2 * (x + 0.5) / kWidth - 1) / view_.clip_from_view[0];
    const double at_y = (2 * (y + 0.5) / kHeight - 1) / view_.clip_from_view[5];
    const double* m = view_.view_from_world;
    const Vec3 way{m[0] * at_x + m[1] * at_y - m[2], m[3] * at_x + m[4] * at_y - m[5],
                   m[6] * at_x + m[7] * at_y - m[8]};
    return query.ray(view_.eye, view_.eye + way * 200, Wait::for_file, hit);
  }

  void casters_shade_the_terrain(double away);

  GLuint lit_ = 0, hazed_ = 0, depth_ = 0;
  ViewState view_;
  Vec3 place_, towards_;
  const Quad* caster_ = nullptr;
  float nearest_ = -1e6f;  // of casters' depth: -1 keeps those that are nearer to the sun than the world
  int casts_ = 0;
};

TEST_F(Light, HostsSurfacesGetTheSunAndTheSky) {
  open();
  frame(nullptr);
  const Air air = renderer_->air(0);
  const Vec3 of_air{air.sun_towards[0], air.sun_towards[1], air.sun_towards[2]};
  EXPECT_GT(dot(of_air, towards_), 0.99999);
  const Vec3 u = unit(cross(towards_, {0, 0, 1}));
  const Quad quad{place_, u, cross(u, towards_)};
  const std::array<int, 3> facing = shade(lit_, quad, towards_);
  const std::array<int, 3> away = shade(lit_, quad, towards_ * -1);
  const Vec3 slanted = unit(towards_ + u * 1.5);
  const std::array<int, 3> aside = shade(lit_, quad, slanted);
  expect_light(facing, expected(towards_, true));
  expect_light(away, expected(towards_ * -1, true));
  expect_light(aside, expected(slanted, true));
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_GT(facing[c], away[c] + 60);
    EXPECT_GT(aside[c], away[c] + 20);
    EXPECT_LT(aside[c], facing[c]);
  }
}

TEST_F(Light, HazeIsThatOfTheAir) {
  open();
  frame(nullptr);
  const Air air = renderer_->air(0);
  // Far away, to the horizon: all haze in the end.
  const Vec3 level = unit({view_.view_from_world[2] * -1, view_.view_from_world[5] * -1, 0});
  for (const double away : {30.0, 300.0}) {
    const Vec3 middle = view_.eye + level * away + Vec3{0, 0, -0.5 * away};
    const Quad quad{middle, Vec3{0.05, 0, 0} * away, Vec3{0, 0.05, 0} * away};
    // Through what lies before it.
    const std::array<int, 3> pixel = shade(hazed_, quad, {0, 0, 1});
    const Vec3 way = middle - view_.eye;
    const double hazed = 1 - std::exp(-std::sqrt(dot(way, way)) * double{air.haze_per_m});
    EXPECT_GT(hazed, away > 100 ? 0.5 : 0.05);
    const Rgb light = expected({0, 0, 1}, true);
    for (std::size_t c = 0; c < 3; ++c) {
      // Below the horizon the air has its colour.
      const double sky = double{air.horizon_rgb[c]};
      EXPECT_NEAR(pixel[c], displayed(light[c] * (1 - hazed) + sky * hazed), away > 100 ? 24 : 8) << c;
    }
  }
  const Rgb horizon = {air.horizon_display_rgb[0], air.horizon_display_rgb[1], air.horizon_display_rgb[2]};
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(255 * horizon[c], displayed(double{air.horizon_rgb[c]}), 1);
  }
}

// Level ground 5 m high under water up to a height; below 0: dry.
std::vector<std::byte> flooded(float level, double voxel_size_m = 1) {
  test::TestWorld world({40, 24, 36}, [](glm::ivec3 v) { return v.y < 5; });
  world.voxel_size_m = voxel_size_m;
  core::WorldMaterials materials;
  if (level > 0) materials.surroundings = {core::kHasWater, level, 0, 0};
  const std::vector<std::byte> dry = world.file();
  std::vector<std::byte> file;
  const Status status =
      core::write_world({world.info(), &world.octree(), core::read_patches(dry), materials}, file);
  EXPECT_TRUE(status.ok()) << status.what() << ' ' << status.field();
  return file;
}

// Water is a height for them as for the ground: blue with depth, the bed lost in the end; nothing above it.
TEST_F(Light, HostsSurfacesUnderWaterAreSeenThroughIt) {
  const auto seen = [&](float level) {
    open({}, flooded(level));
    frame(nullptr);
    return shade(hazed_, {place_, {1, 0, 0}, {0, 1, 0}}, {0, 0, 1});
  };
  const std::array<int, 3> dry = seen(-1);
  EXPECT_EQ(seen(33), dry);  // it is at 34 m, the eye at 45
  const std::array<int, 3> shallow = seen(36);
  const std::array<int, 3> deep = seen(44);
  std::printf("dry %d %d %d, under 2 m %d %d %d, under 10 m %d %d %d\n", dry[0], dry[1], dry[2], shallow[0],
              shallow[1], shallow[2], deep[0], deep[1], deep[2]);
  EXPECT_LT(shallow[0], dry[0] - 30);
  EXPECT_GT(shallow[2], shallow[0]);
  EXPECT_LT(deep[0], shallow[0]);
  EXPECT_GT(deep[1], deep[0]);
  // From within, 25 m away.
  const std::array<int, 3> within = seen(60);
  EXPECT_LT(within[0], deep[0] + 1);
  EXPECT_GT(within[2], within[0]);
}

// In the sun's glitter too, which is of the surface and not of the bed that lies below it in the world.
TEST_F(Light, TheSeaGoesOnWhereTheWorldEnds) {
  HostTest::open({}, {}, {}, flooded(15, 100));
  ASSERT_NE(renderer_, nullptr);
  const Vec3 to_sun = unit(Sun().towards);
  const Vec3 eye{2000, 9000, 1800};
  view_ = test::looking(*host_->world, eye, eye + Vec3{to_sun.x, -1.7, to_sun.z} * 1000, kWidth, kHeight);
  view_.clip_from_view[10] = -1;  // as far as it goes
  view_.clip_from_view[14] = -200;
  test::draw_frame(*renderer_, picture_, {view_});
  const Pixels pixels = picture_.read();
  int most = 0, brightest = 0, darkest = 255;
  for (int y = 1; y < kHeight / 2; ++y) {
    for (int x = 1; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) {
        const int here = pixels.at(x, y)[c];
        most = std::max({most, std::abs(here - int{pixels.at(x - 1, y)[c]}),
                         std::abs(here - int{pixels.at(x, y - 1)[c]})});
      }
      brightest = std::max(brightest, int{pixels.at(x, y)[0]});
      darkest = std::min(darkest, int{pixels.at(x, y)[0]});
    }
  }
  std::printf("red is %d to %d, neighbours differ by %d at most\n", darkest, brightest, most);
  EXPECT_GT(brightest, darkest + 40);
  EXPECT_LE(most, 5);
}

TEST_F(Light, CastersShadeTheHostsSurfaces) {
  open();
  const Vec3 u = unit(cross(towards_, {0, 0, 1}));
  const Vec3 v = cross(u, towards_);
  const Quad floor{place_, {1, 0, 0}, {0, 1, 0}};
  const Quad caster{place_ + towards_ * 4, u * 4, v * 4};
  frame(nullptr);
  expect_light(shade(lit_, floor, {0, 0, 1}), expected({0, 0, 1}, true));
  frame(&caster);
  EXPECT_EQ(casts_, 2);
  expect_light(shade(lit_, floor, {0, 0, 1}), expected({0, 0, 1}, false));
  // Behind the surface, it casts nothing onto it.
  const Quad behind{place_ - towards_ * 4, u * 4, v * 4};
  frame(&behind);
  expect_light(shade(lit_, floor, {0, 0, 1}), expected({0, 0, 1}, true));
}

// A square before the sun shades what lies behind it, and nothing else.
void Light::casters_shade_the_terrain(double away) {
  Query* query = nullptr;
  ASSERT_TRUE(host_->world->take_query(query).ok());
  Hit target;
  ASSERT_TRUE(ground_at(*query, kWidth / 2, kHeight / 2, target));
  const Vec3 u = unit(cross(towards_, {0, 0, 1}));
  const Vec3 v = cross(u, towards_);
  constexpr double kHalf = 7;
  const Quad caster{target.place + towards_ * away, u * kHalf, v * kHalf};
  frame(nullptr);
  const Pixels before = picture_.read();
  frame(&caster);
  const Pixels after = picture_.read();
  frame(nullptr);
  EXPECT_EQ(test::largest_difference(before, picture_.read()), 0) << "the shadow stays";
  int shaded = 0;
  int darker = 0;
  int free = 0;
  int changed = 0;
  int brighter = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int change = int{after.at(x, y)[1]} - int{before.at(x, y)[1]};
      brighter += change > 1;
      Hit hit;
      const bool ground = ground_at(*query, x, y, hit);
      const Vec3 off = hit.place - caster.middle;
      const double beside = std::max(std::abs(dot(off, u)), std::abs(dot(off, v)));
      if (!ground || beside > kHalf + 1) {
        ++free;
        changed += std::abs(change) > 1;
      } else if (beside < kHalf - 1 && dot(off, towards_) < -1 && dot(hit.normal, towards_) > 0.4) {
        // What the terrain does not shade already.
        Hit rock;
        const Vec3 start = hit.place + hit.normal * 0.3;
        if (query->ray(start, start + towards_ * 100, Wait::for_file, rock)) continue;
        ++shaded;
        darker += change < -10;
      }
    }
  }
  host_->world->release(query);
  EXPECT_GT(shaded, 150);
  EXPECT_GE(darker, shaded * 9 / 10);  // shading normals are smoother than triangles
  EXPECT_GT(free, kWidth * kHeight / 3);
  EXPECT_LE(changed, free / 500);
  EXPECT_EQ(brighter, 0);
}

TEST_F(Light, CastersShadeTheTerrain) {
  open();
  casters_shade_the_terrain(6);
}

TEST_F(Light, CastersHighAboveTheWorldShadeItWhereTheyAreKept) {
  open();
  nearest_ = -1;
  casters_shade_the_terrain(25);
  casters_shade_the_terrain(4000);
}

TEST_F(Light, CastersThatStayDrawNoMapAgain) {
  open();
  const Quad caster{place_, {6, 0, 0}, {0, 6, 0}};
  frame(&caster);
  EXPECT_EQ(casts_, 2);
  const Pixels first = picture_.read();
  for (int n = 0; n < 5; ++n) {
    frame(&caster, false);
    EXPECT_EQ(casts_, 0);
    EXPECT_EQ(costs(*renderer_).cascades_drawn, 0u);
    EXPECT_EQ(test::largest_difference(first, picture_.read()), 0);
  }
  frame(&caster, true);
  EXPECT_EQ(casts_, 2);
  EXPECT_EQ(costs(*renderer_).cascades_drawn, 2u);
  EXPECT_EQ(test::largest_difference(first, picture_.read()), 0);
}

TEST_F(Light, LinearOutputIsThePictureBeforeItsCurve) {
  const char* const extensions = reinterpret_cast<const char*>(glGetString(GL_EXTENSIONS));
  if (extensions == nullptr || (std::strstr(extensions, "GL_EXT_color_buffer_half_float") == nullptr &&
                                std::strstr(extensions, "GL_EXT_color_buffer_float") == nullptr)) {
    GTEST_SKIP() << "the driver has no framebuffers of floating point";
  }
  open();
  frame(nullptr);
  const Pixels shown = picture_.read();
  GLuint names[2];
  GLuint framebuffer = 0;
  glGenRenderbuffers(2, names);
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  const GLenum formats[2] = {0x881A /* RGBA16F */, GL_DEPTH_COMPONENT24};
  const GLenum places[2] = {GL_COLOR_ATTACHMENT0, GL_DEPTH_ATTACHMENT};
  for (int n = 0; n < 2; ++n) {
    glBindRenderbuffer(GL_RENDERBUFFER, names[n]);
    glRenderbufferStorage(GL_RENDERBUFFER, formats[n], kWidth, kHeight);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, places[n], GL_RENDERBUFFER, names[n]);
  }
  ASSERT_EQ(glCheckFramebufferStatus(GL_FRAMEBUFFER), GLenum{GL_FRAMEBUFFER_COMPLETE});
  FrameInput input;
  input.views = {&view_, 1};
  input.work_ms = 0;
  FrameResult result;
  ASSERT_TRUE(renderer_->begin_frame(input, result).ok());
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  ASSERT_TRUE(renderer_->draw(0, {{0, 0, kWidth, kHeight}, true, Output::linear}).ok());
  std::vector<float> light(std::size_t{kWidth} * kHeight * 4);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glReadPixels(0, 0, kWidth, kHeight, GL_RGBA, GL_FLOAT, light.data());
  ASSERT_TRUE(renderer_->end_frame().ok());
  EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
  double most = 0;
  double brightest = 0;
  for (std::size_t n = 0; n < light.size(); ++n) {
    if (n % 4 == 3) continue;
    brightest = std::max(brightest, double{light[n]});
    most = std::max(most, std::abs(displayed(double{light[n]}) - static_cast<double>(shown.rgba[n])));
  }
  EXPECT_LE(most, 2);
  EXPECT_GT(brightest, 0.5);
  glDeleteFramebuffers(1, &framebuffer);
  glDeleteRenderbuffers(2, names);
}

TEST_F(Light, TheDrapeLiesWithItsFirstRowInTheNorth) {
  constexpr std::uint32_t kSide = 8;
  Needs needs;
  needs.drape_width = needs.drape_height = kSide;
  open(needs);
  // North west red, north east green, south blue.
  std::vector<std::uint8_t> image;
  for (std::uint32_t row = 0; row < kSide; ++row) {
    for (std::uint32_t column = 0; column < kSide; ++column) {
      const int colour = row >= kSide / 2 ? 2 : column >= kSide / 2 ? 1 : 0;
      for (int c = 0; c < 3; ++c) image.push_back(c == colour ? 230 : 20);
      image.push_back(255);
    }
  }
  const std::span<const std::uint8_t> whole(image);
  EXPECT_EQ(renderer_->set_drape(whole.first(image.size() - 4)).code(), StatusCode::invalid_argument);
  EXPECT_EQ(renderer_->set_drape({}).code(), StatusCode::invalid_argument);
  ASSERT_TRUE(renderer_->set_drape(whole).ok());
  frame(nullptr);
  const Pixels pixels = picture_.read();
  Query* query = nullptr;
  ASSERT_TRUE(host_->world->take_query(query).ok());
  const WorldInfo& info = host_->world->info();
  const Vec3 middle = (info.low_m + info.high_m) * 0.5;
  int seen[3] = {};
  int wrong = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      Hit hit;
      if (!ground_at(*query, x, y, hit)) continue;
      const Vec3 off = host_->world->to_world(hit.place) - middle;
      // Clear of where colours mix.
      if (std::abs(off.x) < 4 || std::abs(off.z) < 4) continue;
      const std::size_t colour = off.z > 0 ? 2 : off.x > 0 ? 1 : 0;
      ++seen[colour];
      const std::uint8_t* p = pixels.at(x, y);
      for (std::size_t c = 0; c < 3; ++c) wrong += c != colour && p[c] >= p[colour];
    }
  }
  host_->world->release(query);
  for (const int count : seen) EXPECT_GT(count, 300);
  EXPECT_LE(wrong, 20);
}

TEST_F(Light, WithoutADrapeInThePlanThereIsNone) {
  open();
  const std::vector<std::uint8_t> image(256, 9);
  const Status status = renderer_->set_drape(image);
  EXPECT_EQ(status.code(), StatusCode::invalid_argument) << status.what() << " " << status.field();
}

TEST(AirText, CompilesOnTheDesktopToo) {
  const test::HostContext host(test::Api::desktop);
  if (!host.ok()) GTEST_SKIP() << "no desktop OpenGL";
  const auto get = [&](const char* name) { return host.get<void()>(name); };
  std::string words;
  EXPECT_NE(link(get, std::string(Renderer::air_glsl()) + kHazed, words), 0u) << words;
  EXPECT_EQ(link(get, "void main() { nothing(); }", words), 0u);
}

}  // namespace
}  // namespace karst
