// SPDX-License-Identifier: MIT
#include "terrain/blocks/isosurface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

// What eyes aim at grows by this where a choice finds no room, and falls by it where its pages would, being
// so many times more, take less than this share of a choice's.
constexpr float kScaleStep = 1.25f;
constexpr float kMostStep = 8;
constexpr int kScalePerLevelLog2 = 2;
constexpr float kMostScale = 1 << 20;
constexpr float kRoomy = 0.8f;

}  // namespace

Status Isosurface::create(const Config& config, Arena& arena) {
  if (const Status status = take_blocks(config, arena, blocks_); !status.ok()) return status;
  rim_.create(blocks_.rim);
  tree_.create(blocks_.tree);
  pool_.create(blocks_.pool);
  shown_ = {blocks_.blocks[0], blocks_.meshes[0], 0};
  wanted_ = {blocks_.blocks[1], blocks_.meshes[1], 0};
  return {};
}

void Isosurface::attach(const FieldBlocks& field, const FieldRegion& region) {
  field_ = &field;
  column_ = region.column;
  pool_.set_region(region.corner);
  forget();
  if (exists()) tree_.reset(field);
}

void Isosurface::forget() {
  pool_.reset();
  rim_.clear();
  shown_.count = wanted_.count = made_ = 0;
  error_scale_ = 1;
  lacks_room_ = false;
}

void Isosurface::change(glm::ivec3 low, glm::ivec3 high) {
  if (!exists()) return;
  tree_.refresh(*field_, low, high);
  pool_.outdate([&](BlockKey key) {
    // Gradients reach a sample beyond a block, and coarse cells as far as they are wide.
    const int cell = 1 << key.level;
    const glm::ivec3 first = key.place() * (kIsoCells * cell) - cell;
    const glm::ivec3 last = first + (kIsoCells + 2) * cell;
    for (int axis = 0; axis < 3; ++axis) {
      if (last[axis] < low[axis] || first[axis] > high[axis]) return false;
    }
    return true;
  });
  // What is drawn stays until all that changed is there: nothing of an edit is shown in parts.
  wanted_.count = made_ = 0;
  ++changes_;
}

void Isosurface::begin_frame() {
  if (!exists()) return;
  pool_.begin_frame();
  for (std::size_t n = 0; n < shown_.count; ++n) pool_.draw(shown_.meshes[n]);
  for (std::size_t n = 0; n < made_; ++n) pool_.ask(wanted_.meshes[n]);
}

void Isosurface::choose(std::span<const BlockEye> eyes) {
  if (!exists() || eyes.size() > eyes_.size()) return;
  std::copy(eyes.begin(), eyes.end(), eyes_.begin());
  eye_count_ = eyes.size();
  lacks_room_ = false;
  // Twice as fine takes four times as many.
  std::uint32_t pages = 0;
  for (std::size_t n = 0; n < shown_.count; ++n) pages += pages_for(pool_.mesh(shown_.meshes[n]).vertices);
  const auto used = static_cast<float>(pages);
  if (error_scale_ > 1 && used * kScaleStep * kScaleStep < kRoomy * static_cast<float>(pool_.page_count()))
    error_scale_ = std::max(1.0f, error_scale_ / kScaleStep);
  rechoose();
}

// Coarser until the list has room for all.
void Isosurface::rechoose() {
  for (std::size_t n = 0; n < made_; ++n) pool_.spare(wanted_.meshes[n]);
  for (std::size_t n = 0; n < shown_.count; ++n) pool_.ask(shown_.meshes[n]);
  made_ = made_pages_ = made_index_pages_ = 0;
  for (;;) {
    std::array<BlockEye, kMostViews> scaled = eyes_;
    for (BlockEye& eye : scaled) eye.steps_per_step = 1 + (eye.steps_per_step - 1) / error_scale_;
    const std::size_t most = wanted_.blocks.size() / 2;
    // What is next to an eye is the finest whatever that aims at.
    const int finest = std::min(std::ilogb(error_scale_) / kScalePerLevelLog2, tree_.levels() - 1);
    const std::size_t count = tree_.choose(std::span(scaled).first(eye_count_), finest, wanted_.blocks);
    wanted_.count = std::min(count, most);
    if (count <= most || !coarsen(kScaleStep)) return;
  }
}

// What was chosen is what is drawn from now on.
void Isosurface::show() {
  std::swap(shown_, wanted_);
  for (std::size_t n = 0; n < shown_.count; ++n) pool_.draw(shown_.meshes[n]);
  wanted_.count = made_ = 0;
  if (field_->info().in_region) rim_.build(pool_, shown_.meshes.first(shown_.count), field_->info(), column_);
}

