// SPDX-License-Identifier: MIT
// Names of what a frame may skip, for --no-skip and benchmarks.
#pragma once

#include <string>
#include <string_view>

#include "scene/scene.h"

namespace karst::app {
using namespace core;

// A skip and the switch of it in a view.
struct Skip {
  const char* name;
  bool& (*in)(SceneView& view);
};
inline constexpr Skip kSkips[] = {
    {"frustum", [](SceneView& v) -> bool& { return v.frustum_culling; }},
    {"backface", [](SceneView& v) -> bool& { return v.backface_culling; }},
    {"occlusion", [](SceneView& v) -> bool& { return v.occlusion_culling; }},
    {"cascades", [](SceneView& v) -> bool& { return v.cascade_caching; }},
    {"triplanar", [](SceneView& v) -> bool& { return v.pixel_skips.triplanar; }},
    {"blend", [](SceneView& v) -> bool& { return v.pixel_skips.blend; }},
    {"sun", [](SceneView& v) -> bool& { return v.pixel_skips.sun; }},
    {"material", [](SceneView& v) -> bool& { return v.shading_skips.material; }},
    {"detail", [](SceneView& v) -> bool& { return v.pixel_skips.detail; }},
    {"cave", [](SceneView& v) -> bool& { return v.shading_skips.cave; }},
};

// Switches off the skips of a list like "frustum,detail", or "all". An empty string on success, else what is
// wrong with the list.
[[nodiscard]] std::string switch_off_skips(std::string_view list, SceneView& view);

}  // namespace karst::app
