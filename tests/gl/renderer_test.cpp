// SPDX-License-Identifier: MIT
// Pictures and depth of small worlds, on the real driver with debug messages on.
#include "renderer/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/draw/index_batches.h"
#include "tests/gl/gl_fixture.h"

namespace karst::core {
namespace {

using test::DrawnWorld;
using test::GlContext;
using test::Picture;

constexpr int kWidth = 160;
constexpr int kHeight = 90;

test::DrawnSettings debug_settings() {
  test::DrawnSettings settings;
  settings.picture.width = kWidth;
  settings.picture.height = kHeight;
  settings.picture.keep_depth = true;
  settings.debug = true;
  return settings;
}

CameraSettings camera_at(glm::dvec3 position, double yaw_deg, double pitch_deg) {
  CameraSettings camera;
  camera.position = position;
  camera.yaw_deg = yaw_deg;
  camera.pitch_deg = pitch_deg;
  return camera;
}

void expect_no_errors(Renderer& renderer) {
  EXPECT_EQ(take_gl_errors(GlContext::get().gl()), GLenum{GL_NO_ERROR});
  EXPECT_STREQ(renderer.message(), "");
}

const std::uint8_t* pixel(const Picture& picture, int x, int y) {
  return picture.data() + (static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)) * 4;
}

double brightness(const Picture& picture) {
  return std::accumulate(picture.begin(), picture.end(), 0.0) / static_cast<double>(picture.size());
}

TEST(Renderer, DrawsWithoutGlErrors) {
  DrawnWorld world(test::hills_with_cave(3), GlContext::get().gl(), debug_settings());
  EXPECT_TRUE(world.renderer().caps().debug);
  FrameCounts counts;
  for (int frame = 0; frame < 10; ++frame) {
    ASSERT_TRUE(world.draw(camera_at({11, 15, 22}, 36.0 * frame, -25), &counts).ok());
  }
  world.picture();
  std::vector<float> depth(kWidth * kHeight);
  EXPECT_TRUE(world.target().read_depth(depth).ok());
  expect_no_errors(world.renderer());
}

TEST(Renderer, TerrainBelowAndSkyAbove) {
  DrawnWorld world(test::level_ground(5, 2), GlContext::get().gl(), debug_settings());
  FrameCounts counts;
  ASSERT_TRUE(world.draw(camera_at({12, 7, 20}, 0, 0), &counts).ok());
  EXPECT_GT(counts.triangles, 100u);
  EXPECT_EQ(counts.draw_calls, 2u);
  EXPECT_EQ(counts.left_out, 0u);
  const Picture picture = world.picture();
  const std::uint8_t* sky = pixel(picture, kWidth / 2, 5);
  const std::uint8_t* ground = pixel(picture, kWidth / 2, kHeight - 5);
  EXPECT_GT(sky[2], sky[0]) << "the sky is blue";
  EXPECT_GT(ground[1], ground[2]) << "level ground is green";
  for (std::size_t i = 3; i < picture.size(); i += 4) ASSERT_EQ(picture[i], 255);
}

TEST(Renderer, DepthIsThatOfTheProjection) {
  DrawnWorld world(test::level_ground(5, 2), GlContext::get().gl(), debug_settings());
  CameraSettings camera = camera_at({12, 9, 12}, 0, -90);
  camera.near_voxels = 0.5;
  camera.far_voxels = 50;
  ASSERT_TRUE(world.draw(camera).ok());
  std::vector<float> depth(kWidth * kHeight);
  ASSERT_TRUE(world.target().read_depth(depth).ok());
  const double distance = 4;
  const double expected =
      camera.far_voxels / (camera.far_voxels - camera.near_voxels) * (1 - camera.near_voxels / distance);
  for (const float value : depth) ASSERT_NEAR(value, expected, 3e-7);
}

TEST(Renderer, DepthRowsRunDownwardsAndTheSkyIsFar) {
  DrawnWorld world(test::level_ground(5, 2), GlContext::get().gl(), debug_settings());
  ASSERT_TRUE(world.draw(camera_at({12, 7, 20}, 0, 0)).ok());
  std::vector<float> depth(kWidth * kHeight);
  ASSERT_TRUE(world.target().read_depth(depth).ok());
  EXPECT_EQ(depth[kWidth / 2], 1.0f);
  float last = 1.0f;
  for (int y = kHeight / 2 + 10; y < kHeight; ++y) {
    const float value = depth[static_cast<std::size_t>(y * kWidth + kWidth / 2)];
    EXPECT_LT(value, last);
    last = value;
  }
}

TEST(Renderer, DepthIsKeptOnlyWhenAskedFor) {
  test::DrawnSettings settings = debug_settings();
  settings.picture.keep_depth = false;
  DrawnWorld world(test::level_ground(5, 1), GlContext::get().gl(), settings);
  std::vector<float> depth(kWidth * kHeight);
  Picture picture(kWidth * kHeight * 4);
  EXPECT_EQ(world.target().read_colour(picture).code(), StatusCode::invalid_argument) << "nothing was drawn";
  ASSERT_TRUE(world.draw(camera_at({12, 7, 20}, 0, 0)).ok());
  EXPECT_EQ(world.target().read_depth(depth).code(), StatusCode::invalid_argument);
  picture.pop_back();
  EXPECT_EQ(world.target().read_colour(picture).code(), StatusCode::invalid_argument);
}

// A stream of indices that holds a few patches only draws the same picture in many parts.
TEST(Renderer, ShortIndexStreamDrawsTheSamePicture) {
  constexpr int kLevel = 3;
  const CameraSettings camera = camera_at({11, 15, 22}, 10, -30);
  test::DrawnSettings all = debug_settings();
  all.stream_indices = 1u << 20;
  DrawnWorld roomy(test::hills_with_cave(kLevel), GlContext::get().gl(), all);
  FrameCounts roomy_counts;
  ASSERT_TRUE(roomy.draw(camera, &roomy_counts).ok());
  test::DrawnSettings settings = debug_settings();
  settings.stream_indices = max_patch_indices(kLevel) * 5;
  DrawnWorld tight(test::hills_with_cave(kLevel), GlContext::get().gl(), settings);
  FrameCounts tight_counts;
  ASSERT_TRUE(tight.draw(camera, &tight_counts).ok());
  EXPECT_EQ(tight_counts.triangles, roomy_counts.triangles);
  EXPECT_EQ(roomy_counts.draw_calls, 2u) << "the terrain's and the sky's";
  EXPECT_GT(tight_counts.draw_calls, 10u);
  EXPECT_EQ(tight.picture(), roomy.picture());
  settings.stream_indices = max_patch_indices(kLevel) - 1;
  DrawnWorld too_tight(test::hills_with_cave(kLevel), GlContext::get().gl(), settings);
  EXPECT_EQ(too_tight.draw(camera).code(), StatusCode::invalid_argument);
  expect_no_errors(tight.renderer());
}

// Patches drawn at several levels: where two levels meet there is no hole for the sky to show through.
TEST(Renderer, NoHolesBetweenLevels) {
  DrawnWorld world(test::level_ground(5, 4), GlContext::get().gl(), debug_settings());
  test::TestWorld rough = test::level_ground(5, 4);
  rough.roughen(4, 5, 2500);
  DrawnWorld rough_world(rough, GlContext::get().gl(), debug_settings());
  rough_world.lod.distance_voxels = 14;  // all levels within the picture
  CameraSettings camera = camera_at({12.2, 10.3, 12.1}, 20, -90);
  ASSERT_TRUE(rough_world.draw(camera).ok());
  std::vector<float> depth(kWidth * kHeight);
  ASSERT_TRUE(rough_world.target().read_depth(depth).ok());
  EXPECT_EQ(std::count(depth.begin(), depth.end(), 1.0f), 0);
}

TEST(Renderer, TheSunLightsWhatFacesIt) {
  DrawnWorld world(test::level_ground(5, 1), GlContext::get().gl(), debug_settings());
  const CameraSettings down = camera_at({12, 9, 12}, 0, -90);
  double before = 1e9;
  for (const double elevation : {70.0, 30.0, 8.0, -20.0}) {
    world.light.sun_elevation_deg = elevation;
    ASSERT_TRUE(world.draw(down).ok());
    const double now = brightness(world.picture());
    EXPECT_LT(now, before) << elevation;
    before = now;
  }
  world.light.sun_elevation_deg = 91;
  EXPECT_EQ(world.draw(down).code(), StatusCode::invalid_argument);
}

// The visitor's lamp and the missing sky: inside the cave it is brown and dim, whatever the sun does.
TEST(Renderer, CavesAreDarkerThanTheGroundAbove) {
  DrawnWorld world(test::hills_with_cave(3), GlContext::get().gl(), debug_settings());
  world.light.sun_elevation_deg = 60;
  ASSERT_TRUE(world.draw(camera_at({11, 15, 10}, 0, -90)).ok());
  const double outside = brightness(world.picture());
  const CameraSettings in_cave = camera_at({11, 4.5, 10}, 0, 0);
  ASSERT_TRUE(world.draw(in_cave).ok());
  const Picture inside = world.picture();
  EXPECT_LT(brightness(inside), outside);
  EXPECT_GT(brightness(inside), 75.0) << "255 / 4 is black with alpha";
  const std::uint8_t* wall = pixel(inside, kWidth / 2, kHeight / 2);
  EXPECT_GT(wall[0], wall[2]) << "the lamp is warm";
}

// Four colours from above: the image's first row is in the north, its first column in the west, and it ends
// where the world's content does, half a voxel inside the sides.
TEST(Renderer, DrapeLiesNorthUpOverTheContent) {
  test::DrawnSettings settings = debug_settings();
  settings.drape_width = 64;
  settings.drape_height = 32;
  DrawnWorld world(test::level_ground(5, 2), GlContext::get().gl(), settings);  // 24 voxels square
  std::vector<std::uint8_t> image;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) {
      const auto on = [](bool yes) { return static_cast<std::uint8_t>(yes ? 200 : 0); };
      image.insert(image.end(), {on(x >= 32), on(y >= 16), 100, 255});
    }
  }
  EXPECT_EQ(world.renderer().upload_drape(std::span(image).first(100)).code(), StatusCode::invalid_argument);
  ASSERT_TRUE(world.renderer().upload_drape(image).ok());
  world.light.sun_elevation_deg = 90;
  FrameCounts counts;
  ASSERT_TRUE(world.draw(camera_at({12, 20, 12}, 0, -90), &counts).ok());
  EXPECT_EQ(counts.draw_calls, 1u) << "no sky";
  const Picture picture = world.picture();
  const auto expect = [&](int x, int y, int red, int green) {
    const std::uint8_t* p = pixel(picture, x, y);
    EXPECT_EQ(p[0], red) << x << ' ' << y;
    EXPECT_EQ(p[1], green) << x << ' ' << y;
    EXPECT_EQ(p[2], 100) << x << ' ' << y;
  };
  // North is up in the picture, east to the right.
  expect(60, 20, 0, 0);
  expect(100, 20, 200, 0);
  expect(60, 70, 0, 200);
  expect(100, 70, 200, 200);
  world.light.sun_elevation_deg = -5;
  ASSERT_TRUE(world.draw(camera_at({12, 20, 12}, 0, -90)).ok());
  EXPECT_EQ(pixel(world.picture(), 60, 20)[2], 25) << "a quarter of the light is ambient";
  expect_no_errors(world.renderer());
}

