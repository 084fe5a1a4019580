// SPDX-License-Identifier: MIT
#include "bake/child_tasks.h"

#include "bake/fields/field_file.h"
#include "bake/imagery/image_file.h"
#include "bake/materials/material_files.h"
#include "bake/rasters/elevation_file.h"

namespace karst::bake {

std::span<const ChildTask> child_tasks() {
  static const ChildTask kTasks[] = {kReadMaterialImage, kReadBlendMap, kDescribeRaster,
                                     kReadRaster,        kDescribeExr,  kReadExr,
                                     kDescribeImage,     kReadImage,    kReadField};
  return kTasks;
}

}  // namespace karst::bake
