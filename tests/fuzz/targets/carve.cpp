// SPDX-License-Identifier: MIT
// Shapes in JSON.
#include "bake/carve/carve.h"
#include "tests/fuzz/run/fuzz_target.h"

#include <cmath>

namespace karst {

void fuzz_one(std::span<const std::byte> input) {
  static const std::string name = "carve.json";
  std::vector<bake::CarveShape> shapes;
  const Error error = bake::parse_carve(as_text(input), name, shapes);
  must_be_short(error);
  if (!error.ok()) return;
  must(shapes.size() <= bake::CarveShape::kMostShapes);
  for (const bake::CarveShape& shape : shapes) {
    const bake::Box box = shape.bounds();
    for (int axis = 0; axis < 3; ++axis) {
      must(std::isfinite(box.min[axis]) && box.min[axis] <= box.max[axis]);
      must(box.max[axis] <= 2 * bake::CarveShape::kFarthestM);
    }
    must(shape.blend_m >= 0 && shape.radius_m >= 0);
  }
}

}  // namespace karst
