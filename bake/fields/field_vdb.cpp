// SPDX-License-Identifier: MIT
#include "bake/fields/field_vdb.h"

#ifdef KARST_OPENVDB
#include <openvdb/openvdb.h>

#include <cmath>
#endif

namespace karst::bake {

// OpenVDB's number 0x56444220 in eight bytes.
bool is_vdb(std::string_view head) {
  return head.starts_with(std::string_view(" BDV\0\0\0\0", 8));
}

#ifdef KARST_OPENVDB

namespace {

Error copy_grid(const openvdb::FloatGrid& from, FieldGrid& grid) {
  openvdb::CoordBBox box = from.evalActiveVoxelBoundingBox();
  if (box.empty()) return "its grid has no active values";
  // One around, so that the surface closes where that is possible.
  box.expand(1);
  const openvdb::Coord size = box.dim();
  std::uint64_t samples = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const int side = size[static_cast<std::size_t>(axis)];
    if (side < 2 || side > FieldGrid::kMostSide)
      return "its sides are not within 2 to 4080 samples: cut or resample it";
    samples *= static_cast<std::uint64_t>(side);
    grid.size[axis] = side;
  }
  if (samples > FieldGrid::kMostSamples) return "it has more than 2^26 samples: cut or resample it";
  if (!from.hasUniformVoxels()) return "its voxels are not cubes";
  grid.spacing_m = from.voxelSize()[0];
  grid.values.reserve(samples);
  const auto read = from.getConstAccessor();
  openvdb::Coord at;
  for (at[2] = box.min()[2]; at[2] <= box.max()[2]; ++at[2]) {
    for (at[1] = box.min()[1]; at[1] <= box.max()[1]; ++at[1]) {
      for (at[0] = box.min()[0]; at[0] <= box.max()[0]; ++at[0]) {
        const float value = read.getValue(at);
        if (!std::isfinite(value)) return "a value is infinite or not a number";
        grid.values.push_back(value);
      }
    }
  }
  return {};
}

}  // namespace

Error read_vdb(const std::string& path, FieldGrid& grid) {
  try {
    openvdb::initialize();
    openvdb::io::File file(path);
    file.open();
    for (auto name = file.beginName(); name != file.endName(); ++name) {
      const auto found = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(*name));
      if (found != nullptr) return copy_grid(*found, grid);
    }
    return "OpenVDB finds no grid of floats in it";
  } catch (const std::exception& failure) {
    return std::string("OpenVDB: ") + failure.what();
  }
}

#else

Error read_vdb(const std::string&, FieldGrid&) {
  return "this karst-bake was built without OpenVDB: save the file as NRRD, or build where libopenvdb-dev is";
}

#endif

}  // namespace karst::bake
