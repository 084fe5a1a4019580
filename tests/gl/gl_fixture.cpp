// SPDX-License-Identifier: MIT
#include "tests/gl/gl_fixture.h"

#include "platform/headless_display.h"

namespace karst::test {

GlContext& GlContext::get() {
  static std::unique_ptr<GlContext> context;
  // A test that closes a display of its own terminates EGL's only headless display.
  if (context == nullptr || !context->ok() || !context->display_->make_current().empty()) {
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
  GlLoader loader;
  loader.context = display_.get();
  loader.load = [](const void* display, const char* name) {
    return static_cast<const Display*>(display)->gl_function(name);
  };
  const Status status = load_gl(loader, gl_);
  EXPECT_TRUE(status.ok()) << status.what() << ' ' << status.field();
}

DrawnWorld::DrawnWorld(const TestWorld& world, const Gl& gl, RendererSettings settings)
    : memory_(Terrain::budget(Terrain::config_for(world.info(), world.info().level)).cpu_bytes()) {
  const Config config = Terrain::config_for(world.info(), world.info().level);
  EXPECT_TRUE(terrain_.create(config, memory_.bytes()).ok());
  const Status loaded = terrain_.load(world.file());
  EXPECT_TRUE(loaded.ok()) << loaded.what() << ' ' << loaded.field();
  settings.vertex_pages = config.gpu_vertex_pages;
  if (settings.stream_indices == 0) settings.stream_indices = config.stream_indices;
  settings.extent = world.info().extent;
  const Status created = renderer_.create(gl, settings);
  EXPECT_TRUE(created.ok()) << created.what() << ' ' << created.field() << ' ' << renderer_.message();
  if (!created.ok()) return;
  renderer_.upload_sky_line(terrain_.octree());

  const Surface surface = terrain_.surface();
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(level())));
  const std::uint32_t slot = slot_pages(level());
  for (PatchId patch = 0; patch < terrain_.patch_count(); ++patch) {
    terrain_.generate(patch, level(), vertices);
    const Volume& v = surface.volume_of(patch);
    EXPECT_TRUE(renderer_.upload_patch(patch * slot, vertices, {v.corner[0], v.corner[1], v.corner[2]}).ok());
    first_vertex_.push_back(patch * slot * kPageVertices);
  }
  EXPECT_TRUE(terrain_.finish_bounds().ok());
  lod.mode = LodMode::distance;  // which needs no morph
  lod.max_level = level();
  lod.resident_level = level();
  lod.mode = LodMode::distance;
  lod.distance_voxels = 30;
}

Status DrawnWorld::draw(const CameraSettings& settings, FrameCounts* counts) {
  FrameInput input;
  if (const Status status = make_camera(settings, input.camera); !status.ok()) return status;
  TerrainView view;
  view.camera = &input.camera;
  view.lod = lod;
  Terrain::Selection selection;
  if (const Status status = terrain_.select(view, selection); !status.ok()) return status;
  input.light = light;
  input.items = terrain_.items();
  input.first_vertex = first_vertex_;
  input.index_table = terrain_.index_table();
  input.max_level = level();
  FrameCounts ignored;
  return renderer_.draw(input, counts != nullptr ? *counts : ignored);
}

Picture DrawnWorld::picture() {
  const RendererSettings& s = renderer_.settings();
  Picture picture(static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.height) * 4);
  EXPECT_TRUE(renderer_.read_colour(picture).ok());
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
