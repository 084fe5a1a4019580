// SPDX-License-Identifier: MIT
// What karst-bake says about a bake: for people, and as JSON (docs/formats.md, "bake report").
#pragma once

#include "bake/pipeline/bake.h"

#include <cstddef>
#include <string>

namespace karst::bake {

std::string report_text(const Bake& job, const Bake::Report& report, std::size_t bytes, double seconds);
std::string report_json(const Bake& job, const Bake::Report& report, std::size_t bytes, double seconds);

}  // namespace karst::bake
