// SPDX-License-Identifier: MIT
// What a frame may skip, and the switches of it.
#pragma once

#include "app/options/scene_options.h"
#include "scene/scene.h"

namespace karst::app {
using namespace core;

struct Skip {
  const char* name;
  bool& (*in)(SceneView& view);
};
// In the order of SkipChoice.
inline constexpr Skip kSkips[kSkipCount] = {
    {kSkipNames[0], [](SceneView& v) -> bool& { return v.frustum_culling; }},
    {kSkipNames[1], [](SceneView& v) -> bool& { return v.backface_culling; }},
    {kSkipNames[2], [](SceneView& v) -> bool& { return v.occlusion_culling; }},
    {kSkipNames[3], [](SceneView& v) -> bool& { return v.cascade_caching; }},
    {kSkipNames[4], [](SceneView& v) -> bool& { return v.pixel_skips.triplanar; }},
    {kSkipNames[5], [](SceneView& v) -> bool& { return v.pixel_skips.blend; }},
    {kSkipNames[6], [](SceneView& v) -> bool& { return v.pixel_skips.sun; }},
    {kSkipNames[7], [](SceneView& v) -> bool& { return v.shading_skips.material; }},
    {kSkipNames[8], [](SceneView& v) -> bool& { return v.pixel_skips.detail; }},
    {kSkipNames[9], [](SceneView& v) -> bool& { return v.shading_skips.cave; }},
};

}  // namespace karst::app
