// SPDX-License-Identifier: MIT
// A world ready to be drawn: its file open, its memory taken once, the renderer in a display's context; and
// the one way in which every command draws a frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "app/common/file_source.h"
#include "app/common/picture_target.h"
#include "app/common/png_file.h"
#include "platform/display.h"
#include "renderer/renderer.h"
#include "scene/frame_statistics.h"
#include "terrain/world/terrain_parts.h"

namespace karst::app {
using namespace core;

struct SceneOptions {
  std::string world;
  int width = 1280;  // pixels
  int height = 720;
  int level = kMaxLevel;  // finest level that is drawn; cut to the world's
  // Of GPU vertex memory; cut to what all of the world takes. 0: what World::config_for() says.
  std::uint64_t vertex_bytes = 0;
  // Bytes, CPU and GPU together. Heights that find no room are read from the file when they are needed.
  std::uint64_t max_memory = 512ull << 20;
  std::uint64_t max_cpu = 0;  // bytes of the CPU's alone, 0: as much as max_memory leaves
  bool keep_depth = false;    // RendererSettings
  bool high_precision = false;
  Show show = Show::materials;
  CascadeSettings shadows;  // none with a drape
  bool rgb565 = false;
  std::string drape;        // PNG that is laid over the world from above; empty: none
  double drape_repeat = 1;  // times on each axis
};

// Milliseconds of the steps that come before the first frame is drawn.
struct LoadTimes {
  double read = 0;      // the file, up to patches and heights in memory
  double context = 0;   // display, shaders, GL objects
  double generate = 0;  // vertices of the first frame
  double upload = 0;
};

struct SceneView {
  // Time to make vertices in a frame that lacks some; such frames are drawn coarser. Without a limit a frame
  // is complete before it is drawn.
  static constexpr double kComplete = std::numeric_limits<double>::infinity();

  Camera camera;
  FrameLight light;
  LodSettings lod;
  bool frustum_culling = true;
  bool backface_culling = true;
  bool occlusion_culling = true;
  ShadingSkips shading_skips;
  PixelSkips pixel_skips;
  bool lamps = true;            // the world's point lights
  bool cascade_caching = true;  // false: every shadow map is drawn in every frame
  double generate_ms = kComplete;
  int quarter_turns = 0;          // FrameInput
  bool wait = true;               // until the GPU is done, so that frame_ms holds its work
  bool wait_for_shadows = false;  // before and after shadow maps, so that shadow_ms holds the GPU's work
};

// The limits and the bytes of a world drawn at a picture's size.
struct WorldBudget {
  Config config;
  RendererSettings renderer;
  PictureSettings picture;
  Budget budget;
  // Adds up anew.
  void add_up();
};
// finest: level that the pages are for, 1..info.level. vertex_bytes: as in SceneOptions.
WorldBudget budget_of(const WorldInfo& info, int finest, int width, int height,
                      std::uint64_t vertex_bytes = 0);
// Holds fewer heights where all is more than max_memory bytes; what is missing is read from the file when it
// is needed. Others have no choice: the budget may still be too large.
void fit_heights(WorldBudget& needs, std::uint64_t max_memory);

class Scene {
 public:
  // Functions return an empty string on success, else one line that names the file or the option at fault.

  // load() and attach() with a headless display of its own. To be called once.
  [[nodiscard]] std::string open(const SceneOptions& options);
  // Opens the world and takes its memory; needs no context. To be called once.
  [[nodiscard]] std::string load(const SceneOptions& options);
  // Makes the GL objects in the display's context, which is current, for pictures of this size. To be called
  // again after detach() when the size changed or the context was lost: vertices are made anew. The display
  // must outlive the attachment.
  [[nodiscard]] std::string attach(Display& display, int width, int height);
  // Where the context is gone and another one is current, what GL says to the old names means nothing.
  void detach() {
    renderer_.destroy();
    target_.take_error();
    target_.destroy();
  }

  // Draws one frame into the target and notes what it cost. The first one after attach() is
  // complete whatever generate_ms says.
  [[nodiscard]] std::string draw(const SceneView& view, FrameRecord& record);

  World& world() { return parts_.world; }
  const World& world() const { return parts_.world; }
  Residency& residency() { return parts_.residency; }
  const Residency& residency() const { return parts_.residency; }
  std::size_t cpu_used() const { return parts_.arena.used(); }
  core::Renderer& renderer() { return renderer_; }
  PictureTarget& target() { return target_; }
  WorldFrame frame() const;
  const Budget& budget() const { return budget_; }
  const LoadTimes& load_times() const { return times_; }

 private:
  ViewState& eye() { return parts_.views[0]; }
  const ViewState& eye() const { return parts_.views[0]; }
  std::string load_world();
  std::string check_memory() const;
  std::string open_renderer(Display& display);
  std::string load_drape();
  RendererSettings renderer_settings(const Config& config, const MaterialSet& materials) const;
  PictureSettings picture_settings() const;
  Status select(const ViewRequest& view, FrameRecord& record);
  Status generate(double until_ms, FrameRecord& record, bool& made);
  Status complete(const ViewRequest& view, FrameRecord& record);
  Status upload_patch(const PatchUpload& upload);
  Status generate_bases(FrameRecord& record);
  Status upload_morph_rows();
  Status draw_shadows(const SceneView& view, double until_ms, FrameRecord& record);
  struct ShadowMap;
  Status generate_casters(std::int64_t start, double until_ms, std::uint32_t& made);
  Status complete_casters(ShadowMap& map, const Cascade& cascade, double until_ms,
                          ShadowCasters::Result& casters, FrameRecord& record);
  bool is_current(const ShadowMap& map, const Cascade& cascade) const;
  Status draw_cascade(int index, double until_ms, bool caching, FrameRecord& record);
  std::string upload_materials();
  unsigned shading_needs(FrameRecord& record) const;
  Status draw_selected(const SceneView& view, FrameRecord& record);

  struct Free {
    void operator()(std::byte* p) const { std::free(p); }
  };

  SceneOptions options_;
  FileSource file_;  // before parts_, which may read from it at any time
  std::unique_ptr<std::byte, Free> memory_;
  TerrainParts parts_;
  std::unique_ptr<Display> display_;  // of open(); before renderer_: whose destructor needs the context
  PictureTarget target_;
  core::Renderer renderer_;
  PngPicture drape_;
  Budget budget_;
  LoadTimes times_;
  bool first_frame_ = true;
  std::uint64_t gl_objects_at_start_ = 0;

  // What a shadow map holds.
  struct ShadowMap {
    bool drawn = false;
    Cascade cascade;
    bool complete = false;         // nothing was lacking
    double error_texels = 0;       // SelectCasters
    std::uint64_t casters = 0;     // ShadowCasters::Result::hash
    std::uint32_t thresholds = 0;  // version that the casters were listed for
    ErrorScale scale;              // of those thresholds
  };
  ShadowMap shadow_maps_[kMostCascades];
  std::vector<DrawItem> shown_items_;  // the frame's, sorted by level, for Show::levels
  LightSpace light_space_;
  Cascade cascades_[kMostCascades];  // of this frame
  int cascade_count_ = 0;
  float error_scale_ = 1;  // Governor::State, of this frame
};

}  // namespace karst::app
