// SPDX-License-Identifier: MIT
// The command line of karst-bake.
#pragma once

#include "app/command_line/command_line.h"
#include "bake/pipeline/bake.h"

#include <span>
#include <string>

namespace karst::bake {

struct BakeOptions {
  Bake job;
  std::string output;
  std::string stats;  // empty: none
  bool json = false;
  bool quiet = false;
};

extern const app::CommandSpec kBakeSpec;

// Empty where the command line is right, else what is wrong with it. With --help and --version options are
// left alone.
[[nodiscard]] std::string parse_bake_options(std::span<const char* const> words, app::CommandLine& line,
                                             BakeOptions& options);

}  // namespace karst::bake
