// SPDX-License-Identifier: MIT
#include "scene/frame/ahead_frame.h"

#include <algorithm>
#include <cmath>

#include "scene/frame/vertex_work.h"
#include "terrain/imagery/look_ahead.h"
#include "terrain/view/projection.h"

namespace karst::core {
namespace {

// Looked ahead are twice the frames that a read takes, then twice as many again, and so on, as long as
// nothing is lacking and it is no more than this, or than four times what a read takes.
constexpr double kMostFrames = 128;
// After a look that found nothing.
constexpr std::uint32_t kRestFrames = 3;

}  // namespace

void AheadFrame::create(TerrainParts& terrain, const Inspection& inspection) {
  terrain_ = &terrain;
  inspection_ = &inspection;
  doublings_ = {};
  rests_ = 0;
  counted_ = {};
}

void AheadFrame::run(const GroundFrame& ground, std::span<const ViewRequest> requests,
                     std::span<const glm::dvec3> motions, FrameCosts& costs) {
  if (!ground.exists()) return;
  view_ = (view_ + 1) % requests.size();
  const glm::dvec3& motion = motions[view_];
  if (motion == glm::dvec3(0.0)) {
    doublings_[view_] = 0;
    return;
  }
  if (rests_ > 0) {
    --rests_;
    return;
  }
  TileCache& tiles = terrain_->ground.tiles();
  Imagery& imagery = terrain_->imagery;
  // One reader has them all, and what is lacking goes first.
  std::uint32_t room = tiles.room_ahead();
  if (tiles.counts().under_way > 0 || (imagery.exists() && imagery.counts().under_way > 0)) room /= 2;
  if (room == 0) return;
  const OwnWork own(*inspection_);
  const std::int64_t start = clock_ns();
  const double to_come = std::max(tiles.frames_to_come(), imagery.exists() ? imagery.frames_to_come() : 0.0);
  const double frames = std::ldexp(2 * to_come, static_cast<int>(doublings_[view_]));
  const ViewRequest& request = requests[view_];
  const Forecast forecast(terrain_->ground.info(), ground.request(view_), motion * frames);
  LookAhead look;
  look.forecast = &forecast;
  look.tiles = &tiles;
  look.parallel = request.camera->parallel;
  look.most_visits = static_cast<std::uint32_t>(terrain_->ground.view(view_).most_nodes());
  if (imagery.exists()) {
    look.images = &imagery.cache();
    look.imagery = imagery.info();
    look.pixel = ImageryFrame::pixel(request);
  }
  const LookAhead::Result result = look.run();
  const std::uint32_t asked = tiles.ask_ahead(room);
  if (imagery.exists()) imagery.cache().ask_ahead(room - std::min(room, asked));
  if (result.lacks_tile + result.lacks_image == 0) {
    const bool last = 2 * frames > std::max(kMostFrames, 4 * to_come);
    doublings_[view_] = last ? 0 : doublings_[view_] + 1;
    rests_ = kRestFrames;
  }
  costs.select_ms += ms_since(start);
}

void AheadFrame::count(FrameCosts& costs) {
  AheadCounts sum;
  const auto add = [&](const AheadCounts& part) {
    sum.asked += part.asked;
    sum.used += part.used;
    sum.wasted += part.wasted;
  };
  if (terrain_->ground.exists()) add(terrain_->ground.counts().ahead);
  if (terrain_->imagery.exists()) add(terrain_->imagery.counts().ahead);
  costs.ahead_asked += static_cast<std::uint32_t>(sum.asked - counted_.asked);
  costs.ahead_used += static_cast<std::uint32_t>(sum.used - counted_.used);
  costs.ahead_wasted += static_cast<std::uint32_t>(sum.wasted - counted_.wasted);
  counted_ = sum;
}

}  // namespace karst::core
