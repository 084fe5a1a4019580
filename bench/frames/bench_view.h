// SPDX-License-Identifier: MIT
// A world that benchmarks draw: one call a frame, with what the frame cost.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/stage/camera_view.h"
#include "app/stage/frame_statistics.h"
#include "app/stage/stage_view.h"
#include "bench/measure/standard_path.h"
#include "platform/display.h"
#include "scene/world/world_object.h"

namespace karst::bench {
using namespace app;
using core::PlacementFrame;

struct BenchFrame {
  FrameRecord record;
  double main_cpu_ms = 0;               // of this thread, the driver's share included
  double all_cpu_ms = 0;                // of all threads
  std::uint64_t working_set_bytes = 0;  // GPU: vertices of what is drawn at its level, indices, targets
};

// How levels of detail are chosen.
struct LevelChoice {
  LodMode mode = LodMode::error;
  double error_px = 4;
  double distance_voxels = 64;
};

class BenchView {
 public:
  // One of the two, to be called once. load() alone leaves it
  // to the caller to attach the stage to a display.
  // look: of all pictures, their size and what they may take included.
  Error open(const std::string& world, const SceneArguments& look, bool keep_depth = false);
  // time_gl: gl_times() tells what the functions of GL take (bench/measure/gl_times.h).
  Error open_timed(const std::string& world, const SceneArguments& look, bool time_gl);
  Error load(const std::string& world, const SceneArguments& look);

  // Draws one picture and waits for it. work_ms: FrameInput's. The rest of the view is look()'s.
  Error draw(const ViewState& camera, const LevelChoice& levels, BenchFrame& frame, double work_ms = 0);
  // The same with any other switch of the view.
  Error draw(const StageView& view, BenchFrame& frame);
  // The last picture: colour of 4 bytes a pixel, and depth. Once a picture.
  Error read(std::vector<std::uint8_t>& rgba, std::vector<float>& depth);

  Stage& stage() { return stage_; }
  // Inside the public world: what the core has.
  const core::World& terrain() const;
  const PlacementFrame& placement() const;
  // A view as the options have it; its camera is left open.
  const StageView& look() const { return look_; }
  LevelChoice levels() const;
  // Found out once, by asking it.
  const GroundHeights& ground();
  // A flight over this world as path files have it: of kStandardPaths, or "default", the place from which
  // programs show the whole world, in every frame.
  std::vector<CameraPlace> flight(std::string_view name, int frames);
  // Cameras of a flight over this world, near and far fitted to its box.
  Error place(std::span<const CameraSettings> path, std::vector<ViewState>& cameras);
  Error place(const CameraPlace& place, ViewState& camera);

  // Milliseconds from the start of the process to the end of the first frame; 0 before it. The kernel tells
  // the start in steps of 10 ms.
  double first_frame_ms() const { return first_frame_ms_; }

 private:
  CameraPlace place_of(const CameraSettings& settings) const;

  std::unique_ptr<Display> display_;  // of open(); before stage_, whose objects are in its context
  std::unique_ptr<Display> timed_;    // stands for it
  Stage stage_;
  StageView look_;
  PictureShape shape_;
  std::optional<GroundHeights> ground_;
  double first_frame_ms_ = 0;
};

// Bytes of this process in memory, now and at most so far.
std::uint64_t resident_bytes();
std::uint64_t peak_resident_bytes();

}  // namespace karst::bench
