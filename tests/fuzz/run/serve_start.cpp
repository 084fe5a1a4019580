// SPDX-License-Identifier: MIT
// Of targets that call what works in children.
#include "bake/base/child.h"
#include "bake/base/image_threads.h"
#include "bake/child_tasks.h"
#include "tests/fuzz/run/fuzz_target.h"

#include <cstdlib>

namespace karst {

void start_target(std::span<char* const> words) {
  if (const std::optional<int> code = bake::serve_as_child(words, bake::child_tasks())) std::exit(*code);
  bake::keep_image_threads_away();
}

}  // namespace karst
