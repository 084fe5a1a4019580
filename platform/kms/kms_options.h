// SPDX-License-Identifier: MIT
// What a user asks of a bare screen.
#pragma once

#include <string>

#include "platform/kms/kms_mode.h"

namespace karst {

enum class ColourFormat { xrgb8888, rgb565 };

struct KmsOptions {
  std::string card;       // a node or a link to one; empty: the first with a monitor
  std::string connector;  // the kernel's name; empty: the first with a monitor
  ModeRequest mode;
  bool mode_fallback = false;  // take another connector or mode where the wanted one is not there
  bool atomic = true;
  bool legacy = true;
  bool modifiers = true;
  ColourFormat format = ColourFormat::xrgb8888;
  int buffers = 2;        // 2, or 3: a frame may be drawn while another waits for the refresh
  int quarter_turns = 0;  // counter-clockwise, of the picture
};

}  // namespace karst
