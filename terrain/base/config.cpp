// SPDX-License-Identifier: MIT
// Checks of a Config: first every field against its own range, then the two limits that depend on another
// one.
#include "terrain/base/config.h"

#include <algorithm>

namespace karst::core {
namespace {

constexpr bool defaults_match_table() {
  const Config config;
  for (const ConfigField& field : kConfigFields) {
    const std::uint32_t value = config.*field.member;
    if (value != field.default_value || value < field.min || value > field.max) return false;
  }
  return true;
}
static_assert(defaults_match_table(), "Config's initialisers and kConfigFields must state the same defaults");
static_assert(sizeof(Config) == kConfigFields.size() * sizeof(std::uint32_t),
              "a field is missing in the table");

}  // namespace

Status Config::validate() const {
  for (const ConfigField& field : kConfigFields) {
    const std::uint32_t value = this->*field.member;
    if (value < field.min || value > field.max) {
      return {StatusCode::invalid_argument, "config limit is outside its range", field.name, value};
    }
  }
  // A patch in view must find room at level 1 whatever else is drawn: the frame may get coarse, never holey.
  if (gpu_vertex_pages < max_draw_items) {
    return {StatusCode::invalid_argument, "config limit is less than one page for each of max_draw_items",
            "gpu_vertex_pages", gpu_vertex_pages};
  }
  if (max_resident_patches < max_draw_items) {
    return {StatusCode::invalid_argument, "config limit is less than max_draw_items", "max_resident_patches",
            max_resident_patches};
  }
  // Nor may one view make holes in another one.
  const std::uint64_t seen = std::min<std::uint64_t>(std::uint64_t{max_views} * max_draw_items, max_patches);
  if (max_views > 1 && gpu_vertex_pages < seen) {
    return {StatusCode::invalid_argument, "config limit is less than one page for each patch that views see",
            "gpu_vertex_pages", gpu_vertex_pages};
  }
  if (max_views > 1 && max_resident_patches < seen) {
    return {StatusCode::invalid_argument, "config limit is less than the patches that views see",
            "max_resident_patches", max_resident_patches};
  }
  if (stream_indices / kLeastIndicesPerPatch < max_draw_items) {
    return {StatusCode::invalid_argument, "config limit is less than 24 indices for each of max_draw_items",
            "stream_indices", stream_indices};
  }
  return {};
}

}  // namespace karst::core
