// SPDX-License-Identifier: MIT
// All that a bake has done in a process of its own (bake/base/child.h).
#pragma once

#include <span>

#include "bake/base/child.h"

namespace karst::bake {

std::span<const ChildTask> child_tasks();

}  // namespace karst::bake
