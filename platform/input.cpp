// SPDX-License-Identifier: MIT
#include "platform/input.h"

namespace karst {

InputEvent turned(const InputEvent& event, int quarter_turns) {
  InputEvent result = event;
  using Kind = InputEvent::Kind;
  if (event.kind != Kind::place && event.kind != Kind::pointer && event.kind != Kind::touch) return result;
  for (int turn = 0; turn < (quarter_turns & 3); ++turn) {
    const double x = result.x;
    result.x = 1 - result.y;
    result.y = x;
  }
  return result;
}

}  // namespace karst
