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

#include "terrain/patch/index_batches.h"
#include "tests/gl/gl_fixture.h"
#include "tests/gl/noop_gl.h"

namespace karst {
namespace {

using test::DrawnWorld;
using test::GlContext;
using test::Picture;

constexpr int kWidth = 160;
constexpr int kHeight = 90;
constexpr int kLevel = 3;
constexpr double kErrorTexels = 1;  // of casters

// Replaces the picture of the terrain by what the shadow's test says: red is how much of the sun reaches the
// surface, green how much it faces the sun.
void GL_APIENTRY show_shadows(GLuint shader, GLsizei, const GLchar* const* texts, const GLint*) {
  std::string text = texts[0];
  const std::string colour = "colour = picture_colour(mix(albedo * incoming, haze, hazed));";
  const std::size_t at = text.find(colour);
  if (at != std::string::npos && text.find("sun_reaches") != std::string::npos) {
    text.replace(at, colour.size(), "colour = vec4(reached, dot(normal, sun_direction.xyz), 0.0, 1.0);");
  }
  const char* const changed = text.c_str();
  GlContext::get().gl().ShaderSource(shader, 1, &changed, nullptr);
}

Gl showing_shadows() {
  Gl gl = GlContext::get().gl();
  gl.ShaderSource = show_shadows;
  return gl;
}

// The world's triangles at its full level, by patch, in voxels.
class Triangles {
 public:
  explicit Triangles(const test::TestWorld& world) {
    std::vector<std::uint16_t> table(index_count(kLevel));
    EXPECT_TRUE(build_index_tables(kLevel, table).ok());
    const Surface surface = world.surface();
    for (PatchId p = 0; p < surface.patches.size(); ++p) {
      const std::vector<GpuVertex> vertices = world.vertices(p, kLevel);
      const glm::dvec3 origin(patch_origin(surface.volume_of(p)));
      Patch patch;
      IndexRange ranges[kMaxIndexRanges];
      EXPECT_EQ(index_ranges(kLevel, 0, 0, ranges), 1);
      for (std::uint32_t n = 0; n < ranges[0].count; ++n) {
        const GpuVertex& v = vertices[table[ranges[0].first + n]];
        const glm::dvec3 at =
            (origin + glm::dvec3(v.position[0], v.position[1], v.position[2])) / double{kStepsPerVoxel};
        patch.corners.push_back(at);
        patch.low = glm::min(patch.low, at);
        patch.high = glm::max(patch.high, at);
      }
      patches_.push_back(std::move(patch));
    }
  }

  // Whether anything lies on the ray beyond a distance.
  bool hit(glm::dvec3 from, glm::dvec3 direction, double beyond) const {
    const glm::dvec3 inverse = 1.0 / direction;
    for (const Patch& patch : patches_) {
      const glm::dvec3 a = (patch.low - from) * inverse;
      const glm::dvec3 b = (patch.high - from) * inverse;
      const glm::dvec3 first = glm::min(a, b);
      const glm::dvec3 last = glm::max(a, b);
      const double end = std::min({last.x, last.y, last.z});
      if (std::max({first.x, first.y, first.z, beyond}) > end) continue;
      for (std::size_t n = 0; n < patch.corners.size(); n += 3) {
        if (hits(&patch.corners[n], from, direction, beyond)) return true;
      }
    }
    return false;
  }

 private:
  struct Patch {
    std::vector<glm::dvec3> corners;
    glm::dvec3 low{1e9}, high{-1e9};
  };

  // T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
  static bool hits(const glm::dvec3* t, glm::dvec3 from, glm::dvec3 direction, double beyond) {
    const glm::dvec3 u = t[1] - t[0];
    const glm::dvec3 v = t[2] - t[0];
    const glm::dvec3 p = glm::cross(direction, v);
    const double determinant = glm::dot(u, p);
    if (std::abs(determinant) < 1e-15) return false;
    const glm::dvec3 s = from - t[0];
    const double a = glm::dot(s, p) / determinant;
    const glm::dvec3 q = glm::cross(s, u);
    const double b = glm::dot(direction, q) / determinant;
    return a >= 0 && b >= 0 && a + b <= 1 && glm::dot(v, q) / determinant > beyond;
  }

