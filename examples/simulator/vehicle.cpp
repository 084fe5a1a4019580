// SPDX-License-Identifier: MIT
#include "vehicle.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>

namespace simulator {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::microseconds kStep{1000};
constexpr std::uint64_t kStepsBetweenPrepares = 250;
constexpr double kReady_m = 40;  // around the car, that is kept ready

constexpr double kSpeed = 8;          // metres a second
constexpr double kTurn = 0.2;         // radians a second
constexpr double kHalfBase_m = 1.4;   // from the middle to an axle
constexpr double kHalfTrack_m = 0.9;  // from the middle to a wheel's middle
constexpr double kRest_m = 0.35;      // length of a spring without load
constexpr double kStepUp_m = 0.5;     // what a wheel climbs
constexpr double kMass = 1200, kPitchInertia = 1800, kRollInertia = 700;  // kg, kg m^2
constexpr double kSpring = 45e3, kDamper = 4.5e3;                         // N / m, N s / m
constexpr double kGravity = 9.81;

double along(int wheel) {
  return wheel < 2 ? kHalfBase_m : -kHalfBase_m;
}
double across(int wheel) {
  return wheel % 2 == 0 ? kHalfTrack_m : -kHalfTrack_m;
}

}  // namespace

bool Car::start(karst::Query& query, int level, Vec3 place) {
  query_ = &query;
  level_ = level;
  karst::Hit top[1];
  if (query.column(place, karst::Wait::for_file, top) == 0) return false;
  x_ = top[0].place.x;
  y_ = top[0].place.y;
  z_ = top[0].place.z + kWheelRadius_m + kRest_m;
  publish();
  thread_ = std::thread([this] { run(); });
  return true;
}

CarReport Car::stop() {
  stopping_ = true;
  thread_.join();
  return report_;
}

CarState Car::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void Car::run() {
  Clock::time_point next = Clock::now();
  while (!stopping_) {
    if (report_.steps % kStepsBetweenPrepares == 0) {
      // May read the file, which costs one step more than the others now and then. Less than all is ready
      // where the plan has too few query_patches; then some answers are coarse, and are counted.
      [[maybe_unused]] const karst::Status status = query_->prepare({x_, y_, z_}, kReady_m);
    }
    const Clock::time_point start = Clock::now();
    step(std::chrono::duration<double>(kStep).count());
    const std::chrono::duration<double, std::micro> took = Clock::now() - start;
    report_.slowest_step_us = std::max(report_.slowest_step_us, took.count());
    publish();
    next += kStep;
    std::this_thread::sleep_until(next);
  }
}

// Four springs on the ground beneath the wheels carry a body that heaves, pitches and rolls.
void Car::step(double seconds) {
  ++report_.steps;
  heading_ += kTurn * seconds;
  x_ += kSpeed * std::cos(heading_) * seconds;
  y_ += kSpeed * std::sin(heading_) * seconds;

  double lift = -kMass * kGravity, pitch = 0, roll = 0;
  for (int wheel = 0; wheel < kWheels; ++wheel) {
    const double a = along(wheel), b = across(wheel);
    const Vec3 hub{x_ + a * std::cos(heading_) - b * std::sin(heading_),
                   y_ + a * std::sin(heading_) + b * std::cos(heading_),
                   z_ + a * std::sin(pitch_) + b * std::sin(roll_)};
    karst::Hit hit;
    double squeeze = 0;
    if (query_->ground(hub, kStepUp_m, karst::Wait::never, hit)) {
      squeeze = std::max(kRest_m + kWheelRadius_m - (hub.z - hit.place.z), 0.0);
      report_.coarse_answers += hit.level < level_ ? 1 : 0;
    }
    if (squeeze > 0) {
      ++report_.wheels_on_ground;
      const double speed = std::clamp((squeeze - squeeze_[wheel]) / seconds, -4.0, 4.0);
      const double force = std::max(kSpring * squeeze + kDamper * speed, 0.0);
      lift += force;
      pitch += force * a;
      roll += force * b;
    }
    squeeze_[wheel] = squeeze;
  }
  speed_up_ += lift / kMass * seconds;
  pitch_speed_ += pitch / kPitchInertia * seconds;
  roll_speed_ += roll / kRollInertia * seconds;
  z_ += speed_up_ * seconds;
  pitch_ = std::clamp(pitch_ + pitch_speed_ * seconds, -1.0, 1.0);
  roll_ = std::clamp(roll_ + roll_speed_ * seconds, -1.0, 1.0);
}

void Car::publish() {
  const Vec3 forwards{std::cos(heading_) * std::cos(pitch_), std::sin(heading_) * std::cos(pitch_),
                      std::sin(pitch_)};
  const Vec3 tilted{-std::sin(heading_) * std::cos(roll_), std::cos(heading_) * std::cos(roll_),
                    std::sin(roll_)};
  const Vec3 up = unit(cross(forwards, tilted));
  const Vec3 left = cross(up, forwards);
  CarState state;
  state.body = frame(forwards, left, up, {x_, y_, z_});
  for (int wheel = 0; wheel < kWheels; ++wheel) {
    const double spring = kRest_m - std::max(squeeze_[wheel], 0.0);
    state.wheels[wheel] = frame(
        forwards, left, up, Vec3{x_, y_, z_} + along(wheel) * forwards + across(wheel) * left + -spring * up);
  }
  const std::lock_guard lock(mutex_);
  state_ = state;
}

}  // namespace simulator
