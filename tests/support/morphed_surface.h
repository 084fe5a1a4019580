// SPDX-License-Identifier: MIT
// What the GPU draws of a world with morphing levels of detail, on the CPU: vertices moved in float as vertex
// shaders move them, and the surface between them in double.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "terrain/lod/morph.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/view/camera.h"
#include "tests/support/test_world.h"

namespace karst::test {
using namespace core;

// A point of the full grid on a coarser level's surface: the triangle that it lies in, and where.
struct SurfacePoint {
  std::uint16_t vertex[3];  // in slot order
  float weight[3];
};

// For every vertex of the full level in slot order, its point on a level's surface.
std::vector<SurfacePoint> points_on_level(int full_level, int level);

class MorphedSurface {
 public:
  // Makes all vertices of the world at its heights' level.
  explicit MorphedSurface(const TestWorld& world);

  int level() const { return level_; }
  std::size_t patches() const { return vertices_.size(); }
  const std::vector<GpuVertex>& vertices(PatchId patch) const { return vertices_[patch]; }
  std::span<const PatchBounds> bounds() const { return bounds_; }
  Surface surface() const { return world_.surface(); }
  Heights heights() const { return world_.heights(); }

  // Vertices of a patch at `drawn` level in slot order, relative to camera.voxel in lattice steps, as the
  // shader moves them.
  std::vector<glm::vec3> moved(PatchId patch, int drawn, const Camera& camera, const ErrorScale& scale,
                               std::span<const PatchLod> lods) const;

  // The patch's drawn surface at every vertex of the full level, and the full surface there, in slot order,
  // in the same space. lower_edges: as in DrawItem.
  void points(PatchId patch, int drawn, unsigned lower_edges, std::span<const glm::vec3> moved,
              std::vector<glm::dvec3>& out) const;
  void full_points(PatchId patch, const Camera& camera, std::vector<glm::dvec3>& out) const;

 private:
  TestWorld world_;
  int level_;
  std::vector<std::vector<GpuVertex>> vertices_;
  std::vector<PatchBounds> bounds_;
  std::vector<std::uint8_t> entries_;
  std::vector<std::vector<SurfacePoint>> on_level_;  // by level
};

// A camera's projection in double.
class Projection {
 public:
  Projection(const Camera& camera, glm::ivec2 size_px);

  // point: relative to camera.voxel, lattice steps.
  double depth(glm::dvec3 point) const;       // lattice steps, along the view's direction
  glm::dvec2 pixels(glm::dvec3 point) const;  // from the picture's centre
  bool inside(glm::dvec3 point) const;        // in the picture and not before the near plane

 private:
  glm::dvec4 clip(glm::dvec3 point) const;

  glm::dmat3 view_from_world_;
  glm::dmat4 clip_from_view_;
  glm::dvec3 forward_;
  glm::dvec3 eye_;
  glm::dvec2 half_px_;
  double nearest_ = 1;
};

}  // namespace karst::test
