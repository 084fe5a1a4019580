// SPDX-License-Identifier: MIT
// Shadows that are drawn, against rays cast on the CPU through the triangles of the full level.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "tests/gl/gl_fixture.h"

namespace karst::test {

// Gl whose terrain shaders show, in place of the picture, how much of the sun reaches the surface (red) and
// how much it faces the sun (green); blue is the sky.
Gl showing_shadows();

// A world's triangles at its full level, voxels.
class Triangles {
 public:
  explicit Triangles(DrawnWorld& drawn);

  // Distance along a ray (unit length) to the first triangle that is further than `beyond`; negative where
  // there is none.
  double first_hit(glm::dvec3 from, glm::dvec3 direction, double beyond) const;
  // Whether there is one.
  bool hit(glm::dvec3 from, glm::dvec3 direction, double beyond) const;

 private:
  struct Box {
    glm::dvec3 low{1e9}, high{-1e9};
  };
  // Triangles that follow each other in a patch.
  struct Chunk {
    Box box;
    std::uint32_t first_vertex = 0;  // of the patch
    std::uint32_t first_index = 0;
    std::uint32_t indices = 0;
  };
  struct Ray;

  void visit(const Ray& ray, int row, std::uint32_t n, double& nearest, bool any) const;
  static bool reaches(const Ray& ray, const Box& box, double nearest);

  const BoundsTree* tree_;
  std::vector<std::uint16_t> table_;
  std::vector<glm::vec3> vertices_;  // exact in float
  std::vector<Chunk> chunks_;
  std::uint32_t chunks_a_patch_ = 0;
};

// A world drawn with shadow maps at its full level, all of it resident.
class ShadowedWorld {
 public:
  ShadowedWorld(const TestWorld& world, const Gl& gl, test::DrawnSettings settings);
  ShadowedWorld(std::span<const std::byte> file, const Gl& gl, test::DrawnSettings settings);

  void draw(const CameraSettings& settings, FrameCounts* counts = nullptr);

  DrawnWorld drawn;
  FitCascades fit;
  LightSpace light;
  Cascade cascades[kMostCascades];
  double error_texels = 1;                   // of casters
  std::uint64_t hashes[kMostCascades] = {};  // ShadowCasters::Result
  std::uint64_t caster_triangles = 0;        // of the last frame
};

// The points of the surface behind the pixels, voxels; 1e9 where there is none. Row 0 is the top.
std::vector<glm::dvec3> points_behind(app::PictureTarget& target, const CameraSettings& settings);

struct Tally {
  int judged = 0;  // pixels that face the sun, away from shadows' borders
  int shaded = 0;  // of these, what rays say
  int wrong = 0;   // shaded or lit by more than half where rays say the other
  int acne = 0;    // darker by a tenth or more where rays reach the sun
};

// Adds every `stride`th pixel of a picture. border_texels: a pixel is judged where rays beside it, so far
// away to each side and corner in the map, say the same as its own.
void judge(ShadowedWorld& world, const Triangles& triangles, const CameraSettings& camera,
           double border_texels, std::size_t stride, Tally& tally);

}  // namespace karst::test
