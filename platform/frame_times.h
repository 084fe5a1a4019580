// SPDX-License-Identifier: MIT
// How frames came to the screen: latencies, missed refreshes, recoveries. Keeps the last kKept values of
// each; never allocates.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace karst {

// The last values of a series.
class Series {
 public:
  static constexpr std::size_t kKept = 1024;  // a quarter of a minute at 60 Hz

  void add(double value) {
    values_[count_ % kKept] = value;
    ++count_;
    most_ = std::max(most_, value);
  }
  std::uint64_t count() const { return count_; }
  double most() const { return count_ > 0 ? most_ : std::numeric_limits<double>::quiet_NaN(); }
  // Of the values kept, nearest rank; NaN without values.
  double percentile(double part) const {
    std::array<double, kKept> sorted = values_;
    const std::size_t n = static_cast<std::size_t>(std::min<std::uint64_t>(count_, kKept));
    if (n == 0) return std::numeric_limits<double>::quiet_NaN();
    std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n));
    const auto rank = static_cast<std::size_t>(part * static_cast<double>(n) + 0.999999);
    return sorted[std::min(std::max<std::size_t>(rank, 1), n) - 1];
  }

 private:
  std::array<double, kKept> values_{};
  std::uint64_t count_ = 0;
  double most_ = 0;
};

class FrameTimes {
 public:
  // A frame is begun; the next that is queued is this one.
  void begin(std::int64_t now) { began_ = now; }
  void queued() { in_flight_ = began_; }
  // The queued frame is on the screen. refresh: 0 where not known. A frame that was begun right behind the
  // last one and appears more than one and a half refreshes after it has missed the refreshes between.
  void shown(std::int64_t at, std::int64_t refresh) {
    latency_ms_.add(static_cast<double>(at - in_flight_) * 1e-6);
    const bool in_a_row = last_shown_ != 0 && in_flight_ - last_shown_ < refresh;
    if (refresh > 0 && in_a_row && at - last_shown_ > refresh + refresh / 2) {
      missed_ += static_cast<std::uint64_t>((at - last_shown_ + refresh / 2) / refresh) - 1;
    }
    last_shown_ = at;
  }
  void flip_lost() { ++lost_; }
  // A picture is on the screen again, which could be used since then.
  void recovered(std::int64_t possible_since, std::int64_t now) {
    recovery_ms_.add(static_cast<double>(now - possible_since) * 1e-6);
  }
  void mode_set() { ++modes_set_; }

  const Series& latency_ms() const { return latency_ms_; }
  const Series& recovery_ms() const { return recovery_ms_; }  // from the screen being usable to a picture
  std::uint64_t missed() const { return missed_; }            // refreshes that showed an old frame
  std::uint64_t lost() const { return lost_; }                // flips whose end was not told within 100 ms
  std::uint64_t modes_set() const { return modes_set_; }

 private:
  Series latency_ms_;
  Series recovery_ms_;
  std::int64_t began_ = 0;
  std::int64_t in_flight_ = 0;
  std::int64_t last_shown_ = 0;
  std::uint64_t missed_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t modes_set_ = 0;
};

}  // namespace karst