// A vertex finds its patch, its place and its thresholds by the page it lies in: pages may lie anywhere in
// the buffer, and rows of thresholds anywhere in their texture. Vertices of finer levels may come later.
TEST(Renderer, PagesMayLieAnywhere) {
  constexpr int kLevel = 4;
  test::TestWorld world = test::level_ground(5, kLevel);
  world.roughen(kLevel, 5, 1500);
  DrawnWorld usual(world, GlContext::get().gl(), debug_settings());
  usual.lod.mode = LodMode::error;
  usual.lod.error_px = 12;
  const CameraSettings camera = camera_at({12, 9, 20}, 0, -35);
  ViewInput input;
  ASSERT_TRUE(usual.prepare(camera, input).ok());
  FrameCounts counts;
  ASSERT_TRUE(usual.draw(input, &counts).ok());
  const Picture expected = usual.picture();
  for (int level = 1; level <= kLevel; ++level) EXPECT_GT(usual.selection.list.at_level[level], 0u) << level;

  // The same patches in pages that stride through a larger buffer, over several rows of the page texture, and
  // rows of thresholds from the last one backwards.
  RendererSettings settings = usual.renderer().settings();
  const Surface surface = world.surface();
  const auto patches = static_cast<std::uint32_t>(surface.patches.size());
  constexpr std::uint32_t kPages = 10'007;  // a prime
  ASSERT_LT(patches * slot_pages(kLevel), kPages);
  settings.vertex_pages = kPages;
  settings.morph_rows = patches + 100;
  Renderer renderer;
  ASSERT_TRUE(renderer.create(GlContext::get().gl(), settings).ok());
  ASSERT_TRUE(renderer.upload_sky(usual.world().sky()).ok());
  test::TestPages pages(patches, kPages);
  const auto row_of = [&](PatchId p) { return patches + 99 - p; };
  std::vector<std::vector<std::uint32_t>> chains(patches);
  std::uint32_t page = 0;
  const auto upload = [&](PatchId p, int from_level, int level) {
    for (auto n = chains[p].size(); n < slot_pages(level); ++n) {
      chains[p].push_back(page);
      page = (page + 3'001) % kPages;
    }
    pages.set(p, chains[p]);
    const std::vector<GpuVertex> vertices = world.vertices(p, kLevel);
    const auto first = static_cast<std::uint32_t>(from_level == 0 ? 0 : patch_vertices(from_level));
    const auto count = static_cast<std::uint32_t>(patch_vertices(level)) - first;
    const Volume& v = surface.volume_of(p);
    const glm::ivec3 origin(v.corner[0], v.corner[1], v.corner[2]);
    return renderer
        .upload_vertices(pages.table(), p, first, std::span(vertices).subspan(first, count), origin,
                         row_of(p))
        .ok();
  };
  for (PatchId p = 0; p < patches; ++p) {
    ASSERT_TRUE(upload(p, 0, p % 4 == 0 ? 1 : 2));
    std::array<std::uint16_t, kMorphRow> row;
    make_morph_row(surface, usual.residency().thresholds().lods(usual.view().threshold_set()), p, row);
    ASSERT_TRUE(renderer.upload_morph_rows(row_of(p), row).ok());
  }
  input.pages = pages.table();
  const auto draw = [&] {
    usual.target().begin();
    const Status status = renderer.draw(input, {.viewport = usual.target().viewport()});
    usual.target().end();
    counts = renderer.end_frame();
    return status;
  };
  ASSERT_TRUE(draw().ok());
  EXPECT_EQ(counts.left_out, usual.selection.list.at_level[3] + usual.selection.list.at_level[4]);
  for (PatchId p = 0; p < patches; ++p) {
    ASSERT_TRUE(p % 4 != 0 || upload(p, 1, 2));
    ASSERT_TRUE(upload(p, 2, kLevel));
  }
  ASSERT_TRUE(draw().ok());
  EXPECT_EQ(counts.left_out, 0u);
  EXPECT_EQ(usual.picture(), expected);
  expect_no_errors(renderer);
}

}  // namespace
}  // namespace karst::core
