// SPDX-License-Identifier: MIT
#include "app/options/scene_settings.h"

#include <algorithm>

#include "app/options/scene_ranges.h"
#include "app/options/skips.h"

namespace karst::app {

static_assert(kMostPicture == PictureSettings::kMaxPicture);
static_assert(kMostLevel == kMaxLevel);
static_assert(kLeastErrorTarget == kLeastErrorPx && kMostErrorTarget == kMostErrorPx);
static_assert(kMostReach == kCameraReach);
static_assert(kMostShadows == kMostCascades);
static_assert(kLeastShadow == kLeastCascadeSize && kMostShadow == kMostCascadeSize);
static_assert(kShadowSizeStep == kCascadeSizeStep);

SceneOptions scene_settings(const SceneArguments& arguments, const std::string& world) {
  SceneOptions scene;
  scene.world = world;
  scene.width = arguments.width;
  scene.height = arguments.height;
  scene.level = arguments.level;
  scene.vertex_bytes = arguments.vertex_bytes;
  scene.max_memory = arguments.max_memory;
  scene.max_cpu = arguments.max_cpu;
  scene.high_precision = arguments.high_precision;
  constexpr Show kShown[] = {Show::materials, Show::cascades, Show::levels};
  scene.show = kShown[static_cast<int>(arguments.show)];
  scene.shadows.count = arguments.shadows;
  scene.shadows.size = arguments.shadow_size;
  scene.shadows.reach_voxels = arguments.shadow_reach_voxels;
  scene.rgb565 = arguments.rgb565;
  scene.drape = arguments.drape;
  scene.drape_repeat = arguments.drape_repeat;
  return scene;
}

SceneView view_settings(const SceneArguments& arguments) {
  SceneView view;
  view.light.sun_azimuth_deg = arguments.sun_azimuth_deg;
  view.light.sun_elevation_deg = arguments.sun_elevation_deg;
  if (arguments.haze_voxels > 0) view.light.haze_voxels = arguments.haze_voxels;
  constexpr LodMode kModes[] = {LodMode::error, LodMode::distance, LodMode::full};
  view.lod.mode = kModes[static_cast<int>(arguments.lod)];
  view.lod.max_level = kMaxLevel;
  view.lod.error_px = arguments.error_px;
  view.lod.distance_voxels = arguments.lod_distance_voxels;
  for (int n = 0; n < kSkipCount; ++n) {
    if ((arguments.drawn_anyway >> n & 1) != 0) kSkips[n].in(view) = false;
  }
  if (arguments.generate_ms >= 0) view.generate_ms = arguments.generate_ms;
  return view;
}

void set_haze(const SceneArguments& arguments, const LatticeBox& box, FrameLight& light) {
  if (arguments.haze_voxels > 0) return;
  const glm::dvec3 size = glm::dvec3(box.max - box.min) / static_cast<double>(kStepsPerVoxel);
  light.haze_voxels = std::max(1.0, 6.0 * std::max(size.x, size.z));
}

}  // namespace karst::app
