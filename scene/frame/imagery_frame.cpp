// SPDX-License-Identifier: MIT
#include "scene/frame/imagery_frame.h"

#include <optional>

#include "scene/frame/vertex_work.h"
#include "terrain/view/projection.h"

namespace karst::core {
namespace {

// A frame that waits gives up after so many rounds of asking: more than it takes to fill all layers.
constexpr int kMostRounds = 4 * static_cast<int>(kMostImageLayers);

}  // namespace

void ImageryFrame::create(TerrainParts& terrain, Renderer& renderer, const Inspection& inspection) {
  terrain_ = &terrain;
  renderer_ = &renderer;
  inspection_ = &inspection;
}

// One at least, where one came.
Status ImageryFrame::take(double work_ms, bool all, std::uint32_t& came) {
  const std::int64_t start = clock_ns();
  came = 0;
  std::int32_t layer = 0;
  ImageArrival arrival;
  while ((all || came == 0 || ms_since(start) < work_ms) && terrain_->imagery.poll(layer, arrival)) {
    const Status status = renderer_->upload_image(static_cast<std::uint32_t>(layer), arrival.texels);
    if (!status.ok()) return status;
    ++came;
  }
  return {};
}

// As FrameBlock::view_scale has it.
double ImageryFrame::pixel(const ViewRequest& request) {
  return 2.0 / vertical_scale(*request.camera) / request.height_px;
}

void ImageryFrame::select(const GroundFrame& ground, std::span<const ViewRequest> requests,
                          std::span<const glm::dvec3> motions) {
  lacking_ = left_out_ = 0;
  for (std::size_t v = 0; v < requests.size(); ++v) {
    ImageRequest request;
    request.camera = requests[v].camera;
    request.pixel = pixel(requests[v]);
    std::optional<Forecast> forecast;
    if (!motions.empty() && motions[v] != glm::dvec3(0.0)) {
      request.forecast = &forecast.emplace(terrain_->ground.info(), ground.request(v),
                                           motions[v] * (kOfUse * terrain_->imagery.frames_to_come()));
    }
    terrain_->imagery.select(v, terrain_->ground.view(v), request);
    lacking_ += terrain_->imagery.view(v).result().lacking;
    left_out_ += terrain_->imagery.view(v).result().left_out;
  }
  terrain_->imagery.ask(motions.empty());
}

Status ImageryFrame::run(const GroundFrame& ground, std::span<const ViewRequest> requests,
                         std::span<const glm::dvec3> motions, double work_ms, bool wait, FrameCosts& costs) {
  lacking_ = left_out_ = 0;
  if (!exists()) return {};
  const std::int64_t start = clock_ns();
  Imagery& imagery = terrain_->imagery;
  {
    const OwnWork own(*inspection_);
    imagery.begin_frame();
    std::uint32_t came = 0;
    if (const Status status = take(work_ms, wait, came); !status.ok()) return status;
    select(ground, requests, motions);
    for (int round = 0; wait && lacking_ > 0 && round < kMostRounds && imagery.wait(); ++round) {
      if (const Status status = take(work_ms, true, came); !status.ok()) return status;
      // Nothing can be read, or finds room.
      if (came == 0 && imagery.counts().under_way == 0) break;
      select(ground, requests, motions);
    }
    for (std::size_t v = 0; v < requests.size(); ++v) {
      std::span<const std::uint16_t> part;
      for (int size; (size = imagery.take_size(v, part)) >= 0;) {
        const Status status = renderer_->upload_image_table(static_cast<std::uint32_t>(v), size, part);
        if (!status.ok()) return status;
      }
    }
  }
  costs.upload_ms += ms_since(start);
  return {};
}

}  // namespace karst::core
