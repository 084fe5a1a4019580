// SPDX-License-Identifier: MIT
// What the console looked like before this program took it, kept in memory that a supervising process shares,
// so that it can be put back even when this program is killed. Writers fill in the fields first and then set
// the flag.
#pragma once

#include <linux/vt.h>
#include <xf86drmMode.h>

#include <atomic>
#include <cstdint>

#include "platform/base/log.h"

namespace karst {

struct ConsoleState {
  static constexpr std::size_t kPathLength = 256;

  // The virtual terminal.
  std::atomic<bool> terminal_taken{false};
  char terminal[kPathLength] = "";
  int display_mode = 0;   // KD_TEXT or KD_GRAPHICS
  int keyboard_mode = 0;  // K_UNICODE, ...
  vt_mode switching{};

  // What the CRTC showed.
  std::atomic<bool> crtc_taken{false};
  char card[kPathLength] = "";
  std::uint32_t crtc = 0;
  std::uint32_t connector = 0;
  std::uint32_t framebuffer = 0;  // 0: it was off, there is nothing to put back
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  drmModeModeInfo mode{};
};

// Memory that stays shared across fork(); null where the system has none.
ConsoleState* share_console_state();

// Puts back what is marked as taken. For the process that took it, and for its supervisor. Safe to call
// twice. open_card: where the process that took the CRTC is gone, the card is opened anew.
void restore_terminal(ConsoleState& state, const LogLine& log);
void restore_crtc(ConsoleState& state, int card_fd, const LogLine& log);
void restore_console(ConsoleState& state, const LogLine& log);

// Runs the rest of the program in a child process and, when that ends in whatever way, gives the console
// back. In the child: returns -1, and the child ends when its supervisor does. In the supervisor: returns
// what the program must exit with (128 + signal where the child was killed by one). SIGTERM, SIGINT and
// SIGHUP are passed on to the child, which is killed where it still runs 3 s after one of the first two.
// Where no process can be made, says so and returns -1: the program then runs without a supervisor.
int supervise(ConsoleState& state, const LogLine& log);

}  // namespace karst