  std::vector<Patch> patches_;
};

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

RendererSettings shadow_settings() {
  RendererSettings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  settings.keep_depth = true;
  settings.debug = true;
  settings.cascades = 2;
  return settings;
}

// A world drawn with shadow maps over all of it.
class ShadowedWorld {
 public:
  ShadowedWorld(const test::TestWorld& world, const Gl& gl, RendererSettings settings)
      : drawn(world, gl, settings) {
    drawn.lod.mode = LodMode::full;
    fit.settings.count = settings.cascades;
    fit.settings.size = settings.shadow_size;
    fit.settings.reach_voxels = 64;
  }

  void draw(const CameraSettings& settings, FrameCounts* counts = nullptr) {
    FrameInput input;
    ASSERT_TRUE(drawn.prepare(settings, input).ok());
    fit.camera = &input.camera;
    fit.to_sun = sun_direction(drawn.light);
    fit.world = drawn.terrain().box();
    fit.light = &light;
    fit.cascades = cascades;
    ASSERT_TRUE(fit.validate().ok());
    fit.run();
    input.light_space = light;
    input.cascades = std::span(cascades).first(static_cast<std::size_t>(fit.settings.count));
    const DrawItem* items = input.items.data();
    for (int n = 0; n < fit.settings.count; ++n) {
      CascadeInput cascade;
      cascade.cascade = cascades[n];
      Terrain::Casters casters;
      ASSERT_TRUE(drawn.terrain().select_casters(cascade.cascade, kErrorTexels, casters).ok());
      EXPECT_EQ(casters.lacking, 0u);
      cascade.items = casters.items;
      cascade.pages = input.pages;
      cascade.index_table = input.index_table;
      cascade.max_level = input.max_level;
      ASSERT_TRUE(drawn.renderer().draw_cascade(n, cascade).ok());
    }
    EXPECT_EQ(items, input.items.data());
    FrameCounts ignored;
    ASSERT_TRUE(drawn.renderer().draw(input, counts != nullptr ? *counts : ignored).ok());
  }

  DrawnWorld drawn;
  FitCascades fit;
  LightSpace light;
  Cascade cascades[kMostCascades];
};

// The points of the surface behind the pixels, voxels; far away where there is none.
std::vector<glm::dvec3> points_behind(Renderer& renderer, const CameraSettings& settings) {
  std::vector<float> depth(kWidth * kHeight);
  EXPECT_TRUE(renderer.read_depth(depth).ok());
  Camera camera;
  EXPECT_TRUE(make_camera(settings, camera).ok());
  const glm::dmat3 axes = world_from_view(camera);
  const double near = camera.near_voxels;
  const double far = camera.far_voxels;
  std::vector<glm::dvec3> points;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double d = depth[static_cast<std::size_t>(y * kWidth + x)];
      const double z = near * far / (far - d * (far - near));
      const double half = z / projection_scale(camera);
      const double right = (2 * (x + 0.5) / kWidth - 1) * half * camera.aspect;
      const double up = (1 - 2 * (y + 0.5) / kHeight) * half;
      points.push_back(d == 1
                           ? glm::dvec3(1e9)
                           : eye_lattice(camera) / double{kStepsPerVoxel} + axes * glm::dvec3(right, up, -z));
    }
  }
  return points;
}

struct Tally {
  int judged = 0;  // pixels that face the sun, away from shadows' borders
  int shaded = 0;  // of these, what rays say
  int wrong = 0;   // shaded or lit by more than half where rays say the other
  int acne = 0;    // darker by a tenth or more where rays reach the sun
};

