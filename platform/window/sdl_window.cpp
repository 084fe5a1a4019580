// SPDX-License-Identifier: MIT
// The window of karst-window, through SDL2. SDL says by no descriptor that something has arrived: the window
// is asked sixty times a second.
#include <SDL.h>
#include <linux/input-event-codes.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "platform/base/clock.h"
#include "platform/window/window_display.h"

namespace karst {
namespace {

constexpr std::int64_t kPollInterval_ns = 1'000'000'000 / 60;

struct Key {
  SDL_Scancode here;
  unsigned there;
};
constexpr Key kKeys[] = {{SDL_SCANCODE_W, KEY_W},
                         {SDL_SCANCODE_A, KEY_A},
                         {SDL_SCANCODE_S, KEY_S},
                         {SDL_SCANCODE_D, KEY_D},
                         {SDL_SCANCODE_Q, KEY_Q},
                         {SDL_SCANCODE_E, KEY_E},
                         {SDL_SCANCODE_1, KEY_1},
                         {SDL_SCANCODE_2, KEY_2},
                         {SDL_SCANCODE_3, KEY_3},
                         {SDL_SCANCODE_UP, KEY_UP},
                         {SDL_SCANCODE_DOWN, KEY_DOWN},
                         {SDL_SCANCODE_LEFT, KEY_LEFT},
                         {SDL_SCANCODE_RIGHT, KEY_RIGHT},
                         {SDL_SCANCODE_0, KEY_0},
                         {SDL_SCANCODE_B, KEY_B},
                         {SDL_SCANCODE_H, KEY_H},
                         {SDL_SCANCODE_I, KEY_I},
                         {SDL_SCANCODE_J, KEY_J},
                         {SDL_SCANCODE_K, KEY_K},
                         {SDL_SCANCODE_M, KEY_M},
                         {SDL_SCANCODE_O, KEY_O},
                         {SDL_SCANCODE_P, KEY_P},
                         {SDL_SCANCODE_T, KEY_T},
                         {SDL_SCANCODE_Y, KEY_Y},
                         {SDL_SCANCODE_Z, KEY_Z},
                         {SDL_SCANCODE_SPACE, KEY_SPACE},
                         {SDL_SCANCODE_RETURN, KEY_ENTER},
                         {SDL_SCANCODE_LEFTBRACKET, KEY_LEFTBRACE},
                         {SDL_SCANCODE_RIGHTBRACKET, KEY_RIGHTBRACE},
                         {SDL_SCANCODE_MINUS, KEY_MINUS},
                         {SDL_SCANCODE_EQUALS, KEY_EQUAL},
                         {SDL_SCANCODE_COMMA, KEY_COMMA},
                         {SDL_SCANCODE_PERIOD, KEY_DOT},
                         {SDL_SCANCODE_F5, KEY_F5},
                         {SDL_SCANCODE_HOME, KEY_HOME},
                         {SDL_SCANCODE_LSHIFT, KEY_LEFTSHIFT},
                         {SDL_SCANCODE_RSHIFT, KEY_RIGHTSHIFT},
                         {SDL_SCANCODE_LCTRL, KEY_LEFTCTRL},
                         {SDL_SCANCODE_RCTRL, KEY_RIGHTCTRL}};

// What was typed and pointed at since it was last asked for.
class WindowInput final : public Input {
 public:
  int fd() const override { return -1; }
  void dispatch(const std::function<void(const InputEvent&)>& handle) override {
    for (const InputEvent& event : std::exchange(events_, {})) handle(event);
  }
  void set_active(bool /*active*/) override {}

  void add(const SDL_Event& event) {
    InputEvent out;
    switch (event.type) {
      case SDL_KEYDOWN:
      case SDL_KEYUP:
        if (event.key.repeat != 0) return;
        for (const Key& key : kKeys) {
          if (key.here == event.key.keysym.scancode) out.code = key.there;
        }
        out.kind = InputEvent::Kind::key;
        out.pressed = event.type == SDL_KEYDOWN;
        break;
      case SDL_MOUSEBUTTONDOWN:
      case SDL_MOUSEBUTTONUP:
        if (event.button.button != SDL_BUTTON_LEFT && event.button.button != SDL_BUTTON_RIGHT) return;
        out.kind = InputEvent::Kind::button;
        out.code = event.button.button == SDL_BUTTON_LEFT ? BTN_LEFT : BTN_RIGHT;
        out.pressed = event.type == SDL_MOUSEBUTTONDOWN;
        break;
      case SDL_MOUSEMOTION:
        if (SDL_Window* const window = SDL_GetWindowFromID(event.motion.windowID); window != nullptr) {
          int width = 0, height = 0;
          SDL_GetWindowSize(window, &width, &height);
          out.kind = InputEvent::Kind::pointer;
          out.x = (event.motion.x + 0.5) / std::max(width, 1);
          out.y = (event.motion.y + 0.5) / std::max(height, 1);
          events_.push_back(out);
        }
        out.kind = InputEvent::Kind::motion;
        out.x = event.motion.xrel;
        out.y = event.motion.yrel;
        break;
      case SDL_MOUSEWHEEL:
        out.kind = InputEvent::Kind::wheel;
        out.y = -event.wheel.preciseY;
        break;
      default:
        return;
    }
    events_.push_back(out);
  }

