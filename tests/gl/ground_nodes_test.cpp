// SPDX-License-Identifier: MIT
// Nodes of several sizes, drawn by the renderer alone: a sheet without a hole near the origin and far away,
// shaded both ways and into shadow maps, what is counted, and what is refused.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/draw/index_batches.h"
#include "terrain/ground/family_row.h"
#include "terrain/patch/octahedral.h"
#include "tests/gl/gl_fixture.h"

namespace karst::core {
namespace {

using test::GlContext;
using test::Picture;

constexpr int kWidth = 320;
constexpr int kHeight = 180;
constexpr float kMagenta[3] = {1, 0, 1};
constexpr int kSide = 24;  // of the sheet, voxels

bool is_magenta(const std::uint8_t* rgba) {
  return rgba[0] == 255 && rgba[1] == 0 && rgba[2] == 255;
}

// Of a sample at whole quarters of a voxel, voxels: multiples of 2^-6, which all sizes' lattices have.
double bumps(int x4, int z4) {
  return std::floor(24 * test::value_noise(5, glm::dvec3(x4, 0, z4) / 3.0)) / 64;
}

// A square of kSide voxels from a corner, in three strips from west to east: nodes of size 2, of size 1, of
// size 0. Vertices at home lie a quarter of their size's voxel apart.
class Sheet {
 public:
  // corner: voxels, multiples of 4.
  explicit Sheet(glm::ivec3 corner) : corner_(corner) {
    for (int size = 2; size >= 0; --size) {
      const int side = 1 << size;
      const int first = (2 - size) * kSide / 3;
      for (int x = first; x < first + kSide / 3; x += side) {
        // West is edge 0: there a coarser strip begins.
        const unsigned lower = x == first && size < 2 ? 1u : 0u;
        for (int z = 0; z < kSide; z += side) add(size, {x, 0, z}, lower);
      }
    }
  }

  // Level, of nodes of one size, at most 3; corner: multiples of 8.
  Sheet(glm::ivec3 corner, int size) : corner_(corner), level_(true) {
    for (int x = 0; x < kSide; x += 1 << size) {
      for (int z = 0; z < kSide; z += 1 << size) add(size, {x, 0, z}, 0);
    }
  }

  // A level node over the sheet that is in no view's list.
  DrawItem add_roof(glm::ivec3 at, int size) {
    const DrawItem roof{static_cast<PatchId>(pages_.size()), kNodeLevel, 0, 0};
    NodePage page{.origin = (corner_ + at) / (1 << size), .size = size};
    std::array<GpuVertex, kNodePageVertices> slot{};
    for (int i = 0; i < kNodeSide; ++i) {
      for (int j = 0; j < kNodeSide; ++j) set(slot, i, j, 0);
    }
    pages_.push_back(page);
    vertices_.push_back(slot);
    return roof;
  }

  std::span<const DrawItem> items() const { return items_; }
  std::vector<DrawItem>& items() { return items_; }
  std::uint32_t pages() const { return static_cast<std::uint32_t>(pages_.size() + 3) / 4 * 4; }

  void upload(Renderer& renderer, const PageTable& table) const {
    for (std::uint32_t n = 0; n < pages_.size(); ++n)
      ASSERT_TRUE(renderer.upload_node(table, n, pages_[n], vertices_[n]).ok());
  }

 private:
  void add(int size, glm::ivec3 at, unsigned lower) {
    items_.push_back({static_cast<PatchId>(pages_.size()), kNodeLevel, static_cast<std::uint8_t>(lower), 0});
    NodePage page{.origin = corner_ + at,
                  .size = size,
                  .quadrant = static_cast<int>(pages_.size() % 4),
                  .material = static_cast<std::uint8_t>(level_ ? 1 : 0)};
    for (int axis = 0; axis < 3; ++axis) page.origin[axis] >>= size;
    std::array<GpuVertex, kNodePageVertices> slot{};
    for (int i = 0; i < kNodeSide; ++i) {
      for (int j = 0; j < kNodeSide; ++j) {
        const double height = level_ ? 0 : bumps(4 * at.x + (j << size), 4 * at.z + (i << size));
        set(slot, i, j, static_cast<int>(height * kStepsPerVoxel) >> size);
      }
    }
    pages_.push_back(page);
    vertices_.push_back(slot);
  }

