// SPDX-License-Identifier: MIT
// What fingers do where a world is edited. One is the tool: a tap once, held down a stroke. It waits for a
// moment, for a second one may follow it; two are the camera's, until all are up. One that comes down where
// there is nothing to edit turns the camera.
#pragma once

#include <cstdint>
#include <functional>

#include <glm/vec2.hpp>

#include "platform/input.h"

namespace karst::app {

class Fingers {
 public:
  enum class Tool : std::uint8_t { stays, tap, press, release };

  // touch and untouch. camera: called with what the camera is to make of it.
  Tool handle(const InputEvent& event, const std::function<void(const InputEvent&)>& camera);
  // A picture comes; found: there is something to edit under the finger.
  Tool frame(std::int64_t now_ns, bool found);

  // Whether frame() is to be called soon, whatever happens.
  bool waits() const { return is_ == Is::waiting; }
  // Where a finger was last as the tool, 0..1 of the picture; it points there until forget().
  bool points() const { return points_; }
  const glm::dvec2& at() const { return at_; }
  void forget() { points_ = false; }

 private:
  enum class Is : std::uint8_t { up, waiting, drawing, of_camera };

  Is is_ = Is::up;
  int id_ = 0;               // of the finger that is the tool
  std::uint32_t down_ = 0;   // bit n: finger n is
  std::int64_t due_ns_ = 0;  // when it draws; 0: not known yet
  glm::dvec2 at_{0.5};
  bool points_ = false;
};

}  // namespace karst::app