void judge(ShadowedWorld& world, const Triangles& triangles, const CameraSettings& camera, Tally& tally) {
  world.draw(camera);
  const Picture picture = world.drawn.picture();
  const std::vector<glm::dvec3> points = points_behind(world.drawn.renderer(), camera);
  for (std::size_t i = 0; i < points.size(); i += 3) {
    const glm::dvec3 p = points[i];
    const double facing = picture[i * 4 + 1] / 255.0;
    if (p.x > 1e8 || facing < 0.15) continue;
    const glm::dvec2 at(glm::dot(world.light.x, p), glm::dot(world.light.y, p));
    const auto covers = [&](const Cascade& c) {
      const glm::dvec2 from_middle = glm::abs((at - c.low) / c.side - 0.5);
      return std::max(from_middle.x, from_middle.y) < 0.5 - double{kCascadeBorder} / world.fit.settings.size;
    };
    int used = 0;
    while (used < world.fit.settings.count && !covers(world.cascades[used])) ++used;
    ASSERT_LT(used, world.fit.settings.count);
    // The tent reaches 1.5 texels, and one texel is the border's.
    const double texel = world.cascades[used].texel;
    const glm::dvec3 sun = world.light.z;
    // Beside the point the ray begins above what the surface can rise to there.
    const double rise = 2.5 * texel * std::sqrt(1 - facing * facing) / facing + 0.05;
    const bool hit = triangles.hit(p, sun, 0.03);
    bool same = true;
    for (int n = 0; n < 9 && same; ++n) {
      const glm::dvec3 beside =
          (world.light.x * double(n % 3 - 1) + world.light.y * double(n / 3 - 1)) * (2.0 * texel);
      same = triangles.hit(p + beside, sun, rise) == hit;
    }
    if (!same) continue;
    const double reached = picture[i * 4] / 255.0;
    ++tally.judged;
    tally.shaded += hit ? 1 : 0;
    tally.wrong += (reached < 0.5) != hit ? 1 : 0;
    tally.acne += !hit && reached < 0.9 ? 1 : 0;
  }
}

TEST(Shadows, AgreeWithRaysOnTheCpu) {
  const test::TestWorld world = shadow_world();
  const Triangles triangles(world);
  for (const int size : {512, 1024}) {
    for (const int bits : {16, 24}) {
      if (size == 512 && bits == 24) continue;
      RendererSettings settings = shadow_settings();
      settings.shadow_size = size;
      settings.shadow_bits = bits;
      ShadowedWorld shadowed(world, showing_shadows(), settings);
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
            judge(shadowed, triangles, camera, tally);
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
      EXPECT_EQ(shadowed.drawn.renderer().take_error(), GLenum{GL_NO_ERROR});
      EXPECT_STREQ(shadowed.drawn.renderer().message(), "");
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

// Where nothing blocks the sun the picture is the one without maps.
TEST(Shadows, LevelGroundHasNone) {
  RendererSettings settings = shadow_settings();
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
  RendererSettings settings = shadow_settings();
  settings.cascades = 3;
  settings.shadow_size = 2048;
  ShadowedWorld world(test::hills_with_cave(1), gl, settings);
  Budget budget;
  world.drawn.renderer().settings().add_to(budget);
  EXPECT_EQ(test::NoopGl::get().object_bytes, budget.gpu_bytes());
  EXPECT_EQ(budget.bytes(GpuConsumer::shadow_maps), 3u * 2048 * 2048 * 2);
  const std::uint64_t objects = test::NoopGl::get().objects_made;
  FrameCounts counts;
  CameraSettings camera;
  camera.position = {11, 14, 18};
  camera.pitch_deg = -30;
  world.draw(camera, &counts);
  world.draw(camera, &counts);
  EXPECT_EQ(counts.draw_calls, 5u) << "three maps, the terrain, the sky";
  EXPECT_EQ(test::NoopGl::get().objects_made, objects);
  CascadeInput none;
  EXPECT_STREQ(world.drawn.renderer().draw_cascade(3, none).field(), "index");
  EXPECT_STREQ(world.drawn.renderer().draw_cascade(-1, none).field(), "index");
}

TEST(Shadows, DefaultsAreFourMebibytes) {
  RendererSettings settings;
  settings.vertex_pages = settings.morph_rows = 10;
  settings.cascades = CascadeSettings().count;
  settings.shadow_size = CascadeSettings().size;
  Budget budget;
  settings.add_to(budget);
  EXPECT_EQ(budget.bytes(GpuConsumer::shadow_maps), std::size_t{4} << 20);
}

}  // namespace
}  // namespace karst
