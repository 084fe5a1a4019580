// SPDX-License-Identifier: MIT
// A world that benchmarks draw: one call a frame, with what the frame cost.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/options/scene_options.h"
#include "bench/measure/standard_path.h"
#include "scene/frame_statistics.h"
#include "scene/scene.h"

namespace karst::bench {
using namespace core;
using namespace app;

struct BenchFrame {
  FrameRecord record;
  double main_cpu_ms = 0;               // of this thread, the driver's share included
  double all_cpu_ms = 0;                // of all threads
  std::uint64_t working_set_bytes = 0;  // GPU: vertices of what is drawn at its level, indices, targets
};

class BenchView {
 public:
  // Empty on success, else one line for the user. One of the two, to be called once. load() alone leaves it
  // to the caller to attach the scene to a display.
  // look: light, skips and field of view of all pictures.
  [[nodiscard]] std::string open(const SceneOptions& options, const SceneArguments& look);
  [[nodiscard]] std::string load(const SceneOptions& options, const SceneArguments& look);

  // Draws one picture and waits for it.
  // generate_ms: SceneView's. The rest of the view is look()'s.
  [[nodiscard]] std::string draw(const Camera& camera, const LodSettings& lod, BenchFrame& frame,
                                 double generate_ms = SceneView::kComplete);
  // The same with any other switch of the view.
  [[nodiscard]] std::string draw(SceneView view, BenchFrame& frame);
  // The last picture: colour of 4 bytes a pixel, and depth. Once a picture.
  [[nodiscard]] std::string read(std::vector<std::uint8_t>& rgba, std::vector<float>& depth);

  Scene& scene() { return scene_; }
  // A view as the options have it; its camera is left open.
  const SceneView& look() const { return look_; }
  double fov_y_deg() const { return fov_y_deg_; }
  GroundHeights ground();
  // Cameras of a flight over this world, near and far fitted to its box.
  [[nodiscard]] std::string place(std::span<const CameraSettings> path, std::vector<Camera>& cameras);

  // Milliseconds from the start of the process to the end of the first frame; 0 before it. The kernel tells
  // the start in steps of 10 ms.
  double first_frame_ms() const { return first_frame_ms_; }

 private:
  void set_look(const SceneArguments& look);

  Scene scene_;
  SceneView look_;
  double fov_y_deg_ = 60;
  double first_frame_ms_ = 0;
};

// Bytes of this process in memory, now and at most so far.
std::uint64_t resident_bytes();
std::uint64_t peak_resident_bytes();

}  // namespace karst::bench
