// SPDX-License-Identifier: MIT
// How far apart the surfaces of a level and of the next finer one are at most, within cells of the level:
// each point of either has one of the other within the bound. What is compared are both as they are with no
// transition cells and with places that are not rounded.
//
// Within a cell that both go through, the finer surface F and the coarser one S, a loop's triangles:
//  - A distance from a convex body is greatest at a triangle's corners. So from F to S it is at most that
//    from F's vertices to one triangle of S; or that to the convex hull of S, and how thick the hull is: seen
//    along the loop's mean normal, where S has no folds and its outline is convex, the greatest gap where a
//    diagonal of the outline crosses an inner edge of S. Loops of the cells around do as well.
//  - From S to F it is at most a triangle's longest edge by sqrt 3, since S's vertices are F's. Less where F
//    has no folds over S either, and F's outline, as seen along the normal, goes q into that of S at most:
//    then as many sheets of F lie over all of S that is more than q within, and that is one where some point
//    of F does. How far they are apart along the normal is found where sides of their triangles cross. From
//    the rest, and where S is narrow, it is what leads to S's outline and from there to F's. Where that is
//    much, F is taken together with that of the cells around.
// A finer surface where the cell has none is lost. It counts as far off as the surface of other cells is;
// where it is shut in within the cells around, as its own width, when that is less.
#pragma once

#include <glm/vec3.hpp>

#include "terrain/field/scalar_field.h"

namespace karst::core {

struct CellDistance {
  float most = 0;  // cells of the level; infinite where nothing is near of what was lost
  int reach = 0;   // samples of cells so far away count, too: 0, 1 or kFarCells
};

inline constexpr int kFarCells = 6;

template <class Sample>
struct MeasureCells {
  const ScalarField<Sample>* field = nullptr;
  int level = 1;  // 1..kIsoMaxLevel

  // Of cells low..high, both included; those beyond the field have nothing. enough: what is no more than that
  // need not be bounded closely. The same whatever the order of cells.
  CellDistance run(glm::ivec3 low, glm::ivec3 high, float enough = 0) const;
};

extern template struct MeasureCells<std::int8_t>;
extern template struct MeasureCells<std::int16_t>;

}  // namespace karst::core
