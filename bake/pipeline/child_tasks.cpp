// SPDX-License-Identifier: MIT
#include "bake/pipeline/child_tasks.h"

#include "bake/materials/material_files.h"

namespace karst::bake {

std::span<const ChildTask> child_tasks() {
  static const ChildTask kTasks[] = {kReadMaterialImage};
  return kTasks;
}

}  // namespace karst::bake
