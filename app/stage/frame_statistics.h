// SPDX-License-Identifier: MIT
// What frames cost and drew, summarised as one JSON object (docs/formats.md, "Statistics").
#pragma once

#include <string>
#include <vector>

#include "app/stage/stage.h"

namespace karst::app {

// NaN for no values. Reorders values.
double median(std::vector<double>& values);
double percentile(std::vector<double>& values, double part);

// frames: at least one. lookups: of textures, by a pixel (Stage::count_lookups).
std::string statistics_json(const Stage& stage, const std::vector<FrameRecord>& frames, double lookups);

}  // namespace karst::app
