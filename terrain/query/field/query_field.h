// SPDX-License-Identifier: MIT
// The field of an isosurface for queries: triangles of its finest level, as ExtractBlock makes them, cell by
// cell where a segment or a moving sphere may meet them. Nothing is kept between questions.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "terrain/base/lattice.h"
#include "terrain/isosurface/field_blocks.h"
#include "terrain/view/frustum.h"

namespace karst::core {

class QueryField {
 public:
  // Borrowed, constant while questions are asked; null: there is none. corner: voxels, of the part of a
  // ground that it is (World::field_corner()).
  void set_field(const FieldBlocks* field, glm::ivec3 corner) {
    field_ = field;
    corner_ = corner;
  }
  bool exists() const { return field_ != nullptr && field_->exists(); }

  // Of all its triangles, lattice steps.
  LatticeBox box() const { return {low(), low() + field_->info().drawn_steps()}; }

  // What walks through triangles.
  class Walk {
   public:
    // The share of the segment beyond which nothing is wanted any more; may fall.
    virtual double limit() const = 0;
    // number: no other triangle of the field has it. Corners in lattice steps, counter-clockwise as seen from
    // the air.
    virtual void visit(std::int64_t number, const glm::dvec3 (&corner)[3]) = 0;

   protected:
    ~Walk() = default;
  };

  // Triangles that a sphere of this radius may meet on its way from a place on, and others near them, roughly
  // from near to far; all in lattice steps. Precondition: exists().
  void run(const glm::dvec3& from, const glm::dvec3& way, double radius, Walk& walk) const;

 private:
  // Where sample (0, 0, 0) lies, lattice steps.
  glm::ivec3 low() const { return corner_ * kStepsPerVoxel + field_->info().low_steps(); }

  const FieldBlocks* field_ = nullptr;
  glm::ivec3 corner_{0};
};

}  // namespace karst::core
