// SPDX-License-Identifier: MIT
// A world ready to be drawn by a program: its file open, its memory taken once, karst's renderer and a
// picture in a display's context; and the one way in which programs draw a frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>

#include "app/common/picture_target.h"
#include "app/files/file_source.h"
#include "app/files/png_file.h"
#include "app/options/scene_options.h"
#include "app/stage/camera_view.h"
#include "karst/inspect.h"
#include "karst/karst.h"
#include "platform/base/error.h"
#include "platform/display.h"

namespace karst::app {

// Patches that a query of a program keeps ready: it asks below one camera.
inline constexpr std::uint32_t kGroundPatches = 32;

// Milliseconds of the steps that come before the first frame is drawn.
struct LoadTimes {
  double read = 0;      // the file, up to patches and heights in memory
  double context = 0;   // display, shaders, GL objects
  double generate = 0;  // vertices of the first frame
  double upload = 0;
};

// What programs draw in a frame: one view, or several side by side.
struct StageView {
  ViewState view;
  // Several, where not empty, of at most StageNeeds::views: `view` is not looked at, and each is drawn into
  // its part of the picture.
  std::span<const ViewState> views{};
  std::span<const Rect> parts{};
  Sun sun;
  Inspection inspection;
  double work_ms = 0;  // FrameInput: 0: the frame is complete
  bool wait = true;    // until the GPU is done, so that frame_ms holds its work
  // Called when the terrain of a view is drawn, with its framebuffer bound, to draw over it; may be null.
  // two_ranges: as karst::Target had it.
  void (*draw_over)(void* user, const ViewState& view, bool two_ranges) = nullptr;
  void* user = nullptr;
};

struct FrameRecord {
  double frame_ms = 0;  // all of it; the GPU's work too where the view waits
  FrameResult result;
  FrameCosts costs;
  std::uint64_t heap_calls = 0;  // of karst's own work, without the driver's
  std::uint64_t gl_objects = 0;  // made since the stage was ready
};

// What a program does with a world beside drawing one view of it.
struct StageNeeds {
  std::uint32_t views = 1;
  std::uint32_t queries = 0;  // Query objects that it takes
  std::uint32_t query_patches = kGroundPatches;
  std::uint64_t query_bytes = 0;  // more patches, as many as find room in so much, about
  std::uint32_t query_tiles = 30;
  std::uint64_t edit_bytes = 0;     // of memory for edits, about; 0: nothing is edited
  std::uint64_t overlay_bytes = 0;  // of GPU memory that it takes to draw over the picture
};

class Stage {
 public:
  Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  ~Stage();

  // Opens the world and takes its memory; needs no context. To be called once.
  Error load(const std::string& world, const SceneArguments& scene, const StageNeeds& needs = {});
  // Makes the GL objects in the display's context, which is current, for pictures of this size. To be called
  // again after detach(): vertices are made anew. The display must outlive the attachment.
  Error attach(Display& display, int width, int height);
  // lost: the context is gone, and nothing is called in it.
  void detach(bool lost = false);
  bool attached() const { return renderer_ != nullptr; }

  // What the device draws best with: PictureShape::reversed_depth. Where it has clip control.
  bool reversed_depth() const { return device_info(*renderer_).clip_control; }
  // Draws one frame into target() and notes what it cost. The first one after attach() is complete whatever
  // work_ms says.
  Error draw(const StageView& view, FrameRecord& record);

  // Texture lookups that a pixel of terrain takes in the view, in the mean; draws it for that. 0 under a
  // drape.
  Error count_lookups(StageView view, double& a_pixel);

  World& world() const { return *world_; }
  Renderer& renderer() const { return *renderer_; }
  PictureTarget& target() { return target_; }
  int width() const { return width_; }
  int height() const { return height_; }
  bool has_drape() const { return !scene_.drape.empty(); }
  bool keep_depth = false;  // for target().read_depth(); before attach()

  // Of karst and of the picture together.
  std::uint64_t cpu_bytes() const { return plan_.cpu_bytes + drape_.rgba.size(); }
  std::uint64_t gpu_bytes() const { return plan_.gpu_bytes + target_bytes(); }
  // Of the GL objects that are there.
  std::uint64_t gpu_used() const;
  const Plan& plan() const { return plan_; }
  const LoadTimes& load_times() const { return times_; }

 private:
  Error load_drape();
  Error make_plan_for(const Head& head);
  Error check_memory() const;
  std::uint64_t target_bytes() const;
  bool may_share_depth() const;

  struct Free {
    void operator()(std::byte* p) const { std::free(p); }
  };

  std::string path_;
  SceneArguments scene_;
  std::uint64_t edit_bytes_ = 0, overlay_bytes_ = 0;
  FileSource file_;  // before world_, which may read from it at any time
  Source source_;
  PngPicture drape_;
  Plan plan_;
  std::unique_ptr<std::byte, Free> memory_;
  World* world_ = nullptr;
  Renderer* renderer_ = nullptr;
  PictureTarget target_;
  std::string driver_words_;  // of the last attach()
  int width_ = 0;
  int height_ = 0;
  bool first_frame_ = true;
  std::uint64_t gl_objects_at_start_ = 0;
  LoadTimes times_;
};

}  // namespace karst::app
