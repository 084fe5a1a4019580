// SPDX-License-Identifier: MIT
#include "app/editor/touch/fingers.h"

namespace karst::app {
namespace {

constexpr std::int64_t kWait_ns = 120'000'000;  // two fingers seldom come down further apart
constexpr int kMostFingers = 32;

}  // namespace

Fingers::Tool Fingers::handle(const InputEvent& event, const std::function<void(const InputEvent&)>& camera) {
  if (event.id < 0 || event.id >= kMostFingers) return Tool::stays;
  const std::uint32_t bit = 1u << event.id;
  const bool touches = event.kind == InputEvent::Kind::touch;
  const bool is_new = touches && (down_ & bit) == 0;
  down_ = touches ? down_ | bit : down_ & ~bit;
  if (is_ == Is::up && is_new) {
    is_ = Is::waiting;
    id_ = event.id;
    due_ns_ = 0;
  }
  if (is_ == Is::of_camera || is_ == Is::up) {
    camera(event);
    if (down_ == 0) is_ = Is::up;
    return Tool::stays;
  }
  const bool was_drawing = is_ == Is::drawing;
  if (event.id != id_) {
    if (!is_new) return Tool::stays;
    InputEvent first = event;
    first.id = id_;
    first.x = at_.x;
    first.y = at_.y;
    camera(first);
    camera(event);
    is_ = Is::of_camera;
    return was_drawing ? Tool::release : Tool::stays;
  }
  if (!touches) {
    is_ = down_ == 0 ? Is::up : Is::of_camera;
    return was_drawing ? Tool::release : Tool::tap;
  }
  points_ = true;
  at_ = {event.x, event.y};
  return Tool::stays;
}

Fingers::Tool Fingers::frame(std::int64_t now_ns, bool found) {
  if (!waits()) return Tool::stays;
  if (!found) {
    is_ = Is::of_camera;
    return Tool::stays;
  }
  if (due_ns_ == 0) due_ns_ = now_ns + kWait_ns;
  if (now_ns < due_ns_) return Tool::stays;
  is_ = Is::drawing;
  return Tool::press;
}

}  // namespace karst::app