 private:
  std::vector<InputEvent> events_;
};

class SdlWindow final : public Display {
 public:
  ~SdlWindow() override {
    if (context_ != nullptr) SDL_GL_DeleteContext(context_);
    if (window_ != nullptr) SDL_DestroyWindow(window_);
    if (started_) SDL_Quit();
  }

  Error open(Size size, const char* title) {
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    SDL_SetHint(SDL_HINT_VIDEO_X11_FORCE_EGL, "1");  // GLX knows OpenGL ES only here and there
    if (SDL_Init(SDL_INIT_VIDEO) != 0) return failure("no window");
    started_ = true;
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_ES);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 3);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 0);
    SDL_GL_SetAttribute(SDL_GL_DEPTH_SIZE, 0);  // pictures are drawn elsewhere and copied
    constexpr Uint32 kFlags = SDL_WINDOW_OPENGL | SDL_WINDOW_RESIZABLE | SDL_WINDOW_ALLOW_HIGHDPI;
    window_ = SDL_CreateWindow(title, SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, size.width,
                               size.height, kFlags);
    if (window_ == nullptr) return failure("no window");
    context_ = SDL_GL_CreateContext(window_);
    if (context_ == nullptr) return failure("no OpenGL ES 3.0 in a window");
    SDL_GL_SetSwapInterval(1);
    name_ = std::string("window (SDL ") + SDL_GetCurrentVideoDriver() + ")";
    size_ = drawable();
    return {};
  }

  Error make_current() override {
    if (SDL_GL_MakeCurrent(window_, context_) != 0) return failure("no context");
    return {};
  }
  Size size() const override { return size_; }
  GlFunction gl_function(const char* name) const override {
    return reinterpret_cast<GlFunction>(SDL_GL_GetProcAddress(name));
  }
  const std::string& name() const override { return name_; }
  Input* input() override { return &input_; }
  std::int64_t refresh_ns() const override {
    SDL_DisplayMode mode{};
    const int display = SDL_GetWindowDisplayIndex(window_);
    if (display < 0 || SDL_GetCurrentDisplayMode(display, &mode) != 0 || mode.refresh_rate <= 0) return 0;
    return 1'000'000'000 / mode.refresh_rate;
  }
  std::int64_t deadline_ns() const override { return polled_ + kPollInterval_ns; }

  Changes dispatch() override {
    Changes changes;
    polled_ = now_ns();
    SDL_Event event;
    while (SDL_PollEvent(&event) != 0) {
      if (event.type == SDL_QUIT) changes.quit = true;
      if (event.type == SDL_WINDOWEVENT && event.window.event == SDL_WINDOWEVENT_EXPOSED)
        changes.redraw = true;
      input_.add(event);
    }
    if (const Size now = drawable(); !(now == size_) && now.width > 0 && now.height > 0) {
      size_ = now;
      changes.rebuild = true;
    }
    return changes;
  }

  Error present() override {
    times_.queued();
    SDL_GL_SwapWindow(window_);
    times_.shown(now_ns(), refresh_ns());
    return {};
  }

 private:
  static Error failure(const char* what) { return std::string(what) + ": " + SDL_GetError(); }
  Size drawable() const {
    Size size;
    SDL_GL_GetDrawableSize(window_, &size.width, &size.height);
    return size;
  }

  SDL_Window* window_ = nullptr;
  SDL_GLContext context_ = nullptr;
  WindowInput input_;
  Size size_;
  std::string name_;
  std::int64_t polled_ = 0;
  bool started_ = false;
};

}  // namespace

std::unique_ptr<Display> open_window_display(Display::Size size, const char* title, Error& error) {
  auto display = std::make_unique<SdlWindow>();
  error = display->open(size, title);
  if (!error.ok()) return nullptr;
  return display;
}

}  // namespace karst
