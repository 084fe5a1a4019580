// SPDX-License-Identifier: MIT
// What keyboards, mice and touch screens say.
#pragma once

#include <cstdint>
#include <functional>

namespace karst {

struct InputEvent {
  enum class Kind : std::uint8_t {
    key,      // code: of linux/input-event-codes.h; pressed
    button,   // code: BTN_LEFT, ...; pressed
    motion,   // x, y: of the pointer, in the mouse's own steps; right and down
    place,    // x, y: of a pointer that has a place (tablets), 0..1 of the screen from its top left
    pointer,  // x, y: the same of a window, whose pointer moves by `motion`, too
    wheel,    // y: notches towards the user
    touch,    // a finger (id) is down at x, y, 0..1 of the screen from its top left
    untouch,  // finger id is up
  };
  Kind kind = Kind::key;
  bool pressed = false;
  int id = 0;
  unsigned code = 0;
  double x = 0;
  double y = 0;
};

// Places on a screen whose picture is turned counter-clockwise, as places on the upright picture. What a
// mouse moves by is its own affair and stays.
InputEvent turned(const InputEvent& event, int quarter_turns);

class Input {
 public:
  Input() = default;
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
  virtual ~Input() = default;
  virtual int fd() const = 0;
  virtual void dispatch(const std::function<void(const InputEvent&)>& handle) = 0;
  // The seat is taken away or given back. libinput tells of every key that is down as released then.
  virtual void set_active(bool active) = 0;
};

}  // namespace karst
