// SPDX-License-Identifier: MIT
// Access to the display and input devices of this machine, and the virtual terminal in front of them. A seat
// may be taken away (a switch to another terminal) and given back; devices that were opened through it are of
// no use meanwhile.
//
// Two kinds: libseat (seatd or logind; no root needed), and devices opened directly (root, or the groups
// video and input), where the virtual terminal is taken over here.
#pragma once

#include <memory>
#include <string>

#include "platform/base/error.h"
#include "platform/base/log.h"
#include "platform/seat/console_state.h"

namespace karst {

struct SeatDevice {
  int fd = -1;
  int id = -1;  // the seat's own number
};

class Seat {
 public:
  Seat() = default;
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;
  virtual ~Seat() = default;

  // Opens a device for reading and writing. Returns 0, or a negative errno; device is then unchanged.
  virtual int open_device(const std::string& path, SeatDevice& device) = 0;
  virtual void close_device(SeatDevice& device) = 0;
  // Readable when dispatch() has something to do; -1: never.
  virtual int fd() const = 0;
  virtual void dispatch() = 0;
  // Whether the devices may be used. When it turns false the owner of the devices must let go of them
  // (drop the DRM master) and call released(), after which the terminal is switched.
  virtual bool active() const = 0;
  virtual void released() = 0;
  // Whether this program, and not the seat's keeper, sets and drops the DRM master.
  virtual bool sets_master() const = 0;
  virtual void switch_terminal(int number) = 0;
  virtual const char* name() const = 0;
};

enum class SeatKind { automatic, libseat, direct };

// automatic: libseat where its keeper answers, else direct. console: where the state of the virtual terminal
// is kept for whoever puts it back (console_state.h); not null. On failure returns null and error is one
// line. Direct access without a virtual terminal is no failure: there is nothing to switch from then.
std::unique_ptr<Seat> open_seat(SeatKind kind, ConsoleState* console, const LogLine& log, Error& error);

// Direct access to devices alone: no terminal is touched. For looking.
std::unique_ptr<Seat> open_device_access();

}  // namespace karst