  // i runs south, j east.
  static void set(std::array<GpuVertex, kNodePageVertices>& slot, int i, int j, int y) {
    GpuVertex& v = slot[static_cast<std::size_t>(vertex_order(kNodeLevel, i, j))];
    v.position[0] = static_cast<std::int16_t>(j * kStepsPerVoxel / 4);
    v.position[1] = static_cast<std::int16_t>(y);
    v.position[2] = static_cast<std::int16_t>(i * kStepsPerVoxel / 4);
    std::copy(std::begin(v.position), std::end(v.position), std::begin(v.morph));
    v.normal = v.morph_normal = encode_octahedral(glm::vec3(0, 1, 0));
  }

  glm::ivec3 corner_;
  bool level_ = false;
  std::vector<DrawItem> items_;
  std::vector<NodePage> pages_;
  std::vector<std::array<GpuVertex, kNodePageVertices>> vertices_;
};

// A renderer of nothing but a sheet, into a picture.
class Scene {
 public:
  Scene(const Sheet& sheet, RendererSettings settings, std::uint32_t stream_indices = 131'072)
      : family_texels_(sheet.pages()), table_(index_count(kNodeLevel)) {
    settings.vertex_pages = 5;
    settings.morph_rows = 2;
    settings.family_pages = sheet.pages();
    settings.family_rows = 1;
    settings.stream_indices = stream_indices;
    settings.debug = true;
    GlContext& context = GlContext::get();
    EXPECT_TRUE(target_.create(context.loader(), {.width = kWidth, .height = kHeight}).ok());
    const Status created = renderer_.create(context.gl(), settings);
    EXPECT_TRUE(created.ok()) << created.what() << ' ' << created.field() << ' ' << renderer_.message();
    EXPECT_TRUE(build_index_tables(kNodeLevel, table_).ok());
    const std::vector<std::uint16_t> rows(kMorphRow, kNeverMorphs);
    EXPECT_TRUE(renderer_.upload_morph_rows(settings.morph_rows, rows).ok());
    sheet.upload(renderer_, pages());
  }

  PageTable pages() { return {{}, {}, {}, family_texels_}; }

  ViewInput input(const CameraSettings& camera, std::span<const DrawItem> nodes) {
    ViewInput input;
    EXPECT_TRUE(make_camera(camera, input.camera).ok());
    input.light.haze_voxels = 1e4;
    input.least_cos2 = 0.5f;
    input.first_family_row = renderer_.settings().morph_rows;
    input.nodes = nodes;
    input.pages = pages();
    input.index_table = table_;
    input.max_level = 1;  // of patches, of which there are none
    return input;
  }

  FrameCounts draw(const ViewInput& input) {
    target_.begin(kMagenta);
    const Status status = renderer_.draw(
        input, {.viewport = target_.viewport(), .framebuffer = target_.framebuffer(), .sky = false});
    EXPECT_TRUE(status.ok()) << status.what() << ' ' << status.field();
    target_.end();
    EXPECT_STREQ(renderer_.message(), "");
    return renderer_.end_frame();
  }

  Picture picture() {
    Picture picture(std::size_t{kWidth} * kHeight * 4);
    EXPECT_TRUE(target_.read_colour(picture).ok());
    return picture;
  }
  int holes() {
    const Picture seen = picture();
    int count = 0;
    for (std::size_t n = 0; n < seen.size(); n += 4) count += is_magenta(seen.data() + n) ? 1 : 0;
    return count;
  }

  Renderer& renderer() { return renderer_; }

 private:
  std::vector<PageTexel> family_texels_;
  std::vector<std::uint16_t> table_;
  app::PictureTarget target_;
  Renderer renderer_;
};

// Low over the sheet's middle, so that what a crack would show is behind it.
CameraSettings camera_over(glm::ivec3 corner, int turn) {
  CameraSettings camera;
  const double angle = turn * 0.7;
  camera.position = glm::dvec3(corner) + glm::dvec3(12 + 3 * std::cos(angle), 3.1, 12 + 3 * std::sin(angle));
  camera.yaw_deg = 40 * turn;
  camera.pitch_deg = -65;
  camera.near_voxels = 0.25;
  return camera;
}

std::uint32_t triangles_of(std::span<const DrawItem> items) {
  std::uint32_t indices = 0;
  for (const DrawItem& item : items) indices += patch_index_count(item.level, item.lower_edges, 0);
  return indices / 3;
}

RendererSettings settings_of(karst::Shading shading) {
  RendererSettings settings;
  settings.shading = shading;
  settings.deferred_width = kWidth;
  settings.deferred_height = kHeight;
  return settings;
}

class GroundNodes : public testing::TestWithParam<karst::Shading> {};

TEST_P(GroundNodes, ThreeSizesMakeOneSheet) {
  for (const glm::ivec3 corner : {glm::ivec3(0), glm::ivec3(300'000, -2'000, -700'004)}) {
    const Sheet sheet(corner);
    Scene scene(sheet, settings_of(GetParam()));
    for (int turn = 0; turn < 9; ++turn) {
      const ViewInput input = scene.input(camera_over(corner, turn), sheet.items());
      const FrameCounts counts = scene.draw(input);
      // Deferred, the screen takes one more.
      const unsigned screen = GetParam() == karst::Shading::deferred ? 1 : 0;
      EXPECT_EQ(counts.triangles, triangles_of(sheet.items()) + screen);
      EXPECT_EQ(counts.draw_calls, 1 + screen);
      EXPECT_EQ(counts.left_out, 0u);
      EXPECT_EQ(scene.holes(), 0) << corner.x << ' ' << turn;
    }
  }
}

// What the test above sees where an edge between two sizes is drawn as one between equal ones.
TEST_P(GroundNodes, WithoutLowerEdgesThereAreHoles) {
  const glm::ivec3 corner(300'000, -2'000, -700'004);
  Sheet sheet(corner);
  for (DrawItem& item : sheet.items()) item.lower_edges = 0;
  Scene scene(sheet, settings_of(GetParam()));
  int holes = 0;
  for (int turn = 0; turn < 9; ++turn) {
    scene.draw(scene.input(camera_over(corner, turn), sheet.items()));
    holes += scene.holes();
  }
  EXPECT_GT(holes, 20);
}

// A roof that no view draws darkens what lies below it, by way of the shadow map.
TEST_P(GroundNodes, CastShadows) {
  Sheet sheet(glm::ivec3(0));
  std::vector<DrawItem> casters(sheet.items().begin(), sheet.items().end());
  casters.push_back(sheet.add_roof({8, 8, 8}, 2));
  RendererSettings settings = settings_of(GetParam());
  settings.cascades = 1;
  Scene scene(sheet, settings);
  CameraSettings camera;
  camera.position = {10, 6, 10};
  camera.pitch_deg = -90;
  ViewInput input = scene.input(camera, sheet.items());
  input.light.sun_elevation_deg = 90;
  LightSpace light;
  std::array<Cascade, 1> cascade;
  FitCascades fit;
  fit.settings.count = 1;
  fit.camera = &input.camera;
  fit.to_sun = light_direction(input.light);
  fit.world = {glm::ivec3(0, -kStepsPerVoxel, 0), glm::ivec3(kSide, 10, kSide) * kStepsPerVoxel};
  fit.light = &light;
  fit.cascades = cascade;
  ASSERT_TRUE(fit.validate().ok());
  fit.run();
  input.light_space = light;
  input.cascades = cascade;
  const auto brightness = [](const Picture& picture, int left) {
    int sum = 0;
    for (int y = kHeight / 2 - 5; y < kHeight / 2 + 5; ++y) {
      for (int x = left; x < left + 10; ++x) sum += picture[static_cast<std::size_t>(y * kWidth + x) * 4 + 1];
    }
    return sum;
  };
  Picture pictures[2];
  for (const bool roof : {false, true}) {
    CascadeInput map;
    map.cascade = cascade[0];
    map.first_family_row = input.first_family_row;
    map.nodes = std::span(casters).first(casters.size() - (roof ? 0 : 1));
    map.pages = input.pages;
    map.index_table = input.index_table;
    map.max_level = input.max_level;
    ASSERT_TRUE(scene.renderer().draw_cascade(0, map).ok());
    const FrameCounts counts = scene.draw(input);
    EXPECT_GE(counts.triangles, triangles_of(map.nodes) + triangles_of(input.nodes));
    pictures[roof ? 1 : 0] = scene.picture();
  }
  // In the middle, which the roof covers, and at the left.
  EXPECT_LT(brightness(pictures[1], kWidth / 2), 0.6 * brightness(pictures[0], kWidth / 2));
  EXPECT_EQ(brightness(pictures[1], 5), brightness(pictures[0], 5));
}

INSTANTIATE_TEST_SUITE_P(Both, GroundNodes,
                         testing::Values(karst::Shading::forward, karst::Shading::deferred),
                         [](const auto& shading) {
                           return shading.param == karst::Shading::forward ? "forward" : "deferred";
                         });

// One material whose textures have no two places alike in a repeat: near ones of 2 voxels, far ones of 32.
void upload_material(Renderer& renderer) {
  MaterialSet set;
  set.count = 1;
  set.side = renderer.settings().material_side;
  set.repeat_log2 = 1;
  ASSERT_TRUE(renderer.set_materials(set).ok());
  for (const TextureArray array : {TextureArray::far, TextureArray::near}) {
    for (int level = 0; level < texture_levels(set.side, array); ++level) {
      const int side = static_cast<int>(texture_side(set.side, array)) >> level;
      std::vector<std::byte> bytes;
      for (int n = 0; n < side * side; ++n) {
        const double s = 6.2831853 * (n % side) / side;
        const double t = 6.2831853 * (n / side) / side;
        for (const double wave : {std::sin(s), std::sin(t), std::sin(s + 2 * t), std::sin(2 * s - t)})
          bytes.push_back(static_cast<std::byte>(static_cast<int>(128 + 90 * wave)));
      }
      ASSERT_TRUE(renderer.upload_textures(array, level, 0, 1, bytes).ok());
    }
  }
}

// What a level sheet looks like does not depend on the size of its nodes: textures go on where they were.
void expect_equal_ground(const RendererSettings& settings, glm::ivec3 far_corner) {
  const bool drape = settings.drape_width > 0;
  for (const glm::ivec3 corner : {glm::ivec3(0), far_corner}) {
    Picture fine;
    for (const int size : {0, 1, 3}) {
      const Sheet sheet(corner, size);
      Scene scene(sheet, settings);
      if (drape) {
        std::vector<std::uint8_t> image;
        for (int n = 0; n < settings.drape_width * settings.drape_height; ++n) {
          const int x = n % settings.drape_width;
          const int z = n / settings.drape_width;
          for (const int value : {20 + 12 * x, 20 + 12 * z, 40 + 6 * (x ^ z), 255})
            image.push_back(static_cast<std::uint8_t>(value));
        }
        ASSERT_TRUE(scene.renderer().upload_drape(image).ok());
      } else {
        upload_material(scene.renderer());
      }
      CameraSettings camera = camera_over(corner, 1);
      camera.position.y += 3;
      camera.pitch_deg = -80;
      scene.draw(scene.input(camera, sheet.items()));
      const Picture seen = scene.picture();
      if (fine.empty()) fine = seen;
      double sum = 0;
      double spread = 0;
      int most = 0;
      for (std::size_t n = 0; n < seen.size(); ++n) {
        const int off = std::abs(seen[n] - fine[n]);
        most = std::max(most, off);
        sum += off;
        if (n % 4 != 3) spread += std::abs(seen[n] - seen[n % 4]);
      }
      EXPECT_LT(sum, 0.02 * static_cast<double>(seen.size())) << corner.x << ' ' << size;
      EXPECT_LE(most, 8) << corner.x << ' ' << size;
      EXPECT_GT(spread, 8.0 * static_cast<double>(seen.size())) << "nothing to see";
    }
  }
}

TEST(GroundNodesTextures, MaterialsGoOnFromSizeToSize) {
  RendererSettings settings;
  settings.shading = karst::Shading::forward;
  settings.material_count = 1;
  settings.material_side = 64;
  expect_equal_ground(settings, {300'008, -2'000, -700'008});
}

TEST(GroundNodesTextures, ImagesGoOnFromSizeToSize) {
  RendererSettings settings;
  settings.drape_width = settings.drape_height = 16;
  settings.extent = {17, 1, 17};
  expect_equal_ground(settings, {296, -2'000, -504});
}

// In as many calls as the stream is short for, and by level as well, the same triangles.
TEST(GroundNodesCounts, TrianglesDoNotDependOnTheStream) {
  const Sheet sheet(glm::ivec3(0));
  const std::uint32_t triangles = triangles_of(sheet.items());
  Picture first;
  for (const std::uint32_t indices : {131'072u, 3'000u, ExpandIndices::kLeastNodeRoom}) {
    RendererSettings settings;
    settings.shading = karst::Shading::forward;
    Scene scene(sheet, settings, indices);
    ViewInput input = scene.input(camera_over(glm::ivec3(0), 1), sheet.items());
    const FrameCounts counts = scene.draw(input);
    EXPECT_EQ(counts.triangles, triangles);
    EXPECT_EQ(counts.left_out, 0u);
    EXPECT_GE(counts.draw_calls, 3 * triangles / indices);
    const Picture picture = scene.picture();
    if (first.empty()) first = picture;
    EXPECT_EQ(picture, first);
    input.show = Show::levels;
    EXPECT_EQ(scene.draw(input).triangles, triangles);
    EXPECT_EQ(scene.holes(), 0);
  }
}

// Sizes have colours of their own: in the sheet's strips yellow, orange and red, whose green falls and whose
// blue rises.
TEST(GroundNodesCounts, SizesAreShown) {
  const Sheet sheet(glm::ivec3(0));
  RendererSettings settings;
  settings.shading = karst::Shading::forward;
  Scene scene(sheet, settings);
  double green = 1;
  double blue = 0;
  for (const double x : {4.0, 12.0, 20.0}) {
    CameraSettings camera;
    camera.position = {x, 2, 12};
    camera.pitch_deg = -90;
    ViewInput input = scene.input(camera, sheet.items());
    input.show = Show::levels;
    scene.draw(input);
    const Picture picture = scene.picture();
    const std::uint8_t* middle = picture.data() + (kHeight / 2 * kWidth + kWidth / 2) * 4;
    const double of_green = 1.0 * middle[1] / middle[0];
    const double of_blue = 1.0 * middle[2] / middle[0];
    EXPECT_LT(of_green, green) << x;
    EXPECT_GT(of_blue, blue + 0.01) << x;
    green = of_green;
    blue = of_blue;
  }
}

TEST(GroundNodesCounts, NodesWithoutAPageAreLeftOut) {
  const Sheet sheet(glm::ivec3(0));
  RendererSettings settings;
  settings.shading = karst::Shading::forward;
  Scene scene(sheet, settings);
  const std::array<DrawItem, 2> nodes = {
      {{sheet.pages(), kNodeLevel, 0, 0}, {sheet.pages() - 1, kNodeLevel, 0, 0}}};
  const FrameCounts counts = scene.draw(scene.input(camera_over(glm::ivec3(0), 0), nodes));
  EXPECT_EQ(counts.left_out, 1u);
  EXPECT_EQ(counts.triangles, 32u);
}

TEST(GroundNodesCounts, WhatDoesNotFitIsRefused) {
  const Sheet sheet(glm::ivec3(0));
  RendererSettings settings;
  settings.shading = karst::Shading::forward;
  Scene scene(sheet, settings);
  const std::array<GpuVertex, kNodePageVertices> vertices{};
  const struct {
    const char* field;
    std::uint32_t page;
    NodePage node;
  } cases[] = {{"page", sheet.pages(), {}},
               {"origin", 0, {.origin = {0, kMostPageHeight, 0}}},
               {"origin", 0, {.origin = {0, -kMostPageHeight - 1, 0}}},
               {"size", 0, {.size = -1}},
               {"size", 0, {.size = kMostPageSize + 1}},
               {"quadrant", 0, {.quadrant = 4}},
               {"row", 0, {.row = 1}},
               {"material", 0, {.material = kMostMaterials + 1}}};
  for (const auto& c : cases) {
    const Status status = scene.renderer().upload_node(scene.pages(), c.page, c.node, vertices);
    EXPECT_EQ(status.code(), StatusCode::invalid_argument);
    EXPECT_STREQ(status.field(), c.field);
  }
  settings.vertex_pages = 1;
  settings.morph_rows = 1;
  settings.stream_indices = 96;
  ASSERT_TRUE(settings.validate().ok());
  settings.family_pages = 6;
  EXPECT_STREQ(settings.validate().field(), "family_pages");
  settings.family_pages = kMostPages;
  EXPECT_STREQ(settings.validate().field(), "family_pages");
  settings.family_pages = 8;
  EXPECT_STREQ(settings.validate().field(), "family_rows");
  settings.family_rows = (kMostViews + 1) * 3;
  EXPECT_TRUE(settings.validate().ok());
  ++settings.family_rows;
  EXPECT_STREQ(settings.validate().field(), "family_rows");
}

}  // namespace
}  // namespace karst::core
