// SPDX-License-Identifier: MIT
#include "bake/child_tasks.h"

#include "bake/materials/material_files.h"

namespace karst::bake {

std::span<const ChildTask> child_tasks() {
  static const ChildTask kTasks[] = {kReadMaterialImage, kReadBlendMap};
  return kTasks;
}

}  // namespace karst::bake
