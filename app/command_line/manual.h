// SPDX-License-Identifier: MIT
// Man pages (troff, man(7)) and completion for bash, from the tables of options. Printed when karst is built;
// no part of the board program.
#pragma once

#include <span>
#include <string>

#include "app/command_line/option_table.h"

namespace karst::app {

// A program: several commands behind a name ("karst"), or one that is the program itself ("karst-bake").
struct ProgramSpec {
  const char* name;
  const char* brief;
  const char* about;  // of the page on the program as a whole, where there are several commands
  std::span<const CommandSpec* const> commands;
};

// The page of a command; its name is the command's with a dash for the blank. Dates are left out, so that the
// same sources make the same page.
std::string man_page(const ProgramSpec& program, const CommandSpec& command);
// The page of a program of several commands.
std::string man_page(const ProgramSpec& program);
std::string bash_completion(const ProgramSpec& program);

// What the programs that print all this are called with: "man PAGE" or "completion"; returns the exit code.
int print_manual(const ProgramSpec& program, std::span<const char* const> words);

}  // namespace karst::app
