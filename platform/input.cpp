// SPDX-License-Identifier: MIT
#include "platform/input.h"

namespace karst {

InputEvent turned(const InputEvent& event, int quarter_turns) {
  InputEvent result = event;
  if (event.kind != InputEvent::Kind::place && event.kind != InputEvent::Kind::touch) return result;
  for (int turn = 0; turn < (quarter_turns & 3); ++turn) {
    const double x = result.x;
    result.x = 1 - result.y;
    result.y = x;
  }
  return result;
}

}  // namespace karst
