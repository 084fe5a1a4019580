// SPDX-License-Identifier: MIT
#include "tests/gl/gl_fixture.h"

#include <numeric>

#include "platform/headless/headless_display.h"

namespace karst::test {

GlContext& GlContext::get() {
  static std::unique_ptr<GlContext> context;
  // A test that closes a display of its own terminates EGL's only headless display.
  if (context == nullptr || !context->ok() || !context->display_->make_current().ok()) {
    context.reset();
    context.reset(new GlContext());
  }
  EXPECT_TRUE(context->ok());
  return *context;
}

GlContext::GlContext() {
  std::string error;
  display_ = open_headless_display({.debug = true}, error);
  EXPECT_NE(display_, nullptr) << error;
  if (display_ == nullptr) return;
  const Status status = load_gl(loader(), false, gl_);
  EXPECT_TRUE(status.ok()) << status.what() << ' ' << status.field();
}

GlLoader GlContext::loader() {
  return {.load = [](void* user, const char* name) { return static_cast<Display*>(user)->gl_function(name); },
          .user = display_.get()};
}

void TestPages::set(PatchId patch, std::span<const std::uint32_t> chain) {
  first_[patch] = chain.empty() ? kNoPage : chain[0];
  for (std::size_t n = 0; n < chain.size(); ++n)
    next_[chain[n]] = n + 1 < chain.size() ? chain[n + 1] : kNoPage;
}

void TestPages::set(PatchId patch, std::uint32_t first, std::uint32_t count) {
  std::vector<std::uint32_t> chain(count);
  std::iota(chain.begin(), chain.end(), first);
  set(patch, chain);
}

namespace {

Config config_of(std::span<const std::byte> file, std::uint32_t detail_pages) {
  WorldReader reader;
  const Status status = reader.open(ByteSource::of(file));
  EXPECT_TRUE(status.ok()) << status.what() << ' ' << status.field();
  return Terrain::config_for(reader.info(), reader.info().level, detail_pages);
}

}  // namespace

DrawnWorld::DrawnWorld(std::span<const std::byte> file, const Gl& gl, DrawnSettings settings,
                       std::uint32_t detail_pages)
    : memory_(Terrain::budget(config_of(file, detail_pages)).cpu_bytes()) {
  const Config config = config_of(file, detail_pages);
  EXPECT_TRUE(terrain_.create(config, memory_.bytes()).ok());
  const Status loaded = terrain_.load(file);
  EXPECT_TRUE(loaded.ok()) << loaded.what() << ' ' << loaded.field();
  settings.vertex_pages = config.gpu_vertex_pages;
  settings.morph_rows = config.max_resident_patches;
  if (settings.stream_indices == 0) settings.stream_indices = config.stream_indices;
  settings.extent = terrain_.info().extent;
  if (settings.loader.load == nullptr) settings.loader = GlContext::get().loader();
  const Status made = target_.create(settings.loader, settings.picture);
  EXPECT_TRUE(made.ok()) << made.what() << ' ' << made.field();
  const Status created = renderer_.create(gl, settings);
  EXPECT_TRUE(created.ok()) << created.what() << ' ' << created.field() << ' ' << renderer_.message();
  if (!created.ok()) return;
  renderer_.upload_sky_line(terrain_.octree());
  upload_first(detail_pages == kMostPages);
  lod.max_level = level();
  lod.resident_level = level();
  lod.mode = LodMode::distance;
  lod.distance_voxels = 30;
}

void DrawnWorld::upload_first(bool all) {
  Camera camera;
  EXPECT_TRUE(make_camera(CameraSettings(), camera).ok());
  TerrainView view;
  view.camera = &camera;
  view.lod.mode = LodMode::full;
  view.lod.max_level = view.lod.resident_level = all ? level() : std::min(level(), 2);
  view.frustum_culling = view.backface_culling = view.occlusion_culling = false;
  terrain_.begin_frame();
  EXPECT_TRUE(terrain_.select(view, selection).ok());
  for (bool made = true; made;) EXPECT_TRUE(upload_next(made).ok());
  EXPECT_EQ(terrain_.pool().resident(), terrain_.patch_count());
}

Status DrawnWorld::upload_next(bool& made) {
  PatchUpload upload;
  Status status;
  made = terrain_.generate_next(false, upload, status);
  if (!made) return status;
  return renderer_.upload_vertices(terrain_.pages(), upload.patch,
                                   static_cast<std::uint32_t>(upload.first_vertex), upload.vertices,
                                   upload.origin, upload.row);
}

Status DrawnWorld::prepare(const CameraSettings& settings, ViewInput& input) {
  if (const Status status = make_camera(settings, input.camera); !status.ok()) return status;
  TerrainView view;
  view.camera = &input.camera;
  view.lod = lod;
  view.width_px = target_.settings().width;
  view.height_px = target_.settings().height;
  terrain_.begin_frame();
  if (const Status status = terrain_.select(view, selection); !status.ok()) return status;
  const MorphRows rows = terrain_.take_morph_rows();
  if (!rows.halves.empty()) {
    if (const Status status = renderer_.upload_morph_rows(rows.first_row, rows.halves); !status.ok())
      return status;
  }
  input.light = light;
  input.least_cos2 = terrain_.error_scale().least_cos2;
  input.items = terrain_.items();
  input.pages = terrain_.pages();
  input.index_table = terrain_.index_table();
  input.max_level = level();
  return {};
}

Status DrawnWorld::draw(const ViewInput& input, FrameCounts* counts) {
  const bool drape = renderer_.settings().drape_width > 0;
  if (drape) {
    const glm::vec3 sky = encode_picture(horizon_light(input.light));
    target_.begin({sky.r, sky.g, sky.b});
  } else {
    target_.begin();
  }
  const Status status = renderer_.draw(input, {.viewport = target_.viewport(), .sky = !drape});
  target_.end();
  const FrameCounts drawn = renderer_.end_frame();
  if (counts != nullptr) *counts = drawn;
  return status;
}

Status DrawnWorld::draw(const CameraSettings& settings, FrameCounts* counts) {
  ViewInput input;
  if (const Status status = prepare(settings, input); !status.ok()) return status;
  Status status = draw(input, counts);
  bool made = true;
  for (int i = 0; i < patches_a_frame && made && status.ok(); ++i) status = upload_next(made);
  return status;
}

Picture DrawnWorld::picture() {
  const app::PictureSettings& s = target_.settings();
  Picture picture(static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.height) * 4);
  EXPECT_TRUE(target_.read_colour(picture).ok());
  return picture;
}

TestWorld hills_with_cave(int level) {
  TestWorld world({22, 16, 20}, [](glm::ivec3 v) {
    const glm::dvec3 p = glm::dvec3(v) + 0.5;
    const double hills = 10 + 3 * value_noise(3, glm::dvec3(v.x, 0, v.z) / 6.0);
    const glm::dvec3 cave = (p - glm::dvec3(11, 4.5, 10)) / glm::dvec3(7, 2.6, 4);
    return p.y < hills && cave.x * cave.x + cave.y * cave.y + cave.z * cave.z > 1;
  });
  world.roughen(level, 9, 900);
  return world;
}

TestWorld level_ground(int height_voxels, int level) {
  TestWorld world({24, 16, 24}, [height_voxels](glm::ivec3 v) { return v.y < height_voxels; });
  world.roughen(level, 1, 0);
  return world;
}

}  // namespace karst::test
