// SPDX-License-Identifier: MIT
// A synthetic ground that is drawn: a world of it, whose tiles come from disks that a benchmark chooses.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "bench/frames/bench_view.h"
#include "bench/ground/synthetic_ground.h"
#include "terrain/paging/tile_source.h"

namespace karst::bench {

class SweepView {
 public:
  SweepView() = default;
  SweepView(const SweepView&) = delete;
  SweepView& operator=(const SweepView&) = delete;
  ~SweepView();

  // ground: borrowed. To be called once.
  Error open(const SyntheticGround& ground, const SceneArguments& look);
  // Forgets all tiles but the root's, and all vertices. source: borrowed until the next one.
  void take_tiles(const core::TileSource& source);

  // A camera above the ground, metres and degrees; places are told from the ground's middle.
  Error place(double east_m, double south_m, double above_m, double yaw_deg, double pitch_deg,
              ViewState& camera);
  // work_ms 0: the frame is complete, whatever it waits for. ahead: Inspection::read_ahead.
  Error draw(const ViewState& camera, double work_ms, BenchFrame& frame, bool ahead = true);
  // Pixels of the last picture that show no ground. Once a picture.
  Error count_open(std::uint64_t& pixels);

  Stage& stage() { return view_.stage(); }

 private:
  const SyntheticGround* ground_ = nullptr;
  int file_ = -1;                     // in memory
  std::unique_ptr<Display> display_;  // before view_, whose objects are in its context
  BenchView view_;
  std::vector<std::uint8_t> rgba_;
  std::vector<float> depth_;
};

}  // namespace karst::bench
