// SPDX-License-Identifier: MIT
// OpenImageIO without threads of its own: their stacks and heaps would count against a child's limit on
// memory (child.h), and a row of an image is too little work for several.
#pragma once

namespace karst::bake {

// To be called before any of OpenImageIO's readers and writers is made.
void keep_image_threads_away();

}  // namespace karst::bake
