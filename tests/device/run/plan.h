// SPDX-License-Identifier: MIT
// What karst-device does on a machine, as a text: a part a line, "KIND NAME : WORDS". '#' begins a comment,
// and
// "@/" at a word's beginning is the folder.
//
//   world     NAME : karst-bake's arguments              baked into the folder before it is taken anywhere
//   tests     NAME : PROGRAM [--gtest_filter=...]        of bin/, made with GoogleTest
//   pictures  NAME : all, or PICTURE...                  golden ones, drawn anew and compared
//   frames    NAME : WORLD [karst-bench's options]       a way to draw; --suite frames
//   program   NAME : PROGRAM [ARGUMENT...]               of bin/; its output is kept
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "platform/base/error.h"

namespace karst::device {

enum class PartKind : std::uint8_t { world, tests, pictures, frames, program };
inline constexpr const char* kPartKinds[] = {"world", "tests", "pictures", "frames", "program"};

struct Part {
  PartKind kind = PartKind::tests;
  std::string name;
  std::vector<std::string> words;  // at least one
};

// name: of the text, for errors, which also tell the line.
Error parse_plan(std::string_view text, const std::string& name, std::vector<Part>& parts);

}  // namespace karst::device
