// SPDX-License-Identifier: MIT
#include "tests/gl/gl_fixture.h"

#include <array>
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
  Error error;
  display_ = open_headless_display({.debug = true}, error);
  EXPECT_NE(display_, nullptr) << error.text();
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

Config config_of(std::span<const std::byte> file, std::uint32_t detail_pages, std::uint32_t max_views) {
  WorldReader reader;
  const Status status = reader.open(ByteSource::of(file));
  EXPECT_TRUE(status.ok()) << status.what() << ' ' << status.field();
  Config config = World::config_for(reader.info(), reader.info().level, detail_pages);
  config.max_views = max_views;
  return config;
}

}  // namespace

DrawnWorld::DrawnWorld(std::span<const std::byte> file, const Gl& gl, DrawnSettings settings,
                       std::uint32_t detail_pages)
    : memory_(terrain_budget(config_of(file, detail_pages, settings.max_views)).cpu_bytes()) {
  const Config config = config_of(file, detail_pages, settings.max_views);
  EXPECT_TRUE(parts_.create(config, memory_.bytes()).ok());
  const Status loaded = parts_.load(file);
  EXPECT_TRUE(loaded.ok()) << loaded.what() << ' ' << loaded.field();
  settings.vertex_pages = config.gpu_vertex_pages;
  settings.morph_rows = config.max_views * config.max_resident_patches;
  if (settings.stream_indices == 0) settings.stream_indices = config.stream_indices;
  settings.extent = world().info().extent;
  settings.sky = world().sky().grid();
  if (settings.loader.load == nullptr) settings.loader = GlContext::get().loader();
  const Status made = target_.create(settings.loader, settings.picture);
  EXPECT_TRUE(made.ok()) << made.what() << ' ' << made.field();
  const Status created = renderer_.create(gl, settings);
  EXPECT_TRUE(created.ok()) << created.what() << ' ' << created.field() << ' ' << renderer_.message();
  if (!created.ok()) return;
  EXPECT_TRUE(renderer_.upload_sky(world().sky()).ok());
  upload_first(detail_pages == kMostPages);
  lod.max_level = level();
  lod.resident_level = level();
  lod.mode = LodMode::distance;
  lod.distance_voxels = 30;
}

Status DrawnWorld::select(std::span<const ViewRequest> requests) {
  const Status status = residency().select(parts_.views_of(requests.size()), requests);
  selection = view().selection();
  pool = residency().governor();
  return status;
}

void DrawnWorld::upload_first(bool all) {
  Camera camera;
  EXPECT_TRUE(make_camera(CameraSettings(), camera).ok());
  ViewRequest request;
  request.camera = &camera;
  request.lod.mode = LodMode::full;
  request.lod.max_level = request.lod.resident_level = all ? level() : std::min(level(), 2);
  request.frustum_culling = request.backface_culling = request.occlusion_culling = false;
  residency().begin_frame();
  EXPECT_TRUE(select(std::span(&request, 1)).ok());
  for (bool made = true; made;) EXPECT_TRUE(upload_next(made).ok());
  EXPECT_EQ(residency().pool().resident(), world().patch_count());
}

Status DrawnWorld::upload_next(bool& made) {
  PatchUpload upload;
  Status status;
  made = residency().generate_next(false, upload, status);
  if (!made) return status;
  return renderer_.upload_vertices(residency().pages(), upload.patch,
                                   static_cast<std::uint32_t>(upload.first_vertex), upload.vertices,
                                   upload.origin, upload.row);
}

Status DrawnWorld::prepare(const CameraSettings& settings, ViewInput& input) {
  Camera camera;
  if (const Status status = make_camera(settings, camera); !status.ok()) return status;
  return prepare(camera, input);
}

Status DrawnWorld::prepare(const Camera& camera, ViewInput& input) {
  return prepare(std::span(&camera, 1), std::span(&input, 1));
}

Status DrawnWorld::prepare(std::span<const Camera> cameras, std::span<ViewInput> inputs) {
  std::array<ViewRequest, kMostViews> requests;
  for (std::size_t v = 0; v < cameras.size(); ++v) {
    requests[v].camera = &cameras[v];
    requests[v].lod = lod;
    requests[v].width_px = target_.settings().width;
    requests[v].height_px = target_.settings().height;
  }
  residency().begin_frame();
  if (const Status status = select(std::span(requests).first(cameras.size())); !status.ok()) return status;
  for (MorphRows rows = residency().take_morph_rows(); !rows.halves.empty();
       rows = residency().take_morph_rows()) {
    if (const Status status = renderer_.upload_morph_rows(rows.first_row, rows.halves); !status.ok())
      return status;
  }
  for (std::size_t v = 0; v < cameras.size(); ++v) {
    const ViewState& seen = parts_.views[v];
    ViewInput& input = inputs[v];
    input.camera = cameras[v];
    input.light = light;
    input.least_cos2 = seen.error_scale().least_cos2;
    input.first_morph_row = residency().first_morph_row(seen);
    input.items = seen.items();
    input.pages = residency().pages();
    input.index_table = world().index_table();
    input.max_level = level();
  }
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
  if (input.camera.reversed_depth) {
    const float farthest = 0;
    GlContext::get().gl().ClearBufferfv(GL_DEPTH, 0, &farthest);
  }
  const Status status = renderer_.draw(
      input, {.viewport = target_.viewport(), .framebuffer = target_.framebuffer(), .sky = !drape});
  target_.end();
  const FrameCounts drawn = renderer_.end_frame();
  if (counts != nullptr) *counts = drawn;
  return status;
}

Status DrawnWorld::draw(const CameraSettings& settings, FrameCounts* counts) {
  Camera camera;
  if (const Status status = make_camera(settings, camera); !status.ok()) return status;
  return draw(camera, counts);
}

Status DrawnWorld::draw(const Camera& camera, FrameCounts* counts) {
  ViewInput input;
  if (const Status status = prepare(camera, input); !status.ok()) return status;
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
