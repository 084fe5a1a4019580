// SPDX-License-Identifier: MIT
// Shadows against rays cast on the CPU through the same triangles, and what the maps cost.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/gl/gl_fixture.h"
#include "tests/gl/noop_gl.h"
#include "tests/gl/shadow_rays.h"

namespace karst::core {
namespace {

using test::GlContext;
using test::Picture;
using test::ShadowedWorld;
using test::showing_shadows;
using test::Tally;
using test::Triangles;

constexpr int kWidth = 160;
constexpr int kHeight = 90;
constexpr int kLevel = 3;

// Hills, a cave, and things that throw long shadows: a pillar, a wall, a slab on two feet.
test::TestWorld shadow_world() {
  test::TestWorld world({40, 22, 36}, [](glm::ivec3 v) {
    const glm::dvec3 p = glm::dvec3(v) + 0.5;
    const bool pillar = std::abs(p.x - 20) < 1.6 && std::abs(p.z - 12) < 1.6 && p.y < 16;
    const bool wall = p.x > 8 && p.x < 16 && p.z > 20 && p.z < 23 && p.y < 13;
    const bool foot = (std::abs(p.x - 27) < 1.1 || std::abs(p.x - 35) < 1.1) && std::abs(p.z - 22) < 2.1;
    const bool slab = p.x > 26 && p.x < 36 && p.z > 20 && p.z < 24 && p.y > 11 && p.y < 14;
    const double hills = 7 + 2 * test::value_noise(3, glm::dvec3(v.x, 0, v.z) / 7.0);
    return p.y < hills || pillar || wall || slab || (foot && p.y < 12);
  });
  world.roughen(kLevel, 9, 150);
  return world;
}

test::DrawnSettings shadow_settings() {
  test::DrawnSettings settings;
  settings.picture.width = kWidth;
  settings.picture.height = kHeight;
  settings.picture.keep_depth = true;
  settings.debug = true;
  settings.cascades = 2;
  return settings;
}

TEST(Shadows, AgreeWithRaysOnTheCpu) {
  const test::TestWorld world = shadow_world();
  for (const int size : {512, 1024}) {
    for (const int bits : {16, 24}) {
      if (size == 512 && bits == 24) continue;
      test::DrawnSettings settings = shadow_settings();
      settings.shadow_size = size;
      settings.shadow_bits = bits;
      ShadowedWorld shadowed(world, showing_shadows(), settings);
      const Triangles triangles(shadowed.drawn);
      Tally tally;
      for (const double azimuth : {40.0, 205.0, 290.0}) {
        for (const double elevation : {20.0, 50.0}) {
          shadowed.drawn.light.sun_azimuth_deg = azimuth;
          shadowed.drawn.light.sun_elevation_deg = elevation;
          for (const auto& [eye, yaw, pitch] : {std::tuple(glm::dvec3(18, 18, 40), 5.0, -28.0),
                                                std::tuple(glm::dvec3(24, 11, 16), 120.0, -12.0)}) {
            CameraSettings camera;
            camera.position = eye;
            camera.yaw_deg = yaw;
            camera.pitch_deg = pitch;
            judge(shadowed, triangles, camera, 1.0, 3, tally);
          }
        }
      }
      std::printf("%d^2, %d bits: %d of %d judged pixels in shadow, %.3f %% wrong, %.3f %% false shadow\n",
                  size, bits, tally.shaded, tally.judged, 100.0 * tally.wrong / tally.judged,
                  100.0 * tally.acne / tally.judged);
      EXPECT_GT(tally.judged, 10'000);
      EXPECT_GT(tally.shaded, 1'000);
      EXPECT_LE(tally.wrong, tally.judged * 0.005);
      EXPECT_LE(tally.acne, tally.judged * 0.001);
      EXPECT_EQ(shadowed.drawn.target().take_error(), GLenum{GL_NO_ERROR});
      EXPECT_STREQ(shadowed.drawn.renderer().message(), "");
    }
  }
}

// A wall along z on level ground, its foot seen from straight above. Where the ground faces the sun and rays
// say that the wall shades it, the drawn shadow should begin at once: the gap is how far from there, away
// from the wall, it does, in texels of the map. The worst of all rows of pixels.
double contact_gap(ShadowedWorld& world, const Triangles& triangles, double foot_x) {
  CameraSettings camera;
  camera.position = {foot_x + 1.2, 8, 30};
  camera.pitch_deg = -90;
  world.draw(camera);
  const Picture picture = world.drawn.picture();
  const std::vector<glm::dvec3> points = test::points_behind(world.drawn.target(), camera);
  double gap = 0;
  for (std::size_t row = 2; row < kHeight; row += 8) {
    double begins = -1;
    for (std::size_t i = row * kWidth; i < (row + 1) * kWidth; ++i) {
      const glm::dvec3 p = points[i];
      if (p.x < foot_x || p.y > 4.1 || picture[i * 4 + 1] < 0.15 * 255) continue;
      if (begins < 0 && !triangles.hit(p, world.light.z, 0.005)) continue;
      if (begins < 0) begins = p.x;
      if (picture[i * 4] >= 128) continue;
      gap = std::max(gap, (p.x - begins) / world.cascades[0].texel);
      break;
    }
  }
  return gap;
}

TEST(Shadows, BeginAtTheFootOfWhatCasts) {
  for (const int thickness : {1, 2, 4}) {
    const test::TestWorld flat({120, 12, 60}, [&](glm::ivec3 v) {
      return v.y < 4 || (v.x >= 40 && v.x < 40 + thickness && v.z > 10 && v.z < 50 && v.y < 9);
    });
    test::TestWorld field = flat;
    field.roughen(2, 1, 0);
    test::DrawnSettings settings = shadow_settings();
    settings.cascades = 1;
    settings.shadow_size = 512;
    ShadowedWorld world(field, showing_shadows(), settings);
    world.fit.settings.reach_voxels = 256;
    const Triangles triangles(world.drawn);
    for (const double elevation : {15.0, 20.0, 30.0, 45.0, 60.0, 75.0}) {
      double gap = 0;
      for (const double azimuth : {270.0, 240.0, 305.0}) {
        world.drawn.light.sun_azimuth_deg = azimuth;
        world.drawn.light.sun_elevation_deg = elevation;
        gap = std::max(gap, contact_gap(world, triangles, 40 + thickness));
      }
      const double texel = world.cascades[0].texel;
      std::printf("wall of %.1f texels, sun at %.0f: gap %.2f texels\n", thickness / texel, elevation, gap);
      EXPECT_LE(gap, 1.5) << thickness << ' ' << elevation;
    }
  }
}

// A caster behind the camera throws its shadow into the picture: the pillar's top, seen from its foot.
TEST(Shadows, CastersOutOfViewAreNotLost) {
  const test::TestWorld world = shadow_world();
  ShadowedWorld shadowed(world, showing_shadows(), shadow_settings());
  shadowed.drawn.light.sun_azimuth_deg = 180;  // from the south: shadows fall to the north
  shadowed.drawn.light.sun_elevation_deg = 35;
  CameraSettings camera;
  camera.position = {20, 13, 9.5};  // north of the pillar, looking north and down
  camera.pitch_deg = -50;
  shadowed.draw(camera);
  const Picture picture = shadowed.drawn.picture();
  int dark = 0;
  for (std::size_t i = 0; i < picture.size(); i += 4) dark += picture[i + 1] > 40 && picture[i] < 30 ? 1 : 0;
  EXPECT_GT(dark, kWidth * kHeight / 20);
}

// The bits of one of the shadow maps.
Picture read_map(const Gl& gl, GLuint maps, int layer, int size) {
  const auto compile = [&](GLenum kind, const char* text) {
    const GLuint shader = gl.CreateShader(kind);
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    return shader;
  };
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, compile(GL_VERTEX_SHADER,
                                   "#version 300 es\nvoid main() { gl_Position = vec4(vec2(gl_VertexID & 1, "
                                   "gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }"));
  gl.AttachShader(program, compile(GL_FRAGMENT_SHADER,
                                   "#version 300 es\nprecision highp float;\n"
                                   "uniform highp sampler2DArray map; uniform int layer; out vec4 colour;\n"
                                   "void main() { float d = texelFetch(map, ivec3(gl_FragCoord.xy, layer), "
                                   "0).r * 65535.0; colour = vec4(floor(d / 256.0), mod(d, 256.0), 0.0, 0.0) "
                                   "/ 255.0; }"));
  gl.LinkProgram(program);
  gl.UseProgram(program);
  gl.Uniform1i(gl.GetUniformLocation(program, "map"), KARST_UNIT_SHADOW_MAPS);
  gl.Uniform1i(gl.GetUniformLocation(program, "layer"), layer);
  gl.ActiveTexture(GL_TEXTURE0 + KARST_UNIT_SHADOW_MAPS);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, maps);
  const auto set = [&](GLenum name, GLenum value) {
    gl.TexParameteri(GL_TEXTURE_2D_ARRAY, name, static_cast<GLint>(value));
  };
  set(GL_TEXTURE_COMPARE_MODE, GL_NONE);
  set(GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  app::PictureTarget target;
  EXPECT_TRUE(target.create(GlContext::get().loader(), {.width = size, .height = size}).ok());
  target.begin();
  gl.Viewport(0, 0, size, size);
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_CULL_FACE);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  target.end();
  Picture bits(static_cast<std::size_t>(size) * static_cast<std::size_t>(size) * 4);
  EXPECT_TRUE(target.read_colour(bits).ok());
  set(GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  set(GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.UseProgram(0);
  gl.DeleteProgram(program);
  return bits;
}

// Every map is drawn anew in each of these frames, and holds the same bits: no edge can move.
TEST(Shadows, TurningTheCameraMovesNoEdge) {
  const Gl& gl = GlContext::get().gl();
  test::DrawnSettings settings = shadow_settings();
  settings.shadow_size = 512;
  ShadowedWorld world(shadow_world(), gl, settings);
  world.drawn.lod.mode = LodMode::error;
  CameraSettings camera;
  camera.position = {18.3, 14.1, 26.7};
  Cascade boxes[2];
  Picture maps[2];
  for (int turn = 0; turn < 24; ++turn) {
    camera.yaw_deg = 15 * turn - 180;
    camera.pitch_deg = 10 * (turn % 5) - 30;
    world.draw(camera);
    for (int n = 0; n < 2; ++n) {
      const Picture map = read_map(gl, world.drawn.renderer().shadow_maps(), n, settings.shadow_size);
      if (turn == 0) {
        boxes[n] = world.cascades[n];
        maps[n] = map;
        EXPECT_NE(*std::max_element(map.begin(), map.end()), *std::min_element(map.begin(), map.end()));
      }
      ASSERT_TRUE(world.cascades[n].same_as(boxes[n])) << turn;
      ASSERT_TRUE(map == maps[n]) << turn;
    }
  }
  camera.position.x += 9;  // the test can see a difference
  world.draw(camera);
  EXPECT_FALSE(read_map(gl, world.drawn.renderer().shadow_maps(), 0, settings.shadow_size) == maps[0]);
}

// Where nothing blocks the sun the picture is the one without maps.
TEST(Shadows, LevelGroundHasNone) {
  test::DrawnSettings settings = shadow_settings();
  ShadowedWorld with(test::level_ground(5, kLevel), showing_shadows(), settings);
  CameraSettings camera;
  camera.position = {12, 9, 20};
  camera.pitch_deg = -20;
  for (const double elevation : {3.0, 10.0, 45.0, 90.0}) {
    with.drawn.light.sun_elevation_deg = elevation;
    with.draw(camera);
    const Picture picture = with.drawn.picture();
    for (std::size_t i = 0; i < picture.size(); i += 4) {
      ASSERT_TRUE(picture[i + 2] != 0 || picture[i] >= 254) << elevation;  // blue: the sky
    }
  }
}

TEST(Shadows, MapsTakeTheirBudgetAndDrawsAreCounted) {
  const Gl gl = test::NoopGl::reset();
  test::DrawnSettings settings = shadow_settings();
  settings.cascades = 3;
  settings.shadow_size = 2048;
  settings.loader = test::NoopGl::loader();
  ShadowedWorld world(test::hills_with_cave(1), gl, settings);
  Budget budget;
  world.drawn.renderer().settings().add_to(budget);
  EXPECT_EQ(test::NoopGl::get().object_bytes, budget.gpu_bytes() + settings.picture.bytes());
  EXPECT_EQ(budget.bytes(GpuConsumer::shadow_maps), 3u * 2048 * 2048 * 2);
  const std::uint64_t objects = test::NoopGl::get().objects_made;
  FrameCounts counts;
  CameraSettings camera;
  camera.position = {11, 14, 18};
  camera.pitch_deg = -30;
  world.draw(camera, &counts);
  const std::uint64_t questions = test::NoopGl::get().questions;
  world.draw(camera, &counts);
  EXPECT_EQ(test::NoopGl::get().questions, questions) << "no frame asks the driver for anything";
  EXPECT_EQ(counts.draw_calls, 5u) << "three maps, the terrain, the sky";
  EXPECT_EQ(test::NoopGl::get().objects_made, objects);
  CascadeInput none;
  EXPECT_STREQ(world.drawn.renderer().draw_cascade(3, none).field(), "index");
  EXPECT_STREQ(world.drawn.renderer().draw_cascade(-1, none).field(), "index");
}

TEST(Shadows, DefaultsAreFourMebibytes) {
  test::DrawnSettings settings;
  settings.vertex_pages = settings.morph_rows = 10;
  settings.cascades = CascadeSettings().count;
  settings.shadow_size = CascadeSettings().size;
  Budget budget;
  settings.add_to(budget);
  EXPECT_EQ(budget.bytes(GpuConsumer::shadow_maps), std::size_t{4} << 20);
}

}  // namespace
}  // namespace karst::core
