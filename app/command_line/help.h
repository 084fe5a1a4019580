// SPDX-License-Identifier: MIT
// What --help prints, from the table of options.
#pragma once

#include <string>

#include "app/command_line/option_table.h"

namespace karst::app {

// Usage, what it does, all options by group, examples, exit codes.
std::string help_text(const CommandSpec& spec);

// A group's title with a capital.
std::string heading(const OptionGroup& group);

// What an option does, with its range, its unit and what holds without it.
std::string explain(const OptionRow& row);

}  // namespace karst::app
