// SPDX-License-Identifier: MIT
// What the editor's hand holds: tool, shape, size and where it is put. Keys change it; it makes edits of it.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "karst/edit.h"

namespace karst::app {

enum class Tool : std::uint8_t { dig, fill, raise, lower, smooth, noise, flatten, level, paint };
inline constexpr int kTools = 9;
enum class HandShape : std::uint8_t { sphere, box, cylinder, voxel };
inline constexpr int kHandShapes = 4;

// Where the brush goes while its stroke lasts (L A.2's drawing planes, and the surface as it is now, into
// which a tool that is held goes on).
enum class DrawOn : std::uint8_t {
  surface,      // as it is now
  old_surface,  // as it was before the stroke
  level,        // the horizontal plane through the stroke's first place
  tangent,      // the plane of the surface there
  camera        // the plane there that faces the camera
};
inline constexpr int kDrawOns = 5;

constexpr bool of_voxels(Tool tool) {
  return tool == Tool::dig || tool == Tool::fill;
}

class Brush {
 public:
  // voxel_m: of the world; octree_depth: its finest level. has_voxels: tools of voxels come first, else those
  // of heights.
  Brush(double voxel_m, int octree_depth, bool has_voxels);

  Tool tool() const { return tool_; }
  HandShape shape() const { return shape_; }
  DrawOn draw_on() const { return draw_on_; }
  double radius_m() const { return radius_m_; }
  double strength() const { return strength_; }    // 0..1
  double offset() const { return offset_; }        // radii along the surface's or the plane's normal, -1..1
  double slope_deg() const { return slope_deg_; }  // that flatten's plane rises by, away from the eye
  int octree_level() const { return octree_level_; }
  int material() const { return material_; }  // one more than the last one: none

  // There is a field alone: its tools and shapes.
  void set_of_field() { of_field_ = true; }
  void set_materials(std::vector<std::string> names) { materials_ = std::move(names); }

  // steps: below 0 back.
  void next_tool(int steps);
  void next_shape(int steps);  // that the tool has
  void next_draw_on(int steps);
  void resize(int steps);  // by a fifth each
  void strengthen(int steps);
  void lift(int steps);
  void tilt(int steps);
  void refine(int steps);  // the octree's level
  void next_material(int steps);

  // place: the brush's middle. plane_up: of flatten. seed: of noise.
  Edit make_edit(const glm::dvec3& place, const glm::dvec3& plane_up, std::uint32_t seed) const;

  // "dig sphere 3 m, on the surface": what it does.
  std::string text() const;

 private:
  bool fits(HandShape shape) const;
  bool fits(Tool tool) const;

  double voxel_m_;
  int octree_depth_;
  bool of_field_ = false;
  Tool tool_;
  HandShape shape_ = HandShape::sphere;
  DrawOn draw_on_ = DrawOn::surface;
  double radius_m_;
  double strength_ = 0.5;
  double offset_ = 0;
  double slope_deg_ = 0;
  int octree_level_;
  int material_ = 0;
  std::vector<std::string> materials_;
};

}  // namespace karst::app
