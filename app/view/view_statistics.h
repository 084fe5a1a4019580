// SPDX-License-Identifier: MIT
// What karst view did, as one JSON object (docs/formats.md, "Statistics"). Sizes are fixed: a kiosk runs for
// months.
#pragma once

#include <cstdint>
#include <string>

#include "app/motion/pose_stream.h"
#include "app/stage/stage.h"
#include "platform/display.h"

namespace karst::app {

class ViewStatistics {
 public:
  void add_frame(double draw_ms, double present_ms) {
    draw_ms_.add(draw_ms);
    present_ms_.add(present_ms);
  }
  std::uint64_t frames() const { return draw_ms_.count(); }
  // edit_ms: of frames that changed the world.
  std::string json(const Display& display, const Stage& stage, const PoseLines& poses,
                   const Series& edit_ms) const;

 private:
  Series draw_ms_;     // choosing, listing and submitting
  Series present_ms_;  // handing over to the screen
};

}  // namespace karst::app
