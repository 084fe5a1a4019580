// SPDX-License-Identifier: MIT
// Edits as text: scripts that people write, and the journal that the editor writes. JSON, one object a line,
// or one list of them; docs/editing.md has the fields. Places are metres in the world's own axes: to the
// east, up and to the south.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "karst/edit.h"
#include "karst/world.h"
#include "platform/base/error.h"

namespace karst::app {

struct ScriptStep {
  enum Kind : std::uint8_t { edit, undo, redo };
  Kind kind = edit;
  bool joined = false;        // with the edit before it: one step of undo
  Edit what;                  // of edit
  std::string material = {};  // of paint, by name: what.material is not known then
};

inline constexpr std::size_t kMostScriptSteps = 1'000'000;

struct ScriptCounts {
  std::size_t edits = 0, unchanged = 0, undone = 0, redone = 0;
};
// What is left of steps once their own undo and redo are done: an edit that was taken back need not be made.
// The first edit of each step of undo is not joined. Counts undone and redone.
std::vector<ScriptStep> effective_steps(const std::vector<ScriptStep>& steps, ScriptCounts& counts);

// Of a journal, a last line that was being written is left out. Messages name the file, the edit or the line,
// and the field.
Error parse_script(std::string_view text, const std::string& name, std::vector<ScriptStep>& steps);
// One line of it, without its end.
Error parse_script_line(std::string_view line, const std::string& place, ScriptStep& step);
// Materials by their numbers in a world. name: of the script, for the message.
Error find_materials(const WorldInfo& info, const std::string& name, std::vector<ScriptStep>& steps);
// The line that means this step, without its end: numbers are as long as their bits need.
std::string script_line(const ScriptStep& step);

}  // namespace karst::app
