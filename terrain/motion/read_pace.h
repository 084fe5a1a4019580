// SPDX-License-Identifier: MIT
// How long reads take, counted in frames: whether what is asked for now will still be of use when it comes,
// and how much to ask for at a time, so that what becomes urgent does not wait behind what no longer is.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace karst::core {

// Of what was asked for before it was lacking.
struct AheadCounts {
  std::uint64_t asked = 0;
  std::uint64_t used = 0;    // looked at afterwards
  std::uint64_t wasted = 0;  // gave way, or found no room, before anything looked at it
};

// What is asked for must still be of use after so many times what it takes to come.
inline constexpr double kOfUse = 1.5;

class ReadPace {
 public:
  void reset() { *this = {}; }
  void begin_frame() {
    // What was waited for within a frame tells nothing.
    if (answered_ > 0 && span_ > 0) {
      const double frames = static_cast<double>(span_) / answered_;
      frames_a_read_ = known_ ? frames_a_read_ + (frames - frames_a_read_) / 4 : frames;
      known_ = true;
    }
    answered_ = 0;
    ++frame_;
  }
  // One is asked for. under_way: before it.
  void ask(std::uint32_t under_way) {
    if (under_way == 0) since_ = frame_;
  }
  // One was answered.
  void answer() {
    if (answered_++ == 0) span_ = frame_ - since_;
    since_ = frame_;
  }

  // Until what is asked for now will come, behind so many that are under way.
  double frames_to_come(std::uint32_t under_way) const {
    const double in_hand = under_way == 0 ? 0.0 : static_cast<double>(frame_ - since_);
    return 1.0 + std::max(frames_a_read_, in_hand) * (under_way + 1.0);
  }
  // How many to have under way: about twice what comes in a frame, so that the reader never rests.
  std::uint32_t depth(std::uint32_t most) const {
    const double wanted = frames_a_read_ > 0 ? 2.0 + std::ceil(2.0 / frames_a_read_) : 4.0;
    return static_cast<std::uint32_t>(std::min(wanted, static_cast<double>(most)));
  }

 private:
  std::uint32_t frame_ = 0;
  std::uint32_t since_ = 0;     // the frame in which the one in hand was begun
  std::uint32_t answered_ = 0;  // in this frame
  std::uint32_t span_ = 0;      // frames that they took
  double frames_a_read_ = 0;
  bool known_ = false;
};

}  // namespace karst::core
