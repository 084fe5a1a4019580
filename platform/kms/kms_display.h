// SPDX-License-Identifier: MIT
// A bare screen: the kernel's modesetting with buffers from GBM, without a window system.
//
// The display lives through everything that happens to a screen. It is in one of these states, and dispatch()
// moves it on whenever the kernel, the seat or a time limit says so:
//
//   no card     no card has a monitor: all cards are looked at again on the kernel's word, and every 500 ms
//   dark        the card is open and its monitor is gone: looked at on the kernel's word, and every 2 s
//   no master   another program has the screen: tried again every 100 ms
//   away        the seat is on another terminal
//   on          frames are drawn; the first one after any other state sets the mode
//
// Nothing waits longer than 100 ms for the driver to say that a frame is shown.
#pragma once

#include <memory>
#include <string>

#include "platform/base/log.h"
#include "platform/display.h"
#include "platform/egl_api.h"
#include "platform/kms/kms_options.h"
#include "platform/seat/console_state.h"
#include "platform/seat/seat.h"

namespace karst {

// Never fails for want of a screen: that may come. error is set, and null returned, where a monitor is there
// and the wanted connector or mode is not, without mode_fallback. seat, console and what log refers to must
// outlive the display.
std::unique_ptr<Display> open_kms_display(const KmsOptions& options, Seat& seat, ConsoleState& console,
                                          const LogLine& log, Error& error, const EglApi& egl = linked_egl());

}  // namespace karst
