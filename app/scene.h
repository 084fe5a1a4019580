// SPDX-License-Identifier: MIT
// A world ready to be drawn: its file read, its memory taken once, a context opened, and the vertices of all
// patches on the GPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "app/png_file.h"
#include "platform/display.h"
#include "renderer/renderer.h"
#include "terrain/world/terrain.h"

namespace karst::app {

struct SceneOptions {
  std::string world;
  int width = 1280;  // pixels
  int height = 720;
  int level = kMaxLevel;    // finest level held on the GPU; cut to the world's and to max_memory
  bool rgb565 = false;      // pictures of 16 bits a pixel
  std::string drape;        // PNG that is laid over the world from above; empty: none
  double drape_repeat = 1;  // times on each axis
  std::uint64_t max_memory = 512ull << 20;  // bytes, CPU and GPU together
};

// Milliseconds of the steps that come before the first frame.
struct LoadTimes {
  double read = 0;      // the file, up to patches and heights in memory
  double context = 0;   // display, shaders, GL objects
  double generate = 0;  // vertices of all patches
  double upload = 0;
};

// The limits and the bytes of a world drawn at a picture's size with all patches resident at a level.
struct WorldBudget {
  Config config;
  RendererSettings renderer;
  Budget budget;
};
WorldBudget budget_of(const WorldInfo& info, int resident_level, int width, int height);

class Scene {
 public:
  // Functions return an empty string on success, else one line that names the file or the option at fault.

  // load() and attach() with a headless display of its own. To be called once.
  [[nodiscard]] std::string open(const SceneOptions& options);
  // Reads the world and takes its memory; needs no context. To be called once.
  [[nodiscard]] std::string load(const SceneOptions& options);
  // Makes the GL objects in the display's context, which is current, for pictures of this size, and uploads
  // all vertices. To be called again after detach() when the size changed or the context was lost: everything
  // comes from memory. The display must outlive the attachment.
  [[nodiscard]] std::string attach(Display& display, int width, int height);
  void detach() { renderer_.destroy(); }

  Terrain& terrain() { return terrain_; }
  Renderer& renderer() { return renderer_; }
  PageTable pages() { return {first_page_, next_page_, texels_}; }
  // To be called between selecting and drawing: gives the renderer the thresholds that the selection was made
  // with, where they have changed.
  [[nodiscard]] Status upload_thresholds();
  int resident_level() const { return resident_level_; }
  // The world is held coarser than asked for, because memory ends: statistics name gpu_vertex_pages.
  bool level_cut() const { return level_cut_; }
  WorldFrame frame() const;
  const Budget& budget() const { return budget_; }
  const LoadTimes& load_times() const { return times_; }

 private:
  std::string load_world(const SceneOptions& options);
  std::string check_memory(const std::string& world) const;
  std::string open_renderer(Display& display);
  std::string load_drape(const SceneOptions& options);
  WorldBudget needs_at(const WorldInfo& info, int resident_level, int width, int height) const;
  std::string upload_patches(const std::string& world);

  struct Free {
    void operator()(std::byte* p) const { std::free(p); }
  };

  SceneOptions options_;
  std::unique_ptr<std::byte, Free> memory_;
  Terrain terrain_;
  std::unique_ptr<Display> display_;  // of open(); before renderer_: whose destructor needs the context
  Renderer renderer_;
  PngPicture drape_;
  std::vector<std::uint32_t> first_page_;
  std::vector<std::uint32_t> next_page_;
  std::vector<PageTexel> texels_;
  std::vector<std::uint16_t> morph_rows_;
  std::uint32_t thresholds_version_ = 0;
  RendererSettings renderer_settings_;
  int resident_level_ = 1;
  bool level_cut_ = false;
  Budget budget_;
  LoadTimes times_;
};

}  // namespace karst::app
