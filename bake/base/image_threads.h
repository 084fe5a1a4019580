// SPDX-License-Identifier: MIT
// OpenImageIO without threads of its own: a process that has some cannot be copied safely (child.h), and
// their stacks and heaps would count against a child's limit on memory.
#pragma once

namespace karst::bake {

// To be called before any of OpenImageIO's readers and writers is made.
void keep_image_threads_away();

}  // namespace karst::bake
