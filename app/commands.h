// SPDX-License-Identifier: MIT
// The commands of karst. Each takes the words behind its name and returns the exit code.
#pragma once

#include <span>

#include "app/command_line/option_table.h"

namespace karst::app {

extern const CommandSpec kViewSpec;
extern const CommandSpec kRenderSpec;
extern const CommandSpec kInfoSpec;
extern const CommandSpec kEditSpec;
extern const CommandSpec kBudgetSpec;

int run_view(std::span<const char* const> words);
int run_render(std::span<const char* const> words);
int run_info(std::span<const char* const> words);
int run_edit(std::span<const char* const> words);
int run_budget(std::span<const char* const> words);

}  // namespace karst::app
