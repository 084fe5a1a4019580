// SPDX-License-Identifier: MIT
// The options that say where pictures are shown, of all programs that show them.
#pragma once

#include "app/command_line/option_table.h"
#include "platform/kms/kms_display.h"

namespace karst::app {

struct ScreenArguments {
  enum class Output { kms, headless, window };

  Output output = Output::kms;
  KmsOptions kms;
  SeatKind seat = SeatKind::automatic;
  bool supervise = true;
  bool list_outputs = false;
  bool json = false;
  double wait_s = -1;  // for a display; below 0: for ever
};

// Stored into ScreenArguments.
extern const OptionGroup kScreenGroups[1];

}  // namespace karst::app
