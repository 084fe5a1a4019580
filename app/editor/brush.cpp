// SPDX-License-Identifier: MIT
#include "app/editor/brush.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace karst::app {
namespace {

constexpr double kStep = 1.2;                             // of sizes
constexpr double kLeastVoxels = 0.25, kMostVoxels = 256;  // of the radius
constexpr double kMostCells = 128;                        // of a field's
constexpr double kFirstVoxels = 3;
constexpr double kStrengthStep = 0.1, kOffsetStep = 0.25;
constexpr double kSlopeStep_deg = 5, kMostSlope_deg = 60;
// Of a dab of full strength, in radii.
constexpr double kHeightOfADab = 0.2, kNoiseOfADab = 0.1, kWaves = 0.5;

constexpr const char* kToolNames[kTools] = {"dig",   "fill",    "raise", "lower", "smooth",
                                            "noise", "flatten", "level", "paint"};
constexpr EditTool kEditTools[kTools] = {EditTool::clear,   EditTool::fill,   EditTool::extrude,
                                         EditTool::extrude, EditTool::smooth, EditTool::noise,
                                         EditTool::flatten, EditTool::level,  EditTool::paint};
constexpr const char* kShapeNames[kHandShapes] = {"sphere", "box", "cylinder", "voxel"};
constexpr BrushShape kShapes[kHandShapes] = {BrushShape::sphere, BrushShape::box, BrushShape::cylinder,
                                             BrushShape::voxel};
constexpr const char* kDrawOnNames[kDrawOns] = {"on the surface", "on the old surface", "on a level plane",
                                                "on the tangent plane", "on the camera's plane"};

// steps around a circle of count.
int turn(int now, int steps, int count) {
  return ((now + steps) % count + count) % count;
}

}  // namespace

Brush::Brush(double voxel_m, int octree_depth, bool has_voxels)
    : voxel_m_(voxel_m),
      octree_depth_(octree_depth),
      tool_(has_voxels ? Tool::dig : Tool::raise),
      radius_m_(kFirstVoxels * voxel_m),
      octree_level_(octree_depth) {}

bool Brush::fits(Tool tool) const {
  return !of_field_ || (tool != Tool::raise && tool != Tool::lower && tool != Tool::noise);
}

bool Brush::fits(HandShape shape) const {
  if (of_field_) return shape == HandShape::sphere || shape == HandShape::box;
  if (shape == HandShape::voxel) return of_voxels(tool_);
  return shape != HandShape::cylinder || !of_voxels(tool_);
}

void Brush::next_tool(int steps) {
  for (int n = 0; n < std::abs(steps); ++n) {
    do {
      tool_ = static_cast<Tool>(turn(static_cast<int>(tool_), steps < 0 ? -1 : 1, kTools));
    } while (!fits(tool_));
  }
  if (!fits(shape_)) shape_ = HandShape::sphere;
}

void Brush::next_shape(int steps) {
  do {
    shape_ = static_cast<HandShape>(turn(static_cast<int>(shape_), steps, kHandShapes));
  } while (!fits(shape_));
}

void Brush::next_draw_on(int steps) {
  draw_on_ = static_cast<DrawOn>(turn(static_cast<int>(draw_on_), steps, kDrawOns));
}

void Brush::resize(int steps) {
  const double most = of_field_ ? kMostCells : kMostVoxels;
  radius_m_ = std::clamp(radius_m_ * std::pow(kStep, steps), kLeastVoxels * voxel_m_, most * voxel_m_);
}

void Brush::strengthen(int steps) {
  strength_ = std::clamp(std::round(strength_ / kStrengthStep + steps) * kStrengthStep, kStrengthStep, 1.0);
}

void Brush::lift(int steps) {
  offset_ = std::clamp(offset_ + steps * kOffsetStep, -1.0, 1.0);
}

void Brush::tilt(int steps) {
  slope_deg_ = std::clamp(slope_deg_ + steps * kSlopeStep_deg, -kMostSlope_deg, kMostSlope_deg);
}

void Brush::refine(int steps) {
  octree_level_ = std::clamp(octree_level_ + steps, 0, octree_depth_);
}

void Brush::next_material(int steps) {
  material_ = turn(material_, steps, static_cast<int>(materials_.size()) + 1);
}

Edit Brush::make_edit(const glm::dvec3& place, const glm::dvec3& plane_up, std::uint32_t seed) const {
  Edit edit;
  edit.tool = kEditTools[static_cast<int>(tool_)];
  edit.shape = kShapes[static_cast<int>(shape_)];
  edit.place = edit.to = {place.x, place.y, place.z};
  edit.radius_m = radius_m_;
  edit.half_m = {radius_m_, radius_m_, radius_m_};
  if (shape_ == HandShape::voxel) edit.octree_level = static_cast<std::uint8_t>(octree_level_);
  switch (tool_) {
    case Tool::dig:
    case Tool::fill:
      break;
    case Tool::raise:
    case Tool::lower:
      edit.strength_m = (tool_ == Tool::raise ? 1 : -1) * kHeightOfADab * strength_ * radius_m_;
      break;
    case Tool::noise:
      edit.strength_m = kNoiseOfADab * strength_ * radius_m_;
      edit.wave_m = kWaves * radius_m_;
      edit.seed = seed;
      break;
    case Tool::flatten:
      edit.up = {plane_up.x, plane_up.y, plane_up.z};
      edit.amount = strength_;
      break;
    case Tool::smooth:
    case Tool::level:
      edit.amount = strength_;
      break;
    case Tool::paint:
      edit.material = material_ < static_cast<int>(materials_.size()) ? static_cast<std::uint8_t>(material_)
                                                                      : kNoMaterial;
      edit.amount = strength_;
      break;
  }
  return edit;
}

std::string Brush::text() const {
  std::string text = kToolNames[static_cast<int>(tool_)];
  char room[96];
  if (shape_ == HandShape::voxel) {
    std::snprintf(room, sizeof room, " voxel of %.3g m (level %d of %d)",
                  std::ldexp(voxel_m_, octree_depth_ - octree_level_), octree_level_, octree_depth_);
  } else {
    std::snprintf(room, sizeof room, " %s %.3g m", kShapeNames[static_cast<int>(shape_)], radius_m_);
  }
  text += room;
  if (!of_voxels(tool_)) {
    std::snprintf(room, sizeof room, ", strength %.0f %%", strength_ * 100);
    text += room;
  }
  if (tool_ == Tool::paint) {
    const auto number = static_cast<std::size_t>(material_);
    text += number < materials_.size() ? ", " + materials_[number] : ", no paint";
  }
  if (tool_ == Tool::flatten && slope_deg_ != 0) {
    std::snprintf(room, sizeof room, ", slope %.0f deg", slope_deg_);
    text += room;
  }
  text += std::string(", ") + kDrawOnNames[static_cast<int>(draw_on_)];
  if (offset_ != 0) {
    std::snprintf(room, sizeof room, " %+.0f %%", offset_ * 100);
    text += room;
  }
  return text;
}

}  // namespace karst::app
