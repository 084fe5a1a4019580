// SPDX-License-Identifier: MIT
// OpenVDB's files of grids, where that library was there when this was built.
#pragma once

#include <string>
#include <string_view>

#include "bake/fields/field_grid.h"
#include "platform/base/error.h"

namespace karst::bake {

// Whether a file's first bytes are those of OpenVDB's.
bool is_vdb(std::string_view head);

// The first grid of floats, all within the box of its active values. The error does not name the file.
Error read_vdb(const std::string& path, FieldGrid& grid);

}  // namespace karst::bake
