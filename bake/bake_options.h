// SPDX-License-Identifier: MIT
// The command line of karst-bake.
#pragma once

#include "app/command_line/command_line.h"
#include "bake/fields/bake_field.h"
#include "bake/imagery/bake_imagery.h"
#include "bake/pipeline/bake.h"
#include "platform/base/error.h"

#include <span>
#include <string>

namespace karst::bake {

struct BakeOptions {
  Bake job;
  std::string output;
  std::string stats;    // empty: none
  bool ground = false;  // a ground of tiles, voxels at most in it
  bool no_ground = false;

  bool is_field() const { return !field.path.empty() || !field.shape.empty(); }
  ImageryOptions imagery;
  BakeField field;
  bool json = false;
  bool quiet = false;
};

extern const app::CommandSpec kBakeSpec;

// The error tells what is wrong with the command line. With --help and --version options are
// left alone.
Error parse_bake_options(std::span<const char* const> words, app::CommandLine& line, BakeOptions& options);

}  // namespace karst::bake