bool Isosurface::coarsen(float factor) {
  if (error_scale_ >= kMostScale) return false;
  error_scale_ *= factor;
  return true;
}

// Of the memory that a choice may take, what the drawn one takes.
float Isosurface::used_share() const {
  std::uint32_t pages = 0, index_pages = 0;
  for (std::size_t n = 0; n < shown_.count; ++n) {
    const BlockPool::Mesh& mesh = pool_.mesh(shown_.meshes[n]);
    pages += pages_for(mesh.vertices);
    index_pages += index_pages_for(mesh.indices);
  }
  const auto share = [](std::uint32_t used, std::uint32_t all) {
    return 2 * static_cast<float>(used) / static_cast<float>(std::max(all, 1u));
  };
  return std::max(
      {share(pages, pool_.page_count()), share(index_pages, pool_.index_page_count()),
       share(static_cast<std::uint32_t>(shown_.count), static_cast<std::uint32_t>(wanted_.blocks.size()))});
}

// Where a choice takes more than its share: as much coarser as what is missing of it says.
bool Isosurface::give_way() {
  lacks_room_ = true;
  const float share = static_cast<float>(wanted_.count) / static_cast<float>(std::max<std::size_t>(made_, 1));
  if (!coarsen(std::clamp(std::sqrt(share), kScaleStep, kMostStep))) return false;
  rechoose();
  return true;
}

bool Isosurface::make_next(MeshUpload& upload, Status& status) {
  status = {};
  upload = {};
  while (made_ < wanted_.count) {
    std::uint32_t number = pool_.find(wanted_.blocks[made_]);
    const bool is_new = number == BlockPool::kNone;
    if (is_new) {
      status = pool_.make(*field_, wanted_.blocks[made_], number, upload);
      if (status.code() == StatusCode::limit_reached) {
        status = {};
        // In the next frames, or when the GPU is idle, what is kept back is free.
        lacks_room_ = true;
        if (pool_.has_kept() || !give_way()) return false;
        continue;
      }
      if (!status.ok()) return false;
    }
    const BlockPool::Mesh& mesh = pool_.mesh(number);
    made_pages_ += pages_for(mesh.vertices);
    made_index_pages_ += index_pages_for(mesh.indices);
    if (2 * made_pages_ > pool_.page_count() || 2 * made_index_pages_ > pool_.index_page_count()) {
      // Its vertices were copied nowhere.
      if (is_new) pool_.discard(number);
      if (!give_way()) return false;
      continue;
    }
    wanted_.meshes[made_++] = number;
    if (is_new && !upload.vertices.empty()) {
      if (is_complete()) show();
      return true;
    }
  }
  if (wanted_.count > 0) show();
  return false;
}

Isosurface::List Isosurface::list(std::size_t number, const Frustum* frustum) {
  List out;
  if (!exists()) return out;
  const std::span<MeshItem> items = blocks_.lists[number];
  std::size_t count = 0;
  std::uint32_t before = 0;
  out.hash = 0xcbf29ce484222325ull ^ changes_;
  for (std::size_t n = 0; n < shown_.count; ++n) {
    const BlockPool::Mesh& mesh = pool_.mesh(shown_.meshes[n]);
    if (mesh.indices == 0) continue;
    if (frustum != nullptr && classify(*frustum, tree_.box(mesh.block.block), kAllPlanes) == kOutside) {
      ++out.culled;
      continue;
    }
    MeshItem& item = items[count++];
    item = {mesh.first_page, mesh.first_index_page, mesh.indices, before};
    before += item.index_pages();
    out.triangles += mesh.indices / 3;
    // Its first page is no other mesh's while it is drawn.
    out.hash = (out.hash ^ (std::uint64_t{mesh.first_page} << 32 | mesh.indices)) * 0x100000001b3ull;
  }
  out.items = std::span<const MeshItem>(items).first(count);
  return out;
}

float Isosurface::bound_px(const LodEye& eye, float pixels) const {
  float most = 0;
  for (const ChosenBlock& block : drawn()) {
    const float error = tree_.block_error(block.block);
    if (error == 0) continue;
    const float left = tree_.least_apparent(block.block, eye) - error;
    most = std::max(most, left > 0 ? pixels * error / left : 1e9f);
  }
  return most;
}

}  // namespace karst::core
