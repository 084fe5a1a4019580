// SPDX-License-Identifier: MIT
// A car with four sprung wheels, on a thread of its own at 1 kHz: what a simulator's physics asks of karst.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>

#include <karst/query.h>

#include "matrix.h"

namespace simulator {

inline constexpr int kWheels = 4;  // front left, front right, rear left, rear right
inline constexpr double kWheelRadius_m = 0.4;

// x of the body forwards, y to the left, z up; places in the simulator's frame.
struct CarState {
  Mat4 body{};
  Mat4 wheels[kWheels] = {};
};

struct CarReport {
  std::uint64_t steps = 0;
  std::uint64_t wheels_on_ground = 0;  // of all steps; kWheels a step where the car never jumps
  std::uint64_t coarse_answers = 0;    // the ground was not in memory: it was answered from a coarser surface
  double slowest_step_us = 0;
};

class Car {
 public:
  // Drives in circles from a place, where it is put down. query: the car's own until stop() has returned;
  // level: of the surface that it meets (Needs::query_level). False where there is no ground.
  [[nodiscard]] bool start(karst::Query& query, int level, Vec3 place);
  CarReport stop();

  CarState state() const;  // the newest, from any thread

 private:
  void run();
  void step(double seconds);
  void publish();

  karst::Query* query_ = nullptr;
  int level_ = 0;
  double x_ = 0, y_ = 0, z_ = 0, speed_up_ = 0;
  double heading_ = 0, pitch_ = 0, roll_ = 0, pitch_speed_ = 0, roll_speed_ = 0;  // radians
  double squeeze_[kWheels] = {};  // of the springs, metres; negative: stretched
  CarReport report_;

  std::atomic<bool> stopping_{false};
  std::thread thread_;
  mutable std::mutex mutex_;  // of state_
  CarState state_;
};

}  // namespace simulator
