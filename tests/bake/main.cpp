// SPDX-License-Identifier: MIT
// These tests start this program again as a child that reads for them (bake/base/child.h).
#include "bake/base/child.h"
#include "bake/child_tasks.h"
#include "tests/bake/child_test_tasks.h"

#include <gtest/gtest.h>

int main(int count, char** words) {
  using namespace karst::bake;
  std::vector<ChildTask> tasks(child_tasks().begin(), child_tasks().end());
  tasks.insert(tasks.end(), child_test_tasks().begin(), child_test_tasks().end());
  const std::span<char* const> all(words, static_cast<std::size_t>(count));
  if (const std::optional<int> code = serve_as_child(all, tasks)) return *code;
  testing::InitGoogleTest(&count, words);
  return RUN_ALL_TESTS();
}
