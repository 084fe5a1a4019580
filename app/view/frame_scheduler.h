// SPDX-License-Identifier: MIT
// When to draw: when something changed that the picture shows, no sooner than the screen can show it, and not
// at all otherwise. Knows no clock; times are handed in.
#pragma once

#include <algorithm>
#include <cstdint>

namespace karst::app {

class FrameScheduler {
 public:
  static constexpr std::int64_t kNever = INT64_MAX;

  // fixed: time in the world advances by step_ns a frame, however long that takes; else it follows the clock.
  struct Settings {
    bool fixed = false;
    std::int64_t step_ns = 16'666'667;  // 60 Hz
  };
  explicit FrameScheduler(const Settings& settings) : settings_(settings) {}

  // The next picture differs from the one that is shown.
  void changed() { changed_ = true; }
  // Everything moves by itself: a picture is due every refresh until this is taken back.
  void set_moving(bool moving) { moving_ = moving; }

  // Whether to draw. ready: the display takes a frame. refresh_ns: its time between two, 0: not known.
  bool due(std::int64_t now, bool ready, std::int64_t refresh_ns) const {
    return ready && (changed_ || moving_) && now >= next_at(refresh_ns);
  }
  // A frame is begun: what changes from here on is for the next one.
  void begin(std::int64_t now) {
    if (!started_) first_ = now;
    if (settings_.fixed) {
      if (started_) time_ns_ += settings_.step_ns;
    } else {
      time_ns_ = now - first_;
    }
    started_ = true;
    last_ = now;
    changed_ = false;
    ++frames_;
  }
  // Seconds of the world's time that the frame shows, 0 in the first.
  double time_s() const { return static_cast<double>(time_ns_) * 1e-9; }
  std::uint64_t frames() const { return frames_; }

  // How long to sleep: until then nothing is to be drawn unless something happens.
  std::int64_t wake_at(bool ready, std::int64_t refresh_ns) const {
    return ready && (changed_ || moving_) ? next_at(refresh_ns) : kNever;
  }

 private:
  // Drivers that tell flips at the refresh pace us themselves: ready turns true there. Some (virtual ones)
  // tell at once, hundreds of times a second. A tenth early leaves the first kind room for unsteady timers.
  std::int64_t next_at(std::int64_t refresh_ns) const {
    const std::int64_t interval = refresh_ns > 0 ? refresh_ns : settings_.step_ns;
    return started_ ? last_ + interval - interval / 10 : 0;
  }

  Settings settings_;
  bool changed_ = true;
  bool moving_ = false;
  bool started_ = false;
  std::int64_t first_ = 0;
  std::int64_t last_ = 0;
  std::int64_t time_ns_ = 0;
  std::uint64_t frames_ = 0;
};

}  // namespace karst::app
