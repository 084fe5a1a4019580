// SPDX-License-Identifier: MIT
#include "scene/frame/imagery_frame.h"

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

void ImageryFrame::select(std::span<const ViewRequest> requests) {
  lacking_ = 0;
  for (std::size_t v = 0; v < requests.size(); ++v) {
    ImageRequest request;
    request.camera = requests[v].camera;
    // As FrameBlock::view_scale has it.
    request.pixel = 2.0 / vertical_scale(*request.camera) / requests[v].height_px;
    terrain_->imagery.select(v, terrain_->ground.view(v), request);
    lacking_ += terrain_->imagery.view(v).result().lacking;
  }
  terrain_->imagery.ask();
}

Status ImageryFrame::run(std::span<const ViewRequest> requests, double work_ms, bool wait,
                         FrameCosts& costs) {
  lacking_ = 0;
  if (!exists()) return {};
  const std::int64_t start = clock_ns();
  Imagery& imagery = terrain_->imagery;
  {
    const OwnWork own(*inspection_);
    imagery.begin_frame();
    std::uint32_t came = 0;
    if (const Status status = take(work_ms, wait, came); !status.ok()) return status;
    select(requests);
    for (int round = 0; wait && lacking_ > 0 && round < kMostRounds && imagery.wait(); ++round) {
      if (const Status status = take(work_ms, true, came); !status.ok()) return status;
      // Nothing can be read, or finds room.
      if (came == 0 && imagery.counts().under_way == 0) break;
      select(requests);
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
