// SPDX-License-Identifier: MIT
// Reads a command line by its table: --name VALUE, --name=VALUE, -n VALUE, --flag, and positional words; "--"
// ends the options. A word that begins with a dash and a digit or a point is a value. Each option may be
// given once.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/command_line/option_table.h"
#include "platform/base/error.h"

namespace karst::app {

class CommandLine {
 public:
  // Finds the options and their values, and stores nothing. words: without the program's and the command's
  // name; they and spec must outlive this object.
  Error parse(std::span<const char* const> words, const CommandSpec& spec);
  // Checks the values that were given and stores them, in the order of the table and not of the words.
  // targets[i]: the struct of spec.parts[i].
  Error store(std::span<void* const> targets) const;

  bool has(std::string_view name) const;
  bool wants_help() const { return has("help"); }
  std::span<const std::string_view> positional() const { return positional_; }

 private:
  struct Given {
    const OptionRow* row;
    std::string_view value;
  };
  const Given* find(const OptionRow& row) const;

  const CommandSpec* spec_ = nullptr;
  std::vector<Given> given_;
  std::vector<std::string_view> positional_;
};

}  // namespace karst::app
