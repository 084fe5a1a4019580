// SPDX-License-Identifier: MIT
// Moves a camera by keys, mouse, wheel and fingers. Pure state: events and time go in, a place comes out.
//
//   fly    w s a d forward, back, left, right; q e down, up; arrows or the dragged mouse turn; the wheel sets
//          the speed; Shift is four times as fast, Ctrl a quarter
//   orbit  around a point before the eye: a d and arrows or dragging turn, w s and the wheel go near and away
//   walk   as fly, level, with the eyes above the ground
//   touch  one finger turns; two move (fly, walk) or go near and away (orbit)
//   1 2 3  choose fly, orbit, walk; Home goes back to where it began, 0 to where all of the world is seen
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>

#include "app/common/camera_path.h"
#include "platform/input.h"

namespace karst::app {

enum class NavigatorMode : std::uint8_t { fly, orbit, walk, none };

struct NavigatorSettings {
  NavigatorMode mode = NavigatorMode::fly;
  CameraPlace start;
  glm::dvec3 centre_m{0.0};  // of the world; what orbit turns around at first
  double speed_m_s = 10;     // above 0; at the start
  // Of key 0, which flies there.
  CameraPlace overview;
  double overview_speed_m_s = 10;
  double eye_height_m = 1.7;  // of walk
  // East, up and south at a place, as columns, on a curved basis; empty: x, y and z.
  std::function<glm::dmat3(const glm::dvec3& place_m)> axes_at;
  // Height of the ground below a place, none where there is none. May be empty: walk then stays at its
  // height.
  std::function<std::optional<double>(const glm::dvec3& place_m)> ground_m;
};

class Navigator {
 public:
  explicit Navigator(NavigatorSettings settings);

  // Whether the event was for the camera and moved it at once.
  bool handle(const InputEvent& event);
  // Whether keys are held that move it as time passes.
  bool moving() const;
  // Moves for so much time; whether the place changed.
  bool advance(double seconds);

  const CameraPlace& place() const { return place_; }
  // Something else has moved the camera.
  void set_place(const CameraPlace& place);
  NavigatorMode mode() const { return mode_; }
  double speed_m_s() const { return speed_m_s_; }

 private:
  enum Held : std::uint8_t {
    kForward,
    kBack,
    kLeft,
    kRight,
    kUp,
    kDown,
    kTurnLeft,
    kTurnRight,
    kTurnUp,
    kTurnDown,
    kFast,
    kSlow,
    kHeldCount
  };
  struct Finger {
    bool down = false;
    double x = 0;
    double y = 0;
  };

  bool handle_key(unsigned code, bool pressed);
  bool handle_finger(const InputEvent& event);
  bool choose(NavigatorMode mode);
  void turn(double yaw_deg, double pitch_deg);
  void move(double right, double up, double forward);  // metres
  void zoom(double steps);
  void orbit_to_place();
  glm::dvec3 forward() const;  // where it looks
  void look_along(const glm::dvec3& forward);
  bool settle();  // on the ground, when walking; whether it moved

  NavigatorSettings settings_;
  NavigatorMode mode_;
  CameraPlace place_;
  double speed_m_s_;
  glm::dvec3 target_m_{0.0};
  double distance_m_ = 1;
  std::array<bool, kHeldCount> held_{};
  std::array<bool, kHeldCount> tapped_{};  // pressed since the last advance(), perhaps released again
  bool dragging_ = false;
  std::optional<glm::dvec2> pointer_;  // last place of a pointer that has one
  std::array<Finger, 2> fingers_{};
};

}  // namespace karst::app
