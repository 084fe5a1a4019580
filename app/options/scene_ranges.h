// SPDX-License-Identifier: MIT
// Ranges of the options of a scene. scene_settings.cpp holds them to those of the core.
#pragma once

namespace karst::app {

inline constexpr int kMostPicture = 16384;  // pixels a side
inline constexpr int kMostLevel = 6;
inline constexpr double kLeastErrorTarget = 0.01;  // pixels
inline constexpr double kMostErrorTarget = 1000;
inline constexpr double kMostReach = 1 << 20;  // voxels
inline constexpr int kMostShadows = 3;
inline constexpr int kLeastShadow = 512;  // texels a side
inline constexpr int kMostShadow = 2048;
inline constexpr int kShadowSizeStep = 16;

}  // namespace karst::app
