// SPDX-License-Identifier: MIT
#include "scene/frame/vertex_work.h"

namespace karst::core {
namespace {

constexpr std::int64_t kRetry_ns = 250'000'000;  // from heights that could not be read to asking again

// Adds the time since `start` to `total` and starts anew.
void lap(std::int64_t& start, double& total) {
  const std::int64_t now = clock_ns();
  total += static_cast<double>(now - start) * 1e-6;
  start = now;
}

}  // namespace

bool VertexWork::rests() const {
  return tolerant_ && failing_ && clock_ns() < retry_at_ns_;
}

Status VertexWork::judge(const Status& status) {
  if (status.ok()) {
    failing_ = false;
    return {};
  }
  if (status.code() != StatusCode::io || !tolerant_) return status;
  failing_ = true;
  retry_at_ns_ = clock_ns() + kRetry_ns;
  return {};
}

Status VertexWork::make(double work_ms, bool ahead, FrameCosts& costs, std::uint32_t& made) {
  const std::int64_t start = clock_ns();
  std::int64_t at = start;
  PatchUpload next;
  Status status;
  if (rests()) return {};
  while (static_cast<double>(at - start) * 1e-6 < work_ms && generate_next(ahead, next, status)) {
    failing_ = false;
    lap(at, costs.generate_ms);
    status = upload(next);
    lap(at, costs.upload_ms);
    if (!status.ok()) return status;
    ++made;
    ++costs.generated;
  }
  lap(at, costs.generate_ms);
  return status.ok() ? status : judge(status);
}

bool VertexWork::generate_next(bool ahead, PatchUpload& next, Status& status) {
  const OwnWork own(*inspection_);
  return terrain_->residency.generate_next(ahead, next, status);
}

Status VertexWork::remake(std::uint32_t most, FrameCosts& costs) {
  const std::int64_t start = clock_ns();
  PatchUpload next;
  Status status;
  while (status.ok() && terrain_->residency.remake_next(next, status, most)) {
    status = upload(next);
    costs.generated += next.vertices.empty() ? 0u : 1u;
  }
  costs.generate_ms += ms_since(start);
  return status;
}

Status VertexWork::make_bases(FrameCosts& costs, std::uint32_t most) {
  const std::int64_t start = clock_ns();
  PatchUpload next;
  Status status;
  if (rests()) return {};
  while (status.ok() && terrain_->residency.generate_base(next, status, most)) {
    failing_ = false;
    status = upload(next);
    ++costs.generated;
  }
  costs.generate_ms += ms_since(start);
  return status.ok() ? status : judge(status);
}

Status VertexWork::upload_morph_rows(FrameCosts& costs) {
  std::int64_t at = clock_ns();
  for (MorphRows rows = terrain_->residency.take_morph_rows(); !rows.halves.empty();
       rows = terrain_->residency.take_morph_rows()) {
    if (const Status status = renderer_->upload_morph_rows(rows.first_row, rows.halves); !status.ok())
      return status;
    costs.morph_bytes += rows.halves.size_bytes();
  }
  lap(at, costs.upload_ms);
  return {};
}

}  // namespace karst::core
