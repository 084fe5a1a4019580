// SPDX-License-Identifier: MIT
#include "app/motion/navigator.h"

#include <linux/input-event-codes.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>

namespace karst::app {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
constexpr double kTurnSpeed_deg_s = 60;  // of the arrow keys
constexpr double kMouse_deg = 0.15;      // a step of the mouse
constexpr double kScreen_deg = 90;       // a finger or pen across the whole screen
constexpr double kMostPitch_deg = 89;    // straight down there is no left and right
constexpr double kWheelFactor = 1.25;    // speed or distance, a notch
constexpr double kScreen_s = 2;          // seconds of movement, two fingers across the whole screen
constexpr double kLeastSpeed_m_s = 1e-3;
constexpr double kMostSpeed_m_s = 1e6;
constexpr double kShortestStep_s = 1.0 / 120;  // what a key does that is released before a frame
constexpr double kLongestStep_s = 0.25;        // after a pause the camera does not jump

struct Axes {
  glm::dvec3 forward;
  glm::dvec3 right;
};

Axes axes(double yaw_deg, double pitch_deg) {
  const double yaw = yaw_deg * kRadiansPerDegree;
  const double pitch = pitch_deg * kRadiansPerDegree;
  const glm::dvec3 forward{-std::sin(yaw) * std::cos(pitch), std::sin(pitch),
                           -std::cos(yaw) * std::cos(pitch)};
  return {forward, {std::cos(yaw), 0, -std::sin(yaw)}};
}

}  // namespace

Navigator::Navigator(NavigatorSettings settings)
    : settings_(std::move(settings)),
      mode_(settings_.mode),
      place_(settings_.start),
      speed_m_s_(settings_.speed_m_s),
      target_m_(settings_.centre_m) {
  choose(mode_);
}

void Navigator::set_place(const CameraPlace& place) {
  place_ = place;
  if (mode_ != NavigatorMode::orbit) return;
  target_m_ = place_.position_m + forward() * distance_m_;
}

glm::dvec3 Navigator::forward() const {
  const glm::dvec3 local = axes(place_.yaw_deg, place_.pitch_deg).forward;
  return settings_.axes_at ? settings_.axes_at(place_.position_m) * local : local;
}

// Of a curved basis, by the axes at the place, which turn with it.
void Navigator::look_along(const glm::dvec3& forward) {
  const glm::dvec3 local = glm::transpose(settings_.axes_at(place_.position_m)) * forward;
  place_.pitch_deg = std::clamp(std::asin(std::clamp(local.y, -1.0, 1.0)) / kRadiansPerDegree,
                                -kMostPitch_deg, kMostPitch_deg);
  if (std::hypot(local.x, local.z) > 1e-9)
    place_.yaw_deg = std::atan2(-local.x, -local.z) / kRadiansPerDegree;
}

// Whether the camera moved by it.
bool Navigator::choose(NavigatorMode mode) {
  mode_ = mode;
  if (mode_ == NavigatorMode::orbit) {
    // As far before the eye as the world's middle is; so the picture stays as it is.
    distance_m_ = std::max(glm::length(settings_.centre_m - place_.position_m), kLeastSpeed_m_s);
    target_m_ = place_.position_m + forward() * distance_m_;
  }
  return mode_ == NavigatorMode::walk && settle();
}

bool Navigator::handle(const InputEvent& event) {
  if (mode_ == NavigatorMode::none) return false;
  switch (event.kind) {
    case InputEvent::Kind::key:
      return handle_key(event.code, event.pressed);
    case InputEvent::Kind::button:
      if (event.code == BTN_LEFT) dragging_ = event.pressed;
      return false;
    case InputEvent::Kind::motion:
      if (!dragging_) return false;
      turn(-event.x * kMouse_deg, -event.y * kMouse_deg);
      return true;
    case InputEvent::Kind::place: {
      const std::optional<glm::dvec2> before = std::exchange(pointer_, glm::dvec2(event.x, event.y));
      if (!dragging_ || !before) return false;
      turn((before->x - event.x) * kScreen_deg, (before->y - event.y) * kScreen_deg);
      return true;
    }
    case InputEvent::Kind::pointer:
      return false;
    case InputEvent::Kind::wheel:
      zoom(event.y);
      return mode_ == NavigatorMode::orbit;
    case InputEvent::Kind::touch:
    case InputEvent::Kind::untouch:
      return handle_finger(event);
  }
  return false;
}

bool Navigator::handle_key(unsigned code, bool pressed) {
  struct Key {
    unsigned code;
    Held held;
  };
  constexpr Key kKeys[] = {
      {KEY_W, kForward},     {KEY_S, kBack},        {KEY_A, kLeft},         {KEY_D, kRight},
      {KEY_E, kUp},          {KEY_Q, kDown},        {KEY_LEFT, kTurnLeft},  {KEY_RIGHT, kTurnRight},
      {KEY_UP, kTurnUp},     {KEY_DOWN, kTurnDown}, {KEY_LEFTSHIFT, kFast}, {KEY_RIGHTSHIFT, kFast},
      {KEY_LEFTCTRL, kSlow}, {KEY_RIGHTCTRL, kSlow}};
  for (const Key& key : kKeys) {
    if (key.code != code) continue;
    held_[key.held] = pressed;
    tapped_[key.held] = tapped_[key.held] || pressed;
  }
  if (!pressed) return false;
  if (code == KEY_1) return choose(NavigatorMode::fly);
  if (code == KEY_2) return choose(NavigatorMode::orbit);
  if (code == KEY_3) return choose(NavigatorMode::walk);
  if (code != KEY_HOME && code != KEY_0) return false;
  const bool all = code == KEY_0;
  place_ = all ? settings_.overview : settings_.start;
  speed_m_s_ = all ? settings_.overview_speed_m_s : settings_.speed_m_s;
  // A walker would be taken down to the ground there.
  choose(all && mode_ == NavigatorMode::walk ? NavigatorMode::fly : mode_);
  return true;
}

