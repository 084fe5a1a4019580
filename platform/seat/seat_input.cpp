// SPDX-License-Identifier: MIT
// Sources: the libinput 1.22 documentation.
#include "platform/seat/seat_input.h"

#include <libinput.h>
#include <libudev.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <utility>
#include <vector>

namespace karst {
namespace {

constexpr double kWheelNotch = 120.0;  // libinput's high-resolution steps a notch

class LibInput final : public Input {
 public:
  LibInput(Seat& seat, LogLine log) : seat_(seat), log_(std::move(log)) {}

  ~LibInput() override {
    if (input_ != nullptr) libinput_unref(input_);
    if (udev_ != nullptr) udev_unref(udev_);
  }

  Error open() {
    static const libinput_interface kInterface = {
        [](const char* path, int, void* self) { return static_cast<LibInput*>(self)->open_device(path); },
        [](int fd, void* self) { static_cast<LibInput*>(self)->close_device(fd); }};
    udev_ = udev_new();
    if (udev_ == nullptr) return errno_text("udev_new", errno);
    input_ = libinput_udev_create_context(&kInterface, this, udev_);
    if (input_ == nullptr) return errno_text("libinput", errno);
    libinput_log_set_priority(input_, LIBINPUT_LOG_PRIORITY_ERROR);
    libinput_set_user_data(input_, this);
    libinput_log_set_handler(
        input_, [](libinput* context, libinput_log_priority, const char* format, va_list arguments) {
          char text[256];
          std::vsnprintf(text, sizeof text, format, arguments);
          std::string line = text;
          while (!line.empty() && line.back() == '\n') line.pop_back();
          static_cast<LibInput*>(libinput_get_user_data(context))->log_("input: " + line);
        });
    if (libinput_udev_assign_seat(input_, "seat0") != 0) return "libinput: no seat0";
    return {};
  }

  int fd() const override { return libinput_get_fd(input_); }

  void dispatch(const std::function<void(const InputEvent&)>& handle) override {
    if (libinput_dispatch(input_) != 0) return;
    while (libinput_event* event = libinput_get_event(input_)) {
      translate(event, handle);
      libinput_event_destroy(event);
    }
  }

  void set_active(bool active) override {
    if (!active) {
      libinput_suspend(input_);
    } else if (libinput_resume(input_) != 0) {
      log_("input: the devices cannot be opened again");
    }
  }

 private:
  struct Opened {
    int fd;
    SeatDevice device;
  };

  int open_device(const char* path) {
    SeatDevice device;
    if (const int error = seat_.open_device(path, device); error != 0) return error;
    opened_.push_back({device.fd, device});
    return device.fd;
  }

  void close_device(int fd) {
    for (std::size_t i = 0; i < opened_.size(); ++i) {
      if (opened_[i].fd != fd) continue;
      seat_.close_device(opened_[i].device);
      opened_.erase(opened_.begin() + static_cast<std::ptrdiff_t>(i));
      return;
    }
  }

  static void translate(libinput_event* event, const std::function<void(const InputEvent&)>& handle) {
    InputEvent out;
    switch (libinput_event_get_type(event)) {
      case LIBINPUT_EVENT_KEYBOARD_KEY: {
        libinput_event_keyboard* key = libinput_event_get_keyboard_event(event);
        out.kind = InputEvent::Kind::key;
        out.code = libinput_event_keyboard_get_key(key);
        out.pressed = libinput_event_keyboard_get_key_state(key) == LIBINPUT_KEY_STATE_PRESSED;
        break;
      }
      case LIBINPUT_EVENT_POINTER_BUTTON: {
        libinput_event_pointer* pointer = libinput_event_get_pointer_event(event);
        out.kind = InputEvent::Kind::button;
        out.code = libinput_event_pointer_get_button(pointer);
        out.pressed = libinput_event_pointer_get_button_state(pointer) == LIBINPUT_BUTTON_STATE_PRESSED;
        break;
      }
      case LIBINPUT_EVENT_POINTER_MOTION: {
        libinput_event_pointer* pointer = libinput_event_get_pointer_event(event);
        out.kind = InputEvent::Kind::motion;
        out.x = libinput_event_pointer_get_dx(pointer);
        out.y = libinput_event_pointer_get_dy(pointer);
        break;
      }
      case LIBINPUT_EVENT_POINTER_MOTION_ABSOLUTE: {
        libinput_event_pointer* pointer = libinput_event_get_pointer_event(event);
        out.kind = InputEvent::Kind::place;
        out.x = libinput_event_pointer_get_absolute_x_transformed(pointer, 1);
        out.y = libinput_event_pointer_get_absolute_y_transformed(pointer, 1);
        break;
      }
      case LIBINPUT_EVENT_POINTER_SCROLL_WHEEL: {
        libinput_event_pointer* pointer = libinput_event_get_pointer_event(event);
        if (libinput_event_pointer_has_axis(pointer, LIBINPUT_POINTER_AXIS_SCROLL_VERTICAL) == 0) return;
        out.kind = InputEvent::Kind::wheel;
        out.y = libinput_event_pointer_get_scroll_value_v120(pointer, LIBINPUT_POINTER_AXIS_SCROLL_VERTICAL) /
                kWheelNotch;
        break;
      }
      case LIBINPUT_EVENT_TOUCH_DOWN:
      case LIBINPUT_EVENT_TOUCH_MOTION: {
        libinput_event_touch* touch = libinput_event_get_touch_event(event);
        out.kind = InputEvent::Kind::touch;
        out.id = libinput_event_touch_get_seat_slot(touch);
        out.x = libinput_event_touch_get_x_transformed(touch, 1);
        out.y = libinput_event_touch_get_y_transformed(touch, 1);
        break;
      }
      case LIBINPUT_EVENT_TOUCH_UP:
      case LIBINPUT_EVENT_TOUCH_CANCEL: {
        out.kind = InputEvent::Kind::untouch;
        out.id = libinput_event_touch_get_seat_slot(libinput_event_get_touch_event(event));
        break;
      }
      default:
        return;
    }
    handle(out);
  }

  Seat& seat_;
  LogLine log_;
  udev* udev_ = nullptr;
  libinput* input_ = nullptr;
  std::vector<Opened> opened_;
};

}  // namespace

std::unique_ptr<Input> open_input(Seat& seat, const LogLine& log, Error& error) {
  auto input = std::make_unique<LibInput>(seat, log);
  error = input->open();
  if (!error.ok()) return nullptr;
  return input;
}

}  // namespace karst
