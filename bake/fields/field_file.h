// SPDX-License-Identifier: MIT
// Files of values on a grid in space: raw ones, and NRRD (teem.sourceforge.net/nrrd/format.html) with the
// encodings raw and gzip, in one file or with detached data. Read in a child (bake/base/child.h).
#pragma once

#include <string>

#include <glm/vec3.hpp>

#include "bake/base/child.h"
#include "bake/fields/field_grid.h"
#include "platform/base/error.h"

namespace karst::bake {

struct ReadField {
  std::string path;
  glm::ivec3 size{0};  // of a raw file; zeros: the file is NRRD
  std::string type;  // of a raw file, little-endian: int8, uint8, int16, uint16, int32, uint32, float, double

  // The error names the file.
  Error run(FieldGrid& grid) const;
};

extern const ChildTask kReadField;

}  // namespace karst::bake