bool Navigator::handle_finger(const InputEvent& event) {
  if (event.id < 0 || event.id >= static_cast<int>(fingers_.size())) return false;
  Finger& finger = fingers_[static_cast<std::size_t>(event.id)];
  const Finger& other = fingers_[static_cast<std::size_t>(1 - event.id)];
  const Finger before = finger;
  finger = {event.kind == InputEvent::Kind::touch, event.x, event.y};
  if (!before.down || !finger.down) return false;
  const double right = finger.x - before.x;
  const double down = finger.y - before.y;
  if (!other.down) {
    turn(right * kScreen_deg, down * kScreen_deg);  // the ground follows the finger
    return true;
  }
  const auto apart = [&](const Finger& f) { return std::hypot(f.x - other.x, f.y - other.y); };
  const double reach = speed_m_s_ * kScreen_s;
  if (mode_ == NavigatorMode::orbit) {
    zoom((apart(before) - apart(finger)) * 10);
  } else {
    // Each finger does half of it. Spreading goes forward.
    move(-right * reach / 2, down * reach / 2, (apart(finger) - apart(before)) * reach);
    settle();
  }
  return true;
}

bool Navigator::moving() const {
  const auto any = [](const std::array<bool, kHeldCount>& keys) {
    return std::any_of(keys.begin(), keys.begin() + kFast, [](bool key) { return key; });
  };
  return mode_ != NavigatorMode::none && (any(held_) || any(tapped_));
}

bool Navigator::advance(double seconds) {
  if (!moving()) return false;
  seconds = std::clamp(seconds, kShortestStep_s, kLongestStep_s);
  std::array<bool, kHeldCount> keys = std::exchange(tapped_, {});
  for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = keys[i] || held_[i];
  const auto both = [&](Held plus, Held minus) {
    return double{keys[plus] ? 1.0 : 0.0} - (keys[minus] ? 1.0 : 0.0);
  };
  const double factor = (keys[kFast] ? 4.0 : 1.0) * (keys[kSlow] ? 0.25 : 1.0);
  const CameraPlace before = place_;
  double yaw = both(kTurnLeft, kTurnRight) * kTurnSpeed_deg_s * seconds;
  const double pitch = both(kTurnUp, kTurnDown) * kTurnSpeed_deg_s * seconds;
  if (mode_ == NavigatorMode::orbit) {
    yaw += both(kRight, kLeft) * kTurnSpeed_deg_s * seconds;
    zoom(both(kBack, kForward) * seconds * 4 * factor);
    turn(yaw, pitch);
  } else {
    turn(yaw, pitch);
    const double step = speed_m_s_ * factor * seconds;
    move(both(kRight, kLeft) * step, both(kUp, kDown) * step, both(kForward, kBack) * step);
    settle();
  }
  return place_.position_m != before.position_m || place_.yaw_deg != before.yaw_deg ||
         place_.pitch_deg != before.pitch_deg;
}

void Navigator::turn(double yaw_deg, double pitch_deg) {
  place_.yaw_deg = std::remainder(place_.yaw_deg + yaw_deg, 360.0);
  place_.pitch_deg = std::clamp(place_.pitch_deg + pitch_deg, -kMostPitch_deg, kMostPitch_deg);
  if (mode_ == NavigatorMode::orbit) orbit_to_place();
}

void Navigator::move(double right, double up, double forward) {
  const bool level = mode_ == NavigatorMode::walk;
  const Axes a = axes(place_.yaw_deg, level ? 0 : place_.pitch_deg);
  if (settings_.axes_at) {
    const glm::dmat3 here = settings_.axes_at(place_.position_m);
    const glm::dvec3 ahead = this->forward();
    place_.position_m +=
        here * (a.right * right + a.forward * forward + glm::dvec3(0.0, level ? 0.0 : up, 0.0));
    look_along(ahead);
    return;
  }
  place_.position_m += a.right * right + a.forward * forward;
  if (!level) place_.position_m.y += up;
}

void Navigator::zoom(double steps) {
  const double factor = std::pow(kWheelFactor, steps);
  if (mode_ == NavigatorMode::orbit) {
    distance_m_ = std::clamp(distance_m_ * factor, kLeastSpeed_m_s, 1e7);
    orbit_to_place();
  } else {
    speed_m_s_ = std::clamp(speed_m_s_ / factor, kLeastSpeed_m_s, kMostSpeed_m_s);
  }
}

void Navigator::orbit_to_place() {
  const glm::dvec3 ahead = forward();
  place_.position_m = target_m_ - ahead * distance_m_;
  if (settings_.axes_at) look_along(ahead);
}

bool Navigator::settle() {
  if (mode_ != NavigatorMode::walk || !settings_.ground_m) return false;
  const std::optional<double> ground = settings_.ground_m(place_.position_m);
  if (!ground) return false;
  const double height = *ground + settings_.eye_height_m;
  const bool moved = height != place_.position_m.y;
  if (settings_.axes_at) {
    place_.position_m += settings_.axes_at(place_.position_m)[1] * (height - place_.position_m.y);
  } else {
    place_.position_m.y = height;
  }
  return moved;
}

}  // namespace karst::app
