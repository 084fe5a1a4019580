// SPDX-License-Identifier: MIT
// One headless context for all tests of the process, and small worlds drawn in it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/common/picture_target.h"
#include "platform/display.h"
#include "renderer/renderer.h"
#include "terrain/world/terrain_parts.h"
#include "tests/support/test_world.h"

namespace karst::test {
using namespace core;

class GlContext {
 public:
  // Made on first use, with a debug context. Failing to make it fails the calling test.
  static GlContext& get();

  const Gl& gl() const { return gl_; }
  GlLoader loader();
  Display& display() { return *display_; }
  bool ok() const { return display_ != nullptr; }
  // A GL function that karst itself does not use.
  template <class Function>
  Function function(const char* name) {
    return reinterpret_cast<Function>(display_->gl_function(name));
  }

 private:
  GlContext();

  std::unique_ptr<Display> display_;
  Gl gl_;
};

using Picture = std::vector<std::uint8_t>;  // rgba, row 0 at the top

// A page table whose patches take pages one after the other, or in any order that a test wants.
class TestPages {
 public:
  TestPages(std::size_t patches, std::uint32_t pages)
      : first_(patches, kNoPage), next_(pages, kNoPage), texels_(pages) {}

  PageTable table() { return {first_, next_, texels_}; }
  // Makes these pages the patch's chain.
  void set(PatchId patch, std::span<const std::uint32_t> chain);
  // A chain of consecutive pages.
  void set(PatchId patch, std::uint32_t first, std::uint32_t count);

 private:
  std::vector<std::uint32_t> first_, next_;
  std::vector<PageTexel> texels_;
};

// A renderer and the target that it draws into.
struct DrawnSettings : RendererSettings {
  app::PictureSettings picture;
  GlLoader loader;  // of the target; empty: GlContext's
  std::uint32_t max_views = 1;
};

// A world, ready to draw: with room for all of it, all patches uploaded at the full level; else
// at the base level, and more when frames ask for it.
class DrawnWorld {
 public:
  // settings: vertex_pages, morph_rows, stream_indices (0: as many as the config says) and extent
  // are filled in.
  // detail_pages: World::config_for.
  DrawnWorld(const TestWorld& world, const Gl& gl, DrawnSettings settings,
             std::uint32_t detail_pages = kMostPages)
      : DrawnWorld(std::span<const std::byte>(world.file()), gl, settings, detail_pages) {}
  DrawnWorld(std::span<const std::byte> file, const Gl& gl, DrawnSettings settings,
             std::uint32_t detail_pages = kMostPages);

  // Chooses levels for the camera and makes a frame of them that waits to be drawn; its thresholds are on the
  // GPU then.
  Status prepare(const CameraSettings& camera, ViewInput& input);
  // The same for several views of a frame, all chosen together; as many of each.
  Status prepare(std::span<const Camera> cameras, std::span<ViewInput> inputs);
  // Draws it into the target.
  Status draw(const ViewInput& input, FrameCounts* counts = nullptr);
  Status prepare(const Camera& camera, ViewInput& input);
  // Both, and draws it.
  Status draw(const CameraSettings& camera, FrameCounts* counts = nullptr);
  Status draw(const Camera& camera, FrameCounts* counts = nullptr);
  Picture picture();

  World& world() { return parts_.world; }
  Residency& residency() { return parts_.residency; }
  ShadowCasters& casters() { return parts_.casters; }
  ViewState& view() { return parts_.views[0]; }
  core::Renderer& renderer() { return renderer_; }
  app::PictureTarget& target() { return target_; }
  PageTable pages() { return parts_.residency.pages(); }
  int level() const { return parts_.world.info().level; }
  ViewState::Selection selection;  // of the last frame
  Governor::State pool;
  // Of the last frame; changes made here hold for the next.
  FrameLight light;
  LodSettings lod;
  // Vertices that draw() makes after a frame, for the next.
  int patches_a_frame = 0;

 private:
  Status select(std::span<const ViewRequest> requests);
  void upload_first(bool all);
  Status upload_next(bool& made);

  AlignedBytes memory_;
  TerrainParts parts_;
  app::PictureTarget target_;
  core::Renderer renderer_;
};

// Hills with a cave: all kinds of patches, about 20 voxels across.
TestWorld hills_with_cave(int level);
// Filled below a height, level ground: the surface is the plane y = height.
TestWorld level_ground(int height_voxels, int level);

}  // namespace karst::test
